//! Springs from the vectors in files.

use super::face::nearest_on_face;
use super::overlap::{COINCIDENT, Proximity, meet_face, unit};
use super::{
    ContactDisk, DiskId, DiskSpring, FaceId, FaceSpring, InPlane, Pose, Scene, Vec2, rotation, vec2,
};

impl Scene {
    /// Returns the centre \[m\] of a disk when the bodies are at these poses.
    pub fn centre(&self, disk: DiskId, poses: &[Pose]) -> Vec2 {
        let disk = &self.disks[disk.index()];
        let pose = &poses[disk.body.index()];
        pose.position + rotation(pose.orientation) * disk.offset
    }

    /// Returns the spring between two disks from its elongation vector \[m\], as seen by the first disk.
    pub fn disk_spring(&self, first: DiskId, second: DiskId, elongation: Vec2, poses: &[Pose]) -> DiskSpring {
        let between = self.centre(first, poses) - self.centre(second, poses);
        DiskSpring { first, second, elongation: elongation_along(between, elongation) }
    }

    /// Returns the spring between a disk and a face from its elongation vector \[m\].
    pub fn face_spring(&self, disk: DiskId, face: FaceId, elongation: Vec2, poses: &[Pose]) -> FaceSpring {
        let (centre, ContactDisk { body, radius, .. }) =
            (self.centre(disk, poses), &self.disks[disk.index()]);
        let of_wall = &self.faces[face.index()];
        let nearest = nearest_on_face(of_wall, centre);
        let owner = poses[body.index()].position;
        let (meeting, part) = meet_face(of_wall, nearest, centre, *radius, owner);
        let elongation = match meeting {
            Proximity::Touching(overlap) => elongation.dot(&overlap.normal.left()),
            Proximity::Apart | Proximity::Coincident => 0.0,
        };
        FaceSpring { disk, face, part, elongation }
    }
}

/// The component along the tangent of a contact; `between` is the vector between the centres.
fn elongation_along(between: Vec2, elongation: Vec2) -> f64 {
    let distance = between.norm();
    if distance <= COINCIDENT { 0.0 } else { elongation.dot(&unit(between, distance).left()) }
}

/// Returns the elongation vector along the tangent. Reading it gives the same double: where the plain product does not,
/// its components are changed by some units in the last place.
pub fn elongation_vector(tangent: Vec2, elongation: f64) -> Vec2 {
    /// Integers of both signs, smallest first.
    fn around(farthest: i64) -> impl Iterator<Item = i64> {
        (0..=farthest).flat_map(|by| [by, -by])
    }
    let ulps = |value: f64, by: i64| f64::from_bits(value.to_bits().saturating_add_signed(by));
    let plain = tangent * elongation;
    // The larger component changes the product by about its own unit, the smaller one by less.
    let near = around(3).flat_map(|large| around(32).map(move |small| (large, small)));
    let moved = near.map(|(large, small)| {
        let (x, y) = if plain.x.abs() < plain.y.abs() { (small, large) } else { (large, small) };
        vec2(ulps(plain.x, x), ulps(plain.y, y))
    });
    moved.into_iter().find(|vector| vector.dot(&tangent) == elongation).unwrap_or(plain)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use proptest::test_runner::RngSeed;

    proptest! {
        #![proptest_config(ProptestConfig { rng_seed: RngSeed::Fixed(7), ..ProptestConfig::default() })]

        #[test]
        fn vectors_read_back(angle in 0.0..6.3f64, distance in 0.01..1.0f64, elongation in -1e-3..1e-3f64) {
            let turn = rotation(angle);
            let between = vec2(distance * turn.re, distance * turn.im);
            let tangent = unit(between, between.norm()).left();
            let vector = elongation_vector(tangent, elongation);
            prop_assert_eq!(elongation_along(between, vector), elongation);
            prop_assert!((vector - tangent * elongation).norm() <= 1e-13 * elongation.abs());
        }
    }
}
