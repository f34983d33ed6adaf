//! Convex hulls.

use crate::plane::{InPlane, Vec2, nearest_on_segment, turn};
use std::f64::consts::FRAC_PI_2;

/// Steps in which the end of a hull on a line is looked for: to the last digits.
const STEPS: u32 = 90;
/// \[m\] A segment that reaches less far into a hull only touches it.
const ROUNDING: f64 = 1e-9;

/// Returns the corners \[m\] of the smallest convex set that contains some finite points (A. M. Andrew, Inf. Process.
/// Lett. 9 (1979) 216): counter-clockwise from the leftmost one (the lowest of several), without repeating it; none lies
/// on the line between its neighbours. There is one if all points coincide, and there are two if they lie on a line.
pub fn convex_hull(points: impl IntoIterator<Item = Vec2>) -> Vec<Vec2> {
    let mut points: Vec<Vec2> = points.into_iter().collect();
    points.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    points.dedup();
    if points.len() < 3 {
        return points;
    }
    let half = |points: &mut dyn Iterator<Item = Vec2>| {
        let mut side: Vec<Vec2> = Vec::new();
        for p in points {
            while let [.., a, b] = side[..]
                && turn(a, b, p) <= 0.0
            {
                side.pop();
            }
            side.push(p);
        }
        side
    };
    let mut corners = half(&mut points.iter().copied());
    let upper = half(&mut points.iter().rev().copied());
    corners.extend(&upper[1..upper.len() - 1]);
    corners
}

/// Returns whether a body of disks, given by centres and radii \[m\], is on a segment from `a` to `b` \[m\]: a disk touches
/// it, or it passes between them.
pub fn body_meets(disks: &[(Vec2, f64)], a: Vec2, b: Vec2) -> bool {
    let touches =
        |&(centre, radius): &(Vec2, f64)| (nearest_on_segment(a, b, centre) - centre).norm() < radius;
    disks.iter().any(touches) || hull_meets(disks, a, b)
}

/// Returns whether a body of disks, given by centres and radii \[m\], has room at a place \[m\]: it touches none of the walls,
/// given by their ends, and nobody. Of the others are given the place, how far they reach from it, and their disks; both
/// with the distance that is to be kept from them.
pub fn has_room<D: Iterator<Item = (Vec2, f64)>>(
    at: Vec2,
    disks: &[(Vec2, f64)],
    mut walls: impl Iterator<Item = [Vec2; 2]>,
    mut others: impl Iterator<Item = (Vec2, f64, D)>,
) -> bool {
    let reach = disks.iter().map(|(own, radius)| (own - at).norm() + radius).fold(0.0, f64::max);
    let clear = |(there, theirs): (Vec2, f64)| {
        disks.iter().all(|(own, radius)| (there - own).norm() >= radius + theirs)
    };
    walls.all(|[a, b]| (nearest_on_segment(a, b, at) - at).norm() > reach || !body_meets(disks, a, b))
        && others.all(|(there, theirs, mut all)| (there - at).norm() >= reach + theirs || all.all(clear))
}

/// Returns whether a segment from `a` to `b` \[m\] reaches into the convex hull of disks, given by centres and radii \[m\],
/// also where it passes between them.
pub fn hull_meets(disks: &[(Vec2, f64)], a: Vec2, b: Vec2) -> bool {
    let Some(along) = (b - a).unit(0.0) else { return false };
    let across = along.left();
    let support = |way: Vec2| {
        disks
            .iter()
            .map(|&(centre, radius)| (centre - a).dot(&way) + radius)
            .fold(f64::NEG_INFINITY, f64::max)
    };
    // How far the hull reaches on the segment's line: as far as the nearest of the tangents that cut it. That is a function
    // of the tangent's angle with one minimum.
    let end = |along: Vec2| {
        let at =
            |angle: f64| support(along * libm::cos(angle) + across * libm::sin(angle)) / libm::cos(angle);
        let (mut low, mut high) = (-FRAC_PI_2, FRAC_PI_2);
        for _ in 0..STEPS {
            let third = (high - low) / 3.0;
            let [left, right] = [low + third, high - third];
            if at(left) < at(right) { high = right } else { low = left }
        }
        at(0.5 * (low + high))
    };
    let both_sides = support(across).min(support(-across)) > 0.0;
    both_sides && end(along) > ROUNDING && -end(-along) < (b - a).norm() - ROUNDING
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plane::vec2;
    use proptest::prelude::*;
    use proptest::test_runner::RngSeed;

    #[test]
    fn of_few_points() {
        assert!(convex_hull([]).is_empty());
        assert_eq!(convex_hull([vec2(1.0, 2.0); 3]), [vec2(1.0, 2.0)]);
        assert_eq!(convex_hull((0..5).map(|k| vec2(f64::from(k), 0.0))), [vec2(0.0, 0.0), vec2(4.0, 0.0)]);
    }

    /// The outside: by hand. Of disks of 0.1 m that are 1 m apart the hull is 0.2 m wide.
    #[test]
    fn a_segment_between_disks_meets_their_hull() {
        let disks = [(vec2(0.0, 0.0), 0.1), (vec2(1.0, 0.0), 0.1)];
        let meets = |x: f64, from: f64, to: f64| hull_meets(&disks, vec2(x, from), vec2(x, to));
        assert!(meets(0.5, -3.0, 3.0) && meets(0.5, -0.05, 0.05) && meets(0.5, 0.099, 3.0));
        assert!(!meets(0.5, 0.101, 3.0) && !meets(1.101, -3.0, 3.0) && meets(1.099, -3.0, 3.0));
        // Along it; beside its round end; touching; no length; nobody.
        assert!(!hull_meets(&disks, vec2(-1.0, 0.11), vec2(2.0, 0.11)));
        assert!(hull_meets(&disks, vec2(-1.0, 0.09), vec2(2.0, 0.09)));
        assert!(!hull_meets(&disks, vec2(1.08, 0.08), vec2(2.0, 1.0)));
        assert!(!hull_meets(&disks, vec2(0.3, 0.1), vec2(0.6, 0.1)) && !meets(0.5, 0.0, 0.0));
        assert!(!hull_meets(&[], vec2(0.0, 0.0), vec2(1.0, 0.0)));
        // A body is also on a point within a disk, as a wall may be, but not on one between two.
        let point = |x: f64| body_meets(&disks, vec2(x, 0.05), vec2(x, 0.05));
        assert!(point(0.0) && point(1.0) && !point(0.5) && !point(1.2));
        assert!(body_meets(&disks, vec2(0.5, -3.0), vec2(0.5, 3.0)));
        // It has no room at a wall's end between its disks, and at another one that is too near.
        let room = |walls: &[[Vec2; 2]], other: f64| {
            let other = (vec2(other, 0.0), 0.3, [(vec2(other, 0.0), 0.3)].into_iter());
            has_room(vec2(0.5, 0.0), &disks, walls.iter().copied(), std::iter::once(other))
        };
        assert!(room(&[], 1.401) && !room(&[], 1.399));
        let wall = |end: f64| [[vec2(0.5, 3.0), vec2(0.5, end)]];
        assert!(room(&wall(0.101), 2.0) && !room(&wall(0.099), 2.0));
    }

    proptest! {
        #![proptest_config(ProptestConfig { rng_seed: RngSeed::Fixed(7), ..ProptestConfig::default() })]

        /// The outside: the polygon through many points of the circles, which lies inside the hull by less than 0.2 mm.
        #[test]
        fn hulls_of_disks_are_those_of_their_points(
            disks in prop::collection::vec((-1.0..1.0, -1.0..1.0, 0.02..0.3), 1..8),
            ends in [(-2.0..2.0, -2.0..2.0), (-2.0..2.0, -2.0..2.0)],
        ) {
            let [a, b] = ends.map(|(x, y)| vec2(x, y));
            let around = |by: f64| convex_hull(disks.iter().flat_map(|&(x, y, radius): &(f64, f64, f64)| {
                (0..100).map(move |k| {
                    let angle = f64::from(k) / 100.0 * std::f64::consts::TAU;
                    vec2(x, y) + vec2(angle.cos(), angle.sin()) * (radius + by)
                })
            }));
            let meets = |corners: Vec<Vec2>| {
                let ring = crate::plane::Ring::through(corners).unwrap();
                ring.contains(a) || ring.sides().any(|(c, d)| crate::plane::segments_touch(a, b, c, d))
            };
            let disks: Vec<(Vec2, f64)> = disks.iter().map(|&(x, y, radius)| (vec2(x, y), radius)).collect();
            let (found, inner, outer) = (hull_meets(&disks, a, b), meets(around(-1e-6)), meets(around(2e-4)));
            prop_assert!(!inner || found, "not found");
            prop_assert!(outer || !found, "found {disks:?}");
        }

        /// By the definition: all corners are points, each turns left, and all points are on the left of every side.
        #[test]
        fn points_are_on_the_left_of_every_side(points in prop::collection::vec((-9i32..=9, -9i32..=9), 3..40)) {
            let points: Vec<Vec2> = points.iter().map(|&(x, y)| vec2(f64::from(x), f64::from(y))).collect();
            let corners = convex_hull(points.iter().copied());
            let n = corners.len();
            prop_assert!(corners.iter().all(|corner| points.contains(corner)));
            for k in 0..n {
                let (a, b, c) = (corners[k], corners[(k + 1) % n], corners[(k + 2) % n]);
                prop_assert!(n < 3 || turn(a, b, c) > 0.0);
                prop_assert!(points.iter().all(|p| turn(a, b, *p) >= 0.0), "{:?}", corners);
            }
        }
    }
}
