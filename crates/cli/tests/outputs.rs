//! What becomes of the files and streams that the command writes: closed pipes, full disks, signals, devices.
#![cfg(unix)]

mod common;
#[path = "../src/files/roles.rs"]
mod roles;

use common::{assert_code, command, decision_library, default_trial, done, err, lemons, out};
use roles::{ROLES, Role};
use std::fs::File;
use std::os::unix::fs::FileTypeExt;
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};
use tempfile::TempDir;

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

/// Every command, with arguments that it does.
fn every_command(trial: &str) -> Vec<Vec<&str>> {
    vec![
        vec!["crowd", "--number", "3", "-o", "Trial_made"],
        vec!["person", "--breadth", "49", "--depth", "25", "--stature", "1.75", "--mass", "70"],
        vec!["pack", trial, "-o", "made.fmu"],
        vec!["decide", trial, "--plan", "wishes.toml", "-o", "decided.fmu"],
        vec!["connect", "decision.fmu", "crowd.fmu", "-o", "made.ssp"],
        vec!["run", trial, "--until", "0.1"],
        vec!["sweep", "sweep.toml", "-o", "swept", "--csv", "swept.csv"],
        vec!["plot", trial, "--at", "0"],
        vec!["movie", trial, "--until", "0.1", "-o", "movie.gif"],
        vec!["export", "run.csv", "run.sqlite", "--to", "jupedsim"],
        vec!["info", "crowd.fmu"],
        vec!["check", trial],
        vec!["describe", trial],
        vec!["verify", "--only", "free flight"],
        vec!["bench", "--only", "none of them"],
        vec!["--help"],
        vec!["crowd", "--help"],
        vec!["--version"],
    ]
}

#[test]
fn a_closed_pipe_is_quiet_and_a_full_one_is_said() {
    let (piped, full) = (workshop(), workshop());
    let trial = default_trial();
    for arguments in every_command(trial.to_str().unwrap()) {
        let (reader, writer) = std::io::pipe().unwrap();
        drop(reader);
        let output =
            command(piped.path(), &arguments).stdout(writer).stderr(Stdio::piped()).output().unwrap();
        assert_code(&output, 0);
        assert!(!err(&output).contains("lemons:") && !err(&output).contains("panic"), "{}", err(&output));

        let device = File::options().write(true).open("/dev/full").unwrap();
        let output = command(full.path(), &arguments).stdout(device).stderr(Stdio::piped()).output().unwrap();
        assert_code(&output, 1);
        let said = err(&output);
        let expected = "lemons: cannot write to standard output: No space left on device (os error 28)\n";
        assert!(said.ends_with(expected), "{arguments:?}: {said}");
    }
    // What they are to write is there nevertheless.
    for file in
        ["Trial_made", "made.fmu", "made.ssp", "trajectories.csv", "swept.csv", "movie.gif", "run.sqlite"]
    {
        assert!(piped.path().join(file).exists() && full.path().join(file).exists(), "{file}");
    }
}

#[test]
fn nobody_on_standard_error_is_no_panic() {
    let directory = workshop();
    for (arguments, code) in [
        (&["run", "nowhere"][..], 1),
        (&["connect", "decision.fmu", "crowd.fmu", "-o", "made.ssp"], 0),
        (&["run"], 2),
    ] {
        let (reader, writer) = std::io::pipe().unwrap();
        drop(reader);
        assert_code(&command(directory.path(), arguments).stderr(writer).output().unwrap(), code);
        let device = File::options().write(true).open("/dev/full").unwrap();
        assert_code(&command(directory.path(), arguments).stderr(device).output().unwrap(), code);
    }
}

/// Names of what is in a directory and begun, not done.
fn begun(directory: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(directory).unwrap();
    let names = entries.map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned());
    names.filter(|name| name.starts_with(".lemons-") || name.starts_with("lemons-")).collect()
}

fn wait_for(what: impl Fn() -> bool) {
    let started = Instant::now();
    while !what() && started.elapsed() < Duration::from_secs(60) {
        std::thread::sleep(Duration::from_millis(1));
    }
}

fn send(signal: &str, child: &Child) {
    // It may have ended already.
    let _ = Command::new("kill").args([signal, &child.id().to_string()]).status();
}

#[test]
fn a_signal_leaves_nothing_half_written() {
    let directory = workshop();
    let place = directory.path();
    // A run whose export takes its time.
    let mut table = std::fs::read_to_string(place.join("run.csv")).unwrap();
    let row: Vec<String> = table.lines().nth(1).unwrap().split(',').skip(2).map(str::to_owned).collect();
    let header = table.lines().next().unwrap().to_owned();
    table = header + "\n";
    for frame in 0..200_000 {
        table += &format!("{:?},0,{}\n", f64::from(frame) * 0.25, row.join(","));
    }
    std::fs::write(place.join("long.csv"), table).unwrap();
    let temporary = place.join("tmp");
    std::fs::create_dir(&temporary).unwrap();
    let trial = default_trial();
    let trial = trial.to_str().unwrap();
    let commands = [
        vec!["pack", trial, "-o", "made.fmu"],
        vec!["decide", trial, "--plan", "wishes.toml", "-o", "decided.fmu"],
        vec!["connect", "decision.fmu", "crowd.fmu", "-o", "made.ssp"],
        vec!["export", "long.csv", "made.sqlite", "--to", "jupedsim"],
        vec!["export", "long.csv", "made.txt", "--to", "pedpy"],
    ];
    for arguments in commands {
        for signal in ["-INT", "-TERM", "-HUP"] {
            let mut begin = command(place, &arguments);
            let mut child = begin.env("TMPDIR", &temporary).stderr(Stdio::piped()).spawn().unwrap();
            wait_for(|| !begun(place).is_empty());
            send(signal, &child);
            let code = child.wait().unwrap().code();
            // It may have been faster than the signal.
            assert!(matches!(code, Some(0 | 130)), "{arguments:?} {signal}: {code:?}");
            assert_eq!(begun(place), [""; 0], "{arguments:?} {signal}");
            assert_eq!(begun(&temporary), [""; 0], "{arguments:?} {signal}");
        }
    }
}

#[test]
fn what_a_killed_sweep_leaves_the_next_command_clears() {
    let directory = workshop();
    let place = directory.path();
    let temporary = place.join("tmp");
    std::fs::create_dir(&temporary).unwrap();
    let text = std::fs::read_to_string(place.join("sweep.toml")).unwrap().replace("0.05", "500.0");
    std::fs::write(place.join("long.toml"), text).unwrap();
    let begin = |arguments: &[&str]| {
        let mut command = command(place, arguments);
        command.env("TMPDIR", &temporary).stdout(Stdio::null()).stderr(Stdio::null());
        command
    };
    for output in ["first", "second"] {
        let mut child = begin(&["sweep", "long.toml", "-o", output]).spawn().unwrap();
        wait_for(|| place.join(output).join("sweep.json").exists());
        assert_eq!(begun(&temporary).len(), 2, "the FMU, packed and unpacked; nothing of the sweep before");
        // Another command does not take them for left behind.
        assert!(begin(&["info", "crowd.fmu"]).status().unwrap().success());
        assert_eq!(begun(&temporary).len(), 2);
        child.kill().unwrap();
        child.wait().unwrap();
    }
    assert_eq!(begun(&temporary).len(), 2);
    assert!(begin(&["info", "crowd.fmu"]).status().unwrap().success());
    assert_eq!(begun(&temporary), [""; 0]);
}

/// With a limit of a shell: `-f` blocks of 1024 bytes of a file, `-n` handles.
fn limited(place: &Path, limit: &str, arguments: &[&str]) -> Output {
    let mut shell = Command::new("bash");
    shell.args(["-c", &format!("ulimit {limit}; exec \"$0\" \"$@\""), env!("CARGO_BIN_EXE_lemons")]);
    shell.args(arguments).current_dir(place).env("TMPDIR", place.join("tmp")).output().unwrap()
}

#[test]
fn a_file_that_may_not_grow_is_an_error_said_once_by_the_users_name() {
    let directory = workshop();
    let place = directory.path();
    std::fs::create_dir(place.join("tmp")).unwrap();
    let trial = default_trial();
    let trial = trial.to_str().unwrap();
    for (arguments, name) in [
        (vec!["pack", trial, "-o", "made.fmu"], "made.fmu"),
        (vec!["decide", trial, "--plan", "wishes.toml", "-o", "decided.fmu"], "decided.fmu"),
        (vec!["export", "run.csv", "made.sqlite", "--to", "jupedsim"], "made.sqlite"),
        (vec!["crowd", "--number", "3", "--stl", "bodies.stl"], "bodies.stl"),
    ] {
        let output = limited(place, "-f 4", &arguments);
        assert_code(&output, 1);
        let said = err(&output);
        assert_eq!(said.lines().count(), 1, "{said}");
        assert!(said.starts_with("lemons: ") && said.contains(name), "{said}");
        assert!(!said.contains("ZipWriter") && !said.contains(".lemons-"), "{said}");
        let why = if name.ends_with("sqlite") { "disk I/O error" } else { "File too large" };
        assert_eq!(said.matches(why).count(), 1, "{said}");
        assert!(!place.join(name).exists());
        assert_eq!(begun(place), [""; 0]);
        assert_eq!(begun(&place.join("tmp")), [""; 0]);
    }
}

#[test]
fn few_file_handles_leave_nothing_behind() {
    let directory = workshop();
    let place = directory.path();
    std::fs::create_dir(place.join("tmp")).unwrap();
    for handles in 6..24 {
        let output = limited(place, &format!("-n {handles}"), &["run", "crowd.fmu", "--until", "0.1"]);
        assert!(
            matches!(output.status.code(), Some(0 | 1 | 127)),
            "{handles}: {}{}",
            out(&output),
            err(&output)
        );
        assert_eq!(begun(place), [""; 0], "{handles}");
        assert_eq!(begun(&place.join("tmp")), [""; 0], "{handles}");
    }
}

#[test]
fn what_is_no_regular_file_is_written_not_replaced() {
    let directory = workshop();
    let place = directory.path();
    let pipe = place.join("pipe.ssp");
    assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    let trial = default_trial();
    let trial = trial.to_str().unwrap();
    for (arguments, begins) in [
        (vec!["export", "run.csv", "pipe.ssp", "--to", "jupedsim"], &b"SQLite format 3\0"[..]),
        (vec!["export", "run.csv", "pipe.ssp", "--to", "pedpy"], b"# framerate"),
        (vec!["pack", trial, "-o", "pipe.ssp"], b"PK\x03\x04"),
        (vec!["decide", trial, "--plan", "wishes.toml", "-o", "pipe.ssp"], b"PK\x03\x04"),
        (vec!["connect", "decision.fmu", "crowd.fmu", "-o", "pipe.ssp"], b"PK\x03\x04"),
        (vec!["run", trial, "--until", "0.1", "--state", "pipe.ssp"], b"PK\x03\x04"),
        (vec!["crowd", "--number", "3", "--zip", "pipe.ssp"], b"PK\x03\x04"),
        (vec!["run", trial, "--until", "0.1", "--format", "csv", "-o", "pipe.ssp"], b"t,id,"),
        (vec!["run", trial, "--until", "0.1", "--format", "parquet", "-o", "pipe.ssp"], b"PAR1"),
    ] {
        let reader = std::thread::spawn({
            let pipe = pipe.clone();
            move || std::fs::read(pipe).unwrap()
        });
        let output = lemons(place, &arguments);
        assert_code(&output, 0);
        let bytes = reader.join().unwrap();
        assert!(bytes.starts_with(begins), "{arguments:?}: {:?}", &bytes[..bytes.len().min(20)]);
        assert!(pipe.symlink_metadata().unwrap().file_type().is_fifo(), "{arguments:?}");
    }
    // The archive is whole.
    let packed = File::create(place.join("through.fmu")).unwrap();
    let pack = command(place, &["pack", trial, "-o", "/dev/stdout"]).stdout(Stdio::piped()).spawn();
    let mut pack = pack.unwrap();
    std::io::copy(&mut pack.stdout.take().unwrap(), &mut &packed).unwrap();
    assert!(pack.wait().unwrap().success());
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

#[test]
fn no_output_of_any_command_overwrites_an_input() {
    let directory = TempDir::new().unwrap();
    let place = directory.path();
    std::os::unix::fs::symlink(place, place.join("alias")).unwrap();
    std::fs::write(place.join("input"), "precious").unwrap();
    std::fs::hard_link(place.join("input"), place.join("same_file")).unwrap();
    let mut tried = 0;
    for (command, arguments) in ROLES {
        let inputs = || {
            arguments
                .iter()
                .filter(|argument| matches!(argument.2, Role::Reads | Role::ReadsAfterEquals | Role::GoesOn))
        };
        let outputs =
            arguments.iter().filter(|argument| matches!(argument.2, Role::Writes | Role::WritesInto));
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
    std::os::unix::fs::symlink(place, place.join("alias")).unwrap();
    let trial = default_trial();
    let trial = trial.to_str().unwrap();
    for command in ["crowd", "person", "run"] {
        let (_, arguments) = ROLES.iter().find(|(name, _)| *name == command).unwrap();
        let outputs: Vec<&str> = arguments
            .iter()
            .filter(|argument| argument.2 == Role::Writes)
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
                assert!(err(&done).contains("made.csv: other results go there"), "{line:?}: {}", err(&done));
                assert!(!place.join("made.csv").exists());
            }
        }
    }
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

#[test]
fn results_of_another_trial_or_changed_ones_are_not_replaced() {
    let directory = TempDir::new().unwrap();
    let place = directory.path();
    copy(&default_trial(), &place.join("first"));
    copy(&default_trial(), &place.join("second"));
    let run = |trial: &'static str| ["run", trial, "--until", "0.1"];
    let table = || std::fs::read_to_string(place.join("trajectories.csv")).unwrap();
    done(place, &run("first"));
    let written = table();
    // Again and again, however it is called, and with other options.
    done(place, &run("first"));
    done(place, &run("second/../first"));
    done(place, &["run", "first", "--until", "0.2"]);
    assert!(table().starts_with(&written) && table() != written);
    done(place, &run("first"));
    let refused = |trial: &'static str, why: &str| {
        let before = table();
        let said = lemons(place, &run(trial));
        assert_code(&said, 1);
        let expected = format!("lemons: cannot write trajectories.csv: {why}; --force replaces it\n");
        assert_eq!(err(&said), expected);
        assert_eq!(table(), before);
    };
    refused("second", "it is of something else, `lemons run first --until 0.1` wrote it");
    done(place, &["run", "second", "--until", "0.1", "--force"]);
    // Now it is the second one's.
    done(place, &run("second"));
    refused("first", "it is of something else, `lemons run second --until 0.1` wrote it");
    std::fs::write(place.join("trajectories.csv"), "my notes").unwrap();
    refused("second", "it was changed after `lemons run second --until 0.1` wrote it");
    std::fs::remove_file(place.join("trajectories.csv")).unwrap();
    done(place, &run("first"));
    assert_eq!(table(), written);
    // A stranger's; an empty one holds nothing.
    for output in ["table.parquet", "plot.png", "made.fmu"] {
        let command = match output {
            "table.parquet" => vec!["run", "first", "--until", "0.1", "-o", output],
            "plot.png" => vec!["plot", "first", "--at", "0"],
            _ => vec!["pack", "first", "-o", output],
        };
        std::fs::write(place.join(output), "not ours").unwrap();
        let said = lemons(place, &command);
        assert_code(&said, 1);
        let expected = format!("cannot write {output}: it is there already, and lemons does not know it");
        assert!(err(&said).contains(&expected), "{}", err(&said));
        assert_eq!(std::fs::read_to_string(place.join(output)).unwrap(), "not ours");
        std::fs::write(place.join(output), "").unwrap();
        done(place, &command);
        done(place, &command);
    }
    // What a copy holds is nobody's.
    std::fs::rename(place.join("plot.png"), place.join("kept.png")).unwrap();
    assert_code(&lemons(place, &["plot", "first", "--at", "0", "-o", "kept.png"]), 1);
    done(place, &["plot", "first", "--at", "0"]);
}

#[test]
fn a_trial_that_was_edited_by_hand_is_not_replaced() {
    let directory = TempDir::new().unwrap();
    let place = directory.path();
    let crowd = ["crowd", "--number", "3", "--box", "3x3", "-o", "T"];
    done(place, &crowd);
    done(place, &crowd);
    let untouched = content(&place.join("T"));
    for file in ["Parameters.xml", "static/Geometry.xml", "dynamic/AgentDynamics.xml"] {
        let path = place.join("T").join(file);
        let text = std::fs::read_to_string(&path).unwrap();
        std::fs::write(&path, format!("{text}<!-- mine -->\n")).unwrap();
        let edited = content(&place.join("T"));
        let said = lemons(place, &crowd);
        assert_code(&said, 1);
        let expected =
            format!("lemons: cannot write T/{file}: it was changed after `lemons crowd --number 3");
        assert!(err(&said).starts_with(&expected), "{}", err(&said));
        assert!(content(&place.join("T")) == edited, "decided before any file is written");
        done(place, &[&crowd[..], &["--force"]].concat());
        assert!(content(&place.join("T")) == untouched);
    }
    // Springs of somebody's would go.
    std::fs::write(place.join("T/dynamic/AgentInteractions.xml"), "mine").unwrap();
    let said = lemons(place, &crowd);
    assert_code(&said, 1);
    assert!(err(&said).contains("AgentInteractions.xml"), "{}", err(&said));
    std::fs::remove_file(place.join("T/dynamic/AgentInteractions.xml")).unwrap();
    done(place, &["crowd", "--number", "4", "--box", "3x3", "-o", "T"]);
}
