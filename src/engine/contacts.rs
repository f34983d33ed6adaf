//! Every contact at one instant: overlap, relative motion, spring -> forces.

use super::contact_law::{Reaction, react};
use super::overlap::{Meeting, Overlap, books_contact, meet, nearest_on_face};
use super::pairs::{DiskPair, DiskPairDetail, FacePair, Pairs, Spring};
use super::vec2::SMALL_TURN;
use super::{BodyId, DiskId, FaceId, FacePart, PairLaw, Pose, Regime, Rotation, Scene, Twist, Vec2, Wrench};

/// Where the disks are, from the poses of their bodies.
#[derive(Debug, Clone, Default)]
pub(super) struct Placement {
    /// Of each body.
    turn: Vec<Rotation>,
    /// \[m\] from the centre of mass to the disk's centre.
    pub arm: Vec<Vec2>,
    /// \[m\] the disk's centre.
    pub centre: Vec<Vec2>,
}

impl Placement {
    pub fn new(scene: &Scene) -> Placement {
        let (bodies, disks) = (scene.bodies.len(), scene.disks.len());
        Placement {
            turn: vec![Rotation::NONE; bodies],
            arm: vec![Vec2::ZERO; disks],
            centre: vec![Vec2::ZERO; disks],
        }
    }

    /// Puts a body's disks where its pose says.
    #[inline]
    pub fn place(&mut self, scene: &Scene, body: usize, pose: Pose) {
        self.turn[body] = Rotation::by(pose.orientation);
        self.put_disks(scene, body, pose.position);
    }

    /// Puts a body's disks where its pose says, which has turned by an angle \[rad\] since they were put.
    ///
    /// Turning the last sine and cosine is cheaper than new ones; rounding adds up over a communication
    /// step (1e-14 after 10 000 steps), at whose ends bodies are placed anew.
    #[inline]
    pub fn follow(&mut self, scene: &Scene, body: usize, pose: Pose, turned: f64) {
        if turned.abs() > SMALL_TURN {
            return self.place(scene, body, pose);
        }
        self.turn[body] = self.turn[body].further(turned);
        self.put_disks(scene, body, pose.position);
    }

    #[inline]
    fn put_disks(&mut self, scene: &Scene, body: usize, position: Vec2) {
        let turn = self.turn[body];
        let range = scene.bodies[body].disks.clone();
        let disks = scene.offsets[range.clone()].iter();
        let places = self.arm[range.clone()].iter_mut().zip(&mut self.centre[range]);
        for (offset, (arm, centre)) in disks.zip(places) {
            *arm = offset.rotated(turn);
            *centre = position + *arm;
        }
    }
}

/// What an evaluation does to the springs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Stretch {
    /// Takes them as they are.
    Hold,
    /// Lets each advance once, over the mechanical step \[s\].
    Over(f64),
}

/// Work done, for tests and benchmarks: counts, never times.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Work {
    /// Mechanical steps.
    pub steps: u64,
    /// Pairs looked at.
    pub pairs: u64,
    /// Pairs found touching.
    pub contacts: u64,
    /// Contacts found sliding.
    pub sliding: u64,
    /// Pairs whose centres coincided: no normal, no force.
    pub coincident: u64,
    /// Neighbour lists made.
    pub rebuilds: u64,
    /// Bodies moved by the closed form over a whole communication step.
    pub shortlisted: u64,
}

/// A touching pair.
struct Touch {
    overlap: Overlap,
    part: FacePart,
    /// \[m\] from the receiver's centre of mass to the contact point.
    arm: Vec2,
    /// \[m\] from the other's centre of mass to the contact point.
    other_arm: Vec2,
    normal_speed: f64,
    slip_speed: f64,
    /// \[m\] of the spring, before the slider may give way.
    elongation: f64,
    reaction: Reaction,
}

enum Finding {
    Apart,
    Coincident,
    Touching(Touch),
}

/// The instant at which contacts are looked at.
pub(super) struct Instant<'a> {
    pub scene: &'a Scene,
    pub placement: &'a Placement,
    /// Of the same instant as the placement.
    pub twists: &'a [Twist],
}

impl Instant<'_> {
    /// \[m/s\] of the body's point at an arm from its centre of mass.
    #[inline]
    fn velocity_at(&self, body: BodyId, arm: Vec2) -> Vec2 {
        let twist = &self.twists[body.index()];
        twist.velocity + arm.perp() * twist.angular_velocity
    }

    #[inline(always)]
    fn disks(&self, pair: &DiskPair, detail: &DiskPairDetail, memory: Memory) -> Finding {
        let (i, j) = (pair.first.index(), pair.second.index());
        let overlap = match meet(self.placement.centre[i] - self.placement.centre[j], pair.reach) {
            Meeting::Apart => return Finding::Apart,
            Meeting::Coincident => return Finding::Coincident,
            Meeting::Touching(overlap) => overlap,
        };
        let arm = self.placement.arm[i] + overlap.contact_point(detail.first_radius);
        let other_arm = self.placement.arm[j] - overlap.contact_point(detail.second_radius);
        let velocity =
            self.velocity_at(detail.first_body, arm) - self.velocity_at(detail.second_body, other_arm);
        let law = self.scene.law_at(detail.law);
        Finding::Touching(touch(law, overlap, FacePart::Inside, arm, other_arm, velocity, memory))
    }

    #[inline]
    fn face(&self, pair: &FacePair, memory: Memory) -> Finding {
        let (i, face) = (pair.disk.index(), pair.face.index());
        let (disk, wall) = (&self.scene.disks[i], &self.scene.faces[face]);
        let centre = self.placement.centre[i];
        let (nearest, part) = nearest_on_face(wall, centre);
        let meeting = meet(centre - nearest, disk.radius);
        if meeting == Meeting::Apart || !books_contact(self.scene, face, nearest, part, centre) {
            return Finding::Apart;
        }
        let Meeting::Touching(overlap) = meeting else { return Finding::Coincident };
        let arm = self.placement.arm[i] + overlap.contact_point(disk.radius);
        let velocity = self.velocity_at(disk.body, arm);
        let law = self.scene.law(disk.material, wall.material);
        Finding::Touching(touch(law, overlap, part, arm, Vec2::ZERO, velocity, memory))
    }

    /// Sums the contact wrenches on every body and lets the springs advance as `stretch` says.
    ///
    /// Each force is computed once and given to the two bodies with opposite signs: Newton's third law
    /// to the last bit.
    pub fn evaluate(&self, pairs: &mut Pairs, stretch: Stretch, wrenches: &mut [Wrench], work: &mut Work) {
        work.pairs += (pairs.disks.len() + pairs.faces.len()) as u64;
        let (before, now) = pairs.next_evaluation();
        self.find_overlapping(pairs);
        for &k in &pairs.overlapping {
            let k = k as usize;
            let (pair, detail) = (&pairs.disks[k], &pairs.disk_details[k]);
            let spring = &mut pairs.disk_springs[k];
            let finding = self.disks(pair, detail, Memory { spring, before, stretch });
            let Some(touch) = settle(finding, spring, now, stretch, work) else { continue };
            let force = touch.force();
            let receiver = &mut wrenches[detail.first_body.index()];
            receiver.force += force;
            receiver.torque += touch.arm.cross(force);
            let giver = &mut wrenches[detail.second_body.index()];
            giver.force -= force;
            giver.torque -= touch.other_arm.cross(force);
        }
        for (pair, spring) in pairs.faces.iter().zip(&mut pairs.face_springs) {
            let finding = self.face(pair, Memory { spring, before, stretch });
            let Some(touch) = settle(finding, spring, now, stretch, work) else { continue };
            let force = touch.force();
            let receiver = &mut wrenches[self.scene.body_of(pair.disk).index()];
            receiver.force += force;
            receiver.torque += touch.arm.cross(force);
        }
    }

    /// Finds the disk pairs that overlap. Without a branch: which pairs touch cannot be guessed.
    fn find_overlapping(&self, pairs: &mut Pairs) {
        let centre = &self.placement.centre[..];
        pairs.overlapping.resize(pairs.disks.len(), 0);
        let mut found = 0;
        for (pair, k) in pairs.disks.iter().zip(0..) {
            let between = centre[pair.first.index()] - centre[pair.second.index()];
            pairs.overlapping[found] = k;
            found += usize::from(between.norm_squared() < pair.reach * pair.reach);
        }
        pairs.overlapping.truncate(found);
    }

    /// The contacts as they are now; changes nothing.
    pub fn report(&self, pairs: &Pairs) -> ContactReport {
        let mut report = ContactReport::empty(self.scene.bodies.len());
        let mut touching_bodies = Vec::new();
        let memory = |spring| Memory { spring, before: pairs.evaluation, stretch: Stretch::Hold };
        let disks = pairs.disks.iter().zip(&pairs.disk_details).zip(&pairs.disk_springs);
        for ((pair, detail), spring) in disks {
            if let Finding::Touching(touch) = self.disks(pair, detail, memory(spring)) {
                let bodies = [detail.first_body, detail.second_body];
                touching_bodies.push(bodies);
                for body in bodies {
                    report.bodies[body.index()].agent_contacts += 1;
                    report.bodies[body.index()].squeeze += touch.reaction.normal.abs();
                }
                report.agent_contacts += 1;
                report.add(Pair::Disks { first: pair.first, second: pair.second }, &touch);
            }
        }
        for (&pair, spring) in pairs.faces.iter().zip(&pairs.face_springs) {
            if let Finding::Touching(touch) = self.face(&pair, memory(spring)) {
                let FacePair { disk, face } = pair;
                let body = &mut report.bodies[self.scene.body_of(disk).index()];
                body.wall_contacts += 1;
                body.squeeze += touch.reaction.normal.abs();
                report.wall_contacts += 1;
                report.add(Pair::Face { disk, face, part: touch.part }, &touch);
            }
        }
        touching_bodies.sort_unstable();
        touching_bodies.dedup();
        for bodies in touching_bodies {
            for body in bodies {
                report.bodies[body.index()].touching_bodies += 1;
            }
        }
        report
    }
}

impl Touch {
    /// \[N\] on the receiver.
    #[inline]
    fn force(&self) -> Vec2 {
        let normal = self.overlap.normal;
        normal * self.reaction.normal + normal.perp() * self.reaction.tangential
    }
}

/// What a pair remembers, and what becomes of it.
#[derive(Clone, Copy)]
struct Memory<'a> {
    spring: &'a Spring,
    /// The evaluation before this one.
    before: u64,
    stretch: Stretch,
}

/// The law at a contact; `velocity` \[m/s\] of the receiver relative to the other at the contact point.
#[inline(always)]
fn touch(
    law: &PairLaw,
    overlap: Overlap,
    part: FacePart,
    arm: Vec2,
    other_arm: Vec2,
    velocity: Vec2,
    memory: Memory,
) -> Touch {
    let normal_speed = velocity.dot(overlap.normal);
    let slip_speed = velocity.dot(overlap.normal.perp());
    let Memory { spring, before, stretch } = memory;
    let touched = spring.touched_at == before;
    let elongation = match stretch {
        Stretch::Hold if touched && spring.part == part => spring.elongation,
        // The trapezoid of ds/dt = v_t keeps the second order of the integrator.
        Stretch::Over(dt) if touched && spring.part == part => {
            spring.elongation + 0.5 * dt * (spring.slip_speed + slip_speed)
        }
        // First touch was within this step, when the depth was zero: the spring has stretched since then.
        Stretch::Over(dt) if !touched => slip_speed * touching_for(overlap.depth, normal_speed, dt),
        // Passing to another part of a wall begins another contact.
        _ => 0.0,
    };
    let reaction = react(law, overlap.depth, normal_speed, slip_speed, elongation);
    Touch { overlap, part, arm, other_arm, normal_speed, slip_speed, elongation, reaction }
}

/// \[s\] how much of a step a contact has lasted that was not there before it.
#[inline]
fn touching_for(depth: f64, normal_speed: f64, dt: f64) -> f64 {
    if -normal_speed * dt > depth { depth / -normal_speed } else { dt }
}

/// Writes what the evaluation `now` has found into the pair's spring.
#[inline(always)]
fn settle(
    finding: Finding,
    spring: &mut Spring,
    now: u64,
    stretch: Stretch,
    work: &mut Work,
) -> Option<Touch> {
    match finding {
        Finding::Apart => None,
        Finding::Coincident => {
            work.coincident += 1;
            None
        }
        Finding::Touching(touch) => {
            work.contacts += 1;
            work.sliding += u64::from(touch.reaction.regime == Regime::Sliding);
            let elongation = match stretch {
                Stretch::Hold => touch.elongation,
                Stretch::Over(_) => touch.reaction.elongation,
            };
            let (slip_speed, part) = (touch.slip_speed, touch.part);
            *spring = Spring { elongation, slip_speed, part, touched_at: now };
            Some(touch)
        }
    }
}

/// Who touches whom.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Pair {
    /// Two disks of different bodies.
    Disks {
        /// The receiver, of the lower-numbered body.
        first: DiskId,
        /// The other.
        second: DiskId,
    },
    /// A disk and a face.
    Face {
        /// The receiver.
        disk: DiskId,
        /// The face.
        face: FaceId,
        /// Where on the face.
        part: FacePart,
    },
}

/// One contact, with the forces on the receiver.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Contact {
    /// Who touches whom.
    pub pair: Pair,
    /// \[m\] overlap h.
    pub depth: f64,
    /// Towards the receiver.
    pub normal: Vec2,
    /// \[N\] along the normal; negative where it pulls.
    pub normal_force: f64,
    /// \[N\] along the tangent `normal.perp()`.
    pub tangential_force: f64,
    /// \[m\] of the tangential spring, along the tangent.
    pub elongation: f64,
    /// \[m/s\] of the receiver relative to the other, along the normal; positive where they part.
    pub normal_speed: f64,
    /// \[m/s\] of the receiver relative to the other, along the tangent.
    pub slip_speed: f64,
    /// Whether the slider holds.
    pub regime: Regime,
}

/// What the contacts do to one body.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct BodyContacts {
    /// Disk–disk contacts.
    pub agent_contacts: u32,
    /// Disk–face contacts.
    pub wall_contacts: u32,
    /// Different bodies that touch this one.
    pub touching_bodies: u32,
    /// \[N\] sum of |F_n| over its contacts.
    pub squeeze: f64,
}

/// Every contact at one instant.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ContactReport {
    /// Disk pairs ascending, then disk–face pairs ascending.
    pub contacts: Vec<Contact>,
    /// One for each body.
    pub bodies: Vec<BodyContacts>,
    /// Disk–disk contacts, each pair once.
    pub agent_contacts: u32,
    /// Disk–face contacts.
    pub wall_contacts: u32,
}

impl ContactReport {
    fn empty(bodies: usize) -> ContactReport {
        ContactReport { bodies: vec![BodyContacts::default(); bodies], ..ContactReport::default() }
    }

    fn add(&mut self, pair: Pair, touch: &Touch) {
        self.contacts.push(Contact {
            pair,
            depth: touch.overlap.depth,
            normal: touch.overlap.normal,
            normal_force: touch.reaction.normal,
            tangential_force: touch.reaction.tangential,
            elongation: touch.elongation,
            normal_speed: touch.normal_speed,
            slip_speed: touch.slip_speed,
            regime: touch.reaction.regime,
        });
    }

    /// A body on which a force is no finite number, if there is one.
    pub(super) fn not_finite(&self, scene: &Scene) -> Option<BodyId> {
        let finite =
            |contact: &&Contact| contact.normal_force.is_finite() && contact.tangential_force.is_finite();
        let contact = self.contacts.iter().find(|contact| !finite(contact));
        let receiver = contact.map(|contact| match contact.pair {
            Pair::Disks { first, .. } => scene.body_of(first),
            Pair::Face { disk, .. } => scene.body_of(disk),
        });
        receiver.or_else(|| self.bodies.iter().position(|body| !body.squeeze.is_finite()).map(BodyId::from))
    }

    /// \[m\] the deepest overlap; zero without contacts.
    pub fn largest_overlap(&self) -> f64 {
        self.contacts.iter().map(|contact| contact.depth).fold(0.0, f64::max)
    }
}
