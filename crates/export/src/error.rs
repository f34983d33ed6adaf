//! Why a run cannot be read or written.

use crowd_mechanics::files::WriteError;
use crowd_mechanics::trial::Problems;
use std::io;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Why a run cannot be read or written.
#[derive(Debug, Error)]
#[allow(missing_docs)] // the messages say it
pub enum ExportError {
    #[error("{}: cannot be read: {error}", path.display())]
    Read { path: PathBuf, error: io::Error },
    #[error("{}: {message}", path.display())]
    Wrong { path: PathBuf, message: String },
    #[error("{0}")]
    Xml(#[from] Problems),
    #[error("{0}")]
    Write(#[from] WriteError),
    #[error("{}: cannot be written: {error}", path.display())]
    Database { path: PathBuf, error: rusqlite::Error },
}

impl ExportError {
    pub(crate) fn wrong(path: &Path, message: impl Into<String>) -> ExportError {
        ExportError::Wrong { path: path.to_owned(), message: message.into() }
    }
}
