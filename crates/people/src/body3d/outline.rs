//! Closed outlines: ovals about a centre, and their girths.

use lemons_core::distribution::bisected;
use lemons_core::plane::{Vec2, vec2};
use std::f64::consts::PI;

/// Number of points of an outline.
pub(super) const POINTS: usize = 64;

/// \[m\] The points of an outline, counter-clockwise; the first is straight ahead.
pub(super) type Points = [Vec2; POINTS];

/// Number of points of a quarter of an outline, including both ends.
const QUARTER: usize = POINTS / 4 + 1;

/// Unit vectors towards the points of an outline. They are denser towards the sides (`denser` positive) or towards
/// front and back (negative). The four quarters are exact mirror images.
pub(super) fn directions(denser: f64) -> Points {
    let quarter: [Vec2; QUARTER] = std::array::from_fn(|k| {
        let even = 2.0 * PI * k as f64 / POINTS as f64;
        let (sin, cos) = libm::sincos(even + denser * libm::sin(2.0 * even));
        match k {
            0 => vec2(1.0, 0.0),
            k if k == POINTS / 4 => vec2(0.0, 1.0),
            _ => vec2(cos, sin),
        }
    });
    std::array::from_fn(|k| {
        let way = quarter[in_quarter(k)];
        let ahead = if k > POINTS / 4 && k < 3 * POINTS / 4 { -way.x } else { way.x };
        vec2(ahead, if k > POINTS / 2 { -way.y } else { way.y })
    })
}

/// The index in the first quarter whose mirror image is point `k`.
fn in_quarter(k: usize) -> usize {
    let half = k.min(POINTS - k);
    half.min(POINTS / 2 - half)
}

/// The mirror image of an outline (left and right exchanged), still counter-clockwise.
pub(super) fn mirrored(points: &Points) -> Points {
    std::array::from_fn(|k| {
        let from = points[(POINTS - k) % POINTS];
        vec2(from.x, -from.y)
    })
}

/// A superellipse at an altitude: |x/depth|ⁿ + |y/breadth|ⁿ = 1 about its centre, with half axes.
#[derive(Debug, Clone, Copy)]
pub(super) struct Oval {
    /// \[m\] altitude.
    pub z: f64,
    /// \[m\] centre.
    pub centre: Vec2,
    /// \[m\] half axis to the sides.
    pub breadth: f64,
    /// \[m\] half axis to front and back.
    pub depth: f64,
    /// The exponent n: 2 is an ellipse; a larger one is closer to a box.
    pub fullness: f64,
}

impl Oval {
    /// An ellipse by its full breadth and depth.
    pub(super) fn new(z: f64, centre: Vec2, breadth: f64, depth: f64) -> Oval {
        Oval { z, centre, breadth: breadth / 2.0, depth: depth / 2.0, fullness: 2.0 }
    }

    /// An ellipse of a girth; `deeper` is depth / breadth.
    pub(super) fn of_girth(z: f64, centre: Vec2, girth: f64, deeper: f64) -> Oval {
        let breadth = girth / ellipse_girth(0.5, deeper / 2.0);
        Oval::new(z, centre, breadth, breadth * deeper)
    }

    /// The same with another exponent.
    pub(super) fn full(self, fullness: f64) -> Oval {
        Oval { fullness, ..self }
    }

    /// Changes the exponent so that the outline has this girth, between those of an ellipse and of `MAX_FULLNESS`.
    pub(super) fn with_girth(self, girth: f64) -> Oval {
        let ways = directions(0.0);
        let (low, high) = bisected([2.0, MAX_FULLNESS], 12, |full| self.full(full).girth(&ways) < girth);
        self.full(0.5 * (low + high))
    }

    /// Scaled about its centre.
    pub(super) fn grown(self, factor: f64) -> Oval {
        Oval { breadth: self.breadth * factor, depth: self.depth * factor, ..self }
    }

    fn girth(self, ways: &Points) -> f64 {
        let quarter: [Vec2; QUARTER] = std::array::from_fn(|k| ways[k] * self.reach(ways[k]));
        4.0 * quarter.windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum::<f64>()
    }

    /// Distance \[m\] from the centre to the outline along a unit vector.
    fn reach(self, way: Vec2) -> f64 {
        let (x, y) = (way.x.abs() / self.depth, way.y.abs() / self.breadth);
        if self.fullness == 2.0 {
            return 1.0 / (x * x + y * y).sqrt();
        }
        let sum = libm::pow(x, self.fullness) + libm::pow(y, self.fullness);
        libm::pow(sum, -1.0 / self.fullness)
    }

    /// Distance \[m\] from a point to the far side of the ellipse (ignoring the exponent) along a unit vector, if the
    /// line meets it ahead.
    pub(super) fn far_side(self, from: Vec2, way: Vec2) -> Option<f64> {
        let scaled = |v: Vec2| vec2(v.x / self.depth, v.y / self.breadth);
        let (start, way) = (scaled(from - self.centre), scaled(way));
        let (a, b, c) = (way.dot(&way), start.dot(&way), start.dot(&start) - 1.0);
        let discriminant = b * b - a * c;
        if discriminant < 0.0 {
            return None;
        }
        let far = (-b + discriminant.sqrt()) / a;
        (far > 0.0).then_some(far)
    }

    /// Distances \[m\] from its centre to its points in the given [`directions`].
    pub(super) fn reaches(self, ways: &Points) -> [f64; POINTS] {
        let quarter: [f64; QUARTER] = std::array::from_fn(|k| self.reach(ways[k]));
        std::array::from_fn(|k| quarter[in_quarter(k)])
    }

    /// Its points in the given [`directions`].
    pub(super) fn points(self, ways: &Points) -> Points {
        let reaches = self.reaches(ways);
        std::array::from_fn(|k| self.centre + ways[k] * reaches[k])
    }
}

/// An outline with a larger exponent is a box, not a body.
const MAX_FULLNESS: f64 = 3.0;

/// \[m\] Circumference of an ellipse from its half axes: Ramanujan (1914), accurate to 1e-5 for these shapes.
fn ellipse_girth(a: f64, b: f64) -> f64 {
    PI * (3.0 * (a + b) - ((3.0 * a + b) * (a + 3.0 * b)).sqrt())
}

/// \[m\] Full depth of the ellipse with this breadth and girth, limited to `least` and `most` times the breadth.
pub(super) fn depth_of_girth(breadth: f64, girth: f64, least: f64, most: f64) -> f64 {
    let (low, high) = bisected([least * breadth, most * breadth], 40, |depth| {
        ellipse_girth(breadth / 2.0, depth / 2.0) < girth
    });
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn girths_are_those_of_closed_forms() {
        let ways = directions(0.0);
        let circle = Oval::new(0.0, Vec2::zeros(), 0.2, 0.2);
        assert!((circle.girth(&ways) - PI * 0.2).abs() < 1e-3 * PI * 0.2);
        assert!((ellipse_girth(0.1, 0.1) - PI * 0.2).abs() < 1e-15);
        // 4 a E(e), a = 2, b = 1: 9.688448220547...
        assert!((ellipse_girth(2.0, 1.0) - 9.688_448_220_547).abs() < 1e-4);
        assert!((depth_of_girth(4.0, 9.688_448_220_547, 0.3, 2.0) - 2.0).abs() < 1e-4);
        let girthed = Oval::of_girth(0.0, Vec2::zeros(), 0.5, 1.2);
        assert!(
            (girthed.girth(&ways) - 0.5).abs() < 1e-3
                && (girthed.depth / girthed.breadth - 1.2).abs() < 1e-12
        );
        let full = Oval::new(0.0, Vec2::zeros(), 0.33, 0.24).with_girth(0.94);
        assert!((full.girth(&ways) - 0.94).abs() < 1e-3 && full.fullness > 2.0, "{full:?}");
    }
}
