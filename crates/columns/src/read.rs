//! Reads the rows of a file.

use crate::header::{Headed, TAIL, check_footer};
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

/// Number of rows that are read together.
const BATCH: usize = 1 << 13;

/// Reads a table that any program may have written.
pub struct Reader {
    file: SerializedFileReader<Headed>,
    columns: Vec<Found>,
}

/// A column of a file.
#[derive(Debug, Clone, PartialEq)]
pub struct Found {
    /// Name; for a nested column the names on its path, joined by points.
    pub name: String,
    /// Type; `None` for values that are not numbers, texts or booleans, such as times and lists.
    pub kind: Option<Kind>,
    /// Whether values may be missing.
    pub optional: bool,
    about: Map<String, Value>,
}

impl Found {
    /// Returns the attribute with this key.
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
    /// For an optional column: whether each value is missing.
    missing: Vec<bool>,
}

enum Data {
    Reals(Vec<f64>),
    Integers(Vec<i32>),
    Longs(Vec<i64>),
    Booleans(Vec<bool>),
    /// All texts are UTF-8; equal ones share their bytes.
    Texts(Vec<ByteArray>),
}

impl Batch {
    /// Returns the number of rows.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Returns a value of the k-th requested column.
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

    /// Returns all values of a row, in the order of the requested columns.
    ///
    /// # Panics
    /// There is no such row.
    pub fn row(&self, row: usize) -> impl Iterator<Item = Cell<'_>> {
        (0..self.columns.len()).map(move |k| self.cell(k, row))
    }
}

impl Reader {
    /// Opens a table in a file that is open for reading.
    ///
    /// # Errors
    /// The file is not a table in Parquet, or it is damaged.
    pub fn open(file: File) -> Result<Reader, TableError> {
        let length = file.metadata().map_err(|error| TableError::System(error.to_string()))?.len();
        let open = || check_footer(&file).and_then(|()| SerializedFileReader::new(Headed(file)));
        let file = guarded(open).map_err(|fault| fault.after(0))?;
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

    /// Returns the text in the metadata of the file under a key.
    pub fn about(&self, key: &str) -> Option<&str> {
        said_of_table(self.file.metadata(), key)
    }

    /// Returns the columns, in the order of the file.
    pub fn columns(&self) -> &[Found] {
        &self.columns
    }

    /// Returns the rows of some columns, in the order given here.
    ///
    /// # Panics
    /// There is no such column, or its type is `None`.
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
                // The length of a text precedes it.
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

/// The rows of a table, some thousands at a time. After an error it ends.
pub struct Batches<'a> {
    reader: &'a Reader,
    wanted: Vec<usize>,
    /// The row group that is being read, and the number of its rows that were read.
    group: usize,
    sources: Option<Vec<Source>>,
    /// Number of rows that were read.
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
                    Err(Fault::Unsound(format!("its metadata says {said} rows")))
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

/// Catches panics: the `parquet` crate panics on some damaged files.
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
        Err(_) => Err(Fault::Unsound("it is inconsistent".into())),
    }
}

/// The message of the `parquet` crate when it was built without a compression method.
const UNBUILT: &str = "Disabled feature at compile time:";

/// What is wrong with a file.
enum Fault {
    Unsound(String),
    /// A feature that is not supported; the file may be valid.
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

/// Checks that the parts of a file lie inside it: the `parquet` crate panics if they begin or end before its start.
fn check_places(metadata: &ParquetMetaData, length: u64) -> Result<(), String> {
    for column in metadata.row_groups().iter().flat_map(|group| group.columns()) {
        let first = column.dictionary_page_offset().unwrap_or(column.data_page_offset());
        let inside = [first, column.data_page_offset(), column.compressed_size(), column.num_values()];
        let end = first.checked_add(column.compressed_size()).and_then(|end| u64::try_from(end).ok());
        if inside.iter().any(|number| *number < 0) || end.is_none_or(|end| end > length.saturating_sub(TAIL))
        {
            return Err(format!("column {}: is outside the file", column.column_path().string()));
        }
    }
    Ok(())
}

fn said_of_table<'a>(metadata: &'a ParquetMetaData, key: &str) -> Option<&'a str> {
    let all = metadata.file_metadata().key_value_metadata().map(Vec::as_slice).unwrap_or_default();
    all.iter().find(|entry| entry.key == key).and_then(|entry| entry.value.as_deref())
}

/// Attributes of columns; empty if another program uses our key for something else.
fn said_of_columns(metadata: &ParquetMetaData) -> Map<String, Value> {
    said_of_table(metadata, COLUMNS).and_then(|text| serde_json::from_str(text).ok()).unwrap_or_default()
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

/// The remaining values of a column.
struct Source {
    reader: ColumnReader,
    /// Whether its 32-bit integers are unsigned.
    unsigned: bool,
}

/// Reads some rows of each column, as many as possible; none at the end of the group.
fn read_batch(sources: &mut [Source]) -> Parquet<Batch> {
    let columns = sources.iter_mut().map(values).collect::<Parquet<Vec<_>>>()?;
    let mut lengths = columns.iter().map(|values| values.data.len());
    let rows = lengths.next().unwrap_or(0);
    if lengths.any(|length| length != rows) {
        return Err(ParquetError::General("its columns have different lengths".into()));
    }
    Ok(Batch { columns, rows })
}

fn values(source: &mut Source) -> Parquet<Values> {
    use ColumnReader::*;
    let other = || Err(ParquetError::General("a column has another type than its metadata says".into()));
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
            // `ByteArray::default()` has no bytes at all; reading it panics.
            let empty = ByteArray::from(Vec::new());
            typed(reader, Data::Texts, |bytes: ByteArray| bytes.as_utf8().map(|_| bytes.clone()), empty)?
        }
        _ => return other(),
    };
    Ok(Values { data, missing })
}

/// `none` replaces a missing value.
fn typed<T: DataType, V: Clone>(
    reader: &mut ColumnReaderImpl<T>,
    data: impl Fn(Vec<V>) -> Data,
    of: impl Fn(T::T) -> Parquet<V>,
    none: V,
) -> Parquet<(Data, Vec<bool>)> {
    let (mut read, mut levels) = (Vec::new(), Vec::new());
    let mut rows = 0;
    while rows < BATCH {
        // Reads to the end of a page at most.
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
