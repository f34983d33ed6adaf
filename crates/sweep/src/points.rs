//! The points of a sweep: each has a value of every parameter; and the values of parameters, as `sweep.toml` has them.

use crate::error::{ErrorPlace, Result};
use lemons_core::files::input;
use lemons_core::require;
use serde::Deserialize;
use sha1_smol::Sha1;
use std::path::Path;

/// A parameter of a sweep.
#[derive(Debug, Clone, PartialEq)]
pub struct SweepParameter {
    /// Its name.
    pub name: String,
    /// Its different values, as text that is read back as the same number.
    values: Vec<String>,
    /// How many points one after the other have the same value.
    repeat: usize,
}

/// The points of a sweep.
#[derive(Debug, Clone, PartialEq)]
pub struct Points {
    /// Parameters that vary.
    pub parameters: Vec<SweepParameter>,
    /// Number of points.
    pub count: usize,
}

/// The parameter that names a directory where a crowd writes files.
pub(crate) const OUTPUT_DIRECTORY: &str = "OutputDirectory";

/// A larger number of points is taken for a mistake.
const MOST_POINTS: usize = 10_000_000;
/// \[byte\] Largest size of a table of points.
const LARGEST_TABLE: u64 = 200_000_000;

impl SweepParameter {
    /// Returns the value at a point.
    pub fn at(&self, point: usize) -> &str {
        &self.values[self.place(point)]
    }

    /// Returns the place of the value at a point among all values.
    pub fn place(&self, point: usize) -> usize {
        point / self.repeat % self.values.len()
    }

    /// Returns all values that points have.
    pub fn values(&self) -> &[String] {
        &self.values
    }
}

impl Points {
    /// Returns the points that write files themselves, with their directories.
    pub fn output_directories(&self) -> impl Iterator<Item = (usize, &str)> {
        let is_directory = |name: &str| name.strip_prefix("crowd.").unwrap_or(name) == OUTPUT_DIRECTORY;
        let parameter = self.parameters.iter().find(|parameter| is_directory(&parameter.name));
        let all = parameter
            .into_iter()
            .flat_map(|parameter| (0..self.count).map(|point| (point, parameter.at(point))));
        all.filter(|(_, directory)| !directory.is_empty())
    }

    /// Returns a parameter by its name.
    pub(crate) fn parameter(&self, name: &str) -> Option<&SweepParameter> {
        self.parameters.iter().find(|parameter| parameter.name == name)
    }

    /// Returns all combinations of values. The last parameter varies fastest.
    ///
    /// # Errors
    /// A parameter has no values, or there are too many points.
    pub fn grid(axes: Vec<(String, Vec<String>)>) -> Result<Points, String> {
        let mut count = 1_usize;
        for (name, values) in &axes {
            require(!values.is_empty(), || format!("{name}: no values"))?;
            count = count.checked_mul(values.len()).filter(|n| *n <= MOST_POINTS).ok_or_else(too_many)?;
        }
        let mut repeat = count;
        let parameters = axes.into_iter().map(|(name, values)| {
            repeat /= values.len();
            SweepParameter { name, values, repeat }
        });
        Ok(Points { parameters: parameters.collect(), count })
    }

    /// Reads a CSV with one row for each point. A column of integers, or of other numbers, has numbers; any other one has
    /// texts.
    ///
    /// # Errors
    /// The file cannot be read, or has no points, too many, or a number that is not finite.
    pub(crate) fn read(path: &Path) -> Result<Points> {
        Points::read_table(path).place(|| path.display().to_string())
    }

    fn read_table(path: &Path) -> Result<Points> {
        let file = input::open_bounded(path, LARGEST_TABLE)?;
        let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).comment(Some(b'#')).from_reader(file);
        let header: Vec<String> = reader.headers()?.iter().map(str::to_owned).collect();
        let mut columns: Vec<Vec<String>> = vec![Vec::new(); header.len()];
        for (row, count) in reader.records().zip(1..) {
            columns.iter_mut().zip(&row?).for_each(|(column, cell)| column.push(cell.to_owned()));
            require(count <= MOST_POINTS, too_many)?;
        }
        let empty = columns.first().is_none_or(Vec::is_empty);
        require(!empty, || "there are no points")?;
        let columns = header.into_iter().zip(columns).map(|(name, cells)| {
            let values = normalized(cells).place(|| name.clone())?;
            Ok((name, values))
        });
        Ok(Points::of_rows(columns.collect::<Result<_>>()?))
    }

    /// Returns one point for each row of columns of the same length.
    pub fn of_rows(columns: Vec<(String, Vec<String>)>) -> Points {
        let count = columns.first().map_or(0, |(_, values)| values.len());
        let columns = columns.into_iter();
        let parameters = columns.map(|(name, values)| SweepParameter { name, values, repeat: 1 }).collect();
        Points { parameters, count }
    }

    /// Returns the SHA-1 of the names and all values.
    pub fn sha1(&self) -> String {
        let mut digest = Sha1::new();
        for SweepParameter { name, values, repeat } in &self.parameters {
            digest.update(format!("{name:?} {repeat} {values:?}").as_bytes());
        }
        digest.digest().to_string()
    }
}

/// Returns the cells of a column, its numbers as they are written everywhere else.
fn normalized(cells: Vec<String>) -> Result<Vec<String>, String> {
    // "007" is a text, not the number 7.
    let is_padded = |cell: &String| cell.len() > 1 && cell.starts_with('0') && !cell.starts_with("0.");
    let is_integer = |cell: &String| cell.parse().is_ok_and(|value: i64| value.to_string() == *cell);
    if cells.iter().all(is_integer) || cells.iter().any(is_padded) {
        return Ok(cells);
    }
    let Some(numbers) = cells.iter().map(|cell| cell.parse().ok()).collect::<Option<Vec<f64>>>() else {
        return Ok(cells);
    };
    match numbers.iter().position(|number| !number.is_finite()) {
        Some(row) => Err(format!("{}: must be a finite number (point {row})", cells[row])),
        None => Ok(numbers.iter().map(|number| format!("{number:?}")).collect()),
    }
}

fn too_many() -> String {
    format!("there are more than {MOST_POINTS} points")
}

/// The values of a parameter.
#[derive(Deserialize)]
#[serde(
    untagged,
    expecting = "expected a list of numbers or of texts, { from, to, count, spacing }, or { from, to } of whole numbers"
)]
pub(crate) enum Axis {
    Integers(Vec<i64>),
    Reals(Vec<f64>),
    Texts(Vec<String>),
    Range(Range),
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Range {
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

impl Axis {
    /// Returns the values as text.
    ///
    /// # Errors
    /// A sentence: a number is not finite, or the range has no such values.
    pub(crate) fn values(self) -> Result<Vec<String>, String> {
        let reals = match self {
            Axis::Integers(values) => return Ok(values.iter().map(i64::to_string).collect()),
            Axis::Texts(values) => return Ok(values),
            Axis::Range(Range { from, to, count: None, spacing }) => return whole_numbers(from, to, spacing),
            Axis::Range(Range { from, to, count: Some(count), spacing }) => range(from, to, count, spacing)?,
            Axis::Reals(values) => match values.iter().find(|value| !value.is_finite()) {
                Some(value) => return Err(format!("{value}: must be a finite number")),
                None => values,
            },
        };
        Ok(reals.iter().map(|value| format!("{value:?}")).collect())
    }
}

fn range(from: f64, to: f64, count: u32, spacing: Spacing) -> Result<Vec<f64>, String> {
    require(from.is_finite() && to.is_finite(), || NOT_FINITE.to_owned())?;
    let possible = (2..=MOST_VALUES).contains(&count);
    require(possible, || format!("count = {count}: must be from 2 to {MOST_VALUES}"))?;
    let positive = spacing == Spacing::Linear || from > 0.0 && to > 0.0;
    require(positive, || "spacing = \"logarithmic\": from and to must be positive".to_owned())?;
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
    Ok((0..count).map(value).collect())
}

const NOT_FINITE: &str = "from and to must be finite";

/// Returns all whole numbers from one to another.
fn whole_numbers(from: f64, to: f64, spacing: Spacing) -> Result<Vec<String>, String> {
    require(from.is_finite() && to.is_finite(), || NOT_FINITE.to_owned())?;
    let is_whole = |value: f64| value.fract() == 0.0 && value.abs() < 2f64.powi(53);
    let whole = is_whole(from) && is_whole(to) && spacing == Spacing::Linear;
    require(whole, || "count: is missing; without it, from and to must be whole numbers".to_owned())?;
    require(from <= to && to - from < f64::from(MOST_VALUES), || {
        format!(
            "from = {from}, to = {to}: from must not be greater than to, and there are at most {MOST_VALUES} values"
        )
    })?;
    Ok((from as i64..=to as i64).map(|value| value.to_string()).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texts(values: &[&str]) -> Vec<String> {
        values.iter().map(|value| (*value).to_owned()).collect()
    }

    #[test]
    fn the_last_name_varies_fastest() {
        let axes = vec![("a".to_owned(), texts(&["1.0", "2.0"])), ("b".to_owned(), texts(&["x", "y", "z"]))];
        let points = Points::grid(axes).unwrap();
        let all: Vec<String> = (0..points.count)
            .map(|point| points.parameters.iter().map(|parameter| parameter.at(point)).collect())
            .collect();
        assert_eq!(all, ["1.0x", "1.0y", "1.0z", "2.0x", "2.0y", "2.0z"]);
        let long = || ("a".to_owned(), vec!["1".to_owned(); 5000]);
        assert!(Points::grid(vec![long(), long()]).unwrap_err().contains("more than"));
    }

    #[test]
    fn numbers_of_a_table_are_normalized_and_finite() {
        let directory = tempfile::TempDir::new().unwrap();
        let path = directory.path().join("points.csv");
        let read = |text: &str| {
            std::fs::write(&path, text).unwrap();
            let points = Points::read(&path).map_err(|error| error.whole());
            points.map(|points| points.parameters[0].values().join(" "))
        };
        for (cells, values) in [
            ("1\n2", "1 2"),
            ("70.50\n1e-3", "70.5 0.001"),
            ("007\n8", "007 8"),
            ("none\n1.50", "none 1.50"),
            ("2\n1e300", "2.0 1e300"),
        ] {
            assert_eq!(read(&format!("Mass\n{cells}\n")).unwrap(), values);
        }
        for cell in ["nan", "-NaN", "inf", "+Infinity", "1e999"] {
            let error = read(&format!("Mass,Other\n70.5,1\n{cell},2\n")).unwrap_err();
            let message = format!("points.csv: Mass: {cell}: must be a finite number (point 1)");
            assert!(error.ends_with(&message), "{error}");
        }
        assert!(read("Mass\n").unwrap_err().ends_with("points.csv: there are no points"));
    }
}
