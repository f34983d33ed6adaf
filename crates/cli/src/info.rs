//! `lemons info`: what an FMU is and which variables it has.

use crate::print;
use anyhow::Result;
use lemons_fmi::Version;
use lemons_master::Fmu;
use lemons_master::ssp::{Causality, FmiType, FmuVariable, Single};
use std::io::Write;
use std::path::PathBuf;

#[derive(clap::Args)]
pub struct Arguments {
    /// The FMU
    #[arg(value_name = "FILE.fmu")]
    fmu: PathBuf,
    /// List only variables whose name contains this text
    #[arg(long, value_name = "TEXT")]
    only: Option<String>,
}

/// Descriptions are shown of an FMU with at most so many variables: those of people fill screens, and documentation says
/// them once.
const MOST_DESCRIBED: usize = 60;

pub fn info(arguments: &Arguments) -> Result<()> {
    let fmu = Fmu::open(&arguments.fmu)?;
    let description = &fmu.description;
    let mut out = print::out();
    let count = |kind| {
        let variables = description.variables.iter().filter(|variable| variable.kind == Some(kind));
        variables.map(FmuVariable::count).sum::<usize>()
    };
    writeln!(out, "{}  {}", description.model_name, description.version.as_deref().unwrap_or(""))?;
    match description.fmi {
        Version::V2 => writeln!(out, "GUID      {}", description.guid)?,
        Version::V3 => {
            writeln!(out, "FMI 3.0   {} variables, token {}", description.variables.len(), description.guid)?
        }
    }
    if let Some(step) = description.step {
        writeln!(out, "step      {step} s")?;
    }
    for (place, platform) in fmu.platforms().into_iter().enumerate() {
        // A name in an archive may be anything.
        let name: String = platform.chars().filter(|c| !c.is_control()).collect();
        writeln!(out, "{:10}{name}", if place == 0 { "platforms" } else { "" })?;
    }
    if let Ok(resources) = fmu.resources() {
        writeln!(out, "Trials    {}", resources.names().join(", "))?;
    }
    writeln!(
        out,
        "{} {} inputs, {} outputs, {} parameters\n",
        if description.fmi == Version::V2 { "variables" } else { "values   " },
        count(Causality::Input),
        count(Causality::Output),
        count(Causality::Parameter)
    )?;
    let wanted = |name: &str| arguments.only.as_ref().is_none_or(|only| name.contains(only));
    let rows = description.singles().filter(|(name, single)| wanted(name) || wanted(&single.variable.name));
    let described = description.singles().count() <= MOST_DESCRIBED;
    let rows: Vec<[String; 5]> = rows.map(|(name, single)| row(name, single, described)).collect();
    let head = ["name", "", "unit", "start", if described { "description" } else { "" }].map(str::to_owned);
    let mut widths = [0; 5];
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

fn row(name: String, single: Single, described: bool) -> [String; 5] {
    let (variable, start) = (single.variable, single.variable.start_of(single.element));
    let unit = match variable.of.class() {
        FmiType::Real => variable.unit.clone().unwrap_or_default(),
        class => class.to_string(),
    };
    let causality = match variable.kind {
        Some(Causality::Input) => "input",
        Some(Causality::Output) => "output",
        Some(Causality::Parameter) => "param",
        Some(Causality::StructuralParameter) => "size",
        _ => "other",
    };
    let description = variable.description.clone().filter(|_| described).unwrap_or_default();
    [name, causality.into(), unit, start.unwrap_or_default().to_owned(), description]
}
