//! The directory of a sweep: a manifest, part files while it runs, one table at the end.

use crate::points::{Points, Values};
use anyhow::{Context, Result, anyhow, bail};
use arrow_array::{Array, ArrayRef, Float64Array, Int64Array, RecordBatch, StringArray};
use arrow_schema::{DataType, Field, Schema, SchemaRef};
use crowd_mechanics::files::Staged;
use parquet::arrow::ArrowWriter;
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
use parquet::basic::{Compression, ZstdLevel};
use parquet::file::properties::WriterProperties;
use serde_json::{Map, Value};
use std::fs::File;
use std::io::Write;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::Arc;

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
    schema: SchemaRef,
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
            schema: schema(points, measures),
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
        let text = std::fs::read_to_string(&path).with_context(|| path.display().to_string())?;
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
            // The crate panics at some broken files.
            let read = catch_unwind(AssertUnwindSafe(|| self.read_file(&path)));
            let rows = read.unwrap_or_else(|_| Err(anyhow!("is no sound Parquet"))).with_context(|| {
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
            out.write_record(self.schema.fields().iter().map(|field| field.name()))?;
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
        let batch = self.batch(rows)?;
        let compression = Compression::ZSTD(ZstdLevel::default());
        let properties = WriterProperties::builder().set_compression(compression).build();
        self.write(name, |file| {
            let mut out = ArrowWriter::try_new(file, self.schema.clone(), Some(properties))?;
            out.write(&batch)?;
            out.close()?;
            Ok(())
        })
    }

    /// A row for each of these.
    fn batch(&self, rows: &[Finished]) -> Result<RecordBatch> {
        let numbers = rows.iter().map(|row| row.point as i64);
        let mut columns: Vec<ArrayRef> = vec![Arc::new(Int64Array::from_iter_values(numbers))];
        for (_, values) in &self.points.columns {
            columns.push(match values {
                Values::Integers(all) => {
                    Arc::new(Int64Array::from_iter_values(rows.iter().map(|row| all[row.point])))
                }
                Values::Reals(all) => {
                    Arc::new(Float64Array::from_iter_values(rows.iter().map(|row| all[row.point])))
                }
                Values::Texts(all) => {
                    Arc::new(StringArray::from_iter_values(rows.iter().map(|row| &all[row.point])))
                }
            });
        }
        for k in 0..self.measures.len() {
            let values = rows.iter().map(|row| row.outcome.as_ref().ok().and_then(|values| values[k]));
            columns.push(Arc::new(Float64Array::from_iter(values)));
        }
        let status = rows.iter().map(|row| if row.outcome.is_ok() { OK } else { FAILED });
        columns.push(Arc::new(StringArray::from_iter_values(status)));
        let errors = rows.iter().map(|row| row.outcome.as_ref().err());
        columns.push(Arc::new(StringArray::from_iter(errors)));
        Ok(RecordBatch::try_new(self.schema.clone(), columns)?)
    }

    fn read_file(&self, path: &Path) -> Result<Vec<Finished>> {
        let reader = ParquetRecordBatchReaderBuilder::try_new(File::open(path)?)?;
        if reader.schema().fields() != self.schema.fields() {
            bail!("it has other columns than the sweep");
        }
        let mut rows = Vec::new();
        for batch in reader.build()? {
            let batch = batch?;
            let found = self.rows(&batch)?;
            if found.iter().any(|row| row.point >= self.points.count) {
                bail!("it has points that the sweep does not have");
            }
            // A point is its number and its values: both must be those of this sweep.
            let again = self.batch(&found)?;
            let parameters = 0..=self.points.columns.len();
            if !parameters.clone().all(|k| batch.column(k) == again.column(k)) {
                bail!("its points have other values than those of the sweep");
            }
            rows.extend(found);
        }
        Ok(rows)
    }

    fn rows(&self, batch: &RecordBatch) -> Result<Vec<Finished>> {
        let damaged = "a column is of another type";
        let numbers = batch.column(0).as_any().downcast_ref::<Int64Array>().context(damaged)?;
        let first = 1 + self.points.columns.len();
        let measured = (first..first + self.measures.len())
            .map(|k| batch.column(k).as_any().downcast_ref::<Float64Array>().context(damaged));
        let measured = measured.collect::<Result<Vec<_>>>()?;
        let text = |k: usize| batch.column(k).as_any().downcast_ref::<StringArray>().context(damaged);
        let (status, error) = (text(batch.num_columns() - 2)?, text(batch.num_columns() - 1)?);
        (0..batch.num_rows())
            .map(|k| {
                let point = usize::try_from(numbers.value(k)).ok().context("a point has no number")?;
                let values = measured.iter().map(|column| column.is_valid(k).then(|| column.value(k)));
                let outcome = match status.value(k) {
                    OK => Ok(values.collect()),
                    FAILED => Err(error.value(k).to_owned()),
                    other => bail!("point {point}: status {other:?}"),
                };
                Ok(Finished { point, outcome })
            })
            .collect()
    }
}

fn schema(points: &Points, measures: &[String]) -> SchemaRef {
    let field = |name: &str, kind, nullable| Field::new(name, kind, nullable);
    let mut fields = vec![field("point", DataType::Int64, false)];
    fields.extend(points.columns.iter().map(|(name, values)| {
        let kind = match values {
            Values::Integers(_) => DataType::Int64,
            Values::Reals(_) => DataType::Float64,
            Values::Texts(_) => DataType::Utf8,
        };
        field(name, kind, false)
    }));
    fields.extend(measures.iter().map(|name| field(name, DataType::Float64, true)));
    fields.push(field("status", DataType::Utf8, false));
    fields.push(field("error", DataType::Utf8, true));
    Arc::new(Schema::new(fields))
}
