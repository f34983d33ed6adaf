//! A file -> its rows.

use crate::page::Checked;
use crate::{COLUMNS, Cell, Kind, TableError};
use parquet::basic::{ConvertedType, LogicalType, Type as Physical};
use parquet::column::reader::{ColumnReader, ColumnReaderImpl, get_column_reader};
use parquet::data_type::{ByteArray, DataType};
use parquet::errors::{ParquetError, Result as Parquet};
use parquet::file::metadata::ParquetMetaData;
use parquet::file::reader::FileReader;
use parquet::file::serialized_reader::SerializedFileReader;
use parquet::schema::types::ColumnDescriptor;
use serde_json::{Map, Value};
use std::fs::File;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// Rows that are read together.
const BATCH: usize = 1 << 13;

/// Reads a table of whatever program.
pub struct Reader {
    file: SerializedFileReader<File>,
    columns: Vec<Found>,
}

/// A column that a file has.
#[derive(Debug, Clone, PartialEq)]
pub struct Found {
    /// Of a column within another one, both with a point between them.
    pub name: String,
    /// `None` for what is no number, no text and not true or false: times of day, lists, …
    pub kind: Option<Kind>,
    /// Whether values may be missing.
    pub optional: bool,
    about: Map<String, Value>,
}

impl Found {
    /// What is said of it under this key.
    pub fn about(&self, key: &str) -> Option<&str> {
        self.about.get(key)?.as_str()
    }
}

/// Some rows.
pub struct Batch {
    columns: Vec<Values>,
    rows: usize,
}

struct Values {
    data: Data,
    /// Of an optional column: where there is none.
    missing: Vec<bool>,
}

enum Data {
    Reals(Vec<f64>),
    Integers(Vec<i32>),
    Longs(Vec<i64>),
    Booleans(Vec<bool>),
    /// All of them UTF-8; equal ones share their bytes.
    Texts(Vec<ByteArray>),
}

impl Batch {
    /// How many there are.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Of the k-th column that was asked for.
    ///
    /// # Panics
    /// There is no such column, or no such row.
    pub fn cell(&self, k: usize, row: usize) -> Cell<'_> {
        let Values { data, missing } = &self.columns[k];
        if missing.get(row) == Some(&true) {
            return Cell::Missing;
        }
        match data {
            Data::Reals(values) => Cell::Real(values[row]),
            Data::Integers(values) => Cell::Integer(values[row]),
            Data::Longs(values) => Cell::Long(values[row]),
            Data::Booleans(values) => Cell::Boolean(values[row]),
            Data::Texts(values) => Cell::Text(values[row].as_utf8().unwrap_or_default()),
        }
    }

    /// All cells of a row, in the order of the columns that were asked for.
    ///
    /// # Panics
    /// There is no such row.
    pub fn row(&self, row: usize) -> impl Iterator<Item = Cell<'_>> {
        (0..self.columns.len()).map(move |k| self.cell(k, row))
    }
}

impl Reader {
    /// Of a file that is open for reading.
    ///
    /// # Errors
    /// It is no table in Parquet, or a damaged one.
    pub fn open(file: File) -> Result<Reader, TableError> {
        let length = file.metadata().map_err(|error| TableError::System(error.to_string()))?.len();
        let file = guarded(|| SerializedFileReader::new(file)).map_err(|fault| fault.after(0))?;
        check_places(file.metadata(), length).map_err(|why| Fault::Unsound(why).after(0))?;
        let said = said_of_columns(file.metadata());
        let columns = file.metadata().file_metadata().schema_descr().columns().iter().map(|column| {
            let name = column.path().string();
            let about = said.get(&name).and_then(Value::as_object).cloned().unwrap_or_default();
            let flat = column.path().parts().len() == 1 && column.max_rep_level() == 0;
            Found { name, kind: kind(column).filter(|_| flat), optional: column.max_def_level() > 0, about }
        });
        let columns = columns.collect();
        Ok(Reader { file, columns })
    }

    /// In the order of the file.
    pub fn columns(&self) -> &[Found] {
        &self.columns
    }

    /// The rows of these columns, in the order in which they are given here.
    ///
    /// # Panics
    /// There is no such column, or it has no kind.
    pub fn batches(&self, columns: &[usize]) -> Batches<'_> {
        for &place in columns {
            assert!(
                self.columns[place].kind.is_some(),
                "column {:?} cannot be read",
                self.columns[place].name
            );
        }
        Batches {
            reader: self,
            wanted: columns.to_vec(),
            group: 0,
            sources: None,
            rows: 0,
            done: columns.is_empty(),
        }
    }

    fn open_columns(&self, group: usize, wanted: &[usize]) -> Parquet<Vec<Source>> {
        let group = self.file.get_row_group(group)?;
        let open = |&place: &usize| {
            let column = self.file.metadata().file_metadata().schema_descr().column(place);
            let width = match column.physical_type() {
                Physical::BOOLEAN => 1,
                // A text has its length before it.
                Physical::INT32 | Physical::FLOAT | Physical::BYTE_ARRAY => 4,
                _ => 8,
            };
            let pages = Checked { pages: group.get_column_page_reader(place)?, width };
            let unsigned = self.columns[place].kind == Some(Kind::Long);
            Ok(Source { reader: get_column_reader(column, Box::new(pages)), unsigned })
        };
        wanted.iter().map(open).collect()
    }
}

/// The rows of a table, some thousands at a time. After an error there are no more.
pub struct Batches<'a> {
    reader: &'a Reader,
    wanted: Vec<usize>,
    /// The group of rows that is read, and how far.
    group: usize,
    sources: Option<Vec<Source>>,
    /// So far.
    rows: u64,
    done: bool,
}

impl Batches<'_> {
    fn advance(&mut self) -> Result<Option<Batch>, Fault> {
        let Reader { file, .. } = self.reader;
        loop {
            if let Some(sources) = &mut self.sources {
                let batch = guarded(|| read_batch(sources))?;
                if batch.rows > 0 {
                    self.rows += batch.rows as u64;
                    return Ok(Some(batch));
                }
                self.sources = None;
                self.group += 1;
            }
            if self.group == file.num_row_groups() {
                let said = file.metadata().file_metadata().num_rows();
                let all = u64::try_from(said) == Ok(self.rows);
                return if all {
                    Ok(None)
                } else {
                    Err(Fault::Unsound(format!("it says that it has {said} rows")))
                };
            }
            self.sources = Some(guarded(|| self.reader.open_columns(self.group, &self.wanted))?);
        }
    }
}

impl Iterator for Batches<'_> {
    type Item = Result<Batch, TableError>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.done {
            return None;
        }
        let next = self.advance();
        self.done = !matches!(next, Ok(Some(_)));
        next.map_err(|fault| fault.after(self.rows)).transpose()
    }
}

/// The crate panics at some broken files.
fn guarded<T>(what: impl FnOnce() -> Parquet<T>) -> Result<T, Fault> {
    match catch_unwind(AssertUnwindSafe(what)) {
        Ok(done) => done.map_err(|error| match error {
            ParquetError::NYI(what) => Fault::Unknown(what),
            ParquetError::General(what) if what.starts_with(UNBUILT) => {
                Fault::Unknown(what.replacen(UNBUILT, "compression", 1))
            }
            ParquetError::External(error) => Fault::Unsound(error.to_string()),
            error => Fault::Unsound(error.to_string()),
        }),
        Err(_) => Err(Fault::Unsound("it contradicts itself".into())),
    }
}

/// So the crate says that it was built without a way to compress.
const UNBUILT: &str = "Disabled feature at compile time:";

/// What is wrong with a file.
enum Fault {
    Unsound(String),
    /// It may be sound.
    Unknown(String),
}

impl Fault {
    fn after(self, rows: u64) -> TableError {
        match self {
            Fault::Unsound(why) => TableError::Unsound { rows, why },
            Fault::Unknown(what) => TableError::Unknown(what),
        }
    }
}

/// Whether the parts of a file lie in it: the crate panics where they begin or end before its start.
fn check_places(metadata: &ParquetMetaData, length: u64) -> Result<(), String> {
    for column in metadata.row_groups().iter().flat_map(|group| group.columns()) {
        let first = column.dictionary_page_offset().unwrap_or(column.data_page_offset());
        let inside = [first, column.data_page_offset(), column.compressed_size(), column.num_values()];
        let end = first.checked_add(column.compressed_size()).and_then(|end| u64::try_from(end).ok());
        if inside.iter().any(|number| *number < 0) || end.is_none_or(|end| end > length) {
            return Err(format!("column {}: lies outside of the file", column.column_path().string()));
        }
    }
    Ok(())
}

/// Nothing, if another program has something else under our key.
fn said_of_columns(metadata: &ParquetMetaData) -> Map<String, Value> {
    let all = metadata.file_metadata().key_value_metadata().map(Vec::as_slice).unwrap_or_default();
    let said = all.iter().find(|entry| entry.key == COLUMNS).and_then(|entry| entry.value.as_deref());
    said.and_then(|text| serde_json::from_str(text).ok()).unwrap_or_default()
}

fn kind(column: &ColumnDescriptor) -> Option<Kind> {
    let (logical, converted) = (column.logical_type_ref(), column.converted_type());
    let unmarked = logical.is_none() && converted == ConvertedType::NONE;
    let bits = match (logical, converted) {
        (Some(LogicalType::Integer(integer)), _) => Some((integer.bit_width, integer.is_signed)),
        (Some(_), _) => None,
        (None, ConvertedType::INT_8 | ConvertedType::INT_16 | ConvertedType::INT_32) => Some((32, true)),
        (None, ConvertedType::UINT_8 | ConvertedType::UINT_16) => Some((16, false)),
        (None, ConvertedType::UINT_32) => Some((32, false)),
        (None, ConvertedType::INT_64) => Some((64, true)),
        (None, _) => None,
    };
    match column.physical_type() {
        Physical::DOUBLE | Physical::FLOAT if unmarked => Some(Kind::Real),
        Physical::BOOLEAN if unmarked => Some(Kind::Boolean),
        Physical::INT32 if bits == Some((32, false)) => Some(Kind::Long),
        Physical::INT32 if unmarked || bits.is_some() => Some(Kind::Integer),
        Physical::INT64 if unmarked || bits.is_some_and(|(_, signed)| signed) => Some(Kind::Long),
        Physical::BYTE_ARRAY
            if logical == Some(&LogicalType::String)
                || (logical.is_none() && converted == ConvertedType::UTF8) =>
        {
            Some(Kind::Text)
        }
        _ => None,
    }
}

/// What comes next of a column.
struct Source {
    reader: ColumnReader,
    /// Its numbers of 32 bits have no sign.
    unsigned: bool,
}

/// Some rows of each column, as many as there are; none at the end of the group.
fn read_batch(sources: &mut [Source]) -> Parquet<Batch> {
    let columns = sources.iter_mut().map(values).collect::<Parquet<Vec<_>>>()?;
    let mut lengths = columns.iter().map(|values| values.data.len());
    let rows = lengths.next().unwrap_or(0);
    if lengths.any(|length| length != rows) {
        return Err(ParquetError::General("its columns are not equally long".into()));
    }
    Ok(Batch { columns, rows })
}

fn values(source: &mut Source) -> Parquet<Values> {
    use ColumnReader::*;
    let other = || Err(ParquetError::General("a column is of another type than it says".into()));
    let (data, missing) = match (&mut source.reader, source.unsigned) {
        (DoubleColumnReader(reader), _) => typed(reader, Data::Reals, Ok, 0.0)?,
        (FloatColumnReader(reader), _) => typed(reader, Data::Reals, |value| Ok(value.into()), 0.0)?,
        (Int32ColumnReader(reader), false) => typed(reader, Data::Integers, Ok, 0)?,
        (Int32ColumnReader(reader), true) => {
            typed(reader, Data::Longs, |value| Ok((value as u32).into()), 0)?
        }
        (Int64ColumnReader(reader), _) => typed(reader, Data::Longs, Ok, 0)?,
        (BoolColumnReader(reader), _) => typed(reader, Data::Booleans, Ok, false)?,
        (ByteArrayColumnReader(reader), _) => {
            // `ByteArray::default()` has no bytes at all, and must not be asked for them.
            let empty = ByteArray::from(Vec::new());
            typed(reader, Data::Texts, |bytes: ByteArray| bytes.as_utf8().map(|_| bytes.clone()), empty)?
        }
        _ => return other(),
    };
    Ok(Values { data, missing })
}

/// `none` stands where a value is missing.
fn typed<T: DataType, V: Clone>(
    reader: &mut ColumnReaderImpl<T>,
    data: impl Fn(Vec<V>) -> Data,
    of: impl Fn(T::T) -> Parquet<V>,
    none: V,
) -> Parquet<(Data, Vec<bool>)> {
    let (mut read, mut levels) = (Vec::new(), Vec::new());
    let mut rows = 0;
    while rows < BATCH {
        // To the end of a page at most.
        let (more, _, _) = reader.read_records(BATCH - rows, Some(&mut levels), None, &mut read)?;
        if more == 0 {
            break;
        }
        rows += more;
    }
    let missing: Vec<bool> = levels.iter().map(|level| *level == 0).collect();
    let mut read = read.into_iter();
    let mut next = || match read.next() {
        Some(value) => of(value),
        None => Err(ParquetError::EOF("values are missing".into())),
    };
    let all = (0..rows).map(|row| if missing.get(row) == Some(&true) { Ok(none.clone()) } else { next() });
    let all = all.collect::<Parquet<Vec<V>>>()?;
    Ok((data(all), missing))
}

impl Data {
    fn len(&self) -> usize {
        match self {
            Data::Reals(values) => values.len(),
            Data::Integers(values) => values.len(),
            Data::Longs(values) => values.len(),
            Data::Booleans(values) => values.len(),
            Data::Texts(values) => values.len(),
        }
    }
}
