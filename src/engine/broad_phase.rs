//! Finds bodies that may meet: a cell grid over circles, and the sorted list of candidate pairs.

use super::circle::Circle;
use super::near_pairs::Candidates;
use super::{BodyId, DiskId, FaceId, Pose, Scene, Vec2};
use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};
use thiserror::Error;

/// \[m\] The skin of a body that does not move fast. Two disks are candidates if they were nearer than the sum of their
/// bodies' skins when these were listed; a disk and a face, if they were nearer than the one skin. Each body has a margin
/// ([`near_margin`]), which is less than its skin. It is listed anew when it has moved by the difference. A larger skin
/// means longer lists that hold longer. The motion does not depend on it.
const SKIN: f64 = 0.03;

/// Returns the skin \[m\] of a body that has some margin \[m\].
pub(super) fn skin_for(margin: f64) -> f64 {
    SKIN.max(2.0 * margin)
}

/// \[m\] Active bodies nearer than this to one that is free make it active: see [`Watch`].
pub(super) const AWAKE: f64 = 0.02;

/// When it is looked again for free bodies near active ones. The choice of free bodies, and the time when one becomes
/// active, depend on it; so do the last digits of results. It depends on the state and the drive alone, not on lists.
pub(super) struct Watch {
    /// \[m\] Twice the distance that a body may move until the next look.
    margin: f64,
    /// \[m\] What is left of this distance.
    leeway: f64,
    /// Number of steps before the last look.
    step: u64,
}

impl Watch {
    /// \[m\] The first margin.
    const FIRST: f64 = 0.002;

    pub fn new() -> Watch {
        Watch { margin: Watch::FIRST, leeway: 0.5 * Watch::FIRST, step: 0 }
    }

    /// Bodies have moved by a distance \[m\] at most. Returns whether it is time to look.
    pub fn is_over(&mut self, moved: f64) -> bool {
        self.leeway -= moved;
        self.leeway <= 0.0
    }

    /// Begins anew after a step. Returns how far \[m\] a body may have moved since it was looked near it.
    pub fn begin(&mut self, step: u64) -> f64 {
        let movement = (0.5 * self.margin - self.leeway) / (step - self.step) as f64;
        // Faster bodies move further between two looks, but have fewer steps. A step that fails must not change later ones.
        let margin = match movement.is_nan() {
            true => Watch::FIRST,
            false => (0.42 * movement.sqrt()).clamp(0.0005, 0.5 * AWAKE),
        };
        *self = Watch { margin, leeway: 0.5 * margin, step };
        0.5 * (AWAKE - margin)
    }
}

/// Returns the margin \[m\] of a body that moves by some distance \[m\] in a step, to last for some steps: candidates
/// nearer than the sum of their margins are checked in every mechanical step. So those who run do not lengthen the list
/// of all others.
pub(super) fn near_margin(movement: f64, mean_movement: f64, steps: f64) -> f64 {
    /// \[m\] What a body at rest has, because it may begin to move.
    const LEAST: f64 = 0.00025;
    // `min` takes the number if the movement is none.
    (LEAST + steps * (1.1 * movement + 0.4 * mean_movement)).min(MOST_MARGIN)
}

/// \[m\] The largest margin. A body that moves further in a step counts as this in the mean: one that explodes must not
/// lengthen the lists of all others.
pub(super) const MOST_MARGIN: f64 = 0.06;

/// Returns for how many steps a list of near pairs should last, if bodies move by this distance \[m\] in a step and some
/// steps are left. It costs some 80 ns per agent to make it; checking the pairs of one more millimetre costs some 0.9 ns
/// per agent in each step. So the best number is inversely proportional to the root of the distance. The factor was
/// found by trial: 0.15 and 0.4 need more instructions in short steps. Lists share the steps that are left.
pub(super) fn steps_of_near_pairs(mean_movement: f64, left: f64) -> f64 {
    let best = (0.21 / mean_movement.sqrt()).max(1.0);
    let lists = libm::round(left / best).max(1.0);
    left / lists
}

/// Whether a disk may have moved further than a distance \[m\]; `reach` \[m\] is the distance of the furthest disk from
/// the centre of mass.
#[inline]
pub(super) fn moved_further(leeway: f64, reach: f64, then: &Pose, now: &Pose) -> bool {
    let left = leeway - reach * (now.orientation - then.orientation).abs();
    // Negated, so that a pose that is not a number counts as moved.
    !(left > 0.0 && (now.position - then.position).norm_squared() < left * left)
}

/// Circles, sorted by the cells of their centres.
///
/// Cells are squares as wide as the largest circle requires: near circles are in the same cell or in neighbouring ones.
/// All cells of the plane share a hash table. Cells of a row are adjacent in it and wrap round at its end; successive
/// rows begin far from each other. So the table is small wherever the circles are, and one circle far away does not
/// enlarge it. Cells that share an entry only cost an additional check.
#[derive(Debug)]
pub(super) struct CellGrid {
    /// \[1/m\]
    cells_per_length: f64,
    /// Number of entries, which is a power of two, minus one.
    mask: u64,
    /// Distance in the table between the starts of two successive rows.
    row: u64,
    /// Index of the first member of each entry; one more at the end.
    starts: Vec<u32>,
    members: Vec<(u32, Circle)>,
}

impl CellGrid {
    /// Makes a grid of some circles, to find those nearer than a margin \[m\].
    pub fn new(circles: &[Circle], who: impl Iterator<Item = usize> + Clone, margin: f64) -> CellGrid {
        let largest = who.clone().map(|k| circles[k].radius).fold(0.0, f64::max);
        CellGrid::near(largest, circles, who, margin, 1)
    }

    /// Makes the same for circles up to a radius \[m\] that look for those in the grid, which are no larger. If most of
    /// them find nothing, more entries per member save checks.
    pub fn near(
        largest: f64,
        circles: &[Circle],
        who: impl Iterator<Item = usize> + Clone,
        margin: f64,
        entries_per_member: usize,
    ) -> CellGrid {
        // With fewer entries the three rows around a cell might share some.
        let places = (entries_per_member * who.clone().count()).next_power_of_two().max(64);
        let mut grid = CellGrid {
            cells_per_length: 1.0 / (2.0 * largest + margin),
            mask: places as u64 - 1,
            // Golden section: neighbouring rows are far apart in the table.
            row: (places as f64 * 0.618) as u64 | 1,
            starts: vec![0; places + 1],
            members: Vec::new(),
        };
        let homes: Vec<u32> = who.clone().map(|k| grid.home(&circles[k])).collect();
        for &home in &homes {
            grid.starts[home as usize] += 1;
        }
        // The counts become ends of entries. Filling each from its end then turns them into starts.
        let mut end = 0;
        for start in &mut grid.starts {
            end += *start;
            *start = end;
        }
        grid.members = vec![(0, Circle { centre: Vec2::zeros(), radius: 0.0 }); homes.len()];
        for (k, &home) in who.zip(&homes) {
            let start = &mut grid.starts[home as usize];
            *start -= 1;
            grid.members[*start as usize] = (k as u32, circles[k]);
        }
        grid
    }

    /// The floor. `as` saturates: circles far away and circles that are not finite share the outermost cells.
    fn cell(&self, coordinate: f64) -> i64 {
        let cells = coordinate * self.cells_per_length;
        let towards_zero = cells as i64;
        towards_zero.saturating_sub(i64::from(cells < towards_zero as f64))
    }

    fn place(&self, row: i64, column: i64) -> u64 {
        (row as u64).wrapping_mul(self.row).wrapping_add(column as u64) & self.mask
    }

    fn home(&self, circle: &Circle) -> u32 {
        self.place(self.cell(circle.centre.y), self.cell(circle.centre.x)) as u32
    }

    /// Calls `visit` for every circle nearer to this one than a margin \[m\], in no particular order; also for the
    /// circle itself if it is in the grid.
    ///
    /// Neither the margin nor the circle may be larger than those for which the grid was made.
    pub fn for_each_near(&self, circle: &Circle, margin: f64, mut visit: impl FnMut(usize)) {
        let (row, column) = (self.cell(circle.centre.y), self.cell(circle.centre.x));
        for row in [row.wrapping_sub(1), row, row.wrapping_add(1)] {
            let first = self.place(row, column.wrapping_sub(1));
            // The entries of three cells of a row follow each other, unless they wrap round.
            let end = (first + 3).min(self.mask + 1);
            self.visit(first, end, circle, margin, &mut visit);
            if first + 3 > end {
                self.visit(0, first + 3 - end, circle, margin, &mut visit);
            }
        }
    }

    /// Calls `visit` for those of some entries.
    #[inline(always)]
    fn visit(&self, first: u64, end: u64, circle: &Circle, margin: f64, visit: &mut impl FnMut(usize)) {
        let (from, to) = (self.starts[first as usize], self.starts[end as usize]);
        for (other, at) in &self.members[from as usize..to as usize] {
            if circle.nears(at, margin) {
                visit(*other as usize);
            }
        }
    }
}

/// Largest number of candidates of a small crowd. Each takes up to 250 bytes while it touches: 0.5 GB in all.
const MOST_PAIRS: usize = 2_000_000;
/// Largest number of candidates per disk of a larger crowd: several times that of the densest crowds of people.
const MOST_PAIRS_PER_DISK: usize = 32;

/// More pairs are near each other than the limit of memory allows, for example if everybody is at one point.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[error(
    "too many bodies are at the same place: {others} others and {faces} faces of walls are near it, and in all more than \
     {most} pairs are near each other, which is the limit; are positions missing?"
)]
pub struct Crowded {
    /// A body in the middle of them.
    pub body: BodyId,
    /// Bodies near it.
    pub others: usize,
    /// Faces near it.
    pub faces: usize,
    /// Largest number of pairs.
    pub most: usize,
}

/// The number of candidates that may still be listed, by all threads together.
pub(super) struct PairLimit {
    most: usize,
    taken: AtomicUsize,
}

impl PairLimit {
    pub fn new(scene: &Scene) -> PairLimit {
        let most = MOST_PAIRS.max(MOST_PAIRS_PER_DISK * scene.disks.len());
        PairLimit { most, taken: AtomicUsize::new(0) }
    }

    /// Reserves space for some pairs; returns whether there was enough. Whether it is enough for all does not depend on
    /// the order of the calls.
    pub fn take(&self, pairs: usize) -> bool {
        self.taken.fetch_add(pairs, Ordering::Relaxed).saturating_add(pairs) <= self.most
    }

    /// Returns an error if some pairs were not listed because of the limit.
    pub fn check(&self, scene: &Scene, grid: &CellGrid, circles: &[Circle]) -> Result<(), Crowded> {
        if self.taken.load(Ordering::Relaxed) <= self.most {
            return Ok(());
        }
        let mut crowded = Crowded { body: BodyId(0), others: 0, faces: 0, most: self.most };
        let (mut looks, mut found) = (0, Vec::new());
        for (b, circle) in circles.iter().enumerate() {
            let mut near: usize = 0;
            grid.for_each_near(circle, 0.0, |_| near += 1);
            let others = near.saturating_sub(1); // itself
            let near_faces = scene.face_grid.candidates(circle, 0.0, &mut found);
            let faces = near_faces.iter().filter(|face| circle.nears_face(&scene.faces, **face, 0.0)).count();
            if others + faces > crowded.others + crowded.faces {
                crowded = Crowded { body: BodyId::from(b), others, faces, ..crowded };
            }
            // A sample of this size shows well enough where they are.
            looks += near + near_faces.len();
            if looks > self.most {
                break;
            }
        }
        Err(crowded)
    }
}

/// Whether the distance of a circle from a face is less than a margin \[m\]; `found` is scratch space.
pub(super) fn nears_a_face(scene: &Scene, circle: &Circle, margin: f64, found: &mut Vec<FaceId>) -> bool {
    let candidates = scene.face_grid.candidates(circle, margin, found);
    candidates.iter().any(|face| circle.nears_face(&scene.faces, *face, margin))
}

/// What is done with the pairs of a body with later bodies and faces.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Listing {
    /// They are looked for.
    Anew,
    /// They hold.
    Kept,
}

/// Lists pairs of a disk of some bodies with a disk of a later body or a face, ascending, as long as there is space: those
/// that meet. `disks` (each at its place) and the circles of listed bodies (also in the grid) are larger by the skin.
/// Bodies that need not be listed anew keep their pairs.
pub(super) fn list(
    scene: &Scene,
    disks: &[Circle],
    grid: &CellGrid,
    circles: &[Circle],
    bodies: impl Iterator<Item = (usize, Listing)>,
    candidates: &mut Candidates,
    limit: &PairLimit,
) {
    match scene.levels.as_deref() {
        None => {
            let all = |_, body: usize| std::iter::once(scene.bodies[body].disks.clone());
            list_those(scene, disks, grid, circles, bodies, (all, |_, _| true), candidates, limit);
        }
        Some(levels) => {
            let beside = |disk, body| levels.beside(disk, body);
            let meets = |disk, face: FaceId| levels.meets_face(disk, &scene.faces[face.index()]);
            list_those(scene, disks, grid, circles, bodies, (beside, meets), candidates, limit);
        }
    }
}

/// Number of disks that are looked at together.
const AT_ONCE: usize = 8;

/// Lists them: of a disk and a body the disks that may touch, of a disk and a face whether they may.
#[expect(clippy::too_many_arguments)]
fn list_those<I: Iterator<Item = Range<usize>>>(
    scene: &Scene,
    disks: &[Circle],
    grid: &CellGrid,
    circles: &[Circle],
    bodies: impl Iterator<Item = (usize, Listing)>,
    (beside, meets): (impl Fn(usize, usize) -> I, impl Fn(usize, FaceId) -> bool),
    candidates: &mut Candidates,
    limit: &PairLimit,
) {
    let old = std::mem::take(candidates);
    let (mut old_disks, mut old_faces) = (&old.disks[..], &old.faces[..]);
    let (mut later, mut found, mut faces) = (Vec::new(), Vec::new(), Vec::new());
    for (a, listing) in bodies {
        let own = &scene.bodies[a].disks;
        let of_disks = of_body(&mut old_disks, own);
        let of_faces = of_body(&mut old_faces, own);
        if listing == Listing::Kept {
            if !limit.take(of_disks.len() + of_faces.len()) {
                return;
            }
            candidates.disks.extend_from_slice(of_disks);
            candidates.faces.extend_from_slice(of_faces);
            continue;
        }
        later.clear();
        grid.for_each_near(&circles[a], 0.0, |b| {
            if b > a {
                later.push(b);
            }
        });
        later.sort_unstable();
        faces.clear();
        let near = scene.face_grid.candidates(&circles[a], 0.0, &mut found).iter().copied();
        faces.extend(near.filter(|face| circles[a].nears_face(&scene.faces, *face, 0.0)));
        if later.is_empty() && faces.is_empty() {
            continue;
        }
        for i in scene.bodies[a].disks.clone() {
            let before = candidates.disks.len() + candidates.faces.len();
            let own = disks[i];
            for &b in later.iter().filter(|&&b| own.nears(&circles[b], 0.0)) {
                for range in beside(i, b) {
                    for start in range.clone().step_by(AT_ONCE) {
                        // No branches: processors cannot predict which disks are near.
                        let (mut near, mut count) = ([DiskId(0); AT_ONCE], 0);
                        for (j, other) in disks[start..range.end.min(start + AT_ONCE)].iter().enumerate() {
                            near[count % AT_ONCE] = DiskId::from(start + j);
                            count += usize::from(own.nears(other, 0.0));
                        }
                        candidates.disks.extend(near[..count].iter().map(|&j| (DiskId::from(i), j)));
                    }
                }
            }
            let near =
                faces.iter().filter(|face| meets(i, **face) && own.nears_face(&scene.faces, **face, 0.0));
            candidates.faces.extend(near.map(|&face| (DiskId::from(i), face)));
            let added = candidates.disks.len() + candidates.faces.len() - before;
            if added > 0 && !limit.take(added) {
                return;
            }
        }
    }
    candidates.disks.shrink_to_fit();
    candidates.faces.shrink_to_fit();
}

/// Takes off the pairs of some disks, and those before them, from a list that is ascending.
fn of_body<'a, Other>(pairs: &mut &'a [(DiskId, Other)], disks: &Range<usize>) -> &'a [(DiskId, Other)] {
    let count =
        |end: usize, from: &[(DiskId, Other)]| from.iter().take_while(|pair| pair.0.index() < end).count();
    let (_, rest) = pairs.split_at(count(disks.start, pairs));
    let (own, rest) = rest.split_at(count(disks.end, rest));
    *pairs = rest;
    own
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
