//! Writes an `.fmu` from a plan and binaries.

use crate::decision::arrays::starts;
use crate::decision::table::{dependencies, table};
use crate::decision::{Decision, PLAN_FILE};
use crate::error::PlanError;
use crate::plan::Plan;
use lemons_core::files::source::Disk;
use lemons_core::xml::number;
use lemons_fmi::Format;
use lemons_fmi::archive::{Archive, ArchiveError, Binary, Version};
use lemons_fmi::v2::description::{Description, Naming};
use lemons_fmi::v2::guid;
use lemons_fmi::v3;
use lemons_fmi::v3::description::Start;
use lemons_fmi::v3::terminals::{CROWD, Terminal, terminals_xml};
use lemons_fmi::v3::{ArrayModel, Known};
use std::io::{Seek, Write};
use thiserror::Error;

/// `modelName`
pub const MODEL_NAME: &str = "LEMONS decision";
/// `modelIdentifier`: the stem of the binaries' names.
pub const MODEL_IDENTIFIER: &str = "Decision";
/// \[s\] `DefaultExperiment.stopTime`
const DEFAULT_STOP_TIME: f64 = 30.0;
/// Description for users.
const DESCRIPTION: &str = "where people want to go: desired speed towards way-points (LEMONS, eq. 4)";

/// More numbers of way-points are not written: their zeros alone would fill a description of 100 MB.
const MOST_NUMBERS: u64 = 20_000_000;

/// Why an FMU could not be written.
#[derive(Debug, Error)]
#[allow(missing_docs)] // the messages say it
pub enum PackError {
    #[error(transparent)]
    Archive(#[from] ArchiveError),
    #[error(transparent)]
    Plan(#[from] PlanError),
    #[error(
        "{agents} agents with up to {waypoints} way-points are too many for FMI 3.0, whose arrays have room for the \
         longest route for everybody: shorten it, or write FMI 2.0"
    )]
    TooLarge { agents: u64, waypoints: u64 },
}

/// Returns the model description of a plan's FMU.
pub fn description(plan: &Plan, format: Format) -> String {
    match format {
        Format::Fmi2(naming) => model_description(plan, naming),
        Format::Fmi3 => model_description_3(plan),
    }
}

/// Returns the model description of a plan's FMI 2.0 FMU.
pub fn model_description(plan: &Plan, naming: Naming) -> String {
    let table = table(plan);
    let mut decision = Decision::new(plan.clone());
    let starts: Vec<Option<f64>> =
        table.iter().map(|variable| decision.place(variable.quantity).map(|place| *place)).collect();
    Description {
        model_name: MODEL_NAME,
        model_identifier: MODEL_IDENTIFIER,
        description: DESCRIPTION,
        naming,
        interpolates_inputs: false,
        knows_derivatives: false,
        stop_time: DEFAULT_STOP_TIME,
        step_size: plan.time_step,
        table: &table,
        start: &|place| starts[place].map(number),
        dependencies: &|place| dependencies(plan, &table, place, Known::Inputs),
        initial_dependencies: &|place| dependencies(plan, &table, place, Known::InputsAndParameters),
    }
    .xml()
}

/// Returns the model description of a plan's FMI 3.0 FMU.
pub fn model_description_3(plan: &Plan) -> String {
    let decision = Decision::new(plan.clone());
    v3::description::Description {
        model_name: MODEL_NAME,
        model_identifier: MODEL_IDENTIFIER,
        description: DESCRIPTION,
        knows_derivatives: false,
        shows_intermediate_values: false,
        stop_time: DEFAULT_STOP_TIME,
        step_size: plan.time_step,
        sizes: &decision.sizes(),
        start: &|block| starts(&mut Decision::new(plan.clone()), block).map(Start::Numbers),
        // Here arrays count, not their elements.
        dependencies: &|block| decision.dependencies_on(block, Known::Inputs, false),
        initial_dependencies: &|block| decision.dependencies_on(block, Known::InputsAndParameters, false),
    }
    .xml::<Decision>()
}

/// Returns the terminal that fits the crowd's: motion in, drives out.
fn terminals() -> String {
    let terminal = Terminal {
        name: CROWD,
        description: "motion in, drives out",
        variables: &["Position", "Theta", "Fp", "Mp", "Active"],
    };
    terminals_xml::<Decision>(&terminal, false)
}

/// Writes the FMU of a plan.
///
/// # Errors
/// A binary cannot be read, or the FMU cannot be written; see [`PackError`].
pub fn write_fmu(
    plan: &Plan,
    format: Format,
    binaries: &[Binary],
    file: impl Write + Seek,
) -> Result<(), PackError> {
    if format == Format::Fmi3 {
        check_size(plan)?;
    }
    let (version, description) = (format.version(), description(plan, format));
    let documentation = match version {
        Version::V2 => documentation(plan),
        Version::V3 => documentation_3(plan),
    };
    let mut archive = Archive::begin(file, version, &description, &documentation)?;
    archive.add_binaries(&Disk, MODEL_IDENTIFIER, binaries)?;
    if version == Version::V3 {
        archive.add("terminalsAndIcons/terminalsAndIcons.xml", terminals().as_bytes())?;
    }
    archive.add(&format!("resources/{PLAN_FILE}"), plan.to_toml()?.as_bytes())?;
    Ok(archive.finish()?)
}

fn check_size(plan: &Plan) -> Result<(), PackError> {
    let waypoints = plan.agents.iter().map(|agent| agent.walker.waypoints.len()).max().unwrap_or(0);
    let (agents, waypoints) = (plan.agents.len() as u64, waypoints as u64);
    let numbers = agents.saturating_mul(waypoints).saturating_mul(2);
    if numbers > MOST_NUMBERS { Err(PackError::TooLarge { agents, waypoints }) } else { Ok(()) }
}

/// `documentation/index.html`
fn documentation(plan: &Plan) -> String {
    include_str!("documentation.html")
        .replace("{version}", env!("CARGO_PKG_VERSION"))
        .replace("{agents}", &plan.agents.len().to_string())
        .replace("{last}", &plan.agents.len().saturating_sub(1).to_string())
        .replace("{guid}", &guid(&table(plan)).braced().to_string())
}

/// `documentation/index.html` of FMI 3.0.
fn documentation_3(plan: &Plan) -> String {
    include_str!("documentation_3.html")
        .replace("{version}", env!("CARGO_PKG_VERSION"))
        .replace("{agents}", &plan.agents.len().to_string())
        .replace("{token}", &v3::token::<Decision>().braced().to_string())
        .replace("{variables}", &v3::documentation::rows::<Decision>())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::person::Person;
    use crate::rule::Pose;

    #[test]
    fn one_route_that_is_far_too_long_for_an_array_of_all_is_refused() {
        let person = |i: usize| Person {
            id: i.to_string(),
            mass: 70.0,
            moment_of_inertia: 1.3,
            floor_damping: 2.0,
            angular_damping: 4.0,
            pose: Pose::default(),
            disks: Vec::new(),
        };
        let people: Vec<Person> = (0..3000).map(person).collect();
        let route = "{ x = 1, y = 2 },".repeat(4000);
        let wishes = format!("waypoints = [{{ x = 1, y = 2 }}]\n[agents.7]\nwaypoints = [{route}]");
        let plan = Plan::new(&people, &crate::wishes::Wishes::from_toml(&wishes).unwrap(), 0.05).unwrap();
        let error = write_fmu(&plan, Format::Fmi3, &[], std::io::Cursor::new(Vec::new())).unwrap_err();
        assert!(matches!(error, PackError::TooLarge { agents: 3000, waypoints: 4000 }), "{error}");
    }
}
