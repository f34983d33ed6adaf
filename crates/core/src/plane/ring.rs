//! Closed polygons.

use crate::plane::{Bounds, Vec2, nearest_on_segment, ray_crosses, segments_touch, turn, vec2};

/// A closed polygon, clockwise or counter-clockwise.
#[derive(Debug, Clone, PartialEq)]
pub struct Ring {
    /// The first corner is repeated at the end.
    corners: Vec<Vec2>,
}

/// The place on a rim that is nearest to a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Foot {
    /// The side that it is on: 0 begins at the first corner.
    pub side: usize,
    /// \[m\] From the beginning of that side.
    pub along: f64,
    /// \[m\]
    pub place: Vec2,
    /// \[m\] From the point.
    pub distance: f64,
}

/// Returns the corners \[m\]; the first is repeated at the end, as that of a closed wall.
impl AsRef<[Vec2]> for Ring {
    fn as_ref(&self) -> &[Vec2] {
        &self.corners
    }
}

impl Ring {
    /// Makes a ring through corners \[m\]; the first may be repeated at the end. Returns `None` without corners.
    pub fn through(mut corners: Vec<Vec2>) -> Option<Ring> {
        let first = *corners.first()?;
        if corners.len() < 2 || corners[corners.len() - 1] != first {
            corners.push(first);
        }
        Some(Ring { corners })
    }

    /// Returns the ring of a line [that is closed](is_closed).
    pub fn of_closed(line: &[Vec2]) -> Option<Ring> {
        is_closed(line).then(|| Ring { corners: line.to_vec() })
    }

    /// Returns the rim of a rectangle, counter-clockwise from the lowest corner.
    pub fn around(Bounds { low, high }: Bounds) -> Ring {
        Ring { corners: vec![low, vec2(high.x, low.y), high, vec2(low.x, high.y), low] }
    }

    /// Returns the ring in the other direction, from what was its last corner.
    pub fn reversed(mut self) -> Ring {
        self.corners.pop();
        self.corners.reverse();
        self.corners.push(self.corners[0]);
        self
    }

    /// Returns the corners \[m\]; the first is repeated at the end.
    pub fn closed(&self) -> &[Vec2] {
        &self.corners
    }

    /// Returns the corners \[m\] without repeating the first.
    pub fn corners(&self) -> &[Vec2] {
        &self.corners[..self.corners.len() - 1]
    }

    /// Returns the sides \[m\], from each corner to the next.
    pub fn sides(&self) -> impl Iterator<Item = (Vec2, Vec2)> + Clone {
        self.corners.windows(2).map(|side| (side[0], side[1]))
    }

    /// Returns the area \[m²\], positive if the ring is counter-clockwise.
    pub fn signed_area(&self) -> f64 {
        // Relative to a corner, so that no digits are lost far from the origin.
        let origin = self.corners[0];
        0.5 * self.sides().map(|(a, b)| turn(origin, a, b)).sum::<f64>()
    }

    /// Returns the area \[m²\].
    pub fn area(&self) -> f64 {
        self.signed_area().abs()
    }

    /// Returns the bounding rectangle \[m\].
    pub fn bounds(&self) -> Bounds {
        let nowhere = Bounds { low: self.corners[0], high: self.corners[0] };
        Bounds::of(self.corners.iter().copied()).unwrap_or(nowhere)
    }

    /// Returns whether a point \[m\] lies inside: a ray to the right crosses the ring an odd number of times. On the
    /// rim the result may be either.
    pub fn contains(&self, p: Vec2) -> bool {
        self.sides().filter(|&(a, b)| ray_crosses(p, a, b)).count() % 2 == 1
    }

    /// Returns the place on the rim nearest to a point \[m\]: of several, that on the first side. A point that is not a
    /// number is infinitely far.
    pub fn nearest(&self, p: Vec2) -> Foot {
        nearest_on_line(&self.corners, p)
    }

    /// Returns whether it is a rectangle parallel to the axes, corner by corner.
    pub fn is_upright(&self) -> bool {
        let level = |first: usize| {
            let mut sides = self.sides().enumerate();
            sides.all(|(k, (a, b))| if k % 2 == first { a.y == b.y } else { a.x == b.x })
        };
        self.corners().len() == 4 && (level(0) || level(1))
    }

    /// Returns whether the rims have a common point.
    pub fn touches(&self, other: &Ring) -> bool {
        self.sides().any(|(a, b)| other.sides().any(|(c, d)| segments_touch(a, b, c, d)))
    }
}

/// Returns the place on a polyline through corners \[m\] that is nearest to a point, as [`Ring::nearest`]; infinitely far
/// without sides.
pub fn nearest_on_line(corners: &[Vec2], p: Vec2) -> Foot {
    let first = corners.first().copied().unwrap_or(Vec2::zeros());
    let far = Foot { side: 0, along: 0.0, place: first, distance: f64::INFINITY };
    corners.windows(2).enumerate().fold(far, |best, (side, ends)| {
        let place = nearest_on_segment(ends[0], ends[1], p);
        let distance = (p - place).norm();
        if distance < best.distance {
            Foot { side, along: (place - ends[0]).norm(), place, distance }
        } else {
            best
        }
    })
}

/// Returns whether a line ends where it begins, and has an inside.
pub fn is_closed(line: &[Vec2]) -> bool {
    line.len() > 3 && line.first() == line.last()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plane::vec2;

    fn ring(corners: &[(f64, f64)]) -> Ring {
        Ring::through(corners.iter().map(|&(x, y)| vec2(x, y)).collect()).unwrap()
    }

    #[test]
    fn area_and_sense_of_an_l() {
        let l = ring(&[(0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (1.0, 1.0), (1.0, 3.0), (0.0, 3.0)]);
        assert_eq!((l.signed_area(), l.corners().len(), l.closed().len()), (4.0, 6, 7));
        let turned = l.clone().reversed();
        assert_eq!((turned.signed_area(), turned.area()), (-4.0, 4.0));
        assert_eq!(l.bounds(), Bounds { low: vec2(0.0, 0.0), high: vec2(2.0, 3.0) });
        assert!(l.contains(vec2(0.5, 2.5)) && l.contains(vec2(1.5, 0.5)) && !l.contains(vec2(1.5, 1.5)));
        // The first corner given twice is the same ring.
        assert_eq!(ring(&[(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (0.0, 0.0)]).corners().len(), 3);
        assert_eq!(Ring::through(Vec::new()), None);
    }

    #[test]
    fn the_nearest_place_is_on_the_nearest_side() {
        let room = ring(&[(0.0, 0.0), (4.0, 0.0), (4.0, 3.0), (0.0, 3.0)]);
        let foot = room.nearest(vec2(4.5, 1.0));
        assert_eq!(foot, Foot { side: 1, along: 1.0, place: vec2(4.0, 1.0), distance: 0.5 });
        // Beyond a corner, that corner: the end of one side and the beginning of the next.
        let foot = room.nearest(vec2(7.0, -4.0));
        assert_eq!(foot, Foot { side: 0, along: 4.0, place: vec2(4.0, 0.0), distance: 5.0 });
        assert_eq!(room.nearest(vec2(f64::NAN, 1.0)).distance, f64::INFINITY);
        // Corners that lie on each other.
        assert_eq!(ring(&[(1.0, 1.0), (1.0, 1.0), (1.0, 1.0)]).nearest(vec2(1.0, 3.0)).distance, 2.0);
    }

    #[test]
    fn upright_is_what_has_four_corners_and_only_level_and_upright_sides() {
        assert!(ring(&[(0.0, 0.0), (4.0, 0.0), (4.0, 3.0), (0.0, 3.0)]).is_upright());
        assert!(ring(&[(4.0, 3.0), (4.0, 0.0), (0.0, 0.0), (0.0, 3.0)]).is_upright());
        assert!(!ring(&[(0.0, 0.0), (4.0, 0.0), (4.0, 3.0), (0.0, 3.001)]).is_upright());
        assert!(!ring(&[(0.0, 0.0), (2.0, 0.0), (4.0, 0.0), (4.0, 3.0), (0.0, 3.0)]).is_upright());
    }
}
