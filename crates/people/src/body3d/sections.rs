//! Horizontal sections of a crowd of bodies.

use super::{Body3d, Polygon};
use i_overlay::core::fill_rule::FillRule;
use i_overlay::float::simplify::SimplifyShape;
use lemons_core::plane::{Pose, Ring, vec2};

/// The section of a crowd with a horizontal plane.
#[derive(Debug, Clone, PartialEq)]
pub struct CrowdSection {
    /// \[m\] altitude of the plane.
    pub altitude: f64,
    /// For each body the outlines of its parts; empty where the plane is above the body.
    pub bodies: Vec<Vec<Polygon>>,
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
        let outlines: Vec<Vec<[f64; 2]>> = self
            .bodies
            .iter()
            .flatten()
            .map(|polygon| polygon.points.iter().map(|p| [p.x, p.y]).collect())
            .collect();
        if outlines.is_empty() {
            return 0.0;
        }
        if !outlines.iter().flatten().flatten().all(|value| value.is_finite()) {
            return f64::NAN;
        }
        // On a grid of 64-bit integers over the whole crowd: better than a nanometre, and the same on every machine.
        let union = outlines.simplify_shape_as::<i64>(FillRule::NonZero);
        let area = |contour: &Vec<[f64; 2]>| {
            Ring::through(contour.iter().map(|[x, y]| vec2(*x, *y)).collect()).map_or(0.0, |ring| ring.area())
        };
        // The first contour of a shape is its outer boundary, the others are holes.
        let shapes = union.iter().filter(|shape| !shape.is_empty());
        shapes.map(|shape| area(&shape[0]) - shape[1..].iter().map(area).sum::<f64>()).sum()
    }

    /// Returns the number of bodies that the plane cuts.
    pub fn cut(&self) -> usize {
        self.bodies.iter().filter(|body| !body.is_empty()).count()
    }
}
