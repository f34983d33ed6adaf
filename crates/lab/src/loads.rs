//! The load on parts of people: on chests, and at each level. Frames have it only where there are chests or levels.

use crowd_mechanics::engine::{Pair, World};
use lemons_core::trial::{Heights, Trial};
use lemons_results::Frame;
use lemons_results::columns::Effect;

/// Most levels that are told apart.
const MOST: usize = 10;
/// Of a chest, in this order.
const CHEST: [Effect; 5] =
    [Effect::ChestForce, Effect::ChestWallForce, Effect::ChestFront, Effect::ChestSide, Effect::ChestLeast];

/// What is found of a Trial.
#[derive(Debug, Clone, PartialEq)]
pub struct Loads {
    /// Whether the load on chests is found.
    pub chests: bool,
    /// Heights that have none in common, of which each disk is in one; none in the plan.
    pub levels: Vec<Heights>,
    /// The level of each disk.
    of_disks: Vec<usize>,
}

impl Loads {
    /// Of people in a Trial, and of their bodies.
    pub fn of(trial: &Trial, world: &World) -> Loads {
        let disks: Vec<Heights> =
            trial.agents.iter().flat_map(|agent| &agent.shapes).map(|disk| disk.heights).collect();
        let levels = levels(&disks);
        let level = |disk: &Heights| levels.iter().position(|level| level.hold(disk.bottom));
        let of_disks = disks.iter().map(|disk| level(disk).unwrap_or_default()).collect();
        Loads { chests: !world.chest_exposures().is_empty(), levels, of_disks }
    }

    /// Returns how many levels are told apart: one is the whole body.
    fn told(&self) -> usize {
        if self.levels.len() > 1 { self.levels.len() } else { 0 }
    }

    /// Returns how many numbers a frame has of each agent besides.
    pub fn columns(&self) -> usize {
        if self.chests || self.told() > 0 { CHEST.len() + self.told() } else { 0 }
    }

    /// Returns these numbers \[N\], those of all agents for each in turn. Of chests they are means over the last communication
    /// step: the sum of |F_n|, its part by walls, the compression along the gaze, across it, and its smaller principal part.
    /// Then comes, for each level from the lowest, the sum of |F_n| over the contacts of the disks there at the end of the
    /// step.
    pub fn numbers(&self, frame: &Frame, world: &World) -> Vec<f64> {
        let people = frame.agents.len();
        if self.columns() == 0 {
            return Vec::new();
        }
        let chest =
            |effect| (0..people).map(move |agent| frame.effects.get(effect, agent).unwrap_or_default());
        let mut numbers: Vec<f64> = CHEST.into_iter().flat_map(chest).collect();
        let first = numbers.len();
        numbers.resize(people * self.columns(), 0.0);
        let at_levels = &mut numbers[first..];
        for contact in world.contacts().contacts.iter().filter(|_| self.told() > 0) {
            let disks = match contact.pair {
                Pair::Disks { first, second } => [Some(first), Some(second)],
                Pair::Face { disk, .. } => [Some(disk), None],
            };
            for disk in disks.into_iter().flatten() {
                let (level, agent) = (self.of_disks[disk.index()], world.scene().body_of(disk).index());
                at_levels[people * level + agent] += contact.normal_force.abs();
            }
        }
        numbers
    }
}

/// Returns the levels of disks: those that have a height in common are in one.
fn levels(disks: &[Heights]) -> Vec<Heights> {
    let mut sorted = disks.to_vec();
    sorted.sort_by(|one, other| one.bottom.total_cmp(&other.bottom));
    let mut levels: Vec<Heights> = Vec::new();
    for disk in sorted {
        match levels.last_mut().filter(|last| disk.bottom < last.top) {
            Some(last) => last.top = last.top.max(disk.top),
            None => levels.push(disk),
        }
    }
    if disks.iter().all(Heights::is_all) {
        levels.clear();
    }
    if levels.len() > MOST {
        let whole = Heights { bottom: levels[0].bottom, top: levels[levels.len() - 1].top };
        levels = vec![whole];
    }
    levels
}
