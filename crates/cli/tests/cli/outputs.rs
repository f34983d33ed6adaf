//! What becomes of the files and streams that the command writes: closed pipes, full disks, signals, devices.

#[path = "../../src/files/roles.rs"]
mod roles;

use crate::common::{assert_code, command, decision_library, default_trial, done, err, lemons, out};
use roles::{ROLES, Role};
use std::fs::File;
use std::os::unix::fs::{FileTypeExt, symlink};
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
        vec!["measure", "run.csv", "--every", "1", "--line", "0.2,-1,0.2,1", "-o", "measured"],
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
    std::fs::write(place.join("area.wkt"), "POLYGON ((-9 -9, 9 -9, 9 9, -9 9, -9 -9))").unwrap();
    let temporary = place.join("tmp");
    std::fs::create_dir(&temporary).unwrap();
    let trial = default_trial();
    let trial = trial.to_str().unwrap();
    let commands = [
        vec!["pack", trial, "-o", "made.fmu"],
        vec!["decide", trial, "--plan", "wishes.toml", "-o", "decided.fmu"],
        vec!["connect", "decision.fmu", "crowd.fmu", "-o", "made.ssp"],
        vec!["export", "long.csv", "made.sqlite", "--to", "jupedsim", "--area", "area.wkt"],
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

fn writes(role: Role) -> bool {
    matches!(role, Role::Writes | Role::Shows | Role::WritesInto)
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
    refused("second", "it was made from something else, by `lemons run first --until 0.1`");
    done(place, &["run", "second", "--until", "0.1", "--force"]);
    // Now it is the second one's.
    done(place, &run("second"));
    refused("first", "it was made from something else, by `lemons run second --until 0.1`");
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
        let expected =
            format!("cannot write {output}: it exists already, and lemons has no record of writing it");
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
        if started.elapsed() > Duration::from_secs(60) {
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

/// The stamps were compared when the run began only: what the user wrote in the hour after was lost.
#[test]
fn results_that_are_edited_while_the_command_runs_are_not_replaced() {
    let directory = TempDir::new().unwrap();
    let place = directory.path();
    let trial = default_trial();
    let run = ["run", trial.to_str().unwrap(), "--until", "0.1"];
    // The run waits for who reads its state when the trajectories are claimed.
    mkfifo(&place.join("state"));
    let (table, new) = (place.join("trajectories.csv"), place.join("trajectories_new.csv"));
    for before in [false, true] {
        if before {
            done(place, &[&run[..], &["--force"]].concat());
        }
        let child = piped(place, &[&run[..], &["--state", "state"]].concat());
        wait_for(|| !begun(place).is_empty());
        std::fs::write(&table, "my notes").unwrap();
        assert!(std::fs::read(place.join("state")).unwrap().starts_with(b"PK"), "the run is saved");
        let output = ended(child);
        assert_code(&output, 1);
        let expected = "lemons: cannot write trajectories.csv: another program changed it while this command \
                        ran, so it was not replaced; the new content is in trajectories_new.csv\n";
        assert_eq!(err(&output), expected);
        assert!(out(&output).contains("greatest peak"), "what was computed is told: {}", out(&output));
        assert_eq!(text(&table), "my notes");
        let kept = text(&new);
        assert!(begun(place).is_empty());
        // It is nobody's but the user's.
        assert_code(&lemons(place, &run), 1);
        assert_eq!(text(&table), "my notes");
        std::fs::remove_file(&new).unwrap();
        done(place, &[&run[..], &["-o", "again.csv"]].concat());
        assert_eq!(text(&place.join("again.csv")), kept, "nothing of the results is lost");
        if before {
            // Who asks for it gets it.
            let child = piped(place, &[&run[..], &["--state", "state", "--force"]].concat());
            wait_for(|| !begun(place).is_empty());
            std::fs::write(&table, "my notes").unwrap();
            std::fs::read(place.join("state")).unwrap();
            assert_code(&ended(child), 0);
            assert_eq!(text(&table), kept);
        }
    }
}

/// Whatever had another stamp at the end was taken for the run's.
#[test]
fn what_the_user_wrote_during_an_interrupted_run_is_not_taken_for_its_result() {
    let directory = TempDir::new().unwrap();
    let place = directory.path();
    let trial = default_trial();
    let run = ["run", trial.to_str().unwrap(), "--until", "0.1"];
    mkfifo(&place.join("state"));
    let child = piped(place, &[&run[..], &["--state", "state"]].concat());
    wait_for(|| !begun(place).is_empty());
    std::fs::write(place.join("trajectories.csv"), "my notes").unwrap();
    send("-INT", &child);
    assert_code(&ended(child), 130);
    let output = lemons(place, &run);
    assert_code(&output, 1);
    assert!(err(&output).contains("lemons has no record of writing it"), "{}", err(&output));
    assert_eq!(text(&place.join("trajectories.csv")), "my notes");
}

/// A Trial is replaced as a whole or not at all.
#[test]
fn a_trial_that_is_edited_while_a_crowd_is_made_is_not_replaced() {
    let directory = TempDir::new().unwrap();
    let place = directory.path();
    let crowd = ["crowd", "--number", "3", "-o", "T"];
    mkfifo(&place.join("people"));
    for there in [true, false] {
        if there {
            done(place, &crowd);
        } else {
            std::fs::remove_dir_all(place.join("T")).unwrap();
        }
        let made = ["--seed", "2", "--zip", "T.zip", "--svg", "T.svg", "--population", "people"];
        let child = piped(place, &[&crowd[..], &made].concat());
        // It waits for who reads the population; all is claimed then.
        std::thread::sleep(Duration::from_millis(300));
        std::fs::create_dir_all(place.join("T/static")).unwrap();
        std::fs::write(place.join("T/Parameters.xml"), "mine").unwrap();
        let edited = content(&place.join("T"));
        let population = text(&place.join("people"));
        assert!(population.lines().count() == 4, "{population}");
        let output = ended(child);
        assert_code(&output, 1);
        let expected = "T/Parameters.xml: cannot be written: another program changed it while this command ran, \
                        so it was not replaced; \
                        the new content is in T_new\n";
        assert!(err(&output).ends_with(expected), "{}", err(&output));
        assert!(content(&place.join("T")) == edited);
        done(place, &["check", "T_new"]);
        assert_code(&lemons(place, &crowd), 1);
        assert!(content(&place.join("T")) == edited);
        // The others are there.
        done(place, &["check", "T.zip"]);
        for file in ["T.zip", "T.svg"] {
            std::fs::remove_file(place.join(file)).unwrap();
        }
        std::fs::remove_dir_all(place.join("T_new")).unwrap();
        assert!(begun(place).is_empty());
    }
    // What somebody made there meanwhile may be no Trial at all.
    std::fs::remove_dir_all(place.join("T")).unwrap();
    let child = piped(place, &[&crowd[..], &["--population", "people"]].concat());
    std::thread::sleep(Duration::from_millis(300));
    std::fs::create_dir(place.join("T")).unwrap();
    std::fs::write(place.join("T/notes"), "mine").unwrap();
    text(&place.join("people"));
    let output = ended(child);
    assert_code(&output, 1);
    assert!(err(&output).ends_with("the Trial is in T_new\n"), "{}", err(&output));
    done(place, &["check", "T_new"]);
    assert_eq!(content(&place.join("T")).len(), 1);
}

/// "nothing was written" was said of it, and what was complete was a stranger's for the next run.
#[test]
fn an_interrupt_between_files_says_which_are_complete() {
    let directory = TempDir::new().unwrap();
    let place = directory.path();
    let trial = default_trial();
    done(place, &["run", trial.to_str().unwrap(), "--until", "0.1", "-o", "run.csv"]);
    let table = text(&place.join("run.csv"));
    let mut lines = table.lines();
    let header = lines.next().unwrap();
    let row = lines.next().unwrap().splitn(3, ',').nth(2).unwrap();
    let mut many = format!("{header}\n");
    for time in ["0.0", "0.5"] {
        (0..70).for_each(|id| many += &format!("{time},{id},{row}\n"));
    }
    std::fs::write(place.join("many.csv"), many).unwrap();
    // Of 64 at a time the second part waits for who reads one of them.
    std::fs::create_dir(place.join("out")).unwrap();
    let pipe = place.join("out/traj065.csv");
    mkfifo(&pipe);
    let export = ["export", "many.csv", "out", "--to", "chaos"];
    let child = piped(place, &export);
    wait_for(|| place.join("out/traj063.csv").exists() && !begun(&place.join("out")).is_empty());
    send("-INT", &child);
    let output = ended(child);
    assert_code(&output, 130);
    let expected = "lemons: interrupted: 64 files are complete, from out/traj000.csv to out/traj063.csv, \
                    nothing else was written\n";
    assert_eq!(err(&output), expected);
    assert!(begun(&place.join("out")).is_empty() && !place.join("out/traj064.csv").exists());
    // They are its own: the same command replaces them.
    std::fs::remove_file(pipe).unwrap();
    done(place, &export);
}

/// It waited for a reader and looked at nothing else: the second signal ended it.
#[test]
fn a_pipe_that_nobody_reads_is_left_at_the_first_signal() {
    let directory = workshop();
    let place = directory.path();
    let trial = default_trial();
    let trial = trial.to_str().unwrap();
    let names = ["pipe.csv", "pipe.png", "pipe.gif", "pipe.run", "pipe.zip", "pipe.fmu"];
    names.iter().for_each(|name| mkfifo(&place.join(name)));
    let temporary = place.join("tmp");
    std::fs::create_dir(&temporary).unwrap();
    for arguments in [
        &["run", trial, "--until", "0.1", "-o", "pipe.csv"][..],
        &["run", trial, "--until", "0.1", "-o", "some.csv", "--state", "pipe.run"],
        &["plot", trial, "--at", "0", "-o", "pipe.png"],
        &["movie", trial, "--until", "0.1", "-o", "pipe.gif"],
        &["crowd", "-n", "3", "--zip", "pipe.zip"],
        &["crowd", "-n", "3", "--fmu", "pipe.fmu"],
        &["pack", trial, "-o", "pipe.fmu"],
    ] {
        let mut begin = command(place, arguments);
        begin.env("TMPDIR", &temporary).stdout(Stdio::piped()).stderr(Stdio::piped());
        let child = begin.spawn().unwrap();
        // Nothing tells that it waits.
        std::thread::sleep(Duration::from_millis(1500));
        send("-INT", &child);
        let output = ended(child);
        assert_code(&output, 130);
        assert_eq!(err(&output), "lemons: interrupted: nothing was written\n", "{arguments:?}");
        assert!(!place.join("some.csv").exists() && begun(place).is_empty(), "{arguments:?}");
        assert_eq!(begun(&temporary), [""; 0], "{arguments:?}");
    }
    let sweep = ["sweep", "sweep.toml", "--csv", "pipe.csv"];
    let child = piped(place, &sweep);
    wait_for(|| place.join("sweep/table.parquet").exists());
    std::thread::sleep(Duration::from_millis(300));
    send("-INT", &child);
    assert_code(&ended(child), 130);
}

/// As `nohup` and a shell's `&` start programs: handlers were installed whatever had been set before.
#[test]
fn signals_that_are_ignored_when_it_starts_do_not_end_a_run() {
    let directory = TempDir::new().unwrap();
    let place = directory.path();
    let trial = default_trial();
    for (signal, start) in
        [("-HUP", "trap '' HUP; exec \"$0\" \"$@\""), ("-INT", "\"$0\" \"$@\" & echo $!; wait $!")]
    {
        let file = place.join(format!("run{signal}.csv"));
        let mut shell = Command::new("sh");
        shell.args(["-c", start, env!("CARGO_BIN_EXE_lemons"), "run", trial.to_str().unwrap()]);
        shell.args(["--until", "100000", "--force", "-o"]).arg(&file).current_dir(place);
        let mut child = shell.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        let pid = match signal {
            "-INT" => {
                let mut line = String::new();
                let out = child.stdout.as_mut().unwrap();
                std::io::BufRead::read_line(&mut std::io::BufReader::new(out), &mut line).unwrap();
                line.trim().to_owned()
            }
            _ => child.id().to_string(),
        };
        let length = || {
            let own = std::fs::read_dir(place).unwrap().map(|entry| entry.unwrap());
            let own = own.filter(|entry| entry.file_name().to_string_lossy().starts_with(".lemons-"));
            own.filter_map(|entry| Some(entry.metadata().ok()?.len())).max().unwrap_or(0)
        };
        let kill = |signal: &str| {
            assert!(Command::new("kill").args([signal, &pid]).status().unwrap().success());
        };
        wait_for(|| length() > 8_000);
        kill(signal);
        // Far more steps than are made before a signal is seen.
        let then = length();
        wait_for(|| length() > then + 200_000 || file.exists());
        assert!(!file.exists(), "{signal} ended it");
        kill("-TERM");
        wait_for(|| file.exists());
        assert!(text(&file).len() > 200_000);
        child.wait().unwrap();
    }
}

/// The link was replaced by a file.
#[test]
fn a_link_to_a_file_that_is_yet_to_be_made_leads_there() {
    let directory = TempDir::new().unwrap();
    let place = directory.path();
    std::fs::create_dir(place.join("disk")).unwrap();
    symlink("disk/run.csv", place.join("link.csv")).unwrap();
    symlink("link.csv", place.join("second.csv")).unwrap();
    symlink(place.join("disk/crowd"), place.join("crowd")).unwrap();
    symlink("circle.csv", place.join("round.csv")).unwrap();
    symlink("round.csv", place.join("circle.csv")).unwrap();
    symlink("nowhere/run.csv", place.join("lost.csv")).unwrap();
    let trial = default_trial();
    let run =
        |to: &'static str| ["run", trial.to_str().unwrap(), "--until", "0.1", "-o", to].map(str::to_owned);
    let run = |to| lemons(place, &run(to).each_ref().map(String::as_str));
    assert_code(&run("second.csv"), 0);
    assert!(text(&place.join("disk/run.csv")).starts_with("t,id,"));
    // By whatever name, it is the file of the same command.
    for name in ["link.csv", "disk/run.csv", "second.csv"] {
        assert_code(&run(name), 0);
    }
    done(place, &["crowd", "-n", "3", "-o", "crowd"]);
    done(place, &["check", "disk/crowd"]);
    for link in ["link.csv", "second.csv", "crowd"] {
        assert!(place.join(link).symlink_metadata().unwrap().is_symlink(), "{link}");
    }
    let both = ["person", "--breadth", "49", "--depth", "25", "--stature", "1.75", "--mass", "70"];
    let both = lemons(place, &[&both[..], &["--wkt", "new.wkt", "--geojson", "new.wkt"]].concat());
    assert!(err(&both).contains("another result goes there"), "{}", err(&both));
    for name in ["round.csv", "lost.csv"] {
        let output = run(name);
        assert_code(&output, 1);
        assert!(err(&output).starts_with(&format!("lemons: cannot write {name}: ")), "{}", err(&output));
        assert!(place.join(name).symlink_metadata().unwrap().is_symlink());
    }
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
    let measure = ["measure", "a.csv", "--every", "1", "--above", "100", "--summary"];
    done(place, &[&measure[..], &["summary.json"]].concat());
    assert_eq!(shown(&[&measure[..], &["-"]].concat(), "5 people"), text(&place.join("summary.json")));
    done(place, &["sweep", "sweep.toml", "--csv", "swept.csv"]);
    assert_eq!(shown(&["sweep", "sweep.toml", "--csv", "-"], "succeeded"), text(&place.join("swept.csv")));
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

/// It spoke of files that stay, and are used, in a Trial that it then did not write.
#[test]
fn a_refused_crowd_says_why_and_nothing_else() {
    let directory = TempDir::new().unwrap();
    let place = directory.path();
    let crowd = ["crowd", "-n", "3", "-o", "T"];
    done(place, &crowd);
    std::fs::write(place.join("T/decision.toml"), "waypoints = [{ x = 6, y = 2 }]\n").unwrap();
    let kept = "warning: T/decision.toml of the Trial that was there stays, and is used\n";
    assert_eq!(err(&done(place, &crowd)), kept);
    std::fs::write(place.join("T/static/Geometry.xml"), "mine").unwrap();
    let output = lemons(place, &crowd);
    assert_code(&output, 1);
    let said = err(&output);
    assert!(
        said.starts_with("lemons: cannot write T/static/Geometry.xml: ") && said.lines().count() == 1,
        "{said}"
    );
}
