//! Why a run cannot be read or written.

use lemons_core::files::WriteError;
use lemons_core::trial::Problems;
use std::io;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Why a run cannot be read or written. The message begins with the path of the file.
#[derive(Debug, Error)]
#[allow(missing_docs)] // the messages say it
pub enum RecordError {
    #[error("{}: cannot be read: {error}", path.display())]
    Read { path: PathBuf, error: io::Error },
    #[error("{}: {message}", path.display())]
    Wrong { path: PathBuf, message: String },
    #[error("{}: reading it was stopped", path.display())]
    Stopped { path: PathBuf },
    #[error(transparent)]
    Xml(#[from] Problems),
    #[error(transparent)]
    Write(#[from] WriteError),
}

impl RecordError {
    pub(crate) fn wrong(path: &Path, message: impl Into<String>) -> RecordError {
        RecordError::Wrong { path: path.to_owned(), message: message.into() }
    }
}
