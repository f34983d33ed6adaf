//! Maps of people per area, as filled contours.

use crate::body::{TENTH_OF_MM, near};
use crate::frame::Frame;
use crate::style::Scale;
use crate::text::{escaped, pair, text_of};
use contour::ContourBuilder;
use lemons_core::plane::{Bounds, Vec2, vec2};
use lemons_core::trial::Wall;
use std::collections::BTreeMap;

/// \[m\] Default standard deviation of the kernel: slightly more than half a shoulder breadth.
pub const DENSITY_KERNEL: f64 = 0.3;
/// Cells per standard deviation of the kernel, along both axes; finer where walls cut it.
const CELLS_PER_KERNEL: f64 = 4.0;
const CELLS_AT_WALLS: f64 = 8.0;
/// Largest number of cells of a map; a larger map has larger cells.
const MOST_CELLS: f64 = 100_000.0;
/// Largest number of cells beyond each side of the map. Only a view much smaller than the kernel would need more.
const MOST_BEYOND: i64 = 400;
/// Cut-off of the kernel, in standard deviations: 2 · 10⁻⁹ of a person is lost.
const REACH: f64 = 6.0;

/// Number of shades of a density map.
const SHADES: usize = 24;

/// People per m² on a grid, averaged over the added frames.
///
/// Each person is a Gaussian with integral 1. A cell contains its mean, so that the sum over a sufficiently large grid,
/// times the area of a cell, is the number of people. Walls stop the kernel: a cell gets its share only if the straight
/// line from the person to its centre crosses no wall. Walls that open and close do not count. The rest of the
/// Gaussian is then scaled so that its integral is 1 again.
#[derive(Debug, Clone, PartialEq)]
pub struct DensityMap {
    view: Bounds,
    kernel: f64,
    columns: usize,
    rows: usize,
    frames: usize,
    /// Row by row from the lowest, summed over the frames.
    sum: Vec<f64>,
    /// \[m\] Sides of walls.
    walls: Vec<[Vec2; 2]>,
}

impl DensityMap {
    /// Makes an empty map of a part of the plane. `kernel` \[m\] is the standard deviation of the Gaussian; if it is
    /// not positive and finite, [`DENSITY_KERNEL`] is used.
    pub fn new(view: Bounds, kernel: f64, walls: &[Wall]) -> DensityMap {
        let fixed = walls.iter().filter(|wall| wall.open.is_none());
        let sides = fixed.flat_map(|wall| wall.corners.windows(2).map(|side| [side[0], side[1]]));
        let walls: Vec<[Vec2; 2]> = sides.filter(|[a, b]| near(*a) && near(*b) && a != b).collect();
        let kernel = if kernel.is_finite() && kernel > 0.0 { kernel } else { DENSITY_KERNEL };
        let view = if near(view.low) && near(view.high) { view } else { Bounds::UNIT };
        let size = vec2((view.high.x - view.low.x).max(1e-3), (view.high.y - view.low.y).max(1e-3));
        let view = Bounds { low: view.low, high: view.low + size };
        let finest = kernel / if walls.is_empty() { CELLS_PER_KERNEL } else { CELLS_AT_WALLS };
        let cells = |cell: f64| ((size.x / cell).ceil().max(1.0), (size.y / cell).ceil().max(1.0));
        let mut cell = finest;
        while cells(cell).0 * cells(cell).1 > MOST_CELLS {
            cell *= 1.5;
        }
        let (columns, rows) = (cells(cell).0 as usize, cells(cell).1 as usize);
        let sum = vec![0.0; columns * rows];
        DensityMap { view, kernel, columns, rows, frames: 0, sum, walls }
    }

    /// Adds a frame: the positions of all people \[m\] at one time. Positions that are not finite are ignored.
    pub fn add(&mut self, positions: impl IntoIterator<Item = Vec2>) {
        self.frames += 1;
        for p in positions.into_iter().filter(|p| near(*p)) {
            self.add_one(p);
        }
    }

    /// Adds the frames of another map of the same part of the plane.
    pub fn join(&mut self, other: &DensityMap) {
        self.frames += other.frames;
        self.sum.iter_mut().zip(&other.sum).for_each(|(sum, more)| *sum += more);
    }

    fn add_one(&mut self, p: Vec2) {
        let (cell, from) = (self.cell(), p - self.view.low);
        let place = |p: Vec2| in_cells(self.view.low, cell, p);
        let reach = vec2(REACH * self.kernel, REACH * self.kernel);
        let around = Bounds { low: p - reach, high: p + reach };
        let near_by = |side: &&[Vec2; 2]| Bounds::of(**side).is_some_and(|side| side.meets(&around));
        let walls: Vec<[Vec2; 2]> = self.walls.iter().filter(near_by).map(|side| side.map(place)).collect();
        // Cells beyond the map matter only if the rest of a person must be scaled.
        let all = if walls.is_empty() { 0 } else { MOST_BEYOND };
        let (first_column, along_x) = self.shares(from.x, cell.x, self.columns, all);
        let (first_row, along_y) = self.shares(from.y, cell.y, self.rows, all);
        let mut parts: Vec<f64> = along_y.iter().flat_map(|y| along_x.iter().map(move |x| y * x)).collect();
        let count = along_x.len();
        if !walls.is_empty() {
            let whole: f64 = parts.iter().sum();
            for (row, cells) in (first_row..).zip(parts.chunks_mut(count.max(1))) {
                for (low, high) in walls.iter().filter_map(|side| shadow(place(p), *side, row as f64)) {
                    // The cells whose centres lie in between.
                    let column = |x: f64| (x - first_column as f64).clamp(0.0, count as f64) as usize;
                    let (from, to) = (column(low.ceil()), column(high.floor() + 1.0));
                    cells[from.min(to)..to].fill(0.0);
                }
            }
            let left: f64 = parts.iter().sum();
            // If a person sees no centre of a cell, nothing is left to scale.
            let enlarged = if left > 0.0 { whole / left } else { 0.0 };
            parts.iter_mut().for_each(|part| *part *= enlarged);
        }
        for (row, cells) in (first_row..).zip(parts.chunks(count.max(1))) {
            for (column, part) in (first_column..).zip(cells) {
                if (0..self.rows as i64).contains(&row) && (0..self.columns as i64).contains(&column) {
                    self.sum[row as usize * self.columns + column as usize] += part;
                }
            }
        }
    }

    /// The first cell that a Gaussian at `x` reaches, and its mean over this cell and the next ones \[1/m\]; within the
    /// cells of the map and `more` cells on each side.
    fn shares(&self, x: f64, cell: f64, cells: usize, more: i64) -> (i64, Vec<f64>) {
        let (low, high) = (-more, cells as i64 + more);
        let first = (((x - REACH * self.kernel) / cell).floor() as i64).clamp(low, high);
        let last = (((x + REACH * self.kernel) / cell).ceil() as i64).clamp(first, high);
        let below =
            |k: i64| 0.5 * libm::erf((k as f64 * cell - x) / (self.kernel * std::f64::consts::SQRT_2));
        (first, (first..last).map(|k| (below(k + 1) - below(k)) / cell).collect())
    }

    /// Returns a description of the kernel in words.
    pub fn described(&self) -> String {
        let walls = if self.walls.is_empty() { "" } else { ", not through walls" };
        let frames = if self.frames == 1 {
            "one frame".to_owned()
        } else {
            format!("the mean of {} frames", self.frames)
        };
        format!(
            "each person is spread as a Gaussian with a standard deviation of {} m{walls}; {frames}",
            self.kernel
        )
    }

    /// Returns the part of the plane \[m\] that the cells cover.
    pub fn view(&self) -> Bounds {
        self.view
    }

    /// Returns the number of cells along x and along y.
    pub fn cells(&self) -> (usize, usize) {
        (self.columns, self.rows)
    }

    /// Returns the size of a cell \[m\].
    pub fn cell(&self) -> Vec2 {
        let size = self.view.high - self.view.low;
        vec2(size.x / self.columns as f64, size.y / self.rows as f64)
    }

    /// Returns the mean density of each cell \[1/m²\], row by row from the lowest; 0 before the first frame.
    pub fn values(&self) -> Vec<f64> {
        let frames = self.frames.max(1) as f64;
        self.sum.iter().map(|sum| sum / frames).collect()
    }
}

/// The x range of the line at height `y` that a wall side hides from a person at `p`. A person exactly on the line of a
/// wall is not hidden by it.
fn shadow(p: Vec2, [a, b]: [Vec2; 2], y: f64) -> Option<(f64, f64)> {
    let (a, b) = (a - p, b - p);
    let turn = a.perp(&b);
    if turn == 0.0 {
        return None;
    }
    // Left of p→a, right of p→b, and beyond a→b: three half planes.
    let (a, b) = if turn > 0.0 { (a, b) } else { (b, a) };
    let side = b - a;
    let (mut low, mut high) = (f64::NEG_INFINITY, f64::INFINITY);
    for (along, from) in [(a, Vec2::zeros()), (-b, Vec2::zeros()), (-side, a)] {
        // For along × (x − from.x, y − from.y) ≥ 0: slope · x ≤ limit.
        let (slope, limit) = (along.y, along.x * (y - p.y - from.y) + along.y * from.x);
        if slope > 0.0 {
            high = high.min(limit / slope);
        } else if slope < 0.0 {
            low = low.max(limit / slope);
        } else if limit < 0.0 {
            return None;
        }
    }
    (low <= high).then_some((low + p.x, high + p.x))
}

/// Draws the areas above each level, from the lowest level to the highest.
pub(crate) fn density(out: &mut String, map: &DensityMap, frame: &Frame, scale: &Scale) {
    let (view, cell) = (map.view, map.cell());
    let shade = |k: usize| (k as f64 + 0.5) / SHADES as f64;
    let between = |part: f64| scale.low * (1.0 - part) + scale.high * part;
    let [x, y, w, h] = [view.low.x, view.low.y, view.high.x - view.low.x, view.high.y - view.low.y]
        .map(|v| text_of(v, TENTH_OF_MM));
    *out += &format!("<desc>{}</desc>\n", escaped(&map.described()));
    *out += "<g class=\"density\" stroke=\"none\">\n";
    *out += &format!(
        "<rect x=\"{x}\" y=\"{y}\" width=\"{w}\" height=\"{h}\" fill=\"{}\"/>\n",
        scale.of(between(shade(0)))
    );
    let levels: Vec<f64> = (1..SHADES).map(|k| between(k as f64 / SHADES as f64)).collect();
    let builder = ContourBuilder::new(map.columns, map.rows, true)
        .x_origin(view.low.x)
        .y_origin(view.low.y)
        .x_step(cell.x)
        .y_step(cell.y);
    let contours = builder.contours(&map.values(), &levels).unwrap_or_default();
    let crossings = crossings(map);
    let decimals = if frame.scale > 300.0 { 4 } else { 3 };
    for (k, contour) in contours.iter().enumerate() {
        let mut d = String::new();
        for polygon in contour.geometry() {
            for ring in std::iter::once(polygon.exterior()).chain(polygon.interiors()) {
                let points = &ring.0[..ring.0.len().saturating_sub(1)];
                for (n, p) in points.iter().enumerate() {
                    d.push(if n == 0 { 'M' } else { 'L' });
                    let p = ended(map, &crossings, vec2(p.x, p.y));
                    pair(&mut d, (p.x, p.y), decimals);
                }
                d.push('Z');
            }
        }
        if !d.is_empty() {
            let colour = scale.of(between(shade(k + 1)));
            *out += &format!("<path fill=\"{colour}\" fill-rule=\"evenodd\" d=\"{d}\"/>\n");
        }
    }
    *out += "</g>\n";
}

/// Returns a point in units of cells: their centres have integer coordinates.
fn in_cells(low: Vec2, cell: Vec2, p: Vec2) -> Vec2 {
    vec2((p.x - low.x) / cell.x - 0.5, (p.y - low.y) / cell.y - 0.5)
}

/// Returns the point, or the one with x and y exchanged.
fn exchanged(p: Vec2, exchange: bool) -> Vec2 {
    if exchange { vec2(p.y, p.x) } else { p }
}

/// Crossings of walls with the lines between centres of neighbouring cells, in cells from the centre before: by whether
/// the line is along y, the place of this centre along the line, and that of the line. Contours run between the centres;
/// a contour between two sides of a wall is moved onto the wall.
type Crossings = BTreeMap<(bool, i64, i64), f64>;

fn crossings(map: &DensityMap) -> Crossings {
    let mut all = Crossings::new();
    for side in &map.walls {
        for (along_y, lines) in [(false, map.rows), (true, map.columns)] {
            let place = |p: Vec2| exchanged(in_cells(map.view.low, map.cell(), p), along_y);
            let [a, b] = side.map(place);
            let (low, high) = (a.y.min(b.y).max(-1.0), a.y.max(b.y).min(lines as f64));
            let between = if a.y == b.y { 0..0 } else { low.ceil() as i64..high.floor() as i64 + 1 };
            for line in between {
                let x = a.x + (b.x - a.x) * (line as f64 - a.y) / (b.y - a.y);
                all.insert((along_y, x.floor() as i64, line), x - x.floor());
            }
        }
    }
    all
}

/// Moves a corner of a contour onto the wall, if there is one between its two centres.
fn ended(map: &DensityMap, crossings: &Crossings, p: Vec2) -> Vec2 {
    for along_y in [false, true] {
        let (low, cell) = (map.view.low, map.cell());
        let at = exchanged(in_cells(low, cell, p), along_y);
        let crossing = crossings.get(&(along_y, at.x.floor() as i64, at.y.round() as i64));
        if let Some(part) = crossing.filter(|_| (at.y - at.y.round()).abs() < 1e-6) {
            let [low, cell, p] = [low, cell, p].map(|v| exchanged(v, along_y));
            return exchanged(vec2(low.x + (at.x.floor() + part + 0.5) * cell.x, p.y), along_y);
        }
    }
    p
}
