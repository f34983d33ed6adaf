//! Line segments.

use crate::Vec2;

/// Returns twice the area of the triangle `a b c` \[m²\]: positive if `c` lies to the left of the line from `a` to `b`.
#[inline]
pub fn turn(a: Vec2, b: Vec2, c: Vec2) -> f64 {
    (b - a).cross(c - a)
}

/// Returns whether the segments `a b` and `c d` have a common point.
pub fn segments_touch(a: Vec2, b: Vec2, c: Vec2, d: Vec2) -> bool {
    let on = |p: Vec2, q: Vec2, r: Vec2| {
        turn(p, q, r) == 0.0
            && r.x >= p.x.min(q.x)
            && r.x <= p.x.max(q.x)
            && r.y >= p.y.min(q.y)
            && r.y <= p.y.max(q.y)
    };
    let (c_side, d_side) = (turn(a, b, c), turn(a, b, d));
    let (a_side, b_side) = (turn(c, d, a), turn(c, d, b));
    (c_side * d_side < 0.0 && a_side * b_side < 0.0)
        || on(a, b, c)
        || on(a, b, d)
        || on(c, d, a)
        || on(c, d, b)
}

/// Returns the point of the segment `a b` nearest to `p`; `a` if the segment has no length.
#[inline]
pub fn nearest_on_segment(a: Vec2, b: Vec2, p: Vec2) -> Vec2 {
    let along = b - a;
    let square = along.norm_squared();
    let share = if square > 0.0 { ((p - a).dot(along) / square).clamp(0.0, 1.0) } else { 0.0 };
    a + along * share
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vec2;

    #[test]
    fn pieces_touch_where_they_cross_meet_or_lie_on_each_other() {
        let [o, e, n, ne] = [vec2(0.0, 0.0), vec2(1.0, 0.0), vec2(0.0, 1.0), vec2(1.0, 1.0)];
        assert!(segments_touch(o, ne, e, n));
        assert!(segments_touch(o, e, e, ne));
        assert!(segments_touch(o, e, vec2(0.5, 0.0), vec2(0.5, 2.0)));
        assert!(segments_touch(o, e, vec2(0.25, 0.0), vec2(0.75, 0.0)));
        assert!(!segments_touch(o, e, n, ne));
        assert!(!segments_touch(o, e, vec2(1.5, 0.0), vec2(2.0, 0.0)));
        assert!(!segments_touch(o, e, vec2(0.5, 1e-9), vec2(0.5, 1.0)));
    }

    #[test]
    fn the_nearest_point_is_within_the_piece() {
        let (a, b) = (vec2(0.0, 0.0), vec2(2.0, 0.0));
        assert_eq!(nearest_on_segment(a, b, vec2(0.5, 3.0)), vec2(0.5, 0.0));
        assert_eq!(nearest_on_segment(a, b, vec2(-1.0, 3.0)), a);
        assert_eq!(nearest_on_segment(a, b, vec2(5.0, -3.0)), b);
        assert_eq!(nearest_on_segment(a, a, b), a);
    }
}
