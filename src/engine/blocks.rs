//! Bodies in blocks of a fixed size, each with the pairs of its bodies: what threads share out.
//!
//! A block is as large for one thread as for many, and forces are summed within it first: so the order of
//! every sum, and with it every bit, is the same for any number of threads.

use super::contacts::{ContactReport, Crossing, Instant, Standing, Stretch, Sums, add_crossing};
use super::neighbours::{Circle, CellGrid, NEAR, list};
use super::pairs::{Candidates, FIRST_EVALUATION, Pairs};
use super::{Scene, State, Threads, Work, Wrench};

/// Bodies of a block: enough that few pairs cross its bounds and that handing it to a thread costs little
/// beside it; few, so that a crowd of a thousand can be shared out. Results change in the last digits with it.
pub(super) const BLOCK: usize = 512;

/// Of the bodies `BLOCK·k` to `BLOCK·(k + 1)`.
#[derive(Debug, Clone, Default)]
pub(super) struct Block {
    candidates: Candidates,
    pairs: Pairs,
    crossing: Vec<Crossing>,
    work: Work,
    /// \[m\] at most so far has a disk moved in the last step.
    pub moved: f64,
}

/// All blocks, and where their bodies are.
#[derive(Debug, Clone, Default)]
pub(super) struct Blocks {
    pub blocks: Vec<Block>,
    /// Of each body.
    pub standing: Vec<Standing>,
    /// By the contacts, of each body, at the present instant; taken by the next kick.
    pub wrenches: Vec<Wrench>,
    /// How many times contacts have been looked at.
    evaluation: u64,
}

impl Blocks {
    pub fn new(scene: &Scene) -> Blocks {
        let bodies = scene.bodies.len();
        Blocks {
            blocks: vec![Block::default(); bodies.div_ceil(BLOCK)],
            standing: vec![Standing::default(); bodies],
            wrenches: vec![Wrench::default(); bodies],
            evaluation: FIRST_EVALUATION,
        }
    }

    /// Holds just the state's springs: what the first list of a communication step starts from.
    pub fn load(&mut self, scene: &Scene, state: &State) {
        self.evaluation = FIRST_EVALUATION;
        for block in &mut self.blocks {
            block.pairs.clear();
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
    pub fn list(
        &mut self,
        scene: &Scene,
        threads: &Threads,
        grid: &CellGrid,
        circles: &[Circle],
        listed: impl Fn(usize) -> bool + Sync,
    ) {
        let standing = &self.standing[..];
        threads.each(self.blocks.iter_mut().enumerate(), |(k, block)| {
            let bodies = (k * BLOCK..((k + 1) * BLOCK).min(circles.len())).filter(|&b| listed(b));
            list(scene, standing, grid, circles, bodies, &mut block.candidates);
        });
    }

    /// Takes the pairs that are near now out of the candidates.
    pub fn renew(&mut self, scene: &Scene, threads: &Threads) {
        let standing = &self.standing[..];
        threads.each(self.blocks.iter_mut(), |block| {
            let Block { candidates, pairs, work, .. } = block;
            work.candidates += (candidates.disks.len() + candidates.faces.len()) as u64;
            pairs.renew(scene, standing, candidates, NEAR);
        });
    }

    /// Adds the contact forces at this instant to the wrenches and lets the springs advance as `stretch` says.
    pub fn evaluate(&mut self, scene: &Scene, threads: &Threads, stretch: Stretch) {
        let instant = Instant { scene, standing: &self.standing, before: self.evaluation };
        let blocks = self.blocks.iter_mut().zip(self.wrenches.chunks_mut(BLOCK)).enumerate();
        threads.each(blocks, |(k, (block, wrenches))| {
            let Block { pairs, crossing, work, .. } = block;
            let mut sums = Sums { start: k * BLOCK, wrenches, crossing, work };
            instant.evaluate(pairs, stretch, &mut sums);
        });
        for block in &mut self.blocks {
            add_crossing(&block.crossing, &mut self.wrenches);
            block.crossing.clear();
        }
        self.evaluation += 1;
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
