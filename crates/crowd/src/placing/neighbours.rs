//! Which circles come near each other: a cell grid filled by counting.

use crowd_mechanics::engine::{Vec2, vec2};

/// Points by the square cells that they are in.
#[derive(Debug)]
pub(super) struct CellGrid {
    low: Vec2,
    /// \[1/m\]
    cells_per_length: f64,
    columns: usize,
    rows: usize,
    /// Where the members of each cell begin; one more at the end.
    starts: Vec<u32>,
    members: Vec<u32>,
}

impl CellGrid {
    /// Finite points in cells at least as wide as a distance \[m\].
    pub fn new(points: &[Vec2], distance: f64) -> CellGrid {
        let first = points.first().copied().unwrap_or(Vec2::ZERO);
        let low = points.iter().fold(first, |low, p| vec2(low.x.min(p.x), low.y.min(p.y)));
        let high = points.iter().fold(first, |high, p| vec2(high.x.max(p.x), high.y.max(p.y)));
        // Wider cells where the points are far apart: no more than a few cells for each.
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
        // Counted; now where each cell ends; then, filled from its end, where it begins.
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
        // `as` saturates: points outside belong to the outermost cells.
        let place = (point - self.low) * self.cells_per_length;
        ((place.x as usize).min(self.columns - 1), (place.y as usize).min(self.rows - 1))
    }

    fn home(&self, point: Vec2) -> usize {
        let (column, row) = self.cell(point);
        row * self.columns + column
    }

    /// Calls `meet` for each point that may lie within the distance of a point, and for others.
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
