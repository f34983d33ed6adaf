//! Rectangles parallel to the axes.

use crate::plane::{Vec2, vec2};

/// The smallest rectangle parallel to the axes that contains some points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds {
    /// \[m\] the lowest x and y.
    pub low: Vec2,
    /// \[m\] the highest x and y.
    pub high: Vec2,
}

impl Bounds {
    /// A square with a side of 1 m about the origin: where nothing is.
    pub const UNIT: Bounds = Bounds { low: vec2(-0.5, -0.5), high: vec2(0.5, 0.5) };

    /// Returns the rectangle around points \[m\]; `None` without any.
    pub fn of(points: impl IntoIterator<Item = Vec2>) -> Option<Bounds> {
        let mut points = points.into_iter();
        let first = points.next()?;
        Some(points.fold(Bounds { low: first, high: first }, |Bounds { low, high }, p| Bounds {
            low: vec2(low.x.min(p.x), low.y.min(p.y)),
            high: vec2(high.x.max(p.x), high.y.max(p.y)),
        }))
    }

    /// Returns width and height \[m\].
    pub fn size(&self) -> Vec2 {
        self.high - self.low
    }

    /// Returns the coordinate of points along the longer side.
    pub fn longer(&self) -> impl Fn(Vec2) -> f64 + use<> {
        let along_x = self.size().x >= self.size().y;
        move |p| if along_x { p.x } else { p.y }
    }

    /// Returns the rectangle enlarged by a margin \[m\] on each side.
    pub fn grown(self, margin: f64) -> Bounds {
        let margin = vec2(margin, margin);
        Bounds { low: self.low - margin, high: self.high + margin }
    }

    /// Returns whether two rectangles have a common point.
    pub fn meets(&self, other: &Bounds) -> bool {
        self.low.x <= other.high.x
            && other.low.x <= self.high.x
            && self.low.y <= other.high.y
            && other.low.y <= self.high.y
    }

    /// Returns whether a point \[m\] lies inside or on the rim.
    pub fn contains(&self, p: Vec2) -> bool {
        self.low.x <= p.x && p.x <= self.high.x && self.low.y <= p.y && p.y <= self.high.y
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hold_their_points() {
        assert_eq!(Bounds::of([]), None);
        let bounds = Bounds::of([vec2(1.0, -2.0), vec2(-3.0, 5.0), vec2(0.0, 0.0)]).unwrap();
        assert_eq!(bounds, Bounds { low: vec2(-3.0, -2.0), high: vec2(1.0, 5.0) });
        assert_eq!(bounds.size(), vec2(4.0, 7.0));
        assert!(bounds.contains(vec2(1.0, 5.0)) && !bounds.contains(vec2(1.1, 5.0)));
        assert!(bounds.grown(0.2).contains(vec2(1.1, 5.0)));
        assert!(!bounds.contains(vec2(f64::NAN, 0.0)));
    }
}
