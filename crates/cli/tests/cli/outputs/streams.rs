//! Closed pipes, full disks, few handles, devices, standard output.

use super::{ROLES, Role, begun, pair, run_line, text, workshop};
use crate::common::{assert_code, command, default_trial, done, err, lemons, out};
use std::fs::File;
use std::os::unix::fs::FileTypeExt;
use std::path::Path;
use std::process::{Command, Output, Stdio};

/// Every command, with arguments that it does.
fn every_command(trial: &str) -> Vec<Vec<&str>> {
    vec![
        vec!["crowd", "--number", "3", "-o", "Trial_made"],
        vec!["person", "--breadth", "49", "--depth", "25", "--stature", "1.75", "--mass", "70"],
        vec!["pack", trial, "-o", "made.fmu"],
        vec!["decide", trial, "--plan", "wishes.toml", "-o", "decided.fmu"],
        vec!["connect", "decision.fmu", "crowd.fmu", "-o", "made.ssp"],
        vec!["run", trial, "--until", "0.1"],
        vec!["sweep", "sweep.toml", "-o", "swept.csv"],
        vec!["plot", trial, "--at", "0"],
        vec!["movie", trial, "--until", "0.1", "-o", "movie.gif"],
        vec!["measure", "run.csv", "--line", "0.2,-1,0.2,1", "-o", "measured"],
        vec!["export", "run.csv", "run.sqlite", "--to", "jupedsim", "--trial", trial],
        vec!["info", "crowd.fmu"],
        vec!["check", trial],
        vec!["describe", trial],
        vec!["verify", "--only", "free flight"],
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
    for file in [
        "Trial_made",
        "made.fmu",
        "made.ssp",
        "trajectories.csv",
        "swept.csv",
        "movie.gif",
        "run.sqlite",
        "measured/summary.json",
    ] {
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
        (vec!["export", "run.csv", "made.sqlite", "--to", "jupedsim", "--trial", trial], "made.sqlite"),
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
        (
            vec!["export", "run.csv", "pipe.ssp", "--to", "jupedsim", "--trial", trial],
            &b"SQLite format 3\0"[..],
        ),
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

/// It made a file called `-`.
#[test]
fn a_dash_is_standard_output_or_refused() {
    let directory = workshop();
    let place = directory.path();
    let trial = default_trial();
    let trial = trial.to_str().unwrap();
    let mut refused = 0;
    for (command, arguments) in ROLES {
        for (id, spelled, _) in
            arguments.iter().filter(|argument| matches!(argument.2, Role::Writes | Role::WritesInto))
        {
            let line = pair(command, [(id, "-"), ("", "")]);
            let output = run_line(place, &line);
            assert_code(&output, 2);
            let expected = format!(
                "lemons: {spelled} -: this result cannot go to standard output; for a file of this name, write ./-\n"
            );
            assert_eq!(err(&output), expected, "{line:?}");
            refused += 1;
        }
    }
    assert!(refused > 8);
    // The command's own words are elsewhere.
    let shown = |arguments: &[&str], said: &str| {
        let output = done(place, arguments);
        assert!(err(&output).contains(said), "{arguments:?}: {}", err(&output));
        out(&output)
    };
    done(place, &["run", trial, "--until", "0.1", "-o", "a.csv"]);
    let table = text(&place.join("a.csv"));
    assert_eq!(shown(&["run", trial, "--until", "0.1", "-o", "-"], "simulated time"), table);
    done(place, &["export", "a.csv", "a.txt", "--to", "pedpy"]);
    assert_eq!(shown(&["export", "a.csv", "-", "--to", "pedpy"], "5 agents"), text(&place.join("a.txt")));
    let measure = ["measure", "a.csv", "--above", "100", "--summary"];
    done(place, &[&measure[..], &["summary.json"]].concat());
    assert_eq!(shown(&[&measure[..], &["-"]].concat(), "5 people"), text(&place.join("summary.json")));
    let person = ["person", "--breadth", "49", "--depth", "25", "--stature", "1.75", "--mass", "70"];
    for option in ["--obj", "--stl", "--geojson", "--wkt", "--svg", "--pdf"] {
        done(place, &[&person[..], &[option, "person"]].concat());
        let output = done(place, &[&person[..], &[option, "-"]].concat());
        assert!(output.stdout == std::fs::read(place.join("person")).unwrap(), "{option}");
        assert!(err(&output).contains("moment of inertia"), "{}", err(&output));
        std::fs::remove_file(place.join("person")).unwrap();
    }
    let output = lemons(place, &[&person[..], &["--wkt", "-", "--svg", "-"]].concat());
    assert_code(&output, 1);
    assert_eq!(err(&output), "lemons: cannot write -: another result goes there\n");
    let output = lemons(place, &["export", "a.csv", "-", "--to", "jupedsim"]);
    assert_code(&output, 2);
    assert!(!place.join("-").exists());
    // Who closes it early has what they wanted.
    let (reader, writer) = std::io::pipe().unwrap();
    drop(reader);
    for format in ["csv", "parquet"] {
        let run = ["run", trial, "--until", "2", "-o", "-", "--format", format];
        let writer = writer.try_clone().unwrap();
        let output = command(place, &run).stdout(writer).stderr(Stdio::piped()).output().unwrap();
        assert_code(&output, 0);
        assert!(!err(&output).contains("lemons:"), "{format}: {}", err(&output));
    }
    done(place, &["run", trial, "--until", "0.1", "-o", "./-"]);
    assert_eq!(text(&place.join("-")), table);
}
