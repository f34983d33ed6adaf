//! Finds points that are near each other: a cell grid.

use lemons_core::plane::{Bounds, Vec2};

/// Points in square cells. Points beyond the grid are in its outermost cells.
#[derive(Debug)]
pub(super) struct CellGrid {
    low: Vec2,
    /// \[1/m\]
    cells_per_length: f64,
    columns: usize,
    /// Row by row.
    cells: Vec<Vec<u32>>,
}

impl CellGrid {
    /// Sorts finite points into cells of at least the width `distance` \[m\].
    pub fn new(points: &[Vec2], distance: f64) -> CellGrid {
        let nowhere = Bounds { low: Vec2::ZERO, high: Vec2::ZERO };
        let Bounds { low, high } = Bounds::of(points.iter().copied()).unwrap_or(nowhere);
        // Cells are wider if the points are far apart: there are only a few cells for each point.
        let most = (4 * points.len() + 16) as f64;
        let (width, height) = (high.x - low.x, high.y - low.y);
        let mut cell = distance.max(1e-9).max((width * height / most).sqrt()).max(width.max(height) / most);
        let count = |length: f64, cell: f64| (length / cell) as usize + 1;
        while (count(width, cell) * count(height, cell)) as f64 > 4.0 * most {
            cell *= 2.0;
        }
        let (columns, rows) = (count(width, cell), count(height, cell));
        let cells = vec![Vec::new(); columns * rows];
        let mut grid = CellGrid { low, cells_per_length: 1.0 / cell, columns, cells };
        for (k, &point) in points.iter().enumerate() {
            let (column, row) = grid.cell(point);
            grid.cells[row * columns + column].push(k as u32);
        }
        grid
    }

    fn rows(&self) -> usize {
        self.cells.len() / self.columns
    }

    fn cell(&self, point: Vec2) -> (usize, usize) {
        // `as` saturates: points outside are in the outermost cells.
        let place = (point - self.low) * self.cells_per_length;
        ((place.x as usize).min(self.columns - 1), (place.y as usize).min(self.rows() - 1))
    }

    /// Moves a point that was at another place.
    pub fn shift(&mut self, who: usize, from: Vec2, to: Vec2) {
        let [before, after] = [from, to].map(|place| {
            let (column, row) = self.cell(place);
            row * self.columns + column
        });
        self.cells[before].retain(|&k| k != who as u32);
        self.cells[after].push(who as u32);
    }

    /// Calls `meet` for each point that may lie within the distance of a point, and for some others.
    #[inline]
    pub fn for_each_near(&self, point: Vec2, mut meet: impl FnMut(usize)) {
        let (column, row) = self.cell(point);
        let last = (column + 1).min(self.columns - 1);
        for row in row.saturating_sub(1)..=(row + 1).min(self.rows() - 1) {
            for cell in &self.cells[row * self.columns + column.saturating_sub(1)..=row * self.columns + last]
            {
                cell.iter().for_each(|&member| meet(member as usize));
            }
        }
    }
}
