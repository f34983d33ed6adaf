//! `lemons plot` and `lemons movie`: what is in the pictures is what was in the run.

use crate::common::{command, default_trial, done, err};
use std::fs;
use std::path::Path;
use tempfile::TempDir;

/// The default push until 1 s, as a table, and as the XML series of the FMU.
fn push() -> TempDir {
    let directory = TempDir::new().unwrap();
    let (at, trial) = (directory.path(), default_trial());
    let trial = trial.to_str().unwrap();
    done(at, &["run", trial, "--until", "1", "--set", "OutputDirectory=series"]);
    std::os::unix::fs::symlink(trial, at.join("push")).unwrap();
    directory
}

fn svg(at: &Path, arguments: &[&str]) -> String {
    let output = done(at, &[&["plot"], arguments, &["-o", "plot.svg", "--force"]].concat());
    assert!(output.stderr.is_empty(), "{}", err(&output));
    fs::read_to_string(at.join("plot.svg")).unwrap()
}

/// The rows of a table at a time, as t, id and numbers in the columns' order.
fn rows_at(at: &Path, time: f64) -> Vec<Vec<f64>> {
    let table = fs::read_to_string(at.join("trajectories.csv")).unwrap();
    let rows = table.lines().skip(1).map(|row| row.split(',').map(|cell| cell.parse().unwrap()).collect());
    rows.filter(|row: &Vec<f64>| (row[0] - time).abs() < 1e-9).collect()
}

/// The place of a column of the table.
fn column(at: &Path, name: &str) -> usize {
    let table = fs::read_to_string(at.join("trajectories.csv")).unwrap();
    table.lines().next().unwrap().split(',').position(|column| column == name).unwrap()
}

/// The labels of everything that is lettered.
fn labels(svg: &str) -> Vec<&str> {
    svg.split("aria-label=\"").skip(1).map(|rest| rest.split('"').next().unwrap()).collect()
}

/// Centres of the bodies, in the order of the picture.
fn places(svg: &str) -> Vec<(f64, f64)> {
    let bodies = svg.split("<g transform=\"translate(").skip(1);
    let pairs = bodies.map(|rest| rest.split(')').next().unwrap());
    let number = |text: &str| text.parse::<f64>().unwrap();
    pairs
        .map(|pair| {
            let cut = pair.find(' ').unwrap_or_else(|| 1 + pair[1..].find('-').unwrap());
            (number(&pair[..cut]), number(pair[cut..].trim()))
        })
        .collect()
}

#[test]
fn a_scene_is_where_the_run_was() {
    let directory = push();
    let at = directory.path();
    let text = svg(at, &["trajectories.csv", "--trial", "push", "--at", "0.4", "--fill", "squeeze"]);
    let (rows, drawn) = (rows_at(at, 0.4), places(&text));
    assert_eq!(drawn.len(), 5);
    for (row, place) in rows.iter().zip(drawn) {
        assert!((row[2] - place.0).abs() < 6e-5 && (row[3] - place.1).abs() < 6e-5, "{row:?} {place:?}");
    }
    let greatest = rows.iter().map(|row| row[column(at, "mean_normal_force")]).fold(0.0, f64::max);
    let labels = labels(&text);
    assert!(greatest > 10.0);
    assert!(labels.contains(&"t = 0.40 s") && labels.contains(&"mean squeeze over a step (N)"), "{labels:?}");
    let high = labels[labels.iter().position(|l| *l == "mean squeeze over a step (N)").unwrap() - 1];
    let high: f64 = high.parse().unwrap();
    assert!((high / greatest - 1.0).abs() < 0.01, "{labels:?}, {greatest} N");
}

/// One step in two hundred is a spike: all others had the colour of nothing.
#[test]
fn a_spike_does_not_set_the_scale() {
    let directory = push();
    let at = directory.path();
    let (place, table) =
        (column(at, "mean_normal_force"), fs::read_to_string(at.join("trajectories.csv")).unwrap());
    let rows: Vec<String> = table
        .lines()
        .enumerate()
        .map(|(k, row)| {
            let mut cells: Vec<String> = row.split(',').map(str::to_owned).collect();
            if k > 0 {
                cells[place] = if k == 40 { "90000".into() } else { format!("{}", 100 + k) };
            }
            cells.join(",")
        })
        .collect();
    fs::write(at.join("spike.csv"), rows.join("\n") + "\n").unwrap();
    let count = rows.len() - 1;
    assert!(count > 100, "{count} rows");
    let times: Vec<String> = (0..=20).map(|k| format!("{}", f64::from(k) * 0.05)).collect();
    let text = svg(at, &["spike.csv", "--trial", "push", "--at", &times.join(","), "--fill", "squeeze"]);
    let labels = labels(&text);
    assert!(labels.contains(&"mean squeeze over a step (N), to the 98 % quantile"), "{labels:?}");
    let high = labels.iter().find_map(|label| label.strip_prefix("≥ ")).unwrap().parse::<f64>().unwrap();
    // The spike is the last of them; the others are 101, 102, ….
    let rank = (0.98 * count as f64).ceil();
    assert!((high - (100.0 + rank)).abs() <= 2.0, "{high} N of {count} rows");
    let asked =
        svg(at, &["spike.csv", "--trial", "push", "--at", "0,1", "--fill", "squeeze", "--range", "0,50"]);
    assert!(asked.contains("≥ 50") && !asked.contains("quantile"));
    let room =
        svg(at, &["spike.csv", "--trial", "push", "--at", "0,1", "--fill", "squeeze", "--range", "0,90000"]);
    assert!(!room.contains('≥'));
}

#[test]
fn an_interrupted_movie_leaves_nothing() {
    let directory = push();
    let at = directory.path();
    let names = || {
        let mut names: Vec<_> = fs::read_dir(at).unwrap().map(|entry| entry.unwrap().file_name()).collect();
        names.sort();
        names
    };
    let temporary = TempDir::new().unwrap();
    let before = names();
    let long = ["--speed-up", "0.001", "-o", "a.gif", "--forces"];
    let mut running = command(at, &[&["movie", "trajectories.csv", "--trial", "push"], &long[..]].concat())
        .env("TMPDIR", temporary.path())
        .spawn()
        .unwrap();
    // The movie is begun when its hidden file is there.
    while names() == before && running.try_wait().unwrap().is_none() {
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    let signal = std::process::Command::new("kill").args(["-TERM", &running.id().to_string()]).status();
    assert!(signal.unwrap().success());
    assert_eq!(running.wait().unwrap().code(), Some(130));
    assert_eq!(names(), before);
    assert_eq!(fs::read_dir(temporary.path()).unwrap().count(), 0);
}
