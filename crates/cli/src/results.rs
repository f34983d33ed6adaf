//! The tables of a run: where they go, how that is said.

use crate::files;
use anyhow::{Result, anyhow};
use clap::ValueEnum;
use lemons_files::{Staged, WriteError};
pub use lemons_master::Extent;
use lemons_record::RecordError;
pub use lemons_record::columns::Column;
pub use lemons_record::{Cell, Content, Format, FrameWriter, Kind, TableWriter};
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

/// Whether the rows of a run before are in a table.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Started {
    /// There was none.
    Anew,
    Continued,
    /// They are elsewhere.
    Later,
}

impl Started {
    /// The file of the table, for a summary.
    pub fn said(self, path: &Path) -> String {
        let path = path.display();
        match self {
            Started::Anew => path.to_string(),
            Started::Continued => format!("{path}   (continued)"),
            Started::Later => format!("{path}   (what came after the saved run)"),
        }
    }
}

/// Begins a table, which appears under its name only when it is complete. If a run before has written some rows of it,
/// and they are there, they are kept.
pub fn begin(
    place: &Place,
    content: &Content,
    before: Option<Extent>,
) -> Result<(TableWriter<Staged>, Started)> {
    let Place { path, format } = place;
    let there = path.is_file() && !files::is_standard_output(path);
    let started = match before {
        None => Started::Anew,
        Some(before) if before.rows > 0 && there => Started::Continued,
        Some(_) => Started::Later,
    };
    let made = match before.filter(|_| started == Started::Continued) {
        Some(Extent { rows, last, digest }) => {
            let kept = lemons_record::Extent { rows, last, digest };
            TableWriter::resume(files::stage_to_go_on(path)?, path, *format, content, kept)
        }
        None => TableWriter::create(files::stage(path)?, path, *format, content),
    };
    Ok((made.map_err(told)?, started))
}

/// Puts a complete table in its place.
pub fn place(complete: Result<Staged, RecordError>, path: &Path) -> Result<()> {
    let placed = complete.and_then(|file| Ok(file.persist().map_err(WriteError::at(path))?));
    placed.map_err(told)
}

/// An error of a table, as this command says it.
pub fn told(error: RecordError) -> anyhow::Error {
    match error {
        RecordError::Write(WriteError { path, error }) => {
            anyhow::Error::new(error).context(format!("cannot write {}", path.display()))
        }
        RecordError::NotContinued { path, message } => anyhow!(
            "{}: is not what the saved run has written, it cannot go on there: choose another file, which gets what \
             follows only: {message}",
            path.display()
        ),
        error => error.into(),
    }
}
