//! Soft shapes that press on each other and on the boundary: the energy that [`super::dense()`] minimizes.
//!
//! E = Σ ½ h² over all overlaps h: pairs of disks of different shapes, and disks and the boundary.

use super::neighbours::CellGrid;
use super::region::Edge;
use super::{Orientation, Region};
use crate::random::Random;
use crate::shape::Shape;
use lemons_core::plane::{Disk, Pose, Vec2, rotation, segments_cross, vec2};
use std::f64::consts::TAU;

/// \[m\] The list of near pairs is made again when something has moved by half of this. Results do not depend on it.
const SKIN: f64 = 0.08;

/// \[m\] Edges nearer than this to the origin of a body are listed. A disk of the body that has no edge within its
/// reach and the skin stays, until the next listing, on the same side of the boundary as the origin, even if it grows
/// by a tenth.
fn edges_within(reach: f64) -> f64 {
    2.2 * reach + 2.0 * SKIN
}

/// The boundary that contains the shapes.
#[derive(Debug, Clone, Copy)]
pub enum Boundary<'a> {
    /// The boundary of a region.
    Region(&'a Region),
    /// A circle about the origin \[m\].
    Circle(f64),
}

impl Boundary<'_> {
    /// The point at two fractions of the area. Evenly spread fractions give evenly spread points.
    pub fn point_at(&self, u: f64, v: f64) -> Vec2 {
        match self {
            Boundary::Region(region) => region.point_at(u, v),
            // From the centre outwards, and around.
            Boundary::Circle(radius) => rotation(TAU * v) * vec2(radius * u.sqrt(), 0.0),
        }
    }

    /// A random point, evenly distributed.
    pub fn random_point(&self, random: &mut Random) -> Vec2 {
        let (u, v) = (random.unit(), random.unit());
        self.point_at(u, v)
    }
}

/// Along x, along y, and the turn × the lever of the body: all three in metres.
pub type Coordinates = [f64; 3];

/// How much the shapes press on each other.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Pressure {
    /// \[m²\] The energy E.
    pub energy: f64,
    /// \[m\] largest overlap of the padded disks.
    pub overlap: f64,
}

/// A shape that moves.
#[derive(Debug, Clone, Copy)]
pub struct SoftBody {
    pub position: Vec2,
    /// \[rad\] Orientation of its frame.
    pub angle: f64,
    /// \[m\] Distance from its origin to its furthest point, at full size.
    pub reach: f64,
    /// \[m\] A turn by one radian counts as a displacement of this length.
    lever: f64,
    /// Index of its first disk.
    first: usize,
    last: usize,
}

impl SoftBody {
    pub fn pose(&self) -> Pose {
        Pose { position: self.position, orientation: super::wrapped(self.angle) }
    }
}

/// Shapes, the forces on them, and lists of near pairs.
#[derive(Debug, Clone)]
pub struct SoftDisks<'a> {
    pub boundary: Boundary<'a>,
    pub bodies: Vec<SoftBody>,
    /// True if the shapes may turn.
    turns: bool,
    /// Relative size of the shapes: 1 is full size.
    pub scale: f64,
    /// \[m\] Distance that shapes keep.
    pad: f64,
    /// Offsets and radii, at full size.
    disks: Vec<Disk>,
    /// Present offsets from the bodies, and radii.
    placed: Vec<Disk>,
    /// −∂E along the coordinates of each body.
    pub force: Vec<Coordinates>,
    pairs: Vec<(u32, u32)>,
    /// For each body near the boundary: its index, whether its origin is inside, the range of its edges in `edges`.
    near_edges: Vec<(u32, bool, std::ops::Range<usize>)>,
    edges: Vec<Edge>,
    /// Positions and scale when the near pairs were listed.
    listed: Vec<Vec2>,
    listed_scale: f64,
}

impl<'a> SoftDisks<'a> {
    /// Makes shapes at the origin. Each keeps a distance `pad` \[m\] from the others and from the boundary.
    pub fn new(
        shapes: &[Shape],
        boundary: Boundary<'a>,
        orientation: Orientation,
        pad: f64,
    ) -> SoftDisks<'a> {
        let mut bodies = Vec::with_capacity(shapes.len());
        let mut disks = Vec::new();
        for shape in shapes {
            let first = disks.len();
            disks.extend(&shape.disks);
            let square = shape.disks.iter().map(|d| d.centre.norm_squared() + 0.5 * d.radius * d.radius);
            let lever = (square.sum::<f64>() / shape.disks.len() as f64).sqrt();
            let (position, reach) = (Vec2::zeros(), super::reach(shape));
            bodies.push(SoftBody { position, angle: 0.0, reach, lever, first, last: disks.len() });
        }
        SoftDisks {
            boundary,
            turns: orientation.turns(),
            scale: 1.0,
            pad,
            placed: disks.clone(),
            disks,
            force: vec![[0.0; 3]; bodies.len()],
            pairs: Vec::new(),
            near_edges: Vec::new(),
            edges: Vec::new(),
            listed: Vec::new(),
            listed_scale: 0.0,
            bodies,
        }
    }

    /// Moves all positions towards the origin by a factor.
    pub fn draw_in(&mut self, factor: f64) {
        self.bodies.iter_mut().for_each(|b| b.position *= factor);
    }

    /// The disks of a body at an angle and a size, relative to its position.
    fn turned(&self, who: usize, angle: f64, scale: f64) -> impl Iterator<Item = Disk> {
        let (body, turn) = (&self.bodies[who], rotation(angle));
        self.disks[body.first..body.last]
            .iter()
            .map(move |disk| Disk { centre: turn * disk.centre * scale, radius: disk.radius * scale })
    }

    /// All disks at their present places and size.
    pub fn circles(&self) -> Vec<Disk> {
        let of = |who: usize| {
            let SoftBody { position, angle, .. } = self.bodies[who];
            self.turned(who, angle, self.scale)
                .map(move |disk| Disk { centre: position + disk.centre, ..disk })
        };
        (0..self.bodies.len()).flat_map(of).collect()
    }

    /// Returns whether a body, at full size, has disks on both sides of a wall.
    pub fn is_across(&self, who: usize, region: &Region) -> bool {
        let body = &self.bodies[who];
        let mut own = self.turned(who, body.angle, 1.0);
        own.any(|disk| region.parted(body.position, body.position + disk.centre))
    }

    /// Moves all bodies.
    pub fn shift(&mut self, way: impl Fn(usize) -> Coordinates) {
        for (k, body) in self.bodies.iter_mut().enumerate() {
            let [x, y, turn] = way(k);
            body.position += vec2(x, y);
            body.angle += turn / body.lever;
        }
    }

    /// Computes forces and energy of the present state.
    pub fn press(&mut self) -> Pressure {
        self.place_disks();
        if self.outdated() {
            self.list();
        }
        self.force.fill([0.0; 3]);
        let mut pressure = Pressure::default();
        self.press_pairs(&mut pressure);
        match self.boundary {
            Boundary::Region(_) => self.press_edges(&mut pressure),
            Boundary::Circle(radius) => self.press_circle(radius, &mut pressure),
        }
        pressure.energy *= 0.5;
        for (force, body) in self.force.iter_mut().zip(&self.bodies) {
            force[2] = if self.turns { force[2] / body.lever } else { 0.0 };
        }
        pressure
    }

    /// For each body its energy \[m²\], where both bodies get half of an overlap, and its largest overlap \[m\]
    /// (padded).
    pub fn loads(&mut self) -> Vec<(f64, f64)> {
        self.place_disks();
        self.list();
        let mut loads = vec![(0.0, 0.0f64); self.bodies.len()];
        let mut add = |k: usize, share: f64, overlap: f64| {
            if overlap > 0.0 {
                loads[k] = (loads[k].0 + share * overlap * overlap, loads[k].1.max(overlap));
            }
        };
        for &(a, b) in &self.pairs {
            let (a, b) = (a as usize, b as usize);
            let apart = self.bodies[b].position - self.bodies[a].position;
            for p in &self.placed[self.bodies[a].first..self.bodies[a].last] {
                for q in &self.placed[self.bodies[b].first..self.bodies[b].last] {
                    let overlap = p.radius + q.radius - (apart + q.centre - p.centre).norm();
                    add(a, 0.25, overlap);
                    add(b, 0.25, overlap);
                }
            }
        }
        for (k, body) in self.bodies.iter().enumerate() {
            for p in &self.placed[body.first..body.last] {
                add(k, 0.5, self.through(body.position + p.centre, p.radius));
            }
        }
        loads
    }

    /// \[m\] Distance by which a padded disk is too near to the boundary; not positive if it is not.
    fn through(&self, centre: Vec2, radius: f64) -> f64 {
        let radius = radius + 0.5 * self.pad;
        match self.boundary {
            Boundary::Region(region) => radius - region.depth(centre),
            Boundary::Circle(outer) => centre.norm() + radius - outer,
        }
    }

    /// \[m²\] Energy of a body at a pose, at most `bound`; `grid` contains the positions of the bodies.
    pub fn energy_at(&self, grid: &CellGrid, who: usize, position: Vec2, angle: f64, bound: f64) -> f64 {
        let mut energy = 0.0;
        let pad = 0.5 * self.pad;
        let own = self.turned(who, angle, self.scale);
        let own = own.map(|disk| Disk { centre: position + disk.centre, radius: disk.radius + pad });
        for disk in own {
            let overlap = self.through(disk.centre, disk.radius).max(0.0);
            energy += 0.5 * overlap * overlap;
            grid.for_each_near(disk.centre, |other| {
                let far = &self.bodies[other];
                let reach = disk.radius + far.reach * self.scale + pad;
                if other == who
                    || energy > bound
                    || (disk.centre - far.position).norm_squared() > reach * reach
                {
                    return;
                }
                for q in &self.placed[far.first..far.last] {
                    let overlap = disk.radius + q.radius - (far.position + q.centre - disk.centre).norm();
                    if overlap > 0.0 {
                        energy += 0.5 * overlap * overlap;
                    }
                }
            });
            if energy > bound {
                break;
            }
        }
        energy
    }

    /// Makes a grid of the bodies for [`SoftDisks::energy_at`].
    pub fn grid(&mut self) -> CellGrid {
        self.place_disks();
        let widest = self.bodies.iter().map(|b| b.reach).fold(0.0, f64::max);
        CellGrid::new(&self.positions(), 2.0 * widest * self.scale + self.pad)
    }

    pub fn positions(&self) -> Vec<Vec2> {
        self.bodies.iter().map(|b| b.position).collect()
    }

    fn place_disks(&mut self) {
        let pad = 0.5 * self.pad;
        for body in &self.bodies {
            let turn = rotation(body.angle);
            let own = body.first..body.last;
            for (placed, disk) in self.placed[own.clone()].iter_mut().zip(&self.disks[own]) {
                placed.centre = turn * disk.centre * self.scale;
                placed.radius = disk.radius * self.scale + pad;
            }
        }
    }

    fn outdated(&self) -> bool {
        let least = 0.25 * SKIN * SKIN;
        self.listed.len() != self.bodies.len()
            || self.listed_scale != self.scale
            || self.bodies.iter().zip(&self.listed).any(|(b, &at)| (b.position - at).norm_squared() >= least)
    }

    fn list(&mut self) {
        self.listed = self.positions();
        self.listed_scale = self.scale;
        let widest = self.bodies.iter().map(|b| b.reach).fold(0.0, f64::max);
        let grid = CellGrid::new(&self.listed, 2.0 * widest * self.scale + self.pad + SKIN);
        self.pairs.clear();
        for (a, body) in self.bodies.iter().enumerate() {
            grid.for_each_near(body.position, |b| {
                let reach = (body.reach + self.bodies[b].reach) * self.scale + self.pad + SKIN;
                if b > a && (body.position - self.bodies[b].position).norm_squared() < reach * reach {
                    self.pairs.push((a as u32, b as u32));
                }
            });
        }
        let Boundary::Region(region) = self.boundary else { return };
        self.near_edges.clear();
        self.edges.clear();
        for (k, body) in self.bodies.iter().enumerate() {
            let first = self.edges.len();
            let wide = edges_within(body.reach);
            let mut nearest = f64::INFINITY;
            for &edge in region.edges() {
                let square = (body.position - edge.nearest(body.position)).norm_squared();
                nearest = nearest.min(square);
                if square < wide * wide {
                    self.edges.push(edge);
                }
            }
            let touching = body.reach * self.scale + self.pad + SKIN;
            let inside = region.contains(body.position);
            if inside && nearest > touching * touching {
                self.edges.truncate(first);
                continue;
            }
            if !inside && self.edges[first..].iter().all(|edge| edge.is_wall) {
                // Far outside, the nearest edge pulls it in.
                let far = |e: &Edge| (body.position - e.nearest(body.position)).norm_squared();
                let own = region.edges().iter().copied().filter(|edge| !edge.is_wall);
                self.edges.extend(own.min_by(|a, b| far(a).total_cmp(&far(b))));
            }
            self.near_edges.push((k as u32, inside, first..self.edges.len()));
        }
    }

    fn press_pairs(&mut self, pressure: &mut Pressure) {
        for &(a, b) in &self.pairs {
            let (a, b) = (a as usize, b as usize);
            let (one, other) = (&self.bodies[a], &self.bodies[b]);
            let apart = other.position - one.position;
            let reach = (one.reach + other.reach) * self.scale + self.pad;
            if apart.norm_squared() >= reach * reach {
                continue;
            }
            let (mut push, mut torque_a, mut torque_b) = (Vec2::zeros(), 0.0, 0.0);
            let others = &self.placed[other.first..other.last];
            for p in &self.placed[one.first..one.last] {
                let from = apart - p.centre;
                for q in others {
                    let way = from + q.centre;
                    let (square, reach) = (way.norm_squared(), p.radius + q.radius);
                    if square >= reach * reach {
                        continue;
                    }
                    let distance = square.sqrt();
                    let overlap = reach - distance;
                    pressure.energy += overlap * overlap;
                    pressure.overlap = pressure.overlap.max(overlap);
                    // The centres coincide: any direction is as good.
                    let f = if distance > 1e-12 { way * (overlap / distance) } else { vec2(overlap, 0.0) };
                    push += f;
                    torque_a -= p.centre.perp(&f);
                    torque_b += q.centre.perp(&f);
                }
            }
            add(&mut self.force[a], -push, torque_a);
            add(&mut self.force[b], push, torque_b);
        }
    }

    fn press_edges(&mut self, pressure: &mut Pressure) {
        // The boundary's half of the distance.
        let pad = 0.5 * self.pad;
        for (k, origin_inside, own) in &self.near_edges {
            let body = &self.bodies[*k as usize];
            let edges = &self.edges[own.clone()];
            for disk in &self.placed[body.first..body.last] {
                let centre = body.position + disk.centre;
                let (inside, nearest) = side_of(edges, centre, body.reach + SKIN, *origin_inside);
                let radius = disk.radius + pad;
                let mut push = |way: Vec2, overlap: f64| {
                    pressure.energy += overlap * overlap;
                    pressure.overlap = pressure.overlap.max(overlap);
                    let distance = way.norm();
                    let f = if distance > 1e-12 { way * (overlap / distance) } else { Vec2::zeros() };
                    add(&mut self.force[*k as usize], f, disk.centre.perp(&f));
                };
                if !inside {
                    let way = nearest - centre;
                    push(way, radius + way.norm());
                    continue;
                }
                for edge in edges {
                    let way = centre - edge.nearest(centre);
                    // A wall with space behind it: the disk goes back to where its body is.
                    if edge.is_wall && segments_cross(body.position, centre, edge.start, edge.end) {
                        push(-way, radius + way.norm());
                    } else if way.norm_squared() < radius * radius {
                        push(way, radius - way.norm());
                    }
                }
            }
        }
    }

    fn press_circle(&mut self, radius: f64, pressure: &mut Pressure) {
        // The boundary's half of the distance.
        let radius = radius - 0.5 * self.pad;
        for (body, force) in self.bodies.iter().zip(&mut self.force) {
            let inner = radius - body.reach * self.scale - self.pad;
            if inner > 0.0 && body.position.norm_squared() < inner * inner {
                continue;
            }
            for disk in &self.placed[body.first..body.last] {
                let centre = body.position + disk.centre;
                let distance = centre.norm();
                let overlap = distance + disk.radius - radius;
                if overlap > 0.0 && distance > 1e-12 {
                    pressure.energy += overlap * overlap;
                    pressure.overlap = pressure.overlap.max(overlap);
                    let f = centre * (-overlap / distance);
                    add(force, f, disk.centre.perp(&f));
                }
            }
        }
    }
}

#[inline]
fn add(force: &mut Coordinates, push: Vec2, torque: f64) {
    force[0] += push.x;
    force[1] += push.y;
    force[2] += torque;
}

/// Returns whether a point is inside, and the nearest point of the boundary. A region lies to the left of its edges. If
/// no edge is within `within`, the point is on the same side as the origin of its body.
fn side_of(edges: &[Edge], point: Vec2, within: f64, origin_inside: bool) -> (bool, Vec2) {
    let mut nearest = (f64::INFINITY, point);
    let mut left_of = 0.0;
    for edge in edges.iter().filter(|edge| !edge.is_wall) {
        let at = edge.nearest(point);
        let square = (point - at).norm_squared();
        let along = edge.end - edge.start;
        let left = along.perp(&(point - edge.start)) / along.norm();
        if square < nearest.0 * (1.0 - 1e-12) {
            nearest = (square, at);
            left_of = left;
        } else if square <= nearest.0 * (1.0 + 1e-12) && left.abs() > left_of.abs() {
            // The nearest point is a corner: use the edge that faces the point more directly.
            left_of = left;
        }
    }
    let inside = if nearest.0 >= within * within { origin_inside } else { left_of >= 0.0 };
    (inside, nearest.1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    /// Forces are −∂E: by central differences, in a polygon with a hole, and in a circle; some stand outside.
    #[test]
    fn forces_are_the_gradient() {
        let corner = |x: f64, y: f64| vec2(x, y);
        let outer =
            [corner(-1.0, -1.0), corner(1.2, -1.0), corner(1.0, 0.9), corner(0.1, 0.3), corner(-1.1, 1.0)];
        let hole = vec![corner(-0.2, -0.4), corner(0.2, -0.5), corner(0.1, -0.1)];
        let region = Region::polygon(&outer, &[hole]).unwrap();
        let mut random = Random::new(3);
        for boundary in [Boundary::Region(&region), Boundary::Circle(1.0)] {
            let disk =
                |random: &mut Random| Disk { radius: 0.1 + 0.1 * random.unit(), centre: random.vector(0.2) };
            let shapes: Vec<Shape> =
                (0..12).map(|_| Shape { disks: (0..3).map(|_| disk(&mut random)).collect() }).collect();
            let mut disks = SoftDisks::new(&shapes, boundary, Orientation::Free, 1e-3);
            disks.scale = 0.9;
            for body in &mut disks.bodies {
                (body.position, body.angle) = (random.vector(1.1), random.within(3.0));
            }
            assert!(disks.press().energy > 0.01);
            let force = disks.force.clone();
            for (k, force) in force.iter().enumerate() {
                for c in 0..3 {
                    let mut at = |way: f64| {
                        let mut step = [0.0; 3];
                        step[c] = way;
                        disks.shift(|j| if j == k { step } else { [0.0; 3] });
                        let energy = disks.press().energy;
                        disks.shift(|j| if j == k { step.map(|s| -s) } else { [0.0; 3] });
                        energy
                    };
                    let slope = (at(1e-6) - at(-1e-6)) / 2e-6;
                    assert!((force[c] + slope).abs() < 1e-5, "body {k}, {c}: {} {}", force[c], -slope);
                }
            }
            let sum: f64 = disks.loads().iter().map(|l| l.0).sum();
            assert!(sum > 0.01);
        }
    }

    /// The energy that a pose would cost is what it costs.
    #[test]
    fn energy_at_a_pose() {
        let region = Region::rectangle(vec2(0.0, 0.0), vec2(1.0, 1.0)).unwrap();
        let shape = Shape {
            disks: vec![
                Disk { radius: 0.2, centre: vec2(0.0, 0.1) },
                Disk { radius: 0.1, centre: vec2(0.0, -0.2) },
            ],
        };
        let shapes = vec![shape; 3];
        let mut disks = SoftDisks::new(&shapes, Boundary::Region(&region), Orientation::Free, 1e-3);
        let places = [(0.5, 0.5), (0.6, 0.7), (0.08, 0.4)];
        for (body, (x, y)) in disks.bodies.iter_mut().zip(places) {
            (body.position, body.angle) = (vec2(x, y), x);
        }
        let before = disks.press().energy;
        let grid = disks.grid();
        let (at, angle) = (vec2(0.3, 0.6), 1.0);
        let change = disks.energy_at(&grid, 1, at, angle, f64::INFINITY)
            - disks.energy_at(&grid, 1, disks.bodies[1].position, disks.bodies[1].angle, f64::INFINITY);
        (disks.bodies[1].position, disks.bodies[1].angle) = (at, angle);
        let after = disks.press().energy;
        assert!((after - before - change).abs() < 1e-15 && change.abs() > 1e-4, "{before} {after} {change}");
        let shared: f64 = disks.loads().iter().map(|l| l.0).sum();
        assert!((shared - after).abs() < 1e-15, "{shared} {after}");
    }
}
