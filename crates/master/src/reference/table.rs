//! Inputs or outputs of an FMU over time, in CSV as the tools page of fmi-standard.org wants it: names in double quotes, a
//! column for each variable, the elements of an array between spaces, Booleans as 0 and 1.

use crate::error::{ErrorPlace, MasterError, Result, require};
use crate::ssp::{Causality, FmiType, FmuVariable, Interface, Single};
use lemons_core::files::input;
use lemons_core::xml::{decimal, quoted};
use std::fmt::Write;
use std::path::Path;

/// \[byte\] The largest table that is read.
const LARGEST: u64 = 100_000_000;
/// The most values of a table that is written: one takes at most 25 bytes.
pub(super) const MOST_VALUES: u64 = LARGEST / 25;

/// The column of a variable.
struct Column {
    name: String,
    /// The number of its values.
    count: usize,
    /// Between two rows it changes linearly; anything else keeps its value until the next row.
    real: bool,
}

/// The values of variables at times.
#[derive(Default)]
pub(super) struct Table {
    columns: Vec<Column>,
    /// \[s\] Ascending.
    pub times: Vec<f64>,
    /// Those of a row one after the other.
    values: Vec<f64>,
}

/// Returns whether values of a variable are numbers, which a table can hold.
pub(super) fn is_number(variable: &FmuVariable) -> bool {
    !matches!(variable.of.class(), FmiType::String | FmiType::Binary | FmiType::Clock)
}

impl Table {
    /// Makes a table without rows.
    pub fn of<'a>(variables: impl IntoIterator<Item = &'a FmuVariable>) -> Table {
        let column = |variable: &FmuVariable| Column {
            name: variable.name.clone(),
            count: variable.count(),
            real: variable.of.class() == FmiType::Real,
        };
        Table { columns: variables.into_iter().map(column).collect(), ..Table::default() }
    }

    /// Adds a row.
    pub fn push(&mut self, time: f64, values: &[f64]) {
        self.times.push(time);
        self.values.extend(values);
    }

    /// Returns the number of the values of a row.
    pub fn width(&self) -> usize {
        self.columns.iter().map(|column| column.count).sum()
    }

    /// Returns whether there are no columns.
    pub fn is_empty(&self) -> bool {
        self.columns.is_empty()
    }

    /// Returns the values of a row.
    pub fn row(&self, k: usize) -> &[f64] {
        let width = self.width();
        &self.values[k * width..][..width]
    }

    /// Returns the values of a row as the variables of an FMU, which has them.
    pub fn singles<'a>(&self, interface: &'a Interface) -> Vec<Single<'a>> {
        let variables = self.columns.iter().filter_map(|column| interface.variable(&column.name));
        variables
            .flat_map(|variable| (0..variable.count()).map(|element| Single { variable, element }))
            .collect()
    }

    /// Returns the values at a time \[s\].
    pub fn at(&self, time: f64) -> Vec<f64> {
        let (Some(last), false) = (self.times.len().checked_sub(1), self.is_empty()) else {
            return Vec::new();
        };
        let after = self.times.partition_point(|row| *row <= time);
        let (before, after) = (after.saturating_sub(1), after.min(last));
        let mut values = self.row(before).to_vec();
        let past = time - self.times[before];
        if before == after || past <= 0.0 {
            return values;
        }
        let share = past / (self.times[after] - self.times[before]);
        let real = self.columns.iter().flat_map(|column| std::iter::repeat_n(column.real, column.count));
        for ((value, next), _) in values.iter_mut().zip(self.row(after)).zip(real).filter(|(_, real)| *real) {
            *value += share * (next - *value);
        }
        values
    }

    /// Writes the table.
    pub fn csv(&self) -> String {
        let mut text = "\"time\"".to_owned();
        for Column { name, .. } in &self.columns {
            text += &format!(",\"{}\"", name.replace('"', "\"\""));
        }
        for (k, time) in self.times.iter().enumerate() {
            let mut values = self.row(k).iter();
            let _ = write!(text, "\n{time:?}");
            for Column { count, real, .. } in &self.columns {
                for (place, value) in values.by_ref().take(*count).enumerate() {
                    let before = if place == 0 { ',' } else { ' ' };
                    // Both read back to the same double.
                    let _ = if *real {
                        write!(text, "{before}{value:?}")
                    } else {
                        write!(text, "{before}{value}")
                    };
                }
            }
        }
        text + "\n"
    }

    /// Reads a table of variables of a kind, which messages call `shown`.
    ///
    /// # Errors
    /// It cannot be read or is too large, a column is no such variable, a value is not a number, times do not ascend.
    pub fn read(path: &Path, shown: &Path, interface: &Interface, kind: Causality) -> Result<Table> {
        let at = |line: u64, what: String| MasterError::new(format!("{}:{line}: {what}", shown.display()));
        let file = input::open_bounded(path, LARGEST).place(|| shown.display().to_string())?;
        let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).flexible(true).from_reader(file);
        let header = reader.headers().place(|| shown.display().to_string())?.clone();
        let first = header.get(0).map(|name| name.trim_start_matches('\u{feff}').trim_matches('"'));
        require(first == Some("time"), || at(1, "the first column must be \"time\"".into()))?;
        let mut variables: Vec<&FmuVariable> = Vec::new();
        for name in header.iter().skip(1) {
            let variable = interface.variable(name).filter(|it| it.kind == Some(kind) && is_number(it));
            let none =
                || at(1, format!("{}: the FMU has no such {} that is a number", quoted(name), kind.name()));
            variables.push(variable.ok_or_else(none)?);
        }
        let mut names: Vec<&str> = variables.iter().map(|variable| variable.name.as_str()).collect();
        names.sort_unstable();
        let twice = names.windows(2).find(|two| two[0] == two[1]);
        require(twice.is_none(), || {
            at(1, format!("two columns are {}", quoted(twice.map_or("", |it| it[0]))))
        })?;
        let mut table = Table::of(variables);
        let mut record = csv::StringRecord::new();
        while reader.read_record(&mut record).place(|| shown.display().to_string())? {
            let line = record.position().map_or(0, csv::Position::line);
            let (has, columns) = (record.len(), header.len());
            require(has == columns, || at(line, format!("has {has} values instead of {columns}")))?;
            let wrong = |column: &str, text: &str, must: &str| {
                at(line, format!("{}: {}: {must}", quoted(column), quoted(text)))
            };
            let number = |column: &str, text: &str| {
                decimal(text).ok_or_else(|| wrong(column, text, "not a finite number"))
            };
            let time = number("time", &record[0])?;
            let ascends = table.times.last().is_none_or(|last| *last < time);
            require(ascends, || wrong("time", &record[0], "does not come after the row before"))?;
            table.times.push(time);
            for (Column { name, count, .. }, text) in table.columns.iter().zip(record.iter().skip(1)) {
                let before = table.values.len();
                for part in text.split_ascii_whitespace() {
                    table.values.push(number(name, part)?);
                }
                let has = table.values.len() - before;
                require(has == *count, || {
                    wrong(name, text, &format!("has {has} numbers instead of {count}"))
                })?;
            }
        }
        require(!table.times.is_empty(), || at(1, "there are no rows".into()))?;
        Ok(table)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DESCRIPTION: &str = r#"<fmiModelDescription fmiVersion="3.0" modelName="m" instantiationToken="t">
        <ModelVariables><Float64 name="a&quot;b" valueReference="1" causality="input" start="0 0">
        <Dimension start="2"/></Float64><Boolean name="on" valueReference="2" causality="input" start="false"/>
        <String name="s" valueReference="3" causality="input"><Start value=""/></String></ModelVariables>
        </fmiModelDescription>"#;

    /// As FMI wants it of importers: continuous inputs change linearly between rows, others at a row.
    #[test]
    fn what_is_written_is_read_and_interpolated() {
        let interface = Interface::read(DESCRIPTION.as_bytes()).unwrap();
        let mut table = Table::of(interface.variables.iter().filter(|variable| is_number(variable)));
        table.push(0.0, &[1.0, -0.0, 0.0]);
        table.push(0.1, &[1.0 / 3.0, 1e300, 1.0]);
        let text = table.csv();
        assert_eq!(text, "\"time\",\"a\"\"b\",\"on\"\n0.0,1.0 -0.0,0\n0.1,0.3333333333333333 1e300,1\n");
        let path = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(&path, format!("\u{feff}{text}")).unwrap();
        let read = Table::read(path.path(), Path::new("x.csv"), &interface, Causality::Input).unwrap();
        assert_eq!(read.csv(), text);
        for (time, expected) in [
            (-1.0, [1.0, 0.0, 0.0]),
            (0.0, [1.0, 0.0, 0.0]),
            (0.025, [1.0 - 0.25 * (2.0 / 3.0), 0.25e300, 0.0]),
            (0.1, [1.0 / 3.0, 1e300, 1.0]),
            (7.0, [1.0 / 3.0, 1e300, 1.0]),
        ] {
            let at = read.at(time);
            let near = at
                .iter()
                .zip(expected)
                .all(|(own, expected)| (own - expected).abs() <= 1e-15 * expected.abs());
            assert!(near, "{time}: {at:?}");
        }
        assert_eq!(Table::default().at(0.0), [0.0; 0]);
    }
}
