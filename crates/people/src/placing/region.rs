//! The region in which people may stand.

use crate::error::{NO_WALLS, PeopleError, Result, SMALL_AREA, require};
use crate::random::Random;
use lemons_core::message::message;
use lemons_core::plane::{
    Bounds, Ring, Vec2, nearest_on_segment, ray_crosses, segments_cross, sides_that_meet, vec2,
};
use lemons_core::trial::Geometry;

/// \[m\] Corners further from the origin are refused: up to there a millimetre is exact.
pub(crate) const FARTHEST: f64 = 1e6;
/// \[m²\] Smallest allowed area of a polygon or hole.
pub(super) const SMALLEST_AREA: f64 = 1e-6;
/// Largest number of corners of all rings together: all pairs of edges are compared.
pub(super) const MOST_CORNERS: usize = 10_000;

/// A part of the plane: all of it, or a simple polygon with holes. What walls leave of a polygon ([`Region::free_space`]) may
/// be several polygons, and may have walls in it.
#[derive(Debug, Clone)]
pub struct Region {
    /// The outer polygon, then its holes, then the next one; the inside is to their left. Empty for the open plane.
    rings: Vec<Ring>,
    /// The sides of the rings, then the walls.
    edges: Vec<Edge>,
    /// Number of edges of the rings.
    of_rings: usize,
    area: f64,
    slabs: Vec<Slab>,
}

/// An edge from a corner to the next.
#[derive(Debug, Clone, Copy)]
pub(super) struct Edge {
    pub start: Vec2,
    pub end: Vec2,
    /// A wall: the region is on both sides of it.
    pub is_wall: bool,
    /// One over the squared length.
    inverse_square: f64,
}

impl Edge {
    fn new(start: Vec2, end: Vec2, is_wall: bool) -> Edge {
        Edge { start, end, is_wall, inverse_square: 1.0 / (end - start).norm_squared() }
    }

    /// The point of the edge nearest to a point.
    #[inline]
    pub fn nearest(&self, point: Vec2) -> Vec2 {
        let along = self.end - self.start;
        let t = (point - self.start).dot(&along) * self.inverse_square;
        self.start + along * t.clamp(0.0, 1.0)
    }
}

/// A slab between two successive heights of corners. The width of the region is linear in it.
#[derive(Debug, Clone, Copy)]
struct Slab {
    low: f64,
    high: f64,
    width_low: f64,
    width_high: f64,
    /// \[m²\] Area of this slab and all slabs below.
    area_to_top: f64,
}

impl Region {
    /// Returns the open plane.
    pub fn plane() -> Region {
        Region::of_sides(Vec::new(), f64::INFINITY)
    }

    /// Returns the rectangle between two opposite corners \[m\].
    pub fn rectangle(low: Vec2, high: Vec2) -> Result<Region> {
        Region::polygon(&[low, vec2(high.x, low.y), high, vec2(low.x, high.y)], &[])
    }

    /// Returns the region inside a simple polygon \[m\] and outside each of the holes. Polygons may go round in either
    /// direction, and may repeat the first corner at the end.
    ///
    /// Edges may meet only at successive corners: holes touch neither the outer polygon nor each other.
    ///
    /// # Errors
    /// The polygons do not bound a region.
    pub fn polygon(outer: &[Vec2], holes: &[Vec<Vec2>]) -> Result<Region> {
        let mut named = vec![("the outer polygon".to_string(), outer)];
        named.extend(holes.iter().enumerate().map(|(k, hole)| (format!("hole {k}"), hole.as_slice())));
        Region::of_rings(&named)
    }

    /// Returns the region inside the closed walls of a Trial: the largest wall is the outer polygon, the others are
    /// holes. Walls that open at times bound nothing, but nobody stands across one.
    ///
    /// # Errors
    /// A wall is not closed, there are no walls, or they do not bound a region.
    pub fn from_walls(geometry: &Geometry) -> Result<Region> {
        let mut named = Vec::new();
        for wall in geometry.fixed_walls() {
            if let [first, .., last] = wall.corners[..]
                && first != last
            {
                let (first, last) = ((first.x, first.y), (last.x, last.y));
                return Err(PeopleError::OpenWall { id: wall.id.clone(), first, last });
            }
            named.push((format!("wall {}", wall.id), wall.corners.as_slice()));
        }
        require(!named.is_empty(), || message!(NO_WALLS))?;
        let area = |k: usize| Ring::through(named[k].1.to_vec()).map_or(0.0, |ring| ring.area());
        let largest = (0..named.len()).max_by(|&a, &b| area(a).total_cmp(&area(b)));
        named.swap(0, largest.unwrap_or(0));
        let mut region = Region::of_rings(&named)?;
        // Nobody stands across a door that is closed.
        let doors = geometry.walls.iter().filter(|wall| wall.open.is_some());
        let sides = doors.flat_map(|wall| wall.corners.windows(2));
        region.edges.extend(sides.map(|ends| Edge::new(ends[0], ends[1], true)));
        Ok(region)
    }

    fn of_rings(named: &[(String, &[Vec2])]) -> Result<Region> {
        let corners: usize = named.iter().map(|(_, ring)| ring.len()).sum();
        require(corners <= MOST_CORNERS, || {
            format!("{corners} corners; at most {MOST_CORNERS} are allowed")
        })?;
        let mut rings = Vec::new();
        for (name, corners) in named {
            rings.push(checked_ring(name, corners)?);
        }
        refuse_crossings(named, &rings)?;
        for (k, ring) in rings.iter().enumerate().skip(1) {
            let within = |other: &Ring| other.contains(ring.corners()[0]);
            let in_a_hole = rings.iter().enumerate().skip(1).any(|(j, other)| j != k && within(other));
            require(within(&rings[0]) && !in_a_hole, || {
                let ring = &named[k].0;
                format!("{ring} does not lie inside the outer polygon and outside the other holes")
            })?;
        }
        let area = rings[0].area() - rings[1..].iter().map(Ring::area).sum::<f64>();
        check_area("the polygon without its holes", area)?;
        let inside_to_the_left = |(k, ring): (usize, Ring)| {
            if (ring.signed_area() > 0.0) == (k == 0) { ring } else { ring.reversed() }
        };
        Ok(Region::of_sides(rings.into_iter().enumerate().map(inside_to_the_left).collect(), area))
    }

    /// Rings with the inside to their left, and its area \[m²\].
    fn of_sides(rings: Vec<Ring>, area: f64) -> Region {
        let sides = rings.iter().flat_map(Ring::sides);
        let edges: Vec<Edge> = sides.map(|(start, end)| Edge::new(start, end, false)).collect();
        let (of_rings, slabs) = (edges.len(), slabs(&edges));
        Region { rings, edges, of_rings, area, slabs }
    }

    /// Makes what walls left of a polygon: rings with the inside to their left, walls in it, and its area \[m²\].
    pub(super) fn left(rings: Vec<Ring>, walls: &[(Vec2, Vec2)], area: f64) -> Region {
        let mut left = Region::of_sides(rings, area);
        left.edges.extend(walls.iter().map(|(start, end)| Edge::new(*start, *end, true)));
        left
    }

    /// Returns the area \[m²\], infinite for the open plane.
    pub fn area(&self) -> f64 {
        self.area
    }

    /// Returns whether this is the open plane.
    pub fn is_plane(&self) -> bool {
        self.rings.is_empty()
    }

    /// Returns the outer polygon, then its holes, then the next polygon \[m\]; empty for the open plane.
    pub fn rings(&self) -> &[Ring] {
        &self.rings
    }

    /// Returns the lowest and the highest coordinates \[m\]; `None` for the open plane.
    pub fn bounds(&self) -> Option<Bounds> {
        Bounds::of(self.rings.iter().flat_map(|ring| ring.corners().iter().copied()))
    }

    /// Returns whether a point \[m\] lies inside. On the boundary the result may be either.
    pub fn contains(&self, point: Vec2) -> bool {
        let crossed = |e: &&Edge| ray_crosses(point, e.start, e.end);
        self.is_plane() || self.edges[..self.of_rings].iter().filter(crossed).count() % 2 == 1
    }

    /// Returns the distance \[m\] of a point inside from the boundary and from walls; negative outside, infinite in the
    /// open plane.
    pub fn depth(&self, point: Vec2) -> f64 {
        if self.is_plane() {
            return f64::INFINITY;
        }
        let square = self.edges.iter().map(|e| (point - e.nearest(point)).norm_squared());
        let distance = square.fold(f64::INFINITY, f64::min).sqrt();
        if self.contains(point) { distance } else { -distance }
    }

    pub(super) fn edges(&self) -> &[Edge] {
        &self.edges
    }

    /// Returns whether a wall in it is between two points.
    pub(super) fn parted(&self, a: Vec2, b: Vec2) -> bool {
        self.edges[self.of_rings..].iter().any(|wall| segments_cross(a, b, wall.start, wall.end))
    }

    /// The point at two fractions in \[0, 1) of the area: from the bottom up, then from left to right. It maps points
    /// evenly spread over the unit square to points evenly spread over the region.
    pub(super) fn point_at(&self, upwards: f64, across: f64) -> Vec2 {
        let wanted = upwards * self.area;
        let place = self.slabs.partition_point(|slab| slab.area_to_top < wanted).min(self.slabs.len() - 1);
        let slab = self.slabs[place];
        let below = if place == 0 { 0.0 } else { self.slabs[place - 1].area_to_top };
        let (height, w0, w1) = (slab.high - slab.low, slab.width_low, slab.width_high);
        // The width is w0 + (w1 − w0) t: solve the quadratic of the area in t without cancellation.
        let part = ((wanted - below) / height).max(0.0);
        let root = (w0 * w0 + 2.0 * (w1 - w0) * part).max(0.0).sqrt();
        let t = if w0 + root > 0.0 { (2.0 * part / (w0 + root)).clamp(0.0, 1.0) } else { 0.5 };
        // Avoid the exact heights of corners, where an edge may be missed.
        let y = slab.low + height * t.clamp(1e-9, 1.0 - 1e-9);
        let crossings = crossings(&self.edges[..self.of_rings], y);
        let width: f64 = crossings.chunks_exact(2).map(|c| c[1] - c[0]).sum();
        let mut left = across * width;
        for c in crossings.chunks_exact(2) {
            if left <= c[1] - c[0] {
                return vec2(c[0] + left, y);
            }
            left -= c[1] - c[0];
        }
        vec2(crossings.last().copied().unwrap_or(0.0), y)
    }

    /// A random point, evenly distributed.
    pub(super) fn random_point(&self, random: &mut Random) -> Vec2 {
        let (upwards, across) = (random.unit(), random.unit());
        self.point_at(upwards, across)
    }
}

/// The x at which the region's edges cross a height, ascending.
fn crossings(edges: &[Edge], y: f64) -> Vec<f64> {
    let mut found: Vec<f64> = edges
        .iter()
        .filter(|e| (e.start.y > y) != (e.end.y > y))
        .map(|e| e.start.x + (y - e.start.y) / (e.end.y - e.start.y) * (e.end.x - e.start.x))
        .collect();
    found.sort_by(f64::total_cmp);
    found
}

fn slabs(edges: &[Edge]) -> Vec<Slab> {
    let mut heights: Vec<f64> = edges.iter().map(|e| e.start.y).collect();
    heights.sort_by(f64::total_cmp);
    heights.dedup();
    let width = |y: f64| -> f64 { crossings(edges, y).chunks_exact(2).map(|c| c[1] - c[0]).sum() };
    let mut area_to_top = 0.0;
    let mut slabs = Vec::new();
    for pair in heights.windows(2) {
        let (low, high) = (pair[0], pair[1]);
        // The width is linear in the slab: two heights well inside give the widths at both ends.
        let (a, b) = (width(low + 0.25 * (high - low)), width(low + 0.75 * (high - low)));
        let (width_low, width_high) = ((1.5 * a - 0.5 * b).max(0.0), (1.5 * b - 0.5 * a).max(0.0));
        area_to_top += 0.5 * (width_low + width_high) * (high - low);
        slabs.push(Slab { low, high, width_low, width_high, area_to_top });
    }
    slabs
}

fn too_few(name: &str, corners: usize) -> PeopleError {
    PeopleError::new(format!("{name}: has {corners} different corners; at least 3 are needed"))
}

fn check_area(name: &str, area: f64) -> Result<()> {
    Ok(require(area >= SMALLEST_AREA, || message!(SMALL_AREA, name, area, least = SMALLEST_AREA))?)
}

fn checked_ring(name: &str, corners: &[Vec2]) -> Result<Ring> {
    for (corner, place) in corners.iter().enumerate() {
        let (x, y) = (place.x, place.y);
        // False for NaN, too.
        require(x.abs() <= FARTHEST && y.abs() <= FARTHEST, || {
            format!("{name}: corner {corner} at ({x:?}, {y:?}) m is not within {FARTHEST} m of the origin")
        })?;
    }
    let mut ring = corners.to_vec();
    ring.dedup();
    while ring.len() > 1 && ring.first() == ring.last() {
        ring.pop();
    }
    let few = too_few(name, ring.len());
    let ring = if ring.len() < 3 { None } else { Ring::through(ring) }.ok_or(few)?;
    check_area(name, ring.area())?;
    Ok(ring)
}

fn refuse_crossings(named: &[(String, &[Vec2])], rings: &[Ring]) -> Result<()> {
    let Some([first, second]) = sides_that_meet(rings) else { return Ok(()) };
    let name = |(ring, side): (usize, usize)| format!("edge {side} of {}", named[ring].0);
    let ends = |(ring, side): (usize, usize)| (rings[ring].closed()[side], rings[ring].closed()[side + 1]);
    let ((a, b), (c, d)) = (ends(first), ends(second));
    let [x, y] = nearest_on_segment(a, b, nearest_on_segment(c, d, (a + b) * 0.5)).into();
    let (first, second) = (name(first), name(second));
    Err(PeopleError::new(format!("{first} and {second} cross or touch near ({x}, {y}) m")))
}
