//! The directory of a sweep: a manifest, part files while it runs, one table at the end.

use crate::points::{Points, Values};
use anyhow::{Context, Result, bail};
use crowd_mechanics::files::Staged;
use lemons_columns::{Batch, Cell, Column, Kind, Reader, Writer};
use lemons_files::input;
use serde_json::{Map, Value};
use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};

const MANIFEST: &str = "sweep.json";
const TABLE: &str = "table.parquet";
const LOCK: &str = "sweep.lock";
/// Of the directory's files; another version is refused.
const FORMAT: u64 = 1;
const OK: &str = "ok";
const FAILED: &str = "failed";

/// A finished point.
#[derive(Debug, Clone, PartialEq)]
pub struct Finished {
    /// Its number, from 0.
    pub point: usize,
    /// What was measured, in the order of the measures, or why it failed.
    pub outcome: Result<Vec<Option<f64>>, String>,
}

/// Where results are kept. One process at a time writes to it.
pub struct Directory {
    path: PathBuf,
    points: Points,
    measures: Vec<String>,
    columns: Vec<Column>,
    /// Held while this lives.
    _lock: File,
}

impl Directory {
    /// Makes the directory, or goes on with the sweep that it holds.
    ///
    /// # Errors
    /// It holds another sweep, another process writes there, or it cannot be written.
    pub fn open(
        path: &Path,
        manifest: Map<String, Value>,
        points: &Points,
        measures: &[String],
    ) -> Result<Directory> {
        let at = || path.display().to_string();
        std::fs::create_dir_all(path).with_context(at)?;
        let lock = File::options().create(true).append(true).open(path.join(LOCK)).with_context(at)?;
        match lock.try_lock() {
            Ok(()) => {}
            Err(std::fs::TryLockError::WouldBlock) => {
                bail!("{}: another process writes its results here", path.display())
            }
            Err(std::fs::TryLockError::Error(error)) => return Err(error).with_context(at),
        }
        let directory = Directory {
            path: path.to_owned(),
            points: points.clone(),
            measures: measures.to_vec(),
            columns: columns(points, measures),
            _lock: lock,
        };
        directory.begin(manifest)?;
        directory.clean().with_context(at)?;
        Ok(directory)
    }

    /// Removes what this sweep had begun to write when it was killed: the directory is its own, and it alone writes.
    fn clean(&self) -> std::io::Result<()> {
        for entry in std::fs::read_dir(&self.path)? {
            let entry = entry?;
            let name = entry.file_name();
            let text = name.to_string_lossy();
            if !entry.file_type()?.is_file() {
                continue;
            }
            if text.starts_with(".lemons-") || (text.starts_with('.') && text.ends_with(".tmp")) {
                std::fs::remove_file(self.path.join(&name))?;
            }
        }
        Ok(())
    }

    fn begin(&self, mut manifest: Map<String, Value>) -> Result<()> {
        manifest.insert("format".into(), FORMAT.into());
        let path = self.path.join(MANIFEST);
        if !path.exists() {
            if self.path.join(TABLE).exists() || !self.parts()?.is_empty() {
                bail!("{} holds tables, but no {MANIFEST}", self.path.display());
            }
            let text = serde_json::to_string_pretty(&Value::Object(manifest))? + "\n";
            return self.write(MANIFEST, |file| Ok(file.write_all(text.as_bytes())?));
        }
        let text =
            input::read_text(&path, input::LARGEST_SETTINGS).with_context(|| path.display().to_string())?;
        let before: Value = serde_json::from_str(&text).with_context(|| path.display().to_string())?;
        let other: Vec<&str> = manifest
            .iter()
            .filter(|(key, value)| before.get(key.as_str()) != Some(*value))
            .map(|(key, _)| key.as_str())
            .collect();
        if !other.is_empty() {
            bail!(
                "{} holds another sweep: {} not as in its {MANIFEST}; give another directory, or remove this one",
                self.path.display(),
                other.join(", ")
            );
        }
        Ok(())
    }

    /// All that is finished, each point once and in the order of the points: of several rows of one point one that is
    /// ok, else the last.
    ///
    /// # Errors
    /// A file is damaged or of other points.
    pub fn read(&self) -> Result<Vec<Finished>> {
        let mut all: Vec<Option<Finished>> = vec![None; self.points.count];
        let table = Some(self.path.join(TABLE)).filter(|path| path.exists());
        for path in table.into_iter().chain(self.parts()?) {
            let rows = self.read_file(&path).with_context(|| {
                format!("{} cannot be used; remove it, and its points are simulated again", path.display())
            })?;
            for row in rows {
                let kept = &mut all[row.point];
                if kept.as_ref().is_none_or(|kept| kept.outcome.is_err() || row.outcome.is_ok()) {
                    *kept = Some(row);
                }
            }
        }
        Ok(all.into_iter().flatten().collect())
    }

    /// One part file more.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn add(&self, rows: &[Finished]) -> Result<()> {
        let numbers = self
            .parts()?
            .into_iter()
            .filter_map(|path| path.file_stem()?.to_str()?.strip_prefix("part-")?.parse::<u64>().ok());
        let number = numbers.max().unwrap_or(0) + 1;
        self.write_table(&format!("part-{number:06}.parquet"), rows)
    }

    /// The whole table in place of the parts.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn finish(&self, rows: &[Finished]) -> Result<()> {
        let parts = self.parts()?;
        if parts.is_empty() && self.path.join(TABLE).exists() {
            return Ok(());
        }
        self.write_table(TABLE, rows)?;
        for part in parts {
            std::fs::remove_file(&part).with_context(|| part.display().to_string())?;
        }
        Ok(())
    }

    /// All that is finished, as CSV; no measure is an empty cell.
    ///
    /// # Errors
    /// It cannot be written, or the directory not be read.
    pub fn write_csv(&self, path: &Path) -> Result<()> {
        let rows = self.read()?;
        let written = || {
            let mut out = csv::Writer::from_writer(Staged::beside(path)?);
            out.write_record(self.columns.iter().map(|column| &column.name))?;
            for Finished { point, outcome } in &rows {
                let parameters = self.points.columns.iter().map(|(_, values)| values.text(*point));
                let (measured, status, error) = match outcome {
                    Ok(values) => (values.clone(), OK, String::new()),
                    Err(message) => (vec![None; self.measures.len()], FAILED, message.clone()),
                };
                // `{:?}` reads back to the same double.
                let measured =
                    measured.iter().map(|value| value.map_or(String::new(), |value| format!("{value:?}")));
                let row = std::iter::once(point.to_string()).chain(parameters).chain(measured);
                out.write_record(row.chain([status.to_owned(), error]))?;
            }
            let file = out.into_inner().map_err(|error| error.into_error())?;
            anyhow::Ok(file.persist()?)
        };
        written().with_context(|| format!("cannot write {}", path.display()))
    }

    /// Where [`Directory::finish`] puts the table.
    pub fn table(&self) -> PathBuf {
        self.path.join(TABLE)
    }

    /// By name.
    fn parts(&self) -> Result<Vec<PathBuf>> {
        let at = || self.path.display().to_string();
        let mut parts = Vec::new();
        for entry in std::fs::read_dir(&self.path).with_context(at)? {
            let path = entry.with_context(at)?.path();
            let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
            if name.starts_with("part-") && name.ends_with(".parquet") {
                parts.push(path);
            }
        }
        parts.sort();
        Ok(parts)
    }

    /// Whole or not at all, after a power failure too.
    fn write(&self, name: &str, write: impl FnOnce(&mut Staged) -> Result<()>) -> Result<()> {
        let path = self.path.join(name);
        let written = || {
            let mut file = Staged::beside(&path)?;
            write(&mut file)?;
            file.sync()?;
            anyhow::Ok(file.persist()?)
        };
        written().with_context(|| format!("cannot write {}", path.display()))
    }

    fn write_table(&self, name: &str, rows: &[Finished]) -> Result<()> {
        self.write(name, |file| {
            let mut out = Writer::create(file, &self.columns, &[])?;
            rows.iter().try_for_each(|row| out.row(self.cells(row)))?;
            out.finish()?;
            Ok(())
        })
    }

    /// Of a row.
    fn cells<'a>(&'a self, Finished { point, outcome }: &'a Finished) -> impl Iterator<Item = Cell<'a>> {
        let measured = (0..self.measures.len()).map(move |k| {
            let value = outcome.as_ref().ok().and_then(|values| values[k]);
            value.map_or(Cell::Missing, Cell::Real)
        });
        let (status, error) = match outcome {
            Ok(_) => (OK, Cell::Missing),
            Err(message) => (FAILED, Cell::Text(message)),
        };
        let number = Cell::Long(*point as i64);
        std::iter::once(number).chain(self.values(*point)).chain(measured).chain([Cell::Text(status), error])
    }

    /// The parameters of a point.
    fn values(&self, point: usize) -> impl Iterator<Item = Cell<'_>> {
        self.points.columns.iter().map(move |(_, values)| match values {
            Values::Integers(all) => Cell::Long(all[point]),
            Values::Reals(all) => Cell::Real(all[point]),
            Values::Texts(all) => Cell::Text(&all[point]),
        })
    }

    fn read_file(&self, path: &Path) -> Result<Vec<Finished>> {
        let reader = Reader::open(input::open(path)?)?;
        let there = reader.columns().iter().map(|column| (&column.name, column.kind, column.optional));
        if !there.eq(self.columns.iter().map(|column| (&column.name, Some(column.kind), column.optional))) {
            bail!("it has other columns than the sweep");
        }
        let all: Vec<usize> = (0..self.columns.len()).collect();
        let mut rows = Vec::new();
        for batch in reader.batches(&all) {
            let batch = batch?;
            for row in 0..batch.rows() {
                rows.push(self.finished(&batch, row)?);
            }
        }
        Ok(rows)
    }

    fn finished(&self, batch: &Batch, row: usize) -> Result<Finished> {
        let Cell::Long(number) = batch.cell(0, row) else { bail!("a point has no number") };
        let point = usize::try_from(number).ok().filter(|point| *point < self.points.count);
        let Some(point) = point else { bail!("it has points that the sweep does not have") };
        // A point is its number and its values: both must be those of this sweep.
        let first = 1 + self.points.columns.len();
        if !self.values(point).zip(1..).all(|(value, k)| same(value, batch.cell(k, row))) {
            bail!("its points have other values than those of the sweep");
        }
        let last = self.columns.len() - 1;
        let outcome = match (batch.cell(last - 1, row), batch.cell(last, row)) {
            (Cell::Text(OK), _) => Ok((first..last - 1)
                .map(|k| if let Cell::Real(value) = batch.cell(k, row) { Some(value) } else { None })
                .collect()),
            (Cell::Text(FAILED), Cell::Text(message)) => Err(message.to_owned()),
            (Cell::Text(FAILED), _) => bail!("point {point} failed without a message"),
            (status, _) => bail!("point {point}: status {status:?}"),
        };
        Ok(Finished { point, outcome })
    }
}

/// Bit for bit.
fn same(one: Cell<'_>, other: Cell<'_>) -> bool {
    match (one, other) {
        (Cell::Real(one), Cell::Real(other)) => one.to_bits() == other.to_bits(),
        (one, other) => one == other,
    }
}

/// Points that are alike have many values in common.
fn columns(points: &Points, measures: &[String]) -> Vec<Column> {
    let column = |name: &str, kind, optional| Column {
        name: name.to_owned(),
        kind,
        optional,
        repeats: true,
        about: Vec::new(),
    };
    let mut columns = vec![column("point", Kind::Long, false)];
    columns.extend(points.columns.iter().map(|(name, values)| {
        let kind = match values {
            Values::Integers(_) => Kind::Long,
            Values::Reals(_) => Kind::Real,
            Values::Texts(_) => Kind::Text,
        };
        column(name, kind, false)
    }));
    columns.extend(measures.iter().map(|name| column(name, Kind::Real, true)));
    columns.push(column("status", Kind::Text, false));
    columns.push(column("error", Kind::Text, true));
    columns
}
