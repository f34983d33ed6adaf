//! The same scenario makes the same files by the command and by the crate that all others use.

use crate::common::done;
use lemons_core::files::source::LocalFiles;
use lemons_scenario::{MOST_PEOPLE, Scenario};
use std::fs;
use std::ops::ControlFlow;
use tempfile::TempDir;

#[test]
fn the_command_makes_the_files_of_a_scenario() {
    let directory = TempDir::new().unwrap();
    let at = directory.path();
    for (name, file) in lemons_testing::scenarios() {
        let (name, path) = (name.as_str(), file.to_str().unwrap());
        done(at, &["crowd", "--scenario", path, "-o", name, "--save-scenario", "again.toml", "--force"]);
        let scenario = Scenario::read(&LocalFiles, &file).unwrap();
        assert_eq!(Scenario::read(&LocalFiles, &at.join("again.toml")).unwrap(), scenario, "{name}");
        let mut watch = |_: &_| ControlFlow::Continue(());
        let made = scenario.documents(name, MOST_PEOPLE, &LocalFiles, &mut watch).unwrap();
        for (path, text) in made.trial.texts(&at.join(name)) {
            assert_eq!(fs::read_to_string(&path).unwrap(), text, "{name}: {}", path.display());
        }
        let beside = ["decision.toml", "drive.csv"];
        let own = beside.map(|file| Some((file, fs::read_to_string(at.join(name).join(file)).ok()?)));
        assert_eq!(own.into_iter().flatten().collect::<Vec<_>>(), made.beside().unwrap(), "{name}");
    }
}
