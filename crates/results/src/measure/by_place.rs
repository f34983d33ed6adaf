//! Squeeze by place.

use lemons_core::plane::{Bounds, Vec2, vec2};

/// Largest number of cells; a larger map has larger cells.
const MOST_CELLS: f64 = 100_000.0;

/// Mean and greatest squeeze in the cells of a grid: of all people whose centre of mass is in the cell, at all communication
/// points that are added.
#[derive(Debug, Clone, PartialEq)]
pub struct SqueezeMap {
    view: Bounds,
    columns: usize,
    rows: usize,
    /// Row by row from the lowest: the number of values, their sum \[N\], the greatest \[N\].
    cells: Vec<(u64, f64, f64)>,
}

impl SqueezeMap {
    /// \[m\] Side of a cell of a map that is not too large: about the depth of a body.
    pub const CELL: f64 = 0.25;

    /// Makes an empty map of a part of the plane. Its cells go over the upper ends of that part, if they must.
    pub fn new(view: Bounds) -> SqueezeMap {
        let (size, mut cell) = (view.size(), SqueezeMap::CELL);
        let count = |length: f64, cell: f64| (length / cell - 1e-9).ceil().max(1.0);
        while count(size.x, cell) * count(size.y, cell) > MOST_CELLS {
            cell *= 2.0;
        }
        let (columns, rows) = (count(size.x, cell), count(size.y, cell));
        let view = Bounds { low: view.low, high: view.low + vec2(columns * cell, rows * cell) };
        let (columns, rows) = (columns as usize, rows as usize);
        SqueezeMap { view, columns, rows, cells: vec![(0, 0.0, 0.0); columns * rows] }
    }

    /// Adds the place \[m\] and the squeeze \[N\] of a person at a communication point. Who is not on the map does not count.
    pub fn add(&mut self, at: Vec2, squeeze: f64) {
        let (from, cell) = (at - self.view.low, self.cell());
        let (x, y) = ((from.x / cell.x).floor(), (from.y / cell.y).floor());
        let inside = x >= 0.0 && y >= 0.0 && x < self.columns as f64 && y < self.rows as f64;
        if inside && squeeze.is_finite() {
            let (count, sum, greatest) = &mut self.cells[y as usize * self.columns + x as usize];
            *count += 1;
            *sum += squeeze;
            *greatest = greatest.max(squeeze);
        }
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
        let size = self.view.size();
        vec2(size.x / self.columns as f64, size.y / self.rows as f64)
    }

    /// Returns the mean of each cell \[N\], row by row from the lowest; not a number where nobody was.
    pub fn means(&self) -> Vec<f64> {
        self.cells.iter().map(|(count, sum, _)| sum / *count as f64).collect()
    }

    /// Returns the greatest squeeze in each cell \[N\]; not a number where nobody was.
    pub fn greatest(&self) -> Vec<f64> {
        self.cells.iter().map(|&(count, _, greatest)| if count > 0 { greatest } else { f64::NAN }).collect()
    }

    /// Returns how many values each cell has.
    pub fn counts(&self) -> Vec<f64> {
        self.cells.iter().map(|(count, ..)| *count as f64).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cell_has_the_mean_and_the_greatest_of_those_in_it() {
        let mut map = SqueezeMap::new(Bounds { low: vec2(-0.5, 1.0), high: vec2(0.4, 1.5) });
        assert_eq!((map.cells(), map.cell()), ((4, 2), vec2(0.25, 0.25)));
        // A place on the line between two cells is in the one to the right, or above.
        for (x, y, squeeze) in [(-0.25, 1.0, 100.0), (-0.1, 1.2, 300.0), (0.45, 1.25, 7.0)] {
            map.add(vec2(x, y), squeeze);
        }
        map.add(vec2(0.51, 1.2), 1e6);
        map.add(vec2(f64::NAN, 1.2), 1e6);
        map.add(vec2(0.0, 1.2), f64::NAN);
        assert_eq!(map.counts(), [0.0, 2.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]);
        assert_eq!([map.means()[1], map.greatest()[1], map.means()[7]], [200.0, 300.0, 7.0]);
        assert!(map.means()[0].is_nan() && map.greatest()[0].is_nan());
    }

    #[test]
    fn a_large_map_has_larger_cells() {
        let map = SqueezeMap::new(Bounds { low: vec2(0.0, 0.0), high: vec2(1000.0, 100.0) });
        assert_eq!((map.cell(), map.cells()), (vec2(1.0, 1.0), (1000, 100)));
    }
}
