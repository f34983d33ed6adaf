//! Convex hulls.

use crate::plane::{Vec2, nearest_on_segment, turn};

/// The smallest convex set that contains some points.
#[derive(Debug, Clone, PartialEq)]
pub struct ConvexHull {
    /// Counter-clockwise from the leftmost point (the lowest of several); no corner lies on the line between its
    /// neighbours. The first is not repeated. If the points coincide there is one corner; if they lie on a line there
    /// are two.
    corners: Vec<Vec2>,
    /// Number of corners from the leftmost to the rightmost along the lower side, including both.
    lower: usize,
}

impl ConvexHull {
    /// Returns the hull of finite points \[m\] (A. M. Andrew, Inf. Process. Lett. 9 (1979) 216); `None` without any.
    pub fn of(points: impl IntoIterator<Item = Vec2>) -> Option<ConvexHull> {
        let mut points: Vec<Vec2> = points.into_iter().collect();
        points.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
        points.dedup();
        if points.len() < 3 {
            let lower = points.len();
            return (lower > 0).then_some(ConvexHull { corners: points, lower });
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
        let lower = corners.len();
        let upper = half(&mut points.iter().rev().copied());
        corners.extend(&upper[1..upper.len() - 1]);
        Some(ConvexHull { corners, lower })
    }

    /// Returns the corners \[m\], counter-clockwise, without repeating the first. There is one if all points coincide,
    /// and there are two if they lie on a line.
    pub fn corners(&self) -> &[Vec2] {
        &self.corners
    }

    /// Returns whether a point \[m\] lies inside or on the rim. It uses two binary searches, so it is fast for many
    /// points and corners.
    pub fn contains(&self, p: Vec2) -> bool {
        let (first, last) = (self.corners[0], self.corners[self.lower - 1]);
        if !(first.x <= p.x && p.x <= last.x) {
            return false;
        }
        if self.corners.len() < 3 {
            return nearest_on_segment(first, last, p) == p;
        }
        // The lower side goes to the right, the upper side back to the left.
        let lower = &self.corners[..self.lower];
        let above = {
            let next = lower.partition_point(|corner| corner.x < p.x).clamp(1, lower.len() - 1);
            turn(lower[next - 1], lower[next], p) >= 0.0
        };
        let upper = |k: usize| if k == self.corners.len() { first } else { self.corners[k] };
        let below = {
            let (mut low, mut high) = (self.lower - 1, self.corners.len());
            // The segment from `low` to `low + 1` is above or below the point.
            while high - low > 1 {
                let middle = low.midpoint(high);
                if upper(middle).x > p.x { low = middle } else { high = middle }
            }
            turn(upper(low), upper(high), p) >= 0.0
        };
        above && below
    }

    /// Returns the distance of a point from the hull \[m\]; 0 inside.
    pub fn distance(&self, p: Vec2) -> f64 {
        if self.contains(p) {
            return 0.0;
        }
        let last = self.corners[self.corners.len() - 1];
        let sides =
            std::iter::once(last).chain(self.corners.iter().copied()).zip(self.corners.iter().copied());
        sides.map(|(a, b)| (p - nearest_on_segment(a, b, p)).norm()).fold(f64::INFINITY, f64::min)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plane::vec2;
    use proptest::prelude::*;

    #[test]
    fn of_few_points() {
        assert_eq!(ConvexHull::of([]), None);
        let one = ConvexHull::of([vec2(1.0, 2.0); 3]).unwrap();
        assert_eq!(one.corners(), [vec2(1.0, 2.0)]);
        assert!(one.contains(vec2(1.0, 2.0)) && !one.contains(vec2(1.0, 2.1)));
        assert_eq!(one.distance(vec2(4.0, 6.0)), 5.0);
        let line = ConvexHull::of((0..5).map(|k| vec2(f64::from(k), 0.0))).unwrap();
        assert_eq!(line.corners(), [vec2(0.0, 0.0), vec2(4.0, 0.0)]);
        assert_eq!(line.distance(vec2(2.0, -3.0)), 3.0);
        assert!(line.contains(vec2(3.5, 0.0)) && !line.contains(vec2(3.5, 1e-9)));
        let upright = ConvexHull::of((0..5).map(|k| vec2(0.0, f64::from(k)))).unwrap();
        assert!(upright.contains(vec2(0.0, 3.5)) && !upright.contains(vec2(0.0, 4.5)));
    }

    proptest! {
        /// By the definition: on the left of every side.
        #[test]
        fn what_is_in_it_is_on_the_left_of_every_side(
            points in prop::collection::vec((-9i32..=9, -9i32..=9), 3..40),
            probe in (-10i32..=10, -10i32..=10),
        ) {
            let point = |(x, y): (i32, i32)| vec2(f64::from(x), f64::from(y));
            let hull = ConvexHull::of(points.iter().map(|p| point(*p))).unwrap();
            let corners = hull.corners();
            for &p in &points {
                prop_assert!(hull.contains(point(p)), "{:?} of {:?}", p, hull);
            }
            let n = corners.len();
            if n > 2 {
                for k in 0..n {
                    prop_assert!(turn(corners[k], corners[(k + 1) % n], corners[(k + 2) % n]) > 0.0);
                }
                let p = point(probe);
                let inside = (0..n).all(|k| turn(corners[k], corners[(k + 1) % n], p) >= 0.0);
                prop_assert_eq!(hull.contains(p), inside);
                prop_assert_eq!(hull.distance(p) == 0.0, inside);
            }
        }
    }
}
