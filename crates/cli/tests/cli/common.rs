//! Helpers that the tests of the command share.

pub use lemons_testing::{copy_tree, repository as root, trial_push as default_trial};
use std::collections::HashMap;
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};

pub fn command(directory: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_lemons"));
    command.args(arguments).current_dir(directory);
    command
}

/// Starts the command; what it says is kept.
pub fn started(directory: &Path, arguments: &[&str]) -> Child {
    command(directory, arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
}

/// Waits until a command has begun something.
pub fn wait_for(child: &mut Child, begun: impl Fn() -> bool) {
    while !begun() {
        assert!(child.try_wait().unwrap().is_none(), "it ended by itself");
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
}

/// Sends a signal to a command as soon as it has begun something. SIGINT would be ignored where the tests are started in
/// the background of a shell.
pub fn signalled(mut child: Child, signal: &str, begun: impl Fn() -> bool) -> Output {
    wait_for(&mut child, begun);
    let sent = Command::new("kill").args([signal, &child.id().to_string()]).status().unwrap();
    assert!(sent.success());
    child.wait_with_output().unwrap()
}

/// The names in a directory, hidden ones too.
pub fn names(at: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(at).unwrap();
    let mut names: Vec<String> =
        entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

/// A row of a table: its cells by the names of the columns.
pub type NamedCells = HashMap<String, String>;

pub fn read_csv(path: &Path) -> Vec<NamedCells> {
    let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_path(path).unwrap();
    reader.deserialize().map(|row| row.unwrap()).collect()
}

pub fn number(row: &NamedCells, name: &str) -> f64 {
    row[name].parse().unwrap_or_else(|_| panic!("{name}: {row:?}"))
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

/// Returns what a call that must do prints.
#[track_caller]
pub fn done(directory: &Path, arguments: &[&str]) -> Output {
    let output = lemons(directory, arguments);
    assert_code(&output, 0);
    output
}
