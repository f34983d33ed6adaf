//! Errors of a sweep.

use std::io;

/// The result of what this crate does.
pub type Result<T, E = SweepError> = std::result::Result<T, E>;

/// Why a sweep cannot be read, run or kept.
///
/// A text does not contain that of its [`source()`](std::error::Error::source): all of them together, with `: ` between them, are
/// the whole message.
#[derive(Debug, thiserror::Error)]
pub enum SweepError {
    /// Where it happened: a file, or a key of `sweep.toml`.
    #[error("{place}")]
    In {
        /// As the user knows it.
        place: String,
        /// The error there.
        source: Box<SweepError>,
    },
    /// `sweep.toml` is not TOML, or a key is unknown, missing or of another type.
    #[error(transparent)]
    Toml(#[from] toml::de::Error),
    /// `sweep.toml` or its table of points says something impossible: key, value and why.
    #[error("{0}")]
    Spec(String),
    /// A crowd is impossible.
    #[error(transparent)]
    Scenario(#[from] lemons_scenario::ScenarioError),
    /// A file cannot be read or written.
    #[error(transparent)]
    Io(#[from] io::Error),
    /// A table in CSV cannot be read or written.
    #[error(transparent)]
    Csv(#[from] csv::Error),
    /// The identity of a sweep cannot be written as JSON.
    #[error(transparent)]
    Json(#[from] serde_json::Error),
    /// A Trial, its drive or its `decision.toml` cannot be used.
    #[error(transparent)]
    Master(#[from] lemons_master::MasterError),
    /// A point cannot be simulated.
    #[error(transparent)]
    Simulation(#[from] lemons_sim::SimError),
    /// A file is not the table of this sweep, is damaged, or another process writes it.
    #[error("{0}")]
    Table(String),
    /// A fault in this program.
    #[error("a worker thread panicked")]
    Worker,
}

impl From<String> for SweepError {
    fn from(what: String) -> SweepError {
        SweepError::Spec(what)
    }
}

impl From<&str> for SweepError {
    fn from(what: &str) -> SweepError {
        SweepError::Spec(what.to_owned())
    }
}

impl SweepError {
    /// The whole message: see [`lemons_master::whole`].
    pub fn whole(&self) -> String {
        lemons_master::whole(self)
    }
}

/// Says where an error happened.
pub(crate) trait ErrorPlace<T> {
    /// The place comes before the error's own text.
    fn place(self, place: impl FnOnce() -> String) -> Result<T>;
}

impl<T, E: Into<SweepError>> ErrorPlace<T> for Result<T, E> {
    fn place(self, place: impl FnOnce() -> String) -> Result<T> {
        self.map_err(|error| SweepError::In { place: place(), source: Box::new(error.into()) })
    }
}
