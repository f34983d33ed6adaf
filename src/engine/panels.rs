//! Panels: the parts of faces for which loads are summed up. They change nothing in the mechanics.

use super::{Face, FaceId, PanelId, Vec2};
use lemons_core::trial::panel_count;

/// The panels of the faces: none, or some of equal length, from the start of the face to its end.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Panels {
    /// The first panel of each face, then the number of all; empty if no face has any.
    first: Vec<u32>,
    /// \[m\] Length of each panel.
    pub lengths: Vec<f64>,
}

impl Panels {
    /// Divides the faces of some walls. `longest` \[m\] is the length of the longest panel of each wall, if it has some.
    pub fn new(faces: &[Face], longest: &[Option<f64>]) -> Panels {
        if longest.iter().all(Option::is_none) {
            return Panels::default();
        }
        let (mut first, mut lengths) = (vec![0], Vec::new());
        for face in faces {
            if let Some(longest) = longest[face.wall.index()] {
                let length = (face.end - face.start).norm();
                let count = panel_count(length, longest);
                lengths.resize(lengths.len() + count, length / count as f64);
            }
            first.push(lengths.len() as u32);
        }
        Panels { first, lengths }
    }

    /// Returns the number of all panels.
    pub fn count(&self) -> usize {
        self.lengths.len()
    }

    /// Returns the panel of a face that is nearest to a place.
    #[inline]
    pub fn nearest(&self, faces: &[Face], face: FaceId, place: Vec2) -> Option<PanelId> {
        let k = face.index();
        let (first, next) = (*self.first.get(k)?, *self.first.get(k + 1)?);
        let last = next.checked_sub(first + 1)?;
        let Face { start, end, .. } = faces[k];
        let along = end - start;
        // A face without length has one panel, and no share.
        let share = (place - start).dot(&along) / along.norm_squared();
        // A cast takes what is below zero to zero.
        let panel = (share * f64::from(last + 1)) as u32;
        Some(PanelId(first + panel.min(last)))
    }
}
