//! The same scenario makes the same files by the command and by the crate that all others use.

use crate::common::{done, root};
use lemons_core::files::source::Disk;
use lemons_scenario::{MOST_PEOPLE, Scenario};
use std::fs;
use std::ops::ControlFlow;
use tempfile::TempDir;

#[test]
fn the_command_makes_the_files_of_a_scenario() {
    let directory = TempDir::new().unwrap();
    let at = directory.path();
    let mut count = 0;
    for file in fs::read_dir(root().join("crates/scenario/tests/crowds")).unwrap() {
        let file = file.unwrap().path();
        let (name, path) = (file.file_stem().unwrap().to_str().unwrap(), file.to_str().unwrap());
        done(at, &["crowd", "--scenario", path, "-o", name, "--save-scenario", "again.toml", "--force"]);
        let scenario = Scenario::read(&Disk, &file).unwrap();
        assert_eq!(Scenario::read(&Disk, &at.join("again.toml")).unwrap(), scenario, "{name}");
        let mut watch = |_: &_| ControlFlow::Continue(());
        let made = scenario.documents(name, MOST_PEOPLE, &Disk, &mut watch).unwrap();
        for (path, text) in made.trial.texts(&at.join(name)) {
            assert_eq!(fs::read_to_string(&path).unwrap(), text, "{name}: {}", path.display());
        }
        let decision = made.decision.map(|(config, _)| config.to_toml().unwrap());
        assert_eq!(fs::read_to_string(at.join(name).join("decision.toml")).ok(), decision, "{name}");
        let drive = Some(made.drive).filter(|text| !text.is_empty());
        assert_eq!(fs::read_to_string(at.join(name).join("drive.csv")).ok(), drive, "{name}");
        count += 1;
    }
    assert!(count >= 20);
}
