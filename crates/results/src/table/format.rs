//! Formats of tables, and what a table holds.

use crate::cell::Cell;
use crate::columns::Column;
use std::io;
use std::path::Path;

/// Format of a table.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TableFormat {
    /// Text with a header. Numbers are written so that they read back to the same doubles.
    Csv,
    /// Compressed columns; units, variables and descriptions are in the metadata. Needs the feature
    /// `parquet`.
    Parquet,
}

impl TableFormat {
    /// All formats.
    pub const ALL: [TableFormat; 2] = [TableFormat::Csv, TableFormat::Parquet];

    /// The format that the extension of a file means; capitals do not matter.
    pub fn of(path: &Path) -> Option<TableFormat> {
        let end = path.extension()?;
        TableFormat::ALL.into_iter().find(|format| end.eq_ignore_ascii_case(format.extension()))
    }

    /// Extension of its files, without a dot.
    pub const fn extension(self) -> &'static str {
        match self {
            TableFormat::Csv => "csv",
            TableFormat::Parquet => "parquet",
        }
    }
}

/// Content of a table besides its rows.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TableContent {
    /// The first one is the time ([`Column::time`]).
    pub columns: Vec<Column>,
    /// Keys and values about the whole table. Parquet has them in its metadata, CSV has no place for
    /// them.
    pub about: Vec<(&'static str, String)>,
}

/// A format that a table is written in.
pub(super) trait Rows<W>: Send {
    /// Writes the cells of a row.
    fn row(&mut self, cells: &mut dyn Iterator<Item = Cell<'_>>) -> io::Result<()>;
    /// Completes the table and returns its file.
    fn finish(self: Box<Self>) -> io::Result<W>;
}
