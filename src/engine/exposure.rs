//! Effects of the contacts on a body, and on a face of a wall, during a communication step.

use super::BodyContacts;
use super::contacts::{Impulse, Load, greater};
use super::levels::ChestExposure;
use serde::{Deserialize, Serialize};

/// Effects of the contacts on a body during the last communication step. All of its mechanical steps count, whereas
/// [`super::BodyContacts`] is a sample at its end.
///
/// Before the first step it is what the contacts do at the start.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Exposure {
    /// \[N\] time average of the sum of |F_n| over the contacts: their impulse over the duration of the step. It is of
    /// second order in the mechanical step, also where contacts begin and end within one.
    pub mean_force: f64,
    /// \[N\] the part of `mean_force` by contacts with walls.
    pub mean_wall_force: f64,
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
        let mean = |one, other| mean_of_both([one, other], [before, duration]);
        let mean_force = mean(self.mean_force, after.mean_force).min(peak_force);
        Exposure {
            mean_force,
            mean_wall_force: mean(self.mean_wall_force, after.mean_wall_force).min(mean_force),
            peak_force,
            peak_overlap: self.peak_overlap.max(after.peak_overlap),
        }
    }

    /// \[N\] Returns the part of `mean_force` by contacts with other bodies; exactly zero if there were none.
    pub fn mean_people_force(&self) -> f64 {
        self.mean_force - self.mean_wall_force
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
    /// \[m\] deepest overlap.
    peak_overlap: f64,
}

impl ExposureSum {
    /// Adds the contact forces at an instant, weighted by a duration \[s\].
    #[inline(always)]
    pub fn add(&mut self, load: &Load, duration: f64) {
        self.impulse += load.squeeze * duration;
        self.peak_force = greater(self.peak_force, load.squeeze);
        self.peak_overlap = greater(self.peak_overlap, load.depth);
    }

    /// Adds what a contact that began or ended within a step did besides the forces at instants.
    pub fn add_impulse(&mut self, impulse: &Impulse) {
        self.impulse += impulse.squeeze;
        self.peak_force = greater(self.peak_force, impulse.peak);
    }

    /// Returns the exposure over a communication step of a duration \[s\], 0 for a single instant. `by_walls` \[N.s\] is
    /// the part of the impulse by walls. `end` is what acts at its end, after the correction of velocities: its force may
    /// be slightly larger than the earlier ones.
    pub fn exposure(&self, duration: f64, by_walls: f64, end: &BodyContacts) -> Exposure {
        let peak_force = self.peak_force.max(end.squeeze);
        let mean_force = mean(self.impulse, duration, end.squeeze, peak_force);
        let mean_wall_force = mean(by_walls, duration, end.wall_squeeze, mean_force);
        Exposure { mean_force, mean_wall_force, peak_force, peak_overlap: self.peak_overlap }
    }
}

/// Effects of the bodies on a face of a wall, or on a panel, during the last communication step; before the first step, at the start.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct FaceExposure {
    /// \[N\] time average of the sum of |F_n| over its contacts, with those of [`Exposure::mean_wall_force`].
    pub mean_force: f64,
    /// \[N\] largest sum, as [`Exposure::peak_force`].
    pub peak_force: f64,
}

impl FaceExposure {
    /// Returns the exposure over a time of two parts, as [`Exposure::and`].
    pub(super) fn and(&self, before: f64, after: &FaceExposure, duration: f64) -> FaceExposure {
        let mean_force = mean_of_both([self.mean_force, after.mean_force], [before, duration]);
        FaceExposure { mean_force, peak_force: self.peak_force.max(after.peak_force) }
    }
}

/// What the contacts did in the last communication step.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Exposures {
    /// One for each body.
    pub bodies: Vec<Exposure>,
    /// One for each face.
    pub faces: Vec<FaceExposure>,
    /// One for each panel.
    pub panels: Vec<FaceExposure>,
    /// One for each body, if the load on some chest is found.
    pub chests: Vec<ChestExposure>,
}

impl Exposures {
    /// Returns the numbers of bodies, faces, panels and chests.
    pub fn counts(&self) -> [usize; 4] {
        [self.bodies.len(), self.faces.len(), self.panels.len(), self.chests.len()]
    }

    /// Adds those of the time before: makes them of both, `so_far` \[s\] and then `duration` \[s\].
    pub(super) fn come_after(&mut self, so_far: f64, before: &Exposures, duration: f64) {
        let both = self.bodies.iter_mut().zip(&before.bodies);
        both.for_each(|(last, before)| *last = before.and(so_far, last, duration));
        for (last, before) in self.faces.iter_mut().zip(&before.faces) {
            *last = before.and(so_far, last, duration);
            last.mean_force = last.mean_force.min(last.peak_force);
        }
        let both = self.panels.iter_mut().zip(&before.panels);
        both.for_each(|(last, before)| *last = before.and(so_far, last, duration));
        let both = self.chests.iter_mut().zip(&before.chests);
        both.for_each(|(last, before)| *last = before.and(so_far, last, duration));
    }
}

/// The sums for a [`FaceExposure`] during a communication step.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct FaceSum {
    /// \[N\] Sum of |F_n| at the present instant.
    now: f64,
    /// \[N.s\] impulse.
    impulse: f64,
    /// \[N\] largest force.
    peak_force: f64,
}

impl FaceSum {
    /// Adds the force of a contact \[N\] at the present instant.
    pub fn add(&mut self, force: f64) {
        self.now += force;
    }

    /// Ends an instant that counts for a duration \[s\].
    pub fn end_instant(&mut self, duration: f64) {
        self.impulse += self.now * duration;
        self.peak_force = self.peak_force.max(self.now);
        self.now = 0.0;
    }

    /// Adds what a contact that began or ended within a step did besides the forces at instants.
    pub fn add_impulse(&mut self, impulse: &Impulse) {
        self.impulse += impulse.squeeze;
        self.peak_force = self.peak_force.max(impulse.peak);
    }

    /// Returns the exposure over a communication step of a duration \[s\], 0 for a single instant. `end` \[N\] is the
    /// force at its end.
    pub fn exposure(&self, duration: f64, end: f64) -> FaceExposure {
        // Of many bodies the sum might be beyond all numbers.
        let peak_force = self.peak_force.max(end).min(f64::MAX);
        FaceExposure { mean_force: mean(self.impulse, duration, end, peak_force), peak_force }
    }

    /// Returns the same of a panel. Its mean may be slightly below zero or above the peak, where a disk goes to another panel
    /// within the mechanical step in which its contact begins or ends: so panels add up to their wall.
    pub fn share(&self, duration: f64, end: f64) -> FaceExposure {
        let mean_force = if duration > 0.0 { self.impulse / duration } else { end };
        let mean_force = mean_force.clamp(-f64::MAX, f64::MAX);
        FaceExposure { mean_force, ..self.exposure(duration, end) }
    }
}

/// Returns the mean force over two times \[s\] of which each has a mean force.
pub(super) fn mean_of_both([one, other]: [f64; 2], [before, after]: [f64; 2]) -> f64 {
    (one * before + other * after) / (before + after)
}

/// Returns the mean force \[N\] of an impulse \[N.s\] over a duration \[s\], which is at most the greatest one; over none
/// the force at its end.
fn mean(impulse: f64, duration: f64, end: f64, greatest: f64) -> f64 {
    // Rounding may make (force × duration) / duration one bit larger than the force, and a sum of zero negative.
    if duration > 0.0 { (impulse / duration).max(0.0).min(greatest) } else { end }
}
