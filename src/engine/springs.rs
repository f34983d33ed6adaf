//! Springs from the vectors that files hold.

use super::overlap::nearest_on_face;
use super::{DiskId, DiskSpring, FaceId, FaceSpring, Pose, Rotation, Scene, Vec2};

impl Scene {
    /// \[m\] the centre of a disk, with bodies at their poses.
    pub fn centre(&self, disk: DiskId, poses: &[Pose]) -> Vec2 {
        let disk = &self.disks[disk.index()];
        let pose = &poses[disk.body.index()];
        pose.position + disk.offset.rotated(Rotation::by(pose.orientation))
    }

    /// The spring between two disks whose elongation is a vector \[m\], as the first one sees it.
    pub fn disk_spring(&self, first: DiskId, second: DiskId, elongation: Vec2, poses: &[Pose]) -> DiskSpring {
        let between = self.centre(first, poses) - self.centre(second, poses);
        DiskSpring { first, second, elongation: along_tangent(elongation, between) }
    }

    /// The spring between a disk and a face whose elongation is a vector \[m\].
    pub fn face_spring(&self, disk: DiskId, face: FaceId, elongation: Vec2, poses: &[Pose]) -> FaceSpring {
        let centre = self.centre(disk, poses);
        let (nearest, part) = nearest_on_face(&self.faces[face.index()], centre);
        FaceSpring { disk, face, part, elongation: along_tangent(elongation, centre - nearest) }
    }
}

/// The component along the tangent of a contact whose centres lie `between` apart.
fn along_tangent(elongation: Vec2, between: Vec2) -> f64 {
    let distance = between.norm();
    if distance == 0.0 { 0.0 } else { elongation.dot(between.perp()) / distance }
}
