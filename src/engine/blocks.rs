//! Bodies in blocks of a fixed size, each with the pairs of its bodies: the units of work for threads.
//!
//! The size of a block does not depend on the number of threads, and forces are first summed within blocks. So the
//! order of every sum, and with it every bit of the results, is the same for any number of threads.

use super::body_kinematics::BodyKinematics;
use super::broad_phase::{CellGrid, Crowded, Listing, PairLimit, list, moved_further, skin_for};
use super::circle::Circle;
use super::contact_geometry::Instant;
use super::contacts::{Impulse, Load, OnWall, OutgoingLoad, SpringUpdate, Sums, WallForce};
use super::exposure::{ExposureSum, Exposures, FaceSum};
use super::levels::{ChestForce, ChestSum};
use super::near_pairs::{Candidates, FIRST_EVALUATION, NearPairs};
use super::report::ContactReport;
use super::wall_contacts::WallContacts;
use super::{Body, ContactDisk, Pair, Pose, Rotation, Scene, State, Threads, Twist, Vec2, Work, vec2};
use std::ops::Range;

/// Number of bodies of a block. It is large enough that few pairs connect two blocks and that giving it to a thread is
/// cheap, and small enough that a crowd of a thousand can be shared. It affects the last digits of results.
pub(super) const BLOCK: usize = 512;

/// Where a body was when its candidates were listed.
#[derive(Debug, Clone, Copy)]
struct Listed {
    pose: Pose,
    turn: Rotation,
    /// \[m\] See [`skin_for`].
    skin: f64,
}

impl Listed {
    /// Returns the value of a body that is not listed. Its pose is not a number, which counts as moved.
    fn nowhere() -> Listed {
        let pose = Pose { position: vec2(f64::NAN, f64::NAN), orientation: f64::NAN };
        Listed { pose, turn: Rotation::identity(), skin: 0.0 }
    }
}

/// The pairs of the bodies `BLOCK·k` to `BLOCK·(k + 1)`.
#[derive(Debug, Clone, Default)]
pub(super) struct Block {
    candidates: Candidates,
    /// Whether bodies that were not listed before the last time may have near pairs in it.
    joined: bool,
    pairs: NearPairs,
    /// Scratch space.
    walls: WallContacts,
    /// Forces on bodies of later blocks.
    outgoing: Vec<OutgoingLoad>,
    /// Forces from earlier blocks, in the order of their pairs.
    incoming: Vec<OutgoingLoad>,
    /// Impulses on its bodies by contacts that began or ended within the last step.
    impulses: Vec<Impulse>,
    /// The same on bodies of later blocks, and from earlier blocks.
    outgoing_impulses: Vec<Impulse>,
    incoming_impulses: Vec<Impulse>,
    /// The contacts of its bodies with walls at the present instant, by body.
    wall_forces: Vec<WallForce>,
    /// The contacts of chests at the present instant.
    chest_forces: Vec<ChestForce>,
    /// The last values returned for its bodies.
    result: [f64; 2],
    work: Work,
}

/// Which blocks get a new list of near pairs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Renewed {
    /// All of them.
    All,
    /// Those in which bodies that joined may have near pairs.
    Joined,
}

/// All blocks and the motion of their bodies.
#[derive(Debug, Clone, Default)]
pub(super) struct Blocks {
    pub blocks: Vec<Block>,
    /// One for each body.
    pub kinematics: Vec<BodyKinematics>,
    /// One for each body.
    pub flown: Vec<Flown>,
    /// \[m\] For each body the margin of its near pairs; not a number for those that do not move by mechanical steps.
    pub margins: Vec<f64>,
    /// Where bodies were when their near pairs were listed, one for each.
    pub near_at: Vec<Pose>,
    /// Where bodies were when their candidates were listed.
    listed: Vec<Listed>,
    /// Scratch space: all disks, larger by a skin or a margin.
    enlarged: Vec<Circle>,
    /// \[N.s\] For each body the impulse by walls since [`Blocks::load`]: few bodies touch one.
    pub by_walls: Vec<f64>,
    /// For each face the sums since then.
    pub faces: Vec<FaceSum>,
    /// The same for each panel.
    pub panels: Vec<FaceSum>,
    /// The same for each chest, if some are watched.
    pub chests: Vec<ChestSum>,
    /// Loads by the contacts: of all bodies if several threads work, else of one block at a time, so that they stay in
    /// the cache.
    loads: Vec<Load>,
    /// Number of evaluations of the contacts.
    evaluation: u32,
}

/// The intermediate motion of a body within the present communication step.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Flown {
    /// Its twist, without the half kick by the contacts at the present instant.
    pub twist: Twist,
    /// The sums up to the present instant.
    pub exposure_sum: ExposureSum,
}

/// The bodies of a block.
pub(super) struct Bodies<'a> {
    /// Index of the first of them.
    pub start: usize,
    pub kinematics: &'a mut [BodyKinematics],
    pub flown: &'a mut [Flown],
    /// Loads by the contacts at the present instant. Who uses one takes it: all are zero at the next instant.
    pub loads: &'a mut [Load],
    /// Impulses by contacts that began or ended within the last step, besides the loads.
    pub impulses: &'a [Impulse],
}

impl Blocks {
    pub fn new(scene: &Scene) -> Blocks {
        let bodies = scene.bodies.len();
        Blocks {
            blocks: vec![Block::default(); bodies.div_ceil(BLOCK)],
            kinematics: vec![BodyKinematics::default(); bodies],
            flown: vec![Flown::default(); bodies],
            margins: vec![0.0; bodies],
            near_at: vec![Pose::default(); bodies],
            listed: vec![Listed::nowhere(); bodies],
            enlarged: vec![Circle { centre: Vec2::zeros(), radius: 0.0 }; scene.disks.len()],
            by_walls: vec![0.0; bodies],
            faces: vec![FaceSum::default(); scene.faces.len()],
            panels: vec![FaceSum::default(); scene.panels.count()],
            chests: ChestSum::of(scene),
            loads: vec![Load::default(); bodies],
            evaluation: FIRST_EVALUATION,
        }
    }

    /// Sets pose and twist of a body.
    pub fn put(&mut self, body: usize, pose: Pose, twist: Twist) {
        self.kinematics[body] = BodyKinematics::at(pose, twist);
        self.flown[body].twist = twist;
    }

    /// Takes the springs of a state and resets all sums, to begin a communication step.
    pub fn load(&mut self, scene: &Scene, state: &State) {
        self.evaluation = FIRST_EVALUATION;
        self.flown.iter_mut().for_each(|flown| flown.exposure_sum = ExposureSum::default());
        self.by_walls.fill(0.0);
        // Already zero, unless a panic was caught.
        self.loads.fill(Load::default());
        self.faces.fill(FaceSum::default());
        self.panels.fill(FaceSum::default());
        self.chests.fill(ChestSum::default());
        for block in &mut self.blocks {
            block.pairs.clear();
            // Already empty, unless a panic was caught.
            block.outgoing.clear();
            block.incoming.clear();
            block.outgoing_impulses.clear();
            block.incoming_impulses.clear();
        }
        for known in &state.disk_springs {
            self.blocks[scene.body_of(known.first).index() / BLOCK].pairs.load_disks(scene, known);
        }
        for known in &state.face_springs {
            self.blocks[scene.body_of(known.disk).index() / BLOCK].pairs.load_face(known);
        }
    }

    /// Writes the springs of touching pairs into the state.
    pub fn store(&self, state: &mut State) {
        state.disk_springs.clear();
        state.face_springs.clear();
        for block in &self.blocks {
            block.pairs.store(self.evaluation, state);
        }
    }

    /// Forgets all candidates: bodies or walls come or go, or bodies are put elsewhere.
    pub fn forget_candidates(&mut self) {
        self.listed.fill(Listed::nowhere());
        self.blocks.iter_mut().for_each(|block| block.candidates = Candidates::default());
    }

    /// Lists the candidates of some bodies, anew for those that have moved too far; returns their number.
    ///
    /// # Errors
    /// There are more candidates than the limit.
    pub fn list(
        &mut self,
        scene: &Scene,
        threads: &Threads,
        listed: impl Fn(usize) -> bool + Sync,
    ) -> Result<u64, Crowded> {
        let mut anew = vec![false; scene.bodies.len()];
        let mut moved = Vec::new();
        self.blocks.iter_mut().for_each(|block| block.joined = false);
        for (b, body) in scene.bodies.iter().enumerate() {
            if !listed(b) {
                self.listed[b] = Listed::nowhere();
                continue;
            }
            let (now, margin, listed) = (&self.kinematics[b], self.margins[b], &mut self.listed[b]);
            if moved_further(listed.skin - margin, body.reach, &listed.pose, &now.pose()) {
                moved.push((b, listed.pose.orientation.is_nan()));
                *listed = Listed { pose: now.pose(), turn: now.turn(), skin: skin_for(margin) };
                anew[b] = true;
            }
        }
        if moved.is_empty() {
            return Ok(0);
        }
        let circle = |(listed, body): (&Listed, &Body)| Circle {
            centre: listed.pose.position,
            radius: body.bounding_radius + listed.skin,
        };
        let circles: Vec<Circle> = self.listed.iter().zip(&scene.bodies).map(circle).collect();
        let there = &self.listed[..];
        enlarge(scene, threads, &mut self.enlarged, |b, disk| {
            let Listed { pose, turn, skin } = &there[b];
            Circle { centre: pose.position + *turn * disk.offset, radius: disk.radius + skin }
        });
        let who = (0..circles.len()).filter(|&b| listed(b));
        let grid = CellGrid::new(&circles, who, 0.0);
        let now = |b: usize| Circle {
            centre: self.kinematics[b].position,
            radius: scene.bodies[b].bounding_radius + self.margins[b],
        };
        for &(b, joins) in &moved {
            self.blocks[b / BLOCK].joined |= joins;
            grid.for_each_near(&circles[b], 0.0, |other| {
                if other < b {
                    anew[other] = true;
                    // By where they are now: where they were listed depends on what was before.
                    self.blocks[other / BLOCK].joined |= joins && now(other).nears(&now(b), 0.0);
                }
            });
        }
        let (limit, disks) = (PairLimit::new(scene), &self.enlarged[..]);
        threads.each(self.blocks.iter_mut().enumerate(), |(k, block)| {
            let bodies = k * BLOCK..((k + 1) * BLOCK).min(circles.len());
            if !anew[bodies.clone()].contains(&true) {
                // Some may be pairs of bodies that are not listed any more: these are never near.
                limit.take(block.candidates.count());
                return;
            }
            let bodies = bodies.filter(|&b| listed(b));
            let bodies = bodies.map(|b| (b, if anew[b] { Listing::Anew } else { Listing::Kept }));
            list(scene, disks, &grid, &circles, bodies, &mut block.candidates, &limit);
        });
        limit.check(scene, &grid, &circles).inspect_err(|_| self.forget_candidates())?;
        Ok(moved.len() as u64)
    }

    /// Makes the lists of near pairs from the candidates: of all blocks, or of those in which bodies that
    /// [`Blocks::list`] did not list before may have some.
    pub fn renew(&mut self, scene: &Scene, threads: &Threads, which: Renewed) {
        let (kinematics, margins, evaluation) = (&self.kinematics[..], &self.margins[..], self.evaluation);
        enlarge(scene, threads, &mut self.enlarged, |b, disk| Circle {
            centre: kinematics[b].centre(disk.offset),
            radius: disk.radius + margins[b],
        });
        let (blocks, enlarged) = (self.blocks.iter_mut(), &self.enlarged[..]);
        threads.each(blocks.filter(|block| which == Renewed::All || block.joined), |block| {
            let Block { candidates, pairs, work, .. } = block;
            work.candidates += candidates.count() as u64;
            pairs.renew(scene, enlarged, candidates, evaluation);
        });
    }

    /// Sums the contact forces at this instant, and lets the springs advance according to `update`. Then it applies a
    /// function to the bodies of every block and returns the largest results. The instant counts for a `duration` \[s\]
    /// in the sums of walls.
    ///
    /// A single thread processes block by block, while each is in the cache. Moving the bodies of a block does not
    /// disturb later blocks, because a pair of two blocks belongs to the first one.
    pub fn evaluate(
        &mut self,
        scene: &Scene,
        threads: &Threads,
        update: SpringUpdate,
        duration: f64,
        then: impl Fn(usize, Bodies) -> [f64; 2] + Send + Sync,
    ) -> [f64; 2] {
        let before = self.evaluation;
        // 32 bits, so that a spring has 32 bytes. A communication step has fewer mechanical steps (`MOST_STEPS`).
        self.evaluation += 1;
        let Blocks { blocks, kinematics, flown, by_walls, faces, panels, chests, loads, .. } = self;
        if threads.count() == 1 {
            for k in 0..blocks.len() {
                let of_block = k * BLOCK..kinematics.len().min((k + 1) * BLOCK);
                let (start, loads) = (of_block.start, &mut loads[..of_block.len()]);
                let instant = Instant { scene, kinematics, before };
                blocks[k].evaluate(&instant, update, start, loads);
                if blocks.len() > 1 {
                    hand_over(blocks, k);
                    blocks[k].take_in(start, loads);
                }
                blocks[k].add_walls(start, &mut by_walls[of_block.clone()], duration);
                let (kinematics, flown) = (&mut kinematics[of_block.clone()], &mut flown[of_block]);
                let block = &mut blocks[k];
                let impulses = &block.impulses[..];
                block.result = then(k, Bodies { start, kinematics, flown, loads, impulses });
            }
        } else {
            let instant = Instant { scene, kinematics, before };
            let each = blocks.iter_mut().zip(loads.chunks_mut(BLOCK)).enumerate();
            threads.each(each, |(k, (block, loads))| {
                block.evaluate(&instant, update, k * BLOCK, loads);
            });
            (0..blocks.len()).for_each(|k| hand_over(blocks, k));
            let each = blocks.iter_mut().zip(kinematics.chunks_mut(BLOCK)).enumerate();
            let loads = loads.chunks_mut(BLOCK).zip(by_walls.chunks_mut(BLOCK));
            let each = each.zip(flown.chunks_mut(BLOCK).zip(loads));
            threads.each(each, |((k, (block, kinematics)), (flown, (loads, by_walls)))| {
                block.take_in(k * BLOCK, loads);
                block.add_walls(k * BLOCK, by_walls, duration);
                let impulses = &block.impulses[..];
                block.result = then(k, Bodies { start: k * BLOCK, kinematics, flown, loads, impulses });
            });
        }
        add_faces(blocks, faces, duration, |on_wall| Some(on_wall.face.index()));
        if !panels.is_empty() {
            add_faces(blocks, panels, duration, |on_wall| Some(on_wall.panel?.index()));
        }
        if !chests.is_empty() {
            let forces = blocks.iter().flat_map(|block| &block.chest_forces);
            ChestSum::add_all(chests, forces, duration);
        }
        let largest = |one: [f64; 2], block: &Block| [0, 1].map(|k| one[k].max(block.result[k]));
        blocks.iter().fold([0.0; 2], largest)
    }

    /// Whether the bits of touching pairs are those of the springs of the last evaluation, and how many pairs there are.
    #[cfg(test)]
    pub fn marked(&self) -> (bool, usize) {
        let count = |block: &Block| block.pairs.disks.len() + block.pairs.faces.len();
        let marked = self.blocks.iter().all(|block| block.pairs.marked(self.evaluation));
        (marked, self.blocks.iter().map(count).sum())
    }

    /// Returns the contacts at present; changes nothing.
    pub fn report(&self, scene: &Scene) -> ContactReport {
        let instant = Instant { scene, kinematics: &self.kinematics, before: self.evaluation };
        instant.report(self.blocks.iter().map(|block| &block.pairs))
    }

    /// Returns the exposures over a duration \[s\], from the sums and the contacts at its end.
    pub fn exposures(&self, scene: &Scene, duration: f64, contacts: &ContactReport) -> Exposures {
        let bodies = self.flown.iter().zip(&self.by_walls).zip(&contacts.bodies);
        let bodies = bodies.map(|((of, by_walls), end)| of.exposure_sum.exposure(duration, *by_walls, end));
        let mut faces = vec![0.0; self.faces.len()];
        let mut panels = vec![0.0; self.panels.len()];
        for contact in &contacts.contacts {
            let Pair::Face { disk, face, .. } = contact.pair else { continue };
            faces[face.index()] += contact.normal_force.abs();
            if panels.is_empty() {
                continue;
            }
            let ContactDisk { body, offset, .. } = scene.disks[disk.index()];
            let centre = self.kinematics[body.index()].centre(offset);
            if let Some(panel) = scene.panels.nearest(face, centre) {
                panels[panel.index()] += contact.normal_force.abs();
            }
        }
        let faces = self.faces.iter().zip(faces).map(|(sum, end)| sum.exposure(duration, end));
        let panels = self.panels.iter().zip(panels).map(|(sum, end)| sum.share(duration, end));
        let chests = ChestSum::exposures(&self.chests, scene, duration, contacts);
        Exposures { bodies: bodies.collect(), faces: faces.collect(), panels: panels.collect(), chests }
    }

    /// Returns the work since the last call.
    pub fn take_work(&mut self) -> Work {
        self.blocks.iter_mut().map(|block| std::mem::take(&mut block.work)).sum()
    }
}

impl Block {
    /// Sums the forces of its own pairs; forces on bodies of later blocks are kept for them.
    fn evaluate(&mut self, instant: &Instant, update: SpringUpdate, start: usize, loads: &mut [Load]) {
        let Block {
            pairs,
            walls,
            outgoing,
            impulses,
            outgoing_impulses,
            wall_forces,
            chest_forces,
            work,
            ..
        } = self;
        debug_assert!(loads.iter().all(|load| load.squeeze == 0.0 && load.depth == 0.0), "not taken");
        impulses.clear();
        wall_forces.clear();
        chest_forces.clear();
        let mut sums =
            Sums { start, loads, outgoing, impulses, outgoing_impulses, wall_forces, chest_forces, work };
        if instant.scene.levels.is_some() {
            instant.evaluate::<true>(pairs, walls, update, &mut sums);
        } else {
            instant.evaluate::<false>(pairs, walls, update, &mut sums);
        }
    }

    /// Adds the forces from earlier blocks. After that the forces are complete.
    fn take_in(&mut self, start: usize, loads: &mut [Load]) {
        for OutgoingLoad { body, load } in self.incoming.drain(..) {
            loads[body.index() - start].add(&load);
        }
        if !self.incoming_impulses.is_empty() {
            self.impulses.append(&mut self.incoming_impulses);
        }
    }

    /// Adds the impulses by walls of this instant, which counts for a `duration` \[s\], to those of its bodies. The sums
    /// have the order of [`ExposureSum`], so that the two are the same for a body that touches only walls.
    fn add_walls(&self, start: usize, by_walls: &mut [f64], duration: f64) {
        for impulse in self.impulses.iter().filter(|impulse| impulse.on_wall.is_some()) {
            by_walls[impulse.body.index() - start] += impulse.squeeze;
        }
        for of_body in self.wall_forces.chunk_by(|one, next| one.body == next.body) {
            let squeeze = of_body.iter().fold(0.0, |sum, force| sum + force.squeeze);
            by_walls[of_body[0].body.index() - start] += squeeze * duration;
        }
    }
}

/// Makes circles of the disks of all bodies.
fn enlarge(
    scene: &Scene,
    threads: &Threads,
    circles: &mut [Circle],
    circle: impl Fn(usize, &ContactDisk) -> Circle + Send + Sync,
) {
    let of_blocks =
        scene.bodies.chunks(BLOCK).map(|bodies| bodies[0].disks.start..bodies[bodies.len() - 1].disks.end);
    threads.each(split(circles, of_blocks), |(disks, circles)| {
        for (to, disk) in circles.iter_mut().zip(&scene.disks[disks]) {
            *to = circle(disk.body.index(), disk);
        }
    });
}

/// Splits a slice into ranges that follow each other.
fn split<T>(
    all: &mut [T],
    ranges: impl Iterator<Item = Range<usize>>,
) -> impl Iterator<Item = (Range<usize>, &mut [T])> {
    let mut rest = all;
    ranges.map(move |range| {
        let (part, others) = std::mem::take(&mut rest).split_at_mut(range.len());
        rest = others;
        (range, part)
    })
}

/// Adds the forces and impulses on walls at this instant, which counts for a `duration` \[s\], to the sums of their faces or
/// panels, in the order of blocks.
fn add_faces(
    blocks: &[Block],
    sums: &mut [FaceSum],
    duration: f64,
    place: impl Fn(&OnWall) -> Option<usize>,
) {
    let forces = || blocks.iter().flat_map(|block| &block.wall_forces);
    for (force, k) in forces().filter_map(|force| Some((force, place(&force.on_wall)?))) {
        sums[k].add(force.squeeze);
    }
    for k in forces().filter_map(|force| place(&force.on_wall)) {
        // Where there are several contacts the further ones add nothing.
        sums[k].end_instant(duration);
    }
    for impulse in blocks.iter().flat_map(|block| &block.impulses) {
        if let Some(k) = impulse.on_wall.as_ref().and_then(&place) {
            sums[k].add_impulse(impulse);
        }
    }
}

/// Passes forces and impulses on bodies of later blocks on, block by block, so that each receives them in order.
#[inline(always)]
fn hand_over(blocks: &mut [Block], k: usize) {
    if !blocks[k].outgoing.is_empty() {
        let mut outgoing = std::mem::take(&mut blocks[k].outgoing);
        for crossing in outgoing.drain(..) {
            blocks[crossing.body.index() / BLOCK].incoming.push(crossing);
        }
        blocks[k].outgoing = outgoing;
    }
    if !blocks[k].outgoing_impulses.is_empty() {
        hand_over_impulses(blocks, k);
    }
}

#[cold]
fn hand_over_impulses(blocks: &mut [Block], k: usize) {
    let mut outgoing = std::mem::take(&mut blocks[k].outgoing_impulses);
    for impulse in outgoing.drain(..) {
        blocks[impulse.body.index() / BLOCK].incoming_impulses.push(impulse);
    }
    blocks[k].outgoing_impulses = outgoing;
}
