//! When a run is where.

use anyhow::Result;
use lemons_master::{State, System};

/// The communication points of a run: `start + k * step`, never added up, and `until`.
pub struct Clock {
    pub start: f64,
    pub step: f64,
    pub until: f64,
    pub every: u64,
    /// How many steps until the end.
    pub steps: u64,
    /// The last k.
    pub index: u64,
}

impl Clock {
    pub fn new(start: f64, step: f64, until: f64, every: u64) -> Clock {
        let steps = ((until - start) / step - 1e-9).ceil().max(1.0) as u64;
        let mut clock = Clock { start, step, until, every, steps, index: 0 };
        // As every longer run has it: multiples are rounded.
        if (clock.point(steps) - until).abs() <= 1e-9 * step {
            clock.until = clock.point(steps);
        }
        clock
    }

    pub fn point(&self, k: u64) -> f64 {
        self.start + k as f64 * self.step
    }

    /// Where the step after the k-th ends.
    pub fn end(&self, k: u64) -> f64 {
        if k + 1 >= self.steps { self.until } else { self.point(k + 1) }
    }
}

/// The newest communication point from which a run can go on.
pub struct Kept {
    pub states: Vec<State>,
    pub index: u64,
    /// \[s\]
    pub time: f64,
}

impl Kept {
    pub fn of(system: &mut System, clock: &Clock) -> Result<Kept> {
        Ok(Kept { states: system.states()?, index: clock.index, time: system.time() })
    }

    pub fn renew(&mut self, system: &System, clock: &Clock) -> Result<()> {
        (self.index, self.time) = (clock.index, system.time());
        self.states.iter_mut().try_for_each(State::renew)
    }
}
