//! Gaps in walls: how wide they are, where they lead, and what is said of them.

use super::pieces::SNAP;
use crate::Door;
use lemons_core::plane::{Vec2, vec2};

/// \[m\] Gaps of such widths may be doors.
pub const DOOR: [f64; 2] = [0.6, 3.0];

/// Space beyond a gap.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Leads {
    /// From the room to what is outside.
    Outside,
    /// From room to room.
    Inside,
    /// From the room to another, which is not part of it.
    Elsewhere,
}

/// A gap between ends of walls.
#[derive(Debug, Clone, PartialEq)]
pub struct Gap {
    /// \[m\] On the side of the room.
    pub ends: [Vec2; 2],
    /// Where it leads.
    pub leads: Leads,
    /// Number of leaves.
    pub leaves: usize,
    /// Whether lines run from end to end, as those of a window.
    pub crossed: bool,
    /// Whether there is a gap: else the lines of the wall run through, and a swing is drawn on it.
    pub open: bool,
    /// \[m\] The ground in the wall.
    pub(super) quad: [Vec2; 4],
}

impl Gap {
    /// Returns its middle \[m\].
    pub fn at(&self) -> Vec2 {
        (self.ends[0] + self.ends[1]) * 0.5
    }

    /// Returns its width \[m\].
    pub fn width(&self) -> f64 {
        (self.ends[1] - self.ends[0]).norm()
    }

    /// Returns whether it can be a door, without a doubt.
    pub fn is_door(&self) -> bool {
        (DOOR[0] - SNAP..=DOOR[1] + SNAP).contains(&self.width()) && (!self.crossed || self.leaves > 0)
    }

    /// Returns it as a door, to the millimetre.
    pub fn door(&self) -> Door {
        let whole = |length: f64| (1e3 * length).round() / 1e3;
        let at = self.at();
        Door::new(vec2(whole(at.x), whole(at.y)), whole(self.width()))
    }

    /// Returns what it seems to be.
    pub fn kind(&self) -> &'static str {
        match self.leads {
            _ if self.crossed && self.leaves == 0 => "window",
            Leads::Outside if self.is_door() => "door",
            Leads::Outside => "gap",
            Leads::Inside => "passage",
            Leads::Elsewhere => "gap",
        }
    }

    /// Says how wide it is, where, and what it is.
    pub fn described(&self) -> String {
        let [a, b] = self.ends.map(place);
        let leaves = match self.leaves {
            0 => String::new(),
            1 => ", 1 leaf".to_owned(),
            count => format!(", {count} leaves"),
        };
        let what = match self.leads {
            _ if self.crossed && self.leaves == 0 => "lines run across it: shut",
            Leads::Outside if self.is_door() && !self.open => {
                "to the outside, drawn on a wall that runs through"
            }
            Leads::Outside if self.is_door() => "to the outside",
            Leads::Outside if self.width() < DOOR[0] => "too narrow for a door: shut",
            Leads::Outside => "too wide for a door: shut",
            Leads::Inside => "between rooms: open",
            Leads::Elsewhere => "to a room that is left out: shut",
        };
        format!("{} m wide at {}, from {a} to {b}; {what}{leaves}", number(self.width()), place(self.at()))
    }
}

/// A number of at most three digits after the point.
pub(super) fn number(value: f64) -> String {
    let value = (1e3 * value).round() / 1e3;
    format!("{}", if value == 0.0 { 0.0 } else { value })
}

/// A place, as options have it.
pub(super) fn place(at: Vec2) -> String {
    format!("{},{}", number(at.x), number(at.y))
}
