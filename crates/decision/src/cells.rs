//! People and walls near somebody.

use lemons_core::plane::{Bounds, Vec2, nearest_on_segment, segments_cross, vec2};
use std::ops::Range;

/// People by cells of the plane, sorted, and the faces that may be seen from each cell.
pub(crate) struct Cells<T> {
    /// Column and row of the first cell, counted from the origin.
    first: (f64, f64),
    /// \[m\] Width of a cell.
    pub width: f64,
    columns: usize,
    rows: usize,
    /// Where the people of each cell begin in `seen`; one more than cells.
    starts: Vec<u32>,
    seen: Vec<T>,
    faces: Vec<Vec<[Vec2; 2]>>,
}

impl<T: Copy> Cells<T> {
    /// Makes cells of at least this width \[m\], of people whose place \[m\] is `at`. They see faces as far as `sight`
    /// \[m\]; `seen` is what others see of a person with this index.
    pub fn new<P>(
        people: &[Option<P>],
        at: impl Fn(&P) -> Vec2,
        faces: &[[Vec2; 2]],
        (width, sight): (f64, f64),
        seen: impl Fn(usize, &P) -> T,
    ) -> Cells<T> {
        let there = || people.iter().enumerate().filter_map(|(i, person)| Some((i, person.as_ref()?)));
        let all = Bounds::of(there().map(|(_, person)| at(person)));
        let Bounds { low, high } = all.unwrap_or(Bounds { low: Vec2::zeros(), high: Vec2::zeros() });
        // At most some cells a person, however far apart people are.
        let size = high - low;
        let most = 16.0 * people.len() as f64 + 1024.0;
        let width = width.max((size.x * size.y / most).sqrt()).max(size.x.max(size.y) / most);
        let first = (libm::floor(low.x / width), libm::floor(low.y / width));
        let count = |first: f64, high: f64| (libm::floor(high / width) - first) as usize + 1;
        let (columns, rows) = (count(first.0, high.x), count(first.1, high.y));
        let mut cells = Cells {
            first,
            width,
            columns,
            rows,
            starts: vec![0; columns * rows + 1],
            seen: Vec::new(),
            faces: vec![Vec::new(); columns * rows],
        };
        // By counting; within a cell in the order of people.
        let places: Vec<usize> = there().map(|(_, person)| cells.index(cells.cell(at(person)))).collect();
        places.iter().for_each(|cell| cells.starts[cell + 1] += 1);
        for k in 0..columns * rows {
            cells.starts[k + 1] += cells.starts[k];
        }
        let mut next = cells.starts.clone();
        let mut order = vec![0; places.len()];
        for ((i, _), cell) in there().zip(&places) {
            order[next[*cell] as usize] = i;
            next[*cell] += 1;
        }
        cells.seen.extend(order.into_iter().filter_map(|i| Some(seen(i, people[i].as_ref()?))));
        let reach = sight / width;
        let span = |a: f64, b: f64, first: f64, count: usize| {
            let (low, high) = (a.min(b) / width - first - reach, a.max(b) / width - first + reach);
            (low.max(0.0) as usize).min(count)..((high + 1.0).max(0.0) as usize).min(count)
        };
        for &[a, b] in faces {
            for y in span(a.y, b.y, first.1, rows) {
                for x in span(a.x, b.x, first.0, columns) {
                    let k = y * columns + x;
                    let middle = vec2(x as f64 + 0.5 + first.0, y as f64 + 0.5 + first.1) * width;
                    let far = || (nearest_on_segment(a, b, middle) - middle).norm();
                    if cells.starts[k] < cells.starts[k + 1] && far() < sight + 0.75 * width {
                        cells.faces[k].push([a, b]);
                    }
                }
            }
        }
        cells
    }

    /// Returns the column and the row of the cell in which somebody is.
    pub fn cell(&self, at: Vec2) -> (usize, usize) {
        let of = |x: f64, first: f64, count: usize| {
            ((libm::floor(x / self.width) - first) as usize).min(count - 1)
        };
        (of(at.x, self.first.0, self.columns), of(at.y, self.first.1, self.rows))
    }

    fn index(&self, (column, row): (usize, usize)) -> usize {
        row * self.columns + column
    }

    /// Returns the faces that may be seen from a cell in which somebody is.
    pub fn faces(&self, cell: (usize, usize)) -> &[[Vec2; 2]] {
        &self.faces[self.index(cell)]
    }

    /// Visits those in the cells of a row, in the same order on every machine.
    fn visit(&self, row: usize, columns: Range<usize>, visit: &mut impl FnMut(&T)) {
        let (from, to) = (self.index((columns.start, row)), self.index((columns.end, row)));
        self.seen[self.starts[from] as usize..self.starts[to] as usize].iter().for_each(visit);
    }

    /// Visits those in a cell and in the rings around it.
    pub fn block(&self, (column, row): (usize, usize), rings: usize, mut visit: impl FnMut(&T)) {
        for y in around(row, rings, self.rows) {
            self.visit(y, around(column, rings, self.columns), &mut visit);
        }
    }

    /// Visits those in the cells whose distance from a cell is `ring`, on those of its four sides that count: of whose cells
    /// the lower left and the upper right corner \[m\] say so.
    pub fn ring(
        &self,
        (column, row): (usize, usize),
        ring: usize,
        counts: impl Fn(Vec2, Vec2) -> bool,
        mut visit: impl FnMut(&T),
    ) {
        let (columns, rows) = (around(column, ring, self.columns), around(row, ring, self.rows));
        let corner = |column: usize, row: usize| {
            vec2(column as f64 + self.first.0, row as f64 + self.first.1) * self.width
        };
        let counts = |columns: &Range<usize>, rows: &Range<usize>| {
            counts(corner(columns.start, rows.start), corner(columns.end, rows.end))
        };
        let on_ring = |k: &usize| k.abs_diff(row) == ring;
        for y in rows.clone().filter(on_ring) {
            if counts(&columns, &(y..y + 1)) {
                self.visit(y, columns.clone(), &mut visit);
            }
        }
        let left = column.checked_sub(ring);
        let right = Some(column + ring).filter(|right| *right < self.columns);
        for x in [left, right].into_iter().flatten() {
            if ring > 0 && counts(&(x..x + 1), &rows) {
                for y in rows.clone().filter(|y| !on_ring(y)) {
                    self.visit(y, x..x + 1, &mut visit);
                }
            }
        }
    }
}

fn around(middle: usize, ring: usize, count: usize) -> Range<usize> {
    middle.saturating_sub(ring)..(middle + ring + 1).min(count)
}

/// Returns whether no wall hides two people from each other.
pub(crate) fn sees(from: Vec2, to: Vec2, faces: &[[Vec2; 2]]) -> bool {
    !faces.iter().any(|&[a, b]| segments_cross(from, to, a, b))
}

/// Returns the nearest points of walls with their distances \[m\], which are above 0 and below `reach`. A wall in many pieces
/// is one wall: a corner counts if no piece that ends there comes nearer, and once.
pub(crate) fn nearest_points(at: Vec2, faces: &[[Vec2; 2]], reach: f64) -> impl Iterator<Item = (Vec2, f64)> {
    let nearest = move |face: &[Vec2; 2]| nearest_on_segment(face[0], face[1], at);
    let of_face = move |(n, face): (usize, &[Vec2; 2])| {
        let point = nearest(face);
        let distance = (at - point).norm();
        let counted = |(m, other): (usize, &[Vec2; 2])| {
            m != n && other.contains(&point) && (nearest(other) != point || m < n)
        };
        let near = distance > 0.0 && distance < reach;
        (near && !faces.iter().enumerate().any(counted)).then_some((point, distance))
    };
    faces.iter().enumerate().filter_map(of_face)
}
