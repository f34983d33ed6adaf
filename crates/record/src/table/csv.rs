//! Tables in CSV: SI units, numbers that read back to the same doubles.

use super::content::{Extent, check_headings, check_kept};
use super::digest::Digest;
use super::rows::{Builder, Head, Row, Stop, check_unit, heads, missing, read as read_row};
use crate::columns::{self, Column};
use crate::record::Each;
use lemons_columns::Cell;
use lemons_files::input;
use std::borrow::Cow;
use std::fmt::Write as _;
use std::io::{self, BufReader, BufWriter, Read, Seek, SeekFrom, Write};
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
    let ours =
        columns::all().find(|quantity| quantity.name == column.name).and_then(|quantity| quantity.unit);
    match (&column.unit, ours) {
        (Some(unit), Some(ours)) if unit != ours => format!("{} [{unit}]", column.name),
        _ => column.name.clone(),
    }
}

/// Where a column is.
fn place(header: &csv::StringRecord, (name, unit): Head) -> Result<usize, String> {
    let all = header.iter().map(name_and_unit).enumerate();
    let mut found = all.filter(|(_, head)| head.0 == name);
    let Some((place, (_, there))) = found.next() else {
        return Err(format!("line 1: {}", missing(name)));
    };
    if found.next().is_some() {
        return Err(format!("line 1: there are two columns {name:?}"));
    }
    check_unit(name, there, unit).map_err(|wrong| format!("line 1: {wrong}"))?;
    Ok(place)
}

/// Reads all frames and returns the Ids of the agents.
pub(super) fn read(file: impl Read, each: &mut Each<'_>) -> Result<Vec<String>, Stop> {
    let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(file);
    let header = reader.headers().map_err(broken)?.clone();
    let (groups, heads) = heads(|name| header.iter().any(|head| name_and_unit(head).0 == name));
    let places = heads.iter().map(|head| place(&header, *head)).collect::<Result<Vec<usize>, String>>()?;
    let mut builder = Builder::new("line");
    let mut record = csv::StringRecord::new();
    while reader.read_record(&mut record).map_err(broken)? {
        let line = record.position().map_or(0, csv::Position::line);
        let row = Line { line, record: &record, places: &places, heads: &heads };
        let seen = read_row(&row, groups)?;
        if let Some(frame) = builder.add(line, row.real(0)?, &row.id()?, seen)? {
            each(frame)?;
        }
    }
    let (last, ids) = builder.finish()?;
    each(last)?;
    Ok(ids)
}

/// A row, and where its line is in the file.
struct Line<'a> {
    line: u64,
    record: &'a csv::StringRecord,
    places: &'a [usize],
    heads: &'a [Head],
}

impl Line<'_> {
    fn text(&self, k: usize) -> &str {
        &self.record[self.places[k]]
    }

    fn wrong<T>(&self, k: usize, what: &str) -> Result<T, String> {
        Err(format!("line {}: column {}: {:?} is not {what}", self.line, self.heads[k].0, self.text(k)))
    }
}

impl Row for Line<'_> {
    fn id(&self) -> Result<Cow<'_, str>, String> {
        Ok(self.text(1).into())
    }

    fn real(&self, k: usize) -> Result<f64, String> {
        let value = self.text(k).parse().ok().filter(|value: &f64| value.is_finite());
        value.map_or_else(|| self.wrong(k, "a finite number"), Ok)
    }

    fn count(&self, k: usize) -> Result<u32, String> {
        self.text(k).parse().or_else(|_| self.wrong(k, "a valid number of contacts"))
    }

    fn size(&self, k: usize, what: &str) -> Result<f64, String> {
        let value = self.text(k).parse().ok().filter(|value| *value >= 0.0 && f64::is_finite(*value));
        value.map_or_else(|| self.wrong(k, &format!("a valid {what}")), Ok)
    }
}

fn broken(error: csv::Error) -> String {
    match error.kind() {
        csv::ErrorKind::UnequalLengths { pos, expected_len, len } => {
            let line = pos.as_ref().map_or(0, csv::Position::line);
            format!("line {line}: has {len} columns, the header {expected_len}")
        }
        csv::ErrorKind::Utf8 { pos, err } => {
            let line = pos.as_ref().map_or(0, csv::Position::line);
            format!("line {line}: column {}: is not UTF-8 text", err.field() + 1)
        }
        _ => error.to_string(),
    }
}

/// A table that is written.
pub(super) struct Writer<W: Write> {
    out: csv::Writer<Digested<W>>,
    text: String,
}

/// A file, and the digest of its bytes.
struct Digested<W: Write> {
    file: BufWriter<W>,
    digest: Digest,
}

impl<W: Write> Digested<W> {
    fn new(file: W) -> Digested<W> {
        Digested { file: BufWriter::new(file), digest: Digest::new() }
    }
}

impl<W: Write> Write for Digested<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.file.write(bytes)?;
        self.digest.add(&bytes[..written]);
        Ok(written)
    }

    /// The file is flushed when the table is complete; [`Writer::row`] only wants the digest.
    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl<W: Write> Writer<W> {
    /// With the header only.
    pub fn create(file: W, columns: &[Column]) -> io::Result<Writer<W>> {
        let mut out = csv::Writer::from_writer(Digested::new(file));
        out.write_record(columns.iter().map(head_of)).map_err(system)?;
        Ok(Writer { out, text: String::new() })
    }

    /// Byte for byte what was written before.
    pub fn resume(file: W, columns: &[Column], path: &Path, kept: Extent) -> Result<Writer<W>, String> {
        let mut out = Digested::new(file);
        copy(path, columns, kept, &mut out)?;
        Ok(Writer { out: csv::Writer::from_writer(out), text: String::new() })
    }

    pub fn row<'a>(&mut self, cells: impl Iterator<Item = Cell<'a>>) -> io::Result<()> {
        for cell in cells {
            let text = &mut self.text;
            text.clear();
            let written = match cell {
                // It reads back to the same double.
                Cell::Real(value) => write!(text, "{value:?}"),
                Cell::Integer(value) => write!(text, "{value}"),
                Cell::Long(value) => write!(text, "{value}"),
                Cell::Boolean(value) => write!(text, "{value}"),
                Cell::Text(value) => text.write_str(value),
                Cell::Missing => Ok(()),
            };
            written.map_err(io::Error::other)?;
            self.out.write_field(&*text).map_err(system)?;
        }
        self.out.write_record(None::<&[u8]>).map_err(system)?;
        self.out.flush()
    }

    /// Of all rows, and of the header.
    pub fn digest(&self) -> u128 {
        self.out.get_ref().digest.value()
    }

    pub fn finish(self) -> io::Result<W> {
        let written = self.out.into_inner().map_err(|error| error.into_error())?;
        written.file.into_inner().map_err(|error| error.into_error())
    }
}

fn system(error: csv::Error) -> io::Error {
    if !error.is_io_error() {
        return io::Error::other(error);
    }
    match error.into_kind() {
        csv::ErrorKind::Io(error) => error,
        other => io::Error::other(format!("{other:?}")),
    }
}

/// Copies the table that was written before, if it is that one.
fn copy<W: Write>(path: &Path, columns: &[Column], kept: Extent, to: &mut Digested<W>) -> Result<(), String> {
    let said = |error: io::Error| error.to_string();
    let mut file = input::open(path).map_err(said)?;
    let mut reader = csv::Reader::from_reader(BufReader::new(&file));
    let headings = reader.headers().map_err(broken)?.iter().map(str::to_owned);
    check_headings(headings, columns.iter().map(head_of))?;
    let (mut row, mut rows, mut last) = (csv::ByteRecord::new(), 0, None);
    while reader.read_byte_record(&mut row).map_err(broken)? {
        rows += 1;
        // Only the last one matters.
        if rows >= kept.rows {
            last = std::str::from_utf8(&row[0]).ok().and_then(|text| text.parse().ok());
        }
    }
    // What it is by its rows; its bytes are seen when they are copied.
    check_kept(kept, Extent { rows, last, digest: kept.digest })?;
    drop(reader);
    file.seek(SeekFrom::End(-1)).map_err(said)?;
    let mut end = [0];
    file.read_exact(&mut end).map_err(said)?;
    if end != *b"\n" {
        return Err("its last row does not end with its line".into());
    }
    let copied = file.seek(SeekFrom::Start(0)).and_then(|_| io::copy(&mut file, to));
    copied.map_err(|error| format!("its rows cannot be copied: {error}"))?;
    check_kept(kept, Extent { rows, last, digest: to.digest.value() })
}
