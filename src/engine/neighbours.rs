//! Who may meet whom: a cell grid over circles, and from it the sorted list of candidate pairs.

use super::contacts::Placement;
use super::overlap::nearest_on_face;
use super::pairs::Pairs;
use super::{BodyId, DiskId, FaceId, Scene, Vec2};

/// \[m\] Pairs nearer than this are listed. The list holds while no disk has moved further than half of
/// it; a larger skin means longer lists and fewer of them. Results do not depend on it.
pub(super) const SKIN: f64 = 0.01;

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

/// Calls `meet` for every two circles that come nearer than a margin \[m\], each two once.
///
/// The circles are binned into square cells as wide as the largest needs, sorted by row and column, so
/// that each looks at its own cell, the next in its row and three in the row above.
pub(super) fn for_each_near_pair(circles: &[Circle], margin: f64, mut meet: impl FnMut(usize, usize)) {
    let largest = circles.iter().map(|circle| circle.radius).fold(0.0, f64::max);
    let size = 2.0 * largest + margin;
    // `as` saturates: far-away and non-finite circles share the outermost cells.
    let cell = |coordinate: f64| libm::floor(coordinate / size) as i64;
    let mut cells: Vec<(i64, i64, u32)> = circles
        .iter()
        .zip(0..)
        .map(|(circle, k)| (cell(circle.centre.y), cell(circle.centre.x), k))
        .collect();
    cells.sort_unstable();
    let mut above = 0;
    for (at, &(row, column, k)) in cells.iter().enumerate() {
        let k = k as usize;
        let mut visit = |other: u32| {
            if circles[k].nears(&circles[other as usize], margin) {
                meet(k.min(other as usize), k.max(other as usize));
            }
        };
        for &(other_row, other_column, other) in &cells[at + 1..] {
            if other_row != row || other_column > column.saturating_add(1) {
                break;
            }
            visit(other);
        }
        let (next, from, to) = (row.saturating_add(1), column.saturating_sub(1), column.saturating_add(1));
        if next == row {
            continue;
        }
        while above < cells.len() && (cells[above].0, cells[above].1) < (next, from) {
            above += 1;
        }
        for &(other_row, other_column, other) in &cells[above..] {
            if other_row != next || other_column > to {
                break;
            }
            visit(other);
        }
    }
}

/// The faces that the circles of some bodies come nearer to than the skin.
pub(super) fn near_faces(
    scene: &Scene,
    circles: &[Circle],
    bodies: impl Iterator<Item = usize>,
) -> Vec<(BodyId, FaceId)> {
    let (mut near, mut scratch) = (Vec::new(), Vec::new());
    for b in bodies {
        let candidates = scene.face_grid.candidates(&circles[b], SKIN, &mut scratch).iter();
        let faces = candidates.filter(|face| circles[b].nears_face(scene, face.index(), SKIN));
        near.extend(faces.map(|&face| (BodyId::from(b), face)));
    }
    near
}

/// Lists every disk pair and every disk–face pair of the near bodies that comes within the skin.
pub(super) fn list_pairs(
    scene: &Scene,
    placement: &Placement,
    near_bodies: &[(BodyId, BodyId)],
    near_faces: &[(BodyId, FaceId)],
    pairs: &mut Pairs,
) {
    let mut disks = Vec::with_capacity(pairs.disks.len() + 16);
    for &(a, b) in near_bodies {
        for i in scene.bodies[a.index()].disks.clone() {
            for j in scene.bodies[b.index()].disks.clone() {
                let reach = scene.disks[i].radius + scene.disks[j].radius + SKIN;
                let between = placement.centre[i] - placement.centre[j];
                if between.norm_squared() <= reach * reach {
                    disks.push((DiskId::from(i), DiskId::from(j)));
                }
            }
        }
    }
    let mut faces = Vec::with_capacity(pairs.faces.len());
    for &(body, face) in near_faces {
        for i in scene.bodies[body.index()].disks.clone() {
            let circle = Circle { centre: placement.centre[i], radius: scene.disks[i].radius };
            if circle.nears_face(scene, face.index(), SKIN) {
                faces.push((DiskId::from(i), face));
            }
        }
    }
    pairs.replace(scene, disks, faces);
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
            let mut found = Vec::new();
            for_each_near_pair(&circles, 0.01, |a, b| found.push((a, b)));
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
