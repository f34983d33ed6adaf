//! `lemons plot` and `lemons movie`: what is in the pictures is what was in the run.

use crate::common::{assert_code, command, default_trial, done, err, names, number, read_csv, signalled};
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
    let mut rows = read_csv(&at.join("trajectories.csv"));
    rows.retain(|row| (number(row, "t") - 0.4).abs() < 1e-9);
    let drawn = places(&text);
    assert_eq!(drawn.len(), 5);
    for (row, place) in rows.iter().zip(drawn) {
        let off = (number(row, "x") - place.0).abs().max((number(row, "y") - place.1).abs());
        assert!(off < 6e-5, "{row:?} {place:?}");
    }
    let greatest = rows.iter().map(|row| number(row, "mean_normal_force")).fold(0.0, f64::max);
    let labels = labels(&text);
    assert!(greatest > 10.0);
    assert!(labels.contains(&"t = 0.40 s") && labels.contains(&"mean squeeze over a step (N)"), "{labels:?}");
    let high = labels[labels.iter().position(|l| *l == "mean squeeze over a step (N)").unwrap() - 1];
    let high: f64 = high.parse().unwrap();
    assert!((high / greatest - 1.0).abs() < 0.01, "{labels:?}, {greatest} N");
}

#[test]
fn an_interrupted_movie_leaves_nothing() {
    let directory = push();
    let at = directory.path();
    let temporary = TempDir::new().unwrap();
    let before = names(at);
    let long = ["--speed-up", "0.001", "-o", "a.gif", "--forces"];
    let mut running = command(at, &[&["movie", "trajectories.csv", "--trial", "push"], &long[..]].concat());
    let running = running.env("TMPDIR", temporary.path()).spawn().unwrap();
    // The movie is begun when its hidden file is there.
    let output = signalled(running, "-TERM", || names(at) != before);
    assert_code(&output, 130);
    assert_eq!(names(at), before);
    assert_eq!(names(temporary.path()), [""; 0]);
}
