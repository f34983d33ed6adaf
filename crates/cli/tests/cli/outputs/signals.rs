//! What a signal leaves behind.

use super::{begun, ended, mkfifo, piped, send, text, wait_for, workshop};
use crate::common::{assert_code, command, default_trial, done, err, waits};
use std::process::{Command, Stdio};
use tempfile::TempDir;

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
    for output in ["first.csv", "second.csv"] {
        let mut child = begin(&["sweep", "long.toml", "-o", output]).spawn().unwrap();
        wait_for(|| place.join(output).exists());
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
    // One after the other; this one waits for who reads it.
    std::fs::create_dir(place.join("out")).unwrap();
    let pipe = place.join("out/traj065.csv");
    mkfifo(&pipe);
    let export = ["export", "many.csv", "out", "--to", "chaos"];
    let child = piped(place, &export);
    wait_for(|| place.join("out/traj064.csv").exists());
    waits(&child);
    send("-INT", &child);
    let output = ended(child);
    assert_code(&output, 130);
    let expected = "lemons: interrupted: 65 files are complete, from out/traj000.csv to out/traj064.csv, \
                    nothing else was written\n";
    assert_eq!(err(&output), expected);
    assert!(begun(&place.join("out")).is_empty() && !place.join("out/traj066.csv").exists());
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
        waits(&child);
        send("-INT", &child);
        let output = ended(child);
        assert_code(&output, 130);
        assert_eq!(err(&output), "lemons: interrupted: nothing was written\n", "{arguments:?}");
        assert!(!place.join("some.csv").exists() && begun(place).is_empty(), "{arguments:?}");
        assert_eq!(begun(&temporary), [""; 0], "{arguments:?}");
    }
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
