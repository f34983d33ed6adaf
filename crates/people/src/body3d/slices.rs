//! Slices of a body at an altitude.

use super::outline::{POINTS, Points};
use super::skin::Ring;
use super::{Body3d, BodyPart};
use lemons_core::plane::{Pose, Vec2, rotation};

/// A slice of one part of a body.
#[derive(Debug, Clone, PartialEq)]
pub struct BodySlice {
    /// The part of the body.
    pub part: BodyPart,
    /// \[m\] Points, counter-clockwise; the first is not repeated.
    pub points: Vec<Vec2>,
}

impl BodySlice {
    /// Returns its area \[m²\].
    pub fn area(&self) -> f64 {
        area(&self.points)
    }

    /// Returns the centroid of its area \[m\].
    pub fn centroid(&self) -> Vec2 {
        let start = self.points[0];
        let corners = self.points.iter().zip(self.points.iter().cycle().skip(1));
        let (sum, twice) = corners.fold((Vec2::zeros(), 0.0), |(sum, twice), (&a, &b)| {
            let (a, b) = (a - start, b - start);
            (sum + (a + b) * a.perp(&b), twice + a.perp(&b))
        });
        start + sum * (1.0 / (3.0 * twice))
    }

    /// Returns the outline of a body at a pose, in world coordinates.
    pub fn at(mut self, pose: &Pose) -> BodySlice {
        let turn = rotation(pose.orientation);
        for point in &mut self.points {
            *point = turn * *point + pose.position;
        }
        self
    }
}

/// \[m²\] Signed area, positive if counter-clockwise: Gauss's formula about the first point.
fn area(points: &[Vec2]) -> f64 {
    let start = points[0];
    let pairs = points.iter().zip(&points[1..]);
    0.5 * pairs.map(|(&a, &b)| (a - start).perp(&(b - start))).sum::<f64>()
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

/// The outline at an altitude. A part includes its lowest outline but not its highest, which belongs to the next part
/// unless `highest`.
pub(super) fn outline(rings: &[Ring], z: f64, highest: bool) -> Option<Points> {
    let above = rings.partition_point(|ring| ring.z <= z);
    let low = &rings[above.checked_sub(1)?];
    let Some(high) = rings.get(above) else {
        return (highest && low.z == z).then_some(low.points);
    };
    let share = (z - low.z) / (high.z - low.z);
    Some(std::array::from_fn(|k| low.points[k] + (high.points[k] - low.points[k]) * share))
}

impl Body3d {
    /// Returns the outlines of the parts at an altitude \[m\], in the body's frame; linear between two rings. It is
    /// empty below the soles and above the head.
    pub fn slice_at(&self, z: f64) -> Vec<BodySlice> {
        let slice = |(part, rings): (BodyPart, &Vec<Ring>)| {
            let points = outline(rings, z, part == BodyPart::Trunk)?.to_vec();
            Some(BodySlice { part, points })
        };
        self.parts().filter_map(slice).collect()
    }

    /// Returns the volume \[m³\]: the exact integral of the area over the altitude.
    pub fn volume(&self) -> f64 {
        self.rings.iter().map(|rings| volume(rings)).sum()
    }

    /// Returns evenly spaced altitudes \[m\] from the soles to the top, at most `spacing` apart. They are the middles of
    /// layers, so that mean area × stature is about the volume.
    pub fn layers(&self, spacing: f64) -> impl Iterator<Item = f64> {
        let stature = self.person.stature;
        let layers = (stature / spacing.max(1e-4)).ceil().max(1.0) as usize;
        (0..layers).map(move |layer| (layer as f64 + 0.5) * stature / layers as f64)
    }
}

const _: () = assert!(POINTS.is_multiple_of(4));
