//! Slices of a body at an altitude.

use super::outline::{POINTS, Points};
use super::skin::Ring;
use super::{Body3d, Part};
use lemons_core::plane::{Pose, Rotation, Vec2, vec2};

/// A slice of one part of a body.
#[derive(Debug, Clone, PartialEq)]
pub struct Polygon {
    /// The part of the body.
    pub part: Part,
    /// \[m\] Points, counter-clockwise; the first is not repeated.
    pub points: Vec<Vec2>,
}

impl Polygon {
    /// Returns its area \[m²\].
    pub fn area(&self) -> f64 {
        area(&self.points)
    }

    /// Returns the centroid of its area \[m\].
    pub fn centroid(&self) -> Vec2 {
        let start = self.points[0];
        let corners = self.points.iter().zip(self.points.iter().cycle().skip(1));
        let (sum, twice) = corners.fold((Vec2::ZERO, 0.0), |(sum, twice), (&a, &b)| {
            let (a, b) = (a - start, b - start);
            (sum + (a + b) * a.cross(b), twice + a.cross(b))
        });
        start + sum * (1.0 / (3.0 * twice))
    }

    /// Returns the outline of a body at a pose, in world coordinates.
    pub fn at(mut self, pose: &Pose) -> Polygon {
        let turn = Rotation::by(pose.orientation);
        for point in &mut self.points {
            *point = point.rotated(turn) + pose.position;
        }
        self
    }
}

/// \[m²\] Signed area, positive if counter-clockwise: Gauss's formula about the first point.
fn area(points: &[Vec2]) -> f64 {
    let start = points[0];
    let pairs = points.iter().zip(&points[1..]);
    0.5 * pairs.map(|(&a, &b)| (a - start).cross(b - start)).sum::<f64>()
}

/// \[m³\] Volume through rings. Between two of them the area is a quadratic of the altitude, which Simpson's rule
/// integrates exactly.
pub(super) fn volume(rings: &[Ring]) -> f64 {
    let slab = |pair: &[Ring]| {
        let (low, high) = (&pair[0], &pair[1]);
        let middle: Points = std::array::from_fn(|k| (low.points[k] + high.points[k]) * 0.5);
        (high.z - low.z) * (area(&low.points) + 4.0 * area(&middle) + area(&high.points)) / 6.0
    };
    rings.windows(2).map(slab).sum()
}

/// Interpolates between two outlines.
fn blend(low: &Points, high: &Points, share: f64) -> Points {
    std::array::from_fn(|k| {
        let (a, b) = (low[k], high[k]);
        vec2(a.x + share * (b.x - a.x), a.y + share * (b.y - a.y))
    })
}

/// The outline at an altitude. A part includes its lowest outline but not its highest, which belongs to the next part.
fn outline(rings: &[Ring], z: f64, highest: bool) -> Option<Points> {
    let above = rings.partition_point(|ring| ring.z <= z);
    match above {
        0 => None,
        above if above == rings.len() => {
            let last = &rings[above - 1];
            (highest && last.z == z).then_some(last.points)
        }
        above => {
            let (low, high) = (&rings[above - 1], &rings[above]);
            Some(blend(&low.points, &high.points, (z - low.z) / (high.z - low.z)))
        }
    }
}

impl Body3d {
    /// Returns the outlines of the parts at an altitude \[m\], in the body's frame; linear between two rings. It is
    /// empty below the soles and above the head.
    pub fn slice_at(&self, z: f64) -> Vec<Polygon> {
        let slices = self.tubes.iter().filter_map(|tube| {
            let points = outline(&tube.rings, z, tube.part == Part::Trunk)?;
            Some(Polygon { part: tube.part, points: points.to_vec() })
        });
        slices.collect()
    }

    /// Returns the volume \[m³\]: the exact integral of the area over the altitude.
    pub fn volume(&self) -> f64 {
        self.tubes.iter().map(|tube| volume(&tube.rings)).sum()
    }

    /// Returns slices at evenly spaced altitudes \[m\] from the soles to the top, at most `spacing` apart. They are at
    /// the middles of the layers, so that mean area × stature is about the volume.
    pub fn stack(&self, spacing: f64) -> Vec<(f64, Vec<Polygon>)> {
        let stature = self.person.stature;
        let layers = (stature / spacing.max(1e-4)).ceil().max(1.0) as usize;
        let middle = |layer: usize| (layer as f64 + 0.5) * stature / layers as f64;
        (0..layers).map(|layer| (middle(layer), self.slice_at(middle(layer)))).collect()
    }
}

const _: () = assert!(POINTS.is_multiple_of(4));
