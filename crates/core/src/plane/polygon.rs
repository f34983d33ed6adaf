//! Polygons with holes, also as well-known text (OGC Simple Features).

use crate::plane::{Ring, Shape, Vec2, shapes_from_wkt};
use std::fmt::Write;

/// A ring and the holes in it.
#[derive(Debug, Clone, PartialEq)]
pub struct Polygon {
    /// The outer ring.
    pub outer: Ring,
    /// Parts that do not belong to it.
    pub holes: Vec<Ring>,
}

impl Polygon {
    /// Returns the outer ring, then the holes.
    pub fn rings(&self) -> impl Iterator<Item = &Ring> {
        std::iter::once(&self.outer).chain(&self.holes)
    }

    /// Returns the area without holes \[m²\], which do not overlap.
    pub fn area(&self) -> f64 {
        self.outer.area() - self.holes.iter().map(Ring::area).sum::<f64>()
    }

    /// Returns whether a point \[m\] lies in it. On a rim the result may be either.
    pub fn contains(&self, p: Vec2) -> bool {
        self.outer.contains(p) && !self.holes.iter().any(|hole| hole.contains(p))
    }

    /// Reads `POLYGON ((x y, …), (hole), …)`.
    ///
    /// # Errors
    /// The text is not a POLYGON, a ring is not closed, or a coordinate is not a finite number. The error is a sentence.
    pub fn from_wkt(wkt: &str) -> Result<Polygon, String> {
        match <[Shape; 1]>::try_from(shapes_from_wkt(wkt)?) {
            Ok([Shape::Polygon(polygon)]) => Ok(polygon),
            _ => Err("is not a POLYGON in well-known text, such as POLYGON ((0 0, 4 0, 4 3, 0 0))".into()),
        }
    }

    /// Returns `POLYGON ((x y, …), (hole), …)`. Numbers have no exponents and are read back exactly.
    pub fn to_wkt(&self) -> String {
        let mut text = String::from("POLYGON (");
        for (k, ring) in self.rings().enumerate() {
            text += if k > 0 { ", (" } else { "(" };
            for (k, corner) in ring.closed().iter().enumerate() {
                let comma = if k > 0 { ", " } else { "" };
                let _ = write!(text, "{comma}{} {}", corner.x, corner.y);
            }
            text.push(')');
        }
        text + ")"
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reads_back() {
        let text = "POLYGON ((0 0, 4 0, 4.1 3, 0 0), (1 0.1, 2 0.1, 2 0.2, 1 0.1))";
        let polygon = Polygon::from_wkt(text).unwrap();
        assert_eq!((polygon.holes.len(), polygon.outer.corners().len()), (1, 3));
        assert_eq!(polygon.to_wkt(), text);
        let whole = Polygon::from_wkt(" polygon((0 0,4 0,4.1 3,0 0))\n").unwrap();
        assert_eq!(whole, Polygon { holes: Vec::new(), ..polygon });
    }

    #[test]
    fn what_is_no_polygon_is_refused_with_its_reason() {
        for (text, expected) in [
            ("", "is not a POLYGON"),
            ("POLYGON", "must be followed by a parenthesis, at the end of the text"),
            ("POLYGON ()", "no ring"),
            ("POLYGON EMPTY", "is not a POLYGON"),
            ("POINT (0 0)", "is not a POLYGON"),
            ("POLYGON ((0 0, 4 0, 4 3))", "is not closed"),
            ("POLYGON ((0 0, 4 0, 4 inf, 0 0))", "\"4 inf\" is not a corner"),
            ("POLYGON ((0 0, 2 0, 2 3, 0 0) (2 2, 3 2, 2 3, 2 2))", "separated by commas"),
            ("POLYGON ((0 0, é", "\"é\" is not a corner"),
        ] {
            let said = Polygon::from_wkt(text).unwrap_err();
            assert!(said.contains(expected), "{text}: {said}");
        }
    }
}
