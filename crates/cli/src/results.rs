//! The tables of a run: which there are, what they hold, how they are written.

mod csv;
mod parquet;

use crate::files;
use anyhow::{Context, Result, bail};
use clap::ValueEnum;
pub use lemons_columns::{Cell, Kind};
pub use lemons_master::Extent;
use std::path::{Path, PathBuf};

/// What a file of results is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Format {
    /// Text: SI units, numbers that read back to the same doubles
    Csv,
    /// Columns, compressed: some times smaller; units in the file's metadata
    Parquet,
}

impl Format {
    /// What the extension of a file says.
    pub fn of(path: &Path) -> Option<Format> {
        let end = path.extension()?;
        [Format::Csv, Format::Parquet].into_iter().find(|format| end.eq_ignore_ascii_case(format.extension()))
    }

    pub fn extension(self) -> &'static str {
        match self {
            Format::Csv => "csv",
            Format::Parquet => "parquet",
        }
    }
}

/// A column of a table.
#[derive(Debug, Clone)]
pub struct Column {
    pub name: String,
    pub kind: Kind,
    pub unit: Option<String>,
    /// Of the FMU, or what it is without one.
    pub variable: String,
    pub description: String,
}

impl Column {
    /// In every table the first one.
    pub fn time() -> Column {
        Column {
            name: "t".into(),
            kind: Kind::Real,
            unit: Some("s".into()),
            variable: "time".into(),
            description: "time of the communication point".into(),
        }
    }

    /// In the metadata of Parquet, where a table of other units is another one.
    fn with_unit(&self) -> String {
        with_unit(&self.name, self.unit.as_deref())
    }
}

/// `x [m]`
fn with_unit(name: &str, unit: Option<&str>) -> String {
    unit.map_or(name.into(), |unit| format!("{name} [{unit}]"))
}

/// What a table holds: its columns, and what is said of the whole.
pub struct Content {
    pub columns: Vec<Column>,
    pub about: Vec<(&'static str, String)>,
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

/// A file of rows that appears under its name only when it is complete.
pub struct Table {
    writer: Writer,
    path: PathBuf,
    extent: Extent,
    started: Started,
}

enum Writer {
    Csv(Box<csv::Table>),
    Parquet(Box<parquet::Table>),
}

impl Table {
    /// If a run before has written some rows of it, and they are there, they are kept.
    pub fn create(place: &Place, content: &Content, before: Option<Extent>) -> Result<Table> {
        let path = place.path.clone();
        let kept = before.filter(|before| before.rows > 0 && path.is_file());
        let file = if kept.is_some() { files::stage_to_go_on(&path)? } else { files::stage(&path)? };
        let made = match place.format {
            Format::Csv => {
                csv::Table::create(file, content, &path, kept).map(|table| Writer::Csv(Box::new(table)))
            }
            Format::Parquet => parquet::Table::create(file, content, &path, kept)
                .map(|table| Writer::Parquet(Box::new(table))),
        };
        let writer = made.with_context(|| match kept {
            Some(_) => format!(
                "{}: is not what the saved run has written, it cannot go on there: choose another file, which \
                 gets what follows only",
                path.display()
            ),
            None => format!("cannot write {}", path.display()),
        })?;
        let started = match (before, kept) {
            (None, _) => Started::Anew,
            (Some(_), Some(_)) => Started::Continued,
            (Some(_), None) => Started::Later,
        };
        Ok(Table { writer, path, extent: kept.unwrap_or_default(), started })
    }

    /// Writes a row: the time \[s\], and the other columns.
    pub fn write<'a>(&mut self, time: f64, cells: impl IntoIterator<Item = Cell<'a>>) -> Result<()> {
        let cells = std::iter::once(Cell::Real(time)).chain(cells);
        let written = match &mut self.writer {
            Writer::Csv(table) => table.write(cells),
            Writer::Parquet(table) => table.write(cells),
        };
        written.with_context(|| format!("cannot write {}", self.path.display()))?;
        self.extent = Extent { rows: self.extent.rows + 1, last: Some(time) };
        Ok(())
    }

    pub fn extent(&self) -> Extent {
        self.extent
    }

    /// Its file, for a summary.
    pub fn said(&self) -> String {
        let path = self.path.display();
        match self.started {
            Started::Anew => path.to_string(),
            Started::Continued => format!("{path}   (continued)"),
            Started::Later => format!("{path}   (what came after the saved run)"),
        }
    }

    /// Puts the file in its place.
    pub fn finish(self) -> Result<()> {
        let done = match self.writer {
            Writer::Csv(table) => table.finish(),
            Writer::Parquet(table) => table.finish(),
        };
        done.and_then(|file| Ok(file.persist()?))
            .with_context(|| format!("cannot write {}", self.path.display()))
    }
}

/// Whether a table there is what a run has written: columns, rows, time of the last row \[s\].
fn check_kept(kept: Extent, rows: u64, last: Option<f64>) -> Result<()> {
    if rows != kept.rows {
        bail!("it has {rows} rows, the saved run has written {}", kept.rows);
    }
    if last.map(f64::to_bits) != kept.last.map(f64::to_bits) {
        let said = |time: Option<f64>| time.map_or("no number".into(), |time| format!("{time:?} s"));
        bail!("its last row is of t = {}, that of the saved run of t = {}", said(last), said(kept.last));
    }
    Ok(())
}

fn check_headings(there: impl Iterator<Item = String>, here: impl Iterator<Item = String>) -> Result<()> {
    let (there, here): (Vec<String>, Vec<String>) = (there.collect(), here.collect());
    if let Some(k) = (0..there.len().max(here.len())).find(|&k| there.get(k) != here.get(k)) {
        let said = |list: &[String]| list.get(k).map_or("missing".into(), |name| format!("{name:?}"));
        bail!("column {} is {}, not {}", k + 1, said(&there), said(&here));
    }
    Ok(())
}
