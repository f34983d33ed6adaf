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
    #[error(transparent)]
    Xml(#[from] Problems),
    #[error(transparent)]
    Write(#[from] WriteError),
}

impl ExportError {
    pub(crate) fn wrong(path: &Path, message: impl Into<String>) -> ExportError {
        ExportError::Wrong { path: path.to_owned(), message: message.into() }
    }
}
