//! Horizontal sections of a crowd of bodies.

use super::{Body3d, Polygon};
use i_overlay::core::fill_rule::FillRule;
use i_overlay::float::simplify::SimplifyShape;
use lemons_core::plane::Pose;

/// A body at a pose.
#[derive(Debug, Clone, Copy)]
pub struct Placed<'a> {
    /// The body.
    pub body: &'a Body3d,
    /// Position of its axis and direction of its gaze.
    pub pose: Pose,
}

impl Placed<'_> {
    /// Returns its outlines at an altitude \[m\], in world coordinates.
    pub fn slice_at(&self, z: f64) -> Vec<Polygon> {
        self.body.slice_at(z).into_iter().map(|polygon| polygon.at(&self.pose)).collect()
    }
}

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
pub fn section(crowd: &[Placed<'_>], altitude: f64) -> CrowdSection {
    CrowdSection { altitude, bodies: crowd.iter().map(|placed| placed.slice_at(altitude)).collect() }
}

impl CrowdSection {
    /// Returns the sum of the areas \[m²\]. Overlaps count several times, as in the paper's figure.
    pub fn area(&self) -> f64 {
        self.bodies.iter().flatten().map(Polygon::area).sum()
    }

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
        let signed = |contour: &Vec<[f64; 2]>| {
            let start = contour[0];
            let pairs = contour.iter().zip(&contour[1..]);
            let twice = pairs
                .map(|(a, b)| (a[0] - start[0]) * (b[1] - start[1]) - (a[1] - start[1]) * (b[0] - start[0]));
            0.5 * twice.sum::<f64>()
        };
        // The first contour of a shape is its outer boundary, the others are holes.
        let shapes = union.iter().filter(|shape| !shape.is_empty());
        shapes
            .map(|shape| {
                signed(&shape[0]).abs() - shape[1..].iter().map(|hole| signed(hole).abs()).sum::<f64>()
            })
            .sum()
    }

    /// Returns the number of bodies that the plane cuts.
    pub fn cut(&self) -> usize {
        self.bodies.iter().filter(|body| !body.is_empty()).count()
    }
}
