//! Horizontal sections of a crowd of bodies.

use super::{Body3d, Polygon};
use crowd_mechanics::engine::Pose;
use i_overlay::core::fill_rule::FillRule;
use i_overlay::float::simplify::SimplifyShape;

/// A body somewhere.
#[derive(Debug, Clone, Copy)]
pub struct Placed<'a> {
    /// Whose outlines.
    pub body: &'a Body3d,
    /// Where its axis stands and where it looks.
    pub pose: Pose,
}

impl Placed<'_> {
    /// The outlines at an altitude \[m\], seen from outside.
    pub fn slice_at(&self, z: f64) -> Vec<Polygon> {
        self.body.slice_at(z).into_iter().map(|polygon| polygon.at(&self.pose)).collect()
    }
}

/// What a horizontal plane cuts of a crowd.
#[derive(Debug, Clone, PartialEq)]
pub struct CrowdSection {
    /// \[m\]
    pub altitude: f64,
    /// Of each body in its order: the outlines of its parts; none where the body is lower than the plane.
    pub bodies: Vec<Vec<Polygon>>,
}

/// The section of a crowd at an altitude \[m\]: panels (b) to (d) of the paper's comparison with two dimensions.
pub fn section(crowd: &[Placed<'_>], altitude: f64) -> CrowdSection {
    CrowdSection { altitude, bodies: crowd.iter().map(|placed| placed.slice_at(altitude)).collect() }
}

impl CrowdSection {
    /// \[m²\] of each body.
    pub fn areas(&self) -> Vec<f64> {
        self.bodies.iter().map(|body| body.iter().map(Polygon::area).sum()).collect()
    }

    /// \[m²\] the sum of the areas, overlaps counted each time, as the paper's figure does.
    pub fn area(&self) -> f64 {
        self.areas().iter().sum()
    }

    /// \[m²\] of ground under the union of all outlines: overlaps of bodies counted once. Not a number where a pose is not
    /// finite.
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
        // On a grid of 64-bit integers over the whole crowd: exact below a nanometre, the same on every machine.
        let union = outlines.simplify_shape_as::<i64>(FillRule::NonZero);
        let signed = |contour: &Vec<[f64; 2]>| {
            let start = contour[0];
            let pairs = contour.iter().zip(&contour[1..]);
            let twice = pairs
                .map(|(a, b)| (a[0] - start[0]) * (b[1] - start[1]) - (a[1] - start[1]) * (b[0] - start[0]));
            0.5 * twice.sum::<f64>()
        };
        // A shape's first contour is its outside, the rest are holes.
        let shapes = union.iter().filter(|shape| !shape.is_empty());
        shapes
            .map(|shape| {
                signed(&shape[0]).abs() - shape[1..].iter().map(|hole| signed(hole).abs()).sum::<f64>()
            })
            .sum()
    }

    /// How many bodies the plane cuts.
    pub fn cut(&self) -> usize {
        self.bodies.iter().filter(|body| !body.is_empty()).count()
    }

    /// \[1/m²\] bodies cut per ground area \[m²\].
    pub fn density(&self, ground: f64) -> f64 {
        self.cut() as f64 / ground
    }
}

/// \[m\] the altitudes of the paper's figure: of the torso of the shortest body, their mean, of the tallest. None of
/// nobody.
pub fn torso_altitudes(crowd: &[Placed<'_>]) -> Option<[f64; 3]> {
    let all = || crowd.iter().map(|placed| placed.body.torso_altitude());
    let (least, most) = (all().reduce(f64::min)?, all().reduce(f64::max)?);
    Some([least, all().sum::<f64>() / crowd.len() as f64, most])
}
