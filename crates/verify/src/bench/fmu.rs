//! The cost of running a crowd as an FMU: getting and setting values, loading, and the paper's push.
//!
//! The Trials are generated, and packed with the library that was built with this program.

use crate::bench::accuracy::{PUSH, trial};
use crate::bench::median;
use crate::checks::scenes::Random;
use crate::checks::{Error, Result};
use cpu_time::{ProcessTime, ThreadTime};
use crowd_mechanics::pack::{Format, Package};
use crowd_mechanics::setup;
use lemons_core::plane::{Vec2, vec2};
use lemons_core::trial::{Agent, AgentDynamics, DriveChoice};
use lemons_master::{Fmu, Instance, Prepared, Selection, Settings, own_binary};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
use tempfile::TempDir;

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
    let (mut trial, _source) = trial(&PUSH)?;
    "crowd".clone_into(&mut trial.name);
    (trial.parameters.time_step, trial.parameters.time_step_mechanical) = (0.1, 1e-5);
    trial.geometry.dimensions = Some(vec2(width, height));
    trial.geometry.walls.truncate(1);
    let corners = [(0.0, 0.0), (width, 0.0), (width, height), (0.0, height), (0.0, 0.0)];
    trial.geometry.walls[0].corners = corners.map(|(x, y)| vec2(x, y)).to_vec();
    let (person, start) = (trial.agents[0].clone(), trial.dynamics[0].clone());
    trial.agents = (0..agents).map(|k| Agent { id: k.to_string(), ..person.clone() }).collect();
    let mut numbers = Random(30);
    let places = (0..agents).map(|k| {
        let along = |of: usize, spacing: f64, shift: f64| spacing * (of as f64 + 0.5) + 0.01 * shift;
        AgentDynamics {
            position: vec2(
                along(k % columns, spacing.x, numbers.signed()),
                along(k / columns, spacing.y, numbers.signed()),
            ),
            theta: 0.5 * numbers.signed(),
            fp: vec2(100.0 * numbers.signed(), 100.0 * numbers.signed()),
            mp: numbers.signed(),
            ..start.clone()
        }
    });
    trial.dynamics = places.collect();
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
    let (mut numbers, mut counts) = (vec![0.0; reals.len()], vec![0.0; integers.len()]);
    let set = || instance.set(&inputs, &given);
    let mut get = || {
        instance.get(&reals, &mut numbers)?;
        instance.get(&integers, &mut counts)
    };
    // Check that the FMU accepts it; the measured calls are the same.
    set()?;
    get()?;
    let microseconds = |time: Duration| time.as_secs_f64() * 1e6 / CALLS as f64;
    let (mut sets, mut gets): (Vec<f64>, Vec<f64>) = (0..runs)
        .map(|_| (microseconds(processor_time(CALLS, set)), microseconds(processor_time(CALLS, &mut get))))
        .unzip();
    Ok(Overhead { set: median(&mut sets), get: median(&mut gets) })
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
    let [read, pack, instantiate, initialize] = times.map(|mut times| median(&mut times));
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
