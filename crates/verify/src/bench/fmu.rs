//! The cost of running a crowd as an FMU: getting and setting values, loading, and the paper's push.
//!
//! The Trials are generated, and packed with the library that was built with this program.

use crate::bench::accuracy::PUSH;
use crate::bench::{DENSE, median};
use crate::checks::scenarios::read;
use anyhow::Result;
use cpu_time::{ProcessTime, ThreadTime};
use crowd_mechanics::pack::{FmuFormat, Package};
use crowd_mechanics::scenes::crowded;
use crowd_mechanics::setup;
use lemons_core::files::Scratch;
use lemons_core::plane::{Vec2, vec2};
use lemons_core::trial::DriveChoice;
use lemons_master::{Fmu, PreparedSystem, RunSettings, ValueSelection, own_binary};
use std::path::PathBuf;
use std::time::Instant;

/// \[m\] Spacing: one person per 2 m².
const SPARSE: Vec2 = vec2(1.4, 1.4);

/// A Trial in a temporary directory, and its FMU there.
struct Packed {
    directory: Scratch,
}

impl Packed {
    /// Writes the Trial of a crowd; [`Packed::pack`] makes the FMU.
    fn new(agents: usize, spacing: Vec2) -> Result<Packed> {
        let packed = Packed { directory: Scratch::new()? };
        crowded(read(PUSH)?, agents, spacing).write(&packed.trial())?;
        Ok(packed)
    }

    fn trial(&self) -> PathBuf {
        self.directory.path().join("crowd")
    }

    fn fmu(&self) -> PathBuf {
        self.directory.path().join("crowd.fmu")
    }

    /// Reads, checks and packs the Trial, as `lemons pack` does.
    fn pack(&self, format: FmuFormat) -> Result<()> {
        let (trials, binaries) = (vec![self.trial()], vec![own_binary()?]);
        Package { trials, binaries, format, ..Package::default() }.write(&self.fmu())?;
        Ok(())
    }
}

/// \[s\] Elapsed time of a call.
fn timed<T>(call: impl FnOnce() -> Result<T>) -> Result<(f64, T)> {
    let start = Instant::now();
    let answer = call()?;
    Ok((start.elapsed().as_secs_f64(), answer))
}

/// Measures what lies around the mechanics. `row` gets what was measured, the figure and its unit, one after the other.
///
/// # Errors
/// A Trial or an FMU is refused, or the row.
pub fn measure(runs: usize, mut row: impl FnMut(&str, f64, &str) -> Result<()>) -> Result<()> {
    for (version, format) in [("", FmuFormat::default()), (" (FMI 3.0)", FmuFormat::Fmi3)] {
        let [set, get] = overhead(1_000, runs, format)?;
        row(&format!("1000 agents: set 3 inputs of each{version}"), set, "µs")?;
        row(&format!("1000 agents: get 10 outputs of each{version}"), get, "µs")?;
    }
    let what =
        ["read and check the Trial", "read, check and pack it", "instantiate the FMU", "initialize it"];
    for (what, time) in what.into_iter().zip(loading(10_000, runs)?) {
        row(&format!("10 000 agents: {what}"), time, "s")?;
    }
    let [wall, processor] = push(runs)?;
    row("push, 5 s at 2e-6 s: wall time", wall, "s")?;
    row("push, 5 s at 2e-6 s: processor time", processor, "s")
}

/// \[µs\] Processor times of setting the three inputs of every agent in one call, and of getting the ten outputs in one
/// call for each type (in FMI 3.0 whole arrays, which our master puts in the order of FMI 2.0): medians of runs of 100
/// calls. Other load on the machine hardly changes them.
fn overhead(agents: usize, runs: usize, format: FmuFormat) -> Result<[f64; 2]> {
    const CALLS: u32 = 100;
    let packed = Packed::new(agents, SPARSE)?;
    packed.pack(format)?;
    let instance = Fmu::open(&packed.fmu())?.instantiate("bench")?;
    instance.initialize()?;
    instance.step(0.0, 1e-4)?;
    let select = |names: &'static [&str]| -> Result<ValueSelection> {
        let all = (0..agents).flat_map(|i| names.iter().map(move |name| format!("agent[{i}].{name}")));
        Ok(instance.select(all)?)
    };
    let inputs = select(&["Fp.x", "Fp.y", "Mp"])?;
    let reals =
        select(&["Position.x", "Position.y", "Theta", "Velocity.x", "Velocity.y", "Omega", "NormalForce"])?;
    let integers = select(&["AgentContacts", "WallContacts", "ContactingAgents"])?;
    let given: Vec<f64> = (0..inputs.len()).map(|k| k as f64).collect();
    let time = |call: &mut dyn FnMut() -> Result<()>| -> Result<f64> {
        let start = ThreadTime::now();
        (0..CALLS).try_for_each(|_| call())?;
        Ok(start.elapsed().as_secs_f64() * 1e6 / f64::from(CALLS))
    };
    let mut times = [const { Vec::new() }; 2];
    for _ in 0..runs {
        times[0].push(time(&mut || Ok(instance.set(&inputs, &given)?))?);
        times[1].push(time(&mut || {
            for all in [&reals, &integers] {
                instance.values::<f64>(all)?;
            }
            Ok(())
        })?);
    }
    Ok(times.map(|mut times| median(&mut times)))
}

/// \[s\] Elapsed times of reading and checking a Trial, of packing it too, of instantiating its FMU, and of initializing
/// it: medians of the runs.
fn loading(agents: usize, runs: usize) -> Result<[f64; 4]> {
    let packed = Packed::new(agents, DENSE)?;
    let mut times = [const { Vec::new() }; 4];
    for _ in 0..runs {
        let read = timed(|| Ok(setup::read(&packed.trial())?))?.0;
        let pack = timed(|| packed.pack(FmuFormat::default()))?.0;
        let fmu = Fmu::open(&packed.fmu())?;
        let (instantiate, instance) = timed(|| Ok(fmu.instantiate("bench")?))?;
        let initialize = timed(|| Ok(instance.initialize()?))?.0;
        for (times, time) in times.iter_mut().zip([read, pack, instantiate, initialize]) {
            times.push(time);
        }
    }
    Ok(times.map(|mut times| median(&mut times)))
}

/// \[s\] Elapsed time of the paper's push, and processor time of all threads, in the fastest run: five people in a row
/// before a wall, the first pushed with 700 N, 5 s with mechanical steps of 2e-6 s through the FMU, in communication
/// steps of 0.1 s.
fn push(runs: usize) -> Result<[f64; 2]> {
    let packed = Packed { directory: Scratch::new()? };
    read(PUSH)?.write(&packed.trial())?;
    packed.pack(FmuFormat::default())?;
    let parameters = [("TimeStepMechanical", "2e-6"), ("agent[0].Fp.x", "700")];
    let settings = RunSettings {
        parameters: parameters.map(|(name, value)| (name.to_owned(), value.to_owned())).to_vec(),
        step: Some(0.1),
        until: Some(5.0),
        drive: DriveChoice::None,
        ..RunSettings::of(packed.fmu())
    };
    let mut best = [f64::INFINITY; 2];
    for _ in 0..runs {
        let mut prepared = PreparedSystem::of(&settings)?;
        let (wall, processor) = (Instant::now(), ProcessTime::now());
        prepared.clock.points(0).try_for_each(|time| prepared.step_to(time))?;
        let run = [wall.elapsed().as_secs_f64(), processor.elapsed().as_secs_f64()];
        if run[0] < best[0] {
            best = run;
        }
    }
    Ok(best)
}
