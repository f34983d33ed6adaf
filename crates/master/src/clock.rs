//! The communication points of a run.

/// Why there are no such communication points.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum ClockError {
    /// More of them than are made.
    #[error(
        "from {start:?} to {until:?} s there are {:.4e} communication steps of {step:?} s: at most {most:e} are made",
        (until - start) / step
    )]
    TooMany {
        /// \[s\]
        start: f64,
        /// \[s\]
        step: f64,
        /// \[s\]
        until: f64,
        /// How many are made.
        most: u64,
    },
    /// The step is less than what times of this size are rounded by.
    #[error("a communication step of {step:?} s is lost in rounding between {start:?} and {until:?} s")]
    Lost {
        /// \[s\]
        start: f64,
        /// \[s\]
        step: f64,
        /// \[s\]
        until: f64,
    },
}

/// The communication points of a run: `start + k * step`, never sums, and `until`; all in \[s\].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Clock {
    /// The first one.
    pub start: f64,
    /// The communication step.
    pub step: f64,
    /// The last one.
    pub until: f64,
    /// The number of steps until the end; the last one may be shorter.
    pub steps: u64,
}

impl Clock {
    /// Greatest number of communication steps of a run: more take weeks, and their results fill any disk.
    pub const MOST_STEPS: u64 = 1_000_000_000;

    /// The communication points of a run.
    ///
    /// # Errors
    /// There are too many, or the step is lost in rounding.
    pub fn new(start: f64, step: f64, until: f64) -> Result<Clock, ClockError> {
        let steps = ((until - start) / step - 1e-9).ceil().max(1.0);
        let mut clock = Clock { start, step, until, steps: steps as u64 };
        clock.check_at_most(Clock::MOST_STEPS)?;
        if start + step <= start || until - step >= until {
            return Err(ClockError::Lost { start, step, until });
        }
        // As every longer run has it: multiples are rounded.
        if (clock.point(clock.steps) - until).abs() <= 1e-9 * step {
            clock.until = clock.point(clock.steps);
        }
        Ok(clock)
    }

    /// Checks that there are at most this many steps.
    ///
    /// # Errors
    /// There are more.
    pub fn check_at_most(&self, most: u64) -> Result<(), ClockError> {
        if self.steps <= most {
            return Ok(());
        }
        let Clock { start, step, until, .. } = *self;
        Err(ClockError::TooMany { start, step, until, most })
    }

    /// The k-th communication point.
    pub fn point(&self, k: u64) -> f64 {
        self.start + k as f64 * self.step
    }

    /// The end of the step that begins at the k-th point.
    pub fn end(&self, k: u64) -> f64 {
        if k + 1 >= self.steps { self.until } else { self.point(k + 1) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

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

    /// Steps that people write, and times until which they simulate, with what the clock makes of them: the Python
    /// package is held to this table by tests/fmpy/test_clock.py.
    #[test]
    fn the_table_of_pairs_is_up_to_date() {
        let steps =
            [0.001, 0.002, 0.005, 0.01, 0.02, 0.025, 0.03, 0.04, 0.05, 0.06, 0.07, 0.1, 0.12, 0.2, 0.25, 0.3];
        let mut table = String::from("step,until,steps,middle,last\n");
        for step in steps {
            for k in 1..=150u32 {
                // As they are written: with two decimals.
                let until = (f64::from(k) * 0.07 * 100.0).round() / 100.0;
                let clock = Clock::new(0.0, step, until).unwrap();
                let middle = clock.steps.div_ceil(2);
                let middle = if middle == clock.steps { clock.until } else { clock.point(middle) };
                let last = clock.end(clock.steps - 1);
                table += &format!("{step:?},{until:?},{},{middle:?},{last:?}\n", clock.steps);
            }
        }
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/clock.csv");
        if std::env::var_os("CLOCK_TABLE").is_some_and(|what| what == "write") {
            std::fs::write(&path, &table).unwrap();
        }
        let committed = std::fs::read_to_string(&path).unwrap();
        assert!(
            committed == table,
            "write it anew: CLOCK_TABLE=write cargo test -p lemons-master --lib clock"
        );
    }
}
