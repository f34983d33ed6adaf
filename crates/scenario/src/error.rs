//! Errors of scenarios.

use lemons_people::PeopleError;

/// An error. In its text, keys of the scenario are between backticks.
#[derive(Debug, thiserror::Error)]
pub enum ScenarioError {
    /// Keys that do not fit together, or one that is missing.
    #[error("{0}")]
    Misused(String),
    /// A value that is not possible: what, and why.
    #[error("{0}")]
    Impossible(String),
    /// A file that cannot be read, is no TOML, or has unknown keys or values of another type.
    #[error("{0}")]
    Toml(String),
    /// More people than fit.
    #[error(
        "{number} people do not fit on {area:.2} m² without overlap; about {about} of them do, {clear:.1} per m²"
    )]
    NoRoom {
        /// How many.
        number: usize,
        /// Ground and packing.
        place: String,
        /// \[m²\] Area of the ground.
        area: f64,
        /// How many do fit.
        about: usize,
        /// \[1/m²\] Their density.
        clear: f64,
        /// \[m\] Largest overlap of the others, if all were tried.
        overlap: Option<f64>,
        /// Whether `dense` reaches more.
        better: bool,
    },
    /// The placing was stopped.
    #[error("the placing was stopped")]
    Stopped,
    /// A file of a Trial has errors.
    #[error("{0}")]
    Files(lemons_core::trial::Problems),
    /// What people, rooms or drawings say, and of what.
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

/// Keys that stand between backticks in messages.
const KEYS: [&str; 36] = [
    "allow_overlap",
    "balance",
    "box",
    "decision",
    "density",
    "desired_speed",
    "direction",
    "doors",
    "drawing",
    "drawing.close",
    "drawing.deviation",
    "drawing.unit",
    "drawing.widest",
    "exits",
    "friction",
    "geometry",
    "groups",
    "leave",
    "material",
    "men",
    "mix",
    "model",
    "number",
    "packing",
    "pedestrians",
    "people",
    "people.file",
    "push",
    "pushes",
    "regions",
    "room",
    "round",
    "seed",
    "speed",
    "start",
    "time_step",
];

/// Returns a text with other names of the keys that are between backticks in it.
pub fn named(text: &str, name: impl Fn(&str) -> String) -> String {
    KEYS.iter().fold(text.to_owned(), |text, key| match format!("`{key}`") {
        quoted if text.contains(&quoted) => text.replace(&quoted, &name(key)),
        _ => text,
    })
}

/// Makes an error of a message.
pub(crate) fn impossible(message: impl Into<String>) -> ScenarioError {
    ScenarioError::Impossible(message.into())
}

/// Checks a condition; `message` says what is wrong if it does not hold.
pub(crate) fn require(holds: bool, message: impl FnOnce() -> String) -> Result<()> {
    if holds { Ok(()) } else { Err(ScenarioError::Impossible(message())) }
}

/// Says what an error is of.
pub(crate) trait Of<T> {
    /// The text of `of` comes before the error's own.
    fn of(self, of: impl FnOnce() -> String) -> Result<T>;
}

impl<T> Of<T> for Result<T, PeopleError> {
    fn of(self, of: impl FnOnce() -> String) -> Result<T> {
        self.map_err(|error| ScenarioError::People { of: of(), error })
    }
}

impl From<PeopleError> for ScenarioError {
    fn from(error: PeopleError) -> ScenarioError {
        ScenarioError::Impossible(error.to_string())
    }
}
