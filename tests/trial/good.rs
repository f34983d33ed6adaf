//! The small Trial without errors of the directory `good`, and changes of it.

use crowd_mechanics::setup::{self};
use lemons_core::trial::*;
use std::fs;
use std::path::Path;
use tempfile::TempDir;

pub const FILES: [&str; 5] = [
    "Parameters.xml",
    "static/Materials.xml",
    "static/Geometry.xml",
    "static/Agents.xml",
    "dynamic/AgentDynamics.xml",
];
pub const INTERACTIONS: &str = "dynamic/AgentInteractions.xml";

/// Two agents in a room; each file short enough to know its lines.
pub fn good() -> Vec<(&'static str, String)> {
    let directory = lemons_testing::repository().join("tests/trial/good");
    let text = |file| fs::read_to_string(directory.join(file)).unwrap().trim_end().to_owned();
    FILES.into_iter().chain([INTERACTIONS]).map(|file| (file, text(file))).collect()
}

pub fn put(directory: &Path, files: &[(&str, String)]) {
    for (file, text) in files {
        let path = directory.join(file);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, text).unwrap();
    }
}

/// What reading the good Trial says after the first occurrence of `old` in `file` became `new`.
pub fn edited(edits: &[(&str, &str, &str)]) -> Result<(Trial, Problems), Problems> {
    let mut files = good();
    for &(file, old, new) in edits {
        let (_, text) = files.iter_mut().find(|(name, _)| *name == file).unwrap();
        assert!(text.contains(old), "{file} has no {old}");
        *text = text.replacen(old, new, 1);
    }
    let directory = TempDir::new().unwrap();
    put(directory.path(), &files);
    setup::read(directory.path())
}

/// The same Trial but for where it lies.
pub fn moved(trial: &Trial, to: &Trial) -> Trial {
    Trial { name: to.name.clone(), directory: to.directory.clone(), ..trial.clone() }
}
