//! Errors of scenarios.

use lemons_core::message::Message;
pub(crate) use lemons_core::require;
use lemons_people::PeopleError;
use std::fmt::Display;

/// An error. In its text, keys of the scenario are between backticks: see [`with_names`].
#[derive(Debug, thiserror::Error)]
pub enum ScenarioError {
    /// Keys that do not fit together, or one that is missing.
    #[error("{0}")]
    Misused(String),
    /// A value that is not possible: what, and why.
    #[error("{0}")]
    Impossible(Message),
    /// A file that cannot be read, is no TOML, or has unknown keys or values of another type.
    #[error("{0}")]
    Toml(String),
    /// More people than fit.
    #[error("{place}: {what}{hint}")]
    NoRoom {
        /// Ground and packing.
        place: String,
        /// How many are wanted, and how many fit.
        what: Message,
        /// Advice.
        hint: String,
    },
    /// The placing was stopped.
    #[error("the placing was stopped")]
    Stopped,
    /// A file of a Trial has errors.
    #[error("{0}")]
    Files(lemons_core::trial::Problems),
    /// An error of people, rooms or drawings, and of what.
    #[error("{of}: {error}")]
    People {
        /// Of what.
        of: String,
        /// Why.
        error: PeopleError,
    },
}

/// A result of this crate.
pub type Result<T, E = ScenarioError> = std::result::Result<T, E>;

/// Returns a text with another name of each key between backticks that has one.
pub fn with_names(text: &str, name: impl Fn(&str) -> Option<String>) -> String {
    text.split('`').fold(text.to_owned(), |text, key| match name(key) {
        Some(name) => text.replace(&format!("`{key}`"), &name),
        None => text,
    })
}

/// Makes an error of a message.
pub(crate) fn impossible(message: impl ToString) -> ScenarioError {
    message.to_string().into()
}

impl From<Message> for ScenarioError {
    fn from(message: Message) -> ScenarioError {
        ScenarioError::Impossible(message)
    }
}

impl From<String> for ScenarioError {
    fn from(message: String) -> ScenarioError {
        ScenarioError::Impossible(message.into())
    }
}

lemons_core::sentences! {
    NO_ROOM "people.no-room" "{count} people do not fit on {area:.2} m² without overlap; about {about} of them do, {clear:.1} per m²";
    NUMBER "people.number" "{all} people: the number must be 1 to {most}";
    ROUND "people.round" "round bodies are of adults with nothing: take no mix of kinds and no bicycles, or no round bodies";
    OUTSIDE "people.outside" "`regions`: more than half of one lies outside the room";
    NOBODY_PUSHED "push.nobody" "push {push}: nobody stands in its circle";
}

/// Checks that keys fit together.
pub(crate) fn fits(holds: bool, message: impl FnOnce() -> String) -> Result<()> {
    if holds { Ok(()) } else { Err(ScenarioError::Misused(message())) }
}

/// Checks that a number is in its range.
pub(crate) fn within(what: impl Display, value: f64, [low, high]: [f64; 2]) -> Result<()> {
    Ok(require((low..=high).contains(&value), || format!("{what} = {value}: must be from {low} to {high}"))?)
}

/// Says what an error is of.
pub(crate) trait Of<T> {
    /// The text of `of` comes before the error's own.
    fn of(self, of: impl Display) -> Result<T>;
}

impl<T> Of<T> for Result<T, PeopleError> {
    fn of(self, of: impl Display) -> Result<T> {
        self.map_err(|error| ScenarioError::People { of: of.to_string(), error })
    }
}

impl From<PeopleError> for ScenarioError {
    fn from(error: PeopleError) -> ScenarioError {
        error.told().into()
    }
}
