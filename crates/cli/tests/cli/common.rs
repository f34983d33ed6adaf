//! What the tests of the command share.

pub use lemons_testing::{repository as root, trial_push as default_trial};
#[cfg(target_os = "linux")]
use std::fs::DirEntry;
use std::path::Path;
use std::process::{Child, Command, Output};
use std::sync::Once;
use std::time::Duration;

/// A copy of the default Trial.
pub fn copy_trial(to: &Path) {
    let files = [
        "Parameters.xml",
        "static/Agents.xml",
        "static/Geometry.xml",
        "static/Materials.xml",
        "dynamic/AgentDynamics.xml",
        "drive.csv",
    ];
    for part in files {
        let target = to.join(part);
        std::fs::create_dir_all(target.parent().unwrap()).unwrap();
        std::fs::copy(default_trial().join(part), target).unwrap();
    }
}

pub fn command(directory: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_lemons"));
    command.args(arguments).current_dir(directory);
    // What it remembers of files, not what the user's own commands remember.
    command.env("XDG_STATE_HOME", Path::new(env!("CARGO_TARGET_TMPDIR")).join("state"));
    command
}

/// Builds the Decision FMU's library beside the command, where `lemons decide` looks for it: no test links it.
pub fn decision_library() {
    static BUILT: Once = Once::new();
    BUILT.call_once(|| {
        let beside = Path::new(env!("CARGO_BIN_EXE_lemons")).parent().unwrap();
        let mut cargo = Command::new(env!("CARGO"));
        cargo.current_dir(root()).args([
            "build",
            "--quiet",
            "--package",
            "lemons-decision-fmu",
            "--target-dir",
        ]);
        cargo.arg(beside.parent().unwrap());
        if beside.ends_with("release") {
            cargo.arg("--release");
        }
        assert!(cargo.status().unwrap().success());
    });
}

/// Returns when a command waits for somebody: all of its threads have slept whenever they were looked at, for 0.3 s. On a
/// busy machine a thread that has something to do does not sleep, but waits for a processor.
#[cfg(target_os = "linux")]
pub fn waits(child: &Child) {
    let sleeps = |task: std::io::Result<DirEntry>| {
        let stat = std::fs::read_to_string(task.unwrap().path().join("stat")).unwrap_or_default();
        stat.rsplit(')').next().is_some_and(|rest| rest.trim_start().starts_with('S'))
    };
    let mut quiet = 0;
    while quiet < 30 {
        std::thread::sleep(Duration::from_millis(10));
        let mut tasks =
            std::fs::read_dir(format!("/proc/{}/task", child.id())).expect("it has ended by itself");
        quiet = if tasks.all(sleeps) { quiet + 1 } else { 0 };
    }
}

#[cfg(not(target_os = "linux"))]
pub fn waits(_: &Child) {
    std::thread::sleep(Duration::from_secs(2));
}

pub fn lemons(directory: &Path, arguments: &[&str]) -> Output {
    command(directory, arguments).output().unwrap()
}

pub fn out(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned()
}

pub fn err(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

#[track_caller]
pub fn assert_code(output: &Output, code: i32) {
    assert_eq!(output.status.code(), Some(code), "{}{}", out(output), err(output));
}

/// What it prints, of a call that must do.
#[track_caller]
pub fn done(directory: &Path, arguments: &[&str]) -> Output {
    let output = lemons(directory, arguments);
    assert_code(&output, 0);
    output
}

/// The tables of the parts of a run, as one.
pub fn joined(at: &Path, names: &[&str]) -> Vec<u8> {
    let mut all = Vec::new();
    for (k, name) in names.iter().enumerate() {
        let table = std::fs::read(at.join(name)).unwrap();
        let head = table.iter().position(|byte| *byte == b'\n').unwrap() + 1;
        all.extend(if k == 0 { &table[..] } else { &table[head..] });
    }
    all
}
