//! The communication points of a run.

/// Why there are no such communication points: a sentence.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{0}")]
pub struct ClockError(String);

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

    /// The communication points from `start` to `until` \[s\] with a communication step \[s\]. If `until` is a multiple
    /// of the step except for rounding, the last point is that multiple, as every longer run has it. Otherwise the
    /// last step is shorter.
    ///
    /// # Errors
    /// A value is not finite, the step is not positive, `until` is not after `start`, there are too many points, or the
    /// step is lost in rounding.
    pub fn new(start: f64, step: f64, until: f64) -> Result<Clock, ClockError> {
        for (what, value) in [("start time", start), ("communication step", step), ("stop time", until)] {
            if !value.is_finite() {
                return Err(ClockError(format!("{what} {value:?} s: not a finite number")));
            }
        }
        if step <= 0.0 {
            let message = format!("a communication step of {step:?} s: it must be greater than 0");
            return Err(ClockError(message));
        }
        if until <= start {
            return Err(ClockError(format!("from {start:?} to {until:?} s there is nothing to simulate")));
        }
        let quotient = (until - start) / step;
        let mut clock = Clock { start, step, until, steps: quotient.round().max(1.0) as u64 };
        clock.check_at_most(Clock::MOST_STEPS)?;
        if start + step <= start || until - step >= until {
            return Err(ClockError(format!(
                "a communication step of {step:?} s is lost in rounding between {start:?} and {until:?} s"
            )));
        }
        // Both the quotient and the multiple are rounded: by less than a few of the smallest differences of such times.
        let rounding = 4.0 * (until.abs().next_up() - until.abs()).max(start.abs().next_up() - start.abs());
        let multiple = clock.point(clock.steps);
        if (multiple - until).abs() <= rounding.max(1e-9 * step) {
            clock.until = multiple;
        } else {
            clock.steps = quotient.ceil().max(1.0) as u64;
        }
        // No step has the length 0.
        while clock.steps > 1 && clock.point(clock.steps - 1) >= clock.until {
            clock.steps -= 1;
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
        let steps = (until - start) / step;
        Err(ClockError(format!(
            "from {start:?} to {until:?} s there are {steps:.4e} communication steps of {step:?} s: at most {most:e} are \
             made"
        )))
    }

    /// The k-th communication point.
    pub fn point(&self, k: u64) -> f64 {
        self.start + k as f64 * self.step
    }

    /// The communication points \[s\] after the `first`-th one.
    pub fn points(self, first: u64) -> impl Iterator<Item = f64> {
        (first..self.steps).map(move |k| self.end(k))
    }

    /// Communication points from `start` on, without an end.
    pub fn endless(start: f64, step: f64) -> Clock {
        Clock { start, step, until: f64::INFINITY, steps: u64::MAX }
    }

    /// The end of the step that begins at the k-th point.
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
    fn impossible_times_are_named() {
        let step = "a communication step of";
        for (start, length, until, expected) in [
            (0.0, 0.05, 1e300, "there are 2.0000e301 communication steps of 0.05 s: at most 1e9 are made"),
            (-1e308, 1.0, 1e308, "communication steps"),
            (0.0, 1e-300, 1e300, "communication steps of 1e-300 s: at most 1e9"),
            (1e17, 0.05, 1e17 + 64.0, "is lost in rounding"),
            (0.0, f64::NAN, 1.0, "communication step NaN s: not a finite number"),
            (f64::NEG_INFINITY, 0.1, 1.0, "start time -inf s: not a finite number"),
            (0.0, 0.1, f64::NAN, "stop time NaN s: not a finite number"),
            (0.0, 0.0, 1.0, &format!("{step} 0.0 s: it must be greater than 0")),
            (0.0, -0.1, 1.0, &format!("{step} -0.1 s: it must be greater than 0")),
            (2.0, 0.1, 2.0, "from 2.0 to 2.0 s there is nothing to simulate"),
        ] {
            let message = Clock::new(start, length, until).unwrap_err().to_string();
            assert!(message.contains(expected), "{message}");
        }
        assert!(Clock::new(0.0, 1e299, 1e300).is_ok());
    }

    /// The quotient of a long run is wrong by more than 1e-9.
    #[test]
    fn a_long_run_has_no_step_of_length_zero() {
        let random = |k: u64| (k.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 33) % 1_000_000_000 + 1;
        let hundredths = [1, 2, 3, 5, 6, 7, 10, 12, 25, 30];
        for (k, hundredth) in (1..20_000).zip(hundredths.into_iter().cycle()) {
            let (steps, step) = (random(k), f64::from(hundredth) / 100.0);
            let until = (hundredth as u64 * steps) as f64 / 100.0;
            let clock = Clock::new(0.0, step, until).unwrap();
            assert_eq!((clock.steps, clock.until), (steps, clock.point(steps)), "{step} {until}");
            assert!(clock.point(steps - 1) < clock.until);
        }
        // Far from 0 times are coarse.
        for start in [1e6, 1e9, -1e9] {
            let clock = Clock::new(start, 0.01, start + 0.07).unwrap();
            assert_eq!((clock.steps, clock.end(6)), (7, clock.point(7)));
        }
    }
}
