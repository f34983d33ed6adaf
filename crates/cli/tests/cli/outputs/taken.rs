//! Nothing is written over what is read, and no two outputs go into one file.

use super::{ROLES, Role, content, copy, ended, mkfifo, pair, piped, run_line, text};
use crate::common::{assert_code, default_trial, done, err, lemons};
use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::Output;
use tempfile::TempDir;

fn writes(role: Role) -> bool {
    matches!(role, Role::Writes | Role::Shows | Role::WritesInto)
}

#[test]
fn no_output_of_any_command_overwrites_an_input() {
    let directory = TempDir::new().unwrap();
    let place = directory.path();
    symlink(place, place.join("alias")).unwrap();
    std::fs::write(place.join("input"), "precious").unwrap();
    std::fs::hard_link(place.join("input"), place.join("same_file")).unwrap();
    let mut tried = 0;
    for (command, arguments) in ROLES {
        let inputs = || {
            arguments
                .iter()
                .filter(|argument| matches!(argument.2, Role::Reads | Role::ReadsAfterEquals | Role::GoesOn))
        };
        let outputs = arguments.iter().filter(|argument| writes(argument.2));
        for (output, input) in outputs.flat_map(|output| inputs().map(move |input| (output, input))) {
            // A run may be saved over the one that it goes on from.
            if (input.2, output.0) == (Role::GoesOn, "state") {
                continue;
            }
            for written in ["input", "./alias/input", "same_file"] {
                let line = pair(command, [(input.0, "input"), (output.0, written)]);
                let done = run_line(place, &line);
                assert_code(&done, 1);
                let said = err(&done);
                let expected = format!("lemons: cannot write {written}: lemons {command} reads it (");
                assert!(said.starts_with(&expected), "{line:?}: {said}");
                assert_eq!(std::fs::read_to_string(place.join("input")).unwrap(), "precious", "{line:?}");
                tried += 1;
            }
        }
    }
    assert!(tried > 3 * 80, "{tried}");
}

#[test]
fn no_two_outputs_of_a_command_go_into_one_file() {
    let directory = TempDir::new().unwrap();
    let place = directory.path();
    symlink(place, place.join("alias")).unwrap();
    let trial = default_trial();
    let trial = trial.to_str().unwrap();
    for command in ["crowd", "person", "run"] {
        let (_, arguments) = ROLES.iter().find(|(name, _)| *name == command).unwrap();
        let outputs: Vec<&str> = arguments
            .iter()
            .filter(|argument| matches!(argument.2, Role::Writes | Role::Shows))
            .map(|argument| argument.0)
            .collect();
        for (k, one) in outputs.iter().enumerate() {
            for other in &outputs[..k] {
                let mut line = pair(command, [(one, "made.csv"), (other, "alias/made.csv")]);
                line.iter_mut()
                    .filter(|word| *word == "some_input")
                    .for_each(|word| *word = trial.to_owned());
                // Trials have no other outputs: there they are not opened.
                if command == "run" && [one, other].contains(&&"outputs") {
                    continue;
                }
                let done = run_line(place, &line);
                assert_code(&done, 1);
                assert!(
                    err(&done).contains("made.csv: another result goes there"),
                    "{line:?}: {}",
                    err(&done)
                );
                assert!(!place.join("made.csv").exists());
            }
        }
    }
    // Nobody reads the pipe: nothing waits for that.
    mkfifo(&place.join("pipe.csv"));
    let outputs = ["-o", "pipe.csv", "--outputs", "alias/pipe.csv"];
    let done = ended(piped(place, &[&["run", trial, "--until", "0.1"][..], &outputs].concat()));
    assert_code(&done, 1);
    assert_eq!(err(&done), "lemons: cannot write alias/pipe.csv: another result goes there\n");
    let outputs = ["-o", "/dev/null", "--outputs", "/dev/null"];
    let format = ["run", trial, "--until", "0.1", "--format", "csv"];
    assert_code(&lemons(place, &[&format[..], &outputs].concat()), 0);
}

/// Names of the files in a directory, sorted.
fn names(directory: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(directory).unwrap();
    let mut names: Vec<_> =
        entries.map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

#[test]
fn an_output_directory_is_an_output_of_its_run() {
    let directory = TempDir::new().unwrap();
    let place = directory.path();
    copy(&default_trial(), &place.join("trial"));
    let parameters = text(&place.join("trial/Parameters.xml")).replace("2e-6", "1e-4");
    std::fs::write(place.join("trial/Parameters.xml"), parameters).unwrap();
    done(place, &["pack", "trial", "-o", "first"]);
    std::fs::copy(place.join("first"), place.join("second")).unwrap();
    let run = |trial: &str, until: &str, to: &str, more: &[&str]| {
        let to = format!("OutputDirectory={to}");
        let fixed = ["run", trial, "--until", until, "-o", "/dev/null", "--format", "csv", "--set", &to];
        lemons(place, &[&fixed[..], more].concat())
    };
    #[track_caller]
    fn refused(done: &Output, why: &str) {
        assert_code(done, 1);
        assert!(err(done).contains(why), "{}", err(done));
    }
    let named = |time: &str| format!("AgentDynamics output t={time}.xml");
    assert_code(&run("first", "0.1", "out", &[]), 0);
    assert_eq!(names(&place.join("out")), ["0.05", "0.1"].map(named));
    // Again, and longer: all files are of the last run.
    assert_code(&run("first", "0.1", "out", &[]), 0);
    assert_code(&run("first", "0.2", "out", &[]), 0);
    let before = content(&place.join("out"));
    assert_eq!(names(&place.join("out")), ["0.05", "0.1", "0.15", "0.2"].map(named));
    refused(&run("first", "0.1", "out", &[]), "t=0.15.xml: is of another run");
    refused(&run("second", "0.2", "out", &[]), "it was made from something else, by `lemons run first");
    assert_eq!(content(&place.join("out")), before);
    assert_code(&run("second", "0.2", "out", &["--force"]), 0);
    std::fs::write(place.join("out").join(named("0.1")), "my notes").unwrap();
    refused(&run("second", "0.2", "out", &[]), "it was changed after");
    // A saved run goes on in its directory.
    assert_code(&run("first", "0.1", "saved", &["--state", "run.run"]), 0);
    let go_on = ["run", "first", "--resume", "run.run", "--until", "0.2", "-o", "rest.csv"];
    done(place, &go_on);
    assert_eq!(names(&place.join("saved")).len(), 4);

    // What is read is not written, and no link leads to it.
    let before = content(&place.join("trial"));
    for inside in ["trial/dynamic", "trial"] {
        refused(&run("trial", "0.1", inside, &["--force"]), "lemons run reads it (trial)");
    }
    std::fs::create_dir(place.join("links")).unwrap();
    let link = place.join("links").join(named("0.1"));
    symlink(place.join("trial/static/Agents.xml"), &link).unwrap();
    refused(&run("trial", "0.1", "links", &["--force"]), "lemons run reads it (trial)");
    std::fs::remove_file(&link).unwrap();
    std::fs::write(place.join("mine"), "precious").unwrap();
    symlink(place.join("mine"), &link).unwrap();
    refused(&run("first", "0.1", "links", &[]), "it exists already, and lemons has no record");
    assert_eq!(content(&place.join("trial")), before);
    assert_eq!(text(&place.join("mine")), "precious");
}

#[test]
fn no_output_overwrites_a_file_of_a_trial_that_is_read() {
    let directory = TempDir::new().unwrap();
    let place = directory.path();
    copy(&default_trial(), &place.join("T"));
    done(place, &["run", "T", "--until", "0.1", "-o", "run.csv"]);
    let before = content(&place.join("T"));
    let files = [
        "T/Parameters.xml",
        "T/static/Materials.xml",
        "T/static/Geometry.xml",
        "T/static/Agents.xml",
        "T/dynamic/AgentDynamics.xml",
        "T/drive.csv",
        // Not there: with them it would be another Trial.
        "T/dynamic/AgentInteractions.xml",
        "T/decision.toml",
    ];
    for file in files {
        for arguments in [
            &["pack", "T", "-o", file][..],
            &["decide", "T", "-o", file],
            &["run", "T", "--format", "csv", "-o", file],
            &["run", "T", "--state", file],
            &["export", "run.csv", file, "--to", "pedpy", "--trial", "T"],
        ] {
            let done = lemons(place, &[arguments, &["--force"]].concat());
            assert_code(&done, 1);
            assert!(err(&done).contains("reads it"), "{arguments:?}: {}", err(&done));
            assert!(content(&place.join("T")) == before, "{arguments:?}");
        }
    }
    for arguments in [
        &["crowd", "--number", "1", "--geometry", "T/static/Geometry.xml", "-o", "T", "--force"][..],
        &["export", "run.csv", "T", "--to", "trial", "--trial", "T", "--force"],
    ] {
        let done = lemons(place, arguments);
        assert_code(&done, 1);
        assert!(err(&done).contains("reads it") && content(&place.join("T")) == before, "{}", err(&done));
    }
}
