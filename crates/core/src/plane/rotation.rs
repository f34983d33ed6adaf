//! Rotations of the plane.

use nalgebra::UnitComplex;

/// A rotation, counter-clockwise, by its cosine (`re`) and its sine (`im`). [`rotation`] makes it.
pub type Rotation = UnitComplex<f64>;

/// \[rad\] The largest angle for [`turned_by`].
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

/// Returns the rotation by an angle \[rad\], accurate to about 1e-16. It uses its own polynomials and `libm`, not
/// the platform's library, which `UnitComplex::new` may call: the result is the same bits on every machine.
#[inline]
pub fn rotation(angle: f64) -> Rotation {
    if angle.abs() < FEW_TURNS {
        return by_few_turns(angle);
    }
    let (sin, cos) = libm::sincos(angle);
    UnitComplex::from_cos_sin_unchecked(cos, sin)
}

/// Returns a rotation turned further by a small angle \[rad\], normalized to first order. An angle of `SMALL_TURN`
/// causes an error of 1e-17 in the angle.
#[inline]
pub fn turned_by(turned: Rotation, angle: f64) -> Rotation {
    let square = angle * angle;
    let sin = angle - angle * square * (1.0 / 6.0);
    let cos = 1.0 - square * (0.5 - square * (1.0 / 24.0));
    let (s, c) = (turned.im * cos + turned.re * sin, turned.re * cos - turned.im * sin);
    let longer = 1.5 - 0.5 * (s * s + c * c);
    UnitComplex::from_cos_sin_unchecked(c * longer, s * longer)
}

/// Computes the rotation without the special cases of `libm`: polynomials for the remaining angle of at most an eighth
/// of a turn.
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
    UnitComplex::from_cos_sin_unchecked(
        f64::from_bits(cos.to_bits() ^ sign),
        f64::from_bits(sin.to_bits() ^ sign),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn turns_are_those_of_libm() {
        let mut worst = 0.0f64;
        for k in -400_000..=400_000 {
            let angle = f64::from(k) * 0.002_499_99;
            let (turn, (sin, cos)) = (rotation(angle), libm::sincos(angle));
            worst = worst.max((turn.im - sin).abs()).max((turn.re - cos).abs());
        }
        assert!(worst < 2.3e-16, "{worst}");
        assert_eq!(rotation(0.0), Rotation::identity());
        assert!(rotation(f64::NAN).im.is_nan());
        assert!(rotation(f64::INFINITY).re.is_nan());
    }
}
