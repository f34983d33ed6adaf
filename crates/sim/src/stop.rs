//! When a run ends before its time: the crowd has come to rest, or has left.

use lemons_core::plane::Vec2;
use lemons_results::Frame;
use lemons_results::measure::Leaving;

/// \[s\] Nobody moves for so long.
pub const REST: f64 = 1.0;
/// \[s\] The same where nobody has moved yet: the crowd may be waiting for something.
const WAIT: f64 = 5.0;
/// \[m/s\] Somebody who is not faster stands,
const STANDING_SPEED: f64 = 0.01;
/// \[rad/s\] and does not turn faster than this.
const STANDING_TURN: f64 = 0.05;
/// \[s\] Times are sums of steps.
const ROUNDING: f64 = 1e-9;

/// What ends a run before its time.
pub enum StopCondition {
    /// Everybody has come to rest.
    Still(Still),
    /// Everybody has left who was to leave, or nobody leaves any more.
    Left(Leaving),
}

/// Since when nobody moves.
pub struct Still {
    /// \[s\]
    since: f64,
    moved: bool,
}

impl StopCondition {
    /// Sees the frames of all crowds at a communication point \[s\].
    pub fn see(&mut self, time: f64, frames: &[Frame]) {
        match self {
            StopCondition::Still(still) => still.see(time, frames.iter().any(moves)),
            StopCondition::Left(leaving) => {
                leaving.see(time, &frames.iter().flat_map(places).collect::<Vec<_>>());
            }
        }
    }

    /// Returns whether the run is over at a time \[s\].
    pub fn is_over(&self, time: f64) -> bool {
        match self {
            StopCondition::Still(still) => still.is_over(time),
            StopCondition::Left(leaving) => leaving.over().is_some(),
        }
    }

    /// Returns how many are to leave, and how many have left, if the run waits for that.
    pub fn left(&self) -> Option<(usize, usize)> {
        match self {
            StopCondition::Still(_) => None,
            StopCondition::Left(leaving) => Some(leaving.counts()),
        }
    }
}

/// Returns whether somebody moves, or turns.
pub fn moves(frame: &Frame) -> bool {
    frame.agents.iter().any(|motion| {
        let twist = motion.twist;
        twist.velocity.x.hypot(twist.velocity.y) > STANDING_SPEED
            || twist.angular_velocity.abs() > STANDING_TURN
    })
}

/// Returns where everybody is \[m\]; `None` of those who have left.
pub fn places(frame: &Frame) -> Vec<Option<Vec2>> {
    let all = frame.agents.iter().enumerate();
    all.map(|(agent, motion)| frame.is_there(agent).then_some(motion.pose.position)).collect()
}

impl Still {
    /// Begins, for a run whose drive ends at a time \[s\]: before, nobody rests.
    pub fn after(drive_end: Option<f64>) -> Still {
        Still { since: drive_end.unwrap_or(f64::NEG_INFINITY), moved: false }
    }

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
    fn end(drive_end: Option<f64>, moves: impl Fn(f64) -> bool) -> Option<f64> {
        let mut rest = Still::after(drive_end);
        (1..=200).map(|k| 0.1 * f64::from(k)).find(|time| {
            rest.see(*time, moves(*time));
            rest.is_over(*time)
        })
    }

    #[test]
    fn rest_is_a_second_after_motion_and_drive() {
        let about = |end: Option<f64>, expected: f64| (end.unwrap() - expected).abs() < 0.11;
        assert!(about(end(None, |time| time < 3.0), 4.0));
        assert!(about(end(None, |time| (2.0..3.0).contains(&time)), 4.0));
        assert!(about(end(Some(6.0), |time| time < 3.0), 7.0));
        assert!(about(end(None, |_| false), 5.0));
        assert_eq!(end(None, |_| true), None);
        assert!(about(end(None, |time| time < 3.0 || (3.5..3.8).contains(&time)), 4.8));
    }
}
