//! Runs a Trial in both ways available to users: as a packed FMU, and by the C entry point.

use crate::checks::error::{Error, Result};
use crowd_mechanics::pack::Package;
use crowd_mechanics::setup;
use lemons_core::plane::{Pose, Twist, vec2};
use lemons_core::trial::{AgentDynamics, DynamicsElement, Trial, dynamics_xml};
use lemons_master::{Fmu, own_binary};
use libloading::{Library, Symbol};
use std::ffi::{CString, c_char, c_int};
use std::path::Path;

/// Poses and twists of all agents.
pub type Motions = Vec<(Pose, Twist)>;

/// Packs the Trial, loads the FMU as any master does, and advances it by `steps` TimeSteps.
///
/// # Errors
/// The FMU refuses a call.
pub fn through_fmu(trial: &Trial, mechanical_step: Option<f64>, steps: u32) -> Result<Vec<Motions>> {
    let directory = tempfile::tempdir()?;
    let path = directory.path().join("crowd.fmu");
    let package = Package {
        trials: vec![trial.directory.clone()],
        binaries: vec![own_binary()?],
        ..Package::default()
    };
    package.write(&path)?;
    let fmu = Fmu::open(&path)?;
    let instance = fmu.instantiate("verify")?;
    if let Some(step) = mechanical_step {
        instance.set(&instance.select(["TimeStepMechanical"])?, &[step])?;
    }
    instance.initialize()?;
    let names = ["Position.x", "Position.y", "Theta", "Velocity.x", "Velocity.y", "Omega"];
    let names =
        (0..trial.agents.len()).flat_map(|i| names.iter().map(move |name| format!("agent[{i}].{name}")));
    let poses = instance.select(names)?;
    let step = trial.parameters.time_step;
    let mut values = vec![0.0; poses.len()];
    (0..steps)
        .map(|k| {
            instance.step(f64::from(k) * step, step)?;
            instance.get(&poses, &mut values)?;
            let (agents, _) = values.as_chunks::<6>();
            Ok(agents
                .iter()
                .map(|v| {
                    let pose = Pose { position: vec2(v[0], v[1]), orientation: v[2] };
                    (pose, Twist { velocity: vec2(v[3], v[4]), angular_velocity: v[5] })
                })
                .collect())
        })
        .collect()
}

/// Advances a copy of the Trial by `steps` calls of `CrowdMechanics(files)`. Its drive is written again before each
/// call, as in the paper's script.
///
/// # Errors
/// A call returns 1, or files cannot be read back.
pub fn through_files(trial: &Trial, steps: u32) -> Result<Vec<Motions>> {
    let directory = tempfile::tempdir()?;
    trial.write(directory.path())?;
    let library = own_binary()?.path;
    let parameters = directory.path().join("Parameters.xml");
    let names = [
        path_text(&parameters)?,
        "Materials.xml".into(),
        "Geometry.xml".into(),
        "Agents.xml".into(),
        "AgentDynamics.xml".into(),
    ];
    let names = names.map(|name| CString::new(name).unwrap_or_default());
    let pointers = names.each_ref().map(|name| name.as_ptr());
    let dynamics = directory.path().join("dynamic/AgentDynamics.xml");
    let mut now = trial.dynamics.clone();
    (0..steps)
        .map(|_| {
            let driven: Vec<AgentDynamics> = now
                .iter()
                .zip(&trial.dynamics)
                .map(|(now, start)| AgentDynamics { fp: start.fp, mp: start.mp, ..now.clone() })
                .collect();
            std::fs::write(&dynamics, dynamics_xml(&trial.agents, &driven, DynamicsElement::Written))?;
            match call(&library, &pointers)? {
                0 => {}
                code => return Err(Error::CrowdMechanics(code)),
            }
            let (read, _) = setup::read(directory.path())?;
            now = read.dynamics;
            Ok(now
                .iter()
                .map(|d| {
                    let pose = Pose { position: d.position, orientation: d.theta };
                    (pose, Twist { velocity: d.velocity, angular_velocity: d.omega })
                })
                .collect())
        })
        .collect()
}

fn path_text(path: &Path) -> Result<String> {
    let text = path.to_str().map(str::to_owned);
    text.ok_or_else(|| Error::Premise("the name of the temporary directory is UTF-8".to_owned()))
}

#[allow(unsafe_code)] // calls our own library as a C program would
fn call(library: &Path, files: &[*const c_char; 5]) -> Result<c_int> {
    type CrowdMechanics = unsafe extern "C" fn(*const *const c_char) -> c_int;
    // SAFETY: the library that was built with this program; its function has this signature and gets
    // five texts that live through the call.
    unsafe {
        let library = Library::new(library)?;
        let function: Symbol<CrowdMechanics> = library.get(b"CrowdMechanics\0")?;
        Ok(function(files.as_ptr()))
    }
}
