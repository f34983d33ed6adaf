//! Errors of this crate.

use lemons_core::files::WriteError;
pub(crate) use lemons_core::require;
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
    Impossible(String),
}

/// A result of this crate.
pub(crate) type Result<T, E = PeopleError> = std::result::Result<T, E>;

impl PeopleError {
    /// Makes an error of a message.
    pub(crate) fn new(message: impl Into<String>) -> PeopleError {
        PeopleError::Impossible(message.into())
    }

    /// Puts before the message what it is about.
    pub(crate) fn of(self, what: impl Display) -> PeopleError {
        PeopleError::Impossible(format!("{what}: {self}"))
    }
}

impl From<String> for PeopleError {
    fn from(message: String) -> PeopleError {
        PeopleError::Impossible(message)
    }
}
