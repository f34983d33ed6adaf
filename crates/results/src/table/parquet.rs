//! Tables in Parquet, with units, variables and descriptions in the metadata: under the key `columns`, as
//! JSON, `{"x": {"unit": "m"}}`.

use super::format::{Rows, TableContent};
use super::rows::{Cells, Frames, Head, place};
use crate::cell::{Cell, CellType};
use crate::columns::{Column, ID};
use crate::error::RecordError;
use crate::record::Each;
use parquet::basic::{
    Compression, ConvertedType, Encoding, LogicalType, Repetition, Type as Physical, ZstdLevel,
};
use parquet::data_type::{BoolType, ByteArray, ByteArrayType, DataType, DoubleType, Int32Type};
use parquet::errors::Result as Parquet;
use parquet::file::metadata::{KeyValue, ParquetMetaData};
use parquet::file::properties::{EnabledStatistics, WriterProperties};
use parquet::file::reader::FileReader;
use parquet::file::serialized_reader::SerializedFileReader;
use parquet::file::writer::{SerializedColumnWriter, SerializedFileWriter};
use parquet::record::Field;
use parquet::schema::types::{ColumnPath, Type};
use serde_json::{Map, Value, json};
use std::borrow::Cow;
use std::collections::HashSet;
use std::fs::File;
use std::io::{self, Write};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::Arc;

/// Key in the metadata of a file for attributes of columns.
const COLUMNS: &str = "columns";
/// Number of values that are kept in memory until they are written as a row group, about 16 MB.
const GROUP: usize = 1 << 21;

/// Reads all frames and returns the Ids of the agents.
pub(super) fn read(path: &Path, file: File, each: &mut Each<'_>) -> Result<Vec<String>, RecordError> {
    let wrong = |message: String| RecordError::wrong(path, message);
    let reader = guarded(|| SerializedFileReader::new(file)).map_err(wrong)?;
    let metadata = reader.metadata();
    let attributes = attributes_of_columns(metadata);
    let columns = metadata.file_metadata().schema().get_fields();
    let heads = || {
        columns.iter().map(|column| {
            let own = attributes.get(column.name());
            (column.name(), own.and_then(|own| own["unit"].as_str()))
        })
    };
    let exists = |name: &str| columns.iter().any(|column| column.name() == name);
    let mut frames = Frames::new(path, exists, "row", each);
    let mut fields = Vec::new();
    for head in frames.heads() {
        let column = &columns[place(heads(), head).map_err(wrong)?];
        check_type(column, head).map_err(wrong)?;
        fields.push(column.clone());
    }
    let schema = Type::group_type_builder(metadata.file_metadata().schema().name()).with_fields(fields);
    let mut rows = guarded(|| reader.get_row_iter(Some(schema.build()?))).map_err(wrong)?;
    let mut count = 0;
    while let Some(row) = guarded(|| rows.next().transpose()).map_err(wrong)? {
        count += 1;
        let row = Row(row.into_columns());
        if let Some((name, _)) = row.0.iter().find(|(_, value)| *value == Field::Null) {
            return Err(wrong(format!("row {count}: column {name}: there is no value")));
        }
        frames.add(count, &row)?;
    }
    frames.finish()
}

/// Catches panics: the `parquet` crate panics on some damaged files.
fn guarded<T>(what: impl FnOnce() -> Parquet<T>) -> Result<T, String> {
    let done = catch_unwind(AssertUnwindSafe(what)).map_err(|_| "it is inconsistent".to_owned());
    let read = done.and_then(|done| done.map_err(|error| error.to_string()));
    read.map_err(|error| format!("cannot be read as Parquet: {error}"))
}

/// Attributes of columns; empty if another program uses our key for something else.
fn attributes_of_columns(metadata: &ParquetMetaData) -> Map<String, Value> {
    let all = metadata.file_metadata().key_value_metadata().map(Vec::as_slice).unwrap_or_default();
    let text = all.iter().find(|entry| entry.key == COLUMNS).and_then(|entry| entry.value.as_deref());
    text.and_then(|text| serde_json::from_str(text).ok()).unwrap_or_default()
}

/// Checks that a column has values of a type that its name allows.
fn check_type(column: &Type, (name, unit): Head) -> Result<(), String> {
    let physical = column.is_primitive().then(|| column.get_physical_type());
    let logical = column.get_basic_info().logical_type_ref();
    let unmarked = logical.is_none();
    let whole = matches!(physical, Some(Physical::INT32 | Physical::INT64))
        && (unmarked || matches!(logical, Some(LogicalType::Integer(_))));
    let real = matches!(physical, Some(Physical::DOUBLE | Physical::FLOAT)) && unmarked;
    let text = physical == Some(Physical::BYTE_ARRAY) && (unmarked || logical == Some(&LogicalType::String));
    let (good, holds) = match (name, unit) {
        // Other tools make numbers of Ids that look like some.
        (ID, _) => (text || whole, "neither texts nor whole numbers"),
        (_, None) => (whole, "no whole numbers"),
        (_, Some(_)) => (real || whole, "no numbers"),
    };
    if good { Ok(()) } else { Err(format!("column {name}: holds {holds}")) }
}

struct Row(Vec<(String, Field)>);

impl Cells for Row {
    fn id(&self) -> Cow<'_, str> {
        match &self.0[1].1 {
            Field::Str(id) => id.into(),
            other => other.to_string().into(),
        }
    }

    fn number(&self, k: usize) -> f64 {
        match &self.0[k].1 {
            Field::Double(value) => *value,
            Field::Float(value) => f64::from(*value),
            Field::Int(value) => f64::from(*value),
            // Other whole numbers.
            other => other.to_string().parse().unwrap_or(f64::NAN),
        }
    }

    fn text(&self, k: usize) -> String {
        match &self.0[k].1 {
            Field::Double(value) => format!("{value:?}"),
            Field::Float(value) => format!("{value:?}"),
            other => other.to_string(),
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
    /// Begins a table without rows.
    pub fn create(file: W, content: &TableContent) -> io::Result<Writer<W>> {
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
}

impl<W: Write + Send> Rows<W> for Writer<W> {
    fn row(&mut self, cells: &mut dyn Iterator<Item = Cell<'_>>) -> io::Result<()> {
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

    fn finish(mut self: Box<Self>) -> io::Result<W> {
        self.flush()?;
        Ok(self.out.into_inner()?)
    }
}

impl Pending {
    fn of(kind: CellType) -> Pending {
        match kind {
            CellType::Real => Pending::Reals(Vec::new()),
            CellType::Integer => Pending::Integers(Vec::new()),
            CellType::Boolean => Pending::Booleans(Vec::new()),
            CellType::Text => Pending::Texts(Vec::new()),
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
        CellType::Real => Physical::DOUBLE,
        CellType::Integer => Physical::INT32,
        CellType::Boolean => Physical::BOOLEAN,
        CellType::Text => Physical::BYTE_ARRAY,
    };
    let text = column.kind == CellType::Text;
    Type::primitive_type_builder(&column.name, physical)
        .with_repetition(Repetition::REQUIRED)
        .with_logical_type(text.then_some(LogicalType::String))
        .with_converted_type(if text { ConvertedType::UTF8 } else { ConvertedType::NONE })
        .build()
}

fn properties(content: &TableContent) -> Parquet<WriterProperties> {
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
    for column in content.columns.iter().skip(1).filter(|column| column.kind == CellType::Real) {
        let path = ColumnPath::new(vec![column.name.clone()]);
        properties = properties
            .set_column_dictionary_enabled(path.clone(), false)
            .set_column_encoding(path, Encoding::BYTE_STREAM_SPLIT);
    }
    Ok(properties.build())
}
