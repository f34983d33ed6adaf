//! When a run is where.

use anyhow::Result;
use lemons_master::{Clock, State, System};

/// How far a run is.
pub struct Progress {
    pub clock: Clock,
    /// Communication points of which one is written.
    pub every: u64,
    /// The last one that the run has reached.
    pub index: u64,
}

/// The newest communication point from which a run can go on.
pub struct Kept {
    pub states: Vec<State>,
    pub index: u64,
    /// \[s\]
    pub time: f64,
}

impl Kept {
    pub fn of(system: &mut System, progress: &Progress) -> Result<Kept> {
        Ok(Kept { states: system.states()?, index: progress.index, time: system.time() })
    }

    pub fn renew(&mut self, system: &System, progress: &Progress) -> Result<()> {
        (self.index, self.time) = (progress.index, system.time());
        self.states.iter_mut().try_for_each(State::renew)
    }
}
