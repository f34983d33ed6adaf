//! Writes rows to a file.

use crate::{COLUMNS, Cell, Column, Kind, TableError};
use parquet::basic::{
    Compression, ConvertedType, Encoding, LogicalType, Repetition, Type as Physical, ZstdLevel,
};
use parquet::data_type::{BoolType, ByteArray, ByteArrayType, DoubleType, Int32Type, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::{EnabledStatistics, WriterProperties};
use parquet::file::writer::{SerializedColumnWriter, SerializedFileWriter};
use parquet::schema::types::{ColumnPath, Type};
use serde_json::{Map, Value};
use std::collections::{HashMap, HashSet};
use std::io::Write;
use std::sync::Arc;

/// Number of values that are kept in memory until they are written as a row group, about 16 MB.
const GROUP: usize = 1 << 21;
/// Number of texts of a column of which one shared copy is kept.
const KNOWN: usize = 1 << 14;

/// Writes a table. It is complete after [`Writer::finish`]. After an error it cannot be used any more.
pub struct Writer<W: Write + Send> {
    out: SerializedFileWriter<W>,
    columns: Vec<(Column, Values)>,
    /// Number of rows of a full group, and of the group in memory.
    group: usize,
    rows: usize,
}

/// Values that are not written yet.
struct Values {
    data: Data,
    /// For an optional column, for each row: 1 if there is a value, else 0.
    levels: Vec<i16>,
}

enum Data {
    Reals(Vec<f64>),
    Integers(Vec<i32>),
    Longs(Vec<i64>),
    Booleans(Vec<bool>),
    Texts { values: Vec<ByteArray>, known: HashMap<Box<str>, ByteArray> },
}

impl<W: Write + Send> Writer<W> {
    /// Creates an empty table with these columns. `about` is written into the metadata of the file.
    ///
    /// # Errors
    /// Two columns have the same name, or the file cannot be written.
    pub fn create(file: W, columns: &[Column], about: &[(&str, String)]) -> Result<Writer<W>, TableError> {
        let mut names = HashSet::new();
        if let Some(column) = columns.iter().find(|column| !names.insert(&column.name)) {
            return Err(TableError::Twice(column.name.clone()));
        }
        let fields = columns.iter().map(|column| Ok(Arc::new(field(column)?)));
        let fields = fields.collect::<Result<Vec<_>, ParquetError>>().map_err(system)?;
        let schema = Type::group_type_builder("schema").with_fields(fields).build().map_err(system)?;
        let properties = properties(columns, about).map_err(system)?;
        let out = SerializedFileWriter::new(file, Arc::new(schema), Arc::new(properties)).map_err(system)?;
        let columns: Vec<_> =
            columns.iter().map(|column| (column.clone(), Values::new(column.kind))).collect();
        let group = (GROUP / columns.len().max(1)).max(1);
        Ok(Writer { out, columns, group, rows: 0 })
    }

    /// Adds a row.
    ///
    /// # Errors
    /// A value does not fit its column, or the file cannot be written.
    pub fn row<'a>(&mut self, cells: impl IntoIterator<Item = Cell<'a>>) -> Result<(), TableError> {
        let mut cells = cells.into_iter();
        for (column, values) in &mut self.columns {
            let cell = cells.next().ok_or_else(|| TableError::Short(column.name.clone()))?;
            values.push(cell, column)?;
        }
        self.rows += 1;
        if self.rows == self.group { self.flush().map_err(system) } else { Ok(()) }
    }

    fn flush(&mut self) -> Result<(), ParquetError> {
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

    /// Completes the file and returns it.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn finish(mut self) -> Result<W, TableError> {
        self.flush().map_err(system)?;
        self.out.into_inner().map_err(system)
    }
}

impl Values {
    fn new(kind: Kind) -> Values {
        let data = match kind {
            Kind::Real => Data::Reals(Vec::new()),
            Kind::Integer => Data::Integers(Vec::new()),
            Kind::Long => Data::Longs(Vec::new()),
            Kind::Boolean => Data::Booleans(Vec::new()),
            Kind::Text => Data::Texts { values: Vec::new(), known: HashMap::new() },
        };
        Values { data, levels: Vec::new() }
    }

    fn push(&mut self, cell: Cell<'_>, column: &Column) -> Result<(), TableError> {
        let there = cell != Cell::Missing;
        match (&mut self.data, cell) {
            (Data::Reals(values), Cell::Real(value)) => values.push(value),
            (Data::Integers(values), Cell::Integer(value)) => values.push(value),
            (Data::Longs(values), Cell::Long(value)) => values.push(value),
            (Data::Booleans(values), Cell::Boolean(value)) => values.push(value),
            (Data::Texts { values, known }, Cell::Text(text)) => {
                // A copy of a `ByteArray` only counts references.
                let value = known.get(text).cloned().unwrap_or_else(|| {
                    let value = ByteArray::from(text.as_bytes().to_vec());
                    if known.len() < KNOWN {
                        known.insert(text.into(), value.clone());
                    }
                    value
                });
                values.push(value);
            }
            (_, Cell::Missing) if column.optional => {}
            _ => return Err(TableError::Cell { column: column.name.clone(), cell: format!("{cell:?}") }),
        }
        if column.optional {
            self.levels.push(there.into());
        }
        Ok(())
    }

    fn write(&mut self, column: &mut SerializedColumnWriter<'_>) -> Result<(), ParquetError> {
        let levels = (!self.levels.is_empty()).then_some(&self.levels[..]);
        match &mut self.data {
            Data::Reals(values) => {
                column.typed::<DoubleType>().write_batch(values, levels, None)?;
                values.clear();
            }
            Data::Integers(values) => {
                column.typed::<Int32Type>().write_batch(values, levels, None)?;
                values.clear();
            }
            Data::Longs(values) => {
                column.typed::<Int64Type>().write_batch(values, levels, None)?;
                values.clear();
            }
            Data::Booleans(values) => {
                column.typed::<BoolType>().write_batch(values, levels, None)?;
                values.clear();
            }
            Data::Texts { values, .. } => {
                column.typed::<ByteArrayType>().write_batch(values, levels, None)?;
                values.clear();
            }
        }
        self.levels.clear();
        Ok(())
    }
}

fn field(column: &Column) -> Result<Type, ParquetError> {
    let physical = match column.kind {
        Kind::Real => Physical::DOUBLE,
        Kind::Integer => Physical::INT32,
        Kind::Long => Physical::INT64,
        Kind::Boolean => Physical::BOOLEAN,
        Kind::Text => Physical::BYTE_ARRAY,
    };
    let text = column.kind == Kind::Text;
    Type::primitive_type_builder(&column.name, physical)
        .with_repetition(if column.optional { Repetition::OPTIONAL } else { Repetition::REQUIRED })
        .with_logical_type(text.then_some(LogicalType::String))
        .with_converted_type(if text { ConvertedType::UTF8 } else { ConvertedType::NONE })
        .build()
}

fn properties(columns: &[Column], about: &[(&str, String)]) -> Result<WriterProperties, ParquetError> {
    let mut metadata: Vec<KeyValue> =
        about.iter().map(|(key, value)| KeyValue::new((*key).to_owned(), value.clone())).collect();
    let said: Map<String, Value> = columns
        .iter()
        .filter(|column| !column.about.is_empty())
        .map(|column| {
            let about = column.about.iter().map(|(key, value)| ((*key).to_owned(), value.as_str().into()));
            (column.name.clone(), Value::Object(about.collect()))
        })
        .collect();
    if !said.is_empty() {
        metadata.push(KeyValue::new(COLUMNS.to_owned(), Value::Object(said).to_string()));
    }
    let mut properties = WriterProperties::builder()
        .set_compression(Compression::ZSTD(ZstdLevel::try_new(3)?))
        .set_statistics_enabled(EnabledStatistics::Chunk)
        .set_offset_index_disabled(true)
        .set_key_value_metadata((!metadata.is_empty()).then_some(metadata));
    for column in columns.iter().filter(|column| !column.repeats) {
        let path = ColumnPath::new(vec![column.name.clone()]);
        properties = properties.set_column_dictionary_enabled(path.clone(), false);
        if column.kind == Kind::Real {
            // Such numbers are rarely equal, but their first bytes are similar.
            properties = properties.set_column_encoding(path, Encoding::BYTE_STREAM_SPLIT);
        }
    }
    Ok(properties.build())
}

/// The error of a file that cannot be written.
fn system(error: ParquetError) -> TableError {
    match error {
        ParquetError::External(error) => TableError::System(error.to_string()),
        error => TableError::System(error.to_string()),
    }
}
