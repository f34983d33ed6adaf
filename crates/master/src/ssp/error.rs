//! Why an archive, a structure or an interface is not read, connected or written.

use lemons_core::xml::Problem;
use std::io;
use std::path::PathBuf;
use thiserror::Error;
use zip::result::ZipError;

/// What is wrong, for those who read, connect or write.
#[derive(Debug, Error)]
pub enum Error {
    /// An XML file is broken, or something in it is not served; its text says where.
    #[error(transparent)]
    Xml(Box<Problem>),
    /// The archive's file cannot be opened.
    #[error(transparent)]
    Open(#[from] io::Error),
    /// The file is not a zip archive, or it is broken.
    #[error(transparent)]
    Zip(#[from] ZipError),
    /// The list of an archive's entries cannot be read.
    #[error("the list of its entries cannot be read")]
    Entries(#[source] io::Error),
    /// An entry leads outside of the archive.
    #[error("the entry {0:?} leads outside of the archive")]
    EntryOutside(String),
    /// Two entries have names that are one name on some system.
    #[error("the entries {0:?} and {1:?} have one name")]
    OneName(String, String),
    /// Two entries have the same name.
    #[error("two entries have the name {0:?}")]
    NameTwice(String),
    /// What a structure names leads outside of the archive.
    #[error("leads outside of the archive")]
    SourceOutside,
    /// What a structure names is missing.
    #[error("there is no {0} in the archive")]
    Missing(String),
    /// What a structure names is not a file.
    #[error("{0} is not a file")]
    NotAFile(String),
    /// An entry is broken, or its copy cannot be written.
    #[error("{name}: {error}")]
    Copy {
        /// The entry's.
        name: String,
        /// What failed.
        error: io::Error,
    },
    /// The entries of archives exceed the [allowance](crate::ssp::Allowance) of so many.
    #[error("it has too many entries: at most {0} are unpacked in all")]
    TooManyEntries(usize),
    /// An entry would exceed the [allowance](crate::ssp::Allowance).
    #[error("{name}: is refused: more than {} MB to unpack in all", *limit as f64 / 1e6)]
    TooLarge {
        /// The entry's.
        name: String,
        /// \[byte\] Of the allowance.
        limit: u64,
    },
    /// FMUs do not fit together: one line for each reason.
    #[error("{0}")]
    DoNotFit(String),
    /// No output has the name of an input; what each FMU has.
    #[error("no output has the name of an input of another FMU: nothing to connect\n{0}")]
    NothingToConnect(String),
    /// Two FMUs give a unit two meanings.
    #[error("{variable}: {participant} means another unit by {unit:?} than another FMU")]
    UnitDiffers {
        /// The variable whose unit it is.
        variable: String,
        /// The FMU that has it.
        participant: String,
        /// The unit's name.
        unit: String,
    },
    /// A file that becomes an entry cannot be read.
    #[error("cannot read {}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// An archive cannot be written.
    #[error("cannot write {}", path.display())]
    Write {
        /// The archive.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
}

/// Of this crate's functions.
pub type Result<T> = std::result::Result<T, Error>;

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
