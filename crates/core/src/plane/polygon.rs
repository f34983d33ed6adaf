//! Polygons with holes, also as well-known text (OGC Simple Features).

use crate::plane::{Ring, Vec2, vec2};
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

    /// Returns whether a point \[m\] lies in it. On a rim the result may be either.
    pub fn contains(&self, p: Vec2) -> bool {
        self.outer.contains(p) && !self.holes.iter().any(|hole| hole.contains(p))
    }

    /// Reads `POLYGON ((x y, …), (hole), …)`.
    ///
    /// # Errors
    /// The text is not a POLYGON, a ring is not closed, or a coordinate is not a finite number. The error is a sentence.
    pub fn from_wkt(wkt: &str) -> Result<Polygon, String> {
        let mut rings = rings_from_wkt(wkt)?.into_iter();
        let outer = rings.next().ok_or("POLYGON has no rings")?;
        Ok(Polygon { outer, holes: rings.collect() })
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

fn rings_from_wkt(wkt: &str) -> Result<Vec<Ring>, String> {
    let text = wkt.trim().trim_start_matches('\u{feff}');
    let keyword = text.get(..7).filter(|word| word.eq_ignore_ascii_case("POLYGON"));
    let inside = keyword.and_then(|_| text[7..].trim().strip_prefix('(')?.strip_suffix(')'));
    let inside =
        inside.ok_or("is not a POLYGON in well-known text, such as POLYGON ((0 0, 4 0, 4 3, 0 0))")?;
    let mut rings = Vec::new();
    for (k, part) in inside.trim().split_inclusive(')').enumerate() {
        let part = if k == 0 { Some(part) } else { part.trim_start().strip_prefix(',') };
        let part = part.ok_or("rings of a POLYGON must be separated by commas")?.trim();
        let ring = part.strip_prefix('(').and_then(|ring| ring.strip_suffix(')'));
        let ring = ring.ok_or("each ring of a POLYGON must be in parentheses")?;
        let corners: Vec<Vec2> = ring.split(',').map(corner).collect::<Result<_, _>>()?;
        let last = *corners.last().ok_or("a ring has no corners")?;
        if corners.len() < 4 || corners[0] != last {
            return Err(format!(
                "the ring that ends at {} {} is not closed: its first corner must be repeated at its end",
                last.x, last.y
            ));
        }
        rings.extend(Ring::through(corners));
    }
    Ok(rings)
}

fn corner(text: &str) -> Result<Vec2, String> {
    let numbers: Option<Vec<f64>> =
        text.split_whitespace().map(|word| word.parse().ok().filter(|x: &f64| x.is_finite())).collect();
    match numbers.as_deref() {
        Some([x, y]) => Ok(vec2(*x, *y)),
        _ => Err(format!("{:?} is not a corner; write two numbers, x and y in m", text.trim())),
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
            ("POLYGON", "is not a POLYGON"),
            ("POLYGON ()", "no ring"),
            ("POLYGON EMPTY", "is not a POLYGON"),
            ("POINT (0 0)", "is not a POLYGON"),
            ("POLYGON ((0 0, 4 0, 4 3))", "is not closed"),
            ("POLYGON ((0 0, 4 0, 4 inf, 0 0))", "\"4 inf\" is not a corner"),
            ("POLYGON ((0 0, 2 0, 2 3, 0 0) (2 2, 3 2, 2 3, 2 2))", "separated by commas"),
            ("POLYGON ((0 0, é", "is not a POLYGON"),
        ] {
            let said = Polygon::from_wkt(text).unwrap_err();
            assert!(said.contains(expected), "{text}: {said}");
        }
    }
}
