//! Results of `lemons run`: written, stopped, and continued.

use crate::common::{self, default_trial, lemons, names, started, wait_for};
use lemons_results::Run;
use std::fs::{self, File};
use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use tempfile::TempDir;

fn trial() -> String {
    default_trial().display().to_string()
}

fn message(output: &Output, code: i32) -> String {
    let all = [&output.stdout[..], &output.stderr[..]].concat();
    let all = String::from_utf8_lossy(&all).into_owned();
    assert_eq!(output.status.code(), Some(code), "{all}");
    assert!(!all.contains("panicked"), "{all}");
    all
}

/// Runs the push, with options.
fn push(at: &Path, options: &str, code: i32) -> String {
    let options: Vec<&str> = options.split_whitespace().collect();
    message(&lemons(at, &[&["run", &trial()], &options[..]].concat()), code)
}

fn read(at: &Path, name: &str) -> Vec<u8> {
    fs::read(at.join(name)).unwrap()
}

/// Runs the push for very long and sends a signal as soon as some steps are written.
#[cfg(unix)]
fn signalled(at: &Path, signal: &str, options: &str) -> Output {
    let trial = trial();
    let arguments = [&["run", &trial, "--until", "100000"], &*options.split_whitespace().collect::<Vec<_>>()];
    let child = started(at, &arguments.concat());
    let prefix = format!(".lemons-{}-", child.id());
    common::signalled(child, signal, || {
        let mut own = names(at).into_iter().filter(|name| name.starts_with(&prefix));
        own.any(|name| fs::metadata(at.join(name)).is_ok_and(|file| file.len() > 40_000))
    })
}

#[test]
#[cfg(unix)]
fn a_signal_leaves_valid_results_and_the_run_goes_on_bit_for_bit() {
    let directory = TempDir::new().unwrap();
    let at = directory.path();
    let stopped = message(&signalled(at, "-TERM", "--state push.run"), 130);
    assert!(stopped.contains("stopped by Ctrl-C ") && stopped.contains("go on with --resume push.run"));
    assert_eq!(names(at), ["push.run", "trajectories.csv"]);
    let run = Run::read_table(&at.join("trajectories.csv")).unwrap();
    let last = run.frames.len() - 1;
    assert!(last >= 12, "contacts go on: {last}");
    assert_eq!(run.frames[last].time, last as f64 * 0.05);
    // Twice on, then at once.
    let (mut table, mut summary) = (read(at, "trajectories.csv"), String::new());
    for steps in [last + 7, last + 20] {
        let until = format!("--until {:?} -o rest.csv --force", steps as f64 * 0.05);
        summary = push(at, &format!("--resume push.run --state push.run {until}"), 0);
        let rest = read(at, "rest.csv");
        table.extend(&rest[rest.iter().position(|byte| *byte == b'\n').unwrap() + 1..]);
    }
    let whole = push(at, &format!("--until {:?} -o whole.csv", (last + 20) as f64 * 0.05), 0);
    assert!(table == read(at, "whole.csv"), "to the last byte");
    let until = (last + 1000) as f64 * 0.05;
    let refused = push(at, &format!("--resume push.run --state push.run --until {until:?} -o - --step 9"), 1);
    assert!(refused.contains("--step: a communication step of 9.0 s: the saved run has one of 0.05 s"));
    // The extremes are those of the whole run.
    let line = |text: &str, name: &str| text.lines().find(|line| line.starts_with(name)).unwrap().to_owned();
    for name in ["largest overlap", "greatest step mean", "greatest peak"] {
        assert_eq!(line(&summary, name), line(&whole, name));
    }
}

#[test]
#[cfg(unix)]
fn a_killed_run_leaves_nothing_under_its_names() {
    let directory = TempDir::new().unwrap();
    let at = directory.path();
    fs::write(at.join("trajectories.csv"), "of before").unwrap();
    assert_eq!(signalled(at, "-KILL", "--state push.run --force").status.code(), None);
    assert_eq!(read(at, "trajectories.csv"), b"of before");
    assert!(!at.join("push.run").exists());
}

#[test]
fn every_nth_point_is_written_and_all_are_looked_at() {
    let directory = TempDir::new().unwrap();
    let at = directory.path();
    let all = push(at, "--until 1.03 -o all.csv", 0);
    let some = push(at, "--until 1.03 -o some.csv --every 3", 0);
    let text = |name: &str| String::from_utf8(read(at, name)).unwrap();
    let (every, third) = (text("all.csv"), text("some.csv"));
    let cells = |text: &str| -> Vec<Vec<f64>> {
        let rows = text.lines().skip(1).map(|row| row.split(',').map(|cell| cell.parse().unwrap()).collect());
        rows.collect()
    };
    let names: Vec<&str> = every.lines().next().unwrap().split(',').collect();
    let of_step = ["mean_normal_force", "peak_normal_force", "peak_overlap", "mean_wall_force"];
    let of_step = of_step.map(|name| names.iter().position(|known| *known == name).unwrap());
    let (all_rows, rows) = (cells(&every), cells(&third));
    assert!(third.lines().next() == every.lines().next() && rows.len() == 5 * (21 / 3 + 1));
    let mut hidden = [false; 4];
    for (k, row) in rows.iter().enumerate() {
        // Of the same agent: the row of this point, and those of the steps since the row before.
        let point = 3 * (k / 5);
        let since = if point == 0 { 0..1 } else { point - 2..point + 1 };
        let since: Vec<&Vec<f64>> = since.map(|point| &all_rows[5 * point + k % 5]).collect();
        for (place, value) in row.iter().enumerate() {
            let values = since.iter().map(|row| row[place]);
            let last = since[since.len() - 1][place];
            let wanted = match of_step.iter().position(|of| *of == place) {
                None => last,
                Some(0 | 3) => values.sum::<f64>() / since.len() as f64,
                Some(_) => values.fold(0.0, f64::max),
            };
            assert!((value - wanted).abs() <= 1e-12 * wanted.abs(), "{k} {}: {value} {wanted}", names[place]);
            if let Some(of) = of_step.iter().position(|of| *of == place) {
                hidden[of] |= wanted > 1.5 * last;
            }
        }
    }
    assert_eq!(hidden[..3], [true; 3], "much squeeze was between the rows");
    for name in ["largest overlap", "greatest step mean", "greatest peak"] {
        let line = |text: &str| text.lines().find(|line| line.starts_with(name)).unwrap().to_owned();
        assert_eq!(line(&all), line(&some));
    }
    // The greatest peak is of the step to 0.45 s, the ninth.
    let noted =
        |text: &str| text.contains("(not in the table, whose last rows are before this step: --every)");
    let missed = push(at, "--until 0.5 -o missed.csv --every 7", 0);
    let kept = push(at, "--until 0.5 -o kept.csv --every 5", 0);
    assert!(noted(&missed) && !noted(&kept) && !noted(&some) && !noted(&all), "{missed}{kept}{some}");
    // Stopped between two rows, the run goes on with the right ones.
    push(at, "--until 0.5 -o part.csv --every 3 --state part.run", 0);
    push(at, "--until 1.03 -o rest.csv --resume part.run", 0);
    assert!(text("part.csv") + text("rest.csv").split_once('\n').unwrap().1 == third);
}

/// A saved run, its texts and states changed.
fn forged(at: &Path, from: &str, change: impl Fn(&str, Vec<u8>) -> Vec<u8>) -> PathBuf {
    let mut zip = zip::ZipArchive::new(File::open(at.join(from)).unwrap()).unwrap();
    let path = at.join("forged.run");
    let mut out = zip::ZipWriter::new(File::create(&path).unwrap());
    for place in 0..zip.len() {
        let mut entry = zip.by_index(place).unwrap();
        let name = entry.name().unwrap().into_owned();
        let mut bytes = Vec::new();
        entry.read_to_end(&mut bytes).unwrap();
        out.start_file(name.as_str(), zip::write::SimpleFileOptions::default()).unwrap();
        out.write_all(&change(&name, bytes)).unwrap();
    }
    out.finish().unwrap();
    path
}

#[test]
fn saved_runs_are_hostile_until_checked() {
    let directory = TempDir::new().unwrap();
    let at = directory.path();
    push(at, "--until 0.5 --state push.run", 0);
    let before = read(at, "trajectories.csv");
    let text = |from: &str, to: &str| {
        forged(at, "push.run", |name, bytes| {
            if name != "run.toml" {
                return bytes;
            }
            let text = String::from_utf8(bytes).unwrap();
            assert!(text.contains(from), "{text}");
            text.replacen(from, to, 1).into_bytes()
        });
        push(at, "--resume forged.run --until 1 -o rest.csv", 1)
    };
    let table = include_str!("forged_runs.txt").lines().filter(|line| !line.starts_with('#'));
    for row in table {
        let row = row.replace("\\n", "\n");
        let [from, to, words] = row.split(" | ").collect::<Vec<_>>()[..] else { panic!("{row:?}") };
        let message = text(from, to);
        assert!(message.contains("run") && message.contains(words), "{from} -> {to}: {message}");
        assert!(read(at, "trajectories.csv") == before, "{to}");
    }
    forged(at, "push.run", |name, mut bytes| {
        if name == "state-0" {
            let place = bytes.len() / 2;
            bytes[place] ^= 1;
        }
        bytes
    });
    let message = push(at, "--resume forged.run --until 1 -o rest.csv", 1);
    assert!(message.contains("forged.run: ") && message.contains("the state is damaged"), "{message}");
    let mut zip = zip::ZipWriter::new(File::create(at.join("forged.run")).unwrap());
    for name in ["run.toml", "./Run.toml"] {
        zip.start_file(name, zip::write::SimpleFileOptions::default()).unwrap();
    }
    zip.finish().unwrap();
    let message = push(at, "--resume forged.run --until 1 -o rest.csv", 1);
    assert!(message.contains("the entries \"run.toml\" and \"./Run.toml\" have one name"), "{message}");
    // A small archive of a lot.
    let mut zip = zip::ZipWriter::new(File::create(at.join("forged.run")).unwrap());
    zip.start_file("run.toml", zip::write::SimpleFileOptions::default()).unwrap();
    zip.write_all(&vec![b' '; 5_000_000]).unwrap();
    zip.finish().unwrap();
    assert!(
        push(at, "--resume forged.run --until 1 -o rest.csv", 1)
            .contains("run.toml: is refused: more than 4 MB")
    );
    fs::write(at.join("forged.run"), "t,id").unwrap();
    let message = push(at, "--resume forged.run --until 1 -o rest.csv", 1);
    assert!(
        message.contains("forged.run: is a text file, not a saved run (--state writes one)"),
        "{message}"
    );
    assert!(push(at, "--resume none.run", 1).contains("none.run"));
}

/// A run of days must not be lost to an update of the program; the files say who wrote them.
#[test]
fn a_run_of_another_build_of_the_program_goes_on_and_all_builds_are_named() {
    let directory = TempDir::new().unwrap();
    let at = directory.path();
    let built = |name: &str| {
        let file =
            parquet::file::reader::SerializedFileReader::new(File::open(at.join(name)).unwrap()).unwrap();
        let about =
            parquet::file::reader::FileReader::metadata(&file).file_metadata().key_value_metadata().unwrap();
        about.iter().find(|entry| entry.key == "lemons_version").unwrap().value.clone().unwrap()
    };
    push(at, "--until 0.5 --state push.run --format parquet", 0);
    let own = built("trajectories.parquet");
    forged(at, "push.run", |name, bytes| match name {
        "run.toml" => {
            let text = String::from_utf8(bytes).unwrap();
            let own_line = format!("lemons = \"{own}\"");
            assert!(text.contains(&own_line), "{text}");
            text.replace(&own_line, "lemons = \"0.1.0 (0123456 2026-01-01)\"").into_bytes()
        }
        _ => bytes,
    });
    push(at, "--until 1 --resume forged.run --state later.run -o later.parquet", 0);
    assert_eq!(built("later.parquet"), format!("0.1.0 (0123456 2026-01-01); {own}"));
    push(at, "--until 1.5 --resume later.run -o last.parquet", 0);
    assert_eq!(built("last.parquet"), format!("0.1.0 (0123456 2026-01-01); {own}"));
}

/// Runs the command where it can have so much memory of its own \[kB\], and no more. Nothing is sampled while it runs, so
/// that it does not matter what else the machine does. (`wait4` would say the memory of the tests, too: until a started
/// program replaces them, it shares theirs.)
#[cfg(target_os = "linux")]
fn within(memory: u32, at: &Path, arguments: &[&str]) -> Output {
    let mut shell = Command::new("sh");
    shell.args(["-c", r#"ulimit -d "$0" && exec "$@""#, &memory.to_string(), env!("CARGO_BIN_EXE_lemons")]);
    // Each thread has a stack.
    shell.args(arguments).current_dir(at).env("RAYON_NUM_THREADS", "2").output().unwrap()
}

/// A table of 300 000 rows.
#[test]
#[cfg(target_os = "linux")]
fn a_long_table_is_exported_and_drawn_in_little_memory() {
    /// \[kB\]
    const ENOUGH: u32 = 30_000;
    let directory = TempDir::new().unwrap();
    let at = directory.path();
    let mut file = std::io::BufWriter::new(File::create(at.join("long.csv")).unwrap());
    let header = "t,id,x,y,vx,vy,theta,omega,agent_contacts,wall_contacts,contacting_agents,normal_force";
    writeln!(file, "{header}").unwrap();
    for k in 0..60_000 {
        for id in 0..5 {
            writeln!(file, "{:?},{id},{},{},0,0,0.5,0,1,0,1,3.5", f64::from(k) * 0.05, k % 97, id).unwrap();
        }
    }
    file.into_inner().unwrap();
    let trial = trial();
    for arguments in [
        &["export", "long.csv", "long.txt", "--to", "pedpy"][..],
        &["export", "long.csv", "long.sqlite", "--to", "jupedsim", "--trial", &trial],
        &["export", "long.csv", "long", "--to", "chaos"],
        &["export", "long.csv", "end", "--to", "trial", "--trial", &trial],
        &["plot", "long.csv", "--trial", &trial, "--at", "1,20,2900", "-o", "a.svg"],
    ] {
        let output = within(ENOUGH, at, arguments);
        assert!(output.status.success(), "{arguments:?}: {}", common::err(&output));
    }
    // All frames of it do not fit.
    let all = ["plot", "long.csv", "--trial", &trial, "--trails", "-o", "b.svg"];
    assert!(!within(ENOUGH, at, &all).status.success());
    assert!(within(10 * ENOUGH, at, &all).status.success());
}

/// Which of two runs ends first is not known: here the other one is a file that appears while a run is held.
#[test]
fn what_another_program_writes_meanwhile_stays_and_the_run_is_told() {
    let directory = TempDir::new().unwrap();
    let at = directory.path();
    push(at, "--until 3 -o alone.csv", 0);
    let alone = read(at, "alone.csv");
    let begun = || names(at).iter().any(|name| name.starts_with(".lemons-"));
    // The first name is one that a run may replace, if it was there before.
    for (file, other) in [("trajectories.csv", "trajectories-2.csv"), ("x.csv", "x-2.csv")] {
        let mut child = started(at, &["run", &trial(), "--until", "3", "-o", file]);
        wait_for(&mut child, begun);
        let send = |signal: &str| {
            assert!(Command::new("kill").args([signal, &child.id().to_string()]).status().unwrap().success());
        };
        send("-STOP");
        File::create_new(at.join(file)).unwrap().write_all(b"of another run").unwrap();
        send("-CONT");
        let message = message(&child.wait_with_output().unwrap(), 1);
        let named = at.canonicalize().unwrap().join(other);
        let expected = format!(
            "{file}: cannot be written: another program has written it meanwhile; this result is in {}",
            named.display()
        );
        assert!(message.contains(&expected), "{message}");
        assert!(read(at, file) == b"of another run" && read(at, other) == alone);
    }
    // What a command itself writes into a directory that it also writes is its own.
    let into = ["crowd", "-n", "6", "--open", "-o", "T", "--zip", "T/t.zip", "--fmu", "T/t.fmu", "--force"];
    assert!(lemons(at, &into[..6]).status.success());
    for _ in 0..2 {
        message(&lemons(at, &into), 0);
    }
    // A Trial, whose files are claimed one by one.
    let mut child =
        started(at, &["crowd", "-n", "400", "--box", "10x10", "-o", "crowd", "--obj", "bodies.obj"]);
    wait_for(&mut child, begun);
    fs::create_dir(at.join("crowd")).unwrap();
    fs::write(at.join("crowd/Parameters.xml"), "of another crowd").unwrap();
    let message = message(&child.wait_with_output().unwrap(), 1);
    let expected = "cannot write crowd/Parameters.xml: another program has written it meanwhile";
    assert!(message.contains(expected), "{message}");
    assert_eq!(names(&at.join("crowd")), ["Parameters.xml"]);
}
