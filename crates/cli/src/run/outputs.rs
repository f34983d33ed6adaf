//! The outputs of what is not a crowd: one table, with a column for each output.

use super::About;
use crate::results::{self, Cell, CellType, Column, Content, Place, TableWriter, with_path};
use anyhow::Result;
use lemons_core::files::Staged;
use lemons_master::ssp::{Address, Kind as Causality, Type};
use lemons_master::{Instance, Selection, System, Value};

/// Outputs that are warned of by name.
const MOST_WARNINGS: usize = 20;

/// A table with a column for each output.
pub struct OutputTable {
    table: TableWriter<Staged>,
    /// Of the columns after the time; `None` once a value was seen that is no finite number.
    names: Vec<Option<String>>,
    /// What was seen then.
    odd: Vec<String>,
}

impl OutputTable {
    /// With these columns after the time.
    pub fn create(columns: Vec<Column>, to: &Place, about: &About) -> Result<OutputTable> {
        let names = columns.iter().map(|column| Some(column.name.clone())).collect();
        let columns = std::iter::once(Column::time()).chain(columns).collect();
        let table = results::begin(to, &Content { columns, about: about.lines.clone() }, about.goes_on)?;
        Ok(OutputTable { table, names, odd: Vec::new() })
    }

    pub fn row(&mut self, time: f64, row: Vec<Cell<'_>>) -> Result<()> {
        for (name, cell) in self.names.iter_mut().zip(&row) {
            if let Cell::Real(value) = cell
                && !value.is_finite()
                && let Some(name) = name.take()
            {
                self.odd.push(format!(
                    "warning: output {name} is {value:?} for the first time at t = {time:?} s"
                ));
            }
        }
        self.table.row(time, row).map_err(with_path)
    }

    /// Puts the table in its place; returns the line of the summary.
    pub fn finish(self) -> Result<String> {
        self.odd.iter().take(MOST_WARNINGS).for_each(|warning| note!("{warning}"));
        if self.odd.len() > MOST_WARNINGS {
            note!("warning: and {} more outputs", self.odd.len() - MOST_WARNINGS);
        }
        let (path, columns) = (self.table.path().to_owned(), self.names.len() + 1);
        results::place(self.table.finish(), &path)?;
        Ok(format!("outputs            {}   ({columns} columns)", path.display()))
    }
}

/// Outputs of components of a system.
pub struct Outputs {
    components: Vec<Columns>,
    table: OutputTable,
    count: usize,
}

/// The outputs of a component, by type.
struct Columns {
    /// Among the components.
    place: usize,
    reals: Selected,
    integers: Selected,
    booleans: Selected,
    strings: Selected,
}

/// Values, and the columns after the time where they go.
struct Selected {
    values: Selection,
    columns: Vec<usize>,
}

impl Outputs {
    /// Of the components at these places; `None` if they have no outputs.
    pub fn create(system: &System, places: Vec<usize>, to: &Place, about: &About) -> Result<Option<Outputs>> {
        let mut header = Vec::new();
        let mut all = Vec::new();
        for place in places {
            let component = &system.components()[place];
            let mut lists = [const { (Vec::new(), Vec::new()) }; 4];
            let singles = component.fmu.description.singles();
            for (name, single) in singles.filter(|(_, own)| own.variable.kind == Some(Causality::Output)) {
                let variable = single.variable;
                let (list, kind) = match variable.of {
                    Type::Real(_) => (0, CellType::Real),
                    Type::Integer | Type::Enumeration(_) => (1, CellType::Integer),
                    Type::Boolean => (2, CellType::Boolean),
                    Type::String => (3, CellType::Text),
                    // A table has no place for them.
                    Type::Binary | Type::Clock => continue,
                };
                lists[list].0.push(single.address());
                lists[list].1.push(header.len());
                header.push(Column {
                    name: format!("{}.{name}", component.name),
                    kind,
                    unit: variable.of.unit().map(str::to_owned),
                    variable: name,
                    description: variable.description.clone().unwrap_or_default(),
                });
            }
            let selected = |(addresses, columns): (Vec<Address>, _)| -> lemons_master::Result<Selected> {
                Ok(Selected { values: component.instance.select_at(&addresses)?, columns })
            };
            let [reals, integers, booleans, strings] = lists;
            all.push(Columns {
                place,
                reals: selected(reals)?,
                integers: selected(integers)?,
                booleans: selected(booleans)?,
                strings: selected(strings)?,
            });
        }
        let count = header.len();
        if count == 0 {
            return Ok(None);
        }
        Ok(Some(Outputs { components: all, table: OutputTable::create(header, to, about)?, count }))
    }

    /// Reads the outputs at a communication point and writes the row.
    pub fn write_row(&mut self, system: &System) -> Result<()> {
        let mut row = vec![Cell::Integer(0); self.count];
        let mut texts = Vec::new();
        for columns in &self.components {
            let instance = &system.components()[columns.place].instance;
            columns.reals.put(instance, &mut row, Cell::Real)?;
            columns.integers.put(instance, &mut row, Cell::Integer)?;
            columns.booleans.put(instance, &mut row, Cell::Boolean)?;
            texts.push(instance.values::<String>(&columns.strings.values)?);
        }
        for (columns, texts) in self.components.iter().zip(&texts) {
            for (column, text) in columns.strings.columns.iter().zip(texts) {
                row[*column] = Cell::Text(text);
            }
        }
        self.table.row(system.time(), row)
    }

    /// As [`OutputTable::finish`].
    pub fn finish(self) -> Result<String> {
        self.table.finish()
    }
}

impl Selected {
    fn put<'a, T: Value>(
        &self,
        instance: &Instance,
        row: &mut [Cell<'a>],
        cell: impl Fn(T) -> Cell<'a>,
    ) -> Result<()> {
        for (column, value) in self.columns.iter().zip(instance.values(&self.values)?) {
            row[*column] = cell(value);
        }
        Ok(())
    }
}
