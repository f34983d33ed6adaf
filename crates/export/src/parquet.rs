//! The table that `lemons run --format parquet` writes.

use crate::table::{Builder, COLUMNS, OBSERVED, check_unit};
use crate::{Observed, Run};
use arrow_array::cast::AsArray;
use arrow_array::types::{Float32Type, Float64Type, Int32Type, Int64Type, UInt32Type};
use arrow_array::{Array, ArrayRef};
use arrow_schema::{DataType, Schema};
use crowd_mechanics::engine::{Vec2, vec2};
use crowd_mechanics::trial::AgentDynamics;
use parquet::arrow::ProjectionMask;
use parquet::arrow::arrow_reader::{
    ArrowReaderMetadata, ArrowReaderOptions, ParquetRecordBatchReaderBuilder,
};
use parquet::errors::ParquetError;
use parquet::file::metadata::ParquetMetaData;
use std::fs::File;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

/// Rows that are read together.
const BATCH: usize = 1 << 13;

type Wanted = (&'static str, Option<&'static str>);

pub(crate) fn read(path: &Path, file: File) -> Result<Run, String> {
    // The crate still panics at some broken files.
    let read = AssertUnwindSafe(|| read_sound(path, file));
    catch_unwind(read).unwrap_or_else(|_| Err("is no sound Parquet".into()))
}

/// Whether the parts of a file lie in it: `parquet` panics where they begin or end before its start.
fn check_places(metadata: &ParquetMetaData, length: u64) -> Result<(), String> {
    let columns = metadata.row_groups().iter().flat_map(|group| group.columns());
    for column in columns {
        let first = column.dictionary_page_offset().unwrap_or(column.data_page_offset());
        let inside = [first, column.data_page_offset(), column.compressed_size(), column.num_values()];
        let end = first.checked_add(column.compressed_size()).and_then(|end| u64::try_from(end).ok());
        if inside.iter().any(|number| *number < 0) || end.is_none_or(|end| end > length) {
            let name = column.column_path().string();
            return Err(format!("is no sound Parquet: column {name}: lies outside of the file"));
        }
    }
    Ok(())
}

fn read_sound(path: &Path, file: File) -> Result<Run, String> {
    let broken = |error: ParquetError| format!("is no sound Parquet: {error}");
    // As Parquet has it: what Arrow made of it elsewhere (dictionaries, views) does not matter.
    let options = ArrowReaderOptions::new().with_skip_arrow_metadata(true);
    let metadata = ArrowReaderMetadata::load(&file, options).map_err(broken)?;
    let length = file.metadata().map_err(|error| format!("cannot be read: {error}"))?.len();
    check_places(metadata.metadata(), length)?;
    let fields = metadata.schema().clone();
    let has = |name: &str| fields.fields().iter().any(|field| field.name() == name);
    let mut wanted: Vec<Wanted> = COLUMNS.to_vec();
    if OBSERVED.iter().all(|(name, _)| has(name)) {
        wanted.extend(OBSERVED);
    }
    // Units are known to Arrow only.
    let arrow = ArrowReaderMetadata::load(&file, ArrowReaderOptions::new()).map_err(broken)?;
    let places = wanted.iter().map(|column| place(&fields, arrow.schema(), *column));
    let places = places.collect::<Result<Vec<usize>, String>>()?;

    let reader = ParquetRecordBatchReaderBuilder::new_with_metadata(file, metadata);
    let mask = ProjectionMask::roots(reader.parquet_schema(), places.iter().copied());
    let reader = reader.with_projection(mask).with_batch_size(BATCH).build().map_err(broken)?;
    let mut builder = Builder::new("row");
    let mut before = 0;
    for batch in reader {
        let batch = batch.map_err(|error| format!("after row {before}: is no sound Parquet: {error}"))?;
        // The reader has them in the order of the file.
        let columns = wanted.iter().map(|(name, _)| {
            let column = batch.column_by_name(name).ok_or_else(|| format!("column {name}: is missing"))?;
            match column.is_nullable().then(|| (0..column.len()).find(|&k| column.is_null(k))).flatten() {
                Some(k) => Err(format!("row {}: column {name}: there is no value", before + 1 + k as u64)),
                None => Ok(column),
            }
        });
        let columns = columns.collect::<Result<Vec<&ArrayRef>, String>>()?;
        let ids = texts(columns[1]).ok_or("column id: holds neither texts nor whole numbers")?;
        let number = |k: usize, row: usize, name: &str| {
            let value = real(columns[k], row).ok_or_else(|| format!("column {name}: holds no numbers"))?;
            let wrong =
                || format!("row {}: column {name}: {value:?} is no finite number", before + 1 + row as u64);
            if value.is_finite() { Ok(value) } else { Err(wrong()) }
        };
        let count = |k: usize, row: usize| {
            let name = wanted[k].0;
            let value =
                whole(columns[k], row).ok_or_else(|| format!("column {name}: holds no whole numbers"))?;
            let wrong = |_| {
                format!("row {}: column {name}: {value} is no number of contacts", before + 1 + row as u64)
            };
            u32::try_from(value).map_err(wrong)
        };
        for (row, id) in ids.iter().enumerate() {
            let real = |k: usize| number(k, row, wanted[k].0);
            let agent = AgentDynamics {
                position: vec2(real(2)?, real(3)?),
                velocity: vec2(real(4)?, real(5)?),
                theta: real(6)?,
                omega: real(7)?,
                fp: Vec2::ZERO,
                mp: 0.0,
            };
            let n = before + 1 + row as u64;
            let seen = (wanted.len() > COLUMNS.len()).then(|| {
                let normal_force = real(11)?;
                if normal_force < 0.0 {
                    return Err(format!(
                        "row {n}: column normal_force: {normal_force:?} is no squeeze in newtons"
                    ));
                }
                Ok(Observed {
                    agent_contacts: count(8, row)?,
                    wall_contacts: count(9, row)?,
                    contacting_agents: count(10, row)?,
                    normal_force,
                })
            });
            builder.add(n, real(0)?, id, (agent, seen.transpose()?))?;
        }
        before += batch.num_rows() as u64;
    }
    builder.finish(path)
}

/// Where a column is.
fn place(fields: &Schema, arrow: &Schema, (name, unit): Wanted) -> Result<usize, String> {
    let mut found = fields.fields().iter().enumerate().filter(|(_, field)| field.name() == name);
    let place = match (found.next(), found.next()) {
        (Some((place, _)), None) => place,
        (Some(_), Some(_)) => return Err(format!("there are two columns {name:?}")),
        (None, _) => {
            let names = COLUMNS.map(|(name, _)| name).join(", ");
            return Err(format!("there is no column {name:?} (lemons run writes {names})"));
        }
    };
    let there = arrow.fields().get(place).and_then(|field| field.metadata().get("unit"));
    check_unit(name, there.map(String::as_str), unit)?;
    Ok(place)
}

fn real(column: &ArrayRef, row: usize) -> Option<f64> {
    match column.data_type() {
        DataType::Float64 => Some(column.as_primitive::<Float64Type>().value(row)),
        DataType::Float32 => Some(column.as_primitive::<Float32Type>().value(row).into()),
        DataType::Int32 => Some(column.as_primitive::<Int32Type>().value(row).into()),
        _ => None,
    }
}

fn whole(column: &ArrayRef, row: usize) -> Option<i64> {
    match column.data_type() {
        DataType::Int32 => Some(column.as_primitive::<Int32Type>().value(row).into()),
        DataType::Int64 => Some(column.as_primitive::<Int64Type>().value(row)),
        DataType::UInt32 => Some(column.as_primitive::<UInt32Type>().value(row).into()),
        _ => None,
    }
}

/// Ids: other tools make numbers of them that look like some.
fn texts(column: &ArrayRef) -> Option<Vec<String>> {
    let rows = 0..column.len();
    match column.data_type() {
        DataType::Utf8 => {
            let values = column.as_string::<i32>();
            Some(rows.map(|row| values.value(row).to_owned()).collect())
        }
        DataType::Int32 | DataType::Int64 | DataType::UInt32 => {
            rows.map(|row| whole(column, row).map(|id| id.to_string())).collect()
        }
        _ => None,
    }
}
