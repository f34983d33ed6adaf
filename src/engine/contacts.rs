//! Computes all contacts at one time: forces from overlap, relative motion and springs.

use super::contact_law::{Grip, Reaction, normal_force, react};
use super::face::nearest_on_face;
use super::overlap::{COINCIDENT, Meeting, Overlap, books_contact, meet, meet_face, overlap_with_part, unit};
use super::pairs::{DiskPair, DiskPairDetail, FacePair, Pairs, Sight, Spring, Touching, spring_at_face};
use super::passing::Passing;
use super::standing::{Standing, velocity_at};
use super::{BodyId, DiskId, FaceId, FacePart, PairLaw, Regime, Scene, Twist, Vec2, Wrench};

/// How an evaluation changes the springs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Stretch {
    /// It does not change them.
    Hold,
    /// Each spring advances once, over a mechanical step \[s\].
    Over(f64),
}

/// Counters of the work that was done, for tests and benchmarks; they do not measure time.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Work {
    /// Number of mechanical steps.
    pub steps: u64,
    /// Pairs that were checked for overlap.
    pub pairs: u64,
    /// Pairs that touched.
    pub contacts: u64,
    /// Contacts that were sliding.
    pub sliding: u64,
    /// Pairs whose centres coincided: they have no normal, so no force acts.
    pub coincident: u64,
    /// How many times the list of candidates was made.
    pub rebuilds: u64,
    /// How many times the list of near pairs was made from the candidates.
    pub refreshes: u64,
    /// Candidates that were checked for this.
    pub candidates: u64,
    /// Bodies that were moved by the closed-form solution over a whole communication step.
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

/// Two touching things, before the law is applied.
#[derive(Clone, Copy)]
struct Encounter<'a> {
    law: &'a PairLaw,
    overlap: Overlap,
    part: FacePart,
    /// \[m\] from the receiver's centre of mass to the contact point.
    arm: Vec2,
    /// \[m\] from the other's centre of mass to the contact point.
    other_arm: Vec2,
    /// \[m/s\] of the receiver relative to the other at the contact point.
    velocity: Vec2,
}

/// By how much the impulse of a contact that began or ended within a step differs from that of the evaluation next to
/// this time, whose forces count for half a step.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Amendment {
    /// \[N.s\] along the normal.
    normal: f64,
    /// \[N.s\] along the tangent.
    tangential: f64,
    /// \[N.s\] of |F_n|.
    squeeze: f64,
}

impl Amendment {
    /// For a contact that lasted a time \[s\] within a step, between its `edge` and the evaluation. `whole`: it began
    /// or ended there with all forces; else it passed to another part of a wall, and its normal force went on.
    fn of(edge: &Reaction, evaluated: &Reaction, lasted: f64, dt: f64, whole: bool) -> Amendment {
        let over = |edge: f64, evaluated: f64| 0.5 * ((edge + evaluated) * lasted - evaluated * dt);
        let tangential = over(edge.tangential, evaluated.tangential);
        if !whole {
            return Amendment { normal: 0.0, tangential, squeeze: 0.0 };
        }
        let squeeze = over(edge.normal.abs(), evaluated.normal.abs());
        Amendment { normal: over(edge.normal, evaluated.normal), tangential, squeeze }
    }
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

/// Number of pairs that are processed together, so that intermediate results stay in the nearest cache.
const AT_ONCE: usize = 32;

/// The sum of the contact forces on a body at one instant.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Load {
    pub wrench: Wrench,
    /// \[N\] sum of |F_n|.
    pub squeeze: f64,
}

impl Load {
    #[inline(always)]
    pub fn add(&mut self, other: &Load) {
        self.wrench.force += other.wrench.force;
        self.wrench.torque += other.wrench.torque;
        self.squeeze += other.squeeze;
    }
}

/// The force of a contact on a body of another block.
#[derive(Debug, Clone, Copy)]
pub(super) struct Crossing {
    pub body: BodyId,
    pub load: Load,
    /// \[m\] overlap h.
    pub depth: f64,
}

/// What a contact that began or ended within a step does to a body besides its loads, see [`Instant::evaluate`].
#[derive(Debug, Clone, Copy)]
pub(super) struct Impulse {
    pub body: BodyId,
    /// \[N.s\], \[N.m.s\]
    pub wrench: Wrench,
    /// \[N.s\] of |F_n|.
    pub squeeze: f64,
    /// \[N\] |F_n| at its beginning or end.
    pub peak: f64,
}

/// The sums of an evaluation for the bodies of a block.
pub(super) struct Sums<'a> {
    /// Index of the first body of the block.
    pub start: usize,
    /// Loads of the bodies of the block at this instant.
    pub loads: &'a mut [Load],
    /// \[m\] For the bodies of the block, the deepest overlap up to this instant.
    pub deepest: &'a mut [f64],
    /// Forces on bodies of later blocks.
    pub outgoing: &'a mut Vec<Crossing>,
    /// Impulses on the bodies of the block, by contacts that began or ended within the last step.
    pub impulses: &'a mut Vec<Impulse>,
    /// The same on bodies of later blocks.
    pub outgoing_impulses: &'a mut Vec<Impulse>,
    pub work: &'a mut Work,
}

impl Sums<'_> {
    /// Each force is computed once and applied to both bodies with opposite signs: Newton's third law holds exactly.
    #[inline(always)]
    fn add(&mut self, receiver: BodyId, giver: Option<BodyId>, touch: &Touch) {
        let (force, squeeze, depth) = (touch.force(), touch.reaction.normal.abs(), touch.overlap.depth);
        self.give(receiver, Load { wrench: touch.on_receiver(force), squeeze }, depth);
        let Some(giver) = giver else { return };
        self.give(giver, Load { wrench: touch.on_giver(force), squeeze }, depth);
    }

    #[inline(always)]
    fn give(&mut self, body: BodyId, load: Load, depth: f64) {
        let b = body.index() - self.start;
        match (self.loads.get_mut(b), self.deepest.get_mut(b)) {
            (Some(sum), Some(deepest)) => {
                sum.add(&load);
                deepen(deepest, depth);
            }
            _ => self.outgoing.push(Crossing { body, load, depth }),
        }
    }

    /// The impulse of a contact that began or ended within a step, on both bodies.
    #[cold]
    fn amend(&mut self, receiver: BodyId, giver: Option<BodyId>, (touch, by): (Touch, Amendment)) {
        let Amendment { normal, tangential, squeeze } = by;
        let impulse = touch.overlap.normal * normal + touch.overlap.normal.perp() * tangential;
        let peak = touch.reaction.normal.abs();
        let on_receiver = Impulse { body: receiver, wrench: touch.on_receiver(impulse), squeeze, peak };
        let on_giver = giver.map(|body| Impulse { body, wrench: touch.on_giver(impulse), squeeze, peak });
        for impulse in [Some(on_receiver), on_giver].into_iter().flatten() {
            let inside = impulse.body.index() - self.start < self.loads.len();
            let impulses = if inside { &mut *self.impulses } else { &mut *self.outgoing_impulses };
            impulses.push(impulse);
        }
    }

    /// Disks that overlap without a normal: no force acts between them, but they are counted.
    #[cold]
    fn add_coincident(&mut self, receiver: BodyId, giver: Option<BodyId>, depth: f64) {
        self.work.coincident += 1;
        for body in [Some(receiver), giver].into_iter().flatten() {
            self.give(body, Load::default(), depth);
        }
    }
}

/// Keeps an overlap \[m\] if it is deeper than all before.
#[inline(always)]
pub(super) fn deepen(deepest: &mut f64, depth: f64) {
    if depth > *deepest {
        *deepest = depth;
    }
}

/// The instant at which contacts are evaluated.
pub(super) struct Instant<'a> {
    pub scene: &'a Scene,
    /// One for each body.
    pub standing: &'a [Standing],
    /// Returns the twist of a body without its last half kick.
    pub unkicked: &'a (dyn Fn(BodyId) -> Twist + Sync),
    /// Number of earlier evaluations.
    pub before: u32,
}

impl Instant<'_> {
    #[inline(always)]
    fn disks(&self, pair: &DiskPair, detail: &DiskPairDetail, sight: &Sight, memory: Memory) -> Finding {
        let overlap = match meet(sight.between, pair.reach) {
            Meeting::Apart => return Finding::Apart,
            Meeting::Coincident => {
                return Finding::Coincident { depth: pair.reach, part: FacePart::Left };
            }
            Meeting::Touching(overlap) => overlap,
        };
        let encounter = self.encounter(pair, detail, sight, overlap);
        let began = |dt| self.begun_disks(pair, &encounter, dt);
        Finding::Touching(touch(&encounter, memory, began))
    }

    #[inline(always)]
    fn encounter(
        &self,
        pair: &DiskPair,
        detail: &DiskPairDetail,
        sight: &Sight,
        overlap: Overlap,
    ) -> Encounter<'_> {
        let (i, j) = (&self.standing[pair.first_body.index()], &self.standing[pair.second_body.index()]);
        let arm = sight.arm + overlap.contact_point(detail.first_radius);
        let other_arm = sight.other_arm - overlap.contact_point(detail.second_radius);
        let velocity = i.velocity_at(arm) - j.velocity_at(other_arm);
        let law = self.scene.law_at(detail.law);
        Encounter { law, overlap, part: FacePart::Left, arm, other_arm, velocity }
    }

    /// How a contact of two disks began within the last step, whose duration is `dt` \[s\].
    #[cold]
    #[inline(never)]
    fn begun_disks(&self, pair: &DiskPair, encounter: &Encounter, dt: f64) -> Beginning {
        let first = velocity_at(&(self.unkicked)(pair.first_body), encounter.arm);
        let second = velocity_at(&(self.unkicked)(pair.second_body), encounter.other_arm);
        let half_kick = encounter.velocity - (first - second);
        begun(encounter, Lately { came: None, half_kick }, dt)
    }

    /// Amends the motion by a contact of two disks that began within the last step.
    #[cold]
    #[inline(never)]
    fn begin_disks(&self, pair: &DiskPair, detail: &DiskPairDetail, sight: &Sight, dt: f64, sums: &mut Sums) {
        let Meeting::Touching(overlap) = meet(sight.between, pair.reach) else { return };
        let encounter = self.encounter(pair, detail, sight, overlap);
        let began = began(&encounter, &self.begun_disks(pair, &encounter, dt), dt);
        sums.amend(pair.first_body, Some(pair.second_body), began);
    }

    /// A disk and a face; `memory` returns the memory of the part of the face that is touched.
    #[inline]
    fn face<'a>(&self, pair: &FacePair, memory: impl FnOnce(FacePart) -> Memory<'a>) -> Finding {
        match self.meet_face(pair) {
            Ok(encounter) => {
                let began = |dt| self.begun_face(pair, &encounter, dt);
                Finding::Touching(touch(&encounter, memory(encounter.part), began))
            }
            Err(finding) => finding,
        }
    }

    /// A disk and a face where they touch.
    #[inline]
    fn meet_face(&self, pair: &FacePair) -> Result<Encounter<'_>, Finding> {
        let (disk, face) = (&self.scene.disks[pair.disk.index()], pair.face.index());
        let (wall, standing) = (&self.scene.faces[face], &self.standing[disk.body.index()]);
        let arm = standing.arm(disk.offset);
        let centre = standing.position + arm;
        let nearest = nearest_on_face(wall, centre);
        let apart = (centre - nearest.0).norm_squared() >= disk.radius * disk.radius;
        if apart || !books_contact(self.scene, face, nearest, centre) {
            return Err(Finding::Apart);
        }
        let (meeting, part) = meet_face(wall, nearest, centre, disk.radius, standing.position);
        let overlap = match meeting {
            Meeting::Apart => return Err(Finding::Apart),
            Meeting::Coincident => return Err(Finding::Coincident { depth: disk.radius, part }),
            Meeting::Touching(overlap) => overlap,
        };
        let arm = arm + overlap.contact_point(disk.radius);
        let law = self.scene.law(disk.material, wall.material);
        let velocity = standing.velocity_at(arm);
        Ok(Encounter { law, overlap, part, arm, other_arm: Vec2::ZERO, velocity })
    }

    /// How a contact of a disk and a face began within the last step, whose duration is `dt` \[s\].
    #[cold]
    #[inline(never)]
    fn begun_face(&self, pair: &FacePair, encounter: &Encounter, dt: f64) -> Beginning {
        let disk = &self.scene.disks[pair.disk.index()];
        let standing = &self.standing[disk.body.index()];
        let arm = standing.arm(disk.offset);
        let (centre, velocity) = (standing.position + arm, standing.velocity_at(arm));
        let passing = Passing { scene: self.scene, centre, velocity, dt };
        let half_kick = encounter.velocity - velocity_at(&(self.unkicked)(disk.body), encounter.arm);
        let came = passing.since_coming(&self.scene.faces[pair.face.index()], encounter.part);
        begun(encounter, Lately { came, half_kick }, dt)
    }

    /// Amends the motion by a contact of a disk and a face that began within the last step.
    #[cold]
    #[inline(never)]
    fn begin_face(&self, pair: &FacePair, dt: f64, sums: &mut Sums) {
        let Ok(encounter) = self.meet_face(pair) else { return };
        let began = began(&encounter, &self.begun_face(pair, &encounter, dt), dt);
        sums.amend(self.scene.body_of(pair.disk), None, began);
    }

    /// Sums the contact wrenches of a block's pairs, and lets their springs advance according to `stretch`.
    ///
    /// The force of an evaluation counts for half a step before it and half a step after it. Where a contact began
    /// within the step before, or ended within it, it lasted longer or shorter than that. The difference is given as
    /// an impulse: else a force that jumps would make the integrator first order.
    pub fn evaluate(&self, pairs: &mut Pairs, stretch: Stretch, sums: &mut Sums) {
        let before = self.before;
        let now = before + 1;
        sums.work.pairs += (pairs.disks.len() + pairs.faces.len()) as u64;
        pairs.overlapping.resize(AT_ONCE, (0, Sight::default()));
        let touched = std::mem::take(&mut pairs.touching);
        pairs.touching = std::mem::take(&mut pairs.touched);
        pairs.touching.clear();
        for start in (0..pairs.disks.len()).step_by(AT_ONCE) {
            for (k, sight) in self.find_overlapping(&pairs.disks, start, &mut pairs.overlapping) {
                let (pair, detail) = (&pairs.disks[*k], &pairs.disk_details[*k]);
                let spring = &mut pairs.disk_springs[*k];
                let began = spring.touched_at != before;
                let finding = self.disks(pair, detail, sight, Memory { spring, before, stretch });
                if settle(finding, spring, now, stretch, pair.first_body, Some(pair.second_body), sums) {
                    pairs.touching.disks.push(*k as u32);
                    if let (Stretch::Over(dt), true) = (stretch, began) {
                        self.begin_disks(pair, detail, sight, dt, sums);
                    }
                }
            }
        }
        let Pairs { faces, face_springs, touching, .. } = &mut *pairs;
        for (k, pair) in faces.iter().enumerate() {
            let mut began = false;
            let memory = |part| {
                let spring = spring_at_face(self.scene, faces, face_springs, k, part, before);
                let memory = Memory { spring, before, stretch };
                began = !memory.continues(part);
                memory
            };
            let finding = self.face(pair, memory);
            if let (Stretch::Over(dt), Finding::Touching(touch)) = (stretch, &finding)
                && (face_springs[k].touched_at, true) == (before, face_springs[k].part != touch.part)
                && let Some(ended) = self.ended_face(pair, &face_springs[k], dt)
            {
                // It touches another part of the same face.
                sums.amend(self.scene.body_of(pair.disk), None, ended);
            }
            if settle(finding, &mut face_springs[k], now, stretch, self.scene.body_of(pair.disk), None, sums)
            {
                touching.faces.push(k as u32);
                if let (Stretch::Over(dt), true) = (stretch, began) {
                    self.begin_face(pair, dt, sums);
                }
            }
        }
        if let Stretch::Over(dt) = stretch {
            self.end(pairs, &touched, dt, sums);
        }
        pairs.touched = touched;
    }

    /// Amends the motion by the contacts that ended within the last step.
    fn end(&self, pairs: &Pairs, touched: &Touching, dt: f64, sums: &mut Sums) {
        for k in touched.disks.iter().map(|k| *k as usize) {
            let spring = &pairs.disk_springs[k];
            if spring.touched_at == self.before
                && let Some(ended) = self.ended_disks(&pairs.disks[k], &pairs.disk_details[k], spring, dt)
            {
                sums.amend(pairs.disks[k].first_body, Some(pairs.disks[k].second_body), ended);
            }
        }
        for k in touched.faces.iter().map(|k| *k as usize) {
            let (pair, spring) = (&pairs.faces[k], &pairs.face_springs[k]);
            if spring.touched_at == self.before
                && let Some(ended) = self.ended_face(pair, spring, dt)
            {
                sums.amend(self.scene.body_of(pair.disk), None, ended);
            }
        }
    }

    /// The contact of two disks when it ended within the last step.
    #[cold]
    fn ended_disks(
        &self,
        pair: &DiskPair,
        detail: &DiskPairDetail,
        spring: &Spring,
        dt: f64,
    ) -> Option<(Touch, Amendment)> {
        let sight = pair.seen(self.standing);
        let distance = sight.between.norm();
        if distance <= COINCIDENT {
            return None;
        }
        let apart = Overlap { depth: pair.reach - distance, normal: unit(sight.between, distance) };
        ended(&self.encounter(pair, detail, &sight, apart), spring, None, dt)
    }

    /// The same for a disk and a face.
    #[cold]
    fn ended_face(&self, pair: &FacePair, spring: &Spring, dt: f64) -> Option<(Touch, Amendment)> {
        let (disk, face) = (&self.scene.disks[pair.disk.index()], pair.face.index());
        let (wall, standing) = (&self.scene.faces[face], &self.standing[disk.body.index()]);
        let arm = standing.arm(disk.offset);
        let centre = standing.position + arm;
        let apart = overlap_with_part(wall, spring.part, centre, disk.radius)?;
        let passing = Passing { scene: self.scene, centre, velocity: standing.velocity_at(arm), dt };
        let left = passing.since_leaving(wall, spring.part);
        let arm = arm + apart.contact_point(disk.radius);
        let law = self.scene.law(disk.material, wall.material);
        let (part, velocity) = (spring.part, standing.velocity_at(arm));
        let encounter = Encounter { law, overlap: apart, part, arm, other_arm: Vec2::ZERO, velocity };
        ended(&encounter, spring, left, dt)
    }

    /// Finds the overlapping pairs among the next [`AT_ONCE`], and their indices. It has no branches, because
    /// processors cannot predict which pairs touch.
    #[inline(always)]
    fn find_overlapping<'a>(
        &self,
        pairs: &[DiskPair],
        start: usize,
        overlapping: &'a mut [(usize, Sight)],
    ) -> &'a [(usize, Sight)] {
        let mut found = 0;
        for (k, pair) in pairs.iter().enumerate().skip(start).take(AT_ONCE) {
            let sight = pair.seen(self.standing);
            overlapping[found] = (k, sight);
            found += usize::from(sight.between.norm_squared() < pair.reach * pair.reach);
        }
        &overlapping[..found]
    }

    /// Returns the contacts of all blocks at present; changes nothing.
    pub fn report<'a>(&self, blocks: impl Iterator<Item = &'a Pairs> + Clone) -> ContactReport {
        let mut report = ContactReport::empty(self.scene.bodies.len());
        let mut touching_bodies = Vec::new();
        let memory = |spring| Memory { spring, before: self.before, stretch: Stretch::Hold };
        let disks = |pairs: &'a Pairs| pairs.disks.iter().zip(&pairs.disk_details).zip(&pairs.disk_springs);
        for ((pair, detail), spring) in blocks.clone().flat_map(disks) {
            let who = Pair::Disks { first: detail.first, second: detail.second };
            let squeeze = match self.disks(pair, detail, &pair.seen(self.standing), memory(spring)) {
                Finding::Apart => continue,
                Finding::Coincident { depth, .. } => report.add_coincident(who, depth),
                Finding::Touching(touch) => {
                    let force = touch.force();
                    report.bodies[pair.first_body.index()].take(&touch.on_receiver(force));
                    report.bodies[pair.second_body.index()].take(&touch.on_giver(force));
                    report.add(who, &touch)
                }
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
            // Because of rounding, a body may now touch the next face of a straight wall.
            let held = |part| memory(spring_at_face(self.scene, faces, face_springs, k, part, self.before));
            let squeeze = match self.face(&faces[k], held) {
                Finding::Apart => continue,
                Finding::Coincident { depth, part } => report.add_coincident(who(part), depth),
                Finding::Touching(touch) => {
                    let body = &mut report.bodies[self.scene.body_of(disk).index()];
                    body.take(&touch.on_receiver(touch.force()));
                    report.add(who(touch.part), &touch)
                }
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

    /// The wrench on the receiver, of the force on it.
    #[inline(always)]
    fn on_receiver(&self, force: Vec2) -> Wrench {
        Wrench { force, torque: self.arm.cross(force) }
    }

    /// The wrench on the other body, of the force on the receiver.
    #[inline(always)]
    fn on_giver(&self, force: Vec2) -> Wrench {
        Wrench { force: -force, torque: -self.other_arm.cross(force) }
    }
}

/// The memory of a pair.
#[derive(Clone, Copy)]
struct Memory<'a> {
    spring: &'a Spring,
    /// Number of the previous evaluation.
    before: u32,
    stretch: Stretch,
}

/// What happened to a contact within the last step.
struct Lately {
    /// \[s\] Time since the receiver came to this part of a wall, if it did so.
    came: Option<f64>,
    /// \[m/s\] What the other contacts added to the relative velocity in the last half step.
    half_kick: Vec2,
}

impl Memory<'_> {
    /// Whether a contact with this part of the other thing goes on.
    #[inline(always)]
    fn continues(&self, part: FacePart) -> bool {
        self.spring.touched_at == self.before && self.spring.part == part
    }
}

/// Applies the law to a contact. `begun` is asked, with the duration \[s\] of the last step, how a contact began within
/// it.
#[inline(always)]
fn touch(encounter: &Encounter, memory: Memory, begun: impl FnOnce(f64) -> Beginning) -> Touch {
    let Encounter { law, overlap, part, .. } = *encounter;
    let (normal_speed, slip_speed) = encounter.speeds();
    let normal = normal_force(law, overlap.depth, normal_speed);
    let grip = &memory.spring.grip;
    let elongation = match (memory.stretch, memory.continues(part)) {
        (Stretch::Hold, true) => grip.elongation,
        (Stretch::Hold, false) => 0.0,
        (Stretch::Over(dt), true) => grip.stretched(law, normal, slip_speed, dt),
        (Stretch::Over(dt), false) => begun(dt).elongation(slip_speed),
    };
    let reaction = react(law, normal, slip_speed, elongation);
    encounter.touch(elongation, reaction)
}

impl Encounter<'_> {
    /// \[m/s\] along the normal, positive if they separate, and along the tangent.
    #[inline(always)]
    fn speeds(&self) -> (f64, f64) {
        (self.velocity.dot(self.overlap.normal), self.velocity.dot(self.overlap.normal.perp()))
    }

    #[inline(always)]
    fn touch(&self, elongation: f64, reaction: Reaction) -> Touch {
        let (normal_speed, slip_speed) = self.speeds();
        let Encounter { overlap, part, arm, other_arm, .. } = *self;
        Touch { overlap, part, arm, other_arm, normal_speed, slip_speed, elongation, reaction }
    }
}

/// How a contact began within a step.
struct Beginning {
    /// Its forces and its spring just after that.
    first: Reaction,
    /// \[s\] Time since then.
    since: f64,
    /// See [`Amendment::of`].
    whole: bool,
}

impl Beginning {
    /// \[m\] of the spring now, before the slider may give way; `slip_speed` \[m/s\] is that of now.
    fn elongation(&self, slip_speed: f64) -> f64 {
        self.first.elongation + slip_speed * self.since
    }
}

/// A contact that began within a step, and by how much its impulse differs from that of half a step.
fn began(encounter: &Encounter, beginning: &Beginning, dt: f64) -> (Touch, Amendment) {
    let (normal_speed, slip_speed) = encounter.speeds();
    let normal = normal_force(encounter.law, encounter.overlap.depth, normal_speed);
    let elongation = beginning.elongation(slip_speed);
    let reaction = react(encounter.law, normal, slip_speed, elongation);
    let Beginning { first, since, whole } = beginning;
    (encounter.touch(elongation, reaction), Amendment::of(first, &reaction, *since, dt, *whole))
}

fn begun(encounter: &Encounter, lately: Lately, dt: f64) -> Beginning {
    let Encounter { law, overlap, velocity, .. } = *encounter;
    let (depth, normal_speed) = (overlap.depth, velocity.dot(overlap.normal));
    // Deeper than it can have come in a step: other contacts turned it, and when it began is not known.
    let known = -2.0 * normal_speed * dt > depth;
    let touched = if known { dt.min(depth / -normal_speed) } else { 0.5 * dt };
    let (since, whole) = match lately.came {
        Some(came) if came < touched || !known => (came, false),
        _ => (touched, true),
    };
    // In the instant in which it begins it may slide, and then stick: the damping forces are there at once.
    let then = velocity - lately.half_kick * (since / (0.5 * dt));
    let depth = if known || !whole { depth + normal_speed * since } else { depth };
    let normal = normal_force(law, depth, then.dot(overlap.normal));
    let first = react(law, normal, then.dot(overlap.normal.perp()), 0.0);
    Beginning { first, since, whole }
}

/// A contact that ended within a step, at its end. `overlap` is what the disks would have now. `left` is the time \[s\]
/// since the receiver left this part of a wall, if it did so within the step.
fn ended(encounter: &Encounter, spring: &Spring, left: Option<f64>, dt: f64) -> Option<(Touch, Amendment)> {
    let Encounter { law, overlap, .. } = *encounter;
    let (normal_speed, slip_speed) = encounter.speeds();
    let gap = -overlap.depth;
    let parted = (gap >= 0.0 && normal_speed > 0.0).then(|| dt.min(gap / normal_speed));
    let (since, whole) = match (left, parted) {
        (Some(left), Some(parted)) => (left.max(parted), parted >= left),
        (Some(left), None) => (left, false),
        (None, Some(parted)) => (parted, true),
        (None, None) => return None,
    };
    let (grip, lasted) = (spring.grip, dt - since);
    let depth = (overlap.depth + normal_speed * since).max(0.0);
    let normal = normal_force(law, depth, normal_speed);
    let elongation = grip.stretched(law, normal, slip_speed, lasted);
    let reaction = react(law, normal, slip_speed, elongation);
    let evaluated = react(law, grip.normal, grip.slip_speed, grip.elongation);
    Some((encounter.touch(elongation, reaction), Amendment::of(&reaction, &evaluated, lasted, dt, whole)))
}

/// Writes the result of the evaluation `now` into the pair's spring, and adds the forces to the sums. Returns whether
/// the pair touches.
#[inline(always)]
fn settle(
    finding: Finding,
    spring: &mut Spring,
    now: u32,
    stretch: Stretch,
    receiver: BodyId,
    giver: Option<BodyId>,
    sums: &mut Sums,
) -> bool {
    match finding {
        Finding::Apart => false,
        Finding::Coincident { depth, .. } => {
            sums.add_coincident(receiver, giver, depth);
            false
        }
        Finding::Touching(touch) => {
            sums.work.contacts += 1;
            sums.work.sliding += u64::from(touch.reaction.regime == Regime::Sliding);
            let elongation = match stretch {
                Stretch::Hold => touch.elongation,
                Stretch::Over(_) => touch.reaction.elongation,
            };
            let grip = Grip { elongation, slip_speed: touch.slip_speed, normal: touch.reaction.normal };
            *spring = Spring { grip, part: touch.part, touched_at: now };
            sums.add(receiver, giver, &touch);
            true
        }
    }
}

/// The two touching things.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Pair {
    /// Two disks of different bodies.
    Disks {
        /// The disk that receives the force; of the body with the lower number.
        first: DiskId,
        /// The other disk.
        second: DiskId,
    },
    /// A disk and a face.
    Face {
        /// The disk that receives the force.
        disk: DiskId,
        /// The face.
        face: FaceId,
        /// The part of the face.
        part: FacePart,
    },
}

/// One contact, with the forces on the receiver.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Contact {
    /// The two touching things.
    pub pair: Pair,
    /// \[m\] overlap h.
    pub depth: f64,
    /// Towards the receiver.
    pub normal: Vec2,
    /// \[N\] force along the normal; negative if it pulls.
    pub normal_force: f64,
    /// \[N\] force along the tangent `normal.perp()`.
    pub tangential_force: f64,
    /// \[m\] elongation of the tangential spring, along the tangent.
    pub elongation: f64,
    /// \[m/s\] velocity of the receiver relative to the other, along the normal; positive if they separate.
    pub normal_speed: f64,
    /// \[m/s\] velocity of the receiver relative to the other, along the tangent.
    pub slip_speed: f64,
    /// Whether the contact sticks or slides.
    pub regime: Regime,
}

/// What the contacts do to one body.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct BodyContacts {
    /// Number of disk–disk contacts, including pairs whose centres coincide.
    pub agent_contacts: u32,
    /// Number of disk–face contacts, including those whose centres coincide.
    pub wall_contacts: u32,
    /// Number of bodies that touch this one.
    pub touching_bodies: u32,
    /// \[N\] sum of |F_n| over its contacts.
    pub squeeze: f64,
    /// The sum of the forces of its contacts, and of their torques about the centre of mass.
    pub wrench: Wrench,
}

impl BodyContacts {
    fn take(&mut self, wrench: &Wrench) {
        self.wrench.force += wrench.force;
        self.wrench.torque += wrench.torque;
    }
}

/// Every contact at one time.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ContactReport {
    /// Disk pairs ascending, then disk–face pairs ascending.
    pub contacts: Vec<Contact>,
    /// One for each body.
    pub bodies: Vec<BodyContacts>,
    /// Number of disk–disk contacts, each pair once.
    pub agent_contacts: u32,
    /// Number of disk–face contacts.
    pub wall_contacts: u32,
    /// How many of these contacts have coinciding centres: no force acts between them.
    pub coincident: Vec<Pair>,
    /// \[m\] the deepest overlap; zero without contacts.
    pub largest_overlap: f64,
}

impl ContactReport {
    fn empty(bodies: usize) -> ContactReport {
        ContactReport { bodies: vec![BodyContacts::default(); bodies], ..ContactReport::default() }
    }

    /// Adds a contact and returns |F_n| \[N\].
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

    /// Adds a pair without a normal.
    fn add_coincident(&mut self, pair: Pair, depth: f64) -> f64 {
        self.largest_overlap = self.largest_overlap.max(depth);
        self.coincident.push(pair);
        0.0
    }

    /// Returns a body on which a force is not a finite number, if there is one.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::vec2;

    static LAW: PairLaw = PairLaw {
        normal_stiffness: 2e6,
        tangential_stiffness: 1e6,
        normal_damping: 1000.0,
        tangential_damping: 1000.0,
        friction: 0.5,
    };
    const DT: f64 = 1e-4;

    /// The other is below.
    fn encounter(depth: f64, velocity: Vec2) -> Encounter<'static> {
        let overlap = Overlap { depth, normal: vec2(0.0, 1.0) };
        let (arm, other_arm) = (Vec2::ZERO, Vec2::ZERO);
        Encounter { law: &LAW, overlap, part: FacePart::Left, arm, other_arm, velocity }
    }

    fn lately(came: Option<f64>) -> Lately {
        Lately { came, half_kick: Vec2::ZERO }
    }

    #[test]
    fn a_contact_counts_from_the_time_when_it_began() {
        // 25 µm deep at 1 m/s: it has lasted a quarter of the step. The tangent points to the left.
        let Beginning { first, since, whole } = begun(&encounter(2.5e-5, vec2(-0.4, -1.0)), lately(None), DT);
        assert!((since - 0.25 * DT).abs() < 1e-18 && whole);
        assert!((first.normal - 1000.0).abs() < 1e-9 && (first.tangential + 400.0).abs() < 1e-9);
        // From 1000 N to 1050 N; half a step of 1050 N counts anyhow.
        let now = Reaction { normal: 1050.0, ..first };
        let Amendment { normal, squeeze, .. } = Amendment::of(&first, &now, since, DT, whole);
        assert!((normal - (1025.0 * 0.25 - 1050.0 * 0.5) * DT).abs() < 1e-15);
        assert_eq!(squeeze, normal);
    }

    #[test]
    fn a_contact_may_slip_in_its_first_instant() {
        let Beginning { first, .. } = begun(&encounter(2.5e-5, vec2(-0.8, -1.0)), lately(None), DT);
        // From 800 N of damping to the limit of 500 N.
        assert!((first.elongation - (500.0 - 800.0) / 1e6).abs() < 1e-15);
        // The others' contacts have pushed it since: at first it was as slow as in the test before.
        let pushed = Lately { came: None, half_kick: vec2(-0.8, 0.0) };
        let Beginning { first, .. } = begun(&encounter(2.5e-5, vec2(-0.8, -1.0)), pushed, DT);
        assert_eq!(first.elongation, 0.0);
    }

    #[test]
    fn at_a_corner_the_normal_force_goes_on() {
        let Beginning { first, since, whole } =
            begun(&encounter(3e-3, vec2(0.4, -1.0)), lately(Some(0.1 * DT)), DT);
        assert!((since - 0.1 * DT).abs() < 1e-18 && !whole);
        let amendment = Amendment::of(&first, &first, since, DT, whole);
        assert_eq!((amendment.normal, amendment.squeeze), (0.0, 0.0));
        assert!((amendment.tangential + 0.4 * DT * first.tangential).abs() < 1e-15);
        // It came to this part of the wall before it touched it.
        let beginning = begun(&encounter(2.5e-5, vec2(0.4, -1.0)), lately(Some(0.9 * DT)), DT);
        assert!((beginning.since - 0.25 * DT).abs() < 1e-18 && beginning.whole);
    }

    #[test]
    fn a_contact_counts_until_the_time_when_it_ended() {
        let grip = Grip { elongation: 1e-5, slip_speed: 0.0, normal: -900.0 };
        let spring = Spring { grip, part: FacePart::Left, touched_at: 1 };
        let ended = |gap: f64, speed: f64| ended(&encounter(-gap, vec2(0.0, speed)), &spring, None, DT);
        // 75 µm away at 1 m/s: it ended three quarters of the step ago, when it pulled with 1000 N.
        let (touch, amendment) = ended(7.5e-5, 1.0).unwrap();
        assert!((touch.reaction.normal + 1000.0).abs() < 1e-9);
        // From −900 N to −1000 N over a quarter of the step; half a step of −900 N has counted.
        assert!((amendment.normal + (950.0 * 0.25 - 900.0 * 0.5) * DT).abs() < 1e-13);
        assert!((amendment.squeeze - (950.0 * 0.25 - 900.0 * 0.5) * DT).abs() < 1e-13);
        assert_eq!(touch.reaction.tangential, -1e6 * 1e-5);
        // Not longer ago than it was seen.
        assert!((ended(1.0, 1.0).unwrap().1.normal - 0.5 * DT * 900.0).abs() < 1e-13);
        // It comes back: when it ended is not known.
        assert!(ended(1e-5, -1.0).is_none());
    }
}
