//! Every contact at one instant: overlap, relative motion, spring -> forces.

use super::contact_law::{Reaction, react};
use super::overlap::{Meeting, Overlap, books_contact, meet, meet_face, nearest_on_face};
use super::pairs::{DiskPair, DiskPairDetail, FacePair, Pairs, Spring, spring_at_face};
use super::vec2::SMALL_TURN;
use super::{BodyId, DiskId, FaceId, FacePart, PairLaw, Pose, Regime, Rotation, Scene, Twist, Vec2, Wrench};

/// Where a body stands and how it moves at one instant: all that a look at its contacts needs of it, in one
/// cache line.
#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
pub(super) struct Standing {
    /// \[m\] of the centre of mass.
    position: Vec2,
    /// \[rad\]
    orientation: f64,
    /// By the orientation.
    turn: Rotation,
    /// Of the same instant.
    twist: Twist,
}

impl Default for Standing {
    fn default() -> Standing {
        Standing::at(Pose::default(), Twist::default())
    }
}

impl Standing {
    /// Where a pose says.
    pub fn at(pose: Pose, twist: Twist) -> Standing {
        let Pose { position, orientation } = pose;
        Standing { position, orientation, turn: Rotation::by(orientation), twist }
    }

    #[inline]
    pub fn pose(&self) -> Pose {
        Pose { position: self.position, orientation: self.orientation }
    }

    /// Goes on to a pose, turned by an angle \[rad\] since the last one.
    ///
    /// Turning the last sine and cosine is cheaper than new ones; rounding adds up over a communication
    /// step (1e-14 after 10 000 steps), at whose ends bodies are placed anew.
    #[inline(always)]
    pub fn follow(&mut self, pose: Pose, turned: f64, twist: Twist) {
        if turned.abs() > SMALL_TURN {
            self.turn_to(pose.orientation);
        } else {
            self.turn = self.turn.further(turned);
        }
        (self.position, self.orientation, self.twist) = (pose.position, pose.orientation, twist);
    }

    #[cold]
    #[inline(never)]
    fn turn_to(&mut self, orientation: f64) {
        self.turn = Rotation::by(orientation);
    }

    /// \[m\] from the centre of mass to the centre of a disk, given its [`super::Disk::offset`].
    #[inline]
    fn arm(&self, offset: Vec2) -> Vec2 {
        offset.rotated(self.turn)
    }

    /// \[m\] the centre of a disk, given its [`super::Disk::offset`].
    #[inline]
    pub fn centre(&self, offset: Vec2) -> Vec2 {
        self.position + self.arm(offset)
    }

    /// \[m/s\] of the body's point at an arm from its centre of mass.
    #[inline]
    fn velocity_at(&self, arm: Vec2) -> Vec2 {
        self.twist.velocity + arm.perp() * self.twist.angular_velocity
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
    /// Lists of candidates made.
    pub rebuilds: u64,
    /// Lists of near pairs taken out of the candidates.
    pub refreshes: u64,
    /// Candidates looked at for that.
    pub candidates: u64,
    /// Bodies moved by the closed form over a whole communication step.
    pub shortlisted: u64,
}

impl std::iter::Sum for Work {
    fn sum<I: Iterator<Item = Work>>(works: I) -> Work {
        works.fold(Work::default(), |sum, work| Work {
            steps: sum.steps + work.steps,
            pairs: sum.pairs + work.pairs,
            contacts: sum.contacts + work.contacts,
            sliding: sum.sliding + work.sliding,
            coincident: sum.coincident + work.coincident,
            rebuilds: sum.rebuilds + work.rebuilds,
            refreshes: sum.refreshes + work.refreshes,
            candidates: sum.candidates + work.candidates,
            shortlisted: sum.shortlisted + work.shortlisted,
        })
    }
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
    Coincident {
        /// \[m\] overlap h.
        depth: f64,
        part: FacePart,
    },
    Touching(Touch),
}

/// Two disks, seen from each other.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Sight {
    /// \[m\] from the other's centre to the receiver's.
    between: Vec2,
    /// \[m\] from the receiver's centre of mass to its disk's centre.
    arm: Vec2,
    /// \[m\] from the other's centre of mass to its disk's centre.
    other_arm: Vec2,
}

/// Pairs that are looked at together: what is found of them stays in the nearest cache.
const AT_ONCE: usize = 32;

/// What the contacts at one instant do to a body, added up.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Load {
    pub wrench: Wrench,
    /// \[N\] sum of |F_n|.
    pub squeeze: f64,
    /// \[m\] the deepest overlap.
    pub depth: f64,
}

impl Load {
    #[inline(always)]
    pub fn add(&mut self, other: &Load) {
        self.wrench.force += other.wrench.force;
        self.wrench.torque += other.wrench.torque;
        self.squeeze += other.squeeze;
        self.depth = if other.depth > self.depth { other.depth } else { self.depth };
    }
}

/// What a contact does to a body of another block.
#[derive(Debug, Clone, Copy)]
pub(super) struct Crossing {
    pub body: BodyId,
    pub load: Load,
}

/// What an evaluation adds up, for the bodies of a block.
pub(super) struct Sums<'a> {
    /// The first body of the block.
    pub start: usize,
    /// Of the bodies of the block.
    pub loads: &'a mut [Load],
    /// For bodies of later blocks.
    pub outgoing: &'a mut Vec<Crossing>,
    pub work: &'a mut Work,
}

impl Sums<'_> {
    /// Each force is computed once and given to the two bodies with opposite signs: Newton's third law to the
    /// last bit.
    #[inline(always)]
    fn add(&mut self, receiver: BodyId, giver: Option<BodyId>, touch: &Touch) {
        let (force, squeeze, depth) = (touch.force(), touch.reaction.normal.abs(), touch.overlap.depth);
        let wrench = Wrench { force, torque: touch.arm.cross(force) };
        self.loads[receiver.index() - self.start].add(&Load { wrench, squeeze, depth });
        let Some(giver) = giver else { return };
        let wrench = Wrench { force: -force, torque: -touch.other_arm.cross(force) };
        self.give(giver, Load { wrench, squeeze, depth });
    }

    #[inline(always)]
    fn give(&mut self, body: BodyId, load: Load) {
        match self.loads.get_mut(body.index() - self.start) {
            Some(sum) => sum.add(&load),
            None => self.outgoing.push(Crossing { body, load }),
        }
    }

    /// Disks that overlap without a normal: no force acts between them.
    #[cold]
    fn add_coincident(&mut self, receiver: BodyId, giver: Option<BodyId>, depth: f64) {
        self.work.coincident += 1;
        for body in [Some(receiver), giver].into_iter().flatten() {
            self.give(body, Load { depth, ..Load::default() });
        }
    }
}

/// The instant at which contacts are looked at.
pub(super) struct Instant<'a> {
    pub scene: &'a Scene,
    /// Of each body.
    pub standing: &'a [Standing],
    /// How many times contacts have been looked at before.
    pub before: u64,
}

impl Instant<'_> {
    /// What two disks look like from each other.
    #[inline(always)]
    fn sight(&self, pair: &DiskPair) -> Sight {
        let (i, j) = (&self.standing[pair.first_body.index()], &self.standing[pair.second_body.index()]);
        let (arm, other_arm) = (i.arm(pair.first_offset), j.arm(pair.second_offset));
        Sight { between: (i.position + arm) - (j.position + other_arm), arm, other_arm }
    }

    #[inline(always)]
    fn disks(&self, pair: &DiskPair, detail: &DiskPairDetail, sight: &Sight, memory: Memory) -> Finding {
        let overlap = match meet(sight.between, pair.reach) {
            Meeting::Apart => return Finding::Apart,
            Meeting::Coincident => {
                return Finding::Coincident { depth: pair.reach, part: FacePart::Left };
            }
            Meeting::Touching(overlap) => overlap,
        };
        let (i, j) = (&self.standing[pair.first_body.index()], &self.standing[pair.second_body.index()]);
        let arm = sight.arm + overlap.contact_point(detail.first_radius);
        let other_arm = sight.other_arm - overlap.contact_point(detail.second_radius);
        let velocity = i.velocity_at(arm) - j.velocity_at(other_arm);
        let law = self.scene.law_at(detail.law);
        Finding::Touching(touch(law, overlap, FacePart::Left, arm, other_arm, velocity, memory))
    }

    /// A disk and a face; `memory` of the part of the face that is touched.
    #[inline]
    fn face<'a>(&self, pair: &FacePair, memory: impl FnOnce(FacePart) -> Memory<'a>) -> Finding {
        let (disk, face) = (&self.scene.disks[pair.disk.index()], pair.face.index());
        let (wall, standing) = (&self.scene.faces[face], &self.standing[disk.body.index()]);
        let arm = standing.arm(disk.offset);
        let centre = standing.position + arm;
        let nearest = nearest_on_face(wall, centre);
        let apart = (centre - nearest.0).norm_squared() >= disk.radius * disk.radius;
        if apart || !books_contact(self.scene, face, nearest, centre) {
            return Finding::Apart;
        }
        let (meeting, part) = meet_face(wall, nearest, centre, disk.radius, standing.position);
        let overlap = match meeting {
            Meeting::Apart => return Finding::Apart,
            Meeting::Coincident => return Finding::Coincident { depth: disk.radius, part },
            Meeting::Touching(overlap) => overlap,
        };
        let arm = arm + overlap.contact_point(disk.radius);
        let law = self.scene.law(disk.material, wall.material);
        let velocity = standing.velocity_at(arm);
        Finding::Touching(touch(law, overlap, part, arm, Vec2::ZERO, velocity, memory(part)))
    }

    /// Sums the contact wrenches of a block's pairs and lets their springs advance as `stretch` says.
    pub fn evaluate(&self, pairs: &mut Pairs, stretch: Stretch, sums: &mut Sums) {
        let before = self.before;
        let now = before + 1;
        sums.work.pairs += (pairs.disks.len() + pairs.faces.len()) as u64;
        pairs.overlapping.resize(AT_ONCE, (0, Sight::default()));
        for start in (0..pairs.disks.len()).step_by(AT_ONCE) {
            for (k, sight) in self.find_overlapping(&pairs.disks, start, &mut pairs.overlapping) {
                let (pair, detail) = (&pairs.disks[*k], &pairs.disk_details[*k]);
                let spring = &mut pairs.disk_springs[*k];
                let finding = self.disks(pair, detail, sight, Memory { spring, before, stretch });
                settle(finding, spring, now, stretch, pair.first_body, Some(pair.second_body), sums);
            }
        }
        let Pairs { faces, face_springs, .. } = pairs;
        for (k, pair) in faces.iter().enumerate() {
            let memory = |part| {
                let spring = spring_at_face(self.scene, faces, face_springs, k, part, before);
                Memory { spring, before, stretch }
            };
            let finding = self.face(pair, memory);
            settle(finding, &mut face_springs[k], now, stretch, self.scene.body_of(pair.disk), None, sums);
        }
    }

    /// Finds those of the next [`AT_ONCE`] pairs that overlap, with their places. Without a branch: which pairs
    /// touch cannot be guessed.
    #[inline(always)]
    fn find_overlapping<'a>(
        &self,
        pairs: &[DiskPair],
        start: usize,
        overlapping: &'a mut [(usize, Sight)],
    ) -> &'a [(usize, Sight)] {
        let mut found = 0;
        for (k, pair) in pairs.iter().enumerate().skip(start).take(AT_ONCE) {
            let sight = self.sight(pair);
            overlapping[found] = (k, sight);
            found += usize::from(sight.between.norm_squared() < pair.reach * pair.reach);
        }
        &overlapping[..found]
    }

    /// The contacts of all blocks as they are now; changes nothing.
    pub fn report<'a>(&self, blocks: impl Iterator<Item = &'a Pairs> + Clone) -> ContactReport {
        let mut report = ContactReport::empty(self.scene.bodies.len());
        let mut touching_bodies = Vec::new();
        let memory = |spring| Memory { spring, before: self.before, stretch: Stretch::Hold };
        let disks = |pairs: &'a Pairs| pairs.disks.iter().zip(&pairs.disk_details).zip(&pairs.disk_springs);
        for ((pair, detail), spring) in blocks.clone().flat_map(disks) {
            let who = Pair::Disks { first: detail.first, second: detail.second };
            let squeeze = match self.disks(pair, detail, &self.sight(pair), memory(spring)) {
                Finding::Apart => continue,
                Finding::Coincident { depth, .. } => report.add_coincident(who, depth),
                Finding::Touching(touch) => report.add(who, &touch),
            };
            let bodies = [pair.first_body, pair.second_body];
            touching_bodies.push(bodies);
            for body in bodies {
                report.bodies[body.index()].agent_contacts += 1;
                report.bodies[body.index()].squeeze += squeeze;
            }
            report.agent_contacts += 1;
        }
        let faces = |pairs: &'a Pairs| (0..pairs.faces.len()).map(move |k| (pairs, k));
        for (pairs, k) in blocks.flat_map(faces) {
            let Pairs { faces, face_springs, .. } = pairs;
            let FacePair { disk, face } = faces[k];
            let who = |part| Pair::Face { disk, face, part };
            // Placed anew, the bodies may be seen from the next face of a straight wall.
            let held = |part| memory(spring_at_face(self.scene, faces, face_springs, k, part, self.before));
            let squeeze = match self.face(&faces[k], held) {
                Finding::Apart => continue,
                Finding::Coincident { depth, part } => report.add_coincident(who(part), depth),
                Finding::Touching(touch) => report.add(who(touch.part), &touch),
            };
            let body = &mut report.bodies[self.scene.body_of(disk).index()];
            body.wall_contacts += 1;
            body.squeeze += squeeze;
            report.wall_contacts += 1;
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

/// Writes what the evaluation `now` has found into the pair's spring, and adds the forces up.
#[inline(always)]
fn settle(
    finding: Finding,
    spring: &mut Spring,
    now: u64,
    stretch: Stretch,
    receiver: BodyId,
    giver: Option<BodyId>,
    sums: &mut Sums,
) {
    match finding {
        Finding::Apart => {}
        Finding::Coincident { depth, .. } => sums.add_coincident(receiver, giver, depth),
        Finding::Touching(touch) => {
            sums.work.contacts += 1;
            sums.work.sliding += u64::from(touch.reaction.regime == Regime::Sliding);
            let elongation = match stretch {
                Stretch::Hold => touch.elongation,
                Stretch::Over(_) => touch.reaction.elongation,
            };
            let (slip_speed, part) = (touch.slip_speed, touch.part);
            *spring = Spring { elongation, slip_speed, part, touched_at: now };
            sums.add(receiver, giver, &touch);
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
    /// Disk–disk contacts, pairs whose centres coincide among them.
    pub agent_contacts: u32,
    /// Disk–face contacts, the same among them.
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
    /// Of these contacts, the pairs whose centres coincide: no force acts between them.
    pub coincident: Vec<Pair>,
    /// \[m\] the deepest overlap; zero without contacts.
    pub largest_overlap: f64,
}

impl ContactReport {
    fn empty(bodies: usize) -> ContactReport {
        ContactReport { bodies: vec![BodyContacts::default(); bodies], ..ContactReport::default() }
    }

    /// Adds a contact; answers |F_n| \[N\].
    fn add(&mut self, pair: Pair, touch: &Touch) -> f64 {
        self.largest_overlap = self.largest_overlap.max(touch.overlap.depth);
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
        touch.reaction.normal.abs()
    }

    /// The same of a pair without a normal.
    fn add_coincident(&mut self, pair: Pair, depth: f64) -> f64 {
        self.largest_overlap = self.largest_overlap.max(depth);
        self.coincident.push(pair);
        0.0
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
}
