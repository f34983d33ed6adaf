//! What can go wrong with FMUs, SSPs and runs.

use crate::calls::{Answer, CallError};
use crate::kind::Unexpected;
use crowd_mechanics::pack::PackError;
use lemons_core::trial::DriveError;
use lemons_core::trial::Problems;
use lemons_decision::WISHES_FILE;
use lemons_sim::ClockError;
use std::collections::TryReserveError;
use std::error::Error as StdError;
use std::io;
use std::path::PathBuf;
use zip::result::ZipError;

/// An error of any kind, as it is passed on.
pub(crate) type Cause = Box<dyn StdError + Send + Sync>;

/// The result of what this crate does.
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// Why an FMU cannot be used, or a run cannot be made.
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
    /// The operating system refused something.
    #[error("{what}")]
    Io {
        /// What was tried.
        what: &'static str,
        /// Why not.
        source: io::Error,
    },
    /// A file cannot be read.
    #[error(transparent)]
    Read(#[from] io::Error),
    /// A path leads to something else than what is wanted.
    #[error(transparent)]
    Unexpected(#[from] Unexpected),
    /// A model description or an SSP is wrong.
    #[error(transparent)]
    Ssp(#[from] crate::ssp::Error),
    /// An archive is damaged.
    #[error(transparent)]
    Zip(#[from] ZipError),
    /// An SSP, where an FMU is wanted.
    #[error("this is an SSP archive")]
    IsSsp,
    /// An FMU, an SSP or the zip of a Trial cannot be used: the text says which value of what is wrong.
    #[error("{0}")]
    Unusable(String),
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
    /// No Trial is packed in an FMU.
    #[error("holds no Trial: it is not an FMU of a crowd")]
    NoTrial,
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
    /// The library cannot be loaded, or the FMU refuses to be instantiated.
    #[error("{}", if said.is_empty() { format!("cannot instantiate the FMU: {why}") } else { said.join("\n") })]
    Instantiate {
        /// Why, as seen from outside.
        why: String,
        /// What the FMU has logged about it.
        said: Vec<String>,
    },
    /// The FMU refuses a call, or it fails.
    #[error("{}", if said.is_empty() { format!("{} returned {answer}", answer.call()) } else { said.join("\n") })]
    Refused {
        /// What the C function returned.
        answer: Answer,
        /// What the FMU has logged about it.
        said: Vec<String>,
    },
    /// A C function cannot be called.
    #[error(transparent)]
    Call(#[from] CallError),
    /// The FMU has no variable of this name.
    #[error("the FMU has no variable {0:?}")]
    NoVariable(String),
    /// The FMU has no value at an address.
    #[error("the FMU has no variable with the value reference {0}, or not so many values in it")]
    NoReference(u32),
    /// A plan is given with an FMU.
    #[error("a file like {WISHES_FILE} is for a Trial, and not for an FMU")]
    PlanOfFmu,
    /// A text is not a value of a variable's type.
    #[error("{name}={text}: {why}")]
    Value {
        /// Of the variable.
        name: String,
        /// The text.
        text: String,
        /// What is wrong with it.
        why: &'static str,
        /// What the number's reader says.
        source: Option<Cause>,
    },
    /// There is no memory for a state.
    #[error("a state of {size} bytes")]
    Memory {
        /// \[byte\]
        size: usize,
        /// Why not.
        source: TryReserveError,
    },
    /// The communication points of a run are impossible.
    #[error(transparent)]
    Clock(#[from] ClockError),
    /// What people want (`decision.toml`) is wrong.
    #[error(transparent)]
    Plan(#[from] lemons_decision::PlanError),
    /// A drive file is wrong.
    #[error(transparent)]
    Drive(#[from] DriveError),
    /// A saved run is damaged, or it is another one's.
    #[error(transparent)]
    Saved(#[from] SavedError),
}

impl Error {
    /// An error of an SSP.
    pub(crate) fn ssp(error: impl Into<crate::ssp::Error>) -> Error {
        Error::Ssp(error.into())
    }

    /// To be passed to [`Result::map_err`]: what was tried.
    pub(crate) fn io(what: &'static str) -> impl FnOnce(io::Error) -> Error {
        move |source| Error::Io { what, source }
    }

    /// The whole message: see [`whole`].
    pub fn whole(&self) -> String {
        whole(self)
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

/// Why a run cannot be saved, or cannot go on from a saved one.
#[derive(Debug, thiserror::Error)]
pub enum SavedError {
    /// No archive.
    #[error("is none")]
    NoArchive(#[source] zip::result::ZipError),
    /// It contains no `run.toml`.
    #[error("it contains no {0}, so it is not a saved run")]
    NoRun(&'static str),
    /// The archive is damaged.
    #[error(transparent)]
    Zip(#[from] zip::result::ZipError),
    /// Two entries of the archive have one name, or it unpacks to too much.
    #[error(transparent)]
    Archive(#[from] crate::ssp::Error),
    /// `run.toml` cannot be written.
    #[error(transparent)]
    Toml(#[from] toml::ser::Error),
    /// What it contains is wrong, or it is of other components: the text says what and where.
    #[error("{0}")]
    Content(String),
    /// It cannot be read or written.
    #[error(transparent)]
    Io(#[from] io::Error),
    /// Its components were coupled by another algorithm.
    #[error("the saved run has {there}, not {here}")]
    Algorithm {
        /// That of the saved run.
        there: String,
        /// The one that is wanted.
        here: String,
    },
}
