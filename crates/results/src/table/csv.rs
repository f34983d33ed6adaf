//! Tables in CSV: SI units, numbers that read back to the same doubles.

use super::format::Rows;
use super::rows::{Cells, Frames, place};
use crate::cell::Cell;
use crate::columns::{self, Column};
use crate::error::RecordError;
use crate::number;
use crate::record::Each;
use std::borrow::Cow;
use std::fmt::Write as _;
use std::io::{self, BufWriter, Read, Write};
use std::path::Path;

/// The name and the unit in the head of a column: `x`, or `x [m]`.
fn name_and_unit(head: &str) -> (&str, Option<&str>) {
    let head = head.trim_start_matches('\u{feff}');
    match head.strip_suffix(']').and_then(|head| head.rsplit_once('[')) {
        Some((name, unit)) => (name.trim_end(), Some(unit)),
        None => (head, None),
    }
}

/// The head of a column. It has a unit only if this is not the one of our table of columns.
fn head_of(column: &Column) -> String {
    let ours = columns::with_name(&column.name).and_then(|quantity| quantity.unit);
    match (&column.unit, ours) {
        (Some(unit), Some(ours)) if unit != ours => format!("{} [{unit}]", column.name),
        _ => column.name.clone(),
    }
}

/// Reads all frames and returns the Ids of the agents.
pub(super) fn read(path: &Path, file: impl Read, each: &mut Each<'_>) -> Result<Vec<String>, RecordError> {
    let broken = |error| RecordError::wrong(path, described(error));
    let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(file);
    let header = reader.headers().map_err(broken)?.clone();
    let exists = |name: &str| header.iter().any(|head| name_and_unit(head).0 == name);
    let mut frames = Frames::new(path, exists, "line", each);
    let places = frames.heads().into_iter().map(|head| place(header.iter().map(name_and_unit), head));
    let places = places.collect::<Result<Vec<usize>, _>>();
    let places = places.map_err(|wrong| RecordError::wrong(path, format!("line 1: {wrong}")))?;
    let mut record = csv::StringRecord::new();
    while reader.read_record(&mut record).map_err(broken)? {
        let line = record.position().map_or(0, csv::Position::line);
        frames.add(line, &Line { record: &record, places: &places })?;
    }
    frames.finish()
}

struct Line<'a> {
    record: &'a csv::StringRecord,
    places: &'a [usize],
}

impl Cells for Line<'_> {
    fn id(&self) -> Cow<'_, str> {
        self.record[self.places[1]].into()
    }

    fn number(&self, k: usize) -> f64 {
        self.record[self.places[k]].parse().unwrap_or(f64::NAN)
    }

    fn text(&self, k: usize) -> String {
        format!("{:?}", &self.record[self.places[k]])
    }
}

fn described(error: csv::Error) -> String {
    let line = error.position().map_or(0, csv::Position::line);
    match error.kind() {
        csv::ErrorKind::UnequalLengths { expected_len, len, .. } => {
            format!("line {line}: has {len} columns, the header {expected_len}")
        }
        csv::ErrorKind::Utf8 { err, .. } => {
            format!("line {line}: column {}: is not UTF-8 text", err.field() + 1)
        }
        _ => error.to_string(),
    }
}

/// \[byte\] What is kept in memory before it goes to the file.
const BUFFER: usize = 1 << 16;

/// A table that is written.
pub(super) struct Writer<W: Write> {
    out: BufWriter<W>,
    line: String,
    /// Number of columns.
    columns: usize,
}

impl<W: Write> Writer<W> {
    /// Begins a table, with the header only.
    pub fn create(file: W, columns: &[Column]) -> io::Result<Writer<W>> {
        let heads: Vec<String> = columns.iter().map(head_of).collect();
        let out = BufWriter::with_capacity(BUFFER, file);
        let mut writer = Writer { out, line: String::new(), columns: columns.len() };
        put(&mut writer.line, &mut heads.iter().map(|head| Cell::Text(head)));
        writer.out.write_all(writer.line.as_bytes())?;
        Ok(writer)
    }
}

impl<W: Write + Send> Rows<W> for Writer<W> {
    fn row(&mut self, cells: &mut dyn Iterator<Item = Cell<'_>>) -> io::Result<()> {
        let cells = put(&mut self.line, cells);
        if cells != self.columns {
            return Err(io::Error::other(format!("a row of {cells} cells in {} columns", self.columns)));
        }
        self.out.write_all(self.line.as_bytes())
    }

    fn finish(self: Box<Self>) -> io::Result<W> {
        self.out.into_inner().map_err(io::IntoInnerError::into_error)
    }
}

/// Puts a row in the place of the line before, and returns the number of its cells. It is not generic, so that it is
/// compiled (and optimised) in this crate.
fn put(line: &mut String, cells: &mut dyn Iterator<Item = Cell<'_>>) -> usize {
    line.clear();
    let mut count = 0;
    for cell in cells {
        count += 1;
        match cell {
            Cell::Real(value) => number::put(line, value),
            Cell::Integer(value) => _ = write!(line, "{value}"),
            Cell::Boolean(value) => _ = write!(line, "{value}"),
            Cell::Text(value) if value.contains([',', '"', '\r', '\n']) => {
                line.extend(["\"", &value.replace('"', "\"\""), "\""]);
            }
            Cell::Text(value) => line.push_str(value),
        }
        line.push(',');
    }
    line.pop();
    line.push('\n');
    count
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_is_that_of_the_package_csv() {
        let texts = ["7", "", "a, b", "\"", "say \"no\"", "two\nlines", "\r", " ß ", "#;\t'"];
        let mut line = String::new();
        let mut theirs = csv::Writer::from_writer(Vec::new());
        for text in texts {
            let (real, integer) = (0.25, -3);
            put(
                &mut line,
                &mut [Cell::Text(text), Cell::Real(real), Cell::Integer(integer), Cell::Boolean(true)]
                    .into_iter(),
            );
            theirs.write_record([text, "0.25", "-3", "true"]).unwrap();
            theirs.flush().unwrap();
            assert!(theirs.get_ref().ends_with(line.as_bytes()), "{line:?} {:?}", theirs.get_ref());
        }
    }
}
