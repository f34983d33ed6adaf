//! What shapes are built of.

use crowd_mechanics::engine::Vec2;

/// A disk of a [`Shape`](crate::Shape).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Disk {
    /// \[m\] positive.
    pub radius: f64,
    /// \[m\] of its centre, in the frame of its shape.
    pub centre: Vec2,
}
