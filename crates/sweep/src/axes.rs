//! The values of parameters, as they are written.

use crate::error::{Error, Place, Result};
use crate::points::{MOST_POINTS, Points, Room, Values, too_many};
use lemons_core::files::input;
use serde::Deserialize;
use std::path::Path;

/// The values of an axis.
#[derive(Deserialize)]
#[serde(untagged)]
enum Axis {
    Integers(Vec<i64>),
    Reals(Vec<f64>),
    Texts(Vec<String>),
    Range(Range),
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Range {
    from: f64,
    to: f64,
    count: Option<u32>,
    #[serde(default)]
    spacing: Spacing,
}

#[derive(Deserialize, Default, PartialEq, Clone, Copy)]
#[serde(rename_all = "snake_case")]
enum Spacing {
    #[default]
    Linear,
    Logarithmic,
}

/// Largest number of values of a range.
const MOST_VALUES: u32 = 1_000_000;

/// The values of a parameter.
pub(crate) fn axis(value: toml::Value) -> Result<Values> {
    let expected = "expected a list of numbers or of texts, { from, to, count, spacing }, or { from, to } of whole numbers";
    Ok(match value.try_into::<Axis>().map_err(|_| Error::Spec(expected.into()))? {
        Axis::Integers(values) => Values::Integers(values),
        Axis::Reals(values) => {
            if let Some(value) = values.iter().find(|value| !value.is_finite()) {
                return Err(Error::Spec(format!("{value}: must be a finite number")));
            }
            Values::Reals(values)
        }
        Axis::Texts(values) => Values::Texts(values),
        Axis::Range(Range { from, to, count, spacing }) => {
            if !(from.is_finite() && to.is_finite()) {
                return Err(Error::Spec("from and to must be finite".into()));
            }
            let Some(count) = count else { return whole_numbers(from, to, spacing) };
            if !(2..=MOST_VALUES).contains(&count) {
                return Err(Error::Spec(format!("count = {count}: must be from 2 to {MOST_VALUES}")));
            }
            if spacing == Spacing::Logarithmic && !(from > 0.0 && to > 0.0) {
                return Err(Error::Spec("spacing = \"logarithmic\": from and to must be positive".into()));
            }
            let part = |k: u32| f64::from(k) / f64::from(count - 1);
            let (difference, ratio) = (to - from, to / from);
            let value = |k: u32| match (k, spacing) {
                (0, _) => from,
                (k, _) if k + 1 == count => to,
                (k, Spacing::Linear) if difference.is_finite() => from + part(k) * difference,
                (k, Spacing::Linear) => (1.0 - part(k)) * from + part(k) * to,
                (k, Spacing::Logarithmic) if ratio.is_normal() => from * ratio.powf(part(k)),
                (k, Spacing::Logarithmic) => from.powf(1.0 - part(k)) * to.powf(part(k)),
            };
            Values::Reals((0..count).map(value).collect())
        }
    })
}

/// All of them from one to another.
fn whole_numbers(from: f64, to: f64, spacing: Spacing) -> Result<Values> {
    let is_whole = |value: f64| value.fract() == 0.0 && value.abs() < 2f64.powi(53);
    if !(is_whole(from) && is_whole(to) && spacing == Spacing::Linear) {
        return Err(Error::Spec("count: is missing; without it, from and to must be whole numbers".into()));
    }
    if !(from <= to && to - from < f64::from(MOST_VALUES)) {
        return Err(Error::Spec(format!(
            "from = {from}, to = {to}: from must not be greater than to, and there are at most {MOST_VALUES} values"
        )));
    }
    Ok(Values::Integers((from as i64..=to as i64).collect()))
}

/// Reads a CSV with one row for each point. A column that contains only integers has integers; one with other numbers
/// has reals.
pub(crate) fn read_table(path: &Path) -> Result<Points> {
    let wrong = || path.display().to_string();
    let file = input::open_bounded(path, input::LARGEST_DRIVE).place(wrong)?;
    let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).comment(Some(b'#')).from_reader(file);
    let header: Vec<String> = reader.headers().place(wrong)?.iter().map(str::to_owned).collect();
    let mut cells: Vec<Vec<String>> = vec![Vec::new(); header.len()];
    let mut room = Room::new();
    for (count, row) in reader.records().enumerate() {
        let row = row.place(wrong)?;
        if count == MOST_POINTS {
            return Err(Error::Spec(too_many())).place(wrong);
        }
        for (column, cell) in cells.iter_mut().zip(&row) {
            room.take_text(cell, 1).map_err(Error::Spec).place(wrong)?;
            column.push(cell.to_owned());
        }
    }
    let columns = header.into_iter().zip(cells).map(|(name, cells)| {
        let values = column(cells).place(|| name.clone())?;
        Ok((name, values))
    });
    let columns = columns.collect::<Result<_>>().place(wrong)?;
    Points::table(columns).map_err(Error::Spec).place(wrong)
}

fn column(cells: Vec<String>) -> Result<Values> {
    // "007" is a text, not the number 7.
    let integer = |cell: &String| cell.parse().ok().filter(|value: &i64| value.to_string() == *cell);
    if let Some(values) = cells.iter().map(integer).collect() {
        return Ok(Values::Integers(values));
    }
    let padded = |cell: &String| cell.len() > 1 && cell.starts_with('0') && !cell.starts_with("0.");
    if cells.iter().any(padded) {
        return Ok(Values::Texts(cells));
    }
    let values: Vec<f64> = match cells.iter().map(|cell| cell.parse()).collect() {
        Ok(values) => values,
        Err(_) => return Ok(Values::Texts(cells)),
    };
    match values.iter().position(|value| !value.is_finite()) {
        Some(row) => Err(Error::Spec(format!("{}: must be a finite number (point {row})", cells[row]))),
        None => Ok(Values::Reals(values)),
    }
}
