//! Finds faces near a circle: a grid of cells over the walls, made with the scene, and again when walls open or close.

use super::circle::Circle;
use super::{Face, FaceId, Vec2, WallId, vec2};

/// Rectangular cells over all walls that are there, each with the faces that cross it, ascending.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct FaceGrid {
    low: Vec2,
    /// \[m\] Size of a cell, along x and y.
    size: Vec2,
    columns: usize,
    rows: usize,
    /// Index of the first face of each cell in `faces`; one more at the end.
    starts: Vec<u32>,
    faces: Vec<FaceId>,
}

/// Cells per face: more cells make queries faster and the grid larger.
const CELLS_PER_FACE: usize = 4;
/// Largest number of cells along one side. A face crosses at most twice as many cells.
const MOST_CELLS_PER_SIDE: f64 = 1000.0;

impl FaceGrid {
    /// Makes the grid of the faces of some walls.
    pub fn new(faces: &[Face], present: impl Fn(WallId) -> bool) -> FaceGrid {
        let faces: Vec<(FaceId, &Face)> = faces
            .iter()
            .enumerate()
            .map(|(place, face)| (FaceId::from(place), face))
            .filter(|(_, face)| present(face.wall))
            .collect();
        let ends = || faces.iter().flat_map(|(_, face)| [face.start, face.end]);
        let Some(first) = ends().next() else { return FaceGrid::default() };
        let (low, high) = ends().fold((first, first), |(low, high), end| {
            (vec2(low.x.min(end.x), low.y.min(end.y)), vec2(high.x.max(end.x), high.y.max(end.y)))
        });
        // As nearly square as possible; a wall along an axis makes a single row of cells.
        let cells = (CELLS_PER_FACE * faces.len()) as f64;
        let (width, height) = (high.x - low.x, high.y - low.y);
        let side = (width * height / cells).sqrt().max(width.max(height) / cells);
        // Walls without extent need one cell.
        let count = |length: f64| (length / side).ceil().clamp(1.0, MOST_CELLS_PER_SIDE) as usize;
        let count = |length| count(length).max(1);
        let (columns, rows) = (count(width), count(height));
        let size = vec2(width / columns as f64, height / rows as f64);
        let mut grid = FaceGrid { low, size, columns, rows, ..FaceGrid::default() };
        let mut entries: Vec<(usize, FaceId)> = Vec::new();
        for (place, face) in &faces {
            grid.for_each_cell(face, |cell| entries.push((cell, *place)));
        }
        entries.sort_unstable();
        entries.dedup();
        grid.starts = vec![0; columns * rows + 1];
        for (cell, _) in &entries {
            grid.starts[cell + 1] += 1;
        }
        for cell in 0..columns * rows {
            grid.starts[cell + 1] += grid.starts[cell];
        }
        grid.faces = entries.into_iter().map(|(_, face)| face).collect();
        grid
    }

    /// The column of a coordinate. Coordinates outside belong to the outermost columns, NaN to the first.
    fn column(&self, x: f64) -> usize {
        (((x - self.low.x) / self.size.x).max(0.0) as usize).min(self.columns - 1)
    }

    fn row(&self, y: f64) -> usize {
        (((y - self.low.y) / self.size.y).max(0.0) as usize).min(self.rows - 1)
    }

    /// Visits the cells that a face crosses, and perhaps neighbours in the same rows.
    fn for_each_cell(&self, face: &Face, mut visit: impl FnMut(usize)) {
        let (from, to) =
            if face.start.y <= face.end.y { (face.start, face.end) } else { (face.end, face.start) };
        let rise = to.y - from.y;
        let x_at = |y: f64| {
            let share = ((y - from.y) / rise).clamp(0.0, 1.0);
            from.x + (to.x - from.x) * share
        };
        let (first, last) = (self.row(from.y), self.row(to.y));
        for row in first..=last {
            // x where it enters and leaves the row.
            let enters = if row == first { from.x } else { x_at(self.low.y + row as f64 * self.size.y) };
            let leaves = if row == last { to.x } else { x_at(self.low.y + (row + 1) as f64 * self.size.y) };
            // One more column on both sides, because rounding may move the crossing into the next one.
            let left = self.column(enters.min(leaves)).saturating_sub(1);
            let right = (self.column(enters.max(leaves)) + 1).min(self.columns - 1);
            (left..=right).for_each(|column| visit(row * self.columns + column));
        }
    }

    /// Returns every face nearer to a circle than a margin \[m\], ascending, and perhaps others; `found` is scratch
    /// space.
    pub fn candidates<'a>(&self, circle: &Circle, margin: f64, found: &'a mut Vec<FaceId>) -> &'a [FaceId] {
        found.clear();
        if self.columns == 0 {
            return found;
        }
        let (centre, reach) = (circle.centre, circle.radius + margin);
        let (left, right) = (self.column(centre.x - reach), self.column(centre.x + reach));
        // One more row on both sides, for the same reason.
        let bottom = self.row(centre.y - reach).saturating_sub(1);
        let top = (self.row(centre.y + reach) + 1).min(self.rows - 1);
        for row in bottom..=top {
            let cells = row * self.columns + left..=row * self.columns + right;
            let (from, to) = (self.starts[*cells.start()], self.starts[cells.end() + 1]);
            found.extend_from_slice(&self.faces[from as usize..to as usize]);
        }
        found.sort_unstable();
        found.dedup();
        found
    }
}

#[cfg(test)]
mod tests {
    use super::super::{LawTable, Scene, WallSpec, vec2};
    use super::*;
    use proptest::prelude::*;
    use proptest::test_runner::RngSeed;

    fn walls(corners: &[Vec<Vec2>]) -> Scene {
        let specs: Vec<WallSpec> =
            corners.iter().map(|corners| WallSpec { material: 0, corners: corners.clone() }).collect();
        Scene::new(&[], &specs, LawTable::new(1))
    }

    /// The candidates that are near are all that are near.
    fn finds_all(scene: &Scene, circle: &Circle, margin: f64) {
        let near = |face: &FaceId| circle.nears_face(&scene.faces, *face, margin);
        let expected: Vec<FaceId> = (0..scene.faces.len()).map(FaceId::from).filter(near).collect();
        let mut scratch = Vec::new();
        let candidates = scene.face_grid.candidates(circle, margin, &mut scratch);
        assert!(candidates.is_sorted());
        let found: Vec<FaceId> = candidates.iter().copied().filter(near).collect();
        assert_eq!(found, expected, "{circle:?}");
    }

    proptest! {
        #![proptest_config(ProptestConfig { rng_seed: RngSeed::Fixed(7), ..ProptestConfig::default() })]

        #[test]
        fn every_near_face_is_found(
            corners in prop::collection::vec(prop::collection::vec((-3.0..3.0f64, -3.0..3.0f64), 2..6), 0..12),
            circles in prop::collection::vec((-4.0..4.0f64, -4.0..4.0f64, 0.01..0.8f64), 1..20),
            scale in prop::sample::select(vec![1e-3, 1.0, 1e4]),
            flat in prop::sample::select(vec![0.0, 1.0]),
        ) {
            let place = |&(x, y): &(f64, f64)| vec2(x * scale, y * scale * flat);
            let scene = walls(&corners.iter().map(|wall| wall.iter().map(place).collect()).collect::<Vec<_>>());
            for (x, y, radius) in circles {
                finds_all(&scene, &Circle { centre: vec2(x * scale, y * scale), radius: radius * scale }, 0.01);
            }
        }
    }

    #[test]
    fn strange_walls_and_circles() {
        let scenes = [
            walls(&[]),
            walls(&[vec![vec2(1.0, 1.0), vec2(1.0, 1.0)]]),
            walls(&[vec![vec2(0.0, -5.0), vec2(0.0, 5.0)]]),
            walls(&[
                vec![vec2(-1e308, 0.0), vec2(1e308, 1.0), vec2(1e308, -1e308)],
                vec![vec2(0.0, 0.0), vec2(1.0, 0.0)],
            ]),
        ];
        for scene in &scenes {
            for (x, y) in [(1.0, 1.0), (0.0, 0.0), (1e300, -1e300), (f64::NAN, 0.0), (f64::INFINITY, 0.0)] {
                finds_all(scene, &Circle { centre: vec2(x, y), radius: 0.3 }, 0.01);
            }
        }
    }

    /// Only near ones cost: of a thousand faces a person looks at some.
    #[test]
    fn far_faces_are_no_candidates() {
        let zigzag: Vec<Vec2> = (0..=1000).map(|k| vec2(0.1 * f64::from(k), f64::from(k % 2))).collect();
        let scene = walls(&[zigzag]);
        let circle = Circle { centre: vec2(50.0, 0.5), radius: 0.3 };
        let mut scratch = Vec::new();
        let candidates = scene.face_grid.candidates(&circle, 0.01, &mut scratch).len();
        assert!((6..40).contains(&candidates), "{candidates}");
        finds_all(&scene, &circle, 0.01);
    }
}
