//! Soft shapes that press on each other and on the boundary: the energy that [`super::dense()`] minimizes.
//!
//! E = Σ ½ h² over all overlaps h: pairs of disks of different shapes, and disks and the boundary.

use super::neighbours::CellGrid;
use super::region::Edge;
use super::{Orientation, Region};
use crate::shape::Shape;
use lemons_core::plane::{Bounds, Disk, Pose, Rotation, Vec2, segments_cross, vec2};

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
pub struct Body {
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

impl Body {
    pub fn pose(&self) -> Pose {
        Pose { position: self.position, orientation: super::wrapped(self.angle) }
    }
}

/// The side of the boundary on which a point lies.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Side {
    Inside,
    Outside,
}

/// Shapes, the forces on them, and lists of near pairs.
#[derive(Debug, Clone)]
pub struct Pile<'a> {
    pub boundary: Boundary<'a>,
    pub bodies: Vec<Body>,
    /// Whether the shapes may turn.
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
    /// For each body near the boundary: its index, the side of its origin, the range of its edges in `edges`.
    near_edges: Vec<(u32, Side, std::ops::Range<usize>)>,
    edges: Vec<Edge>,
    edge_grid: EdgeGrid,
    /// Positions and scale when the near pairs were listed.
    listed: Vec<Vec2>,
    listed_scale: f64,
}

impl<'a> Pile<'a> {
    /// Makes shapes at the origin. Each keeps a distance `pad` \[m\] from the others and from the boundary.
    pub fn new(shapes: &[Shape], boundary: Boundary<'a>, orientation: Orientation, pad: f64) -> Pile<'a> {
        let mut bodies = Vec::with_capacity(shapes.len());
        let mut disks = Vec::new();
        for shape in shapes {
            let first = disks.len();
            disks.extend(&shape.disks);
            let square = shape.disks.iter().map(|d| d.centre.norm_squared() + 0.5 * d.radius * d.radius);
            let lever = (square.sum::<f64>() / shape.disks.len() as f64).sqrt();
            let (position, reach) = (Vec2::ZERO, super::reach(shape));
            bodies.push(Body { position, angle: 0.0, reach, lever, first, last: disks.len() });
        }
        let widest = bodies.iter().map(|b| b.reach).fold(0.0, f64::max);
        let edge_grid = match boundary {
            Boundary::Region(region) => EdgeGrid::new(region, edges_within(widest)),
            Boundary::Circle(_) => EdgeGrid::default(),
        };
        Pile {
            boundary,
            turns: !matches!(orientation, Orientation::Fixed(_)),
            scale: 1.0,
            pad,
            placed: disks.clone(),
            disks,
            force: vec![[0.0; 3]; bodies.len()],
            pairs: Vec::new(),
            near_edges: Vec::new(),
            edges: Vec::new(),
            edge_grid,
            listed: Vec::new(),
            listed_scale: 0.0,
            bodies,
        }
    }

    /// Moves all positions towards the origin by a factor.
    pub fn draw_in(&mut self, factor: f64) {
        self.bodies.iter_mut().for_each(|b| b.position = b.position * factor);
    }

    /// All disks at their present places and size.
    pub fn circles(&self) -> Vec<Disk> {
        let mut circles = Vec::with_capacity(self.disks.len());
        for body in &self.bodies {
            let turn = Rotation::by(body.angle);
            circles.extend(self.disks[body.first..body.last].iter().map(|d| Disk {
                centre: body.position + d.centre.rotated(turn) * self.scale,
                radius: d.radius * self.scale,
            }));
        }
        circles
    }

    /// Whether a body, at full size, has disks on both sides of a wall.
    pub fn is_across(&self, who: usize, region: &Region) -> bool {
        let body = &self.bodies[who];
        let turn = Rotation::by(body.angle);
        let own = self.disks[body.first..body.last].iter();
        own.map(|disk| body.position + disk.centre.rotated(turn))
            .any(|disk| region.parted(body.position, disk))
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
        for &(a, b) in &self.pairs {
            let (a, b) = (a as usize, b as usize);
            let apart = self.bodies[b].position - self.bodies[a].position;
            for p in &self.placed[self.bodies[a].first..self.bodies[a].last] {
                for q in &self.placed[self.bodies[b].first..self.bodies[b].last] {
                    let overlap = p.radius + q.radius - (apart + q.centre - p.centre).norm();
                    if overlap > 0.0 {
                        for k in [a, b] {
                            loads[k] = (loads[k].0 + 0.25 * overlap * overlap, loads[k].1.max(overlap));
                        }
                    }
                }
            }
        }
        for (k, body) in self.bodies.iter().enumerate() {
            for p in &self.placed[body.first..body.last] {
                let overlap = self.through(body.position + p.centre, p.radius);
                if overlap > 0.0 {
                    loads[k] = (loads[k].0 + 0.5 * overlap * overlap, loads[k].1.max(overlap));
                }
            }
        }
        loads
    }

    /// \[m\] Distance by which a padded disk is too near to the boundary; not positive if it is not.
    fn through(&self, centre: Vec2, radius: f64) -> f64 {
        let radius = radius + 0.5 * self.pad;
        match self.boundary {
            Boundary::Region(region) => match self.edge_grid.near(centre) {
                ([], true) => 0.0,
                _ => radius - region.depth(centre),
            },
            Boundary::Circle(outer) => centre.norm() + radius - outer,
        }
    }

    /// \[m²\] Energy of a body at a pose, at most `bound`; `grid` contains the positions of the bodies.
    pub fn energy_at(&self, grid: &CellGrid, who: usize, position: Vec2, angle: f64, bound: f64) -> f64 {
        let (body, turn) = (&self.bodies[who], Rotation::by(angle));
        let mut energy = 0.0;
        let pad = 0.5 * self.pad;
        let own = self.disks[body.first..body.last].iter().map(|d| Disk {
            centre: position + d.centre.rotated(turn) * self.scale,
            radius: d.radius * self.scale + pad,
        });
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

    /// Makes a grid of the bodies for [`Pile::energy_at`].
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
            let turn = Rotation::by(body.angle);
            let own = body.first..body.last;
            for (placed, disk) in self.placed[own.clone()].iter_mut().zip(&self.disks[own]) {
                placed.centre = disk.centre.rotated(turn) * self.scale;
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
            let (near, inside) = self.edge_grid.near(body.position);
            if near.is_empty() && inside {
                continue;
            }
            let first = self.edges.len();
            let wide = edges_within(body.reach);
            let mut nearest = f64::INFINITY;
            for &edge in near {
                let edge = region.edges()[edge as usize];
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
            let side = if inside { Side::Inside } else { Side::Outside };
            self.near_edges.push((k as u32, side, first..self.edges.len()));
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
            let (mut push, mut torque_a, mut torque_b) = (Vec2::ZERO, 0.0, 0.0);
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
                    torque_a -= p.centre.cross(f);
                    torque_b += q.centre.cross(f);
                }
            }
            add(&mut self.force[a], -push, torque_a);
            add(&mut self.force[b], push, torque_b);
        }
    }

    fn press_edges(&mut self, pressure: &mut Pressure) {
        // The boundary's half of the distance.
        let pad = 0.5 * self.pad;
        for (k, side, own) in &self.near_edges {
            let body = &self.bodies[*k as usize];
            let edges = &self.edges[own.clone()];
            for disk in &self.placed[body.first..body.last] {
                let centre = body.position + disk.centre;
                let (side, nearest) = side_of(edges, centre, body.reach + SKIN, *side);
                let radius = disk.radius + pad;
                let mut push = |way: Vec2, overlap: f64| {
                    pressure.energy += overlap * overlap;
                    pressure.overlap = pressure.overlap.max(overlap);
                    let distance = way.norm();
                    let f = if distance > 1e-12 { way * (overlap / distance) } else { Vec2::ZERO };
                    add(&mut self.force[*k as usize], f, disk.centre.cross(f));
                };
                if side == Side::Outside {
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
                    add(force, f, disk.centre.cross(f));
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

/// The side of the boundary on which a point lies, and the nearest point of the boundary. A region lies to the left of
/// its edges. If no edge is within `within`, the point is on the same side as the origin of its body.
fn side_of(edges: &[Edge], point: Vec2, within: f64, origin: Side) -> (Side, Vec2) {
    let mut nearest = (f64::INFINITY, point);
    let mut left_of = 0.0;
    for edge in edges.iter().filter(|edge| !edge.is_wall) {
        let at = edge.nearest(point);
        let square = (point - at).norm_squared();
        let along = edge.end - edge.start;
        let left = along.cross(point - edge.start) / along.norm();
        if square < nearest.0 * (1.0 - 1e-12) {
            nearest = (square, at);
            left_of = left;
        } else if square <= nearest.0 * (1.0 + 1e-12) && left.abs() > left_of.abs() {
            // The nearest point is a corner: use the edge that faces the point more directly.
            left_of = left;
        }
    }
    let side = if nearest.0 >= within * within {
        origin
    } else if left_of >= 0.0 {
        Side::Inside
    } else {
        Side::Outside
    };
    (side, nearest.1)
}

/// Square cells with the edges near each of them.
#[derive(Debug, Clone, Default)]
struct EdgeGrid {
    low: Vec2,
    cell: f64,
    columns: usize,
    rows: usize,
    starts: Vec<u32>,
    edges: Vec<u32>,
    /// Whether the middle of a cell is inside. A cell without edges is completely inside or outside.
    inside: Vec<bool>,
}

/// Largest number of cells of an [`EdgeGrid`].
const MOST_CELLS: f64 = 65536.0;

impl EdgeGrid {
    /// Makes a grid in which each point of a cell finds all edges within a distance \[m\].
    fn new(region: &Region, distance: f64) -> EdgeGrid {
        let Some(Bounds { low, high }) = region.bounds() else { return EdgeGrid::default() };
        let (width, height) = (high.x - low.x, high.y - low.y);
        let cell =
            (0.5 * distance).max((width * height / MOST_CELLS).sqrt()).max(width.max(height) / MOST_CELLS);
        let (columns, rows) = ((width / cell) as usize + 1, (height / cell) as usize + 1);
        let mut grid = EdgeGrid { low, cell, columns, rows, ..EdgeGrid::default() };
        // Half the diagonal, rounded up.
        let wide = distance + 0.7072 * cell;
        let mut found = vec![Vec::new(); columns * rows];
        for (k, edge) in region.edges().iter().enumerate() {
            let lowest = vec2(edge.start.x.min(edge.end.x) - wide, edge.start.y.min(edge.end.y) - wide);
            let highest = vec2(edge.start.x.max(edge.end.x) + wide, edge.start.y.max(edge.end.y) + wide);
            let ((left, bottom), (right, top)) = (grid.place(lowest), grid.place(highest));
            for row in bottom..=top {
                for column in left..=right {
                    let middle = grid.middle(column, row);
                    if (middle - edge.nearest(middle)).norm_squared() <= wide * wide {
                        found[row * columns + column].push(k as u32);
                    }
                }
            }
        }
        grid.starts.push(0);
        for (k, edges) in found.iter().enumerate() {
            grid.edges.extend(edges);
            grid.starts.push(grid.edges.len() as u32);
            // This is used for cells without edges only.
            grid.inside.push(edges.is_empty() && region.contains(grid.middle(k % columns, k / columns)));
        }
        grid
    }

    fn place(&self, point: Vec2) -> (usize, usize) {
        let place = (point - self.low) * (1.0 / self.cell);
        ((place.x as usize).min(self.columns - 1), (place.y as usize).min(self.rows - 1))
    }

    fn middle(&self, column: usize, row: usize) -> Vec2 {
        self.low + vec2(column as f64 + 0.5, row as f64 + 0.5) * self.cell
    }

    /// Returns all edges within the distance of a point, perhaps with others; and, if there are none, whether the point
    /// is inside.
    fn near(&self, point: Vec2) -> (&[u32], bool) {
        if self.rows == 0 {
            return (&[], true);
        }
        let (column, row) = self.place(point);
        let home = row * self.columns + column;
        // A point beyond the grid is outside; the cell at the rim says nothing about it.
        let beyond = |low: f64, at: f64, cells: usize| at < low || at > low + cells as f64 * self.cell;
        let out = beyond(self.low.x, point.x, self.columns) || beyond(self.low.y, point.y, self.rows);
        let edges = &self.edges[self.starts[home] as usize..self.starts[home + 1] as usize];
        (edges, self.inside[home] && !out)
    }
}

#[cfg(test)]
mod tests {
    use super::super::random::Random;
    use super::*;

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
            let mut pile = Pile::new(&shapes, boundary, Orientation::Free, 1e-3);
            pile.scale = 0.9;
            for body in &mut pile.bodies {
                (body.position, body.angle) = (random.vector(1.1), random.within(3.0));
            }
            assert!(pile.press().energy > 0.01);
            let force = pile.force.clone();
            for (k, force) in force.iter().enumerate() {
                for c in 0..3 {
                    let mut at = |way: f64| {
                        let mut step = [0.0; 3];
                        step[c] = way;
                        pile.shift(|j| if j == k { step } else { [0.0; 3] });
                        let energy = pile.press().energy;
                        pile.shift(|j| if j == k { step.map(|s| -s) } else { [0.0; 3] });
                        energy
                    };
                    let slope = (at(1e-6) - at(-1e-6)) / 2e-6;
                    assert!((force[c] + slope).abs() < 1e-5, "body {k}, {c}: {} {}", force[c], -slope);
                }
            }
            let sum: f64 = pile.loads().iter().map(|l| l.0).sum();
            assert!(sum > 0.01);
        }
    }

    /// What a pose would cost is what it costs.
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
        let mut pile = Pile::new(&shapes, Boundary::Region(&region), Orientation::Free, 1e-3);
        let places = [(0.5, 0.5), (0.6, 0.7), (0.08, 0.4)];
        for (body, (x, y)) in pile.bodies.iter_mut().zip(places) {
            (body.position, body.angle) = (vec2(x, y), x);
        }
        let before = pile.press().energy;
        let grid = pile.grid();
        let (at, angle) = (vec2(0.3, 0.6), 1.0);
        let change = pile.energy_at(&grid, 1, at, angle, f64::INFINITY)
            - pile.energy_at(&grid, 1, pile.bodies[1].position, pile.bodies[1].angle, f64::INFINITY);
        (pile.bodies[1].position, pile.bodies[1].angle) = (at, angle);
        let after = pile.press().energy;
        assert!((after - before - change).abs() < 1e-15 && change.abs() > 1e-4, "{before} {after} {change}");
        let shared: f64 = pile.loads().iter().map(|l| l.0).sum();
        assert!((shared - after).abs() < 1e-15, "{shared} {after}");
    }
}
