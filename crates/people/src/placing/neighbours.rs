//! Finds points that are near each other: a cell grid.

use lemons_core::plane::{Bounds, Vec2};
use std::collections::HashMap;

/// Points in square cells.
#[derive(Debug)]
pub(super) struct CellGrid {
    low: Vec2,
    /// \[1/m\]
    cells_per_length: f64,
    /// By row and column.
    cells: HashMap<[i64; 2], Vec<u32>>,
}

impl CellGrid {
    /// Sorts finite points into cells of at least the width `distance` \[m\].
    pub fn new(points: &[Vec2], distance: f64) -> CellGrid {
        let nowhere = Bounds { low: Vec2::zeros(), high: Vec2::zeros() };
        let bounds = Bounds::of(points.iter().copied()).unwrap_or(nowhere);
        // Cells are wider if the points are far apart. The order in which neighbours are met depends on it.
        let most = (4 * points.len() + 16) as f64;
        let [width, height] = bounds.size().into();
        let cell = distance.max(1e-9).max((width * height / most).sqrt()).max(width.max(height) / most);
        let mut grid = CellGrid { low: bounds.low, cells_per_length: 1.0 / cell, cells: HashMap::new() };
        for (k, &point) in points.iter().enumerate() {
            grid.cells.entry(grid.cell(point)).or_default().push(k as u32);
        }
        grid
    }

    fn cell(&self, point: Vec2) -> [i64; 2] {
        let place = (point - self.low) * self.cells_per_length;
        [place.y, place.x].map(|along| libm::floor(along) as i64)
    }

    /// Moves a point that was at another place.
    pub fn shift(&mut self, who: usize, from: Vec2, to: Vec2) {
        let [before, after] = [from, to].map(|place| self.cell(place));
        self.cells.entry(before).or_default().retain(|&k| k != who as u32);
        self.cells.entry(after).or_default().push(who as u32);
    }

    /// Calls `meet` for each point that may lie within the distance of a point, and for some others.
    #[inline]
    pub fn for_each_near(&self, point: Vec2, mut meet: impl FnMut(usize)) {
        let [row, column] = self.cell(point);
        for row in row - 1..=row + 1 {
            for column in column - 1..=column + 1 {
                let members = self.cells.get(&[row, column]).into_iter().flatten();
                members.for_each(|&member| meet(member as usize));
            }
        }
    }
}
