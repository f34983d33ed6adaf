//! Tables in Parquet, with units, variables and descriptions in the metadata: under the key `columns`, as
//! JSON, `{"x": {"unit": "m"}}`.

use super::format::Content;
use super::rows::{self, Frames, Stop, Wanted, place};
use crate::cell::{Cell, Kind};
use crate::columns::{Column, ID};
use crate::record::Each;
use parquet::basic::{
    Compression, ConvertedType, Encoding, LogicalType, Repetition, Type as Physical, ZstdLevel,
};
use parquet::column::reader::{ColumnReader, ColumnReaderImpl};
use parquet::data_type::{BoolType, ByteArray, ByteArrayType, DataType, DoubleType, Int32Type};
use parquet::errors::{ParquetError, Result as Parquet};
use parquet::file::metadata::{KeyValue, ParquetMetaData};
use parquet::file::properties::{EnabledStatistics, WriterProperties};
use parquet::file::reader::{FileReader, RowGroupReader};
use parquet::file::serialized_reader::SerializedFileReader;
use parquet::file::writer::{SerializedColumnWriter, SerializedFileWriter};
use parquet::schema::types::{ColumnDescriptor, ColumnPath, Type};
use serde_json::{Map, Value, json};
use std::borrow::Cow;
use std::collections::HashSet;
use std::fs::File;
use std::io::{self, Write};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;

/// Key in the metadata of a file for attributes of columns.
const COLUMNS: &str = "columns";
/// Number of values that are kept in memory until they are written as a row group, about 16 MB.
const GROUP: usize = 1 << 21;
/// Number of rows that are decoded together.
const BATCH: usize = 1 << 13;

/// Reads all frames and returns the Ids of the agents.
pub(super) fn read(file: File, each: &mut Each<'_>) -> Result<Vec<String>, Stop> {
    let reader = guarded(|| SerializedFileReader::new(file))?;
    let metadata = reader.metadata();
    let attributes = attributes_of_columns(metadata);
    let columns = metadata.file_metadata().schema_descr().columns();
    let names: Vec<String> = columns.iter().map(|column| column.path().string()).collect();
    let heads = || {
        let unit = |name: &String| attributes.get(name).and_then(|own| own["unit"].as_str());
        names.iter().map(move |name| (name.as_str(), unit(name)))
    };
    let wanted = Wanted::among(|name| names.iter().any(|known| known == name));
    let mut places = Vec::new();
    for head in wanted.heads() {
        let place = place(heads(), head)?;
        check_type(&columns[place], head)?;
        places.push(place);
    }
    let mut frames = Frames::new(&wanted, "row");
    let mut before = 0;
    for group in 0..reader.num_row_groups() {
        let columns = guarded(|| {
            let group = reader.get_row_group(group)?;
            places.iter().map(|&place| read_column(&*group, place)).collect::<Parquet<Vec<Values>>>()
        })?;
        for (values, (name, _)) in columns.iter().zip(wanted.heads()) {
            if let Some(row) = values.missing {
                return Err(
                    format!("row {}: column {name}: there is no value", before + 1 + row as u64).into()
                );
            }
        }
        let rows = columns.iter().map(Values::len).min().unwrap_or(0);
        if columns.iter().any(|values| values.len() != rows) {
            return Err(format!("{INVALID}: its columns have different lengths").into());
        }
        for row in 0..rows {
            if let Some(frame) = frames.add(before + 1 + row as u64, &Row { columns: &columns, row })? {
                each(frame)?;
            }
        }
        before += rows as u64;
    }
    let (last, ids) = frames.finish()?;
    each(last)?;
    Ok(ids)
}

const INVALID: &str = "is not valid Parquet";

/// Catches panics: the `parquet` crate panics on some damaged files.
fn guarded<T>(what: impl FnOnce() -> Parquet<T>) -> Result<T, String> {
    /// The message of a build without a method of compression.
    const UNBUILT: &str = "Disabled feature at compile time:";
    let unknown = |what: String| format!("is Parquet with a feature that is not supported: {what}");
    match catch_unwind(AssertUnwindSafe(what)) {
        Ok(done) => done.map_err(|error| match error {
            ParquetError::NYI(what) => unknown(what),
            ParquetError::General(what) if what.starts_with(UNBUILT) => {
                unknown(what.replacen(UNBUILT, "compression", 1))
            }
            error => format!("{INVALID}: {error}"),
        }),
        Err(_) => Err(format!("{INVALID}: it is inconsistent")),
    }
}

/// Attributes of columns; empty if another program uses our key for something else.
fn attributes_of_columns(metadata: &ParquetMetaData) -> Map<String, Value> {
    let all = metadata.file_metadata().key_value_metadata().map(Vec::as_slice).unwrap_or_default();
    let text = all.iter().find(|entry| entry.key == COLUMNS).and_then(|entry| entry.value.as_deref());
    text.and_then(|text| serde_json::from_str(text).ok()).unwrap_or_default()
}

/// Whether a column has values of a type that its name allows.
fn check_type(column: &ColumnDescriptor, (name, unit): rows::Head) -> Result<(), String> {
    let (logical, converted) = (column.logical_type_ref(), column.converted_type());
    let unmarked = logical.is_none() && converted == ConvertedType::NONE;
    // Counts of other tools may be unsigned. Those of more than 31 or 63 bits are negative here, and refused as such.
    let integer = match logical {
        Some(LogicalType::Integer(_)) => true,
        Some(_) => false,
        None => matches!(
            converted,
            ConvertedType::NONE
                | ConvertedType::INT_8
                | ConvertedType::INT_16
                | ConvertedType::INT_32
                | ConvertedType::INT_64
                | ConvertedType::UINT_8
                | ConvertedType::UINT_16
                | ConvertedType::UINT_32
                | ConvertedType::UINT_64
        ),
    };
    let flat = column.path().parts().len() == 1 && column.max_rep_level() == 0;
    let physical = column.physical_type();
    let real = flat && unmarked && matches!(physical, Physical::DOUBLE | Physical::FLOAT);
    let whole = flat && integer && matches!(physical, Physical::INT32 | Physical::INT64);
    let text = flat
        && physical == Physical::BYTE_ARRAY
        && (logical == Some(&LogicalType::String) || converted == ConvertedType::UTF8);
    let (good, holds) = match (name, unit) {
        // Other tools make numbers of Ids that look like some.
        (ID, _) => (text || whole, "neither texts nor whole numbers"),
        (_, None) => (whole, "no whole numbers"),
        (_, Some(_)) => (real || whole, "no numbers"),
    };
    if good { Ok(()) } else { Err(format!("column {name}: holds {holds}")) }
}

/// The values of a column in a row group.
struct Values {
    data: Data,
    /// The first row without a value.
    missing: Option<usize>,
}

enum Data {
    Reals(Vec<f64>),
    Wholes(Vec<i64>),
    /// All are UTF-8; equal ones share their bytes.
    Texts(Vec<ByteArray>),
}

impl Values {
    fn len(&self) -> usize {
        match &self.data {
            Data::Reals(values) => values.len(),
            Data::Wholes(values) => values.len(),
            Data::Texts(values) => values.len(),
        }
    }
}

fn read_column(group: &dyn RowGroupReader, place: usize) -> Parquet<Values> {
    match group.get_column_reader(place)? {
        ColumnReader::DoubleColumnReader(reader) => values(reader, Data::Reals, Ok),
        ColumnReader::FloatColumnReader(reader) => values(reader, Data::Reals, |value| Ok(value.into())),
        ColumnReader::Int32ColumnReader(reader) => values(reader, Data::Wholes, |value| Ok(value.into())),
        ColumnReader::Int64ColumnReader(reader) => values(reader, Data::Wholes, Ok),
        ColumnReader::ByteArrayColumnReader(reader) => {
            values(reader, Data::Texts, |bytes| bytes.as_utf8().map(|_| bytes.clone()))
        }
        _ => Err(ParquetError::General("a column has another type than its metadata says".into())),
    }
}

fn values<T: DataType, V>(
    mut reader: ColumnReaderImpl<T>,
    data: impl Fn(Vec<V>) -> Data,
    of: impl Fn(T::T) -> Parquet<V>,
) -> Parquet<Values> {
    let (mut read, mut levels) = (Vec::new(), Vec::new());
    // Reads to the end of a page at most.
    while reader.read_records(BATCH, Some(&mut levels), None, &mut read)?.0 > 0 {}
    let missing = levels.iter().position(|level| *level == 0);
    Ok(Values { data: data(read.into_iter().map(of).collect::<Parquet<_>>()?), missing })
}

struct Row<'a> {
    columns: &'a [Values],
    row: usize,
}

impl rows::Row for Row<'_> {
    fn id(&self) -> Cow<'_, str> {
        match &self.columns[1].data {
            Data::Texts(values) => values[self.row].as_utf8().unwrap_or_default().into(),
            _ => self.shown(1).into(),
        }
    }

    fn number(&self, k: usize) -> f64 {
        match &self.columns[k].data {
            Data::Reals(values) => values[self.row],
            Data::Wholes(values) => values[self.row] as f64,
            Data::Texts(_) => f64::NAN,
        }
    }

    fn shown(&self, k: usize) -> String {
        match &self.columns[k].data {
            Data::Reals(values) => format!("{:?}", values[self.row]),
            Data::Wholes(values) => values[self.row].to_string(),
            Data::Texts(values) => format!("{:?}", values[self.row].as_utf8().unwrap_or_default()),
        }
    }
}

/// A table that is written.
pub(super) struct Writer<W: Write + Send> {
    out: SerializedFileWriter<W>,
    columns: Vec<(String, Pending)>,
    /// Number of rows of a full group, and of the group in memory.
    group: usize,
    rows: usize,
}

/// Values that are not written yet.
enum Pending {
    Reals(Vec<f64>),
    Integers(Vec<i32>),
    Booleans(Vec<bool>),
    Texts(Vec<ByteArray>),
}

impl<W: Write + Send> Writer<W> {
    /// Without rows.
    pub fn create(file: W, content: &Content) -> io::Result<Writer<W>> {
        let mut names = HashSet::new();
        if let Some(twice) = content.columns.iter().find(|column| !names.insert(&column.name)) {
            return Err(io::Error::other(format!("there are two columns {:?}", twice.name)));
        }
        let fields = content.columns.iter().map(|column| Ok(Arc::new(field(column)?)));
        let schema =
            Type::group_type_builder("schema").with_fields(fields.collect::<Parquet<_>>()?).build()?;
        let out = SerializedFileWriter::new(file, Arc::new(schema), Arc::new(properties(content)?))?;
        let pending = |column: &Column| (column.name.clone(), Pending::of(column.kind));
        let columns: Vec<_> = content.columns.iter().map(pending).collect();
        let group = (GROUP / columns.len().max(1)).max(1);
        Ok(Writer { out, columns, group, rows: 0 })
    }

    pub fn row<'a>(&mut self, mut cells: impl Iterator<Item = Cell<'a>>) -> io::Result<()> {
        for (name, values) in &mut self.columns {
            let cell = cells.next();
            match (values, cell) {
                (Pending::Reals(values), Some(Cell::Real(value))) => values.push(value),
                (Pending::Integers(values), Some(Cell::Integer(value))) => values.push(value),
                (Pending::Booleans(values), Some(Cell::Boolean(value))) => values.push(value),
                (Pending::Texts(values), Some(Cell::Text(text))) => values.push(text.into()),
                _ => {
                    let message = format!("column {name}: the value {cell:?} has the wrong type");
                    return Err(io::Error::other(message));
                }
            }
        }
        self.rows += 1;
        if self.rows == self.group { self.flush() } else { Ok(()) }
    }

    fn flush(&mut self) -> io::Result<()> {
        if self.rows == 0 {
            return Ok(());
        }
        let mut group = self.out.next_row_group()?;
        for (_, values) in &mut self.columns {
            let Some(mut column) = group.next_column()? else { break };
            values.write(&mut column)?;
            column.close()?;
        }
        group.close()?;
        self.rows = 0;
        Ok(())
    }

    pub fn finish(mut self) -> io::Result<W> {
        self.flush()?;
        Ok(self.out.into_inner()?)
    }
}

impl Pending {
    fn of(kind: Kind) -> Pending {
        match kind {
            Kind::Real => Pending::Reals(Vec::new()),
            Kind::Integer => Pending::Integers(Vec::new()),
            Kind::Boolean => Pending::Booleans(Vec::new()),
            Kind::Text => Pending::Texts(Vec::new()),
        }
    }

    fn write(&mut self, column: &mut SerializedColumnWriter<'_>) -> Parquet<()> {
        fn all<T: DataType>(values: &mut Vec<T::T>, column: &mut SerializedColumnWriter<'_>) -> Parquet<()> {
            column.typed::<T>().write_batch(values, None, None)?;
            values.clear();
            Ok(())
        }
        match self {
            Pending::Reals(values) => all::<DoubleType>(values, column),
            Pending::Integers(values) => all::<Int32Type>(values, column),
            Pending::Booleans(values) => all::<BoolType>(values, column),
            Pending::Texts(values) => all::<ByteArrayType>(values, column),
        }
    }
}

fn field(column: &Column) -> Parquet<Type> {
    let physical = match column.kind {
        Kind::Real => Physical::DOUBLE,
        Kind::Integer => Physical::INT32,
        Kind::Boolean => Physical::BOOLEAN,
        Kind::Text => Physical::BYTE_ARRAY,
    };
    let text = column.kind == Kind::Text;
    Type::primitive_type_builder(&column.name, physical)
        .with_repetition(Repetition::REQUIRED)
        .with_logical_type(text.then_some(LogicalType::String))
        .with_converted_type(if text { ConvertedType::UTF8 } else { ConvertedType::NONE })
        .build()
}

fn properties(content: &Content) -> Parquet<WriterProperties> {
    let about = content.about.iter().map(|(key, value)| KeyValue::new((*key).to_owned(), value.clone()));
    let attributes = content.columns.iter().map(|column| {
        let mut own = json!({ "variable": column.variable, "description": column.description });
        if let Some(unit) = &column.unit {
            own["unit"] = unit.as_str().into();
        }
        (column.name.clone(), own)
    });
    let attributes = Value::Object(attributes.collect()).to_string();
    let metadata = about.chain([KeyValue::new(COLUMNS.to_owned(), attributes)]);
    let mut properties = WriterProperties::builder()
        .set_compression(Compression::ZSTD(ZstdLevel::try_new(3)?))
        .set_statistics_enabled(EnabledStatistics::Chunk)
        .set_offset_index_disabled(true)
        .set_key_value_metadata(Some(metadata.collect()));
    // Times occur many times; other numbers are rarely equal, but their first bytes are similar.
    for column in content.columns.iter().skip(1).filter(|column| column.kind == Kind::Real) {
        let path = ColumnPath::new(vec![column.name.clone()]);
        properties = properties
            .set_column_dictionary_enabled(path.clone(), false)
            .set_column_encoding(path, Encoding::BYTE_STREAM_SPLIT);
    }
    Ok(properties.build())
}
