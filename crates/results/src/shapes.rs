//! Polygons as `i_overlay` wants them, and the one place that calls it: its generic code takes long to build.

use i_overlay::core::fill_rule::FillRule;
use i_overlay::core::overlay_rule::OverlayRule;
use i_overlay::float::single::SingleFloatOverlay;
use lemons_core::plane::{Ring, vec2};

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
