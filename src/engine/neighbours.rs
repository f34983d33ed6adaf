//! Who may meet whom: a cell grid over circles, and from it the sorted list of candidate pairs.

use super::contacts::Standing;
use super::overlap::nearest_on_face;
use super::pairs::Candidates;
use super::{BodyId, DiskId, FaceId, Scene, Vec2};
use std::sync::atomic::{AtomicUsize, Ordering};
use thiserror::Error;

/// \[m\] Pairs nearer than this are candidates. Their list holds while no disk has moved further than half of
/// what this is more than [`Near`]; a larger skin means longer lists and fewer of them. Who is free and when a free body is taken
/// in depends on it, so last digits do.
pub(super) const SKIN: f64 = 0.02;

/// \[m\] Candidates nearer than this are looked at in every mechanical step. Their list holds while no disk has moved
/// further than half of this. Results do not depend on it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Near(pub f64);

impl Default for Near {
    fn default() -> Near {
        Near(0.002)
    }
}

impl Near {
    /// \[m\] So that each mechanical step still has less to look at than all candidates.
    const LARGEST: f64 = 0.5 * SKIN;
    /// \[m\]
    const SMALLEST: f64 = 0.0005;
    /// \[m^½\] For a movement m per step, a list lasts near/2m steps and has pairs in proportion to it. Making it
    /// takes some 80 ns for each agent, looking at what a millimetre adds some 0.9 ns in each step: all that is least
    /// where near² is 0.18 m · movement.
    const PER_ROOT_OF_MOVEMENT: f64 = 0.42;

    /// The best where disks move so far \[m\] in a step.
    pub fn for_movement(movement: f64) -> Near {
        if movement.is_nan() {
            // A step that fails must leave nothing behind.
            return Near::default();
        }
        Near((Near::PER_ROOT_OF_MOVEMENT * movement.sqrt()).clamp(Near::SMALLEST, Near::LARGEST))
    }
}

/// A circle that holds a body, at one instant or over a whole communication step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Circle {
    pub centre: Vec2,
    pub radius: f64,
}

impl Circle {
    /// Whether two circles come nearer than a margin \[m\].
    pub fn nears(&self, other: &Circle, margin: f64) -> bool {
        let reach = self.radius + other.radius + margin;
        (self.centre - other.centre).norm_squared() <= reach * reach
    }

    /// Whether the circle comes nearer to a face than a margin \[m\].
    pub fn nears_face(&self, scene: &Scene, face: usize, margin: f64) -> bool {
        let face = &scene.faces[face];
        let reach = self.radius + margin;
        // The box around the face first: most faces are far.
        let (low, high) = (face.start.x.min(face.end.x) - reach, face.start.x.max(face.end.x) + reach);
        if self.centre.x < low || self.centre.x > high {
            return false;
        }
        let (low, high) = (face.start.y.min(face.end.y) - reach, face.start.y.max(face.end.y) + reach);
        if self.centre.y < low || self.centre.y > high {
            return false;
        }
        let (nearest, _) = nearest_on_face(face, self.centre);
        (self.centre - nearest).norm_squared() <= reach * reach
    }
}

/// Circles by the cells that their centres are in.
///
/// Square cells as wide as the largest circle needs, so that near circles are in the same cell or in neighbouring
/// ones. All cells of the plane share a table: those of a row lie side by side, wrapped round its end, and each
/// row begins far from the next. So it is small wherever the circles are, and never made larger by one that
/// is far out; cells that share a place cost a look, no more.
#[derive(Debug)]
pub(super) struct CellGrid {
    /// \[1/m\]
    cells_per_length: f64,
    /// The places, a power of two, less one.
    mask: u64,
    /// From the beginning of a row to that of the next.
    row: u64,
    /// Where the members of each place begin; one more at the end.
    starts: Vec<u32>,
    members: Vec<(u32, Circle)>,
}

impl CellGrid {
    /// Of some of the circles, to be asked who is nearer than a margin \[m\].
    pub fn new(circles: &[Circle], who: impl Iterator<Item = usize> + Clone, margin: f64) -> CellGrid {
        let largest = who.clone().map(|k| circles[k].radius).fold(0.0, f64::max);
        // Fewer places, and the three rows around a cell might share some.
        let places = who.clone().count().next_power_of_two().max(64);
        let mut grid = CellGrid {
            cells_per_length: 1.0 / (2.0 * largest + margin),
            mask: places as u64 - 1,
            // By the golden section: rows that are near each other do not come near in the table.
            row: (places as f64 * 0.618) as u64 | 1,
            starts: vec![0; places + 1],
            members: Vec::new(),
        };
        let homes: Vec<u32> = who.clone().map(|k| grid.home(&circles[k])).collect();
        for &home in &homes {
            grid.starts[home as usize] += 1;
        }
        // Counted; now where each place ends; then, filled from its end, where it begins.
        let mut end = 0;
        for start in &mut grid.starts {
            end += *start;
            *start = end;
        }
        grid.members = vec![(0, Circle { centre: Vec2::ZERO, radius: 0.0 }); homes.len()];
        for (k, &home) in who.zip(&homes) {
            let start = &mut grid.starts[home as usize];
            *start -= 1;
            grid.members[*start as usize] = (k as u32, circles[k]);
        }
        grid
    }

    /// `as` saturates: far-away and non-finite circles share the outermost cells.
    fn cell(&self, coordinate: f64) -> i64 {
        libm::floor(coordinate * self.cells_per_length) as i64
    }

    fn place(&self, row: i64, column: i64) -> u64 {
        (row as u64).wrapping_mul(self.row).wrapping_add(column as u64) & self.mask
    }

    fn home(&self, circle: &Circle) -> u32 {
        self.place(self.cell(circle.centre.y), self.cell(circle.centre.x)) as u32
    }

    /// Calls `meet` for every circle, itself too if it is there, that this one comes nearer to than a margin \[m\],
    /// in no order.
    ///
    /// Neither the margin nor the circle may be larger than those that the grid was made for.
    pub fn for_each_near(&self, circle: &Circle, margin: f64, mut meet: impl FnMut(usize)) {
        let (row, column) = (self.cell(circle.centre.y), self.cell(circle.centre.x));
        for row in [row.wrapping_sub(1), row, row.wrapping_add(1)] {
            let first = self.place(row, column.wrapping_sub(1));
            for place in [first, (first + 1) & self.mask, (first + 2) & self.mask] {
                let (from, to) = (self.starts[place as usize], self.starts[place as usize + 1]);
                for (other, at) in &self.members[from as usize..to as usize] {
                    if circle.nears(at, margin) {
                        meet(*other as usize);
                    }
                }
            }
        }
    }
}

/// So many candidates any crowd may have. Each takes up to 250 bytes while it is near and touches: 0.5 GB.
const MOST_PAIRS: usize = 2_000_000;
/// A larger crowd may have so many for each of its disks: some ten times what the densest crowds of people have.
const MOST_PAIRS_PER_DISK: usize = 32;

/// More pairs are near each other than are held in memory, as when everybody stands at one point.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[error(
    "{others} others and {faces} faces of walls are within {} mm of it; more than {most} pairs of disks and of disks \
     and faces are near each other in all, the most that are held: are positions missing?", 1e3 * SKIN
)]
pub struct Crowded {
    /// In the thick of it.
    pub body: BodyId,
    /// Bodies near it.
    pub others: usize,
    /// Faces near it.
    pub faces: usize,
    /// Pairs that are held.
    pub most: usize,
}

/// How many candidates may be listed, by all threads together.
pub(super) struct Room {
    most: usize,
    taken: AtomicUsize,
}

impl Room {
    pub fn new(scene: &Scene) -> Room {
        let most = MOST_PAIRS.max(MOST_PAIRS_PER_DISK * scene.disks.len());
        Room { most, taken: AtomicUsize::new(0) }
    }

    /// Takes room for so many pairs more; whether there was enough. Whether there is enough for all does not
    /// depend on who takes first.
    fn take(&self, pairs: usize) -> bool {
        self.taken.fetch_add(pairs, Ordering::Relaxed).saturating_add(pairs) <= self.most
    }

    /// An error if some were not listed for want of room.
    pub fn check(&self, scene: &Scene, grid: &CellGrid, circles: &[Circle]) -> Result<(), Crowded> {
        if self.taken.load(Ordering::Relaxed) <= self.most {
            return Ok(());
        }
        let mut crowded = Crowded { body: BodyId(0), others: 0, faces: 0, most: self.most };
        let (mut looks, mut found) = (0, Vec::new());
        for (b, circle) in circles.iter().enumerate() {
            let mut near: usize = 0;
            grid.for_each_near(circle, SKIN, |_| near += 1);
            let others = near.saturating_sub(1); // itself
            let near_faces = scene.face_grid.candidates(circle, SKIN, &mut found);
            let faces = near_faces.iter().filter(|face| circle.nears_face(scene, face.index(), SKIN)).count();
            if others + faces > crowded.others + crowded.faces {
                crowded = Crowded { body: BodyId::from(b), others, faces, ..crowded };
            }
            // Of so many it is known well enough where they stand.
            looks += near + near_faces.len();
            if looks > self.most {
                break;
            }
        }
        Err(crowded)
    }
}

/// Whether the circle of a body comes nearer to a face than the skin; `found` is scratch.
pub(super) fn nears_a_face(scene: &Scene, circle: &Circle, found: &mut Vec<FaceId>) -> bool {
    let candidates = scene.face_grid.candidates(circle, SKIN, found);
    candidates.iter().any(|face| circle.nears_face(scene, face.index(), SKIN))
}

/// Lists every pair of a disk of some bodies, ascending, with a disk of a later body or a face that comes within
/// the skin, as far as there is room. The circles of all bodies are in the grid.
pub(super) fn list(
    scene: &Scene,
    standing: &[Standing],
    grid: &CellGrid,
    circles: &[Circle],
    bodies: impl Iterator<Item = usize>,
    candidates: &mut Candidates,
    room: &Room,
) {
    candidates.disks.clear();
    candidates.faces.clear();
    let (mut later, mut found, mut faces) = (Vec::new(), Vec::new(), Vec::new());
    for a in bodies {
        later.clear();
        grid.for_each_near(&circles[a], SKIN, |b| {
            if b > a {
                later.push(b);
            }
        });
        later.sort_unstable();
        faces.clear();
        let near = scene.face_grid.candidates(&circles[a], SKIN, &mut found).iter().copied();
        faces.extend(near.filter(|face| circles[a].nears_face(scene, face.index(), SKIN)));
        if later.is_empty() && faces.is_empty() {
            continue;
        }
        for i in scene.bodies[a].disks.clone() {
            let before = candidates.disks.len() + candidates.faces.len();
            let disk = &scene.disks[i];
            let own = Circle { centre: standing[a].centre(disk.offset), radius: disk.radius };
            for &b in later.iter().filter(|&&b| own.nears(&circles[b], SKIN)) {
                for j in scene.bodies[b].disks.clone() {
                    let disk = &scene.disks[j];
                    let other = Circle { centre: standing[b].centre(disk.offset), radius: disk.radius };
                    if own.nears(&other, SKIN) {
                        candidates.disks.push((DiskId::from(i), DiskId::from(j)));
                    }
                }
            }
            let near = faces.iter().filter(|face| own.nears_face(scene, face.index(), SKIN));
            candidates.faces.extend(near.map(|&face| (DiskId::from(i), face)));
            let added = candidates.disks.len() + candidates.faces.len() - before;
            if added > 0 && !room.take(added) {
                return;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::vec2;
    use super::*;
    use proptest::prelude::*;
    use proptest::test_runner::RngSeed;

    proptest! {
        #![proptest_config(ProptestConfig { rng_seed: RngSeed::Fixed(7), ..ProptestConfig::default() })]

        /// The grid finds what looking at every two finds, across signs and scales.
        #[test]
        fn grid_finds_every_near_pair(
            places in prop::collection::vec((-3.0..3.0f64, -3.0..3.0f64, 0.01..0.5f64), 0..60),
            scale in prop::sample::select(vec![1e-3, 1.0, 1e4]),
        ) {
            let circles: Vec<Circle> = places
                .iter()
                .map(|&(x, y, radius)| Circle { centre: vec2(x * scale, y * scale), radius: radius * scale })
                .collect();
            let grid = CellGrid::new(&circles, 0..circles.len(), 0.01);
            let mut found = Vec::new();
            for (a, circle) in circles.iter().enumerate() {
                grid.for_each_near(circle, 0.01, |b| if a < b { found.push((a, b)) });
            }
            // Each once.
            found.sort_unstable();
            let mut expected = Vec::new();
            for a in 0..circles.len() {
                for b in a + 1..circles.len() {
                    if circles[a].nears(&circles[b], 0.01) {
                        expected.push((a, b));
                    }
                }
            }
            prop_assert_eq!(found, expected);
        }
    }
}
