//! What it costs to run a crowd as an FMU: values across the boundary, loading, and the paper's push.
//!
//! The Trials are made here and packed with the library that was built with this program.

use crate::{MASS, Numbers, RATE};
use anyhow::{Context, Result};
use cpu_time::{ProcessTime, ThreadTime};
use crowd_mechanics::engine::{Vec2, vec2};
use crowd_mechanics::pack::Package;
use crowd_mechanics::trial::{
    Agent, AgentDynamics, Contact, Geometry, Interactions, Material, Materials, Parameters, Shape, Trial,
    Wall,
};
use include_dir::{Dir, include_dir};
use lemons_master::{Fmu, Instance, own_binary};
use lemons_verify::scenes::pedestrian;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
use tempfile::TempDir;

static PUSH: Dir = include_dir!("$CARGO_MANIFEST_DIR/../../resources/Trial_push");

/// The inputs of one agent.
pub const INPUTS: [&str; 3] = ["Fp.x", "Fp.y", "Mp"];
/// The Real outputs of one agent.
pub const REALS: [&str; 7] =
    ["Position.x", "Position.y", "Theta", "Velocity.x", "Velocity.y", "Omega", "NormalForce"];
/// The Integer outputs of one agent.
pub const INTEGERS: [&str; 3] = ["AgentContacts", "WallContacts", "ContactingAgents"];

/// \[m\] one person on two square metres.
pub const SPARSE: Vec2 = vec2(1.4, 1.4);
/// \[m\] six people on a square metre; some touch.
pub const DENSE: Vec2 = vec2(0.32, 0.521);

/// Writes the Trial of a crowd in a room: pedestrians on a lattice, turned and shifted a little.
///
/// # Errors
/// The directory cannot be written.
pub fn write_trial(agents: usize, spacing: Vec2, directory: &Path) -> Result<()> {
    let columns = ((agents as f64 * spacing.y / spacing.x).sqrt().round() as usize).max(1);
    let rows = agents.div_ceil(columns);
    let (width, height) = (spacing.x * columns as f64, spacing.y * rows as f64);
    let (skin, concrete) = ("human_naked".to_owned(), "concrete".to_owned());
    let contact = |id1: &String, id2: &String, damping, kinetic_friction| Contact {
        id1: id1.clone(),
        id2: id2.clone(),
        gamma_normal: damping,
        gamma_tangential: damping,
        kinetic_friction,
    };
    let person = pedestrian(MASS, RATE);
    let shapes: Vec<Shape> = person
        .disks
        .iter()
        .map(|disk| Shape { radius: disk.radius, material_id: skin.clone(), position: disk.position })
        .collect();
    let mut numbers = Numbers(30);
    let corners = [(0.0, 0.0), (width, 0.0), (width, height), (0.0, height), (0.0, 0.0)];
    let trial = Trial {
        name: "crowd".into(),
        directory: PathBuf::new(),
        parameters: Parameters {
            static_directory: "./static/".into(),
            dynamic_directory: "./dynamic/".into(),
            time_step: 0.1,
            time_step_mechanical: 1e-5,
        },
        materials: Materials {
            intrinsic: vec![
                Material { id: concrete.clone(), young_modulus: 1.7e9, shear_modulus: 7.1e8 },
                Material { id: skin.clone(), young_modulus: 4e6, shear_modulus: 1_379_310.3 },
            ],
            binary: vec![contact(&skin, &skin, 700.0, 0.4), contact(&concrete, &skin, 1230.0, 0.5)],
        },
        geometry: Geometry {
            dimensions: Some(vec2(width, height)),
            walls: vec![Wall {
                id: "room".into(),
                material_id: concrete,
                corners: corners.iter().map(|&(x, y)| vec2(x, y)).collect(),
            }],
        },
        agents: (0..agents)
            .map(|k| Agent {
                kind: Some("pedestrian".into()),
                id: k.to_string(),
                mass: person.mass,
                height: Some(1.75),
                moment_of_inertia: person.inertia,
                floor_damping: person.translation_rate,
                angular_damping: person.rotation_rate,
                shapes: shapes.clone(),
            })
            .collect(),
        dynamics: (0..agents)
            .map(|k| AgentDynamics {
                position: vec2(
                    spacing.x * ((k % columns) as f64 + 0.5) + 0.01 * numbers.next(),
                    spacing.y * ((k / columns) as f64 + 0.5) + 0.01 * numbers.next(),
                ),
                velocity: Vec2::ZERO,
                theta: 0.5 * numbers.next(),
                omega: 0.0,
                fp: vec2(100.0 * numbers.next(), 100.0 * numbers.next()),
                mp: numbers.next(),
            })
            .collect(),
        interactions: Interactions::default(),
    };
    Ok(trial.write(directory)?)
}

/// A Trial of so many people in a directory of its own, and the FMU that it becomes there.
pub struct Packed {
    directory: TempDir,
}

impl Packed {
    /// Writes the Trial; the FMU is for [`Packed::pack`].
    ///
    /// # Errors
    /// It cannot be written.
    pub fn new(agents: usize, spacing: Vec2) -> Result<Packed> {
        let packed = Packed { directory: TempDir::with_prefix("lemons-bench-")? };
        write_trial(agents, spacing, &packed.trial())?;
        Ok(packed)
    }

    /// Where the Trial lies as in an unzipped FMU.
    pub fn resources(&self) -> PathBuf {
        self.directory.path().join("resources")
    }

    /// The Trial's directory.
    pub fn trial(&self) -> PathBuf {
        self.resources().join("crowd")
    }

    /// The FMU's place.
    pub fn fmu(&self) -> PathBuf {
        self.directory.path().join("crowd.fmu")
    }

    /// Reads, checks and packs the Trial, as `lemons pack` does.
    ///
    /// # Errors
    /// It cannot be packed.
    pub fn pack(&self) -> Result<()> {
        let (trials, binaries) = (vec![self.trial()], vec![own_binary()?]);
        Package { trials, binaries, ..Package::default() }.write(&self.fmu())?;
        Ok(())
    }
}

/// The value references of some variables of each agent, agent by agent.
fn references(instance: &Instance, agents: usize, names: &[&str]) -> Result<Vec<u32>> {
    let all = (0..agents).flat_map(|i| names.iter().map(move |name| format!("agent[{i}].{name}")));
    all.map(|name| instance.reference(&name)).collect()
}

/// \[s\] wall time of a call.
fn timed<T>(call: impl FnOnce() -> Result<T>) -> Result<(f64, T)> {
    let start = Instant::now();
    let answer = call()?;
    Ok((start.elapsed().as_secs_f64(), answer))
}

/// Processor time of this thread for so many calls: on a shared machine, too.
pub fn processor_time<T>(calls: u64, mut call: impl FnMut() -> T) -> Duration {
    let start = ThreadTime::now();
    for _ in 0..calls {
        std::hint::black_box(call());
    }
    start.elapsed()
}

fn median(mut times: Vec<f64>) -> f64 {
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}

/// What values across the boundary cost.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Overhead {
    /// \[µs\] the three inputs of each agent, in one `fmi2SetReal`.
    pub set: f64,
    /// \[µs\] the ten outputs of each agent, in one `fmi2GetReal` and one `fmi2GetInteger`.
    pub get: f64,
}

/// Measures an FMU's overhead at a communication point, in processor time: medians of the runs, of 100 calls each.
///
/// # Errors
/// The FMU's refusal.
pub fn overhead(agents: usize, runs: usize) -> Result<Overhead> {
    const CALLS: u64 = 100;
    let packed = Packed::new(agents, SPARSE)?;
    packed.pack()?;
    let instance = Fmu::open(&packed.fmu())?.instantiate("bench")?;
    instance.initialize()?;
    instance.step(0.0, 1e-4)?;
    let (inputs, reals) = (references(&instance, agents, &INPUTS)?, references(&instance, agents, &REALS)?);
    let integers = references(&instance, agents, &INTEGERS)?;
    let given: Vec<f64> = (0..inputs.len()).map(|k| k as f64).collect();
    let (mut numbers, mut counts) = (vec![0.0; reals.len()], vec![0; integers.len()]);
    let set = || instance.set_real(&inputs, &given);
    let mut get = || {
        instance.get_real(&reals, &mut numbers)?;
        instance.get_integer(&integers, &mut counts)
    };
    // Not refused; what follows is the same.
    set()?;
    get()?;
    let microseconds = |time: Duration| time.as_secs_f64() * 1e6 / CALLS as f64;
    let (sets, gets) = (0..runs)
        .map(|_| (microseconds(processor_time(CALLS, set)), microseconds(processor_time(CALLS, &mut get))))
        .unzip();
    Ok(Overhead { set: median(sets), get: median(gets) })
}

/// What it takes until a crowd can be stepped \[s\], wall time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Loading {
    /// The Trial read and checked.
    pub read: f64,
    /// The same and the FMU written.
    pub pack: f64,
    /// An instance made.
    pub instantiate: f64,
    /// From `fmi2SetupExperiment` to `fmi2ExitInitializationMode`.
    pub initialize: f64,
}

/// Measures how long a crowd takes to be read, packed, instantiated and initialized: medians of the runs.
///
/// # Errors
/// The Trial or the FMU is refused.
pub fn loading(agents: usize, runs: usize) -> Result<Loading> {
    let packed = Packed::new(agents, DENSE)?;
    let mut times = [const { Vec::new() }; 4];
    for _ in 0..runs {
        let read = timed(|| Ok(Trial::read(&packed.trial())?))?.0;
        let pack = timed(|| packed.pack())?.0;
        let fmu = Fmu::open(&packed.fmu())?;
        let (instantiate, instance) = timed(|| fmu.instantiate("bench"))?;
        let initialize = timed(|| instance.initialize())?.0;
        for (times, time) in times.iter_mut().zip([read, pack, instantiate, initialize]) {
            times.push(time);
        }
    }
    let [read, pack, instantiate, initialize] = times.map(median);
    Ok(Loading { read, pack, instantiate, initialize })
}

/// What a run took.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Run {
    /// \[s\]
    pub wall: f64,
    /// \[s\] of this process, all its threads.
    pub processor: f64,
}

/// The paper's push: its five people against each other and the wall, the first pushed with 700 N. 5 s at a mechanical
/// step of 2e-6 s through the FMU, in steps of 0.1 s; the fastest of the runs.
///
/// # Errors
/// The FMU's refusal.
pub fn push(runs: usize) -> Result<Run> {
    let packed = Packed { directory: TempDir::with_prefix("lemons-bench-")? };
    std::fs::create_dir_all(packed.trial())?;
    PUSH.extract(packed.trial())?;
    packed.pack()?;
    let fmu = Fmu::open(&packed.fmu())?;
    let mut best: Option<Run> = None;
    for _ in 0..runs {
        let instance = fmu.instantiate("bench")?;
        let names = ["TimeStepMechanical", "agent[0].Fp.x"];
        let references = [instance.reference(names[0])?, instance.reference(names[1])?];
        instance.set_real(&references, &[2e-6, 700.0])?;
        instance.initialize()?;
        let (wall, processor) = (Instant::now(), ProcessTime::now());
        for k in 0..50 {
            instance.step(f64::from(k) * 0.1, 0.1)?;
        }
        let run = Run { wall: wall.elapsed().as_secs_f64(), processor: processor.elapsed().as_secs_f64() };
        if best.is_none_or(|best| run.wall < best.wall) {
            best = Some(run);
        }
    }
    best.context("no run")
}
