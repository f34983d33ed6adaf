//! Points, poses and rectangles that can be drawn.

use crowd_mechanics::engine::Vec2;

/// \[m\] What lies further out than this is not drawn, like what is not finite: the digits and the
/// rasteriser's single precision end there.
const FARTHEST: f64 = 1e6;

/// Where a body stands.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose {
    /// \[m\] centre of mass.
    pub position: Vec2,
    /// \[rad\] direction of the gaze.
    pub theta: f64,
}

impl Pose {
    /// Whether a body can be drawn there.
    pub(crate) fn drawable(&self) -> bool {
        near(self.position) && self.theta.is_finite()
    }
}

/// A rectangle of the plane, `low` its lower left corner.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct View {
    /// \[m\]
    pub low: Vec2,
    /// \[m\]
    pub high: Vec2,
}

/// Whether a point can be drawn.
pub(crate) fn near(p: Vec2) -> bool {
    p.x.abs() <= FARTHEST && p.y.abs() <= FARTHEST
}
