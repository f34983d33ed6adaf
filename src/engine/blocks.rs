//! Bodies in blocks of a fixed size, each with the pairs of its bodies: what threads share out.
//!
//! A block is as large for one thread as for many, and forces are summed within it first: so the order of
//! every sum, and with it every bit, is the same for any number of threads.

use super::contacts::{ContactReport, Crossing, Instant, Load, Standing, Stretch, Sums};
use super::exposure::Tally;
use super::neighbours::{CellGrid, Circle, Crowded, Near, Room, list};
use super::pairs::{Candidates, FIRST_EVALUATION, Pairs};
use super::{Pose, Scene, State, Threads, Twist, Work};

/// Bodies of a block: enough that few pairs cross its bounds and that handing it to a thread costs little
/// beside it; few, so that a crowd of a thousand can be shared out. Results change in the last digits with it.
pub(super) const BLOCK: usize = 512;

/// Of the bodies `BLOCK·k` to `BLOCK·(k + 1)`.
#[derive(Debug, Clone, Default)]
pub(super) struct Block {
    candidates: Candidates,
    pairs: Pairs,
    /// For bodies of later blocks.
    outgoing: Vec<Crossing>,
    /// From earlier blocks, in the order of their pairs.
    incoming: Vec<Crossing>,
    /// What was answered of its bodies last.
    answer: f64,
    work: Work,
}

/// All blocks, and where their bodies are.
#[derive(Debug, Clone, Default)]
pub(super) struct Blocks {
    pub blocks: Vec<Block>,
    /// Of each body.
    pub standing: Vec<Standing>,
    /// Of each body.
    pub flown: Vec<Flown>,
    /// By the contacts: of each body where blocks are shared out, else of one block after the other, so that it
    /// stays in the cache.
    loads: Vec<Load>,
    /// How many times contacts have been looked at.
    evaluation: u64,
}

/// What a body has come to during the present communication step.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Flown {
    /// How it moves but for the half kick that the contacts at the present instant will give.
    pub twist: Twist,
    /// Up to the present instant.
    pub tally: Tally,
}

/// The bodies of a block.
pub(super) struct Bodies<'a> {
    /// The first of them.
    pub start: usize,
    pub standing: &'a mut [Standing],
    pub flown: &'a mut [Flown],
    /// By the contacts at the present instant.
    pub loads: &'a [Load],
}

impl Blocks {
    pub fn new(scene: &Scene) -> Blocks {
        let bodies = scene.bodies.len();
        Blocks {
            blocks: vec![Block::default(); bodies.div_ceil(BLOCK)],
            standing: vec![Standing::default(); bodies],
            flown: vec![Flown::default(); bodies],
            loads: vec![Load::default(); bodies],
            evaluation: FIRST_EVALUATION,
        }
    }

    /// Puts a body at a pose.
    pub fn put(&mut self, body: usize, pose: Pose, twist: Twist) {
        self.standing[body] = Standing::at(pose, twist);
        self.flown[body].twist = twist;
    }

    /// Holds just the state's springs, and nothing added up: what a communication step starts from.
    pub fn load(&mut self, scene: &Scene, state: &State) {
        self.evaluation = FIRST_EVALUATION;
        self.flown.iter_mut().for_each(|flown| flown.tally = Tally::default());
        for block in &mut self.blocks {
            block.pairs.clear();
            // Empty, unless somebody has caught a panic.
            block.outgoing.clear();
            block.incoming.clear();
        }
        for known in &state.disk_springs {
            self.blocks[scene.body_of(known.first).index() / BLOCK].pairs.load_disks(scene, known);
        }
        for known in &state.face_springs {
            self.blocks[scene.body_of(known.disk).index() / BLOCK].pairs.load_face(known);
        }
    }

    /// Writes the springs of the touching pairs into the state.
    pub fn store(&self, state: &mut State) {
        state.disk_springs.clear();
        state.face_springs.clear();
        for block in &self.blocks {
            block.pairs.store(self.evaluation, state);
        }
    }

    /// Lists the candidates of some bodies, `circles` of all of them being in the grid.
    ///
    /// # Errors
    /// They are more than are held.
    pub fn list(
        &mut self,
        scene: &Scene,
        threads: &Threads,
        grid: &CellGrid,
        circles: &[Circle],
        listed: impl Fn(usize) -> bool + Sync,
    ) -> Result<(), Crowded> {
        let room = Room::new(scene);
        let standing = &self.standing[..];
        threads.each(self.blocks.iter_mut().enumerate(), |(k, block)| {
            let bodies = (k * BLOCK..((k + 1) * BLOCK).min(circles.len())).filter(|&b| listed(b));
            list(scene, standing, grid, circles, bodies, &mut block.candidates, &room);
        });
        room.check(scene, grid, circles)
    }

    /// Takes the pairs that are near now out of the candidates.
    pub fn renew(&mut self, scene: &Scene, threads: &Threads, near: Near) {
        let standing = &self.standing[..];
        threads.each(self.blocks.iter_mut(), |block| {
            let Block { candidates, pairs, work, .. } = block;
            work.candidates += (candidates.disks.len() + candidates.faces.len()) as u64;
            pairs.renew(scene, standing, candidates, near.0);
        });
    }

    /// Sums the contact forces at this instant and lets the springs advance as `stretch` says; then does
    /// something with the bodies of every block, and answers the largest answer.
    ///
    /// One thread does it block by block, while each is in the cache: that a block's bodies move on does not
    /// disturb the later ones, for a pair of two blocks is with the first.
    pub fn evaluate(
        &mut self,
        scene: &Scene,
        threads: &Threads,
        stretch: Stretch,
        then: impl Fn(usize, Bodies) -> f64 + Send + Sync,
    ) -> f64 {
        let before = self.evaluation;
        self.evaluation += 1;
        let Blocks { blocks, standing, flown, loads, .. } = self;
        if threads.count() == 1 {
            for k in 0..blocks.len() {
                let of_block = k * BLOCK..standing.len().min((k + 1) * BLOCK);
                let (start, loads) = (of_block.start, &mut loads[..of_block.len()]);
                blocks[k].evaluate(&Instant { scene, standing, before }, stretch, start, loads);
                hand_over(blocks, k);
                blocks[k].take_in(start, loads);
                let (standing, flown) = (&mut standing[of_block.clone()], &mut flown[of_block]);
                blocks[k].answer = then(k, Bodies { start, standing, flown, loads });
            }
        } else {
            let instant = Instant { scene, standing, before };
            let each = blocks.iter_mut().zip(loads.chunks_mut(BLOCK)).enumerate();
            threads.each(each, |(k, (block, loads))| {
                block.evaluate(&instant, stretch, k * BLOCK, loads);
            });
            (0..blocks.len()).for_each(|k| hand_over(blocks, k));
            let each = blocks.iter_mut().zip(standing.chunks_mut(BLOCK)).enumerate();
            let each = each.zip(flown.chunks_mut(BLOCK).zip(loads.chunks_mut(BLOCK)));
            threads.each(each, |((k, (block, standing)), (flown, loads))| {
                block.take_in(k * BLOCK, loads);
                block.answer = then(k, Bodies { start: k * BLOCK, standing, flown, loads });
            });
        }
        blocks.iter().map(|block| block.answer).fold(0.0, f64::max)
    }

    /// The contacts as they are now; changes nothing.
    pub fn report(&self, scene: &Scene) -> ContactReport {
        let instant = Instant { scene, standing: &self.standing, before: self.evaluation };
        instant.report(self.blocks.iter().map(|block| &block.pairs))
    }

    /// The work done since it was last asked for.
    pub fn take_work(&mut self) -> Work {
        self.blocks.iter_mut().map(|block| std::mem::take(&mut block.work)).sum()
    }
}

impl Block {
    /// Sums the forces of its own pairs; what crosses its bounds waits to be handed over.
    fn evaluate(&mut self, instant: &Instant, stretch: Stretch, start: usize, loads: &mut [Load]) {
        let Block { pairs, outgoing, work, .. } = self;
        loads.fill(Load::default());
        instant.evaluate(pairs, stretch, &mut Sums { start, loads, outgoing, work });
    }

    /// Adds what was handed over; then the forces are complete.
    fn take_in(&mut self, start: usize, loads: &mut [Load]) {
        for Crossing { body, load } in self.incoming.drain(..) {
            loads[body.index() - start].add(&load);
        }
    }
}

/// Hands over what crosses the bounds of a block; one after the other, so that each gets it in order.
#[inline(always)]
fn hand_over(blocks: &mut [Block], k: usize) {
    if blocks[k].outgoing.is_empty() {
        return;
    }
    let mut outgoing = std::mem::take(&mut blocks[k].outgoing);
    for crossing in outgoing.drain(..) {
        blocks[crossing.body.index() / BLOCK].incoming.push(crossing);
    }
    blocks[k].outgoing = outgoing;
}
