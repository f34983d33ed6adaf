//! `lemons connect` and `lemons run FILE.ssp` as their users meet them.

#[path = "../../../../tests/coupling/controller.rs"]
pub mod controller;

use crate::common::done;
use controller::{DESCRIPTION, write_controller};
use std::fs;
use std::path::Path;
use std::process::Command;
use tempfile::TempDir;

/// `crowd.fmu` of the default Trial, and `controller.fmu`.
fn fmus(binary: bool) -> TempDir {
    let directory = TempDir::new().unwrap();
    let trial = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../resources/Trial_push");
    done(directory.path(), &["pack", trial.to_str().unwrap(), "-o", "crowd.fmu"]);
    write_controller(&directory.path().join("controller.fmu"), DESCRIPTION, binary);
    directory
}

const CONNECT: [&str; 5] = ["connect", "controller.fmu", "crowd.fmu", "-o", "coupled.ssp"];

/// A step of 7.5e8 mechanical ones, which takes minutes: the run ends before it does.
#[test]
#[cfg(unix)]
fn one_long_step_of_coupled_fmus_can_be_interrupted() {
    let directory = fmus(true);
    let at = directory.path();
    done(at, &CONNECT);
    let mut child = Command::new(env!("CARGO_BIN_EXE_lemons"))
        .args(["run", "coupled.ssp", "--step", "1500", "--until", "1500"])
        .current_dir(at)
        .stderr(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    // The step is under way a moment after the files are begun.
    while fs::read_dir(at).unwrap().count() < 5 {
        assert!(child.try_wait().unwrap().is_none(), "it ended by itself");
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
    std::thread::sleep(std::time::Duration::from_secs(1));
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    let output = child.wait_with_output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(130), "{said}");
    assert!(said.contains("stopped at t = 0.0 s"), "{said}");
    for file in ["trajectories.csv", "outputs.csv"] {
        assert!(fs::read_to_string(at.join(file)).unwrap().lines().count() > 1);
    }
}
