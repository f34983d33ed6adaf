//! What the contacts did to a body during a communication step.

use super::contacts::Load;
use serde::{Deserialize, Serialize};

/// What the contacts did to a body during the last communication step, at whichever of its mechanical steps: unlike
/// [`super::BodyContacts`], no sample at its end.
///
/// Before the first step it is what the contacts do at the start.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Exposure {
    /// \[N\] time average of the sum of |F_n| over the contacts: their impulse over the duration of the step, by the
    /// trapezoidal rule over its mechanical steps.
    pub mean_force: f64,
    /// \[N\] largest sum of |F_n| over the contacts.
    pub peak_force: f64,
    /// \[m\] deepest overlap of a contact.
    pub peak_overlap: f64,
}

impl Exposure {
    pub(super) fn is_finite(&self) -> bool {
        self.mean_force.is_finite() && self.peak_force.is_finite() && self.peak_overlap.is_finite()
    }
}

/// What is added up for an [`Exposure`] while a communication step is under way.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Tally {
    /// \[N.s\]
    impulse: f64,
    /// \[N\]
    peak_force: f64,
    /// \[m\]
    peak_overlap: f64,
}

impl Tally {
    /// Adds what the contacts do at an instant that stands for a duration \[s\].
    #[inline(always)]
    pub fn add(&mut self, load: &Load, duration: f64) {
        // Most bodies touch nothing, or go on touching: the processor guesses well.
        if load.depth > 0.0 {
            self.impulse += load.squeeze * duration;
            self.peak_force = if load.squeeze > self.peak_force { load.squeeze } else { self.peak_force };
            self.peak_overlap = if load.depth > self.peak_overlap { load.depth } else { self.peak_overlap };
        }
    }

    /// Over the duration \[s\] of the communication step, zero at an instant. At its end the contacts squeeze with a
    /// force \[N\]: that of the corrected velocities, which may be a little larger than what was seen.
    pub fn exposure(&self, duration: f64, squeeze: f64) -> Exposure {
        let peak_force = self.peak_force.max(squeeze);
        // A constant force times the duration, divided by it, may be one bit more than the force.
        let mean_force = if duration > 0.0 { (self.impulse / duration).min(peak_force) } else { squeeze };
        Exposure { mean_force, peak_force, peak_overlap: self.peak_overlap }
    }
}
