//! Circles, and what is near them.

use super::face::{Face, nearest_on_face};
use super::{FaceId, Vec2};

/// A circle that contains a body, at one instant or during a whole communication step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Circle {
    pub centre: Vec2,
    pub radius: f64,
}

impl Circle {
    /// Returns the circle around a point that holds some others.
    pub fn around(centre: Vec2, circles: &[Circle]) -> Circle {
        let reach = |circle: &Circle| (circle.centre - centre).norm() + circle.radius;
        Circle { centre, radius: circles.iter().map(reach).fold(0.0, f64::max) }
    }

    /// Whether the distance of two circles is less than a margin \[m\].
    pub fn nears(&self, other: &Circle, margin: f64) -> bool {
        let reach = self.radius + other.radius + margin;
        (self.centre - other.centre).norm_squared() <= reach * reach
    }

    /// Whether the distance of the circle from a face is less than a margin \[m\].
    pub fn nears_face(&self, faces: &[Face], face: FaceId, margin: f64) -> bool {
        let face = &faces[face.index()];
        let reach = self.radius + margin;
        // Test the bounding box of the face first: most faces are far away.
        let (low, high) = (face.start.x.min(face.end.x) - reach, face.start.x.max(face.end.x) + reach);
        if self.centre.x < low || self.centre.x > high {
            return false;
        }
        let (low, high) = (face.start.y.min(face.end.y) - reach, face.start.y.max(face.end.y) + reach);
        if self.centre.y < low || self.centre.y > high {
            return false;
        }
        let (nearest, _) = nearest_on_face(face, self.centre);
        (self.centre - nearest).norm_squared() <= reach * reach
    }
}
