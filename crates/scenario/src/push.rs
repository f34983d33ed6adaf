//! Pushes: pulses on all who stand in a circle.

use crate::error::{Result, impossible, within};
use crate::forms::Pair;
use lemons_core::plane::vec2;
use lemons_core::trial::{DriveTable, Pulse, Trial, drive_of_pulses};
use lemons_people::heading;
use serde::{Deserialize, Serialize};

/// A pulse on all whose centres lie in a circle at the start.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
#[serde(deny_unknown_fields)]
pub struct Push {
    /// \[m\] Middle of the circle.
    pub at: Pair,
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

    fn pulse(&self) -> Result<Pulse> {
        self.check()?;
        let (Pair([x, y]), &Push { radius, start, duration, .. }) = (self.at, self);
        Ok(Pulse { at: vec2(x, y), radius, force: heading(self.direction) * self.force, start, duration })
    }
}

/// Returns the drive of pushes; empty without any.
///
/// # Errors
/// A number of a push is not possible, or it reaches nobody.
pub fn drive(trial: &Trial, pushes: &[Push]) -> Result<DriveTable> {
    let pulses = pushes.iter().map(Push::pulse).collect::<Result<Vec<_>>>()?;
    drive_of_pulses(trial, &pulses)
        .map_err(|lost| impossible(format!("push {}: nobody stands in its circle", lost + 1)))
}
