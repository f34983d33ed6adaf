//! Line segments.

use crate::plane::Vec2;

/// Returns twice the area of the triangle `a b c` \[m²\]: positive if `c` lies to the left of the line from `a` to `b`.
#[inline]
pub fn turn(a: Vec2, b: Vec2, c: Vec2) -> f64 {
    (b - a).perp(&(c - a))
}

/// Returns whether the segments `a b` and `c d` have a common point.
pub fn segments_touch(a: Vec2, b: Vec2, c: Vec2, d: Vec2) -> bool {
    // This is exact. Of points on one line, rounding may give turns of any sign.
    let apart = |a: f64, b: f64, c: f64, d: f64| a.max(b) < c.min(d) || c.max(d) < a.min(b);
    if apart(a.x, b.x, c.x, d.x) || apart(a.y, b.y, c.y, d.y) {
        return false;
    }
    let (c_side, d_side) = (turn(a, b, c), turn(a, b, d));
    // On one line. A point has no line.
    if c_side == 0.0 && d_side == 0.0 && a != b {
        return true;
    }
    let parts = |p: f64, q: f64| (p > 0.0 && q > 0.0) || (p < 0.0 && q < 0.0);
    !parts(c_side, d_side) && !parts(turn(c, d, a), turn(c, d, b))
}

/// Returns whether the segments `a b` and `c d` cross, and do not only touch.
pub fn segments_cross(a: Vec2, b: Vec2, c: Vec2, d: Vec2) -> bool {
    turn(a, b, c) * turn(a, b, d) < 0.0 && turn(c, d, a) * turn(c, d, b) < 0.0
}

/// Returns whether the ray from `p` in the direction of x crosses the segment `a b`. Of a segment's ends, only the lower
/// one belongs to it, so a ray through a corner crosses one of two sides, or both or neither.
#[inline]
pub fn ray_crosses(p: Vec2, a: Vec2, b: Vec2) -> bool {
    (a.y > p.y) != (b.y > p.y) && (turn(a, b, p) > 0.0) == (b.y > a.y)
}

/// Returns the point of the segment `a b` nearest to `p`; `a` if the segment has no length.
#[inline]
pub fn nearest_on_segment(a: Vec2, b: Vec2, p: Vec2) -> Vec2 {
    let along = b - a;
    let square = along.norm_squared();
    let share = if square > 0.0 { ((p - a).dot(&along) / square).clamp(0.0, 1.0) } else { 0.0 };
    a + along * share
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plane::vec2;

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
        // A point is on a piece, or only within its bounds.
        let (middle, beside) = (vec2(0.5, 0.5), vec2(0.75, 0.25));
        assert!(segments_touch(middle, middle, o, ne) && segments_touch(o, ne, middle, middle));
        assert!(!segments_touch(beside, beside, o, ne) && !segments_touch(o, ne, beside, beside));
        // Apart on one line: by their rounded turns they would cross.
        for places in [
            [(3.7, 16.2), (5.9, 25.44), (7.9, 33.84), (10.7, 45.6)],
            [(15.5, 24.979999999999997), (19.3, 34.1), (20.0, 35.78), (21.4, 39.14)],
        ] {
            let [a, b, c, d] = places.map(|(x, y)| vec2(x, y));
            assert!(!segments_touch(a, b, c, d) && !segments_touch(c, d, a, b), "{places:?}");
        }
        assert!(segments_cross(o, ne, e, n) && !segments_cross(o, e, e, ne));
        assert!(!segments_cross(o, e, vec2(0.5, 0.0), vec2(0.5, 2.0)));
    }

    #[test]
    fn a_ray_crosses_what_is_to_the_right() {
        let (low, high) = (vec2(1.0, 0.0), vec2(2.0, 2.0));
        for (a, b) in [(low, high), (high, low)] {
            assert!(ray_crosses(vec2(0.0, 1.0), a, b) && !ray_crosses(vec2(3.0, 1.0), a, b));
            assert!(ray_crosses(vec2(0.0, 0.0), a, b) && !ray_crosses(vec2(0.0, 2.0), a, b));
            assert!(!ray_crosses(vec2(0.0, -1.0), a, b));
        }
        assert!(!ray_crosses(vec2(0.0, 0.0), low, vec2(5.0, 0.0)));
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
