//! Vectors of the plane.

use nalgebra::Vector2;

/// A vector or point of the plane, in SI units. Files have it as a pair of numbers.
pub type Vec2 = Vector2<f64>;

/// Returns the vector `(x, y)`.
pub const fn vec2(x: f64, y: f64) -> Vec2 {
    Vector2::new(x, y)
}

/// Functions that `nalgebra` does not have for vectors of the plane.
pub trait InPlane: Sized {
    /// Returns the vector turned by 90° counter-clockwise.
    fn left(self) -> Self;

    /// Returns the vector of length 1 in this direction; `None` if it is not longer than `least`, or not a number.
    fn unit(self, least: f64) -> Option<Self>;

    /// Returns whether both components are finite.
    fn is_finite(&self) -> bool;
}

impl InPlane for Vec2 {
    #[inline]
    fn left(self) -> Vec2 {
        vec2(-self.y, self.x)
    }

    #[inline]
    fn unit(self, least: f64) -> Option<Vec2> {
        let norm = self.norm();
        (norm > least).then(|| self * (1.0 / norm))
    }

    #[inline]
    fn is_finite(&self) -> bool {
        self.x.is_finite() && self.y.is_finite()
    }
}
