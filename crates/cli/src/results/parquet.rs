//! A table as Parquet, with units, variables and descriptions.

use super::{Cell, Content, Extent, Kind, check_headings, check_kept, with_unit};
use anyhow::{Context, Result, bail};
use crowd_mechanics::files::Staged;
use lemons_columns::{Column, Reader, Writer};
use lemons_files::input;
use std::path::Path;

pub struct Table(Writer<Staged>);

impl Table {
    /// Empty, or with the rows that a run before has written.
    pub fn create(file: Staged, content: &Content, path: &Path, kept: Option<Extent>) -> Result<Table> {
        let columns: Vec<Column> =
            content.columns.iter().enumerate().map(|(k, column)| described(k, column)).collect();
        let mut out = Writer::create(file, &columns, &content.about)?;
        if let Some(kept) = kept {
            copy(path, content, kept, &columns, &mut out)?;
        }
        Ok(Table(out))
    }

    pub fn write<'a>(&mut self, cells: impl Iterator<Item = Cell<'a>>) -> Result<()> {
        Ok(self.0.row(cells)?)
    }

    pub fn finish(self) -> Result<Staged> {
        Ok(self.0.finish()?)
    }
}

/// The k-th column.
fn described(k: usize, column: &super::Column) -> Column {
    let unit = column.unit.clone().map(|unit| ("unit", unit));
    let about = [("variable", column.variable.clone()), ("description", column.description.clone())];
    Column {
        name: column.name.clone(),
        kind: column.kind,
        optional: false,
        // Times do; other numbers hardly.
        repeats: k == 0 || column.kind != Kind::Real,
        about: unit.into_iter().chain(about).collect(),
    }
}

/// The rows of the run before.
fn copy(
    path: &Path,
    content: &Content,
    kept: Extent,
    columns: &[Column],
    to: &mut Writer<Staged>,
) -> Result<()> {
    let reader = Reader::open(input::open(path)?)?;
    let headings = reader.columns().iter().map(|column| with_unit(&column.name, column.about("unit")));
    check_headings(headings, content.columns.iter().map(|column| column.with_unit()))?;
    for (there, here) in reader.columns().iter().zip(columns) {
        if there.kind != Some(here.kind) {
            bail!("column {:?} is of another type", here.name);
        }
    }
    let (mut rows, mut last) = (0, None);
    let all: Vec<usize> = (0..columns.len()).collect();
    for batch in reader.batches(&all) {
        let batch = batch?;
        rows += batch.rows() as u64;
        if rows > kept.rows {
            bail!("it has more than the {} rows that the saved run has written", kept.rows);
        }
        for row in 0..batch.rows() {
            to.row(batch.row(row)).context("the rows of the saved run cannot be copied")?;
        }
        if let Cell::Real(time) = batch.cell(0, batch.rows() - 1) {
            last = Some(time);
        }
    }
    check_kept(kept, rows, last)
}
