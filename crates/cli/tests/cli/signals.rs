//! Files and exit codes after a signal.

use crate::common::{command, default_trial, done, names};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};
use tempfile::TempDir;

/// For what must come or end: generous, as a machine may have much else to do.
const LIMIT: Duration = Duration::from_secs(1200);

/// Names of what is in a directory and begun, not done.
fn begun(directory: &Path) -> Vec<String> {
    names(directory).into_iter().filter(|name| name.starts_with(".lemons-")).collect()
}

fn wait_for(mut what: impl FnMut() -> bool) {
    let started = Instant::now();
    while !what() && started.elapsed() < LIMIT {
        std::thread::sleep(Duration::from_millis(1));
    }
}

/// A crowd that cannot be placed for long, a movie, files that are packed or exported.
#[test]
fn a_signal_leaves_nothing_half_written() {
    let directory = TempDir::new().unwrap();
    let place = directory.path();
    let trial = default_trial();
    let trial = trial.to_str().unwrap();
    done(place, &["pack", trial, "-o", "crowd.fmu"]);
    std::fs::write(place.join("walk.toml"), "waypoints = [{ x = 6.0, y = 2.5 }]\n").unwrap();
    done(place, &["decide", trial, "--decision", "walk.toml", "-o", "decision.fmu"]);
    done(place, &["run", trial, "--until", "0.1", "-o", "run.csv"]);
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
    let commands = [
        vec!["pack", trial, "-o", "made.fmu"],
        vec!["decide", trial, "--decision", "walk.toml", "-o", "decided.fmu"],
        vec!["connect", "decision.fmu", "crowd.fmu", "-o", "made.ssp"],
        vec!["export", "long.csv", "made.sqlite", "--to", "jupedsim", "--area", "area.wkt"],
        vec!["export", "long.csv", "made.txt", "--to", "pedpy"],
        vec!["crowd", "-n", "2600", "--box", "17.2x17.2", "-o", "crowd", "--obj", "bodies.obj"],
        vec!["movie", "run.csv", "--trial", trial, "--speed-up", "0.001", "-o", "a.gif", "--forces"],
    ];
    for arguments in commands {
        for signal in ["-INT", "-TERM", "-HUP"] {
            let before = names(place);
            let mut begin = command(place, &[&arguments[..], &["--force"]].concat());
            let mut child = begin.env("TMPDIR", &temporary).stderr(Stdio::piped()).spawn().unwrap();
            // It may be done before anybody has looked.
            wait_for(|| !begun(place).is_empty() || child.try_wait().unwrap().is_some());
            if arguments[0] == "crowd" {
                // It is placing people then, and looks for the signal itself.
                std::thread::sleep(Duration::from_millis(300));
            }
            // It may have ended already.
            let _ = Command::new("kill").args([signal, &child.id().to_string()]).status();
            let code = child.wait().unwrap().code();
            // It may have been faster than the signal.
            assert!(matches!(code, Some(0 | 130)), "{arguments:?} {signal}: {code:?}");
            let made: Vec<String> = names(place).into_iter().filter(|name| !before.contains(name)).collect();
            if code == Some(130) && !made.is_empty() {
                // The signal came when all was written.
                let contents =
                    || made.iter().map(|name| std::fs::read(place.join(name)).ok()).collect::<Vec<_>>();
                let whole = contents();
                done(place, &[&arguments[..], &["--force"]].concat());
                assert!(contents() == whole, "{arguments:?} {signal}: {made:?}");
            }
            assert_eq!(begun(place), [""; 0], "{arguments:?} {signal}");
            assert_eq!(begun(&temporary), [""; 0], "{arguments:?} {signal}");
        }
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
        assert!(std::fs::read_to_string(&file).unwrap().len() > 200_000);
        child.wait().unwrap();
    }
}
