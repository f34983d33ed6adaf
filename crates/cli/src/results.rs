//! The tables of a run: where they go, how that is said.

use crate::files;
use anyhow::Result;
use clap::ValueEnum;
use lemons_core::files::{Staged, WriteError};
use lemons_results::RecordError;
pub use lemons_results::columns::Column;
pub use lemons_results::{Cell, CellType, Content, Format, FrameWriter, TableWriter};
use std::path::{Path, PathBuf};

/// `--format`
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum FormatName {
    /// Text: SI units, numbers that read back to the same doubles
    Csv,
    /// Columns, compressed: some times smaller; units in the file's metadata
    Parquet,
}

impl From<FormatName> for Format {
    fn from(name: FormatName) -> Format {
        match name {
            FormatName::Csv => Format::Csv,
            FormatName::Parquet => Format::Parquet,
        }
    }
}

/// Where a table goes.
#[derive(Clone)]
pub struct Place {
    pub path: PathBuf,
    pub format: Format,
}

/// Begins a table, which appears under its name only when it is complete. That of a run which goes on replaces none:
/// it may be that of the run before.
pub fn begin(place: &Place, content: &Content, goes_on: bool) -> Result<TableWriter<Staged>> {
    let Place { path, format } = place;
    let file = if goes_on { files::stage_new(path) } else { files::stage(path) };
    TableWriter::create(file?, path, *format, content).map_err(with_path)
}

/// Puts a complete table in its place.
pub fn place(complete: Result<Staged, RecordError>, path: &Path) -> Result<()> {
    let placed = complete.and_then(|file| Ok(file.persist().map_err(WriteError::at(path))?));
    placed.map_err(with_path)
}

/// An error of a table, as this command says it.
pub fn with_path(error: RecordError) -> anyhow::Error {
    match error {
        RecordError::Write(WriteError { path, error }) => {
            anyhow::Error::new(error).context(format!("cannot write {}", path.display()))
        }
        error => error.into(),
    }
}
