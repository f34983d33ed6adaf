//! Convex hulls.

use crate::plane::{Vec2, turn};

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

    proptest! {
        #![proptest_config(ProptestConfig { rng_seed: RngSeed::Fixed(7), ..ProptestConfig::default() })]

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
