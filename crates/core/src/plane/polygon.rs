//! Polygons with holes, also as well-known text (OGC Simple Features).

use crate::plane::{Ring, Vec2};
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
