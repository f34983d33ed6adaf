//! Writes an `.fmu` from a plan and binaries.

use crate::decision::{Decision, Known, PLAN_FILE, dependencies, table};
use crate::plan::{Plan, PlanError};
use lemons_fmi::archive::{Archive, ArchiveError, Binary, Version};
use lemons_fmi::v2::description::{Description, Naming};
use lemons_fmi::v2::guid;
use lemons_xml::number;
use std::io::{Seek, Write};
use thiserror::Error;

/// `modelName`
pub const MODEL_NAME: &str = "LEMONS decision";
/// `modelIdentifier`: the stem of the binaries' names.
pub const MODEL_IDENTIFIER: &str = "Decision";
/// \[s\] `DefaultExperiment.stopTime`
const DEFAULT_STOP_TIME: f64 = 30.0;

/// Why an FMU could not be written.
#[derive(Debug, Error)]
#[allow(missing_docs)] // the messages say it
pub enum PackError {
    #[error(transparent)]
    Archive(#[from] ArchiveError),
    #[error(transparent)]
    Plan(#[from] PlanError),
}

/// Returns the model description of a plan's FMU.
pub fn model_description(plan: &Plan, naming: Naming) -> String {
    let table = table(plan);
    let mut decision = Decision::new(plan.clone());
    let starts: Vec<Option<f64>> =
        table.iter().map(|variable| decision.place(variable.quantity).map(|place| *place)).collect();
    Description {
        model_name: MODEL_NAME,
        model_identifier: MODEL_IDENTIFIER,
        description: "where people want to go: desired speed towards way-points (LEMONS, eq. 4)",
        naming,
        interpolates_inputs: false,
        knows_derivatives: false,
        stop_time: DEFAULT_STOP_TIME,
        step_size: plan.time_step,
        table: &table,
        start: &|place| starts[place].map(number),
        dependencies: &|place| dependencies(&table, place, Known::Inputs),
        initial_dependencies: &|place| dependencies(&table, place, Known::InputsAndParameters),
    }
    .xml()
}

/// Writes the FMU of a plan.
///
/// # Errors
/// A binary cannot be read, or the FMU cannot be written; see [`PackError`].
pub fn write_fmu(
    plan: &Plan,
    naming: Naming,
    binaries: &[Binary],
    file: impl Write + Seek,
) -> Result<(), PackError> {
    let description = model_description(plan, naming);
    let mut archive =
        Archive::begin(file, Version::V2, MODEL_IDENTIFIER, &description, &documentation(plan), binaries)?;
    archive.add(&format!("resources/{PLAN_FILE}"), plan.to_toml()?.as_bytes())?;
    Ok(archive.finish()?)
}

/// `documentation/index.html`
fn documentation(plan: &Plan) -> String {
    include_str!("documentation.html")
        .replace("{version}", env!("CARGO_PKG_VERSION"))
        .replace("{agents}", &plan.agents.len().to_string())
        .replace("{last}", &plan.agents.len().saturating_sub(1).to_string())
        .replace("{guid}", &guid(&table(plan)).braced().to_string())
}
