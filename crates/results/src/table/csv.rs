//! Tables in CSV: SI units, numbers that read back to the same doubles.

use super::rows::{Cells, Frames, place};
use super::write::Rows;
use crate::cell::Cell;
use crate::columns::{self, Column};
use crate::error::RecordError;
use crate::record::Each;
use std::borrow::Cow;
use std::fmt::Write as _;
use std::io::{self, Read, Write};
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
    let ours = columns::named(&column.name).and_then(|quantity| quantity.unit);
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

    fn shown(&self, k: usize) -> String {
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

/// A table that is written.
pub(super) struct Writer<W: Write> {
    out: csv::Writer<W>,
    text: String,
}

impl<W: Write> Writer<W> {
    /// Begins a table, with the header only.
    pub fn create(file: W, columns: &[Column]) -> io::Result<Writer<W>> {
        let mut out = csv::Writer::from_writer(file);
        out.write_record(columns.iter().map(head_of))?;
        Ok(Writer { out, text: String::new() })
    }
}

impl<W: Write + Send> Rows<W> for Writer<W> {
    fn row(&mut self, cells: &mut dyn Iterator<Item = Cell<'_>>) -> io::Result<()> {
        for cell in cells {
            let text = &mut self.text;
            text.clear();
            let written = match cell {
                // It reads back to the same double.
                Cell::Real(value) => write!(text, "{value:?}"),
                Cell::Integer(value) => write!(text, "{value}"),
                Cell::Boolean(value) => write!(text, "{value}"),
                Cell::Text(value) => text.write_str(value),
            };
            written.map_err(io::Error::other)?;
            self.out.write_field(&*text)?;
        }
        Ok(self.out.write_record(None::<&[u8]>)?)
    }

    fn finish(self: Box<Self>) -> io::Result<W> {
        self.out.into_inner().map_err(csv::IntoInnerError::into_error)
    }
}
