//! The end of a run: at a time, or before, when the crowd has come to rest or has left.

use lemons_core::plane::{Motion, Vec2};
use lemons_results::Frame;
use lemons_results::measure::{LATEST, Leaving, OUTSIDE, Over};

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

/// End of a run, as users say it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Until {
    /// \[s\]
    Time(f64),
    /// \[s\] At the first communication point that is not before, as pictures need it: the last step is a whole one.
    Point(f64),
    /// When all have come to rest, as movies need it; at the latest after two minutes.
    Still,
    /// When all have left who have an exit, or nobody gets any further; at the latest after [`LATEST`].
    Left,
}

/// \[s\] Crowds that push for ever never come to rest.
const LATEST_REST: f64 = 120.0;

impl Until {
    /// Returns the time \[s\] at which the run ends, if it is known.
    pub fn time(self) -> Option<f64> {
        match self {
            Until::Time(time) | Until::Point(time) => Some(time),
            Until::Still | Until::Left => None,
        }
    }

    /// Returns the time \[s\] at which the run ends at the latest.
    pub fn latest(self) -> f64 {
        self.time().unwrap_or(if self == Until::Still { LATEST_REST } else { LATEST })
    }

    /// Returns what ends such a run before its time, if something does: `drive_end` \[s\] is when its drive ends, `who`
    /// says of everybody whether they are to leave.
    ///
    /// # Errors
    /// It is to end when all have left, and nobody can leave.
    pub fn condition(
        self,
        drive_end: Option<f64>,
        who: impl FnOnce() -> Vec<bool>,
    ) -> Result<Option<StopCondition>, NobodyLeaves> {
        Ok(match self {
            Until::Time(_) | Until::Point(_) => None,
            Until::Still => Some(StopCondition::Still(Still::after(drive_end))),
            Until::Left => {
                let who = Some(who()).filter(|who| who.contains(&true)).ok_or(NobodyLeaves)?;
                Some(StopCondition::Left(Leaving::of(who)))
            }
        })
    }
}

/// The error of a run that shall end when all have left.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("nobody can leave: people do not walk, or have no exits (give a time in seconds)")]
pub struct NobodyLeaves;

/// A condition that ends a run before its time.
#[derive(Debug, Clone)]
pub enum StopCondition {
    /// Everybody has come to rest.
    Still(Still),
    /// Everybody has left who was to leave, or nobody leaves any more.
    Left(Leaving),
}

/// Time since which nobody moves.
#[derive(Debug, Clone)]
pub struct Still {
    /// \[s\]
    since: f64,
    moved: bool,
}

impl StopCondition {
    /// Sees the frames of all crowds at a communication point \[s\], after a step or before the first one. Returns
    /// whether the run is over.
    pub(crate) fn see(&mut self, time: f64, frames: &[Frame], stepped: bool) -> bool {
        match self {
            // Whether anybody rests is known after a step.
            StopCondition::Still(_) if !stepped => false,
            StopCondition::Still(still) => {
                still.see(time, frames.iter().any(moves));
                still.is_over(time)
            }
            StopCondition::Left(leaving) => {
                leaving.see(time, &frames.iter().flat_map(places).collect::<Vec<_>>()).is_some()
            }
        }
    }

    /// Returns whether all have left who were to leave.
    pub(crate) fn have_left(&self) -> bool {
        matches!(self, StopCondition::Left(leaving) if leaving.over() == Some(Over::Left))
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

/// Returns where everybody is \[m\], or [`OUTSIDE`]; `None` of those who have left.
fn places(frame: &Frame) -> Vec<Option<Vec2>> {
    let at = |(agent, motion): (usize, &Motion)| match frame.is_there(agent) {
        true => Some(motion.pose.position),
        false => frame.is_outside(agent).then_some(OUTSIDE),
    };
    frame.agents.iter().enumerate().map(at).collect()
}

impl Still {
    /// Begins, for a run whose drive ends at a time \[s\]: before, nobody rests.
    fn after(drive_end: Option<f64>) -> Still {
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
