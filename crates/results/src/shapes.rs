//! Checks of polygons that users give.

use lemons_core::plane::Ring;

/// \[m\] From the origin. What is computed of points that are further away has rounding errors that are not seen.
pub(crate) const FARTHEST: f64 = 1e6;
/// More corners of a ring are a mistake.
const MOST_CORNERS: usize = 10_000;

/// Checks a ring that a user gives.
///
/// # Errors
/// The ring is no simple polygon, or reaches too far; the text says how.
pub(crate) fn check(ring: &Ring) -> Result<(), String> {
    // Before anything else: whether it is simple takes time.
    if ring.corners().iter().any(|p| !(p.x.abs() <= FARTHEST && p.y.abs() <= FARTHEST)) {
        return Err(format!("has a corner further than {FARTHEST:e} m from the origin"));
    }
    if ring.corners().len() > MOST_CORNERS {
        return Err(format!("has more than {MOST_CORNERS} corners"));
    }
    if ring.is_simple() { Ok(()) } else { Err("crosses itself or has no area".into()) }
}
