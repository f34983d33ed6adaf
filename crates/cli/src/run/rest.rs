//! When a crowd has come to rest, or has left.

use crate::watch::Watch;
use lemons_measure::Leaving;

/// \[s\] Nobody moves for so long.
pub const REST: f64 = 1.0;
/// \[s\] The same where nobody has moved yet: the crowd may be waiting for something.
const WAIT: f64 = 5.0;

/// \[s\] Times are sums of steps.
const ROUNDING: f64 = 1e-9;

/// What ends a run before its time.
pub enum Rest {
    Still(Still),
    Left(Leaving),
}

/// Since when nobody moves, while a run is made.
pub struct Still {
    /// \[s\]
    since: f64,
    moved: bool,
}

impl Rest {
    /// At the last look at a time \[s\].
    pub fn see(&mut self, time: f64, watch: &Watch) {
        match self {
            Rest::Still(still) => still.see(time, watch.moves()),
            Rest::Left(leaving) => {
                leaving.see(time, &watch.standing());
            }
        }
    }

    /// At a time \[s\].
    pub fn is_over(&self, time: f64) -> bool {
        match self {
            Rest::Still(still) => still.is_over(time),
            Rest::Left(leaving) => leaving.over().is_some(),
        }
    }

    /// How many have left of how many, if the run waits for that.
    pub fn left(&self) -> Option<(usize, usize)> {
        match self {
            Rest::Still(_) => None,
            Rest::Left(leaving) => Some(leaving.counts()),
        }
    }
}

impl Still {
    /// Of a run whose propulsion over time ends then \[s\]: before, nobody rests.
    pub fn after(pushes_end: Option<f64>) -> Still {
        Still { since: pushes_end.unwrap_or(f64::NEG_INFINITY), moved: false }
    }

    /// At a time \[s\], whether somebody moves.
    fn see(&mut self, time: f64, moves: bool) {
        self.moved |= moves;
        if moves || self.since == f64::NEG_INFINITY {
            self.since = self.since.max(time);
        }
    }

    fn is_over(&self, time: f64) -> bool {
        let enough = if self.moved { REST } else { WAIT };
        self.since.is_finite() && time - self.since >= enough - ROUNDING
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// When a run ends in which somebody moves at these times \[s\].
    fn end(pushes_end: Option<f64>, moves: impl Fn(f64) -> bool) -> Option<f64> {
        let mut rest = Still::after(pushes_end);
        (1..=200).map(|k| 0.1 * f64::from(k)).find(|time| {
            rest.see(*time, moves(*time));
            rest.is_over(*time)
        })
    }

    #[test]
    fn rest_is_a_second_after_motion_and_pushes() {
        let about = |end: Option<f64>, expected: f64| (end.unwrap() - expected).abs() < 0.11;
        assert!(about(end(None, |time| time < 3.0), 4.0));
        assert!(about(end(None, |time| (2.0..3.0).contains(&time)), 4.0));
        assert!(about(end(Some(6.0), |time| time < 3.0), 7.0));
        assert!(about(end(None, |_| false), 5.0));
        assert_eq!(end(None, |_| true), None);
        assert!(about(end(None, |time| time < 3.0 || (3.5..3.8).contains(&time)), 4.8));
    }
}
