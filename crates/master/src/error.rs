//! What can go wrong with FMUs, SSPs and runs.

use crate::calls::Answer;
use crate::file_type::Unexpected;
use crowd_mechanics::pack::PackError;
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
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// Why an FMU or an SSP cannot be used, or a run cannot be made.
///
/// A text does not contain that of its [`source()`](StdError::source): all of them together, with `: ` between them, are
/// the whole message.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// Where it happened: a file, an entry of an archive, a component.
    #[error("{place}")]
    In {
        /// As the user knows it.
        place: String,
        /// What happened there.
        source: Box<Error>,
    },
    /// Anything that no caller treats in a way of its own: the text says which value of what is wrong.
    #[error("{what}")]
    Failed {
        /// What is wrong, or what was tried.
        what: String,
        /// Why, if somebody else says it.
        source: Option<Cause>,
    },
    /// An XML file is broken, or something in it is not served; its text says where.
    #[error(transparent)]
    Xml(Box<Problem>),
    /// A file cannot be read.
    #[error(transparent)]
    Read(#[from] io::Error),
    /// A path leads to something else than what is wanted.
    #[error(transparent)]
    Unexpected(#[from] Unexpected),
    /// An archive is damaged.
    #[error(transparent)]
    Zip(#[from] ZipError),
    /// An SSP, where an FMU is wanted.
    #[error("this is an SSP archive")]
    IsSsp,
    /// A shared library that was built with this program is not there.
    #[error("{name} is not beside this program ({})", beside.display())]
    NoLibrary {
        /// Its file name.
        name: String,
        /// Where it was looked for.
        beside: PathBuf,
        /// FMI's name of its platform.
        platform: String,
    },
    /// FMI has no name for the platform of this program.
    #[error("FMI has no name for this platform")]
    NoPlatform,
    /// A Trial has errors.
    #[error("the Trial {} has errors:\n{problems}", path.display())]
    Broken {
        /// As it was given.
        path: PathBuf,
        /// All of them, and warnings; files have the names that the user knows.
        problems: Problems,
    },
    /// A Trial cannot be packed.
    #[error(transparent)]
    Pack(#[from] PackError),
    /// The FMU refuses a call, or it fails.
    #[error("{}", if said.is_empty() { format!("{} returned {answer}", answer.call()) } else { said.join("\n") })]
    Refused {
        /// What the C function returned.
        answer: Answer,
        /// What the FMU has logged about it.
        said: Vec<String>,
    },
    /// The FMU has no variable of this name.
    #[error("the FMU has no variable {0:?}")]
    NoVariable(String),
    /// The communication points of a run are impossible.
    #[error(transparent)]
    Clock(#[from] ClockError),
    /// What people want (`decision.toml`) is wrong.
    #[error(transparent)]
    Plan(#[from] lemons_decision::PlanError),
    /// A drive file is wrong.
    #[error(transparent)]
    Drive(#[from] Problems),
    /// The components of a saved run were coupled by another algorithm.
    #[error("the saved run has {there}, not {here}")]
    Algorithm {
        /// That of the saved run.
        there: String,
        /// The one that is wanted.
        here: String,
    },
}

impl Error {
    /// An error with a text of its own.
    pub(crate) fn new(what: impl Into<String>) -> Error {
        Error::Failed { what: what.into(), source: None }
    }

    /// Makes an error of what was tried and why it failed; to be passed to [`Result::map_err`].
    pub(crate) fn of<E: Into<Cause>>(what: impl Into<String>) -> impl FnOnce(E) -> Error {
        move |source| Error::Failed { what: what.into(), source: Some(source.into()) }
    }

    /// The whole message: see [`whole`].
    pub fn whole(&self) -> String {
        whole(self)
    }
}

impl From<Problem> for Error {
    fn from(problem: Problem) -> Error {
        Error::Xml(problem.into())
    }
}

impl From<Box<Problem>> for Error {
    fn from(problem: Box<Problem>) -> Error {
        Error::Xml(problem)
    }
}

/// The whole message of an error whose text does not contain that of its cause: its text and those of its causes, with
/// `: ` between them.
pub fn whole(error: &dyn StdError) -> String {
    let mut text = error.to_string();
    let mut cause = error.source();
    while let Some(error) = cause {
        text += &format!(": {error}");
        cause = error.source();
    }
    text
}

/// Says where an error happened.
pub(crate) trait Place<T> {
    /// The place comes before the error's own text.
    fn place(self, place: impl FnOnce() -> String) -> Result<T>;
}

impl<T, E: Into<Error>> Place<T> for Result<T, E> {
    fn place(self, place: impl FnOnce() -> String) -> Result<T> {
        self.map_err(|error| Error::In { place: place(), source: Box::new(error.into()) })
    }
}
