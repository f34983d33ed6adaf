//! The outputs of what is not a crowd: one table, with a column for each output.

use crate::files;
use crate::print::few;
use anyhow::Result;
use lemons_core::files::{Staged, WriteError};
use lemons_results::columns::Column;
use lemons_results::{Cell, CellType, RecordError, TableContent, TableFormat, TableWriter};
use std::path::{Path, PathBuf};

/// Lines that tables have of a run.
pub struct About {
    pub lines: Vec<(&'static str, String)>,
    /// True if a saved run goes on: then no table is replaced, which may be one of the run before.
    pub goes_on: bool,
}

/// Where a table goes.
#[derive(Clone)]
pub struct TableFile {
    pub path: PathBuf,
    pub format: TableFormat,
}

impl TableFile {
    /// Begins a table, which appears under its name only when it is complete. That of a run which goes on replaces
    /// none: it may be that of the run before.
    pub fn begin(&self, content: &TableContent, about: &About) -> Result<TableWriter<Staged>> {
        let file = files::stage_new(&self.path, about.goes_on)?;
        Ok(TableWriter::create(file, &self.path, self.format, content)?)
    }
}

/// Puts a complete table in its place.
pub fn persist(complete: Result<Staged, RecordError>, path: &Path) -> Result<()> {
    Ok(complete?.persist().map_err(WriteError::at(path))?)
}

/// The outputs at a communication point, in the order of their columns: all numbers, and all texts.
pub type OutputValues = (Vec<f64>, Vec<String>);

/// A table with a column for each output.
pub struct OutputTable {
    table: TableWriter<Staged>,
    kinds: Vec<CellType>,
    /// Names of the columns after the time; `None` once a value was seen that is no finite number.
    names: Vec<Option<String>>,
    /// Oddities that were seen then.
    odd: Vec<String>,
}

impl OutputTable {
    /// Begins a table with these columns after the time.
    pub fn create(columns: Vec<Column>, to: &TableFile, about: &About) -> Result<OutputTable> {
        let kinds = columns.iter().map(|column| column.kind).collect();
        let names = columns.iter().map(|column| Some(column.name.clone())).collect();
        let columns = std::iter::once(Column::time()).chain(columns).collect();
        let table = to.begin(&TableContent { columns, about: about.lines.clone() }, about)?;
        Ok(OutputTable { table, kinds, names, odd: Vec::new() })
    }

    /// Writes the row of a time \[s\].
    pub fn row(&mut self, time: f64, (numbers, texts): &OutputValues) -> Result<()> {
        let (mut numbers, mut texts) = (numbers.iter().copied(), texts.iter());
        let mut row = Vec::with_capacity(self.kinds.len());
        for (kind, name) in self.kinds.iter().zip(&mut self.names) {
            let mut number = || numbers.next().unwrap_or(f64::NAN);
            row.push(match kind {
                CellType::Real => Cell::Real(number()),
                CellType::Integer => Cell::Integer(number() as i32),
                CellType::Boolean => Cell::Boolean(number() != 0.0),
                CellType::Text => Cell::Text(texts.next().map_or("", String::as_str)),
            });
            if let Some(Cell::Real(value)) = row.last()
                && !value.is_finite()
                && let Some(name) = name.take()
            {
                self.odd.push(format!("{name} is {value:?} at t = {time:?} s"));
            }
        }
        Ok(self.table.row(time, row)?)
    }

    /// Puts the table in its place; returns the line of the summary.
    pub fn finish(self) -> Result<String> {
        if !self.odd.is_empty() {
            note!("warning: outputs that are no finite numbers: {}", few(&self.odd, 20));
        }
        let (path, columns) = (self.table.path().to_owned(), self.names.len() + 1);
        persist(self.table.finish(), &path)?;
        Ok(format!("outputs            {}   ({columns} columns)", path.display()))
    }
}
