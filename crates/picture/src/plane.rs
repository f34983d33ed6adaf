//! Points and poses that can be drawn.

use lemons_core::plane::{Pose, Vec2};

/// \[m\] Points further from the origin are not drawn, nor are points that are not finite. Decimals and the
/// rasterizer's single precision are not sufficient there.
const FARTHEST: f64 = 1e6;

/// Whether a body at this pose can be drawn.
pub(crate) fn drawable(pose: &Pose) -> bool {
    near(pose.position) && pose.orientation.is_finite()
}

/// Whether a point can be drawn.
pub(crate) fn near(p: Vec2) -> bool {
    p.x.abs() <= FARTHEST && p.y.abs() <= FARTHEST
}
