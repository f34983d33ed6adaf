//! What becomes of the files and streams that the command writes: closed pipes, full disks, signals, devices.
#![cfg(unix)]

mod common;

use common::{assert_code, command, default_trial, done, err, lemons, out};
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
