//! Vectors of the plane.

use serde::{Deserialize, Serialize};
use std::ops::{Add, AddAssign, Mul, Neg, Sub, SubAssign};

/// A vector or point of the plane, in SI units. Only `+`, `−` and the product with a number are operators; the other
/// operations are methods. Files have it as a pair of numbers.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(from = "[f64; 2]", into = "[f64; 2]")]
pub struct Vec2 {
    /// First component.
    pub x: f64,
    /// Second component.
    pub y: f64,
}

/// Returns the vector `(x, y)`.
pub const fn vec2(x: f64, y: f64) -> Vec2 {
    Vec2 { x, y }
}

impl From<[f64; 2]> for Vec2 {
    fn from([x, y]: [f64; 2]) -> Vec2 {
        vec2(x, y)
    }
}

impl From<Vec2> for [f64; 2] {
    fn from(v: Vec2) -> [f64; 2] {
        [v.x, v.y]
    }
}

impl Vec2 {
    /// The zero vector.
    pub const ZERO: Vec2 = vec2(0.0, 0.0);

    /// Returns the scalar product.
    #[inline]
    pub fn dot(self, other: Vec2) -> f64 {
        self.x * other.x + self.y * other.y
    }

    /// Returns the out-of-plane component of the vector product `self × other`.
    #[inline]
    pub fn cross(self, other: Vec2) -> f64 {
        self.x * other.y - self.y * other.x
    }

    /// Returns the vector turned by 90° counter-clockwise.
    #[inline]
    pub fn perp(self) -> Vec2 {
        vec2(-self.y, self.x)
    }

    /// Returns the square of the length.
    #[inline]
    pub fn norm_squared(self) -> f64 {
        self.dot(self)
    }

    /// Returns the length.
    #[inline]
    pub fn norm(self) -> f64 {
        self.norm_squared().sqrt()
    }

    /// Returns the vector of length 1 in this direction; `None` if it is not longer than `least`.
    #[inline]
    pub fn unit(self, least: f64) -> Option<Vec2> {
        let norm = self.norm();
        (norm > least).then(|| self * (1.0 / norm))
    }

    /// Returns the vector turned by a rotation.
    #[inline]
    pub fn rotated(self, by: Rotation) -> Vec2 {
        vec2(by.cos * self.x - by.sin * self.y, by.sin * self.x + by.cos * self.y)
    }

    /// Returns whether both components are finite.
    pub fn is_finite(self) -> bool {
        self.x.is_finite() && self.y.is_finite()
    }
}

/// \[rad\] The largest angle for [`Rotation::further`].
pub const SMALL_TURN: f64 = 1e-3;

/// \[rad\] Below this, splitting a quarter turn into two parts causes no error.
const FEW_TURNS: f64 = 1000.0;

/// Taylor series of (sin x − x)/x³ in x²; its error is below 1e-19 for an eighth of a turn.
const SINE: [f64; 8] = [
    -1.0 / 6.0,
    1.0 / 120.0,
    -1.0 / 5040.0,
    1.0 / 362_880.0,
    -1.0 / 39_916_800.0,
    1.0 / 6_227_020_800.0,
    -1.0 / 1_307_674_368_000.0,
    1.0 / 355_687_428_096_000.0,
];
/// Taylor series of (cos x − 1 + x²/2)/x⁴ in x²; its error is below 3e-18.
const COSINE: [f64; 7] = [
    1.0 / 24.0,
    -1.0 / 720.0,
    1.0 / 40_320.0,
    -1.0 / 3_628_800.0,
    1.0 / 479_001_600.0,
    -1.0 / 87_178_291_200.0,
    1.0 / 20_922_789_888_000.0,
];

/// Horner's rule.
#[inline]
fn polynomial(coefficients: &[f64], x: f64) -> f64 {
    coefficients.iter().rev().fold(0.0, |sum, coefficient| sum * x + coefficient)
}

/// A rotation, counter-clockwise, by its sine and cosine.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rotation {
    /// Sine of the angle.
    pub sin: f64,
    /// Cosine of the angle.
    pub cos: f64,
}

impl Rotation {
    /// The identity.
    pub const NONE: Rotation = Rotation { sin: 0.0, cos: 1.0 };

    /// Returns the rotation by an angle \[rad\], accurate to about 1e-16. It uses its own polynomials and `libm`, not
    /// the platform's library: the result is the same bits on every machine.
    #[inline]
    pub fn by(angle: f64) -> Rotation {
        if angle.abs() < FEW_TURNS {
            return Rotation::by_few_turns(angle);
        }
        let (sin, cos) = libm::sincos(angle);
        Rotation { sin, cos }
    }

    /// Returns the rotation turned further by a small angle \[rad\], normalized to first order. An angle of
    /// `SMALL_TURN` causes an error of 1e-17 in the angle.
    #[inline]
    pub fn further(self, angle: f64) -> Rotation {
        let square = angle * angle;
        let sin = angle - angle * square * (1.0 / 6.0);
        let cos = 1.0 - square * (0.5 - square * (1.0 / 24.0));
        let (s, c) = (self.sin * cos + self.cos * sin, self.cos * cos - self.sin * sin);
        let longer = 1.5 - 0.5 * (s * s + c * c);
        Rotation { sin: s * longer, cos: c * longer }
    }

    /// Computes the rotation without the special cases of `libm`: polynomials for the remaining angle of at most an eighth of a turn.
    #[inline]
    fn by_few_turns(angle: f64) -> Rotation {
        use std::f64::consts::FRAC_2_PI;
        // Adding and subtracting rounds to a whole number of quarter turns; the low bits of the sum contain that
        // number.
        const ROUND: f64 = 1.5 * (1u64 << 52) as f64;
        // A quarter turn as a sum of two parts. The first has 33 bits, so that its multiples are exact.
        const QUARTER: f64 = 1.570_796_326_734_125_6;
        const QUARTER_REST: f64 = 6.077_100_506_506_192e-11;
        let shifted = angle * FRAC_2_PI + ROUND;
        let quarters = shifted - ROUND;
        let rest = (angle - quarters * QUARTER) - quarters * QUARTER_REST;
        let square = rest * rest;
        let sin = rest + rest * square * polynomial(&SINE, square);
        let cos = 1.0 - 0.5 * square + square * square * polynomial(&COSINE, square);
        let quarters = shifted.to_bits();
        let (sin, cos) = if quarters & 1 == 0 { (sin, cos) } else { (cos, -sin) };
        let sign = (quarters & 2) << 62;
        Rotation { sin: f64::from_bits(sin.to_bits() ^ sign), cos: f64::from_bits(cos.to_bits() ^ sign) }
    }
}

impl Add for Vec2 {
    type Output = Vec2;
    #[inline]
    fn add(self, other: Vec2) -> Vec2 {
        vec2(self.x + other.x, self.y + other.y)
    }
}

impl Sub for Vec2 {
    type Output = Vec2;
    #[inline]
    fn sub(self, other: Vec2) -> Vec2 {
        vec2(self.x - other.x, self.y - other.y)
    }
}

impl Neg for Vec2 {
    type Output = Vec2;
    #[inline]
    fn neg(self) -> Vec2 {
        vec2(-self.x, -self.y)
    }
}

impl Mul<f64> for Vec2 {
    type Output = Vec2;
    #[inline]
    fn mul(self, factor: f64) -> Vec2 {
        vec2(self.x * factor, self.y * factor)
    }
}

impl AddAssign for Vec2 {
    #[inline]
    fn add_assign(&mut self, other: Vec2) {
        *self = *self + other;
    }
}

impl SubAssign for Vec2 {
    #[inline]
    fn sub_assign(&mut self, other: Vec2) {
        *self = *self - other;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn turns_are_those_of_libm() {
        let mut worst = 0.0f64;
        for k in -400_000..=400_000 {
            let angle = f64::from(k) * 0.002_499_99;
            let (turn, (sin, cos)) = (Rotation::by(angle), libm::sincos(angle));
            worst = worst.max((turn.sin - sin).abs()).max((turn.cos - cos).abs());
        }
        assert!(worst < 2.3e-16, "{worst}");
        assert_eq!(Rotation::by(0.0), Rotation { sin: 0.0, cos: 1.0 });
        assert!(Rotation::by(f64::NAN).sin.is_nan());
        assert!(Rotation::by(f64::INFINITY).cos.is_nan());
    }
}
