//! Pushes: pulses on all who stand in a circle.

use crate::error::{NOBODY_PUSHED, Result, require, within};
use crate::forms::TwoNumbers;
use lemons_core::message::message;
use lemons_core::plane::Vec2;
use lemons_core::trial::{DriveTable, EVER, Trial, half_sine};
use lemons_people::heading;
use serde::{Deserialize, Serialize};

/// Straight pieces of a pulse. Its impulse is that of the half sine but for 0.3 %.
const PIECES: u32 = 16;

/// A half sine of force on all whose centres lie in a circle at the start.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
#[serde(deny_unknown_fields)]
pub struct Push {
    /// \[m\] Middle of the circle.
    pub at: TwoNumbers,
    /// \[m\]
    pub radius: f64,
    /// \[°\]
    pub direction: f64,
    /// \[N\] Greatest force on each.
    pub force: f64,
    /// \[s\]
    pub start: f64,
    /// \[s\]
    pub duration: f64,
}

impl Push {
    /// Checks that each number is in its range.
    pub(crate) fn check(&self) -> Result<()> {
        within("radius of a push [m]", self.radius, [0.01, 1000.0])?;
        within("force of a push [N]", self.force, [0.0, 1e5])?;
        within("direction of a push [°]", self.direction, [-360.0, 360.0])?;
        within("start of a push [s]", self.start, [0.0, 1e4])?;
        within("duration of a push [s]", self.duration, [0.01, 1e4])
    }

    fn reaches(&self, place: Vec2) -> bool {
        (place - Vec2::from(self.at.0)).norm() <= self.radius
    }

    /// \[N\]
    fn at_time(&self, time: f64) -> Vec2 {
        let force = |sine| heading(self.direction) * self.force * sine;
        half_sine((time - self.start) / self.duration).map_or(Vec2::zeros(), force)
    }

    /// \[s\] Where its straight pieces begin and end.
    fn times(&self) -> impl Iterator<Item = f64> {
        let Push { start, duration, .. } = *self;
        (0..=PIECES).map(move |k| start + duration * f64::from(k) / f64::from(PIECES))
    }
}

/// Returns the drive of pushes; empty without any. They act besides what AgentDynamics.xml says, which goes on before and
/// after them.
///
/// # Errors
/// A number of a push is not possible, or it reaches nobody.
pub fn drive(trial: &Trial, pushes: &[Push]) -> Result<DriveTable> {
    for (k, push) in pushes.iter().enumerate() {
        push.check()?;
        let reached = trial.dynamics.iter().any(|here| push.reaches(here.position));
        require(reached, || message!(NOBODY_PUSHED, push = k + 1))?;
    }
    let mut drive = DriveTable::default();
    for (agent, here) in trial.agents.iter().zip(&trial.dynamics) {
        let own: Vec<&Push> = pushes.iter().filter(|push| push.reaches(here.position)).collect();
        if own.is_empty() {
            continue;
        }
        let mut times: Vec<f64> = own.iter().flat_map(|push| push.times()).chain([0.0, EVER]).collect();
        times.sort_by(f64::total_cmp);
        times.dedup();
        let row = |time: f64| {
            let sum = own.iter().fold(here.fp, |sum, push| sum + push.at_time(time));
            (time, [sum.x, sum.y, here.mp])
        };
        drive.add(&agent.id, times.into_iter().map(row).collect());
    }
    Ok(drive)
}
