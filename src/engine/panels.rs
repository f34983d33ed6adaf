//! Panels: the parts of walls for which loads are summed up. They change nothing in the mechanics.

use super::{FaceId, PanelId, Vec2};
use lemons_core::trial::Stretch;
use std::ops::Range;

/// The panels of the faces: equal parts of the straight stretches to which faces belong.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Panels {
    /// For each face the stretch, if its wall has panels; empty if no wall has any.
    stretches: Vec<Option<DividedStretch>>,
    /// \[m\] Length of each panel.
    pub lengths: Vec<f64>,
}

/// A straight stretch of a wall.
#[derive(Debug, Clone, Copy, PartialEq)]
struct DividedStretch {
    first: u32,
    count: u32,
    /// \[m\]
    start: Vec2,
    end: Vec2,
}

impl Panels {
    /// Divides walls, each with the faces of its sides, into the panels of these stretches.
    pub fn new<'a>(faces: usize, walls: impl Iterator<Item = (&'a Range<usize>, Vec<Stretch>)>) -> Panels {
        let mut panels = Panels { stretches: vec![None; faces], lengths: Vec::new() };
        for (own, stretches) in walls {
            for Stretch { ends: [start, end], sides, panels: count } in stretches {
                let first = panels.lengths.len();
                panels.lengths.resize(first + count, (end - start).norm() / count as f64);
                let stretch = DividedStretch { first: first as u32, count: count as u32, start, end };
                panels.stretches[own.start + sides.start..own.start + sides.end].fill(Some(stretch));
            }
        }
        if panels.lengths.is_empty() { Panels::default() } else { panels }
    }

    /// Returns the number of all panels.
    pub fn count(&self) -> usize {
        self.lengths.len()
    }

    /// Returns the panel that is nearest to a place \[m\], on the stretch of a face.
    #[inline]
    pub fn nearest(&self, face: FaceId, place: Vec2) -> Option<PanelId> {
        let DividedStretch { first, count, start, end } = (*self.stretches.get(face.index())?)?;
        let along = end - start;
        let share = (place - start).dot(&along) / along.norm_squared();
        // A cast takes what is below zero to zero.
        Some(PanelId(first + ((share * f64::from(count)) as u32).min(count - 1)))
    }
}
