//! Computes all contacts at one time: forces from overlap, relative motion and springs.

use super::contact_events::ImpulseCorrection;
use super::contact_geometry::{ContactForce, ContactGeometry, Instant};
use super::contact_law::{Relaxation, SpringHistory, normal_force, react};
use super::levels::ChestForce;
use super::near_pairs::{
    AT_ONCE, DiskPair, DiskPairDetail, FacePair, NearPairs, Overlapping, Separation, Spring,
};
use super::overlap::{Proximity, proximity};
use super::wall_contacts::WallContacts;
use super::{BodyId, DiskId, FaceId, PairLaw, PanelId, Regime, Scene, Wrench};
use lemons_core::plane::InPlane;

/// How an evaluation changes the springs.
#[derive(Debug, Clone, Copy)]
pub(super) enum SpringUpdate<'a> {
    /// It does not change them.
    Hold,
    /// Each spring advances once, over a mechanical step.
    Over(&'a Step),
}

/// A mechanical step.
#[derive(Debug, Clone, Default)]
pub(super) struct Step {
    /// \[s\]
    pub dt: f64,
    /// For each law of the scene.
    relaxations: Vec<Relaxation>,
}

impl Step {
    /// A step of a duration \[s\].
    pub fn new(scene: &Scene, dt: f64) -> Step {
        Step { dt, relaxations: scene.all_laws().iter().map(|law| Relaxation::over(law, dt)).collect() }
    }
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
    /// Bodies whose candidates were listed anew because they had moved too far; their neighbours are not counted.
    pub listed: u64,
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
            listed: sum.listed + work.listed,
            refreshes: sum.refreshes + work.refreshes,
            candidates: sum.candidates + work.candidates,
            shortlisted: sum.shortlisted + work.shortlisted,
        })
    }
}

/// The sum of the contact forces on a body at one instant.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Load {
    pub wrench: Wrench,
    /// \[N\] sum of |F_n|.
    pub squeeze: f64,
    /// \[m\] The deepest overlap.
    pub depth: f64,
}

/// Returns the greater number, the first one if the second is not a number: one instruction, unlike [`f64::max`].
#[inline(always)]
pub(super) fn greater(one: f64, other: f64) -> f64 {
    if other > one { other } else { one }
}

impl Load {
    #[inline(always)]
    pub fn add(&mut self, other: &Load) {
        self.wrench.force += other.wrench.force;
        self.wrench.torque += other.wrench.torque;
        self.squeeze += other.squeeze;
        self.depth = greater(self.depth, other.depth);
    }
}

/// The force of a contact on a body of another block.
#[derive(Debug, Clone, Copy)]
pub(super) struct OutgoingLoad {
    pub body: BodyId,
    pub load: Load,
}

/// Impulse on a body, besides its loads, of a contact that began or ended within a step, see [`super::contact_events`].
#[derive(Debug, Clone, Copy)]
pub(super) struct Impulse {
    pub body: BodyId,
    /// Of a contact with a wall.
    pub on_wall: Option<OnWall>,
    /// \[N.s\], \[N.m.s\]
    pub wrench: Wrench,
    /// \[N.s\] of |F_n|.
    pub squeeze: f64,
    /// \[N\] |F_n| at its beginning or end.
    pub peak: f64,
}

/// The place of a contact on a wall.
#[derive(Debug, Clone, Copy)]
pub(super) struct OnWall {
    pub face: FaceId,
    /// The panel, if the face has some.
    pub panel: Option<PanelId>,
}

/// The normal force of a contact with a wall.
#[derive(Debug, Clone, Copy)]
pub(super) struct WallForce {
    pub body: BodyId,
    pub on_wall: OnWall,
    /// \[N\] |F_n|.
    pub squeeze: f64,
}

/// The other of a contact, besides the receiver.
#[derive(Debug, Clone, Copy)]
enum Other {
    Body(BodyId),
    Wall(OnWall),
}

/// The sums of an evaluation for the bodies of a block.
pub(super) struct Sums<'a> {
    /// Index of the first body of the block.
    pub start: usize,
    /// Loads of the bodies of the block at this instant.
    pub loads: &'a mut [Load],
    /// Forces on bodies of later blocks.
    pub outgoing: &'a mut Vec<OutgoingLoad>,
    /// Impulses on the bodies of the block, by contacts that began or ended within the last step.
    pub impulses: &'a mut Vec<Impulse>,
    /// The same on bodies of later blocks.
    pub outgoing_impulses: &'a mut Vec<Impulse>,
    /// The contacts with walls at this instant, by body.
    pub wall_forces: &'a mut Vec<WallForce>,
    /// The contacts of chests at this instant, and their impulses.
    pub chest_forces: &'a mut Vec<ChestForce>,
    pub work: &'a mut Work,
}

impl Sums<'_> {
    /// Each force is computed once and applied to both bodies with opposite signs: Newton's third law holds exactly.
    #[inline(always)]
    fn add(&mut self, receiver: BodyId, other: Other, force: &ContactForce) {
        self.work.sliding += u64::from(force.reaction.regime == Regime::Sliding);
        let (vector, squeeze, depth) = (force.vector(), force.reaction.normal.abs(), force.overlap.depth);
        self.give(receiver, Load { wrench: force.on_receiver(vector), squeeze, depth });
        match other {
            Other::Body(giver) => self.give(giver, Load { wrench: force.on_giver(vector), squeeze, depth }),
            Other::Wall(on_wall) => self.wall_forces.push(WallForce { body: receiver, on_wall, squeeze }),
        }
    }

    #[inline(always)]
    fn give(&mut self, body: BodyId, load: Load) {
        match self.loads.get_mut(body.index() - self.start) {
            Some(sum) => sum.add(&load),
            None => self.outgoing.push(OutgoingLoad { body, load }),
        }
    }

    /// A contact that began within a step. Returns what the pair keeps of it, after the evaluation `now`.
    #[cold]
    #[inline(never)]
    fn begin<const LEVELS: bool>(
        &mut self,
        receiver: BodyId,
        other: Other,
        law: &PairLaw,
        began: (ContactForce, ImpulseCorrection),
        share: f64,
        now: u32,
    ) -> Spring {
        let spring = kept(law, &began.0, now);
        let began = shared::<LEVELS>(began, share);
        self.add_impulse(receiver, other, &began);
        self.add(receiver, other, &began.0);
        spring
    }

    /// The impulse of a contact that began or ended within a step, on both bodies.
    #[cold]
    fn add_impulse(
        &mut self,
        receiver: BodyId,
        other: Other,
        (force, by): &(ContactForce, ImpulseCorrection),
    ) {
        let ImpulseCorrection { normal, tangential, squeeze, peak } = *by;
        let impulse = force.overlap.normal * normal + force.overlap.normal.left() * tangential;
        let (on_wall, giver) = match other {
            Other::Wall(on_wall) => (Some(on_wall), None),
            Other::Body(body) => (None, Some(body)),
        };
        let on_receiver =
            Impulse { body: receiver, on_wall, wrench: force.on_receiver(impulse), squeeze, peak };
        let on_giver =
            giver.map(|body| Impulse { body, on_wall, wrench: force.on_giver(impulse), squeeze, peak });
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
            self.give(body, Load { depth, ..Load::default() });
        }
    }
}

impl Instant<'_> {
    /// Sums the contact wrenches of a block's pairs, and lets their springs advance according to `update`. Contacts
    /// that began or ended within the last step give impulses.
    ///
    /// `LEVELS`: whether things have heights. The law is homogeneous: forces over a share of the load length are this share
    /// of the forces, and springs are the same.
    pub fn evaluate<const LEVELS: bool>(
        &self,
        pairs: &mut NearPairs,
        walls: &mut WallContacts,
        update: SpringUpdate,
        sums: &mut Sums,
    ) {
        sums.work.pairs += (pairs.disks.len() + pairs.faces.len()) as u64;
        for start in (0..pairs.disks.len()).step_by(AT_ONCE) {
            self.evaluate_disks::<LEVELS>(pairs, start, update, sums);
        }
        let NearPairs { faces, face_springs, .. } = pairs;
        let mut springs = &mut face_springs[..];
        for of_disk in faces.chunk_by(|one, next| one.disk == next.disk) {
            let (springs_of_disk, others) = springs.split_at_mut(of_disk.len());
            springs = others;
            self.evaluate_walls::<LEVELS>(of_disk, springs_of_disk, walls, update, sums);
        }
    }

    /// The next [`AT_ONCE`] pairs of disks.
    #[inline(always)]
    fn evaluate_disks<const LEVELS: bool>(
        &self,
        pairs: &mut NearPairs,
        start: usize,
        update: SpringUpdate,
        sums: &mut Sums,
    ) {
        let next = start..pairs.disks.len().min(start + AT_ONCE);
        // Of one length, so that one check of an index is enough.
        let (disks, details) = (&pairs.disks[next.clone()], &pairs.disk_details[next.clone()]);
        let springs = &mut pairs.disk_springs[next];
        let mut touching = 0u32;
        for &(k, separation) in self.find_overlapping(disks, &mut pairs.overlapping) {
            let (pair, detail, spring) = (&disks[k], &details[k], &mut springs[k]);
            let (receiver, giver) = (pair.first_body, pair.second_body);
            let geometry = match proximity(separation.between, pair.reach) {
                Proximity::Apart => continue,
                Proximity::Coincident => {
                    sums.add_coincident(receiver, Some(giver), pair.reach);
                    continue;
                }
                Proximity::Touching(overlap) => self.disk_geometry(pair, detail, &separation, overlap),
            };
            let continues = spring.touched_at == self.before;
            let (who, share) = ([detail.first, detail.second], self.share_of_disks::<LEVELS>(detail));
            if let SpringUpdate::Over(step) = update
                && !continues
            {
                // A copy, so that the geometry itself stays in registers.
                let began = self.disks_began(&{ geometry }, step.dt);
                self.watch_chests::<LEVELS>(who, &began.0, Some(&began.1), share, sums);
                self.watch_chests::<LEVELS>(who, &began.0, None, share, sums);
                let (now, giver) = (self.before + 1, Other::Body(giver));
                *spring = sums.begin::<LEVELS>(receiver, giver, geometry.law, began, share, now);
            } else {
                let mut force = contact_force(&geometry, continues.then_some(&*spring), update);
                *spring = kept(geometry.law, &force, self.before + 1);
                self.watch_chests::<LEVELS>(who, &force, None, share, sums);
                if LEVELS {
                    force.scale(share);
                }
                sums.add(receiver, Other::Body(giver), &force);
            }
            touching |= 1 << k;
        }
        sums.work.contacts += u64::from(touching.count_ones());
        let ended = std::mem::replace(&mut pairs.touching[start / AT_ONCE], touching) & !touching;
        if let SpringUpdate::Over(step) = update
            && ended != 0
        {
            self.end_disks::<LEVELS>(pairs, start, ended, step.dt, sums);
        }
    }

    /// The pairs of one disk and the faces near it.
    fn evaluate_walls<const LEVELS: bool>(
        &self,
        pairs: &[FacePair],
        springs: &mut [Spring],
        walls: &mut WallContacts,
        update: SpringUpdate,
        sums: &mut Sums,
    ) {
        let (scene, body) = (self.scene, self.scene.body_of(pairs[0].disk));
        let disk = self.circle(&pairs[0]);
        let on_wall = |face| Other::Wall(OnWall { face, panel: scene.panels.nearest(face, disk.centre) });
        walls.find(scene, pairs, disk, self.kinematics[body.index()].position);
        for contact in walls.found().iter().filter(|contact| contact.overlap.depth > 0.0) {
            let k = contact.place;
            if contact.coincident {
                sums.add_coincident(body, None, contact.overlap.depth);
                continue;
            }
            sums.work.contacts += 1;
            let geometry = self.face_geometry(&pairs[k], contact.overlap, contact.part);
            let face = on_wall(pairs[k].face);
            let (who, share, now) =
                ([pairs[k].disk; 2], self.share_of_face::<LEVELS>(&pairs[k]), self.before + 1);
            let from = walls.keeps(scene, pairs, springs, contact, disk.centre, self.before);
            match (from, update) {
                (Some(from), SpringUpdate::Over(step))
                    if from != k
                        && let Some(passed) =
                            self.passed_bend([&pairs[from], &pairs[k]], contact, &springs[from], step.dt) =>
                {
                    let [ended, began] = passed;
                    springs[from] = Spring::RELAXED;
                    // Only walls of equal heights are joined.
                    self.watch_chests::<LEVELS>(who, &ended.0, Some(&ended.1), share, sums);
                    sums.add_impulse(body, on_wall(pairs[from].face), &shared::<LEVELS>(ended, share));
                    self.watch_chests::<LEVELS>(who, &began.0, Some(&began.1), share, sums);
                    self.watch_chests::<LEVELS>(who, &began.0, None, share, sums);
                    springs[k] = sums.begin::<LEVELS>(body, face, geometry.law, began, share, now);
                }
                (None, SpringUpdate::Over(step)) => {
                    if springs[k].touched_at == self.before
                        && let Some(ended) = self.face_ended(&pairs[k], None, &springs[k], step.dt)
                    {
                        // It touches another part of the same face.
                        self.watch_chests::<LEVELS>(who, &ended.0, Some(&ended.1), share, sums);
                        sums.add_impulse(body, face, &shared::<LEVELS>(ended, share));
                    }
                    let began = self.face_began(&pairs[k], contact, &{ geometry }, step.dt);
                    self.watch_chests::<LEVELS>(who, &began.0, Some(&began.1), share, sums);
                    self.watch_chests::<LEVELS>(who, &began.0, None, share, sums);
                    springs[k] = sums.begin::<LEVELS>(body, face, geometry.law, began, share, now);
                }
                _ => {
                    let mut force = contact_force(&geometry, from.map(|from| &springs[from]), update);
                    if let Some(from) = from {
                        springs[from] = Spring::RELAXED;
                    }
                    springs[k] = kept(geometry.law, &force, now);
                    self.watch_chests::<LEVELS>(who, &force, None, share, sums);
                    if LEVELS {
                        force.scale(share);
                    }
                    sums.add(body, face, &force);
                }
            }
        }
        let SpringUpdate::Over(step) = update else { return };
        for (k, spring) in springs.iter().enumerate().filter(|(_, spring)| spring.touched_at == self.before) {
            let held = walls.found().iter().find(|contact| contact.place == k);
            if let Some(ended) = self.face_ended(&pairs[k], held, spring, step.dt) {
                let share = self.share_of_face::<LEVELS>(&pairs[k]);
                self.watch_chests::<LEVELS>([pairs[k].disk; 2], &ended.0, Some(&ended.1), share, sums);
                sums.add_impulse(body, on_wall(pairs[k].face), &shared::<LEVELS>(ended, share));
            }
        }
    }

    /// Pairs of disks that touched in the evaluation before and do not touch now.
    #[cold]
    fn end_disks<const LEVELS: bool>(
        &self,
        pairs: &NearPairs,
        start: usize,
        ended: u32,
        dt: f64,
        sums: &mut Sums,
    ) {
        for k in places(ended).map(|place| start + place) {
            let (pair, detail, spring) = (&pairs.disks[k], &pairs.disk_details[k], &pairs.disk_springs[k]);
            if let Some(ended) = self.disks_ended(pair, detail, spring, dt) {
                let (who, share) = ([detail.first, detail.second], self.share_of_disks::<LEVELS>(detail));
                self.watch_chests::<LEVELS>(who, &ended.0, Some(&ended.1), share, sums);
                let ended = shared::<LEVELS>(ended, share);
                sums.add_impulse(pair.first_body, Other::Body(pair.second_body), &ended);
            }
        }
    }

    /// Notes the force of a contact, or its impulse besides the force, for the chests that it presses. `who`: the disks; both
    /// are the same at a wall.
    #[inline(always)]
    fn watch_chests<const LEVELS: bool>(
        &self,
        who: [DiskId; 2],
        force: &ContactForce,
        impulse: Option<&ImpulseCorrection>,
        share: f64,
        sums: &mut Sums,
    ) {
        let levels = self.scene.levels.as_deref();
        if LEVELS && let Some(levels) = levels.filter(|levels| levels.watches_chests()) {
            let turn = |disk| self.kinematics[self.scene.body_of(disk).index()].turn();
            sums.chest_forces.extend(levels.chest_forces(self.scene, who, turn, force, impulse, share));
        }
    }

    /// \[1\] The share of the load length over which two disks touch.
    #[inline(always)]
    pub fn share_of_disks<const LEVELS: bool>(&self, detail: &DiskPairDetail) -> f64 {
        let levels = self.scene.levels.as_deref().filter(|_| LEVELS);
        levels.map_or(1.0, |levels| levels.share_of_disks(detail.first, detail.second))
    }

    /// \[1\] The same of a disk and a face.
    #[inline(always)]
    pub fn share_of_face<const LEVELS: bool>(&self, pair: &FacePair) -> f64 {
        let levels = self.scene.levels.as_deref().filter(|_| LEVELS);
        levels.map_or(1.0, |levels| levels.share_of_face(pair.disk, &self.scene.faces[pair.face.index()]))
    }

    /// Finds the overlapping pairs among at most [`AT_ONCE`], and their indices. It has no branches, because processors
    /// cannot predict which pairs touch.
    #[inline(always)]
    fn find_overlapping<'a>(
        &self,
        pairs: &[DiskPair],
        overlapping: &'a mut Overlapping,
    ) -> &'a [(usize, Separation)] {
        let mut found = 0;
        for (k, pair) in pairs.iter().enumerate() {
            let separation = pair.separation(self.kinematics);
            // The remainder shows the compiler that there is room.
            overlapping[found % AT_ONCE] = (k, separation);
            found += usize::from(separation.between.norm_squared() < pair.reach * pair.reach);
        }
        &overlapping[..found]
    }
}

/// The indices of the bits that are set.
fn places(mut bits: u32) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let lowest = bits.trailing_zeros();
        bits &= bits.wrapping_sub(1);
        (lowest < u32::BITS).then_some(lowest as usize)
    })
}

/// Applies the law to a contact: one that keeps a spring, or one that has no past.
#[inline(always)]
pub(super) fn contact_force(
    geometry: &ContactGeometry,
    spring: Option<&Spring>,
    update: SpringUpdate,
) -> ContactForce {
    let ContactGeometry { law, law_at, overlap, .. } = *geometry;
    let (normal_speed, slip_speed) = geometry.speeds();
    let normal = normal_force(law, overlap.depth, normal_speed);
    let reaction = match (spring, update) {
        (Some(spring), SpringUpdate::Over(step)) => {
            let relaxation = &step.relaxations[law_at as usize];
            spring.history.advanced(law, normal, slip_speed, step.dt, relaxation)
        }
        (Some(spring), SpringUpdate::Hold) => react(law, normal, slip_speed, spring.history.elongation),
        (None, _) => react(law, normal, slip_speed, 0.0),
    };
    geometry.with(reaction)
}

/// The share of an event that acts where things have heights.
#[inline(always)]
fn shared<const LEVELS: bool>(
    (mut force, mut by): (ContactForce, ImpulseCorrection),
    share: f64,
) -> (ContactForce, ImpulseCorrection) {
    if LEVELS {
        force.scale(share);
        by.scale(share);
    }
    (force, by)
}

/// Returns what the pair keeps of a contact of the evaluation `now`.
#[inline(always)]
fn kept(law: &PairLaw, force: &ContactForce, now: u32) -> Spring {
    let history = SpringHistory::after(law, &force.reaction, force.slip_speed);
    Spring { history, part: force.part, touched_at: now }
}
