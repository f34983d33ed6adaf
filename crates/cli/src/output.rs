//! A file that a command makes.

use crate::files;
use anyhow::{Context, Result};
use lemons_core::files::Staged;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

/// A file that appears under its name only when it is complete; it is opened before any long work, so that a place
/// that cannot be written is found at once.
pub struct Output {
    path: PathBuf,
    file: BufWriter<Staged>,
}

impl Output {
    pub fn open(path: &Path) -> Result<Output> {
        let file = files::stage(path)?;
        Ok(Output { path: path.to_owned(), file: BufWriter::new(file) })
    }

    /// Opens a file in a place that was claimed before.
    pub fn claimed(path: &Path) -> Result<Output> {
        Ok(Output { path: path.to_owned(), file: BufWriter::new(files::open(path)?) })
    }

    /// Returns where it will appear.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Returns what is to be written to; [`Output::persist`] writes what is left in it.
    pub fn writer(&mut self) -> &mut BufWriter<Staged> {
        &mut self.file
    }

    /// Writes the content; the file does not appear yet.
    pub fn fill(&mut self, write: impl FnOnce(&mut BufWriter<Staged>) -> std::io::Result<()>) -> Result<()> {
        let filled = write(&mut self.file).and_then(|()| self.file.flush());
        filled.with_context(|| format!("cannot write {}", self.path.display()))
    }

    pub fn persist(self) -> Result<()> {
        let cannot = || format!("cannot write {}", self.path.display());
        let file = self.file.into_inner().map_err(|error| error.into_error()).with_context(cannot)?;
        file.persist().with_context(cannot)
    }
}
