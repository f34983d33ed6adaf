//! Finds circles that are near each other: a cell grid, filled by counting.

use lemons_core::plane::{Vec2, vec2};

/// Points, sorted by square cells.
#[derive(Debug)]
pub(super) struct CellGrid {
    low: Vec2,
    /// \[1/m\]
    cells_per_length: f64,
    columns: usize,
    rows: usize,
    /// Index of the first member of each cell, and the end of the last cell.
    starts: Vec<u32>,
    members: Vec<u32>,
}

impl CellGrid {
    /// Sorts finite points into cells of at least the width `distance` \[m\].
    pub fn new(points: &[Vec2], distance: f64) -> CellGrid {
        let first = points.first().copied().unwrap_or(Vec2::ZERO);
        let low = points.iter().fold(first, |low, p| vec2(low.x.min(p.x), low.y.min(p.y)));
        let high = points.iter().fold(first, |high, p| vec2(high.x.max(p.x), high.y.max(p.y)));
        // Cells are wider if the points are far apart: there are only a few cells for each point.
        let most = (4 * points.len() + 16) as f64;
        let (width, height) = (high.x - low.x, high.y - low.y);
        let mut cell = distance.max(1e-9).max((width * height / most).sqrt()).max(width.max(height) / most);
        let count = |length: f64, cell: f64| (length / cell) as usize + 1;
        while (count(width, cell) * count(height, cell)) as f64 > 4.0 * most {
            cell *= 2.0;
        }
        let (columns, rows) = (count(width, cell), count(height, cell));
        let mut grid = CellGrid {
            low,
            cells_per_length: 1.0 / cell,
            columns,
            rows,
            starts: vec![0; columns * rows + 1],
            members: vec![0; points.len()],
        };
        let homes: Vec<usize> = points.iter().map(|&p| grid.home(p)).collect();
        for &home in &homes {
            grid.starts[home] += 1;
        }
        // The counts become ends of cells. Filling each cell from its end then turns them into starts.
        let mut end = 0;
        for start in &mut grid.starts {
            end += *start;
            *start = end;
        }
        for (k, &home) in homes.iter().enumerate().rev() {
            grid.starts[home] -= 1;
            grid.members[grid.starts[home] as usize] = k as u32;
        }
        grid
    }

    fn cell(&self, point: Vec2) -> (usize, usize) {
        // `as` saturates: points outside are in the outermost cells.
        let place = (point - self.low) * self.cells_per_length;
        ((place.x as usize).min(self.columns - 1), (place.y as usize).min(self.rows - 1))
    }

    fn home(&self, point: Vec2) -> usize {
        let (column, row) = self.cell(point);
        row * self.columns + column
    }

    /// Calls `meet` for each point that may lie within the distance of a point, and for some others.
    #[inline]
    pub fn for_each_near(&self, point: Vec2, mut meet: impl FnMut(usize)) {
        let (column, row) = self.cell(point);
        let last = (column + 1).min(self.columns - 1);
        for row in row.saturating_sub(1)..=(row + 1).min(self.rows - 1) {
            let cells = row * self.columns + column.saturating_sub(1)..row * self.columns + last + 1;
            for &member in &self.members[self.starts[cells.start] as usize..self.starts[cells.end] as usize] {
                meet(member as usize);
            }
        }
    }
}
