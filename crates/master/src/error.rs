//! Why an FMU or an SSP cannot be used, or a run cannot be made.

use crowd_mechanics::pack::PackError;
use lemons_core::files::Scratch;
pub use lemons_core::require;
use lemons_core::trial::Problems;
use lemons_core::xml::Problem;
use lemons_sim::ClockError;
use std::error::Error as StdError;
use std::io;
use std::path::PathBuf;
use zip::result::ZipError;

/// An error of any kind, as it is passed on.
pub(crate) type Cause = Box<dyn StdError + Send + Sync>;

/// The result of what this crate does.
pub type Result<T, E = MasterError> = std::result::Result<T, E>;

/// Why an FMU or an SSP cannot be used, or a run cannot be made. Texts say which value of what is wrong, with the option of
/// `lemons` that means it.
///
/// A text does not contain that of its [`source()`](StdError::source): all of them together, with `: ` between them, are
/// the whole message.
#[derive(Debug, thiserror::Error)]
pub enum MasterError {
    /// Text of what is wrong, where, or what was tried; and why, if somebody else says it.
    #[error("{what}")]
    Failed {
        /// The text.
        what: String,
        /// The reason.
        source: Option<Cause>,
    },
    /// Settings that make no sense together.
    #[error("{0}")]
    Misused(String),
    /// A Trial has errors.
    #[error("the Trial {} has errors:\n{problems}", path.display())]
    Broken {
        /// As it was given.
        path: PathBuf,
        /// All of them, and warnings; files have the names that the user knows.
        problems: Problems,
    },
    /// An XML file is broken, or something in it is not served; its text says where.
    #[error(transparent)]
    Xml(#[from] Box<Problem>),
    /// A file cannot be read.
    #[error(transparent)]
    Read(#[from] io::Error),
    /// An archive is damaged.
    #[error(transparent)]
    Zip(#[from] ZipError),
    /// A Trial cannot be packed.
    #[error(transparent)]
    Pack(#[from] PackError),
    /// The communication points of a run are impossible.
    #[error(transparent)]
    Clock(#[from] ClockError),
    /// A `decision.toml` is wrong.
    #[error(transparent)]
    Plan(#[from] lemons_decision::PlanError),
    /// A drive file is wrong.
    #[error(transparent)]
    Drive(#[from] Problems),
}

impl MasterError {
    /// Makes an error with a text of its own.
    pub(crate) fn new(what: impl Into<String>) -> MasterError {
        MasterError::Failed { what: what.into(), source: None }
    }

    /// Returns the whole message: see [`whole`].
    pub fn whole(&self) -> String {
        whole(self)
    }
}

impl From<String> for MasterError {
    fn from(what: String) -> MasterError {
        MasterError::new(what)
    }
}

impl From<&str> for MasterError {
    fn from(what: &str) -> MasterError {
        MasterError::new(what)
    }
}

impl From<Problem> for MasterError {
    fn from(problem: Problem) -> MasterError {
        MasterError::Xml(problem.into())
    }
}

/// Returns the whole message of an error whose text does not contain that of its cause: its text and those of its causes,
/// with `: ` between them.
pub fn whole(error: &dyn StdError) -> String {
    let mut text = error.to_string();
    let mut cause = error.source();
    while let Some(error) = cause {
        text += &format!(": {error}");
        cause = error.source();
    }
    text
}

/// Makes a temporary directory.
pub(crate) fn scratch() -> Result<Scratch> {
    Scratch::new().place(|| "cannot make a temporary directory".to_owned())
}

/// Says where an error happened, or what was tried.
pub(crate) trait ErrorPlace<T> {
    /// The place comes before the error's own text.
    fn place(self, place: impl FnOnce() -> String) -> Result<T>;
}

impl<T, E: Into<Cause>> ErrorPlace<T> for Result<T, E> {
    fn place(self, place: impl FnOnce() -> String) -> Result<T> {
        self.map_err(|error| MasterError::Failed { what: place(), source: Some(error.into()) })
    }
}
