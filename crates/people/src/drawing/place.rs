//! Places of a drawing: exits, distributions, way-points.

use lemons_core::plane::{Bounds, Ring, Vec2, vec2};

/// A place with a name.
#[derive(Debug, Clone, PartialEq)]
pub struct NamedPlace {
    /// No two of a kind have the same.
    pub name: String,
    /// \[m\] One is a point, two are a line, more are an area.
    pub corners: Vec<Vec2>,
}

impl NamedPlace {
    /// Returns its middle \[m\], and how far its sides are from there; none of a point. Where the middle of an area lies
    /// outside, or close to a side, it is another place inside.
    pub fn middle(&self) -> (Vec2, Option<f64>) {
        let bounds = Bounds::of(self.corners.iter().copied()).unwrap_or(Bounds::UNIT);
        let middle = (bounds.low + bounds.high) * 0.5;
        let ring = Ring::through(self.corners.clone()).filter(|_| self.corners.len() > 2);
        let Some(ring) = ring else { return (middle, None) };
        let distance = |at: Vec2| if ring.contains(at) { ring.nearest(at).distance } else { 0.0 };
        let best = |a: (Vec2, f64), b: (Vec2, f64)| if b.1 > a.1 { b } else { a };
        let inner = inner_places(&ring).map(|at| (at, distance(at))).fold((middle, 0.0), best);
        let own = (middle, distance(middle));
        let (middle, distance) = if own.1 > 0.2 * inner.1 { own } else { inner };
        (middle, (distance > 0.0).then_some(distance))
    }
}

/// Returns places inside a ring: of lines through it in both directions, the middle of the longest part inside.
fn inner_places(ring: &Ring) -> impl Iterator<Item = Vec2> {
    const LINES: u32 = 32;
    let Bounds { low, high } = ring.bounds();
    let parts = (0..LINES).map(|k| (f64::from(k) + 0.5) / f64::from(LINES));
    let lines = parts.flat_map(|part| [(part, false), (part, true)]);
    lines.filter_map(move |(part, upright)| {
        // Along the line, and across it.
        let split = |p: Vec2| if upright { (p.y, p.x) } else { (p.x, p.y) };
        let (from, to) = (split(low).1, split(high).1);
        let level = from + (to - from) * part;
        let crossing = |(a, b): (Vec2, Vec2)| {
            let ((a, from), (b, to)) = (split(a), split(b));
            ((from > level) != (to > level)).then(|| a + (b - a) * ((level - from) / (to - from)))
        };
        let mut places: Vec<f64> = ring.sides().filter_map(crossing).collect();
        places.sort_by(f64::total_cmp);
        let inside = places.chunks_exact(2).map(|ends| (ends[0], ends[1]));
        let (a, b) = inside.max_by(|a, b| (a.1 - a.0).total_cmp(&(b.1 - b.0)))?;
        let along = 0.5 * (a + b);
        Some(if upright { vec2(level, along) } else { vec2(along, level) })
    })
}
