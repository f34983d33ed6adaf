//! Errors of this crate.

use lemons_core::files::WriteError;
use lemons_core::message::{Message, message};
pub(crate) use lemons_core::require;
use lemons_core::rule::parts::OF;
use std::fmt::Display;
use thiserror::Error;

/// An error of people, shapes, regions, crowds or their files. Only those that callers can do something about have a
/// kind of their own.
#[derive(Debug, Error)]
pub enum PeopleError {
    /// A wall of a Trial that does not end at its first corner.
    #[error(
        "wall {id} is not closed: its first corner is {first:?}, its last corner {last:?} (repeat the first one at the end)"
    )]
    OpenWall {
        /// Id of the wall.
        id: String,
        /// \[m\] first corner.
        first: (f64, f64),
        /// \[m\] last corner.
        last: (f64, f64),
    },
    /// A drawing that does not say how long its unit is.
    #[error("the drawing does not say how long its unit is")]
    NoUnit {
        /// Width and height in its units, if something is in it.
        size: Option<[f64; 2]>,
        /// Whether a unit is any length, as in SVG.
        scale: bool,
    },
    /// A file that cannot be written.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// Anything else: what is wrong, with its name and value.
    #[error("{0}")]
    Impossible(Message),
}

/// A result of this crate.
pub(crate) type Result<T, E = PeopleError> = std::result::Result<T, E>;

impl PeopleError {
    /// Makes an error of a message.
    pub(crate) fn new(message: impl Into<Message>) -> PeopleError {
        PeopleError::Impossible(message.into())
    }

    /// Puts before the message what it is about.
    pub(crate) fn of(self, what: impl Display) -> PeopleError {
        PeopleError::Impossible(message!(OF, of = what.to_string(), finding = self.told()))
    }

    /// Returns its text as a message.
    pub fn told(&self) -> Message {
        if let PeopleError::Impossible(message) = self { message.clone() } else { self.to_string().into() }
    }
}

impl From<Message> for PeopleError {
    fn from(message: Message) -> PeopleError {
        PeopleError::Impossible(message)
    }
}

impl From<String> for PeopleError {
    fn from(message: String) -> PeopleError {
        PeopleError::new(message)
    }
}

lemons_core::sentences! {
    COVER_MORE "shapes.cover" "{shapes} shapes cover {covered:.3} m², but the region has {room:.3} m²: it cannot hold them without overlap";
    FEW_PLACES "shapes.grid" "the grid of {along:.3} m × {across:.3} m has {places} places in the region; {shapes} shapes are given";
    NO_WALLS "region.no-walls" "no walls: nothing bounds the region";
    SMALL_AREA "region.area" "{name}: its area is {area} m²; at least {least} m² is needed";
    NO_SHARES "mix.shares" "the shares must sum up to more than 0";
    NONE_CLOSED "drawing.open" "no wall is closed, so nothing is inside";
    BY_SWING "drawing.swing" "wall {wall} is closed by the swing of a door only, {width} m wide at {at}: its arc and leaf are taken as a wall";
    BAND "drawing.band" "the outline, wall {outline}, is a band of {width:.0} cm: walls are probably drawn as two lines";
    TWO_LINES "drawing.two-lines" "wall {wall} lies {width:.0} cm inside the outline, wall {outline}: walls are probably drawn as two lines";
    LITTLE_AROUND "drawing.little" "the outline, wall {outline}, lies around {own:.1} m², all walls together around {all:.1} m²: probably a gap in the walls around the room is open";
    ON_NOTES "drawing.notes" "the outline, wall {outline}, is on layer {layer:?}, which has a frame or notes by its name: --walls takes other layers, or this one";
    IS_FRAME "drawing.frame" "is the rectangle of {width} m x {height} m a frame of the sheet, or a fence? No other wall meets it, and the walls of a room stand in it: --walls without its layer leaves it out";
    GAP "gap.at" "{width} m wide at {at}, from {from} to {to}; {what}{leaves}";
    GAP_CROSSED "gap.crossed" "lines run across it: shut";
    GAP_THROUGH "gap.through" "to the outside, drawn on a wall that runs through";
    GAP_OUT "gap.out" "to the outside";
    GAP_NARROW "gap.narrow" "too narrow for a door: shut";
    GAP_WIDE "gap.wide" "too wide for a door: shut";
    GAP_INSIDE "gap.inside" "between rooms: open";
    GAP_ELSEWHERE "gap.elsewhere" "to a room that is left out: shut";
    LEAF "gap.leaf" ", 1 leaf";
    LEAVES "gap.leaves" ", {count} leaves";
}
