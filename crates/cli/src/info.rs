//! `lemons info`: what an FMU is and which variables it has.

use crate::tell;
use anyhow::Result;
use fmi_rs::model_description::fmi2::{Causality, ScalarVariable, VariableType};
use lemons_master::Fmu;
use std::io::Write;
use std::path::PathBuf;

#[derive(clap::Args)]
pub struct Arguments {
    /// The FMU
    #[arg(value_name = "FILE.fmu")]
    fmu: PathBuf,
    /// Only variables whose name contains this
    #[arg(long, value_name = "TEXT")]
    only: Option<String>,
}

pub fn info(arguments: &Arguments) -> Result<()> {
    let fmu = Fmu::open(&arguments.fmu)?;
    let description = &fmu.description;
    let mut out = tell::out();
    let count = |causality| description.modelVariables.iter().filter(|v| v.causality == causality).count();
    writeln!(out, "{}  {}", description.modelName, description.version.as_deref().unwrap_or(""))?;
    writeln!(out, "GUID      {}", description.guid)?;
    if let Some(experiment) = &description.defaultExperiment {
        writeln!(out, "step      {} s", experiment.stepSize.as_deref().unwrap_or("-"))?;
    }
    if let Ok(resources) = fmu.resources() {
        writeln!(out, "Trials    {}", resources.names().join(", "))?;
    }
    writeln!(
        out,
        "variables {} inputs, {} outputs, {} parameters\n",
        count(Causality::Input),
        count(Causality::Output),
        count(Causality::Parameter)
    )?;
    let wanted = |v: &&ScalarVariable| arguments.only.as_ref().is_none_or(|only| v.name.contains(only));
    let rows: Vec<[String; 4]> = description.modelVariables.iter().filter(wanted).map(row).collect();
    let head = ["name", "", "unit", "start"].map(str::to_owned);
    let mut widths = [0; 4];
    for row in std::iter::once(&head).chain(&rows) {
        for (width, cell) in widths.iter_mut().zip(row) {
            *width = (*width).max(cell.chars().count());
        }
    }
    for row in std::iter::once(&head).chain(&rows) {
        let cells: Vec<String> =
            row.iter().zip(widths).map(|(cell, width)| format!("{cell:width$}")).collect();
        writeln!(out, "{}", cells.join(" ").trim_end())?;
    }
    Ok(())
}

fn row(variable: &ScalarVariable) -> [String; 4] {
    let unit = match &variable.variableType {
        VariableType::Real { unit, .. } => unit.clone().unwrap_or_default(),
        other => other.name().to_owned(),
    };
    let causality = match variable.causality {
        Causality::Input => "input",
        Causality::Output => "output",
        Causality::Parameter => "param",
        _ => "other",
    };
    [variable.name.clone(), causality.into(), unit, variable.variableType.start().clone().unwrap_or_default()]
}
