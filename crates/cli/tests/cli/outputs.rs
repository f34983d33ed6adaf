//! What becomes of the files and streams that the command writes, and what these tests share.

mod replaced;
#[path = "../../src/files/roles.rs"]
mod roles;
mod signals;
mod streams;
mod taken;

use crate::common::{command, decision_library, default_trial, done, err, lemons};
use roles::{ROLES, Role};
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};
use tempfile::TempDir;

/// For what must come or end: generous, as a machine may have much else to do.
const LIMIT: Duration = Duration::from_secs(1200);

/// A directory with an FMU, a run, a sweep, to be worked on.
fn workshop() -> TempDir {
    let directory = TempDir::new().unwrap();
    let trial = default_trial();
    let trial = trial.to_str().unwrap();
    decision_library();
    done(directory.path(), &["pack", trial, "-o", "crowd.fmu"]);
    std::fs::write(directory.path().join("wishes.toml"), "waypoints = [{ x = 6.0, y = 2.5 }]\n").unwrap();
    done(directory.path(), &["decide", trial, "--plan", "wishes.toml", "-o", "decision.fmu"]);
    done(directory.path(), &["run", trial, "--until", "0.1", "-o", "run.csv"]);
    let sweep = format!(
        "trial = {trial:?}\nuntil = 0.05\n[parameters]\n\"agent[*].Mass\" = [70.0, 80.0]\n\
         [measures]\nreach = {{ of = \"x\", take = \"reach\", agents = [\"4\"] }}\n"
    );
    std::fs::write(directory.path().join("sweep.toml"), sweep).unwrap();
    directory
}

/// Names of what is in a directory and begun, not done.
fn begun(directory: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(directory).unwrap();
    let names = entries.map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned());
    names.filter(|name| name.starts_with(".lemons-") || name.starts_with("lemons-")).collect()
}

fn wait_for(what: impl Fn() -> bool) {
    let started = Instant::now();
    while !what() && started.elapsed() < LIMIT {
        std::thread::sleep(Duration::from_millis(1));
    }
}

fn send(signal: &str, child: &Child) {
    // It may have ended already.
    let _ = Command::new("kill").args([signal, &child.id().to_string()]).status();
}

/// What clap wants of a command beside two of its arguments.
fn needed(command: &str) -> (&'static [&'static str], &'static [&'static str]) {
    match command {
        "crowd" => (&["--number", "2", "--sections", "1"], &[]),
        "person" => (&["--breadth", "49", "--depth", "25", "--stature", "1.75", "--mass", "70"], &[]),
        "pack" => (&[], &["trials", "output"]),
        "decide" => (&[], &["trial", "output"]),
        "connect" => (&["another.fmu"], &["fmus", "output"]),
        "run" => (&[], &["input"]),
        "sweep" => (&[], &["spec"]),
        "plot" | "movie" => (&[], &["path"]),
        "measure" => (&["--area", "0,0,1,1"], &["path"]),
        "export" => (&["--to", "pedpy"], &["source", "out"]),
        _ => (&[], &[]),
    }
}

/// A command with these values for two of its arguments, and `--force`.
fn pair(command: &'static str, given: [(&str, &str); 2]) -> Vec<String> {
    let (words, required) = needed(command);
    let mut line = vec![command.to_owned(), "--force".to_owned()];
    line.extend(words.iter().map(|word| (*word).to_owned()));
    let (_, arguments) = ROLES.iter().find(|(name, _)| *name == command).unwrap();
    for (id, spelled, role) in *arguments {
        let place = format!("some_{id}");
        let value = given.iter().find(|(name, _)| name == id).map(|(_, value)| *value);
        let Some(value) = value.or(required.contains(id).then_some(&*place)) else { continue };
        line.extend(Some(spelled).filter(|spelled| !spelled.is_empty()).map(|&spelled| spelled.to_owned()));
        line.push(if *role == Role::ReadsAfterEquals {
            format!("linux64={value}")
        } else {
            value.to_owned()
        });
    }
    line
}

fn run_line(place: &Path, line: &[String]) -> Output {
    lemons(place, &line.iter().map(String::as_str).collect::<Vec<_>>())
}

fn copy(from: &Path, to: &Path) {
    std::fs::create_dir_all(to).unwrap();
    for entry in std::fs::read_dir(from).unwrap() {
        let (path, to) = (entry.as_ref().unwrap().path(), to.join(entry.unwrap().file_name()));
        if path.is_dir() {
            copy(&path, &to);
        } else {
            std::fs::copy(&path, &to).unwrap();
        }
    }
}

/// All files below a directory, and what is in them.
fn content(directory: &Path) -> Vec<(String, Vec<u8>)> {
    let mut all = Vec::new();
    for entry in std::fs::read_dir(directory).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            all.extend(content(&path));
        } else {
            all.push((path.display().to_string(), std::fs::read(&path).unwrap()));
        }
    }
    all.sort();
    all
}

fn mkfifo(path: &Path) {
    assert!(Command::new("mkfifo").arg(path).status().unwrap().success());
}

fn piped(place: &Path, arguments: &[&str]) -> Child {
    command(place, arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
}

/// Its output; it must end.
#[track_caller]
fn ended(mut child: Child) -> Output {
    let started = Instant::now();
    while child.try_wait().unwrap().is_none() {
        if started.elapsed() > LIMIT {
            child.kill().unwrap();
            panic!("it does not end: {}", err(&child.wait_with_output().unwrap()));
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    child.wait_with_output().unwrap()
}

fn text(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap()
}
