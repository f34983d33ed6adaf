//! Runs of an FMU from settings, as any program makes them, against a loop written out here.

use crate::packed;
use crowd_mechanics::pack::FmuFormat;
use lemons_core::files::Staged;
use lemons_core::trial::DriveChoice;
use lemons_master::{Fmu, FmuInstance, MasterError, PreparedSystem, RunSettings, SavedRun};
use std::path::Path;
use tempfile::TempDir;

const AGENTS: usize = 5;

/// Bits of a time, and of all poses then.
type Row = (u64, Vec<u64>);

fn row(instance: &FmuInstance, time: f64) -> Result<Row, MasterError> {
    let of = |i: usize| ["Position.x", "Position.y", "Theta"].map(|name| format!("agent[{i}].{name}"));
    let values: Vec<f64> = instance.values(&instance.select((0..AGENTS).flat_map(of))?)?;
    Ok((time.to_bits(), values.into_iter().map(f64::to_bits).collect()))
}

/// Runs at most so many steps and notes the poses after each.
fn poses(settings: &RunSettings, most: usize) -> (PreparedSystem, Vec<Row>) {
    let mut run = PreparedSystem::of(settings).unwrap();
    let begun = run.before.as_ref().map_or(0, |before| before.index);
    let mut rows = Vec::new();
    for time in run.clock.points(begun).take(most) {
        run.step_to(time).unwrap();
        rows.push(row(&run.system.components[0].instance, time).unwrap());
    }
    (run, rows)
}

/// Agent 0 is pushed with 900 N until 0.7 s; everybody has 80 kg.
fn by_hand(fmu: &Path, step: f64, steps: u32) -> Vec<Row> {
    let fmu = Fmu::open(fmu).unwrap();
    let instance = fmu.instantiate("by_hand").unwrap();
    let select = |name: &str| instance.select([name]).unwrap();
    (0..AGENTS).for_each(|i| instance.set(&select(&format!("agent[{i}].Mass")), &[80.0]).unwrap());
    instance.set(&select("TimeStepMechanical"), &[1e-5]).unwrap();
    instance.initialize().unwrap();
    let rows = (0..steps).map(|k| {
        let (from, to) = (f64::from(k) * step, f64::from(k + 1) * step);
        let force = if from <= 0.7 { 900.0 } else { 0.0 };
        instance.set(&select("agent[0].Fp.x"), &[force]).unwrap();
        instance.step(from, to - from).unwrap();
        row(&instance, to).unwrap()
    });
    rows.collect()
}

fn pushed(directory: &Path) -> RunSettings {
    let drive = directory.join("push.csv");
    std::fs::write(&drive, "t,agent,Fp.x,Fp.y,Mp\n0,0,900,0,0\n0.7,0,900,0,0\n").unwrap();
    let parameters = [("agent[*].Mass", "80"), ("TimeStepMechanical", "1e-5")];
    RunSettings {
        parameters: parameters.map(|(name, value)| (name.to_owned(), value.to_owned())).to_vec(),
        until: Some(2.0),
        drive: DriveChoice::File(drive),
        ..RunSettings::of(packed(directory, FmuFormat::default()))
    }
}

#[test]
fn an_fmu_runs_to_the_bits_of_a_loop_by_hand() {
    let directory = TempDir::new().unwrap();
    let settings = pushed(directory.path());
    let (run, rows) = poses(&settings, usize::MAX);
    assert!(run.warnings.is_empty(), "{:?}", run.warnings);
    assert_eq!((run.clock.step, run.every, run.coupled), (0.05, 1, false));
    assert_eq!(run.trials[0].as_ref().unwrap().agents.len(), AGENTS);
    assert_eq!(rows.len(), 40);
    assert!(rows == by_hand(&settings.input, 0.05, 40), "other bits");
    let moved = |i: usize| f64::from_bits(rows[39].1[3 * i]) - f64::from_bits(rows[0].1[3 * i]);
    assert!(moved(0) > 0.1 && moved(1) > 0.01, "one feed the next: {} m, {} m", moved(0), moved(1));
}

/// Saves the run where it is.
fn save(run: &mut PreparedSystem, index: u64, path: &Path) {
    let states = run.system.states().unwrap();
    let saved = SavedRun {
        format: SavedRun::FORMAT,
        lemons: "a test".into(),
        start: run.clock.start,
        step: run.clock.step,
        until: run.clock.until,
        index,
        time: run.system.time,
        every: run.every,
        algorithm: run.system.algorithm.to_string(),
        wiring: run.system.fingerprint.clone(),
        drive: run.feed.drive.fingerprint(),
        component: run.system.records(),
        crowd: Vec::new(),
    };
    saved.write(&states, Staged::beside(path).unwrap()).unwrap();
}

#[test]
fn a_saved_run_goes_on_to_the_same_bits() {
    let directory = TempDir::new().unwrap();
    let settings = RunSettings { saves: true, ..pushed(directory.path()) };
    let (_, whole) = poses(&settings, usize::MAX);
    // In the middle of the push, with people in contact.
    let (mut run, begun) = poses(&settings, 9);
    let path = directory.path().join("half.run");
    save(&mut run, 9, &path);
    drop(run);
    let on = RunSettings { parameters: Vec::new(), until: None, resume: Some(path), ..settings };
    let (run, rest) = poses(&on, usize::MAX);
    let before = run.before.as_ref().unwrap();
    assert_eq!((before.index, before.time, before.lemons.as_str()), (9, 0.45, "a test"));
    assert_eq!((begun.len(), rest.len()), (9, 31));
    assert!([begun, rest].concat() == whole, "other bits");
}
