//! The progress of a run, and the point from which it can go on.

use crate::clock::Clock;
use crate::error::Result;
use crate::pushes::Pushes;
use crate::saved::{Saved, wiring_of};
use crate::state::State;
use crate::system::System;

/// How far a run is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Progress {
    /// Its communication points.
    pub clock: Clock,
    /// One communication point in so many is recorded, beginning with the first.
    pub every: u64,
    /// The last communication point of the clock that the run has reached.
    pub index: u64,
}

/// The states of all components at a communication point, from which a run can go on. They are held by the FMUs: it must
/// be dropped before the system.
pub struct Kept {
    states: Vec<State>,
    index: u64,
    /// \[s\]
    time: f64,
}

impl Kept {
    /// Takes the states.
    ///
    /// # Errors
    /// An FMU refuses it.
    pub fn of(system: &mut System, progress: &Progress) -> Result<Kept> {
        Ok(Kept { states: system.states()?, index: progress.index, time: system.time() })
    }

    /// Takes the present states instead.
    ///
    /// # Errors
    /// An FMU refuses it.
    pub fn renew(&mut self, system: &System, progress: &Progress) -> Result<()> {
        (self.index, self.time) = (progress.index, system.time());
        self.states.iter_mut().try_for_each(State::renew)
    }

    /// A saved run without records, and the states of its components; `by` are the [`writers`](crate::writers).
    ///
    /// # Errors
    /// A state cannot be written as bytes.
    pub fn saved(
        &self,
        system: &System,
        progress: &Progress,
        pushes: &Pushes,
        by: &str,
    ) -> Result<(Saved, Vec<Vec<u8>>)> {
        let states = self.states.iter().map(State::bytes).collect::<Result<Vec<_>>>()?;
        let Clock { start, step, until, .. } = progress.clock;
        let saved = Saved {
            format: Saved::FORMAT,
            lemons: by.to_owned(),
            start,
            step,
            until,
            index: self.index,
            time: self.time,
            every: progress.every,
            algorithm: system.algorithm().to_string(),
            wiring: wiring_of(system),
            drive: pushes.fingerprint().to_owned(),
            component: Saved::components(system, &states),
            crowd: Vec::new(),
        };
        Ok((saved, states))
    }
}
