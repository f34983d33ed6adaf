//! Panels: the parts of walls for which loads are outputs.

use crate::plane::Vec2;
use crate::require;
use crate::trial::geometry::{Geometry, Wall};
use std::ops::Range;

/// Walls that are divided into panels, and how.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PanelChoice {
    /// Those without panels, into some of at most 0.5 m; none if there would be too many.
    Missing,
    /// All, into panels of at most so many metres.
    Longest(f64),
}

/// \[m\] Length of the longest panel, if nobody says it.
const PANEL_LENGTH: f64 = 0.5;
/// Most panels of a Trial.
pub(crate) const MOST_PANELS: usize = 20_000;
/// \[rad\] Sides that turn by at most this much go on straight.
const STRAIGHT: f64 = 1e-6;

/// A straight stretch of a wall, in equal panels: so these do not depend on how a wall is cut into sides.
#[derive(Debug, Clone, PartialEq)]
pub struct Stretch {
    /// \[m\] Its ends.
    pub ends: [Vec2; 2],
    /// Places of its sides in the wall.
    pub sides: Range<usize>,
    /// Number of its panels.
    pub panels: usize,
}

impl Stretch {
    /// Returns whether a side that ends there \[m\] goes on in its direction.
    fn goes_on(&self, to: Vec2) -> bool {
        let (along, next) = (self.ends[1] - self.ends[0], to - self.ends[1]);
        along.dot(&next) > 0.0 && along.perp(&next).abs() <= STRAIGHT * along.norm() * next.norm()
    }
}

impl Wall {
    /// Returns its straight stretches; none if it has no panels.
    pub fn stretches(&self) -> Vec<Stretch> {
        let Some(longest) = self.panel_length else { return Vec::new() };
        let mut all: Vec<Stretch> = Vec::new();
        for (k, [start, end]) in self.sides().enumerate() {
            match all.last_mut().filter(|before| before.goes_on(end)) {
                Some(before) => (before.ends[1], before.sides.end) = (end, k + 1),
                None => all.push(Stretch { ends: [start, end], sides: k..k + 1, panels: 0 }),
            }
        }
        for Stretch { ends: [start, end], panels, .. } in &mut all {
            // A stretch of 2.0000000001 m has four of 0.5 m.
            *panels = (((*end - *start).norm() / longest - 1e-9).ceil() as usize).max(1);
        }
        all
    }

    /// Returns the ends \[m\] of its panels.
    pub fn panels(&self) -> impl Iterator<Item = [Vec2; 2]> {
        self.stretches().into_iter().flat_map(|Stretch { ends: [start, end], panels, .. }| {
            let part = move |k: usize| start + (end - start) * (k as f64 / panels as f64);
            // The last one ends at the corner, without rounding.
            let at = move |k: usize| if k == panels { end } else { part(k) };
            (0..panels).map(move |k| [at(k), at(k + 1)])
        })
    }
}

impl Geometry {
    /// Divides walls into panels.
    ///
    /// # Errors
    /// A sentence: there would be too many.
    pub fn divide(&mut self, panels: PanelChoice) -> Result<(), String> {
        let before = self.clone();
        let longest = match panels {
            PanelChoice::Missing => PANEL_LENGTH,
            PanelChoice::Longest(longest) => longest,
        };
        let stays = |wall: &Wall| panels == PanelChoice::Missing && wall.panel_length.is_some();
        self.walls.iter_mut().filter(|wall| !stays(wall)).for_each(|wall| wall.panel_length = Some(longest));
        let count = self.panel_count();
        if count > MOST_PANELS && panels == PanelChoice::Missing {
            *self = before;
            return Ok(());
        }
        require(count <= MOST_PANELS, || {
            format!(
                "panels of at most {longest} m would be {count}; at most {MOST_PANELS} can be: take longer ones"
            )
        })
    }

    /// Returns all panels, in file order: the wall of each, and its ends \[m\].
    pub fn panels(&self) -> impl Iterator<Item = (&Wall, [Vec2; 2])> {
        self.walls.iter().flat_map(|wall| wall.panels().map(move |ends| (wall, ends)))
    }

    /// Returns the number of all panels.
    pub fn panel_count(&self) -> usize {
        let all = self.walls.iter().flat_map(Wall::stretches);
        all.map(|stretch| stretch.panels).fold(0, usize::saturating_add)
    }
}
