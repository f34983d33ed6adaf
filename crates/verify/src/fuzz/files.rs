//! Any bytes as files.

use crate::fuzz::models::{small_trial, walkers};
use crate::fuzz::show_panics;
use crowd_mechanics::in_place::{CallError, advance_files};
use crowd_mechanics::model_description::model_description;
use crowd_mechanics::pack::FmuFormat;
use crowd_mechanics::quantities::scalars;
use crowd_mechanics::setup::{self, Setup};
use crowd_mechanics::setup::{dynamics_of, interactions_of};
use lemons_core::trial::{FileNames, Trial};
use lemons_decision::{Decision, DecisionConfig, Plan};
use lemons_fmi::{Model, Step};
use lemons_master::Fmu;
use lemons_master::ssp::ArchiveReader;
use std::collections::HashSet;
use std::io::Write;
use std::path::Path;
use tempfile::TempDir;

/// Mechanical steps that a Trial is advanced by.
const STEPS: f64 = 20.0;

pub(crate) fn directory() -> TempDir {
    TempDir::with_prefix("lemons-fuzz-").expect("a temporary directory")
}

/// One file of a Trial, the first byte says which: it is refused in words, or makes a world that moves, and
/// what is written reads back.
pub fn trial_xml(data: &[u8]) {
    const FILES: [&str; 6] = [
        "Parameters.xml",
        "static/Materials.xml",
        "static/Geometry.xml",
        "static/Agents.xml",
        "dynamic/AgentDynamics.xml",
        "dynamic/AgentInteractions.xml",
    ];
    let Some((&which, content)) = data.split_first() else { return };
    show_panics();
    let directory = directory();
    let place = directory.path().join("Trial");
    small_trial().write(&place).expect("a Trial can be written");
    std::fs::write(place.join(FILES[usize::from(which) % FILES.len()]), content).expect("a file");
    let trial = match setup::read(&place) {
        Ok((trial, _)) => trial,
        Err(problems) => return assert!(problems.has_errors() && !problems.to_string().is_empty()),
    };
    reads_back(&trial, &directory.path().join("read"));
    well_described(&trial);

    let mut world = Setup::of(&trial).world().expect("a Trial as read makes a world");
    if world.advance(STEPS * trial.parameters.time_step_mechanical).is_err() {
        return;
    }
    let (dynamics, interactions) = (dynamics_of(&world), interactions_of(&world));
    let moved = directory.path().join("moved");
    reads_back(&Trial { dynamics, interactions, ..trial.clone() }, &moved);

    if trial.parameters.time_step < STEPS * trial.parameters.time_step_mechanical {
        match advance_files(&moved.join("Parameters.xml"), &FileNames::default()) {
            Ok(()) => assert!(setup::read(&moved).is_ok(), "what the C entry point wrote reads back"),
            Err(CallError::Advance(why)) => assert!(why.contains("finite"), "{why}"),
            // The file system's own reasons, such as a name too long.
            Err(CallError::Write(_)) => {}
            Err(other) => panic!("{other}"),
        }
    }
}

fn reads_back(trial: &Trial, place: &Path) {
    // The file system's own reasons, such as a name too long.
    if trial.write(place).is_err() {
        return;
    }
    let (mut back, _) = setup::read(place).unwrap_or_else(|problems| panic!("{problems}"));
    (back.name, back.directory) = (trial.name.clone(), trial.directory.clone());
    // Directories outside the Trial's become its own.
    back.parameters.static_directory.clone_from(&trial.parameters.static_directory);
    back.parameters.dynamic_directory.clone_from(&trial.parameters.dynamic_directory);
    assert_eq!(&back, trial);
}

/// A model description that is XML, with unique names.
fn well_described(trial: &Trial) {
    let text = model_description(trial, FmuFormat::default());
    roxmltree::Document::parse(&text).unwrap_or_else(|error| panic!("{error} in {text}"));
    let mut names = HashSet::new();
    for scalar in scalars(trial) {
        assert!(names.insert(scalar.name.clone()), "{} stands twice", scalar.name);
    }
}

/// An `.fmu`: the bytes themselves, or, after an odd byte, an archive in which they are the model description.
pub fn fmu_archive(data: &[u8]) {
    let Some((&way, content)) = data.split_first() else { return };
    show_panics();
    let directory = directory();
    let path = directory.path().join("x.fmu");
    let bytes = if way % 2 == 0 { content.to_vec() } else { archive("modelDescription.xml", content) };
    std::fs::write(&path, bytes).expect("a file");
    if let Ok(fmu) = Fmu::open(&path)
        && let Ok(resources) = fmu.resources()
    {
        let _ = resources.load(resources.first());
    }
}

/// An `.ssp`: the bytes themselves, an archive in which they are the structure, or the interface of an FMU.
pub fn ssp_archive(data: &[u8]) {
    let Some((&way, content)) = data.split_first() else { return };
    show_panics();
    let content = match way % 3 {
        0 => content.to_vec(),
        1 => archive(lemons_master::ssp::STRUCTURE_FILE, content),
        _ => {
            let _ = lemons_master::ssp::Interface::read(content);
            return;
        }
    };
    let directory = directory();
    let path = directory.path().join("x.ssp");
    std::fs::write(&path, content).expect("a file");
    let structure = ArchiveReader::open(&path).and_then(|mut archive| archive.structure());
    match structure {
        Ok(structure) => {
            for connection in &structure.connections {
                for port in [&connection.from, &connection.to] {
                    structure.port(port);
                }
            }
        }
        Err(error) => assert!(!format!("{error:#}").is_empty()),
    }
}

fn archive(name: &str, content: &[u8]) -> Vec<u8> {
    archive_of(&[(name, content)])
}

pub(crate) fn archive_of(files: &[(&str, &[u8])]) -> Vec<u8> {
    let mut archive = zip::ZipWriter::new(std::io::Cursor::new(Vec::new()));
    // The same bytes whenever it is made: a crash comes again.
    let stored = zip::write::SimpleFileOptions::default()
        .last_modified_time(zip::DateTime::default())
        .compression_method(zip::CompressionMethod::Stored);
    for (name, content) in files {
        archive.start_file(*name, stored).expect("an entry");
        archive.write_all(content).expect("written into memory");
    }
    archive.finish().expect("an archive").into_inner()
}

/// `decision.toml`, after a byte that says nothing: refused in words, or a plan that can be asked for drives, and whose
/// settings read back.
pub fn decision_toml(data: &[u8]) {
    let Some((_, content)) = data.split_first() else { return };
    let Ok(text) = std::str::from_utf8(content) else { return };
    show_panics();
    let read = |text: &str| DecisionConfig::from_toml(text).and_then(|config| Plan::of(&walkers(), &config));
    let plan = match read(text) {
        Ok(plan) => plan,
        Err(error) => return assert!(!error.to_string().is_empty()),
    };
    let written = plan.config.to_toml().expect("settings can be written");
    assert_eq!(read(&written).as_ref(), Ok(&plan), "{written}");
    let mut decision = Decision::new(plan);
    for scalar in decision.scalars() {
        // Absurd ones are refused.
        assert!(decision.number(scalar.variable.quantity, scalar.element).map_or(true, f64::is_finite));
    }
    decision.advance(Step::of(1.0, 1.0)).expect("a decision");
}
