//! Reads `sweep.toml`.

use crate::error::{Error, Place, Result};
use crate::measure::Measure;
use crate::points::{MOST_POINTS, OUTPUT_DIRECTORY, Points, Room, Values, too_many};
use lemons_files::input;
use lemons_master::Kind;
use lemons_trial::DriveChoice;
use serde::Deserialize;
use std::collections::HashSet;
use std::path::{Path, PathBuf};

/// Model, parameters and measures of a sweep. Relative paths are relative to the directory of the file.
#[derive(Debug, Clone)]
pub struct Spec {
    /// A Trial directory or an FMU.
    pub model: PathBuf,
    /// If `model` is a temporary FMU of a Trial: the Trial as the user knows it, for messages.
    pub trial: Option<PathBuf>,
    /// \[s\] End time.
    pub until: f64,
    /// \[s\] Communication step; `None`: that of the Trial.
    pub step: Option<f64>,
    /// The forces that drive people.
    pub drive: DriveChoice,
    /// The points that are simulated.
    pub points: Points,
    /// Names and measures, in the order of the file.
    pub measures: Vec<(String, Measure)>,
    /// The files that are read.
    pub inputs: Vec<PathBuf>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Document {
    trial: Option<PathBuf>,
    fmu: Option<PathBuf>,
    until: f64,
    step: Option<f64>,
    drive: Option<DriveText>,
    parameters: Option<toml::Table>,
    table: Option<PathBuf>,
    measures: toml::Table,
}

#[derive(Deserialize)]
#[serde(untagged)]
enum DriveText {
    Switch(bool),
    File(PathBuf),
}

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
    count: u32,
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

/// Names that the table uses itself.
const RESERVED: [&str; 3] = ["point", "status", "error"];
/// Largest number of values of a range.
const MOST_VALUES: u32 = 1_000_000;

impl Spec {
    /// Reads a `sweep.toml`.
    ///
    /// # Errors
    /// A sentence with the key and what is wrong.
    pub fn read(path: &Path) -> Result<Spec> {
        Kind::expect(path, &[Kind::Text, Kind::Stream], "a sweep.toml (lemons sweep --help)")
            .map_err(lemons_master::Error::from)?;
        let text = input::read_given_text(path, input::LARGEST_SETTINGS)
            .place(|| format!("cannot read {}", path.display()))?;
        let directory =
            path.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
        Self::from_toml(&text, directory).place(|| path.display().to_string())
    }

    /// Reads the text of a `sweep.toml` in a directory.
    ///
    /// # Errors
    /// A sentence with the key and what is wrong.
    pub fn from_toml(text: &str, directory: &Path) -> Result<Spec> {
        let document: Document = toml::from_str(text)?;
        let model = match (document.trial, document.fmu) {
            (Some(path), None) | (None, Some(path)) => directory.join(path),
            _ => return Err(Error::Spec("give one of the keys trial and fmu".into())),
        };
        for (key, value) in [("until", Some(document.until)), ("step", document.step)] {
            if value.is_some_and(|value| !(value > 0.0 && value.is_finite())) {
                return Err(Error::Spec(format!("{key}: must be a positive number of seconds")));
            }
        }
        let table = document.table.map(|table| directory.join(table));
        let mut inputs: Vec<PathBuf> = std::iter::once(model.clone()).chain(table.clone()).collect();
        let points = match (document.parameters, table) {
            (Some(axes), None) => {
                let axes = axes.into_iter().map(|(name, value)| {
                    let values = axis(value).place(|| format!("parameters: {name}"))?;
                    Ok((name, values))
                });
                let axes = axes.collect::<Result<Vec<_>>>()?;
                Points::grid(axes).map_err(|message| Error::Spec(format!("parameters: {message}")))?
            }
            (None, Some(table)) => read_table(&table)?,
            _ => return Err(Error::Spec("give one of [parameters] and table".into())),
        };
        check_directories(&points)?;
        let measures = document.measures.into_iter().map(|(name, value)| {
            let measure = value.try_into().place(|| format!("measures: {name}"))?;
            Ok((name, measure))
        });
        let measures: Vec<(String, Measure)> = measures.collect::<Result<_>>()?;
        if measures.is_empty() {
            return Err(Error::Spec("measures: must not be empty".into()));
        }
        let mut names = HashSet::from(RESERVED);
        let given = points.columns.iter().map(|(name, _)| name).chain(measures.iter().map(|(name, _)| name));
        for name in given {
            if !names.insert(name) {
                return Err(Error::Spec(format!("{name:?}: the table already has a column with this name")));
            }
        }
        let drive = match document.drive {
            None | Some(DriveText::Switch(true)) => DriveChoice::Own,
            Some(DriveText::Switch(false)) => DriveChoice::None,
            Some(DriveText::File(path)) => DriveChoice::File(directory.join(path)),
        };
        if let DriveChoice::File(path) = &drive {
            inputs.push(path.clone());
        }
        Ok(Spec {
            model,
            trial: None,
            until: document.until,
            step: document.step,
            drive,
            points,
            measures,
            inputs,
        })
    }
}

/// That no two points have the same OutputDirectory, where they would overwrite each other's files.
fn check_directories(points: &Points) -> Result<()> {
    let mut seen = HashSet::new();
    match points.output_directories().find(|directory| !seen.insert(directory.clone())) {
        Some(twice) => Err(Error::Spec(format!(
            "{OUTPUT_DIRECTORY} = {twice:?}: two points have it, and would overwrite each other's files; with \
             a table of points, each can have its own"
        ))),
        None => Ok(()),
    }
}

fn axis(value: toml::Value) -> Result<Values> {
    let expected = "expected a list of numbers or of texts, or { from, to, count, spacing }";
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

/// Reads a CSV with one row for each point. A column that contains only integers has integers; one with other numbers
/// has reals.
fn read_table(path: &Path) -> Result<Points> {
    let wrong = || path.display().to_string();
    let file = input::open_found(path, input::LARGEST_DRIVE).place(wrong)?;
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

#[cfg(test)]
mod tests {
    use super::*;

    const GOOD: &str = r#"
        trial = "push"
        until = 2
        drive = false
        [parameters]
        "agent[*].Mass" = { from = 50, to = 200, count = 3, spacing = "logarithmic" }
        "contact.a.a.KineticFriction" = [0, 0.5]
        [measures]
        reach = { of = "x", take = "reach", agents = ["4"] }
    "#;

    #[test]
    fn a_grid() {
        let spec = Spec::from_toml(GOOD, Path::new("dir")).unwrap();
        assert_eq!((spec.model, spec.until, spec.points.count), (PathBuf::from("dir/push"), 2.0, 6));
        let (name, values) = &spec.points.columns[0];
        let Values::Reals(values) = values else { panic!("{values:?}") };
        assert_eq!(name, "agent[*].Mass");
        assert_eq!((values[0], values[5]), (50.0, 200.0));
        assert!((values[2] - 100.0).abs() < 1e-12);
        assert_eq!(spec.drive, DriveChoice::None);
    }

    #[test]
    fn mistakes_name_the_key() {
        let said = |from: &str, to: &str| {
            assert!(GOOD.contains(from));
            Spec::from_toml(&GOOD.replace(from, to), Path::new("")).unwrap_err().whole()
        };
        for (from, to, expected) in [
            ("trial = \"push\"", "", "trial and fmu"),
            ("until = 2", "until = -2", "until: must be a positive"),
            ("until = 2", "untill = 2", "untill"),
            ("[0, 0.5]", "[]", "KineticFriction: no values"),
            ("[0, 0.5]", "true", "KineticFriction: expected a list"),
            ("count = 3", "count = 1", "agent[*].Mass: count = 1"),
            ("from = 50", "from = 0", "must be positive"),
            ("reach = {", "status = {", "\"status\": the table already has a column"),
            ("of = \"x\"", "of = \"mood\"", "measures: reach"),
            ("[0, 0.5]", "[0.5, nan]", "KineticFriction: NaN: must be a finite number"),
            ("[0, 0.5]", "[0.5, -inf]", "KineticFriction: -inf: must be a finite number"),
            ("[0, 0.5]", "[1e999]", "KineticFriction"),
            ("from = 50", "from = -inf", "agent[*].Mass: from and to must be finite"),
        ] {
            assert!(said(from, to).contains(expected), "{}", said(from, to));
        }
    }

    /// They overflowed to infinities and to NaN, which were simulated.
    #[test]
    fn a_wide_range_has_finite_values() {
        for (from, to, spacing, middle) in [
            (-1e308, 1.7e308, "linear", 0.35e308),
            (1.7e308, -1.7e308, "linear", 0.0),
            (1e-300, 1e300, "logarithmic", 1.0),
            (1e300, 1e-300, "logarithmic", 1.0),
            (5e-324, f64::MAX, "logarithmic", 2f64.powi(-25)),
        ] {
            let text = format!("{{ from = {from:e}, to = {to:e}, count = 101, spacing = {spacing:?} }}");
            let text = GOOD.replace("[0, 0.5]", &text);
            let points = Spec::from_toml(&text, Path::new("")).unwrap().points;
            let Values::Reals(values) = &points.columns[1].1 else { panic!("numbers") };
            let values = &values[..101];
            let rising = |pair: &[f64]| if from < to { pair[0] < pair[1] } else { pair[0] > pair[1] };
            assert!(
                values.iter().all(|value| value.is_finite()) && values.windows(2).all(rising),
                "{values:?}"
            );
            assert_eq!((values[0], values[100]), (from, to));
            let error = values[50] - middle;
            assert!(error.abs() <= 1e-2 * f64::abs(middle), "{text}: {}", values[50]);
        }
    }

    #[test]
    fn a_table_with_what_is_no_finite_number_is_refused() {
        let directory = tempfile::TempDir::new().unwrap();
        let path = directory.path().join("points.csv");
        for (cell, refused) in [
            ("nan", true),
            ("-NaN", true),
            ("inf", true),
            ("+Infinity", true),
            ("1e999", true),
            ("1e300", false),
            ("none", false),
        ] {
            std::fs::write(&path, format!("Mass,Other\n70.5,1\n{cell},2\n")).unwrap();
            let said = read_table(&path).map_or_else(|error| error.whole(), |_| "taken".into());
            let expected = format!("points.csv: Mass: {cell}: must be a finite number (point 1)");
            assert!(if refused { said.ends_with(&expected) } else { said == "taken" }, "{said}");
        }
    }

    /// Each name was compared with all others: a minute for so many.
    #[test]
    fn many_names_are_compared_in_short_time() {
        let parameters: String = (0..100_000).map(|k| format!("p{k} = [1]\n")).collect();
        let text = GOOD.replace("\"agent[*].Mass\"", &format!("{parameters}\"agent[*].Mass\""));
        let begin = std::time::Instant::now();
        let points = Spec::from_toml(&text, Path::new("")).unwrap().points;
        assert_eq!((points.columns.len(), points.count), (100_002, 6));
        assert!(begin.elapsed().as_secs() < 30, "{:?}", begin.elapsed());
    }
}
