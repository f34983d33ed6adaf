//! What `lemons run` writes, stops and goes on with.

use crate::common::{command, joined, out};
use crowd_mechanics::setup;
use lemons_record::{Record, Run};
use parquet::file::reader::{FileReader, SerializedFileReader};
use std::fs::{self, File};
use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use tempfile::TempDir;

fn trial() -> String {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../resources/Trial_push").to_str().unwrap().to_owned()
}

fn lemons(directory: &Path, arguments: &[&str]) -> Output {
    command(directory, arguments).output().unwrap()
}

fn said(output: &Output, code: i32) -> String {
    let all = [&output.stdout[..], &output.stderr[..]].concat();
    let all = String::from_utf8_lossy(&all).into_owned();
    assert_eq!(output.status.code(), Some(code), "{all}");
    assert!(!all.contains("panicked"), "{all}");
    all
}

/// Runs the push, with options.
fn push(at: &Path, options: &str, code: i32) -> String {
    let options: Vec<&str> = options.split_whitespace().collect();
    said(&lemons(at, &[&["run", &trial()], &options[..]].concat()), code)
}

fn read(at: &Path, name: &str) -> Vec<u8> {
    fs::read(at.join(name)).unwrap()
}

/// Hidden files too.
fn names(at: &Path) -> Vec<String> {
    let mut names: Vec<String> =
        fs::read_dir(at).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

/// Runs the push for very long and sends a signal as soon as some steps are written.
#[cfg(unix)]
fn signalled(at: &Path, signal: &str, options: &str) -> Output {
    let mut child = Command::new(env!("CARGO_BIN_EXE_lemons"))
        .args(["run", &trial(), "--until", "100000"])
        .args(options.split_whitespace())
        .current_dir(at)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let prefix = format!(".lemons-{}-", child.id());
    let written = || {
        let files = fs::read_dir(at).unwrap().map(|entry| entry.unwrap());
        let mut own = files.filter(|entry| entry.file_name().to_str().unwrap().starts_with(&prefix));
        own.any(|entry| entry.metadata().is_ok_and(|file| file.len() > 8_000))
    };
    while !written() {
        assert!(child.try_wait().unwrap().is_none(), "it ended by itself");
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
    let sent = Command::new("kill").args([signal, &child.id().to_string()]).status().unwrap();
    assert!(sent.success());
    child.wait_with_output().unwrap()
}

#[test]
#[cfg(unix)]
fn ctrl_c_leaves_valid_results_and_the_run_goes_on_bit_for_bit() {
    let directory = TempDir::new().unwrap();
    let at = directory.path();
    let stopped = said(&signalled(at, "-INT", "--state push.run"), 130);
    assert!(stopped.contains("stopped by Ctrl-C ") && stopped.contains("go on with --resume push.run"));
    assert_eq!(names(at), ["push.run", "trajectories.csv"]);
    let run = Run::read_table(&at.join("trajectories.csv")).unwrap();
    let last = run.frames.len() - 1;
    assert!(last >= 12, "contacts go on: {last}");
    assert_eq!(run.frames[last].time, last as f64 * 0.05);
    // Twice on, each time with a table of its own; then at once.
    let time = |steps: usize| steps as f64 * 0.05;
    for (steps, to) in [(last + 7, "2.csv"), (last + 20, "3.csv")] {
        push(at, &format!("--resume push.run --state push.run --until {:?} -o {to}", time(steps)), 0);
    }
    let whole = push(at, &format!("--until {:?} -o whole.csv --state whole.run", time(last + 20)), 0);
    let parts = ["trajectories.csv", "2.csv", "3.csv"];
    assert!(joined(at, &parts) == read(at, "whole.csv"), "to the last byte");
    // Which are read as one.
    let measured = |tables: &[&str], option: &str| {
        said(
            &lemons(
                at,
                &[&["measure"], tables, &["--line", "9,0,9,9", option, "a.json", "--force"]].concat(),
            ),
            0,
        );
        let seen: serde_json::Value = serde_json::from_slice(&read(at, "a.json")).unwrap();
        (seen["frames"].clone(), seen["lines"].clone(), seen["exposure"].clone())
    };
    assert_eq!(measured(&parts, "--summary"), measured(&["whole.csv"], "--summary"));
    for tables in [&["whole.csv"][..], &parts] {
        let more: Vec<&str> = tables[1..].iter().flat_map(|table| ["--more", table]).collect();
        let to = format!("{}.txt", tables.len());
        said(&lemons(at, &[&["export", tables[0], &to, "--to", "pedpy"], &more[..]].concat()), 0);
    }
    assert!(read(at, "1.txt") == read(at, "3.txt"));
    let wrong = said(&lemons(at, &["measure", "2.csv", "trajectories.csv"]), 1);
    assert!(wrong.contains("trajectories.csv: begins at t = 0.0 s, before the end of the table"), "{wrong}");
    let line = |text: &str, name: &str| text.lines().find(|line| line.starts_with(name)).unwrap().to_owned();
    let summary = push(at, "--resume push.run --state push.run --until 100 -o - --step 9", 1);
    assert!(summary.contains("--step 9.0: the saved run has a communication step of 0.05 s"), "{summary}");
    // The extremes are those of the whole run.
    let next = format!("--resume push.run --until {:?} -o rest.csv", time(last + 21));
    let summary = push(at, &next, 0);
    for name in ["largest overlap", "greatest step mean", "greatest peak"] {
        assert_eq!(line(&summary, name), line(&whole, name));
    }
    assert_eq!(String::from_utf8(read(at, "rest.csv")).unwrap().lines().count(), 1 + 5);
}

/// What job schedulers send.
#[test]
#[cfg(unix)]
fn sigterm_completes_the_results_too() {
    let directory = TempDir::new().unwrap();
    let at = directory.path();
    said(&signalled(at, "-TERM", "--state push.run"), 130);
    assert_eq!(names(at), ["push.run", "trajectories.csv"]);
    let run = Run::read_table(&at.join("trajectories.csv")).unwrap();
    push(at, &format!("--resume push.run -o 2.csv --until {:?}", run.frames.len() as f64 * 0.05), 0);
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
fn parquet_holds_what_csv_holds() {
    let directory = TempDir::new().unwrap();
    let at = directory.path();
    push(at, "--until 1", 0);
    push(at, "--until 1 --format parquet", 0);
    push(at, "--until 1 -o again.parquet", 0);
    assert!(read(at, "trajectories.parquet") == read(at, "again.parquet"), "same run, same bytes");
    fs::rename(at.join("again.parquet"), at.join("odd.csv")).unwrap();
    let csv = Run::read_table(&at.join("trajectories.csv")).unwrap();
    for name in ["trajectories.parquet", "odd.csv"] {
        let parquet = Run::read_table(&at.join(name)).unwrap();
        assert_eq!(csv.ids, parquet.ids);
        assert_eq!(csv.frames.len(), 21);
        assert_eq!(csv.frames.len(), parquet.frames.len());
        for (a, b) in csv.frames.iter().zip(&parquet.frames) {
            assert_eq!((a.time, format!("{:?}", a.agents)), (b.time, format!("{:?}", b.agents)));
            assert_eq!(format!("{:?}", a.observed), format!("{:?}", b.observed));
            assert!(a.observed.is_some());
        }
    }
    push(at, "--until 0.4 -o part.parquet --state part.run", 0);
    push(at, "--until 1 -o rest.parquet --resume part.run", 0);
    let parts = Record::tables(&["part.parquet", "rest.parquet"].map(|name| at.join(name))).unwrap();
    assert!(parts.times().eq(csv.frames.iter().map(|frame| frame.time)));
    push(at, "--until 1 -o part.txt --format parquet", 0);
    assert!(read(at, "part.txt").starts_with(b"PAR1"));
    for (options, words) in [
        ("--format csv -o x.parquet", "x.parquet: ends in .parquet, but --format is csv"),
        ("--format parquet --outputs x.csv", "x.csv: ends in .csv, but --format is parquet"),
        ("--format hdf5", "hdf5"),
        ("--every 0", "--every"),
    ] {
        assert!(push(at, options, 2).contains(words), "{options}");
    }
}

/// Two people who overlap at the start and part: the squeeze of that instant was called a mean over a step to 0.000 s.
#[test]
fn the_greatest_mean_is_of_a_step_and_not_of_the_start() {
    let directory = TempDir::new().unwrap();
    let at = directory.path();
    let (mut trial, _) = setup::read(Path::new(&trial())).unwrap();
    trial.dynamics[1].position.x -= 0.08;
    trial.write(&at.join("T")).unwrap();
    let summary = said(&lemons(at, &["run", "T", "--until", "0.2", "--no-drive"]), 0);
    let run = Run::read_table(&at.join("trajectories.csv")).unwrap();
    let means = |range: &[lemons_record::Frame]| {
        let seen = range.iter().flat_map(|frame| frame.observed.iter().flatten());
        seen.map(|seen| seen.of_step.as_ref().unwrap().mean_normal_force).fold(0.0, f64::max)
    };
    let (start, steps) = (means(&run.frames[..1]), means(&run.frames[1..]));
    assert!(start > 1.5 * steps && steps > 0.0, "{start} {steps}");
    let line = summary.lines().find(|line| line.starts_with("greatest step mean")).unwrap();
    assert!(
        line.contains(&format!(" {steps:.1} N   (squeeze of agent ")) && line.ends_with(", step to 0.050 s)"),
        "{line}"
    );
    let peak = summary.lines().find(|line| line.starts_with("greatest peak")).unwrap();
    assert!(peak.ends_with(", step to 0.050 s)"), "{peak}");
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
    let of_step = ["mean_normal_force", "peak_normal_force", "peak_overlap"];
    let of_step = of_step.map(|name| names.iter().position(|known| *known == name).unwrap());
    let (all_rows, rows) = (cells(&every), cells(&third));
    assert!(third.lines().next() == every.lines().next() && rows.len() == 5 * (21 / 3 + 1));
    let mut hidden = [false; 3];
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
                Some(0) => values.sum::<f64>() / since.len() as f64,
                Some(_) => values.fold(0.0, f64::max),
            };
            assert!((value - wanted).abs() <= 1e-12 * wanted.abs(), "{k} {}: {value} {wanted}", names[place]);
            if let Some(of) = of_step.iter().position(|of| *of == place) {
                hidden[of] |= wanted > 1.5 * last;
            }
        }
    }
    assert_eq!(hidden, [true; 3], "much squeeze was between the rows");
    for name in ["largest overlap", "greatest step mean", "greatest peak"] {
        let line = |text: &str| text.lines().find(|line| line.starts_with(name)).unwrap().to_owned();
        assert_eq!(line(&all), line(&some));
    }
    // The greatest peak is of the step to 0.45 s, the ninth.
    let said =
        |text: &str| text.contains("(not in the table, whose last rows are before this step: --every)");
    let missed = push(at, "--until 0.5 -o missed.csv --every 7", 0);
    let kept = push(at, "--until 0.5 -o kept.csv --every 5", 0);
    assert!(said(&missed) && !said(&kept) && !said(&some) && !said(&all), "{missed}{kept}{some}");
    // Stopped between two rows, the run goes on with the right ones.
    push(at, "--until 0.5 -o part.csv --every 3 --state part.run", 0);
    push(at, "--until 1.03 -o rest.csv --resume part.run", 0);
    assert!(joined(at, &["part.csv", "rest.csv"]) == third.as_bytes());
}

/// The greatest squeeze is in a step of which the table with every second row has no row of its own.
#[test]
fn a_parquet_table_with_every_second_row_has_the_whole_exposure() {
    let directory = TempDir::new().unwrap();
    let at = directory.path();
    let peak = |table: &str, every: &str| {
        push(at, &format!("--until 1 -o {table} --every {every}"), 0);
        said(&lemons(at, &["measure", table, "--summary", "s.json", "--force"]), 0);
        let summary: serde_json::Value = serde_json::from_slice(&read(at, "s.json")).unwrap();
        summary["exposure"]["peak"]["max"].as_f64().unwrap()
    };
    let all = peak("all.parquet", "1");
    assert!(all > 20_000.0, "{all}");
    assert_eq!(peak("some.parquet", "2"), all);
}

/// Of a run that ended within a communication step, the bytes are others, although they were said to be the same.
#[test]
fn a_run_that_is_saved_between_two_communication_points_says_that_its_results_will_differ() {
    let directory = TempDir::new().unwrap();
    let at = directory.path();
    push(at, "--until 1 -o whole.csv", 0);
    let words =
        |time: &str| format!("warning: t = {time} s is between two communication points (0.05 s apart)");
    for (time, between) in [("0.52", true), ("0.55", false), ("0.5", false)] {
        let saved = push(at, &format!("--until {time} -o {time}.csv --state {time}.run"), 0);
        assert_eq!(saved.contains(&words(time)), between, "{saved}");
        let resumed = push(at, &format!("--until 1 -o {time}+.csv --resume {time}.run"), 0);
        assert_eq!(resumed.contains(&words(time)), between, "{resumed}");
        let parts = joined(at, &[&format!("{time}.csv"), &format!("{time}+.csv")]);
        assert_eq!(parts == read(at, "whole.csv"), !between, "{time}");
    }
    // Where nothing is saved, nothing is said.
    assert!(!push(at, "--until 0.52 -o x.csv", 0).contains("between two"));
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
    let text = |from: &'static str, to: &'static str| {
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
    for (from, to, words) in [
        (
            "format = 4",
            "format = 2",
            "run.toml: format = 2: this program knows format 4 only; continue the run with the program that saved it (lemons ",
        ),
        ("step = 0.05", "step = nan", "run.toml: step: NaN: must be positive and finite"),
        ("step = 0.05", "step = -1.0", "step: -1.0"),
        ("start = 0.0", "start = inf", "start: inf"),
        ("time = 0.5", "time = 0.7", "time: 0.7: must be from 0.5 on and before 0.55"),
        ("index = 10", "index = -1", "run.toml: "),
        ("index = 10", "index = 9000000000000000000", "time: 0.5: must be"),
        ("every = 1", "every = 0", "every: 0"),
        ("until = 0.5", "until = nan", "until: NaN"),
        ("largest_overlap = ", "largest_overlap = -", "largest_overlap: -"),
        ("agent = ", "agent = 7", "contains other agents"),
        (
            "component = \"crowd\"",
            "component = \"crowd\"\nsince = { duration = 1.0, agents = [[1.0, 1.0, 1.0]] }",
            "contains other agents",
        ),
        (
            "component = \"crowd\"",
            "component = \"crowd\"\nsince = { duration = -1.0, agents = [] }",
            "since: must be finite and not negative",
        ),
        ("state = \"state-0\"", "state = \"../x\"", "it contains no \"../x\""),
        (
            "state = \"state-0\"",
            "state = \"run.toml\"",
            "run.toml: state: \"run.toml\": component \"crowd\" has no entry of its own",
        ),
        ("bytes = ", "bytes = 1", "state-0: has not the 1"),
        ("every = 1", "every = 1\nevil = 1", "evil"),
        ("guid = \"{", "guid = \"{0", "the saved run is of"),
        ("[[crowd]]", "[[crowd]]\ncomponent = \"x\"", "run.toml: "),
        (
            "[[component]]",
            "[[component]]\nname = \"other\"\nmodel = \"\"\nguid = \"\"\nstate = \"state-0\"\nbytes = 1\n\n[[component]]",
            "run.toml: state: \"state-0\": is that of component \"other\" and of \"crowd\"",
        ),
        ("component = \"crowd\"", "component = \"x\"", "it has no entry for the crowd \"crowd\""),
    ] {
        let said = text(from, to);
        assert!(said.contains("run") && said.contains(words), "{from} -> {to}: {said}");
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
        let table = SerializedFileReader::new(File::open(at.join(name)).unwrap()).unwrap();
        let about = table.metadata().file_metadata().key_value_metadata().unwrap();
        about.iter().find(|entry| entry.key == "lemons_version").unwrap().value.clone().unwrap()
    };
    push(at, "--until 0.5 --state push.run --format parquet", 0);
    let own = built("trajectories.parquet");
    let word = |k: usize| own.split(['(', ')', ' ']).nth(k).map(str::to_owned);
    let shown = out(&lemons(at, &["-V"]));
    assert!(shown.starts_with(&format!("lemons {}", env!("CARGO_PKG_VERSION"))), "{shown}");
    assert_eq!(word(0).as_deref(), Some(env!("CARGO_PKG_VERSION")));
    // The commit is whole in files.
    let commit = word(2).unwrap_or_default();
    assert!(commit.is_empty() || shown.contains(&commit[..commit.len().min(7)]), "{own}: {shown}");
    forged(at, "push.run", |name, bytes| match name {
        "run.toml" => {
            let text = String::from_utf8(bytes).unwrap();
            let said = format!("lemons = \"{own}\"");
            assert!(text.contains(&said), "{text}");
            text.replace(&said, "lemons = \"0.1.0 (0123456 2026-01-01)\"").into_bytes()
        }
        _ => bytes,
    });
    for (until, from, to) in [("1", "forged.run", "2.parquet"), ("1.5", "later.run", "3.parquet")] {
        push(at, &format!("--until {until} --resume {from} --state later.run -o {to}"), 0);
        assert_eq!(built(to), format!("0.1.0 (0123456 2026-01-01); {own}"));
    }
}

#[test]
fn a_run_goes_on_as_it_went_or_not_at_all() {
    let directory = TempDir::new().unwrap();
    let at = directory.path();
    push(at, "--until 0.5 --state push.run", 0);
    let before = read(at, "trajectories.csv");
    fs::write(at.join("drive.csv"), "t,agent,Fp.x,Fp.y,Mp\n0,0,1,2,3\n").unwrap();
    for (options, code, words) in [
        (
            "--set agent[0].Mass=80",
            2,
            "--set agent[0].Mass=80 with --resume: the saved run contains its parameters",
        ),
        ("--threads 2", 2, "--threads 2 with --resume"),
        ("--step 0.1", 1, "--step 0.1: the saved run has a communication step of 0.05 s"),
        ("--every 2", 1, "--every 2: the saved run has --every 1"),
        ("--drive drive.csv", 1, "the saved run had another drive"),
        ("--no-drive", 1, "the saved run had another drive"),
        ("--until 0.5", 1, "nothing to simulate: the saved run is at 0.5 s"),
        ("", 1, "nothing to simulate"),
        ("--until 1 --algorithm gauss-seidel", 1, "--algorithm: the saved run has Jacobi, not Gauss-Seidel"),
        ("--until 1 -o new.csv --state new.csv", 1, "new.csv: another result goes there"),
    ] {
        let until = if options.contains("--until") || options.is_empty() { "" } else { " --until 1" };
        let said = push(at, &format!("--resume push.run {options}{until}"), code);
        assert!(said.contains(words), "{options}: {said}");
        assert!(read(at, "trajectories.csv") == before);
    }
    // What the saved run has written is not replaced, unless somebody says so.
    for options in ["", " -o trajectories.csv"] {
        let said = push(at, &format!("--resume push.run --until 1{options}"), 1);
        let words = "trajectories.csv: it is there, and may hold what the saved run has written";
        assert!(said.contains(words) && read(at, "trajectories.csv") == before, "{said}");
    }
    push(at, "--resume push.run --until 1 --force", 0);
    assert!(joined(at, &["trajectories.csv"]) != before);
    // Another crowd.
    let (mut other, _) = setup::read(Path::new(&trial())).unwrap();
    other.agents[0].id = "other".into();
    other.write(&at.join("other")).unwrap();
    let message = said(
        &lemons(at, &["run", "other", "--resume", "push.run", "--no-drive", "--until", "1", "-o", "o.csv"]),
        1,
    );
    assert!(
        message.contains("saved run push.run: ") && message.contains("one of the packed Trials"),
        "{message}"
    );
    // And one that has the same name.
    other.agents[0].id = "0".into();
    other.agents[0].mass += 1.0;
    other.write(&at.join("elsewhere/Trial_push")).unwrap();
    let again = ["run", "elsewhere/Trial_push", "--resume", "push.run", "--no-drive", "--until", "1"];
    let message = said(&lemons(at, &again), 1);
    assert!(message.contains("has changed since the state was saved"), "{message}");
    assert!(names(at).iter().all(|name| !name.starts_with('.')), "{:?}", names(at));
}

#[test]
fn help_is_readable() {
    let directory = TempDir::new().unwrap();
    let help = said(&lemons(directory.path(), &["run", "--help"]), 0);
    assert!(help.lines().all(|line| line.chars().count() <= 80), "{help}");
}

/// Sends it once the run's files are begun and, as nothing tells when a step is under way, a moment later.
#[cfg(unix)]
fn interrupted(at: &Path, arguments: &[&str]) -> Output {
    let files = || fs::read_dir(at).unwrap().count();
    let before = files();
    let mut child = command(at, arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    while files() == before {
        assert!(child.try_wait().unwrap().is_none(), "it ended by itself");
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
    std::thread::sleep(std::time::Duration::from_secs(1));
    assert!(child.try_wait().unwrap().is_none(), "it ended by itself");
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    child.wait_with_output().unwrap()
}

/// The step of 7.5e8 mechanical ones takes minutes: the run ends before it does.
#[test]
#[cfg(unix)]
fn one_long_step_can_be_interrupted() {
    let directory = TempDir::new().unwrap();
    let at = directory.path();
    let step = ["--step", "1500", "--until", "1500"];
    let trial = trial();
    let output = interrupted(at, &[&["run", &trial, "--state", "a.run"], &step[..]].concat());
    let text = said(&output, 130);
    assert!(text.contains("stopped at t = 0.0 s; go on with --resume a.run"), "{text}");
    assert_eq!(names(at), ["a.run", "trajectories.csv"]);
    assert_eq!(Run::read_table(&at.join("trajectories.csv")).unwrap().frames.len(), 1);
    // What was kept goes on.
    let more = push(at, "--resume a.run --until 0.1 --step 1500 -o rest.csv", 0);
    assert!(more.contains("simulated time          0.100 s"), "{more}");

    let before = names(at);
    let output = interrupted(at, &["plot", &trial, "--at", "1500", "--step", "1500", "-o", "a.png"]);
    let text = said(&output, 130);
    assert!(text.contains("interrupted: nothing was written"), "{text}");
    assert_eq!(names(at), before);
}

#[test]
fn endless_runs_are_refused_with_their_number() {
    let directory = TempDir::new().unwrap();
    let at = directory.path();
    let refused = |arguments: &[&str], most: &str| {
        let output = command(at, arguments).output().unwrap();
        let text = said(&output, 1);
        let expected = format!("2.0000e301 communication steps of 0.05 s: at most {most}");
        assert!(text.contains(&expected), "{arguments:?}: {text}");
        assert_eq!(names(at), Vec::<String>::new());
    };
    let trial = trial();
    refused(&["run", &trial, "--until", "1e300"], "1e9");
    refused(&["plot", &trial, "--at", "1e300"], "1e9");
    refused(&["plot", &trial, "--series", "x", "--until", "1e300"], "1e9");
    refused(&["movie", &trial, "--until", "1e300", "-o", "a.gif"], "1e9");
    let output = Command::new(env!("CARGO_BIN_EXE_lemons"))
        .args(["plot", &trial, "--at", "60000"])
        .current_dir(at)
        .output();
    let text = said(&output.unwrap(), 1);
    assert!(text.contains("1.2000e6 communication steps of 0.05 s: at most 1e6 are made"), "{text}");
}

#[test]
fn unknown_kinds_of_tables_are_refused() {
    let directory = TempDir::new().unwrap();
    let at = directory.path();
    for options in ["-o t.xlsx", "--outputs t.xlsx", "-o t.csv.gz"] {
        let text = push(at, options, 2);
        assert!(text.contains(": tables are .csv or .parquet"), "{text}");
        assert_eq!(names(at), Vec::<String>::new());
    }
    push(at, "--until 0.1 -o t.dat --format csv", 0);
    push(at, "--until 0.1 -o plain", 0);
    assert!(read(at, "t.dat") == read(at, "plain"));
}

#[test]
fn a_parameter_of_all_agents() {
    let directory = TempDir::new().unwrap();
    let at = directory.path();
    let each: Vec<String> = (0..5).map(|i| format!("--set agent[{i}].Mass=80")).collect();
    push(at, &format!("--until 1 -o each.csv {}", each.join(" ")), 0);
    push(at, "--until 1 -o all.csv --set agent[*].Mass=80", 0);
    push(at, "--until 1 -o own.csv", 0);
    assert!(read(at, "each.csv") == read(at, "all.csv") && read(at, "all.csv") != read(at, "own.csv"));
    let unknown = push(at, "--until 1 --set agent[*].Beauty=80", 1);
    assert!(unknown.contains("the FMU has no variable \"agent[*].Beauty\""), "{unknown}");
    let trial = trial();
    let done = |arguments: &[&str]| {
        let output = command(at, arguments).output().unwrap();
        said(&output, 0)
    };
    let plot = ["plot", &trial, "--series", "x", "--until", "1", "-o"];
    let each: Vec<&str> = each.iter().flat_map(|option| option.split(' ')).collect();
    done(&[&plot[..], &["each.svg"], &each].concat());
    done(&[&plot[..], &["all.svg", "--set", "agent[*].Mass=80"]].concat());
    assert!(read(at, "each.svg") == read(at, "all.svg"));
}

#[test]
fn negative_numbers_are_values() {
    let directory = TempDir::new().unwrap();
    let trial = trial();
    for (arguments, expected) in [
        (
            ["run", &trial, "--until", "-1"],
            "'-1' for '--until <SECONDS|left>': must be a positive number of seconds, or the word left",
        ),
        (["run", &trial, "--step", "-0.5"], "'-0.5' for '--step <SECONDS>': must be a positive"),
        (["run", &trial, "--every", "-3"], "'-3' for '--every <N>': -3 is not in 1.."),
        (["plot", &trial, "--until", "-1e3"], "'-1e3' for '--until <SECONDS|left>': must be a positive"),
        (["movie", &trial, "--frame-rate", "-25"], "'-25' for '--frame-rate <FPS>': must be a number from"),
    ] {
        let output = Command::new(env!("CARGO_BIN_EXE_lemons"))
            .args(arguments)
            .current_dir(directory.path())
            .output()
            .unwrap();
        let text = said(&output, 2);
        assert!(text.contains(expected) && !text.contains("use '--"), "{text}");
    }
}

/// \[kB\] What it held at most, as far as was seen while it ran.
#[cfg(target_os = "linux")]
fn memory_of(at: &Path, arguments: &[&str]) -> u64 {
    let mut child = Command::new(env!("CARGO_BIN_EXE_lemons"))
        .args(arguments)
        .current_dir(at)
        .stdout(Stdio::null())
        .spawn()
        .unwrap();
    let status = format!("/proc/{}/status", child.id());
    let mut most = 0;
    while child.try_wait().unwrap().is_none() {
        let text = fs::read_to_string(&status).unwrap_or_default();
        let peak = text.lines().find_map(|line| line.strip_prefix("VmHWM:"));
        let peak = peak.and_then(|line| line.split_whitespace().next()?.parse().ok());
        most = most.max(peak.unwrap_or(0));
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    assert!(child.wait().unwrap().success(), "{arguments:?}");
    most
}

/// A table of 300 000 rows; a run of them in memory takes 30 MB more.
#[test]
#[cfg(target_os = "linux")]
fn a_long_table_is_exported_and_drawn_in_little_memory() {
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
    let few = memory_of(at, &["export", &trial, "--help"]);
    for arguments in [
        &["export", "long.csv", "long.txt", "--to", "pedpy"][..],
        &["export", "long.csv", "long.sqlite", "--to", "jupedsim", "--trial", &trial],
        &["export", "long.csv", "long", "--to", "chaos"],
        &["export", "long.csv", "end", "--to", "trial", "--trial", &trial],
        &["plot", "long.csv", "--trial", &trial, "--at", "1,20,2900", "-o", "a.svg"],
    ] {
        let most = memory_of(at, arguments);
        // What needs less was over before it was looked at.
        assert!(most < few.max(10_000) + 20_000, "{arguments:?}: {most} kB, of {few} kB without a table");
    }
}
