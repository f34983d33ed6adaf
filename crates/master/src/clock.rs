//! When a run is where.

use anyhow::{Result, bail};

/// The communication points of a run: `start + k * step`, never added up, and `until`; all \[s\].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Clock {
    /// The first one.
    pub start: f64,
    /// From one to the next.
    pub step: f64,
    /// The last one.
    pub until: f64,
    /// How many steps until the end; the last may be a shorter one.
    pub steps: u64,
}

impl Clock {
    /// Communication steps of a run at most: more take weeks, and their results fill any disk.
    pub const MOST_STEPS: u64 = 1_000_000_000;

    /// The communication points of a run.
    ///
    /// # Errors
    /// There are too many, or the step is lost in rounding.
    pub fn new(start: f64, step: f64, until: f64) -> Result<Clock> {
        let steps = ((until - start) / step - 1e-9).ceil().max(1.0);
        let mut clock = Clock { start, step, until, steps: steps as u64 };
        clock.check_at_most(Clock::MOST_STEPS)?;
        if start + step <= start || until - step >= until {
            bail!("a communication step of {step:?} s is lost in rounding between {start:?} and {until:?} s");
        }
        // As every longer run has it: multiples are rounded.
        if (clock.point(clock.steps) - until).abs() <= 1e-9 * step {
            clock.until = clock.point(clock.steps);
        }
        Ok(clock)
    }

    /// That there are not more steps than this.
    ///
    /// # Errors
    /// There are.
    pub fn check_at_most(&self, most: u64) -> Result<()> {
        if self.steps <= most {
            return Ok(());
        }
        let Clock { start, step, until, .. } = *self;
        let steps = (until - start) / step;
        bail!(
            "from {start:?} to {until:?} s there are {steps:.4e} communication steps of {step:?} s: at most {most:e} are made"
        )
    }

    /// The k-th.
    pub fn point(&self, k: u64) -> f64 {
        self.start + k as f64 * self.step
    }

    /// Where the step after the k-th ends.
    pub fn end(&self, k: u64) -> f64 {
        if k + 1 >= self.steps { self.until } else { self.point(k + 1) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_step_ends_at_the_end() {
        let ends = |clock: Clock| (0..clock.steps).map(|k| clock.end(k)).collect::<Vec<_>>();
        assert_eq!(ends(Clock::new(0.0, 0.1, 0.25).unwrap()), [0.1, 0.2, 0.25]);
        // A multiple but for rounding.
        assert_eq!(ends(Clock::new(0.0, 0.1, 0.3).unwrap()), [0.1, 0.2, 3.0 * 0.1]);
        assert_eq!(ends(Clock::new(2.0, 5.0, 3.0).unwrap()), [3.0]);
    }

    #[test]
    fn endless_runs_are_refused_with_their_number() {
        let said = |start, step, until| Clock::new(start, step, until).unwrap_err().to_string();
        let text =
            "from 0.0 to 1e300 s there are 2.0000e301 communication steps of 0.05 s: at most 1e9 are made";
        assert_eq!(said(0.0, 0.05, 1e300), text);
        assert!(said(-1e308, 1.0, 1e308).contains("communication steps"));
        assert!(said(1e17, 0.05, 1e17 + 64.0).contains("is lost in rounding"));
        assert!(Clock::new(0.0, 1e299, 1e300).is_ok());
    }
}
