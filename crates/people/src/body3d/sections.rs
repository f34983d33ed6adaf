//! Horizontal sections of a crowd of bodies.

use super::{Body3d, BodySlice};
use lemons_core::plane::Pose;
use lemons_core::plane::overlay::{Contour, area, union};

/// The section of a crowd with a horizontal plane.
#[derive(Debug, Clone, PartialEq)]
pub struct CrowdSection {
    /// \[m\] altitude of the plane.
    pub altitude: f64,
    /// For each body the outlines of its parts; empty where the plane is above the body.
    pub bodies: Vec<Vec<BodySlice>>,
}

/// Returns the section of a crowd at an altitude \[m\]: panels (b) to (d) of the paper's comparison with two
/// dimensions.
pub fn section(crowd: &[(&Body3d, Pose)], altitude: f64) -> CrowdSection {
    let outlines = |(body, pose): &(&Body3d, Pose)| {
        body.slice_at(altitude).into_iter().map(|polygon| polygon.at(pose)).collect()
    };
    CrowdSection { altitude, bodies: crowd.iter().map(outlines).collect() }
}

impl CrowdSection {
    /// Returns the area of ground under the union of all outlines \[m²\]: overlaps of bodies count once. It is NaN if a
    /// pose is not finite.
    pub fn covered(&self) -> f64 {
        let outlines: Vec<Contour> = self
            .bodies
            .iter()
            .flatten()
            .map(|polygon| polygon.points.iter().map(|p| [p.x, p.y]).collect())
            .collect();
        if !outlines.iter().flatten().flatten().all(|value| value.is_finite()) {
            return f64::NAN;
        }
        union(&outlines).iter().map(|part| area(part)).sum()
    }

    /// Returns the number of bodies that the plane cuts.
    pub fn cut(&self) -> usize {
        self.bodies.iter().filter(|body| !body.is_empty()).count()
    }
}
