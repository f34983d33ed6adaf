//! Tables in Parquet, with units, variables and descriptions in the metadata.

use super::content::{Content, Extent, check_headings, check_kept};
use super::digest::Digest;
use super::rows::{Builder, Head, Row as _, Stop, check_unit, heads, missing, read as read_row};
use crate::columns::{CONTACTS, Column, ID, TOTALS};
use crate::record::Each;
use crate::run::Points;
use lemons_columns::{Batch, Cell, Kind, Reader, TableError};
use lemons_files::input;
use std::borrow::Cow;
use std::fs::File;
use std::io::Write;
use std::path::Path;

/// Reads all frames and returns the Ids of the agents.
pub(super) fn read(file: File, each: &mut Each<'_>) -> Result<Vec<String>, Stop> {
    let reader = Reader::open(file).map_err(|error| error.to_string())?;
    let (groups, heads) = heads(|name| reader.columns().iter().any(|column| column.name == name));
    let places = heads.iter().map(|head| place(&reader, *head)).collect::<Result<Vec<usize>, String>>()?;
    let mut builder = Builder::new("row");
    let mut before = 0;
    for batch in reader.batches(&places) {
        let batch = batch.map_err(|error| error.to_string())?;
        for row in 0..batch.rows() {
            let n = before + 1 + row as u64;
            let row = Row { batch: &batch, row, n, heads: &heads };
            let seen = read_row(&row, groups)?;
            if let Some(frame) = builder.add(n, row.real(0)?, &row.id()?, seen)? {
                each(frame)?;
            }
        }
        before += batch.rows() as u64;
    }
    let (last, ids) = builder.finish()?;
    each(last)?;
    Ok(ids)
}

/// Which communication points a file has.
pub(super) fn points(file: File) -> Option<Points> {
    let reader = Reader::open(file).ok()?;
    let [every, step] = Points::KEYS.map(|key| reader.about(key));
    Some(Points { every: every?.parse().ok()?, step: step?.parse().ok()? })
}

/// Where a column is.
fn place(reader: &Reader, (name, unit): Head) -> Result<usize, String> {
    let mut found = reader.columns().iter().enumerate().filter(|(_, column)| column.name == name);
    let (place, column) = match (found.next(), found.next()) {
        (Some(column), None) => column,
        (Some(_), Some(_)) => return Err(format!("there are two columns {name:?}")),
        (None, _) => return Err(missing(name)),
    };
    check_unit(name, column.about("unit"), unit)?;
    let (good, holds): (&[Kind], _) = match name {
        // Other tools make numbers of ids that look like some.
        ID => (&[Kind::Text, Kind::Integer, Kind::Long], "neither texts nor whole numbers"),
        _ if CONTACTS.iter().chain(&TOTALS).any(|count| count.name == name) => {
            (&[Kind::Integer, Kind::Long], "no whole numbers")
        }
        _ => (&[Kind::Real, Kind::Integer], "no numbers"),
    };
    if !column.kind.is_some_and(|kind| good.contains(&kind)) {
        return Err(format!("column {name}: holds {holds}"));
    }
    Ok(place)
}

/// The n-th row of the file.
struct Row<'a> {
    batch: &'a Batch,
    /// In the batch.
    row: usize,
    n: u64,
    heads: &'a [Head],
}

impl Row<'_> {
    fn wrong<T>(&self, k: usize, what: impl std::fmt::Display) -> Result<T, String> {
        Err(format!("row {}: column {}: {what}", self.n, self.heads[k].0))
    }

    fn cell(&self, k: usize) -> Result<Cell<'_>, String> {
        match self.batch.cell(k, self.row) {
            Cell::Missing => self.wrong(k, "there is no value"),
            cell => Ok(cell),
        }
    }
}

impl super::rows::Row for Row<'_> {
    fn id(&self) -> Result<Cow<'_, str>, String> {
        match self.cell(1)? {
            Cell::Text(id) => Ok(id.into()),
            Cell::Integer(id) => Ok(id.to_string().into()),
            Cell::Long(id) => Ok(id.to_string().into()),
            _ => self.wrong(1, "is not an Id"),
        }
    }

    fn real(&self, k: usize) -> Result<f64, String> {
        match self.cell(k)? {
            Cell::Real(value) if value.is_finite() => Ok(value),
            Cell::Integer(value) => Ok(value.into()),
            Cell::Real(value) => self.wrong(k, format!("{value:?} is not a finite number")),
            _ => self.wrong(k, "is not a number"),
        }
    }

    fn count(&self, k: usize) -> Result<u32, String> {
        let value = match self.cell(k)? {
            Cell::Integer(value) => value.into(),
            Cell::Long(value) => value,
            _ => return self.wrong(k, "is not a whole number"),
        };
        u32::try_from(value).or_else(|_| self.wrong(k, format!("{value} is not a valid number of contacts")))
    }

    fn size(&self, k: usize, what: &str) -> Result<f64, String> {
        let value = self.real(k)?;
        if value < 0.0 { self.wrong(k, format!("{value:?} is not a valid {what}")) } else { Ok(value) }
    }
}

/// A table that is written.
pub(super) struct Writer<W: Write + Send> {
    out: lemons_columns::Writer<W>,
    digest: Digest,
}

impl<W: Write + Send> Writer<W> {
    /// Without rows.
    pub fn create(file: W, content: &Content) -> Result<Writer<W>, TableError> {
        let out = lemons_columns::Writer::create(file, &described(&content.columns), &content.about)?;
        Ok(Writer { out, digest: Digest::new() })
    }

    /// With the rows that were written before.
    pub fn resume(file: W, content: &Content, path: &Path, kept: Extent) -> Result<Writer<W>, String> {
        let mut new = Writer::create(file, content).map_err(|error| error.to_string())?;
        copy(path, &content.columns, kept, &mut new)?;
        Ok(new)
    }

    pub fn row<'a>(&mut self, cells: impl Iterator<Item = Cell<'a>>) -> Result<(), TableError> {
        let digest = &mut self.digest;
        self.out.row(cells.inspect(|cell| digest.add_cell(cell)))
    }

    /// Of all cells.
    pub fn digest(&self) -> u128 {
        self.digest.value()
    }

    pub fn finish(self) -> Result<W, TableError> {
        self.out.finish()
    }
}

fn described(columns: &[Column]) -> Vec<lemons_columns::Column> {
    let described = |(k, column): (usize, &Column)| {
        let unit = column.unit.clone().map(|unit| ("unit", unit));
        let about = [("variable", column.variable.clone()), ("description", column.description.clone())];
        lemons_columns::Column {
            name: column.name.clone(),
            kind: column.kind,
            optional: false,
            // Times do; other numbers hardly.
            repeats: k == 0 || column.kind != Kind::Real,
            about: unit.into_iter().chain(about).collect(),
        }
    };
    columns.iter().enumerate().map(described).collect()
}

/// Name and unit: a table in other units is another one.
fn heading(name: &str, unit: Option<&str>) -> String {
    unit.map_or(name.into(), |unit| format!("{name} [{unit}]"))
}

/// Copies the rows that were written before, if the table is that one.
fn copy<W: Write + Send>(
    path: &Path,
    columns: &[Column],
    kept: Extent,
    to: &mut Writer<W>,
) -> Result<(), String> {
    let file = input::open(path).map_err(|error| error.to_string())?;
    let reader = Reader::open(file).map_err(|error| error.to_string())?;
    check_headings(
        reader.columns().iter().map(|column| heading(&column.name, column.about("unit"))),
        columns.iter().map(|column| heading(&column.name, column.unit.as_deref())),
    )?;
    for (there, here) in reader.columns().iter().zip(columns) {
        if there.kind != Some(here.kind) {
            return Err(format!("column {:?} is of another type", here.name));
        }
    }
    let (mut rows, mut last) = (0, None);
    let all: Vec<usize> = (0..columns.len()).collect();
    for batch in reader.batches(&all) {
        let batch = batch.map_err(|error| error.to_string())?;
        rows += batch.rows() as u64;
        if rows > kept.rows {
            return Err(format!("it has more than the {} rows that were written before", kept.rows));
        }
        for row in 0..batch.rows() {
            let copied = to.row(batch.row(row));
            copied.map_err(|error| format!("its rows cannot be copied: {error}"))?;
        }
        if let Cell::Real(time) = batch.cell(0, batch.rows() - 1) {
            last = Some(time);
        }
    }
    check_kept(kept, Extent { rows, last, digest: to.digest() })
}
