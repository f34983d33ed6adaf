//! The loop of the program fmusim, which is the module `sim` of fmi-rs: inputs from CSV, steps, a record. It shows what a
//! run of ours shows, and its validation finds no problem in the descriptions.

#![allow(clippy::arc_with_non_send_sync)] // `simulate` takes an `Arc` of its recorder

use crate::packed;
use crowd_mechanics::pack::FmuFormat;
use fmi_rs::fmi3::LibraryKind;
use fmi_rs::model_description::{fmi2, fmi3};
use fmi_rs::sim::fmi2 as sim2;
use fmi_rs::sim::fmi3 as sim3;
use lemons_core::trial::DriveChoice;
use lemons_master::{Fmu, PreparedSystem, RunSettings};
use std::path::Path;
use std::sync::Arc;
use tempfile::TempDir;

/// \[s\] A power of two: every importer then has the same times.
const STEP: f64 = 1.0 / 16.0;
const STOP: f64 = 2.0;
const AGENTS: usize = 5;

/// Outputs of an agent, and whether they have two elements.
const SHOWN: [(&str, bool); 4] =
    [("Position", true), ("Theta", false), ("Velocity", true), ("PeakNormalForce", false)];

/// Names of the elements of [`SHOWN`], in the order of the arrays of FMI 3.0.
fn elements() -> Vec<String> {
    let of = |(name, is_vector): (&'static str, bool)| {
        let axes = if is_vector { &[".x", ".y"][..] } else { &[""] };
        (0..AGENTS).flat_map(move |i| axes.iter().map(move |axis| format!("agent[{i}].{name}{axis}")))
    };
    SHOWN.into_iter().flat_map(of).collect()
}

/// Values of a run of ours after each step, while agent 0 is pushed with 700 N.
fn ours(fmu: &Path, directory: &Path) -> Vec<Vec<u64>> {
    let drive = directory.join("drive.csv");
    std::fs::write(&drive, "t,agent,Fp.x,Fp.y,Mp\n0,0,700,0,0\n9,0,700,0,0\n").unwrap();
    let mut run = PreparedSystem::of(&RunSettings {
        step: Some(STEP),
        until: Some(STOP),
        drive: DriveChoice::File(drive),
        ..RunSettings::of(fmu.to_owned())
    })
    .unwrap();
    let points: Vec<_> = run.clock.points(0).collect();
    let mut rows = Vec::new();
    for time in points {
        run.step_to(time).unwrap();
        let instance = &run.system.components[0].instance;
        rows.push(bits(&instance.values(&instance.select(elements()).unwrap()).unwrap()));
    }
    rows
}

fn bits(values: &[f64]) -> Vec<u64> {
    values.iter().map(|value| value.to_bits()).collect()
}

/// In the file of FMI 3.0, `Mp` is called like another variable.
#[test]
fn its_validation_finds_no_problem_but_would_find_one() {
    let directory = TempDir::new().unwrap();
    for format in [FmuFormat::default(), FmuFormat::Fmi3] {
        let fmu = Fmu::open(&packed(directory.path(), format)).unwrap();
        let path = fmu.directory().join("modelDescription.xml");
        let problems = match format {
            FmuFormat::Fmi3 => fmi3::ModelDescription::from_path(&path).unwrap().validate(),
            _ => fmi2::ModelDescription::from_path(&path).unwrap().validate(),
        };
        assert!(problems.is_empty(), "{problems:?}");
        if format == FmuFormat::Fmi3 {
            let text = std::fs::read_to_string(&path).unwrap();
            let other = directory.path().join("other.xml");
            std::fs::write(&other, text.replace("name=\"Mp\"", "name=\"Fp\"")).unwrap();
            let problems = fmi3::ModelDescription::from_path(&other).unwrap().validate();
            assert!(problems.iter().any(|problem| problem.message.contains("Fp")), "{problems:?}");
        }
    }
}

#[test]
fn it_shows_the_bits_of_our_run_in_fmi_2() {
    let directory = TempDir::new().unwrap();
    let path = packed(directory.path(), FmuFormat::default());
    let fmu = Fmu::open(&path).unwrap();
    let description =
        Arc::new(fmi2::ModelDescription::from_path(&fmu.directory().join("modelDescription.xml")).unwrap());
    let indices = elements().iter().map(|name| description.variable_index_by_name(name).unwrap()).collect();
    let recorder =
        Arc::new(sim2::recorder::Recorder::new(sim2::Trajectories::new(description.clone(), indices)));
    let table = "time,agent[0].Fp.x\n0,700\n9,700\n";
    let input = sim2::csv::read_csv(table.as_bytes(), description.clone()).unwrap();
    let settings = sim2::SimulationSettings {
        unzipdir: fmu.directory().to_owned(),
        model_description: description,
        start_time: 0.0,
        stop_time: STOP,
        logging_on: false,
        set_stop_time: true,
        output_interval: STEP,
        log_time_scale: false,
        tolerance: 1e-6,
        set_tolerance: false,
        start_values: Vec::new(),
        log_fmi_calls: false,
        input_file: None,
        early_return_allowed: false,
        event_mode_used: false,
        log_file: None,
        initial_fmu_state_file: None,
        final_fmu_state_file: None,
    };
    let input = Arc::new(sim2::input::StaticInput::new(input, settings.tolerance));
    sim2::cs::simulate(&settings, Some(input), recorder.clone()).unwrap();
    let seen = Arc::try_unwrap(recorder).unwrap().into_trajectories();
    let number = |value: &sim2::VariableValue| value.to_f64().unwrap().to_bits();
    let theirs: Vec<Vec<u64>> = seen.rows.iter().map(|row| row.iter().map(number).collect()).collect();
    assert_alike(&theirs, &ours(&path, directory.path()));
}

#[test]
fn it_shows_the_bits_of_our_run_in_fmi_3() {
    let directory = TempDir::new().unwrap();
    let path = packed(directory.path(), FmuFormat::Fmi3);
    let fmu = Fmu::open(&path).unwrap();
    let description =
        Arc::new(fmi3::ModelDescription::from_path(&fmu.directory().join("modelDescription.xml")).unwrap());
    let indices = SHOWN.map(|(name, _)| description.variable_index_by_name(name).unwrap()).to_vec();
    let recorder =
        Arc::new(sim3::recorder::Recorder::new(sim3::Trajectories::new(description.clone(), indices)));
    let force = format!("700{}", " 0".repeat(2 * AGENTS - 1));
    let table = format!("time,Fp\n0,{force}\n9,{force}\n");
    let input = sim3::csv::read_csv(table.as_bytes(), description.clone()).unwrap();
    let settings = sim3::SimulationSettings {
        unzipdir: fmu.directory().to_owned(),
        model_description: description,
        library_kind: LibraryKind::Native,
        enable_dae: false,
        start_time: 0.0,
        stop_time: STOP,
        visible: false,
        logging_on: false,
        set_stop_time: true,
        output_interval: STEP,
        log_time_scale: false,
        tolerance: 1e-6,
        set_tolerance: false,
        start_values: Vec::new(),
        log_fmi_calls: false,
        intermediate_update: false,
        input_file: None,
        early_return_allowed: false,
        event_mode_used: false,
        log_file: None,
        initial_fmu_state_file: None,
        final_fmu_state_file: None,
    };
    let input = Arc::new(sim3::input::StaticInput::new(input, settings.tolerance));
    sim3::cs::simulate(&settings, Some(input), recorder.clone()).unwrap();
    let seen = Arc::try_unwrap(recorder).unwrap().into_trajectories();
    let numbers = |value: &sim3::VariableValue| bits(&value.as_f64().unwrap());
    let theirs: Vec<Vec<u64>> = seen.rows.iter().map(|row| row.iter().flat_map(numbers).collect()).collect();
    assert_alike(&theirs, &ours(&path, directory.path()));
}

/// The first row of theirs is the start.
fn assert_alike(theirs: &[Vec<u64>], ours: &[Vec<u64>]) {
    assert_eq!((theirs.len(), ours.len()), (33, 32));
    for (k, (theirs, ours)) in theirs[1..].iter().zip(ours).enumerate() {
        assert_eq!(theirs, ours, "step {k}");
    }
    let squeeze =
        |row: &Vec<u64>| row[row.len() - AGENTS..].iter().map(|it| f64::from_bits(*it)).fold(0.0, f64::max);
    assert!(ours.iter().map(squeeze).fold(0.0, f64::max) > 100.0, "they touch");
}
