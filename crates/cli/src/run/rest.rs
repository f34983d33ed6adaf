//! When a crowd has come to rest, or has left.

/// \[s\] Nobody moves for so long.
pub const REST: f64 = 1.0;
/// \[s\] The same where nobody has moved yet: the crowd may be waiting for something.
const WAIT: f64 = 5.0;

/// \[s\] Times are sums of steps.
const ROUNDING: f64 = 1e-9;

/// Since when nobody moves, while a run is made.
pub struct Rest {
    /// \[s\]
    since: f64,
    moved: bool,
    /// It is over only when so many have left.
    leave: Option<usize>,
    left: usize,
}

impl Rest {
    /// Of a run whose propulsion over time ends then \[s\]: before, nobody rests.
    pub fn after(pushes_end: Option<f64>) -> Rest {
        let since = pushes_end.unwrap_or(f64::NEG_INFINITY);
        Rest { since, moved: false, leave: None, left: 0 }
    }

    /// Over as soon as so many have left.
    pub fn when_left(leave: usize) -> Rest {
        Rest { leave: Some(leave), ..Rest::after(None) }
    }

    /// At a time \[s\], whether somebody moves, and how many have left.
    pub fn see(&mut self, time: f64, moves: bool, left: usize) {
        self.left = left;
        self.moved |= moves;
        if moves || self.since == f64::NEG_INFINITY {
            self.since = self.since.max(time);
        }
    }

    /// At a time \[s\].
    pub fn is_over(&self, time: f64) -> bool {
        if let Some(leave) = self.leave {
            return self.left >= leave;
        }
        let enough = if self.moved { REST } else { WAIT };
        self.since.is_finite() && time - self.since >= enough - ROUNDING
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// When a run ends in which somebody moves at these times \[s\].
    fn end(pushes_end: Option<f64>, moves: impl Fn(f64) -> bool) -> Option<f64> {
        let mut rest = Rest::after(pushes_end);
        (1..=200).map(|k| 0.1 * f64::from(k)).find(|time| {
            rest.see(*time, moves(*time), 0);
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
