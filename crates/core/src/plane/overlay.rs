//! Unions, intersections and differences of polygons, and polygons between lines: the one place that calls `i_overlay`, whose generic code takes
//! seconds to build for each type of number and of polygon.
//!
//! Corners are rounded to a grid of 64-bit integers over all contours: better than a nanometre, and the same on every
//! machine.

use super::{Ring, vec2};
use i_overlay::core::fill_rule::FillRule;
use i_overlay::core::overlay_rule::OverlayRule;
use i_overlay::float::overlay::{FloatOverlay, OverlayOptions};
use i_overlay::float::slice::FloatSlice;

/// The corners of a ring \[m\]; the first one is not repeated.
pub type Contour = Vec<[f64; 2]>;

/// Polygons that contours become: of each its rim, then its holes.
pub type Polygons = Vec<Vec<Contour>>;

/// Rule of what is inside of several contours.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum InsideRule {
    /// What an odd number of contours goes around.
    EvenOdd,
    /// What contours go around, where a clockwise one counts against the others.
    NonZero,
}

/// Returns what is inside of the contours ([`InsideRule::NonZero`]).
pub fn union(contours: &[Contour]) -> Polygons {
    overlay(contours, &[], OverlayRule::Subject, InsideRule::NonZero, OverlayOptions::default())
}

/// Returns what is inside of both.
pub fn intersection(one: &[Contour], other: &[Contour], fill: InsideRule) -> Polygons {
    overlay(one, other, OverlayRule::Intersect, fill, OverlayOptions::default())
}

/// Returns what is inside of the first and not of the other.
pub fn difference(one: &[Contour], other: &[Contour], fill: InsideRule) -> Polygons {
    overlay(one, other, OverlayRule::Difference, fill, OverlayOptions::default())
}

/// Returns what is inside of the first and not of the other ([`InsideRule::NonZero`]), parted where it hangs together in a point
/// only: no contour touches itself.
pub(super) fn parted(one: &[Contour], other: &[Contour]) -> Polygons {
    overlay(one, other, OverlayRule::Difference, InsideRule::NonZero, OverlayOptions::ogc())
}

fn overlay(
    one: &[Contour],
    other: &[Contour],
    rule: OverlayRule,
    fill: InsideRule,
    options: OverlayOptions<f64, i64>,
) -> Polygons {
    let fill = match fill {
        InsideRule::EvenOdd => FillRule::EvenOdd,
        InsideRule::NonZero => FillRule::NonZero,
    };
    let solver = Default::default();
    FloatOverlay::from_subj_and_clip_custom(one, other, options, solver).overlay(rule, fill)
}

/// Returns the parts into which lines cut what is inside of a contour. Ends of lines within a part are not seen.
pub fn cut(contour: &Contour, lines: &[Contour]) -> Polygons {
    contour.slice_by_as::<i64>(&lines.to_vec(), FillRule::NonZero)
}

/// Returns the corners of a ring.
pub fn contour(ring: &Ring) -> Contour {
    ring.corners().iter().map(|corner| [corner.x, corner.y]).collect()
}

/// Returns the ring of a contour; `None` if it has fewer than three corners.
pub fn ring(contour: &Contour) -> Option<Ring> {
    Ring::through(contour.iter().map(|[x, y]| vec2(*x, *y)).collect())
}

/// Returns the area of a polygon without its holes \[m²\].
pub fn area(polygon: &[Contour]) -> f64 {
    let mut areas = polygon.iter().map(|contour| ring(contour).map_or(0.0, |ring| ring.area()));
    areas.next().unwrap_or(0.0) - areas.sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plane::Bounds;

    fn square(low: f64, high: f64) -> Contour {
        contour(&Ring::around(Bounds { low: vec2(low, low), high: vec2(high, high) }))
    }

    /// Squares from 0 to 4, from 2 to 6, and a hole of the first from 1 to 2.
    #[test]
    fn squares_overlap() {
        let (one, other) = ([square(0.0, 4.0), square(1.0, 2.0)], [square(2.0, 6.0)]);
        let sum = |polygons: Polygons| polygons.iter().map(|polygon| area(polygon)).sum::<f64>();
        for (what, left, expected) in [
            ("both", intersection(&one, &other, InsideRule::EvenOdd), 4.0),
            ("the first", difference(&one, &other, InsideRule::EvenOdd), 15.0 - 4.0),
            ("the first, filled", difference(&one, &other, InsideRule::NonZero), 16.0 - 4.0),
            ("any", union(&[one.as_slice(), &other].concat()), 16.0 + 16.0 - 4.0),
        ] {
            let found = sum(left);
            assert!((found - expected).abs() < 1e-12, "{what}: {found}");
        }
        assert_eq!(union(&[]), Polygons::new());
    }

    #[test]
    fn lines_cut_a_square() {
        let around = square(-1.0, 11.0);
        let closed = |low, high| {
            let mut line = square(low, high);
            line.push(line[0]);
            line
        };
        // A room in a room with a column, a partition with an end that is free, lines that go too far, one in two.
        let lines = [
            closed(0.0, 10.0),
            closed(1.0, 9.0),
            closed(4.0, 5.0),
            vec![[1.0, 2.0], [3.0, 2.0]],
            vec![[7.0, 0.5], [7.0, 9.5]],
            vec![[8.0, 8.0], [8.5, 8.5]],
            vec![[4.0, 4.0], [5.0, 5.0]],
        ];
        let parts = cut(&around, &lines);
        let mut areas: Vec<f64> = parts.iter().map(|polygon| area(polygon)).collect();
        areas.sort_by(f64::total_cmp);
        let by_hand = [0.5, 0.5, 16.0, 36.0, 144.0 - 100.0, 47.0];
        assert_eq!(areas.len(), by_hand.len(), "{areas:?}");
        assert!(areas.iter().zip(by_hand).all(|(a, b)| (a - b).abs() < 1e-9), "{areas:?}");
    }
}
