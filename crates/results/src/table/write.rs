//! Writes tables row by row.

use super::csv;
use super::format::{Rows, TableContent, TableFormat};
#[cfg(feature = "parquet")]
use super::parquet;
use crate::cell::{Cell, CellType};
use crate::columns::{AgentRow, Groups, RecordedQuantity, row_of};
use crate::error::RecordError;
use crate::run::Frame;
use lemons_core::files::WriteError;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Writes a table with any columns after the time. The table is complete after
/// [`TableWriter::finish`], and of no use after an error. The same rows give the same bytes.
pub struct TableWriter<W> {
    rows: Box<dyn Rows<W>>,
    /// For messages.
    path: PathBuf,
}

impl<W: Write + Send + 'static> TableWriter<W> {
    /// Begins a table in an empty file, which messages call `path`.
    ///
    /// # Errors
    /// Two columns have the same name (Parquet), this build has no Parquet, or the file cannot be
    /// written.
    pub fn create(
        file: W,
        path: &Path,
        format: TableFormat,
        content: &TableContent,
    ) -> Result<Self, RecordError> {
        let made: io::Result<Box<dyn Rows<W>>> = match format {
            TableFormat::Csv => csv::Writer::create(file, &content.columns).map(|rows| Box::new(rows) as _),
            #[cfg(feature = "parquet")]
            TableFormat::Parquet => parquet::Writer::create(file, content).map(|rows| Box::new(rows) as _),
            #[cfg(not(feature = "parquet"))]
            TableFormat::Parquet => Err(io::Error::other(super::NO_PARQUET)),
        };
        let rows = made.map_err(WriteError::at(path))?;
        Ok(TableWriter { rows, path: path.to_owned() })
    }

    /// Writes a row: the time \[s\], and the cells of the other columns.
    ///
    /// # Errors
    /// A cell has not the type of its column or is missing (Parquet), or the file cannot be written.
    pub fn row<'a>(
        &mut self,
        time: f64,
        cells: impl IntoIterator<Item = Cell<'a>>,
    ) -> Result<(), RecordError> {
        self.cells(&mut std::iter::once(Cell::Real(time)).chain(cells))
    }

    fn cells(&mut self, cells: &mut dyn Iterator<Item = Cell<'_>>) -> Result<(), RecordError> {
        Ok(self.rows.row(cells).map_err(|error| WriteError::at(&self.path)(error))?)
    }

    /// Returns what messages call the file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Completes the table and returns its file.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn finish(self) -> Result<W, RecordError> {
        Ok(self.rows.finish().map_err(WriteError::at(&self.path))?)
    }
}

/// Writes the table of a crowd frame by frame: what [`Record::table`](crate::Record::table) reads.
pub struct FrameWriter<W> {
    table: TableWriter<W>,
    ids: Vec<String>,
    cells: RowCells,
}

impl<W: Write + Send + 'static> FrameWriter<W> {
    /// Writes frames of the agents with these Ids into a table whose columns are [`Groups::columns`].
    pub fn new(table: TableWriter<W>, ids: Vec<String>, groups: Groups) -> FrameWriter<W> {
        FrameWriter { table, ids, cells: RowCells::of(groups) }
    }

    /// Writes a row for each agent.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn frame(&mut self, frame: &Frame) -> Result<(), RecordError> {
        for (k, id) in self.ids.iter().enumerate() {
            self.cells.of_agent(frame.time, id, &row_of(frame, k), &mut |cells| self.table.cells(cells))?;
        }
        Ok(())
    }

    /// Completes the table and returns its file.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn finish(self) -> Result<W, RecordError> {
        self.table.finish()
    }
}

/// Cells of an agent's row. It is not generic, so that it is compiled (and optimised) in this crate.
struct RowCells {
    /// Places in a [`AgentRow`], and whether the cell is a real number.
    quantities: Vec<(usize, bool)>,
}

impl RowCells {
    fn of(groups: Groups) -> RowCells {
        let cell = |(place, quantity): (usize, &RecordedQuantity)| (place, quantity.kind() == CellType::Real);
        RowCells { quantities: groups.quantities().map(cell).collect() }
    }

    fn of_agent(
        &self,
        time: f64,
        id: &str,
        row: &AgentRow,
        write: &mut dyn FnMut(&mut dyn Iterator<Item = Cell<'_>>) -> Result<(), RecordError>,
    ) -> Result<(), RecordError> {
        let cell = |&(place, real): &(usize, bool)| {
            if real { Cell::Real(row[place]) } else { Cell::Integer(row[place] as i32) }
        };
        let first = [Cell::Real(time), Cell::Text(id)];
        write(&mut first.into_iter().chain(self.quantities.iter().map(cell)))
    }
}
