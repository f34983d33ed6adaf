//! Ways around walls: how far it is to a target from everywhere, on a grid.
//!
//! The distance T solves the eikonal equation |∇T| = 1/f with T = 0 on the target, by fast marching (Sethian, PNAS 93
//! (1996) 1591). Everybody walks down T: the cost of a step does not depend on the number of people. The factor f is 1
//! in the open and falls towards walls, so that ways keep some distance from them where there is room. Walls are pieces
//! without thickness: two nodes of the grid are neighbours if no wall lies between them.
//!
//! Only sums, products and roots are used, so the result is the same bits on every machine.

use crate::error::PlanError;
use lemons_core::plane::{
    Bounds, InPlane, Motion, Pose, Ring, Vec2, nearest_on_segment, segments_touch, vec2,
};
use lemons_core::trial::LinkPassage;
use std::cmp::Reverse;
use std::collections::{BinaryHeap, HashMap};

/// \[m\] Distance of two nodes.
const STEP: f64 = 0.1;
/// \[m\] Coarser grids would not find doors.
const COARSEST: f64 = 0.25;
/// Most nodes of a grid.
const MOST_NODES: f64 = 4e6;
/// Most nodes of all fields together: 0.3 GB.
const MOST_VALUES: usize = 40_000_000;
/// \[m\] Nearer than this to a wall, a metre counts as more.
const CLEARANCE: f64 = 0.35;
/// \[m\] No centre of mass is nearer to a wall. So gaps of twice as much are closed.
const NEAREST: f64 = 0.1;
/// Greatest price of a metre: right beside a wall.
const DEAREST: f64 = 4.0;
/// \[m\] Free space around everything.
const MARGIN: f64 = 1.0;
/// \[m\] Walls further away than this do not make a way narrow.
const WIDE: f64 = 3.0;
/// Sine of the smallest angle between the way and the direction to a wall beside it: about 49°.
const BESIDE: f64 = 0.75;
/// Steps from a line, or the side of an area, within which the way leads straight to it.
pub(crate) const LAST: f64 = 1.5;
/// Parts of a step by which the grid is shifted: nodes do not lie on walls with round coordinates.
const SHIFT: Vec2 = vec2(0.382, 0.417);

/// Bits of [`Grid::links`].
const LEFT: u8 = 1;
const RIGHT: u8 = 2;
const BELOW: u8 = 4;
const ABOVE: u8 = 8;
const FACES: u8 = 16;

/// Grid of places where people can walk: nodes, and which of them are neighbours.
#[derive(Debug, Clone)]
pub struct Grid {
    origin: Vec2,
    step: f64,
    columns: usize,
    rows: usize,
    /// Of each node, as bits: to which of the next nodes no wall is between, and whether faces are beside it.
    links: Vec<u8>,
    /// Price of each node: how many metres a metre counts; infinite where nobody can be.
    price: Vec<f64>,
    faces: Vec<[Vec2; 2]>,
    /// Of nodes to which people are carried over a link: the nodes from where.
    carried: HashMap<usize, Vec<usize>>,
    /// Faces in or near the square to the upper right of a node.
    beside: HashMap<usize, Vec<u32>>,
}

/// Distances \[m\] from all nodes of a grid.
pub type Field = Vec<f64>;

/// Doors on the ways down a field.
#[derive(Debug, Clone)]
pub struct Gates {
    /// Of each node, the first one; [`NO_GATE`] if there is none.
    first: Vec<u32>,
    /// Of each door: how far \[m\] it is from there, and the next one.
    all: Vec<(f64, u32)>,
}

const NO_GATE: u32 = u32::MAX;

/// \[m\] Who arrives so near to a door is at it: rounding.
const AT_DOOR: f64 = 1e-6;
/// \[m\] What is so near to a wall lies on it: ends of slanted lines, and of walls, are written in whole centimetres.
const ON_WALL: f64 = 0.015;

/// Doors of straight pieces.
#[derive(Debug, Clone, Default)]
pub struct Doors {
    all: Vec<Vec<[Vec2; 2]>>,
    /// Pieces in or near the square to the upper right of a node.
    beside: HashMap<usize, Vec<[Vec2; 2]>>,
}

impl Doors {
    /// Returns whether one of them lies between two places, open or not.
    pub fn are_between(&self, from: Vec2, to: Vec2) -> bool {
        self.all.iter().flatten().any(|[a, b]| segments_touch(from, to, *a, *b))
    }
}

impl Grid {
    /// Makes a grid that contains these places and walls, given as polylines.
    ///
    /// # Errors
    /// They take too large an area.
    pub fn new(walls: &[Vec<Vec2>], places: impl Iterator<Item = Vec2>) -> Result<Grid, PlanError> {
        let faces: Vec<[Vec2; 2]> =
            walls.iter().flat_map(|wall| wall.windows(2).map(|ends| [ends[0], ends[1]])).collect();
        let all = Bounds::of(faces.iter().flatten().copied().chain(places));
        let all = all.unwrap_or(Bounds { low: Vec2::zeros(), high: Vec2::zeros() }).grown(MARGIN);
        let size = all.size();
        let step = STEP.max((size.x * size.y / MOST_NODES).sqrt());
        // Also if a number is not finite.
        if !(step <= COARSEST && size.x.max(size.y) / step < MOST_NODES) {
            return Err(PlanError::of_area(size));
        }
        let [columns, rows] = [size.x, size.y].map(|length| (length / step) as usize + 2);
        let nodes = columns * rows;
        let origin = all.low - vec2(SHIFT.x * step, SHIFT.y * step);
        let mut grid = Grid {
            origin,
            step,
            columns,
            rows,
            links: vec![LEFT | RIGHT | BELOW | ABOVE; nodes],
            price: vec![f64::INFINITY; nodes],
            faces,
            carried: HashMap::new(),
            beside: HashMap::new(),
        };
        for row in 0..rows {
            grid.links[row * columns] &= !LEFT;
            grid.links[row * columns + columns - 1] &= !RIGHT;
        }
        for column in 0..columns {
            grid.links[column] &= !BELOW;
            grid.links[nodes - columns + column] &= !ABOVE;
        }
        for k in 0..grid.faces.len() {
            grid.put_face(k);
        }
        // Until here the distance to the nearest wall.
        for price in &mut grid.price {
            let near = (*price / CLEARANCE).min(1.0);
            let dear = 1.0 + (DEAREST - 1.0) * (1.0 - near) * (1.0 - near);
            *price = if *price < NEAREST { f64::INFINITY } else { dear };
        }
        Ok(grid)
    }

    /// Joins the nodes in the strips behind lines to those where people are carried from there.
    pub fn with_passages(mut self, passages: impl Iterator<Item = LinkPassage>) -> Grid {
        for passage in passages {
            let strip = Bounds::of(passage.strip()).expect("four points");
            for node in self.nodes_in(strip) {
                let at = self.place(node);
                let there = passage.carried(Motion { pose: Pose::new(at.x, at.y, 0.0), ..Motion::default() });
                let (column, row) = self.square(there.pose.position + vec2(0.5, 0.5) * self.step);
                let inside =
                    (0.0..self.columns as f64).contains(&column) && (0.0..self.rows as f64).contains(&row);
                if passage.is_beyond(at) && self.price[node].is_finite() && inside {
                    let to = row as usize * self.columns + column as usize;
                    self.carried.entry(to).or_default().push(node);
                }
            }
        }
        self
    }

    /// Checks that so many fields can be kept in memory.
    ///
    /// # Errors
    /// They are too many for the area.
    pub fn check_fields(&self, fields: usize) -> Result<(), PlanError> {
        if fields * self.price.len() <= MOST_VALUES {
            return Ok(());
        }
        Err(PlanError::of_area(vec2(self.columns as f64, self.rows as f64) * self.step))
    }

    /// Parts what the face lies between.
    fn put_face(&mut self, k: usize) {
        let [from, to] = self.faces[k];
        let around = Bounds::of([from, to]).expect("two points").grown(CLEARANCE + self.step);
        for node in self.nodes_in(around) {
            let at = self.place(node);
            let away = (nearest_on_segment(from, to, at) - at).norm();
            self.price[node] = self.price[node].min(away);
            let (next, up) = (at + vec2(self.step, 0.0), at + vec2(0.0, self.step));
            for (there, other, bits) in
                [(next, node + 1, [RIGHT, LEFT]), (up, node + self.columns, [ABOVE, BELOW])]
            {
                if self.links[node] & bits[0] != 0 && segments_touch(at, there, from, to) {
                    self.links[node] &= !bits[0];
                    self.links[other] &= !bits[1];
                }
            }
            if self.is_beside(node, [from, to]) {
                self.beside.entry(node).or_default().push(k as u32);
                self.links[node] |= FACES;
            }
        }
    }

    /// Returns whether a piece is in or near the square to the upper right of a node.
    fn is_beside(&self, node: usize, [from, to]: [Vec2; 2]) -> bool {
        let middle = self.place(node) + vec2(0.5 * self.step, 0.5 * self.step);
        (nearest_on_segment(from, to, middle) - middle).norm() < 0.75 * self.step
    }

    /// Finds where these doors are on the grid.
    pub fn doors(&self, all: Vec<Vec<[Vec2; 2]>>) -> Doors {
        let mut beside: HashMap<usize, Vec<[Vec2; 2]>> = HashMap::new();
        for &piece in all.iter().flatten() {
            let around = Bounds::of(piece).expect("two points").grown(self.step);
            for node in self.nodes_in(around).filter(|node| self.is_beside(*node, piece)) {
                beside.entry(node).or_default().push(piece);
            }
        }
        Doors { all, beside }
    }

    /// \[m\] Returns the distance of two nodes.
    pub fn step(&self) -> f64 {
        self.step
    }

    fn place(&self, node: usize) -> Vec2 {
        let (row, column) = (node / self.columns, node % self.columns);
        self.origin + vec2(column as f64 * self.step, row as f64 * self.step)
    }

    /// Column and row of the square that contains a place, which may be outside.
    fn square(&self, at: Vec2) -> (f64, f64) {
        let share = (at - self.origin) * (1.0 / self.step);
        (libm::floor(share.x), libm::floor(share.y))
    }

    fn nodes_in(&self, bounds: Bounds) -> impl Iterator<Item = usize> + use<> {
        let columns = self.columns;
        let range = |low: f64, high: f64, count: usize| {
            let end = (high.max(-1.0) as usize + 1).min(count - 1);
            (low.max(0.0) as usize).min(count - 1)..=end
        };
        let (low, high) = (self.square(bounds.low), self.square(bounds.high));
        let across = range(low.0, high.0, self.columns);
        range(low.1, high.1, self.rows)
            .flat_map(move |row| across.clone().map(move |column| row * columns + column))
    }

    /// Returns whether no wall lies between two places that are near each other, and none at the second one.
    pub fn sees(&self, from: Vec2, to: Vec2) -> bool {
        let between = Bounds::of([from, to]).expect("two points").grown(self.step);
        let mut near = self.nodes_in(between).filter_map(|node| self.beside.get(&node)).flatten();
        !near.any(|&face| {
            let [a, b] = self.faces[face as usize];
            segments_touch(from, to, a, b) || (nearest_on_segment(a, b, to) - to).norm() < ON_WALL
        })
    }

    /// Returns whether somebody can be at some lines, or in some areas.
    pub fn begins(&self, lines: &[[Vec2; 2]], areas: &[Ring]) -> bool {
        !self.first(lines, areas).is_empty()
    }

    /// Computes how far it is to the nearest of some lines, and of the areas that rings enclose.
    pub fn field(&self, lines: &[[Vec2; 2]], areas: &[Ring]) -> Field {
        let mut field = vec![f64::INFINITY; self.price.len()];
        let mut front = BinaryHeap::new();
        for (node, distance) in self.first(lines, areas) {
            if distance < field[node] {
                field[node] = distance;
                front.push(Reverse((distance.to_bits(), node)));
            }
        }
        self.march(&mut field, front);
        field
    }

    /// Nodes at lines and in areas, with their distances.
    fn first(&self, lines: &[[Vec2; 2]], areas: &[Ring]) -> Vec<(usize, f64)> {
        let mut first = Vec::new();
        let mut begin = |node: usize, distance: f64| {
            if self.price[node].is_finite() {
                first.push((node, distance));
            }
        };
        let sides = areas.iter().flat_map(|ring| ring.sides().map(|(a, b)| [a, b]));
        for [from, to] in lines.iter().copied().chain(sides) {
            let around = Bounds::of([from, to]).expect("two points").grown(LAST * self.step);
            for node in self.nodes_in(around) {
                let at = self.place(node);
                let nearest = nearest_on_segment(from, to, at);
                let distance = (nearest - at).norm();
                if distance < LAST * self.step && self.sees(at, nearest) {
                    begin(node, distance);
                }
            }
        }
        for ring in areas {
            for node in self.nodes_in(ring.bounds()).filter(|node| ring.contains(self.place(*node))) {
                begin(node, 0.0);
            }
        }
        first
    }

    /// Fast marching. Distances are not negative, so they have the order of their bits.
    fn march(&self, field: &mut [f64], mut front: BinaryHeap<Reverse<(u64, usize)>>) {
        let mut done = vec![false; field.len()];
        while let Some(Reverse((_, node))) = front.pop() {
            if std::mem::replace(&mut done[node], true) {
                continue;
            }
            for &from in self.carried.get(&node).into_iter().flatten() {
                // Rounded to nodes, it is never nearer than where people are carried.
                let distance = field[node] + self.step;
                if !done[from] && distance < field[from] {
                    field[from] = distance;
                    front.push(Reverse((distance.to_bits(), from)));
                }
            }
            for next in self.neighbours(node).into_iter().flatten() {
                if done[next] {
                    continue;
                }
                let distance = self.arrival(field, &done, next);
                // Infinite where nobody can be.
                if distance < field[next] {
                    field[next] = distance;
                    front.push(Reverse((distance.to_bits(), next)));
                }
            }
        }
    }

    /// Returns the nodes to the left, right, below and above, where no wall is between.
    fn neighbours(&self, node: usize) -> [Option<usize>; 4] {
        let (links, columns) = (self.links[node], self.columns);
        let next = |bit, other| if links & bit != 0 { Some(other) } else { None };
        [
            next(LEFT, node.wrapping_sub(1)),
            next(RIGHT, node + 1),
            next(BELOW, node.wrapping_sub(columns)),
            next(ABOVE, node + columns),
        ]
    }

    /// Returns the distance of a node by those of its neighbours that are known.
    fn arrival(&self, field: &[f64], done: &[bool], node: usize) -> f64 {
        let known = |next: Option<usize>| match next {
            Some(next) if done[next] => field[next],
            _ => f64::INFINITY,
        };
        let [left, right, below, above] = self.neighbours(node).map(known);
        let (a, b) = (left.min(right), below.min(above));
        let way = self.step * self.price[node];
        if (a - b).abs() < way {
            0.5 * (a + b + (2.0 * way * way - (a - b) * (a - b)).sqrt())
        } else {
            a.min(b) + way
        }
    }

    /// Returns how far it is from a place \[m\]: the mean of the nodes around it that are on the same side of all walls.
    /// Beside walls, metres count more. Infinite where no way leads from, and outside of the grid.
    pub fn distance(&self, field: &[f64], at: Vec2) -> f64 {
        mean_of(field, self.around(at))
    }

    /// Returns how far it is from a place, as [`Grid::distance`], and the direction in which the distance falls fastest, as a
    /// unit vector; `None` where no way leads from, and outside of the grid.
    pub fn way(&self, field: &[f64], at: Vec2) -> (f64, Option<Vec2>) {
        let around = self.around(at);
        let downs = around.iter().filter_map(|&(node, share)| Some(self.down(field, node)? * share));
        (mean_of(field, around), downs.fold(Vec2::zeros(), |sum, down| sum + down).unit(1e-9))
    }

    /// Computes the free width \[m\] of the narrowest place on the way down a field, from all nodes: there the nearest wall on
    /// the left and the nearest one on the right are together least far away. Infinite where walls are more than 3 m away.
    pub fn widths(&self, field: &[f64]) -> Field {
        let downs: Vec<Option<Vec2>> = (0..field.len()).map(|node| self.down(field, node)).collect();
        let mut sides = vec![[f64::INFINITY; 2]; field.len()];
        for &[from, to] in &self.faces {
            for node in self.nodes_in(Bounds::of([from, to]).expect("two points").grown(WIDE)) {
                let Some(down) = downs[node] else { continue };
                let way = nearest_on_segment(from, to, self.place(node)) - self.place(node);
                let (far, across) = (way.norm(), down.perp(&way));
                // A wall ahead or behind is not beside the way.
                if far <= WIDE && across.abs() >= BESIDE * far {
                    let side = &mut sides[node][usize::from(across > 0.0)];
                    *side = side.min(far);
                }
            }
        }
        let mut widths = vec![f64::INFINITY; field.len()];
        for node in from_near(field) {
            let rest = self.next(field, node).map_or(f64::INFINITY, |next| widths[next]);
            widths[node] = rest.min(sides[node][0] + sides[node][1]);
        }
        widths
    }

    /// Returns the neighbour to which the distance falls most.
    fn next(&self, field: &[f64], node: usize) -> Option<usize> {
        let lower = self.neighbours(node).into_iter().flatten().filter(|next| field[*next] < field[node]);
        lower.min_by(|a, b| field[*a].total_cmp(&field[*b]))
    }

    /// Finds which of some doors the ways down a field lead through. `end` gives where the way from a place ends: the nearest
    /// point of what the field leads to.
    pub fn gates(&self, field: &[f64], doors: &Doors, end: impl Fn(Vec2) -> Vec2) -> Gates {
        // Nodes are on either side of a target, or on it: the last step is no way between two of them.
        let last = |node: usize, a: Vec2, b: Vec2| {
            let (at, end) = (self.place(node), end(self.place(node)));
            segments_touch(at, end, a, b) || (nearest_on_segment(a, b, end) - end).norm() < AT_DOOR
        };
        let mut crossed: HashMap<usize, u32> = HashMap::new();
        for (k, door) in doors.all.iter().enumerate() {
            for &[a, b] in door {
                let around = Bounds::of([a, b]).expect("two points").grown(LAST * self.step);
                for node in self.nodes_in(around) {
                    let touches = |next| segments_touch(self.place(node), self.place(next), a, b);
                    if self.next(field, node).map_or_else(|| last(node, a, b), touches) {
                        crossed.entry(node).or_insert(k as u32);
                    }
                }
            }
        }
        let mut gates =
            Gates { first: vec![NO_GATE; field.len()], all: vec![(f64::INFINITY, NO_GATE); doors.all.len()] };
        for node in from_near(field) {
            let rest = self.next(field, node).map_or(NO_GATE, |next| gates.first[next]);
            gates.first[node] = crossed.get(&node).copied().unwrap_or(rest);
            if let Some(gate) =
                gates.all.get_mut(gates.first[node] as usize).filter(|gate| gate.0 > field[node])
            {
                *gate = (field[node], rest);
            }
        }
        gates
    }

    /// Returns the doors on the way from a place, in its order, with how far \[m\] it is from each. Nodes behind one of the
    /// `doors` do not count.
    pub fn gates_from<'a>(
        &self,
        gates: &'a Gates,
        doors: &Doors,
        at: Vec2,
    ) -> impl Iterator<Item = (usize, f64)> + use<'a> {
        let around = self.around(at);
        let beside = doors.beside.get(&around[0].0).map_or(&[][..], |beside| &beside[..]);
        let parted = |node: usize| beside.iter().any(|&[a, b]| segments_touch(at, self.place(node), a, b));
        let near = around.into_iter().filter(|&(node, share)| share > 0.0 && !parted(node));
        let nearest = near.max_by(|a, b| a.1.total_cmp(&b.1));
        let first = nearest.map_or(NO_GATE, |(node, _)| gates.first[node]);
        let known = |gate: u32| gates.all.get(gate as usize).map(|&(far, next)| (gate as usize, far, next));
        let ways = std::iter::successors(known(first), move |&(.., next)| known(next));
        ways.take(gates.all.len()).map(|(gate, far, _)| (gate, far))
    }

    /// \[m\] Returns the width of the way from the node that is nearest to a place; `None` where no wall makes it narrow.
    pub fn width(&self, widths: &[f64], at: Vec2) -> Option<f64> {
        let (column, row) = self.square(at + vec2(0.5 * self.step, 0.5 * self.step));
        let inside = (0.0..self.columns as f64).contains(&column) && (0.0..self.rows as f64).contains(&row);
        let node = if inside { row as usize * self.columns + column as usize } else { usize::MAX };
        widths.get(node).copied().filter(|width| width.is_finite())
    }

    /// Returns the nodes around a place with their bilinear shares; zero for those on another side of a wall, and outside.
    fn around(&self, at: Vec2) -> [(usize, f64); 4] {
        let (column, row) = self.square(at);
        let inside =
            column >= 0.0 && row >= 0.0 && column + 1.0 < self.columns as f64 && row + 1.0 < self.rows as f64;
        if !inside {
            return [(0, 0.0); 4];
        }
        let first = row as usize * self.columns + column as usize;
        let share = (at - self.origin) * (1.0 / self.step) - vec2(column, row);
        let corners = [
            (first, 1.0 - share.x, 1.0 - share.y),
            (first + 1, share.x, 1.0 - share.y),
            (first + self.columns, 1.0 - share.x, share.y),
            (first + self.columns + 1, share.x, share.y),
        ];
        // Also a node in whose very place somebody stands counts a little.
        let mut around = corners.map(|(node, x, y)| (node, x * y + 1e-6));
        if self.links[first] & FACES != 0 {
            let faces = || self.beside[&first].iter().map(|&face| self.faces[face as usize]);
            for (node, share) in &mut around {
                if faces().any(|[a, b]| segments_touch(at, self.place(*node), a, b)) {
                    *share = 0.0;
                }
            }
        }
        around
    }

    /// Returns the direction down the distance at a node: against the gradient by the lower neighbours.
    fn down(&self, field: &[f64], node: usize) -> Option<Vec2> {
        let here = field[node];
        if !here.is_finite() {
            return None;
        }
        let [left, right, below, above] =
            self.neighbours(node).map(|next| next.map_or(f64::INFINITY, |next| field[next]));
        let fall = |low: f64, high: f64| {
            let (back, on) = ((here - low).max(0.0), (here - high).max(0.0));
            if back > on { -back } else { on }
        };
        vec2(fall(left, right), fall(below, above)).unit(0.0)
    }
}

/// Returns the nodes from which a way leads, those with the shortest first.
fn from_near(field: &[f64]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..field.len()).filter(|node| field[*node].is_finite()).collect();
    order.sort_by(|a, b| field[*a].total_cmp(&field[*b]));
    order
}

/// Returns the mean of a field over nodes with shares; infinite if none of them is reached.
fn mean_of(field: &[f64], around: [(usize, f64); 4]) -> f64 {
    let known = around.into_iter().filter(|&(node, share)| share > 0.0 && field[node].is_finite());
    let (sum, shares) =
        known.fold((0.0, 0.0), |(sum, shares), (node, share)| (sum + share * field[node], shares + share));
    if shares > 0.0 { sum / shares } else { f64::INFINITY }
}

#[cfg(test)]
mod tests;
