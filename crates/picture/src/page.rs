//! Layout of the page.

use crate::plane::near;
use crate::scene::Scene;
use lemons_core::plane::{Bounds, Vec2, vec2};

/// \[px\] Page width at which lines and letters have their nominal sizes in px.
pub(crate) const NOMINAL_WIDTH: f64 = 400.0;
/// \[px\] Margin around everything.
pub(crate) const MARGIN: f64 = 14.0;
/// \[px\] Height of capital letters.
pub(crate) const CAP_HEIGHT: f64 = 7.5;
/// \[px\] Gap between the scene and elements above or below it.
pub(crate) const BAND_GAP: f64 = 12.0;
/// Largest height / width of a scene.
pub(crate) const TALLEST: f64 = 1.4;
/// \[m\] Smallest width and height of a view.
const SMALLEST_VIEW: f64 = 0.01;

/// The page, in px.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Page {
    /// Scale of everything that is not drawn to scale.
    pub unit: f64,
    pub width: f64,
    pub height: f64,
}

/// Limits a width to what can be drawn.
pub(crate) fn page_width(asked: f64) -> f64 {
    if asked.is_finite() { asked.clamp(32.0, 32_768.0) } else { NOMINAL_WIDTH }
}

/// The view of a scene, not smaller than can be drawn.
pub(crate) fn view_of(scene: &Scene) -> Bounds {
    let view = scene.view.filter(|v| near(v.low) && near(v.high)).unwrap_or_else(|| scene.extent());
    let grow = |low: f64, high: f64| 0.5 * (SMALLEST_VIEW - (high - low)).max(0.0);
    let by = vec2(grow(view.low.x, view.high.x), grow(view.low.y, view.high.y));
    Bounds { low: view.low - by, high: view.high + by }
}

/// Position and scale of the view on the page.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Frame {
    pub unit: f64,
    pub view: Bounds,
    /// \[px/m\] Scale.
    pub scale: f64,
    /// \[px\] Upper left corner and size of the view.
    pub left: f64,
    pub top: f64,
    pub drawn: Vec2,
}

impl Frame {
    /// Fits the view below `top`, as large as possible and centred in a width `room` from `left` on.
    pub fn fit(view: Bounds, unit: f64, left: f64, room: f64, top: f64) -> Frame {
        let size = view.high - view.low;
        let scale = (room / size.x).min(TALLEST * room / size.y);
        let drawn = size * scale;
        Frame { unit, view, scale, left: left + 0.5 * (room - drawn.x), top, drawn }
    }

    /// Whether the border would cut a disk.
    pub fn cuts(&self, p: Vec2, r: f64) -> bool {
        let Bounds { low, high } = self.view;
        p.x - r < low.x || p.x + r > high.x || p.y - r < low.y || p.y + r > high.y
    }

    /// Whether a disk is completely off the page.
    pub fn misses(&self, p: Vec2, r: f64) -> bool {
        let Bounds { low, high } = self.view;
        let r = r + MARGIN * self.unit / self.scale;
        p.x + r < low.x || p.x - r > high.x || p.y + r < low.y || p.y - r > high.y
    }
}
