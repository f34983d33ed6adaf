//! Shapes built of disks.

use crowd_mechanics::engine::Vec2;

/// A disk of a [`Shape`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Disk {
    /// \[m\] positive.
    pub radius: f64,
    /// \[m\] of its centre, in the frame of its shape.
    pub centre: Vec2,
}

/// The union of some disks: a pedestrian from above, in its own frame: the origin at the centroid of the area, the
/// gaze along +x, so left is +y.
#[derive(Debug, Clone, PartialEq)]
pub struct Shape {
    /// At least one, from the left shoulder to the right one.
    pub disks: Vec<Disk>,
}
