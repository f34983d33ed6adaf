//! People per area.

use crate::plane::{View, near};
use crowd_mechanics::engine::{Vec2, vec2};
use crowd_mechanics::trial::Wall;

/// \[m\] Standard deviation of the kernel unless another is given: half a shoulder breadth and a bit.
pub const DENSITY_KERNEL: f64 = 0.3;
/// Cells per standard deviation of the kernel, both ways; finer where walls end it.
const CELLS_PER_KERNEL: f64 = 4.0;
const CELLS_AT_WALLS: f64 = 8.0;
/// Most cells of a map: beyond them the cells are larger.
const MOST_CELLS: f64 = 100_000.0;
/// Cells beyond the map, on each side: more only in a view much smaller than the kernel.
const MOST_BEYOND: i64 = 400;
/// The kernel is cut here, in standard deviations: 2 · 10⁻⁹ of a person is lost.
const REACH: f64 = 6.0;

/// People per m² on a grid, averaged over the frames added.
///
/// Everybody is a Gaussian of unit integral; a cell has the mean of it, so that the sum over a grid that is
/// wide enough, times a cell's area, is the number of people. Walls hold the kernel back: a cell has its part
/// only if the straight line from the person to its centre crosses no wall, and what is left of the Gaussian
/// is enlarged until its integral is one person again.
#[derive(Debug, Clone, PartialEq)]
pub struct DensityMap {
    view: View,
    kernel: f64,
    columns: usize,
    rows: usize,
    frames: usize,
    /// Row by row from the lowest, summed over the frames.
    sum: Vec<f64>,
    /// \[m\] sides of walls.
    walls: Vec<[Vec2; 2]>,
    /// \[1/m²\] ends of the colour map; 0 and the highest density when `None`.
    pub range: Option<(f64, f64)>,
}

impl DensityMap {
    /// An empty map of this part of the plane. `kernel` \[m\] is the standard deviation of the Gaussian,
    /// [`DENSITY_KERNEL`] in place of one that is not positive and finite.
    pub fn new(view: View, kernel: f64, walls: &[Wall]) -> DensityMap {
        let sides = walls.iter().flat_map(|wall| wall.corners.windows(2).map(|side| [side[0], side[1]]));
        let walls: Vec<[Vec2; 2]> = sides.filter(|[a, b]| near(*a) && near(*b) && a != b).collect();
        let kernel = if kernel.is_finite() && kernel > 0.0 { kernel } else { DENSITY_KERNEL };
        let view = if near(view.low) && near(view.high) {
            view
        } else {
            View { low: vec2(-0.5, -0.5), high: vec2(0.5, 0.5) }
        };
        let size = vec2((view.high.x - view.low.x).max(1e-3), (view.high.y - view.low.y).max(1e-3));
        let view = View { low: view.low, high: view.low + size };
        let finest = kernel / if walls.is_empty() { CELLS_PER_KERNEL } else { CELLS_AT_WALLS };
        let cells = |cell: f64| ((size.x / cell).ceil().max(1.0), (size.y / cell).ceil().max(1.0));
        let mut cell = finest;
        while cells(cell).0 * cells(cell).1 > MOST_CELLS {
            cell *= 1.5;
        }
        let (columns, rows) = (cells(cell).0 as usize, cells(cell).1 as usize);
        let sum = vec![0.0; columns * rows];
        DensityMap { view, kernel, columns, rows, frames: 0, sum, walls, range: None }
    }

    /// Adds a frame: where everybody is at one time \[m\]. Positions that are not finite are nobody's.
    pub fn add(&mut self, positions: impl IntoIterator<Item = Vec2>) {
        self.frames += 1;
        for p in positions.into_iter().filter(|p| near(*p)) {
            self.add_one(p);
        }
    }

    fn add_one(&mut self, p: Vec2) {
        let (cell, p) = (self.cell(), p - self.view.low);
        let reach = REACH * self.kernel;
        let walls: Vec<[Vec2; 2]> = self
            .walls
            .iter()
            .map(|side| side.map(|corner| corner - self.view.low))
            .filter(|[a, b]| {
                a.x.min(b.x) < p.x + reach
                    && a.x.max(b.x) > p.x - reach
                    && a.y.min(b.y) < p.y + reach
                    && a.y.max(b.y) > p.y - reach
            })
            .collect();
        // What is beyond the map counts where the rest of a person is enlarged.
        let all = if walls.is_empty() { 0 } else { MOST_BEYOND };
        let (first_column, along_x) = self.shares(p.x, cell.x, self.columns, all);
        let (first_row, along_y) = self.shares(p.y, cell.y, self.rows, all);
        let mut parts: Vec<f64> = along_y.iter().flat_map(|y| along_x.iter().map(move |x| y * x)).collect();
        if !walls.is_empty() {
            let whole: f64 = parts.iter().sum();
            let count = along_x.len();
            for (row, cells) in parts.chunks_mut(count.max(1)).enumerate() {
                let y = ((first_row + row as i64) as f64 + 0.5) * cell.y;
                for side in &walls {
                    let Some((low, high)) = shadow(p, *side, y) else { continue };
                    // The cells whose centres lie between.
                    let place = |x: f64| (x / cell.x - 0.5 - first_column as f64).clamp(-1.0, count as f64);
                    let (from, to) = (place(low).ceil().max(0.0) as usize, place(high).floor());
                    if to >= 0.0 {
                        let to = (to as usize + 1).min(count);
                        cells[from.min(to)..to].fill(0.0);
                    }
                }
            }
            let left: f64 = parts.iter().sum();
            // Of whom no cell's centre is seen, nothing would be left.
            let enlarged = if left > 0.0 { whole / left } else { 0.0 };
            parts.iter_mut().for_each(|part| *part *= enlarged);
        }
        for (row, cells) in parts.chunks(along_x.len().max(1)).enumerate() {
            let row = first_row + row as i64;
            if !(0..self.rows as i64).contains(&row) {
                continue;
            }
            for (column, part) in cells.iter().enumerate() {
                let column = first_column + column as i64;
                if (0..self.columns as i64).contains(&column) {
                    self.sum[row as usize * self.columns + column as usize] += part;
                }
            }
        }
    }

    /// The first cell that a Gaussian at `x` reaches, and the mean of the Gaussian over that and the next
    /// cells \[1/m\]; of the cells of the map, and so many more on each side.
    fn shares(&self, x: f64, cell: f64, cells: usize, more: i64) -> (i64, Vec<f64>) {
        let (low, high) = (-more, cells as i64 + more);
        let first = (((x - REACH * self.kernel) / cell).floor() as i64).clamp(low, high);
        let last = (((x + REACH * self.kernel) / cell).ceil() as i64).clamp(first, high);
        let below =
            |k: i64| 0.5 * libm::erf((k as f64 * cell - x) / (self.kernel * std::f64::consts::SQRT_2));
        (first, (first..last).map(|k| (below(k + 1) - below(k)) / cell).collect())
    }

    /// The part of the plane that the map covers.
    pub fn view(&self) -> View {
        self.view
    }

    /// \[m\] standard deviation of the Gaussian.
    pub fn kernel(&self) -> f64 {
        self.kernel
    }

    /// In words, what stands for a person.
    pub fn described(&self) -> String {
        let walls = if self.walls.is_empty() { "" } else { ", nothing of it behind a wall" };
        let frames = if self.frames == 1 {
            "one frame".to_owned()
        } else {
            format!("the mean of {} frames", self.frames)
        };
        format!(
            "each person is a Gaussian of standard deviation {} m and integral 1{walls}; {frames}",
            self.kernel
        )
    }

    /// \[m\] sides of walls.
    pub(crate) fn walls(&self) -> &[[Vec2; 2]] {
        &self.walls
    }

    /// Cells along x and along y.
    pub fn cells(&self) -> (usize, usize) {
        (self.columns, self.rows)
    }

    /// \[m\] size of a cell.
    pub fn cell(&self) -> Vec2 {
        let size = self.view.high - self.view.low;
        vec2(size.x / self.columns as f64, size.y / self.rows as f64)
    }

    /// \[1/m²\] mean density of each cell, row by row from the lowest; 0 before the first frame.
    pub fn values(&self) -> Vec<f64> {
        let frames = self.frames.max(1) as f64;
        self.sum.iter().map(|sum| sum / frames).collect()
    }
}

/// The part of the line of this `y` that somebody at `p` does not see for the side of a wall: from this x to that.
/// Nobody on a wall's own line is hidden by it.
fn shadow(p: Vec2, [a, b]: [Vec2; 2], y: f64) -> Option<(f64, f64)> {
    let (a, b) = (a - p, b - p);
    let turn = a.cross(b);
    if turn == 0.0 {
        return None;
    }
    // To the left of p a, to the right of p b, and beyond a b: each a half of the plane.
    let (a, b) = if turn > 0.0 { (a, b) } else { (b, a) };
    let side = b - a;
    let (mut low, mut high) = (f64::NEG_INFINITY, f64::INFINITY);
    for (along, from) in [(a, Vec2::ZERO), (-b, Vec2::ZERO), (-side, a)] {
        // Of along × (x − from.x, y − from.y) ≥ 0: slope · x ≤ limit.
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
