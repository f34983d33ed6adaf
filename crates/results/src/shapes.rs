//! Polygons as `i_overlay` wants them, and the one place that calls it: its generic code takes long to build.

use i_overlay::core::fill_rule::FillRule;
use i_overlay::core::overlay_rule::OverlayRule;
use i_overlay::float::single::SingleFloatOverlay;
use lemons_core::plane::{Ring, vec2};

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

/// The corners of a ring \[m\].
pub(crate) type Contour = Vec<[f64; 2]>;
/// A polygon with holes: the first contour is its rim.
pub(crate) type Shape = Vec<Contour>;

pub(crate) fn overlay(one: &Shape, other: &Shape, rule: OverlayRule, fill: FillRule) -> Vec<Shape> {
    one.overlay(other, rule, fill)
}

pub(crate) fn contour(ring: &Ring) -> Contour {
    ring.corners().iter().map(|p| [p.x, p.y]).collect()
}

pub(crate) fn ring(contour: &Contour) -> Option<Ring> {
    Ring::through(contour.iter().map(|[x, y]| vec2(*x, *y)).collect())
}
