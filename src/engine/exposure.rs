//! What the contacts did to a body during a communication step.

use super::contacts::{Impulse, Load};
use serde::{Deserialize, Serialize};

/// What the contacts did to a body during the last communication step. All of its mechanical steps count, whereas
/// [`super::BodyContacts`] is a sample at its end.
///
/// Before the first step it is what the contacts do at the start.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Exposure {
    /// \[N\] time average of the sum of |F_n| over the contacts: their impulse over the duration of the step. It is of
    /// second order in the mechanical step, also where contacts begin and end within one.
    pub mean_force: f64,
    /// \[N\] largest sum of |F_n| over the contacts at the evaluations; or |F_n| of one contact when it began or ended,
    /// if that is larger.
    pub peak_force: f64,
    /// \[m\] deepest overlap of a contact.
    pub peak_overlap: f64,
}

impl Exposure {
    /// Returns the exposure over a time of two parts: this over `before` \[s\], then `after` over `duration` \[s\].
    pub(super) fn and(&self, before: f64, after: &Exposure, duration: f64) -> Exposure {
        let peak_force = self.peak_force.max(after.peak_force);
        let impulse = self.mean_force * before + after.mean_force * duration;
        Exposure {
            mean_force: (impulse / (before + duration)).min(peak_force),
            peak_force,
            peak_overlap: self.peak_overlap.max(after.peak_overlap),
        }
    }

    /// Returns whether all of it are numbers.
    pub fn is_finite(&self) -> bool {
        self.mean_force.is_finite() && self.peak_force.is_finite() && self.peak_overlap.is_finite()
    }
}

/// The sums for an [`Exposure`] during a communication step.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct ExposureSum {
    /// \[N.s\] impulse.
    impulse: f64,
    /// \[N\] largest force.
    peak_force: f64,
}

impl ExposureSum {
    /// Adds the contact forces at an instant, weighted by a duration \[s\].
    #[inline(always)]
    pub fn add(&mut self, load: &Load, duration: f64) {
        self.impulse += load.squeeze * duration;
        self.peak_force = if load.squeeze > self.peak_force { load.squeeze } else { self.peak_force };
    }

    /// Adds what a contact that began or ended within a step did besides the forces at instants.
    pub fn add_impulse(&mut self, impulse: &Impulse) {
        self.impulse += impulse.squeeze;
        self.peak_force = if impulse.peak > self.peak_force { impulse.peak } else { self.peak_force };
    }

    /// Returns the exposure over a communication step of a duration \[s\], 0 for a single instant. `peak_overlap` \[m\]
    /// is the deepest overlap. `squeeze` \[N\] is the force at its end, after the correction of velocities, which may
    /// be slightly larger than the earlier ones.
    pub fn exposure(&self, duration: f64, squeeze: f64, peak_overlap: f64) -> Exposure {
        let peak_force = self.peak_force.max(squeeze);
        // Rounding may make (force × duration) / duration one bit larger than the force, and a sum of zero negative.
        let mean_force =
            if duration > 0.0 { (self.impulse / duration).max(0.0).min(peak_force) } else { squeeze };
        Exposure { mean_force, peak_force, peak_overlap }
    }
}
