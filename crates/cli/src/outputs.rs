//! The outputs of components that are not a crowd: one table, with a column for each output.

use crate::recording::Recording;
use crate::results::{self, Cell, Column, Content, Kind, Place, TableWriter, told};
use anyhow::Result;
use lemons_files::Staged;
use lemons_master::{Selection, System};
use lemons_ssp::{Address, Kind as Causality, Type};

/// Outputs that are warned of by name.
const MOST_WARNINGS: usize = 20;

pub struct Outputs {
    components: Vec<Columns>,
    table: TableWriter<Staged>,
    /// After the time.
    count: usize,
    /// Of the columns after the time; `None` once a value was seen that is no finite number.
    names: Vec<Option<String>>,
    /// What was seen then.
    odd: Vec<String>,
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
    pub fn create(
        system: &System,
        places: Vec<usize>,
        to: &Place,
        recording: &mut Recording<'_>,
    ) -> Result<Option<Outputs>> {
        let mut header = vec![Column::time()];
        let mut all = Vec::new();
        for place in places {
            let component = &system.components()[place];
            let mut lists = [const { (Vec::new(), Vec::new()) }; 4];
            let singles = component.fmu.description.singles();
            for (name, single) in singles.filter(|(_, own)| own.variable.kind == Some(Causality::Output)) {
                let variable = single.variable;
                let (list, kind) = match variable.of {
                    Type::Real(_) => (0, Kind::Real),
                    Type::Integer | Type::Enumeration(_) => (1, Kind::Integer),
                    Type::Boolean => (2, Kind::Boolean),
                    Type::String => (3, Kind::Text),
                    // A table has no place for them.
                    Type::Binary | Type::Clock => continue,
                };
                lists[list].0.push(single.address());
                lists[list].1.push(header.len() - 1);
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
        let count = header.len() - 1;
        if count == 0 {
            return Ok(None);
        }
        let names = header.iter().skip(1).map(|column| Some(column.name.clone())).collect();
        let content = Content { columns: header, about: recording.about.clone() };
        let table = results::begin(to, &content, recording.before.is_some())?;
        Ok(Some(Outputs { components: all, table, count, names, odd: Vec::new() }))
    }

    /// Reads the outputs at a communication point and writes the row.
    pub fn look(&mut self, system: &System) -> Result<()> {
        let mut row = vec![Cell::Integer(0); self.count];
        let mut texts = Vec::new();
        for columns in &self.components {
            let instance = &system.components()[columns.place].instance;
            columns.reals.put(&mut row, |r, v| instance.get_real(r, v), Cell::Real)?;
            columns.integers.put(&mut row, |r, v| instance.get_integer(r, v), Cell::Integer)?;
            columns.booleans.put(
                &mut row,
                |r, v| instance.get_boolean(r, v),
                |v: i32| Cell::Boolean(v != 0),
            )?;
            texts.push(columns.strings.get(|r, v| instance.get_string(r, v))?);
        }
        for (columns, texts) in self.components.iter().zip(&texts) {
            for (column, text) in columns.strings.columns.iter().zip(texts) {
                row[*column] = Cell::Text(text);
            }
        }
        for (name, cell) in self.names.iter_mut().zip(&row) {
            if let Cell::Real(value) = cell
                && !value.is_finite()
                && let Some(name) = name.take()
            {
                let time = system.time();
                self.odd.push(format!(
                    "warning: output {name} is {value:?} for the first time at t = {time:?} s"
                ));
            }
        }
        self.table.row(system.time(), row).map_err(told)
    }

    /// Puts the table in its place; returns the line of the summary.
    pub fn finish(self) -> Result<String> {
        self.odd.iter().take(MOST_WARNINGS).for_each(|warning| note!("{warning}"));
        if self.odd.len() > MOST_WARNINGS {
            note!("warning: and {} more outputs", self.odd.len() - MOST_WARNINGS);
        }
        let path = self.table.path().to_owned();
        results::place(self.table.finish(), &path)?;
        Ok(format!("outputs            {}   ({} columns)", path.display(), self.count + 1))
    }
}

impl Selected {
    fn get<T: Clone + Default, E>(
        &self,
        get: impl FnOnce(&Selection, &mut [T]) -> Result<(), E>,
    ) -> Result<Vec<T>, E> {
        let mut values = vec![T::default(); self.values.len()];
        if !values.is_empty() {
            get(&self.values, &mut values)?;
        }
        Ok(values)
    }

    fn put<'a, T: Clone + Default, E>(
        &self,
        row: &mut [Cell<'a>],
        get: impl FnOnce(&Selection, &mut [T]) -> Result<(), E>,
        cell: impl Fn(T) -> Cell<'a>,
    ) -> Result<(), E> {
        for (column, value) in self.columns.iter().zip(self.get(get)?) {
            row[*column] = cell(value);
        }
        Ok(())
    }
}
