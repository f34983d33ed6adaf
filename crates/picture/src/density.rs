//! People per area.

use crate::plane::{View, near};
use crowd_mechanics::engine::{Vec2, vec2};

/// \[m\] Standard deviation of the kernel unless another is given: half a shoulder breadth and a bit.
pub const DENSITY_KERNEL: f64 = 0.3;
/// Cells per standard deviation of the kernel, both ways.
const CELLS_PER_KERNEL: f64 = 4.0;
/// Most cells of a map: beyond them the cells are larger.
const MOST_CELLS: f64 = 100_000.0;
/// The kernel is cut here, in standard deviations: 2 · 10⁻⁹ of a person is lost.
const REACH: f64 = 6.0;

/// People per m² on a grid, averaged over the frames added.
///
/// Everybody is a Gaussian of unit integral; a cell has the mean of it, so that the sum over a grid that is
/// wide enough, times a cell's area, is the number of people. Walls do not hold the kernel back: near one,
/// part of a person is behind it.
#[derive(Debug, Clone, PartialEq)]
pub struct DensityMap {
    view: View,
    kernel: f64,
    columns: usize,
    rows: usize,
    frames: usize,
    /// Row by row from the lowest, summed over the frames.
    sum: Vec<f64>,
    /// \[1/m²\] ends of the colour map; 0 and the highest density when `None`.
    pub range: Option<(f64, f64)>,
}

impl DensityMap {
    /// An empty map of this part of the plane. `kernel` \[m\] is the standard deviation of the Gaussian,
    /// [`DENSITY_KERNEL`] in place of one that is not positive and finite.
    pub fn new(view: View, kernel: f64) -> DensityMap {
        let kernel = if kernel.is_finite() && kernel > 0.0 { kernel } else { DENSITY_KERNEL };
        let view = if near(view.low) && near(view.high) {
            view
        } else {
            View { low: vec2(-0.5, -0.5), high: vec2(0.5, 0.5) }
        };
        let size = vec2((view.high.x - view.low.x).max(1e-3), (view.high.y - view.low.y).max(1e-3));
        let view = View { low: view.low, high: view.low + size };
        let finest = kernel / CELLS_PER_KERNEL;
        let cells = |cell: f64| ((size.x / cell).ceil().max(1.0), (size.y / cell).ceil().max(1.0));
        let mut cell = finest;
        while cells(cell).0 * cells(cell).1 > MOST_CELLS {
            cell *= 1.5;
        }
        let (columns, rows) = (cells(cell).0 as usize, cells(cell).1 as usize);
        DensityMap { view, kernel, columns, rows, frames: 0, sum: vec![0.0; columns * rows], range: None }
    }

    /// Adds a frame: where everybody is at one time \[m\]. Positions that are not finite are nobody's.
    pub fn add(&mut self, positions: impl IntoIterator<Item = Vec2>) {
        self.frames += 1;
        let cell = self.cell();
        for p in positions.into_iter().filter(|p| near(*p)) {
            let along_x = self.shares(p.x - self.view.low.x, cell.x, self.columns);
            let along_y = self.shares(p.y - self.view.low.y, cell.y, self.rows);
            for (row, part) in along_y.1.iter().enumerate() {
                let start = (along_y.0 + row) * self.columns + along_x.0;
                let cells = &mut self.sum[start..start + along_x.1.len()];
                cells.iter_mut().zip(&along_x.1).for_each(|(sum, share)| *sum += part * share);
            }
        }
    }

    /// The first cell that a Gaussian at `x` reaches, and the mean of the Gaussian over that and the next
    /// cells \[1/m\].
    fn shares(&self, x: f64, cell: f64, cells: usize) -> (usize, Vec<f64>) {
        let first = ((x - REACH * self.kernel) / cell).floor().clamp(0.0, cells as f64) as usize;
        let last = ((x + REACH * self.kernel) / cell).ceil().clamp(first as f64, cells as f64) as usize;
        let below =
            |k: usize| 0.5 * libm::erf((k as f64 * cell - x) / (self.kernel * std::f64::consts::SQRT_2));
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
