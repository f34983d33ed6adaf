//! The table of a sweep: CSV to which finished points are appended.
//!
//! The first line is a comment, `# lemons sweep {…}`, with what must be equal to go on, as JSON. Then come the names of
//! the columns, and a row for each finished point. A sweep that was killed leaves a table whose last line may be cut
//! off; its point is simulated again. When all points are finished, the rows are sorted: so the table does not depend on
//! how often the sweep was stopped, or on the number of threads.

use crate::error::{ErrorPlace, Result, SweepError};
use crate::points::Points;
use lemons_core::files::Staged;
use lemons_core::require;
use serde_json::{Map, Value};
use std::fs::{File, TryLockError};
use std::io::{BufRead, BufReader, Read, Write};
use std::path::{Path, PathBuf};

/// Beginning of the first line.
const BEGIN: &str = "# lemons sweep ";
/// \[byte\] of the first line.
const LARGEST_IDENTITY: u64 = 64 << 20;
/// The columns that are no parameters and no measures.
pub const POINT: &str = "point";
pub const STATUS: &str = "status";
pub const ERROR: &str = "error";
const OK: &str = "ok";
const FAILED: &str = "failed";
const OTHERS: &str = "its columns are others";

/// A finished point.
#[derive(Debug, Clone, PartialEq)]
pub struct Finished {
    /// Number of the point, from 0.
    pub point: usize,
    /// The measured values, in the order of the measures, or the message of the failure.
    pub outcome: Result<Vec<Option<MeasuredValue>>, String>,
}

/// Value of a measure.
#[derive(Debug, Clone, PartialEq)]
pub enum MeasuredValue {
    /// A number.
    Number(f64),
    /// A text, of a measure that another program has computed.
    Text(String),
}

/// A table that is written. Only one process at a time can write to it.
pub struct SweepTable {
    path: PathBuf,
    points: Points,
    /// Names of the measures; `None` until the first results name them.
    measures: Option<Vec<String>>,
    /// The first line.
    first: String,
    /// Locked; what is written is appended.
    file: File,
    /// The best row of each finished point.
    rows: Vec<Option<Finished>>,
    /// Whether the rows of the file are those of the first points, in order.
    sorted: bool,
    /// Number of rows in the file.
    written: usize,
}

impl SweepTable {
    /// Creates the table, or opens that of an unfinished sweep.
    ///
    /// # Errors
    /// The file is no such table, or that of another sweep, another process writes it, or it cannot be written.
    pub fn open(path: &Path, identity: &Map<String, Value>, points: &Points) -> Result<SweepTable> {
        let at = || path.display().to_string();
        let file = File::options().create(true).read(true).append(true).open(path).place(at)?;
        match file.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => {
                return Err(SweepError::Table(format!("{}: another process writes its results here", at())));
            }
            Err(TryLockError::Error(error)) => return Err(error).place(at),
        }
        let mut table = SweepTable {
            path: path.to_owned(),
            points: points.clone(),
            measures: None,
            first: format!("{BEGIN}{}\n", serde_json::to_string(identity)?),
            file,
            rows: vec![None; points.count],
            sorted: true,
            written: 0,
        };
        let end = table.read(identity)?;
        table.file.set_len(end).place(at)?;
        if end == 0 && table.measures.is_some() {
            table.file.write_all(&table.whole()?).place(at)?;
        }
        Ok(table)
    }

    /// Returns the line with the names of all columns.
    fn names(&self) -> Result<Vec<u8>> {
        let parameters = self.points.parameters.iter().map(|parameter| &parameter.name);
        let names = parameters.chain(self.measures.iter().flatten()).cloned();
        line([POINT.to_owned()].into_iter().chain(names).chain([STATUS, ERROR].map(str::to_owned)))
    }

    /// Returns the whole file, its rows in order.
    fn whole(&self) -> Result<Vec<u8>> {
        let mut text = [self.first.as_bytes(), &self.names()?].concat();
        for row in self.rows() {
            text.extend(self.line_of(row)?);
        }
        Ok(text)
    }

    /// Returns the measures that the line of names has; `None` if it is cut off.
    fn measures_in(&self, lines: &[u8]) -> Result<Option<Vec<String>>> {
        let mut reader = csv::ReaderBuilder::new().has_headers(false).from_reader(lines);
        let mut row = csv::StringRecord::new();
        let fixed = 1 + self.points.parameters.len();
        let found = reader.read_record(&mut row)? && row.len() >= fixed + 2;
        if found && row.iter().rev().take(2).eq([ERROR, STATUS]) {
            return Ok(Some(row.iter().take(row.len() - 2).skip(fixed).map(str::to_owned).collect()));
        }
        if lines.contains(&b'\n') { Err(SweepError::Table(OTHERS.into())) } else { Ok(None) }
    }

    /// Returns the names of the measures, where they are known.
    pub fn measures(&self) -> Option<&[String]> {
        self.measures.as_deref()
    }

    /// Names the measures, as long as no point has any; these names stay.
    ///
    /// # Errors
    /// Points have others, or the file cannot be written.
    pub fn name_measures(&mut self, measures: &[String]) -> Result<()> {
        if self.measures() == Some(measures) {
            return Ok(());
        }
        if self.rows().any(|row| row.outcome.is_ok()) {
            return Err(SweepError::Table(OTHERS.into())).place(|| self.path.display().to_string());
        }
        self.measures = Some(measures.to_vec());
        let text = self.whole()?;
        let written = self.file.set_len(0).and_then(|()| self.file.write_all(&text));
        written.place(|| format!("cannot write {}", self.path.display()))
    }

    /// Reads the file. Returns how many of its bytes are whole lines.
    fn read(&mut self, identity: &Map<String, Value>) -> Result<u64> {
        let shown = self.path.display().to_string();
        let at = || shown.clone();
        let mut file = BufReader::new(self.file.try_clone().place(at)?);
        let mut first = Vec::new();
        file.by_ref().take(LARGEST_IDENTITY).read_until(b'\n', &mut first).place(at)?;
        let cut_off = self.first.as_bytes().starts_with(&first) && !first.ends_with(b"\n");
        if !cut_off {
            let text = first.strip_prefix(BEGIN.as_bytes()).filter(|_| first.ends_with(b"\n"));
            let before = text.and_then(|text| serde_json::from_slice::<Map<String, Value>>(text).ok());
            let before = before.ok_or_else(|| {
                let why = "is there, and is not the table of a sweep; give another file: -o";
                SweepError::Table(format!("{shown} {why}"))
            })?;
            let keys = identity.keys().chain(before.keys().filter(|key| !identity.contains_key(*key)));
            let differ = keys.filter(|key| identity.get(*key) != before.get(*key));
            let differ = differ.map(String::as_str).collect::<Vec<_>>().join(", ");
            require(differ.is_empty(), || {
                let other = format!("{shown} is the table of another sweep: it differs in {differ}");
                SweepError::Table(format!("{other}; give another file, or remove this one"))
            })?;
        }
        let mut rest = Vec::new();
        file.read_to_end(&mut rest).place(at)?;
        self.measures = self.measures_in(&rest).place(at)?;
        let names = self.names()?;
        if cut_off || self.measures.is_none() || rest.len() < names.len() && names.starts_with(&rest) {
            return Ok(0);
        }
        let rows = rest.strip_prefix(&names[..]).ok_or(SweepError::Table(OTHERS.into())).place(at)?;
        let lines = self.read_rows(rows);
        let advice = "cannot be used; if you remove it, all points are simulated again";
        let lines = lines.place(|| format!("{shown}: {advice}"))?;
        Ok((first.len() + names.len() + lines) as u64)
    }

    /// Reads the rows. Returns how many bytes of them are whole rows.
    fn read_rows(&mut self, rows: &[u8]) -> Result<usize> {
        let width = 1 + self.points.parameters.len() + self.measures.iter().flatten().count() + 2;
        let mut reader = csv::ReaderBuilder::new().has_headers(false).flexible(true).from_reader(rows);
        let mut row = csv::StringRecord::new();
        let mut whole = 0;
        while reader.read_record(&mut row)? {
            let end = reader.position().byte() as usize;
            // The last one may be cut off.
            if end == rows.len() && (row.len() != width || !rows.ends_with(b"\n")) {
                break;
            }
            let wrong = |why| SweepError::Table(format!("row {}: {why}", self.written + 1));
            let finished = self.finished(&row, width).map_err(wrong)?;
            self.keep(&finished);
            whole = end;
        }
        Ok(whole)
    }

    /// Returns what a row says.
    fn finished(&self, row: &csv::StringRecord, width: usize) -> Result<Finished, String> {
        require(row.len() == width, || format!("has {} columns, not {width}", row.len()))?;
        let point = row[0].parse().ok().filter(|point: &usize| *point < self.points.count);
        let point = point.ok_or_else(|| format!("there is no point {:?}", &row[0]))?;
        // Both the number and the values of a point must be those of this sweep.
        for (cell, parameter) in row.iter().skip(1).zip(&self.points.parameters) {
            let other = || format!("column {}: {cell:?} is not the value of point {point}", parameter.name);
            require(cell == parameter.at(point), other)?;
        }
        let first = 1 + self.points.parameters.len();
        let outcome = match (&row[width - 2], &row[width - 1]) {
            (OK, "") => Ok((first..width - 2).map(|k| measured(&row[k])).collect()),
            (FAILED, message) => Err(message.to_owned()),
            (status, _) => return Err(format!("status {status:?}")),
        };
        Ok(Finished { point, outcome })
    }

    /// Notes what is in the file.
    fn keep(&mut self, row: &Finished) {
        self.sorted &= row.point == self.written;
        self.written += 1;
        let kept = &mut self.rows[row.point];
        if kept.as_ref().is_none_or(|kept| kept.outcome.is_err()) {
            *kept = Some(row.clone());
        }
    }

    /// Appends rows. They stay there even if the power fails.
    ///
    /// # Errors
    /// The file cannot be written, or there is no such point.
    pub fn add(&mut self, rows: &[Finished]) -> Result<()> {
        if rows.is_empty() {
            return Ok(());
        }
        let unknown = rows.iter().map(|row| row.point).find(|point| *point >= self.points.count);
        if let Some(point) = unknown {
            return Err(SweepError::Table(format!(
                "there is no point {point}: there are {}",
                self.points.count
            )));
        }
        let mut text = Vec::new();
        for row in rows {
            text.extend(self.line_of(row)?);
            self.keep(row);
        }
        let written = self.file.write_all(&text).and_then(|()| self.file.sync_data());
        written.place(|| format!("cannot write {}", self.path.display()))
    }

    /// Sorts the rows, unless they are sorted. Returns those of all finished points, in order.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn finish(self) -> Result<Vec<Finished>> {
        let text = if self.sorted { None } else { Some(self.whole()?) };
        let SweepTable { path, file, rows, .. } = self;
        if let Some(text) = text {
            let cannot = || format!("cannot write {}", path.display());
            let mut sorted = Staged::beside(&path).place(cannot)?;
            sorted.write_all(&text).place(cannot)?;
            sorted.sync().place(cannot)?;
            // Windows replaces no open file.
            drop(file);
            sorted.persist().place(cannot)?;
        }
        Ok(rows.into_iter().flatten().collect())
    }

    /// Returns the finished points, each once and in order: of several rows of a point a successful one, else the first.
    pub fn rows(&self) -> impl Iterator<Item = &Finished> {
        self.rows.iter().flatten()
    }

    /// Returns a row as it is written. Numbers are read back as the same doubles; a missing value is an empty cell.
    fn line_of(&self, Finished { point, outcome }: &Finished) -> Result<Vec<u8>> {
        let parameters = self.points.parameters.iter().map(|parameter| parameter.at(*point).to_owned());
        let none = vec![None; self.measures.iter().flatten().count()];
        let (measured, status, error) = match outcome {
            Ok(values) => (values, OK, String::new()),
            // In one line, so that it is seen whether a row is cut off.
            Err(message) => (&none, FAILED, message.lines().collect::<Vec<_>>().join(" ")),
        };
        let measured = measured.iter().map(|value| match value {
            None => String::new(),
            Some(MeasuredValue::Number(value)) => format!("{value:?}"),
            // As messages.
            Some(MeasuredValue::Text(text)) => text.lines().collect::<Vec<_>>().join(" "),
        });
        let row = std::iter::once(point.to_string()).chain(parameters).chain(measured);
        line(row.chain([status.to_owned(), error]))
    }
}

/// Returns what a cell says that was measured.
fn measured(cell: &str) -> Option<MeasuredValue> {
    let text = |_| MeasuredValue::Text(cell.to_owned());
    (!cell.is_empty()).then(|| cell.parse().map_or_else(text, MeasuredValue::Number))
}

fn line(cells: impl Iterator<Item = String>) -> Result<Vec<u8>> {
    // With quotes around what looks like a comment.
    let mut out = csv::WriterBuilder::new().comment(Some(b'#')).from_writer(Vec::new());
    out.write_record(cells.map(String::into_bytes))?;
    Ok(out.into_inner().map_err(csv::IntoInnerError::into_error)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points() -> Points {
        let names = ["a, \"b\"", "# no comment", "line\nbreak", ""].map(str::to_owned).to_vec();
        let masses = [60.0, 0.1 + 0.2, 5e-324, 80.0].map(|mass: f64| format!("{mass:?}")).to_vec();
        Points::of_rows(vec![("mass".to_owned(), masses), ("name".to_owned(), names)])
    }

    fn row(point: usize) -> Finished {
        let outcome = match point {
            1 => Err("it \"fell\",\nbadly # so".to_owned()),
            2 => Ok(vec![None, Some(MeasuredValue::Number(f64::INFINITY))]),
            _ => Ok([1.0 / (point as f64 + 3.0), -0.0].map(MeasuredValue::Number).map(Some).to_vec()),
        };
        Finished { point, outcome }
    }

    fn identity(until: f64) -> Map<String, Value> {
        Map::from_iter([("until".to_owned(), until.into()), ("program".to_owned(), "0.1.0".into())])
    }

    fn open(path: &Path) -> Result<SweepTable> {
        let mut table = SweepTable::open(path, &identity(2.0), &points())?;
        table.name_measures(&["x", "y"].map(str::to_owned))?;
        Ok(table)
    }

    /// A table that was written in one go, in order.
    fn whole(path: &Path) -> Vec<u8> {
        let mut table = open(path).unwrap();
        table.add(&[0, 1, 2, 3].map(row)).unwrap();
        table.finish().unwrap();
        std::fs::read(path).unwrap()
    }

    /// The first results name the measures; the table says them again.
    #[test]
    fn measures_that_are_named_later_are_those_of_the_table() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("sweep.csv");
        let open = || SweepTable::open(&path, &identity(2.0), &points()).unwrap();
        let fallen = |point| Finished { point, outcome: Err("it fell".into()) };
        let far = Some(MeasuredValue::Text("far, \"so\"".into()));
        let far = Finished { point: 2, outcome: Ok(vec![far, Some(MeasuredValue::Number(0.5))]) };
        let mut table = open();
        table.name_measures(&[]).unwrap();
        table.add(&[fallen(0)]).unwrap();
        drop(table);
        let mut table = open();
        assert_eq!(table.measures(), Some(&[][..]));
        table.name_measures(&["how, far", "x"].map(str::to_owned)).unwrap();
        table.add(&[far.clone(), fallen(1)]).unwrap();
        drop(table);
        assert!(open().rows().eq([&fallen(0), &fallen(1), &far]));
        assert!(open().name_measures(&[]).is_err());
        let text = std::fs::read_to_string(&path).unwrap();
        std::fs::write(&path, text.replace("status,error", "state")).unwrap();
        assert!(SweepTable::open(&path, &identity(2.0), &points()).is_err());
    }

    /// Wherever a sweep is killed, and in whatever order its points were finished.
    #[test]
    fn a_table_that_was_cut_off_anywhere_becomes_the_same_table() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("sweep.csv");
        let whole = whole(&directory.path().join("whole.csv"));
        let mut table = open(&path).unwrap();
        table.add(&[row(2), row(0)]).unwrap();
        table.add(&[row(3), row(1)]).unwrap();
        drop(table);
        let unsorted = std::fs::read(&path).unwrap();
        assert_eq!(unsorted.len(), whole.len());
        for bytes in [&whole, &unsorted] {
            for length in 0..=bytes.len() {
                std::fs::write(&path, &bytes[..length]).unwrap();
                let mut table = open(&path).unwrap();
                let there: Vec<usize> = table.rows().map(|row| row.point).collect();
                let lost: Vec<Finished> = (0..4).filter(|point| !there.contains(point)).map(row).collect();
                table.add(&lost).unwrap();
                let rows = table.finish().unwrap();
                assert_eq!(rows.len(), 4);
                assert!(std::fs::read(&path).unwrap() == whole, "{length} of {}", bytes.len());
            }
        }
        let rows = open(&path).unwrap().finish().unwrap();
        let mut expected = [0, 1, 2, 3].map(row);
        expected[1].outcome = Err("it \"fell\", badly # so".to_owned());
        assert_eq!(rows, expected);
    }

    /// Only one process writes at a time.
    #[test]
    fn a_failed_point_can_be_simulated_again() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("sweep.csv");
        whole(&path);
        let mut table = open(&path).unwrap();
        let message = open(&path).err().unwrap().whole();
        assert!(message.contains("another process writes"), "{message}");
        let again = Finished { point: 1, outcome: Ok(vec![Some(MeasuredValue::Number(1.0)), None]) };
        table.add(std::slice::from_ref(&again)).unwrap();
        assert_eq!(table.finish().unwrap()[1], again);
        assert_eq!(open(&path).unwrap().rows().count(), 4);
        assert_eq!(std::fs::read_to_string(&path).unwrap().matches("failed").count(), 0);
    }

    #[test]
    fn another_file_stays_as_it_is() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("sweep.csv");
        let good = String::from_utf8(whole(&path)).unwrap();
        let other = |from: &str, to: &str| {
            assert!(good.contains(from), "{from}");
            good.replace(from, to)
        };
        for (text, expected) in [
            ("my notes".to_owned(), "is there, and is not the table of a sweep"),
            (other("\"until\":2.0", "\"until\":3.0"), "another sweep: it differs in until;"),
            (other("\"until\":2.0", "\"stop\":1"), "another sweep: it differs in until, stop;"),
            (other("mass,", "height,"), "its columns are others"),
            (other("\n3,80.0", "\n4,80.0"), "row 4: there is no point \"4\""),
            (other("60.0", "61.0"), "row 1: column mass: \"61.0\" is not the value of point 0"),
            (other("inf,ok", "inf,maybe"), "row 3: status \"maybe\""),
            (other(",x,", ",z,"), "its columns are others"),
            (other("\n0,60.0,", "\n0,"), "row 1: has 6 columns, not 7"),
        ] {
            std::fs::write(&path, &text).unwrap();
            let message = open(&path).err().unwrap().whole();
            assert!(message.contains(expected) && message.contains("sweep.csv"), "{message}");
            assert_eq!(std::fs::read_to_string(&path).unwrap(), text);
        }
    }
}
