//! Gaps in walls: how wide they are, where they lead, and what is said of them.

use super::pieces::SNAP;
use crate::Door;
use crate::error::*;
use lemons_core::message::{Message, message};
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
    pub fn described(&self) -> Message {
        let [from, to] = self.ends.map(place);
        let leaves = match self.leaves {
            0 => None,
            1 => Some(message!(LEAF)),
            count => Some(message!(LEAVES, count)),
        };
        let what = match self.leads {
            _ if self.crossed && self.leaves == 0 => message!(GAP_CROSSED),
            Leads::Outside if self.is_door() && !self.open => message!(GAP_THROUGH),
            Leads::Outside if self.is_door() => message!(GAP_OUT),
            Leads::Outside if self.width() < DOOR[0] => message!(GAP_NARROW),
            Leads::Outside => message!(GAP_WIDE),
            Leads::Inside => message!(GAP_INSIDE),
            Leads::Elsewhere => message!(GAP_ELSEWHERE),
        };
        message!(GAP, width = number(self.width()), at = place(self.at()), from, to, what, leaves)
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
