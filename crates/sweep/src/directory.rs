//! The directory of a sweep: a manifest, part files while it runs, and one table at the end.

use crate::error::{Error, Place, Result};
use crate::points::{Points, Values};
use lemons_columns::{Batch, Cell, Column, Kind, Reader, Writer};
use lemons_files::Staged;
use lemons_files::input;
use lemons_master::writers;
use serde_json::{Map, Value};
use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};

const MANIFEST: &str = "sweep.json";
const TABLE: &str = "table.parquet";
const LOCK: &str = "sweep.lock";
/// Version of the format of the files; other versions are refused.
const FORMAT: u64 = 1;
/// Key in the metadata of tables: the programs that wrote them.
const BY: &str = "lemons_version";
const OK: &str = "ok";
const FAILED: &str = "failed";

/// A finished point.
#[derive(Debug, Clone, PartialEq)]
pub struct Finished {
    /// Number of the point, from 0.
    pub point: usize,
    /// The measured values, in the order of the measures, or the message of the failure.
    pub outcome: Result<Vec<Option<f64>>, String>,
}

/// The directory with the results. Only one process at a time can write to it.
pub struct Directory {
    path: PathBuf,
    points: Points,
    measures: Vec<String>,
    columns: Vec<Column>,
    /// The program that writes.
    by: String,
    /// Locked while this value lives.
    _lock: File,
}

impl Directory {
    /// Creates the directory, or opens the one of an unfinished sweep. `by` is the program named in the tables.
    ///
    /// # Errors
    /// The directory contains another sweep, another process writes there, or it cannot be written.
    pub fn open(
        path: &Path,
        manifest: Map<String, Value>,
        points: &Points,
        measures: &[String],
        by: &str,
    ) -> Result<Directory> {
        let at = || path.display().to_string();
        std::fs::create_dir_all(path).place(at)?;
        let lock = File::options().create(true).append(true).open(path.join(LOCK)).place(at)?;
        match lock.try_lock() {
            Ok(()) => {}
            Err(std::fs::TryLockError::WouldBlock) => {
                return Err(Error::Busy(path.to_owned()));
            }
            Err(std::fs::TryLockError::Error(error)) => return Err(error).place(at),
        }
        let directory = Directory {
            path: path.to_owned(),
            points: points.clone(),
            measures: measures.to_vec(),
            columns: columns(points, measures),
            by: by.to_owned(),
            _lock: lock,
        };
        directory.begin(manifest)?;
        directory.clean().place(at)?;
        Ok(directory)
    }

    /// Removes temporary files of a killed sweep, and nothing else: other programs may write to the directory, too.
    fn clean(&self) -> std::io::Result<()> {
        for entry in std::fs::read_dir(&self.path)? {
            let entry = entry?;
            let name = entry.file_name();
            if entry.file_type()?.is_file() && name.to_str().is_some_and(is_temporary) {
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
                return Err(Error::NoManifest { directory: self.path.clone(), manifest: MANIFEST });
            }
            let text = serde_json::to_string_pretty(&Value::Object(manifest))? + "\n";
            return self.write(MANIFEST, |file| Ok(file.write_all(text.as_bytes())?));
        }
        let text = input::read_text(&path, input::LARGEST_SETTINGS).place(|| path.display().to_string())?;
        let before: Value = serde_json::from_str(&text).place(|| path.display().to_string())?;
        let mut other: Vec<String> = manifest
            .iter()
            .filter(|(key, value)| before.get(key.as_str()) != Some(*value))
            .map(|(key, _)| key.clone())
            .collect();
        // A plan or a condition that this sweep does not have.
        let keys = before.as_object().into_iter().flat_map(|before| before.keys());
        other.extend(keys.filter(|key| !manifest.contains_key(*key)).cloned());
        if !other.is_empty() {
            let directory = self.path.clone();
            return Err(Error::OtherSweep { directory, keys: other, manifest: MANIFEST });
        }
        Ok(())
    }

    /// Returns all finished points, each once and in order. If a point has several rows, it returns a successful one,
    /// else the last.
    ///
    /// # Errors
    /// A file is damaged, or contains points of another sweep.
    pub fn read(&self) -> Result<Vec<Finished>> {
        let mut all: Vec<Option<Finished>> = vec![None; self.points.count];
        for path in self.tables()? {
            let rows = self.read_file(&path).place(|| {
                format!("{} cannot be used; if you remove it, its points are simulated again", path.display())
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

    /// Adds a part file.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn add(&self, rows: &[Finished]) -> Result<()> {
        let numbers = self
            .parts()?
            .into_iter()
            .filter_map(|path| path.file_stem()?.to_str()?.strip_prefix("part-")?.parse::<u64>().ok());
        let number = numbers.max().unwrap_or(0) + 1;
        self.write_table(&format!("part-{number:06}.parquet"), rows, &self.by)
    }

    /// Writes the whole table and removes the parts.
    ///
    /// # Errors
    /// The table cannot be written.
    pub fn finish(&self, rows: &[Finished]) -> Result<()> {
        let parts = self.parts()?;
        if parts.is_empty() && self.path.join(TABLE).exists() {
            return Ok(());
        }
        let mut by = String::new();
        for path in self.tables()? {
            let reader = Reader::open(input::open(&path)?).place(|| path.display().to_string())?;
            by = writers(&by, reader.about(BY).unwrap_or_default());
        }
        self.write_table(TABLE, rows, &by)?;
        for part in parts {
            std::fs::remove_file(&part).place(|| part.display().to_string())?;
        }
        Ok(())
    }

    /// Writes all finished points as CSV. A missing value is an empty cell.
    ///
    /// # Errors
    /// The file cannot be written, or the directory cannot be read.
    pub fn write_csv(&self, file: Staged) -> Result<()> {
        let rows = self.read()?;
        let mut out = csv::Writer::from_writer(file);
        out.write_record(self.columns.iter().map(|column| &column.name))?;
        for Finished { point, outcome } in &rows {
            let parameters = self.points.columns.iter().map(|(_, values)| values.text(*point));
            let (measured, status, error) = match outcome {
                Ok(values) => (values.clone(), OK, String::new()),
                Err(message) => (vec![None; self.measures.len()], FAILED, message.clone()),
            };
            // `{:?}` is read back as the same double.
            let measured =
                measured.iter().map(|value| value.map_or(String::new(), |value| format!("{value:?}")));
            let row = std::iter::once(point.to_string()).chain(parameters).chain(measured);
            out.write_record(row.chain([status.to_owned(), error]))?;
        }
        let file = out.into_inner().map_err(|error| error.into_error())?;
        Ok(file.persist()?)
    }

    /// Returns the path of the table that [`Directory::finish`] writes.
    pub fn table(&self) -> PathBuf {
        self.path.join(TABLE)
    }

    /// Paths of the table, if there is one, and of the parts.
    fn tables(&self) -> Result<Vec<PathBuf>> {
        let table = Some(self.path.join(TABLE)).filter(|path| path.exists());
        Ok(table.into_iter().chain(self.parts()?).collect())
    }

    /// Paths of the parts, sorted by name.
    fn parts(&self) -> Result<Vec<PathBuf>> {
        let at = || self.path.display().to_string();
        let mut parts = Vec::new();
        for entry in std::fs::read_dir(&self.path).place(at)? {
            let path = entry.place(at)?.path();
            let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
            if is_part(name) {
                parts.push(path);
            }
        }
        parts.sort();
        Ok(parts)
    }

    /// Writes a file completely or not at all, even if the power fails.
    fn write(&self, name: &str, write: impl FnOnce(&mut Staged) -> Result<()>) -> Result<()> {
        let path = self.path.join(name);
        let written = || {
            let mut file = Staged::beside_as(&path, &temporary(name))?;
            write(&mut file)?;
            file.sync()?;
            Ok::<_, Error>(file.persist()?)
        };
        written().place(|| format!("cannot write {}", path.display()))
    }

    fn write_table(&self, name: &str, rows: &[Finished], by: &str) -> Result<()> {
        self.write(name, |file| {
            let mut out = Writer::create(file, &self.columns, &[(BY, by.to_owned())])?;
            rows.iter().try_for_each(|row| out.row(self.cells(row)))?;
            out.finish()?;
            Ok(())
        })
    }

    /// The cells of a row.
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

    /// The values of the parameters at a point.
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
            return Err(Error::Damaged("its columns are not those of the sweep".into()));
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
        let Cell::Long(number) = batch.cell(0, row) else {
            return Err(Error::Damaged("a point has no number".into()));
        };
        let point = usize::try_from(number).ok().filter(|point| *point < self.points.count);
        let Some(point) = point else {
            return Err(Error::Damaged("it contains points that are not in the sweep".into()));
        };
        // Both the number and the values of a point must be those of this sweep.
        let first = 1 + self.points.columns.len();
        if !self.values(point).zip(1..).all(|(value, k)| same(value, batch.cell(k, row))) {
            return Err(Error::Damaged("the values of its points are not those of the sweep".into()));
        }
        let last = self.columns.len() - 1;
        let outcome = match (batch.cell(last - 1, row), batch.cell(last, row)) {
            (Cell::Text(OK), _) => Ok((first..last - 1)
                .map(|k| if let Cell::Real(value) = batch.cell(k, row) { Some(value) } else { None })
                .collect()),
            (Cell::Text(FAILED), Cell::Text(message)) => Err(message.to_owned()),
            (Cell::Text(FAILED), _) => {
                return Err(Error::Damaged(format!("point {point} failed without a message")));
            }
            (status, _) => return Err(Error::Damaged(format!("point {point}: status {status:?}"))),
        };
        Ok(Finished { point, outcome })
    }
}

fn is_part(name: &str) -> bool {
    name.starts_with("part-") && name.ends_with(".parquet")
}

/// The name under which a file is written, until it is complete. The Python package uses the same names.
fn temporary(name: &str) -> String {
    format!(".{name}.tmp")
}

fn is_temporary(name: &str) -> bool {
    let whole = name.strip_prefix('.').and_then(|name| name.strip_suffix(".tmp"));
    whole.is_some_and(|whole| whole == MANIFEST || whole == TABLE || is_part(whole))
}

/// Compares bit for bit.
fn same(one: Cell<'_>, other: Cell<'_>) -> bool {
    match (one, other) {
        (Cell::Real(one), Cell::Real(other)) => one.to_bits() == other.to_bits(),
        (one, other) => one == other,
    }
}

/// The columns of the table. Neighbouring points share many values.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_names_all_programs_that_wrote_its_points() {
        let directory = tempfile::tempdir().unwrap();
        let columns = vec![("mass".to_owned(), Values::Reals(vec![60.0, 70.0, 80.0]))];
        let points = Points { columns, count: 3 };
        let row = |point| Finished { point, outcome: Ok(vec![Some(1.0)]) };
        let open = |by: &str| {
            Directory::open(directory.path(), Map::new(), &points, &["moved".to_owned()], by).unwrap()
        };
        for (point, by) in [(0, "0.1.0 (a)"), (1, "0.1.0 (b)"), (2, "0.1.0 (a)")] {
            open(by).add(&[row(point)]).unwrap();
        }
        let kept = open("0.1.0 (c)");
        kept.finish(&kept.read().unwrap()).unwrap();
        let table = Reader::open(File::open(kept.table()).unwrap()).unwrap();
        // The last one only put together what the others had simulated.
        assert_eq!(table.about(BY), Some("0.1.0 (a); 0.1.0 (b)"));
        assert_eq!(kept.read().unwrap(), [row(0), row(1), row(2)]);
    }

    #[test]
    fn only_the_sweeps_own_temporary_files_are_removed() {
        let directory = tempfile::tempdir().unwrap();
        let at = |name: &str| directory.path().join(name);
        let points = Points { columns: vec![("mass".to_owned(), Values::Reals(vec![60.0]))], count: 1 };
        let open = || {
            Directory::open(directory.path(), Map::new(), &points, &["moved".to_owned()], "0.1.0 (a)")
                .unwrap()
        };
        drop(open());
        // A killed sweep leaves these; the Python package has the same names.
        let own = [".sweep.json.tmp", ".table.parquet.tmp", ".part-000001.parquet.tmp"];
        // Another process writes its results here, and the user has notes.
        let foreign = [".lemons-4711-0", ".notes.tmp", ".part-1.csv.tmp", "table.parquet.tmp"];
        own.iter().chain(&foreign).for_each(|name| std::fs::write(at(name), "half").unwrap());
        let sweep = open();
        assert!(own.iter().all(|name| !at(name).exists()));
        assert!(foreign.iter().all(|name| at(name).exists()));
        sweep.add(&[Finished { point: 0, outcome: Ok(vec![Some(1.0)]) }]).unwrap();
        let mut file = Staged::beside_as(&sweep.table(), &temporary(TABLE)).unwrap();
        file.write_all(b"half").unwrap();
        assert!(at(".table.parquet.tmp").exists(), "it is written under a name that the next sweep removes");
        drop(file);
        assert!(!at(".table.parquet.tmp").exists());
    }
}
