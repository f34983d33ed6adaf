//! The view of a scene on its page.

use crate::page::MARGIN;
use lemons_core::plane::{Bounds, Vec2};

/// Largest height / width of a scene.
const TALLEST: f64 = 1.4;

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
        let size = view.size();
        let scale = (room / size.x).min(TALLEST * room / size.y);
        let drawn = size * scale;
        Frame { unit, view, scale, left: left + 0.5 * (room - drawn.x), top, drawn }
    }

    /// Returns whether the border would cut a disk.
    pub fn cuts(&self, p: Vec2, r: f64) -> bool {
        !self.view.grown(-r).contains(p)
    }

    /// Returns whether part of a disk is on the page.
    pub fn shows(&self, p: Vec2, r: f64) -> bool {
        self.view.grown(r + MARGIN * self.unit / self.scale).contains(p)
    }
}
