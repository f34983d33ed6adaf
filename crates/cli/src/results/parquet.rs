//! A table as Parquet, which Arrow's readers see with units, variables and descriptions.

use super::{Cell, Column, Content, Extent, Kind, check_headings, check_kept};
use anyhow::{Context, Result, anyhow, bail};
use arrow_array::builder::{
    BooleanBuilder, Float64Builder, Int32Builder, StringBuilder, StringDictionaryBuilder,
};
use arrow_array::types::Int32Type;
use arrow_array::{ArrayRef, Float64Array, RecordBatch};
use arrow_schema::{DataType, Field, Schema, SchemaRef};
use crowd_mechanics::files::Staged;
use parquet::arrow::ArrowWriter;
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
use parquet::basic::{Compression, Encoding, ZstdLevel};
use parquet::file::metadata::KeyValue;
use parquet::file::properties::{EnabledStatistics, WriterProperties};
use parquet::schema::types::ColumnPath;
use std::collections::HashMap;
use std::fs::File;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::Arc;

/// Cells that a row group holds in memory before it is written, some 16 MB.
const GROUP: usize = 1 << 21;
/// Rows that go to Arrow together, at most.
const BATCH: usize = 1 << 13;

pub struct Table {
    out: ArrowWriter<Staged>,
    schema: SchemaRef,
    columns: Vec<Values>,
    rows: usize,
    /// Rows of a full batch.
    batch: usize,
}

/// Values of a column that are not yet written.
enum Values {
    Reals(Float64Builder),
    Integers(Int32Builder),
    Booleans(BooleanBuilder),
    Texts(StringBuilder),
    Labels(StringDictionaryBuilder<Int32Type>),
}

impl Values {
    fn new(kind: Kind) -> Values {
        match kind {
            Kind::Real => Values::Reals(Float64Builder::new()),
            Kind::Integer => Values::Integers(Int32Builder::new()),
            Kind::Boolean => Values::Booleans(BooleanBuilder::new()),
            Kind::Text => Values::Texts(StringBuilder::new()),
            Kind::Label => Values::Labels(StringDictionaryBuilder::new()),
        }
    }

    fn push(&mut self, cell: Cell<'_>) -> Result<()> {
        match (self, cell) {
            (Values::Reals(values), Cell::Real(value)) => values.append_value(value),
            (Values::Integers(values), Cell::Integer(value)) => values.append_value(value),
            (Values::Booleans(values), Cell::Boolean(value)) => values.append_value(value),
            (Values::Texts(values), Cell::Text(value)) => values.append_value(value),
            (Values::Labels(values), Cell::Text(value)) => values.append_value(value),
            (_, cell) => bail!("{cell:?} is not of the type of its column"),
        }
        Ok(())
    }

    fn take(&mut self) -> ArrayRef {
        match self {
            Values::Reals(values) => Arc::new(values.finish()),
            Values::Integers(values) => Arc::new(values.finish()),
            Values::Booleans(values) => Arc::new(values.finish()),
            Values::Texts(values) => Arc::new(values.finish()),
            Values::Labels(values) => Arc::new(values.finish()),
        }
    }
}

impl Table {
    /// Empty, or with the rows that a run before has written.
    pub fn create(file: Staged, content: &Content, path: &Path, kept: Option<Extent>) -> Result<Table> {
        let schema = Arc::new(Schema::new(content.columns.iter().map(field).collect::<Vec<_>>()));
        let group = (GROUP / content.columns.len()).max(1);
        let properties = properties(content, group)?;
        let mut out = ArrowWriter::try_new(file, schema.clone(), Some(properties))?;
        let batch = group.min(BATCH);
        if let Some(kept) = kept {
            copy(path, content, kept, &schema, batch, &mut out)?;
        }
        let columns = content.columns.iter().map(|column| Values::new(column.kind)).collect();
        Ok(Table { out, schema, columns, rows: 0, batch })
    }

    pub fn write<'a>(&mut self, cells: impl Iterator<Item = Cell<'a>>) -> Result<()> {
        for (column, cell) in self.columns.iter_mut().zip(cells) {
            column.push(cell)?;
        }
        self.rows += 1;
        if self.rows == self.batch { self.flush() } else { Ok(()) }
    }

    fn flush(&mut self) -> Result<()> {
        if self.rows > 0 {
            let columns = self.columns.iter_mut().map(Values::take).collect();
            self.out.write(&RecordBatch::try_new(self.schema.clone(), columns)?)?;
            self.rows = 0;
        }
        Ok(())
    }

    pub fn finish(mut self) -> Result<Staged> {
        self.flush()?;
        Ok(self.out.into_inner()?)
    }
}

fn field(column: &Column) -> Field {
    let kind = match column.kind {
        Kind::Real => DataType::Float64,
        Kind::Integer => DataType::Int32,
        Kind::Boolean => DataType::Boolean,
        Kind::Text => DataType::Utf8,
        Kind::Label => DataType::Dictionary(Box::new(DataType::Int32), Box::new(DataType::Utf8)),
    };
    let mut about = HashMap::from([
        ("variable".to_owned(), column.variable.clone()),
        ("description".to_owned(), column.description.clone()),
    ]);
    about.extend(column.unit.clone().map(|unit| ("unit".to_owned(), unit)));
    Field::new(&column.name, kind, false).with_metadata(about)
}

fn properties(content: &Content, group: usize) -> Result<WriterProperties> {
    let about = content.about.iter().map(|(key, value)| KeyValue::new((*key).to_owned(), value.clone()));
    let mut properties = WriterProperties::builder()
        .set_compression(Compression::ZSTD(ZstdLevel::try_new(3)?))
        .set_statistics_enabled(EnabledStatistics::Chunk)
        .set_offset_index_disabled(true)
        .set_max_row_group_row_count(Some(group))
        .set_key_value_metadata(Some(about.collect()));
    // Times repeat; other numbers hardly do, but their first bytes are alike.
    for column in content.columns.iter().skip(1).filter(|column| column.kind == Kind::Real) {
        let path = ColumnPath::new(vec![column.name.clone()]);
        properties = properties
            .set_column_dictionary_enabled(path.clone(), false)
            .set_column_encoding(path, Encoding::BYTE_STREAM_SPLIT);
    }
    Ok(properties.build())
}

/// The rows of the run before.
fn copy(
    path: &Path,
    content: &Content,
    kept: Extent,
    schema: &SchemaRef,
    batch: usize,
    to: &mut ArrowWriter<Staged>,
) -> Result<()> {
    // The crate panics at some broken files.
    let copied = AssertUnwindSafe(|| copy_sound(path, content, kept, schema, batch, to));
    catch_unwind(copied).unwrap_or_else(|_| Err(anyhow!("is no sound Parquet")))
}

fn copy_sound(
    path: &Path,
    content: &Content,
    kept: Extent,
    schema: &SchemaRef,
    batch: usize,
    to: &mut ArrowWriter<Staged>,
) -> Result<()> {
    let reader = ParquetRecordBatchReaderBuilder::try_new(File::open(path)?)?;
    let headings = reader.schema().fields().iter().map(|field| match field.metadata().get("unit") {
        Some(unit) => format!("{} [{unit}]", field.name()),
        None => field.name().clone(),
    });
    check_headings(headings, &content.columns)?;
    for (there, here) in reader.schema().fields().iter().zip(schema.fields()) {
        if there.data_type() != here.data_type() {
            bail!("column {:?} is of type {}, not {}", here.name(), there.data_type(), here.data_type());
        }
    }
    let (mut rows, mut last) = (0, None);
    for there in reader.with_batch_size(batch).build()? {
        let there = there?;
        let times = there.column(0).as_any().downcast_ref::<Float64Array>();
        last = times.and_then(|times| times.iter().next_back().flatten()).or(last);
        rows += there.num_rows() as u64;
        let ours = RecordBatch::try_new(schema.clone(), there.columns().to_vec());
        to.write(&ours?).context("the rows of the saved run cannot be copied")?;
    }
    check_kept(kept, rows, last)
}
