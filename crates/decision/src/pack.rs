//! Writes an `.fmu` from a Trial, a plan and binaries. Its resources are a Trial directory with a `decision.toml`.

use crate::config::DECISION_FILE;
use crate::decision::Decision;
use crate::error::PlanError;
use crate::plan::Plan;
use lemons_core::files::source::LocalFiles;
use lemons_core::trial::Trial;
use lemons_fmi::archive::{ArchiveError, Binary, FmuContent, FmuPicture, FmuWriter};
use lemons_fmi::description::{Packed, model_description, packed_description, terminals_xml};
use lemons_fmi::documentation::documentation;
use lemons_fmi::{FmuFormat, Version};
use std::io::{Seek, Write};
use std::path::Path;
use thiserror::Error;

/// More numbers of way-points are not written: their zeros alone would fill a description of 100 MB.
const MOST_NUMBERS: u64 = 20_000_000;

/// Why an FMU could not be written.
#[derive(Debug, Error)]
#[allow(missing_docs)] // the messages say it
pub enum PlanPackError {
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
pub fn description(plan: &Plan, format: FmuFormat) -> String {
    model_description(&mut Decision::new(plan.clone()), format).expect("start values are in the plan")
}

/// Writes the FMU of a plan for the people of a Trial.
///
/// # Errors
/// A binary cannot be read, or the FMU cannot be written; see [`PlanPackError`].
pub fn write_fmu(
    trial: &Trial,
    plan: &Plan,
    format: FmuFormat,
    binaries: &[Binary],
    file: impl Write + Seek,
) -> Result<(), PlanPackError> {
    if format == FmuFormat::Fmi3 {
        check_size(plan)?;
    }
    let version = format.version();
    let page = match version {
        Version::V2 => include_str!("documentation.html"),
        Version::V3 => include_str!("documentation_3.html"),
    };
    let packed = Packed { name: DECISION_FILE.to_owned(), fingerprint: plan.fingerprint };
    let mut model = Decision::new(plan.clone());
    let names = ["Position", "Theta", "Velocity", "Fp", "Mp", "Active"];
    let content = FmuContent {
        version,
        description: &packed_description(&mut model, format, &[packed])
            .expect("start values are in the plan"),
        documentation: &documentation(&model, version, page, plan.agents.len()),
        binaries,
        // It fits the crowd's.
        terminals: terminals_xml(&model, version, "motion in, drives out", &names),
        icon: FmuPicture { svg: include_str!("icon.svg"), png: include_bytes!("icon.png") },
        diagram: FmuPicture { svg: include_str!("diagram.svg"), png: include_bytes!("diagram.png") },
        picture: None,
    };
    let mut archive = FmuWriter::begin::<Decision>(file, &LocalFiles, &content)?;
    archive.add(&format!("resources/{DECISION_FILE}"), plan.config.to_toml()?.as_bytes())?;
    for (path, text) in trial.texts(Path::new("resources")) {
        let parts: Vec<_> = path.iter().map(|part| part.to_string_lossy()).collect();
        archive.add(&parts.join("/"), text.as_bytes())?;
    }
    Ok(archive.finish()?)
}

fn check_size(plan: &Plan) -> Result<(), PlanPackError> {
    let waypoints = plan.agents.iter().map(|agent| agent.walker.waypoints.len()).max().unwrap_or(0);
    let (agents, waypoints) = (plan.agents.len() as u64, waypoints as u64);
    let numbers = agents.saturating_mul(waypoints).saturating_mul(2);
    if numbers > MOST_NUMBERS { Err(PlanPackError::TooLarge { agents, waypoints }) } else { Ok(()) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::DecisionConfig;
    use lemons_core::trial::{Agent, AgentDynamics};

    #[test]
    fn one_route_that_is_far_too_long_for_an_array_of_all_is_refused() {
        let person = |i: usize| (Agent::new(i.to_string(), 70.0, 1.3, [2.0, 4.0]), AgentDynamics::default());
        let trial = Trial::of((0..3000).map(person), Vec::new(), 0.05);
        let route = "{ x = 1, y = 2 },".repeat(4000);
        let config = format!("waypoints = [{{ x = 1, y = 2 }}]\n[agents.7]\nwaypoints = [{route}]");
        let plan = Plan::of(&trial, &DecisionConfig::from_toml(&config).unwrap()).unwrap();
        let error =
            write_fmu(&trial, &plan, FmuFormat::Fmi3, &[], std::io::Cursor::new(Vec::new())).unwrap_err();
        assert!(matches!(error, PlanPackError::TooLarge { agents: 3000, waypoints: 4000 }), "{error}");
    }
}
