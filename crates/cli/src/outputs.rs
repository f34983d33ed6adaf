//! The outputs of components that are no crowd: one table, one column for each.

use crate::recording::Recording;
use crate::results::{Cell, Column, Content, Extent, Kind, Place, Table};
use anyhow::Result;
use fmi_rs::model_description::fmi2::{Causality, VariableType};
use lemons_master::System;

pub struct Outputs {
    components: Vec<Columns>,
    table: Table,
    /// After the time.
    count: usize,
}

/// The outputs of a component, by type.
struct Columns {
    /// Among the components.
    place: usize,
    reals: References,
    integers: References,
    booleans: References,
    strings: References,
}

/// Value references, and the columns after the time where their values go.
#[derive(Default)]
struct References {
    references: Vec<u32>,
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
            let mut columns = Columns {
                place,
                reals: References::default(),
                integers: References::default(),
                booleans: References::default(),
                strings: References::default(),
            };
            let description = &component.fmu.description;
            let variables = description.modelVariables.iter();
            for variable in variables.filter(|variable| variable.causality == Causality::Output) {
                let (list, kind) = match variable.variableType {
                    VariableType::Real { .. } => (&mut columns.reals, Kind::Real),
                    VariableType::Integer { .. } | VariableType::Enumeration { .. } => {
                        (&mut columns.integers, Kind::Integer)
                    }
                    VariableType::Boolean { .. } => (&mut columns.booleans, Kind::Boolean),
                    VariableType::String { .. } => (&mut columns.strings, Kind::Text),
                };
                list.references.push(variable.valueReference);
                list.columns.push(header.len() - 1);
                header.push(Column {
                    name: format!("{}.{}", component.name, variable.name),
                    kind,
                    unit: description.get_unit(variable).map(str::to_owned),
                    variable: variable.name.clone(),
                    description: variable.description.clone().unwrap_or_default(),
                });
            }
            all.push(columns);
        }
        let count = header.len() - 1;
        if count == 0 {
            return Ok(None);
        }
        let content = Content { columns: header, about: recording.about.clone() };
        let table = Table::create(to, &content, recording.before_of_outputs())?;
        Ok(Some(Outputs { components: all, table, count }))
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
        self.table.write(system.time(), row)
    }

    /// What was written.
    pub fn extent(&self) -> Extent {
        self.table.extent()
    }

    /// Puts the table in its place; answers the line of the summary.
    pub fn finish(self) -> Result<String> {
        let said = format!("outputs            {}   ({} columns)", self.table.said(), self.count + 1);
        self.table.finish()?;
        Ok(said)
    }
}

impl References {
    fn get<T: Clone + Default>(&self, get: impl FnOnce(&[u32], &mut [T]) -> Result<()>) -> Result<Vec<T>> {
        let mut values = vec![T::default(); self.references.len()];
        if !values.is_empty() {
            get(&self.references, &mut values)?;
        }
        Ok(values)
    }

    fn put<'a, T: Clone + Default>(
        &self,
        row: &mut [Cell<'a>],
        get: impl FnOnce(&[u32], &mut [T]) -> Result<()>,
        cell: impl Fn(T) -> Cell<'a>,
    ) -> Result<()> {
        for (column, value) in self.columns.iter().zip(self.get(get)?) {
            row[*column] = cell(value);
        }
        Ok(())
    }
}
