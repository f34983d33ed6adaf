//! The outputs of components that are no crowd: one CSV, one column for each.

use crate::results::{Table, Tables};
use anyhow::Result;
use fmi_rs::model_description::fmi2::{Causality, VariableType};
use lemons_master::System;
use std::path::{Path, PathBuf};

pub struct Outputs {
    components: Vec<Columns>,
    table: Table,
    path: PathBuf,
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

/// Value references, and the columns where their values go.
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
        path: &Path,
        tables: &mut Tables,
    ) -> Result<Option<Outputs>> {
        let mut header = vec!["t".to_owned()];
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
            let variables = component.fmu.description.modelVariables.iter();
            for variable in variables.filter(|variable| variable.causality == Causality::Output) {
                let list = match variable.variableType {
                    VariableType::Real { .. } => &mut columns.reals,
                    VariableType::Integer { .. } | VariableType::Enumeration { .. } => &mut columns.integers,
                    VariableType::Boolean { .. } => &mut columns.booleans,
                    VariableType::String { .. } => &mut columns.strings,
                };
                list.references.push(variable.valueReference);
                list.columns.push(header.len());
                header.push(format!("{}.{}", component.name, variable.name));
            }
            all.push(columns);
        }
        let count = header.len() - 1;
        if count == 0 {
            return Ok(None);
        }
        let table = tables.create(path, header)?;
        Ok(Some(Outputs { components: all, table, path: path.to_owned(), count }))
    }

    /// Reads the outputs at a communication point and writes the row.
    pub fn look(&mut self, system: &System) -> Result<()> {
        let mut row = vec![String::new(); self.count + 1];
        row[0] = format!("{:?}", system.time());
        for columns in &self.components {
            let Columns { place, reals, integers, booleans, strings } = columns;
            let instance = &system.components()[*place].instance;
            reals.put(&mut row, |r, v| instance.get_real(r, v), |v: f64| format!("{v:?}"))?;
            integers.put(&mut row, |r, v| instance.get_integer(r, v), |v: i32| v.to_string())?;
            booleans.put(&mut row, |r, v| instance.get_boolean(r, v), |v: i32| (v != 0).to_string())?;
            strings.put(&mut row, |r, v| instance.get_string(r, v), |v: String| v)?;
        }
        self.table.write(row)
    }

    /// Puts the table in its place; answers the line of the summary.
    pub fn finish(self) -> Result<String> {
        self.table.finish()?;
        Ok(format!("outputs            {}   ({} columns)", self.path.display(), self.count + 1))
    }
}

impl References {
    fn put<T: Clone + Default>(
        &self,
        row: &mut [String],
        get: impl FnOnce(&[u32], &mut [T]) -> Result<()>,
        text: impl Fn(T) -> String,
    ) -> Result<()> {
        if self.references.is_empty() {
            return Ok(());
        }
        let mut values = vec![T::default(); self.references.len()];
        get(&self.references, &mut values)?;
        for (column, value) in self.columns.iter().zip(values) {
            row[*column] = text(value);
        }
        Ok(())
    }
}
