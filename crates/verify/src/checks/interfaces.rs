//! Runs a Trial in both ways available to users: as a packed FMU, and by the C entry point.

use crate::checks::scenes::motion;
use crate::checks::{Result, ensure};
use crowd_mechanics::c_api::CrowdMechanics;
use crowd_mechanics::pack::Package;
use crowd_mechanics::setup;
use lemons_core::files::Scratch;
use lemons_core::plane::Motion;
use lemons_core::trial::{AgentDynamics, DynamicsElement, Trial, dynamics_xml};
use lemons_master::{Fmu, own_binary};
use std::ffi::CString;

/// Motions of all agents after each step.
type Motions = Vec<Vec<Motion>>;

/// Packs the Trial, loads the FMU as any master does, and advances it by `steps` TimeSteps.
///
/// # Errors
/// The FMU refuses a call.
pub fn through_fmu(trial: &Trial, steps: u32) -> Result<Motions> {
    let directory = Scratch::new()?;
    let (place, path) = (directory.path().join("Trial"), directory.path().join("crowd.fmu"));
    trial.write(&place)?;
    Package { trials: vec![place], binaries: vec![own_binary()?], ..Package::default() }.write(&path)?;
    let fmu = Fmu::open(&path)?;
    let instance = fmu.instantiate("verify")?;
    instance.initialize()?;
    let names = ["Position.x", "Position.y", "Theta", "Velocity.x", "Velocity.y", "Omega"];
    let names =
        (0..trial.agents.len()).flat_map(|i| names.iter().map(move |name| format!("agent[{i}].{name}")));
    let variables = instance.select(names)?;
    let step = trial.parameters.time_step;
    (0..steps)
        .map(|k| {
            instance.step(f64::from(k) * step, step)?;
            let values: Vec<f64> = instance.values(&variables)?;
            Ok(values.as_chunks().0.iter().map(motion).collect())
        })
        .collect()
}

/// Advances a copy of the Trial by `steps` calls of `CrowdMechanics(files)`. Its drive is written again before each
/// call, as in the paper's script.
///
/// # Errors
/// A call returns 1, or files cannot be read back.
pub fn through_files(trial: &Trial, steps: u32) -> Result<Motions> {
    let directory = Scratch::new()?;
    trial.write(directory.path())?;
    let parameters = directory.path().join("Parameters.xml").display().to_string();
    let names = [&*parameters, "Materials.xml", "Geometry.xml", "Agents.xml", "AgentDynamics.xml"];
    let names = names.map(|name| CString::new(name).unwrap_or_default());
    let pointers = names.each_ref().map(|name| name.as_ptr());
    let mut now = trial.dynamics.clone();
    (0..steps)
        .map(|_| {
            let driven = now.iter().zip(&trial.dynamics);
            let driven: Vec<AgentDynamics> = driven
                .map(|(now, start)| AgentDynamics { fp: start.fp, mp: start.mp, ..now.clone() })
                .collect();
            let text = dynamics_xml(&trial.agents, &driven, DynamicsElement::Written);
            std::fs::write(directory.path().join("dynamic/AgentDynamics.xml"), text)?;
            #[allow(unsafe_code)] // as a C program calls it
            // SAFETY: five texts that live through the call.
            let code = unsafe { CrowdMechanics(pointers.as_ptr()) };
            ensure!(code == 0, "CrowdMechanics returns 0");
            now = setup::read(directory.path())?.0.dynamics;
            Ok(now.iter().map(AgentDynamics::motion).collect())
        })
        .collect()
}
