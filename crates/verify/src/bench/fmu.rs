//! The cost of running a crowd as an FMU: getting and setting values, loading, and the paper's push.
//!
//! The Trials are generated, and packed with the library that was built with this program.

use crate::bench::{MASS, Numbers, RATE};
use crate::checks::scenes::pedestrian;
use crate::checks::{Error, Result};
use cpu_time::{ProcessTime, ThreadTime};
use crowd_mechanics::pack::{Format, Package};
use crowd_mechanics::setup;
use include_dir::{Dir, include_dir};
use lemons_core::plane::{Vec2, vec2};
use lemons_core::trial::DriveChoice;
use lemons_core::trial::{
    Agent, AgentDynamics, Contact, Geometry, Interactions, Material, Materials, Parameters, Shape, Trial,
    Wall,
};
use lemons_master::{Fmu, Instance, Prepared, Selection, Settings, own_binary};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
use tempfile::TempDir;

static PUSH: Dir = include_dir!("$CARGO_MANIFEST_DIR/../../resources/Trial_push");

/// Names of the inputs of one agent.
pub const INPUTS: [&str; 3] = ["Fp.x", "Fp.y", "Mp"];
/// Names of the Real outputs of one agent.
pub const REALS: [&str; 7] =
    ["Position.x", "Position.y", "Theta", "Velocity.x", "Velocity.y", "Omega", "NormalForce"];
/// Names of the Integer outputs of one agent.
pub const INTEGERS: [&str; 3] = ["AgentContacts", "WallContacts", "ContactingAgents"];

/// \[m\] Spacing: one person per 2 m².
pub const SPARSE: Vec2 = vec2(1.4, 1.4);
/// \[m\] Spacing: six people per square metre; some touch.
pub const DENSE: Vec2 = vec2(0.32, 0.521);

/// Writes the Trial of a crowd in a room: pedestrians on a lattice, slightly turned and shifted.
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

/// A Trial of a number of people in a temporary directory, and its FMU there.
pub struct Packed {
    directory: TempDir,
}

impl Packed {
    /// Writes the Trial; [`Packed::pack`] makes the FMU.
    ///
    /// # Errors
    /// The Trial cannot be written.
    pub fn new(agents: usize, spacing: Vec2) -> Result<Packed> {
        let packed = Packed { directory: TempDir::with_prefix("lemons-bench-")? };
        write_trial(agents, spacing, &packed.trial())?;
        Ok(packed)
    }

    /// Returns the directory that contains the Trial as in an unzipped FMU.
    pub fn resources(&self) -> PathBuf {
        self.directory.path().join("resources")
    }

    /// Returns the Trial's directory.
    pub fn trial(&self) -> PathBuf {
        self.resources().join("crowd")
    }

    /// Returns the path of the FMU.
    pub fn fmu(&self) -> PathBuf {
        self.directory.path().join("crowd.fmu")
    }

    /// Reads, checks and packs the Trial, as `lemons pack` does.
    ///
    /// # Errors
    /// The Trial cannot be packed.
    pub fn pack(&self, format: Format) -> Result<()> {
        let (trials, binaries) = (vec![self.trial()], vec![own_binary()?]);
        Package { trials, binaries, format, ..Package::default() }.write(&self.fmu())?;
        Ok(())
    }
}

/// Some variables of each agent, agent by agent.
fn select(instance: &Instance, agents: usize, names: &[&str]) -> Result<Selection> {
    let all = (0..agents).flat_map(|i| names.iter().map(move |name| format!("agent[{i}].{name}")));
    Ok(instance.select(all)?)
}

/// \[s\] Elapsed time of a call.
fn timed<T>(call: impl FnOnce() -> Result<T>) -> Result<(f64, T)> {
    let start = Instant::now();
    let answer = call()?;
    Ok((start.elapsed().as_secs_f64(), answer))
}

/// Returns the processor time of this thread for a number of calls. Other load on the machine hardly changes it.
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

/// The cost of getting and setting values.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Overhead {
    /// \[µs\] Setting the three inputs of every agent, in one `fmi2SetReal` or `fmi3SetFloat64`.
    pub set: f64,
    /// \[µs\] Getting the ten outputs of every agent, in one `fmi2GetReal` and one `fmi2GetInteger`; in FMI 3.0 whole arrays,
    /// which our master puts in the order of FMI 2.0.
    pub get: f64,
}

/// Measures an FMU's overhead at a communication point, in processor time: the median of several runs of 100 calls
/// each.
///
/// # Errors
/// The FMU refuses a call.
pub fn overhead(agents: usize, runs: usize, format: Format) -> Result<Overhead> {
    const CALLS: u64 = 100;
    let packed = Packed::new(agents, SPARSE)?;
    packed.pack(format)?;
    let instance = Fmu::open(&packed.fmu())?.instantiate("bench")?;
    instance.initialize()?;
    instance.step(0.0, 1e-4)?;
    let (inputs, reals) = (select(&instance, agents, &INPUTS)?, select(&instance, agents, &REALS)?);
    let integers = select(&instance, agents, &INTEGERS)?;
    let given: Vec<f64> = (0..inputs.len()).map(|k| k as f64).collect();
    let (mut numbers, mut counts) = (vec![0.0; reals.len()], vec![0; integers.len()]);
    let set = || instance.set(&inputs, &given);
    let mut get = || {
        instance.get(&reals, &mut numbers)?;
        instance.get(&integers, &mut counts)
    };
    // Check that the FMU accepts it; the measured calls are the same.
    set()?;
    get()?;
    let microseconds = |time: Duration| time.as_secs_f64() * 1e6 / CALLS as f64;
    let (sets, gets) = (0..runs)
        .map(|_| (microseconds(processor_time(CALLS, set)), microseconds(processor_time(CALLS, &mut get))))
        .unzip();
    Ok(Overhead { set: median(sets), get: median(gets) })
}

/// \[s\] Elapsed times of the stages before a crowd can be stepped.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Loading {
    /// Reading and checking the Trial.
    pub read: f64,
    /// Reading, checking and writing the FMU.
    pub pack: f64,
    /// Instantiating the FMU.
    pub instantiate: f64,
    /// From `fmi2SetupExperiment` to `fmi2ExitInitializationMode`.
    pub initialize: f64,
}

/// Measures how long it takes to read, pack, instantiate and initialize a crowd: medians of the runs.
///
/// # Errors
/// The Trial or the FMU is refused.
pub fn loading(agents: usize, runs: usize) -> Result<Loading> {
    let packed = Packed::new(agents, DENSE)?;
    let mut times = [const { Vec::new() }; 4];
    for _ in 0..runs {
        let read = timed(|| Ok(setup::read(&packed.trial())?))?.0;
        let pack = timed(|| packed.pack(Format::default()))?.0;
        let fmu = Fmu::open(&packed.fmu())?;
        let (instantiate, instance) = timed(|| Ok(fmu.instantiate("bench")?))?;
        let initialize = timed(|| Ok(instance.initialize()?))?.0;
        for (times, time) in times.iter_mut().zip([read, pack, instantiate, initialize]) {
            times.push(time);
        }
    }
    let [read, pack, instantiate, initialize] = times.map(median);
    Ok(Loading { read, pack, instantiate, initialize })
}

/// The duration of a run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Run {
    /// \[s\] Elapsed time.
    pub wall: f64,
    /// \[s\] Processor time of this process, all threads.
    pub processor: f64,
}

/// Measures the paper's push: five people in a row before a wall, the first pushed with 700 N. It simulates 5 s with
/// mechanical steps of 2e-6 s through the FMU, in communication steps of 0.1 s, and returns the fastest run.
///
/// # Errors
/// The FMU refuses a call.
pub fn push(runs: usize) -> Result<Run> {
    let packed = Packed { directory: TempDir::with_prefix("lemons-bench-")? };
    std::fs::create_dir_all(packed.trial())?;
    PUSH.extract(packed.trial())?;
    packed.pack(Format::default())?;
    let parameters = [("TimeStepMechanical", "2e-6"), ("agent[0].Fp.x", "700")];
    let settings = Settings {
        parameters: parameters.map(|(name, value)| (name.to_owned(), value.to_owned())).to_vec(),
        step: Some(0.1),
        until: Some(5.0),
        drive: DriveChoice::None,
        ..Settings::of(packed.fmu())
    };
    let mut best: Option<Run> = None;
    for _ in 0..runs {
        let mut prepared = Prepared::of(&settings)?;
        let (wall, processor) = (Instant::now(), ProcessTime::now());
        let clock = prepared.clock;
        let _ = lemons_sim::run::<_, Error>(&mut prepared, &clock, 0, |_, _| Ok(ControlFlow::Continue(())))?;
        let run = Run { wall: wall.elapsed().as_secs_f64(), processor: processor.elapsed().as_secs_f64() };
        if best.is_none_or(|best| run.wall < best.wall) {
            best = Some(run);
        }
    }
    best.ok_or(Error::NoRun)
}
