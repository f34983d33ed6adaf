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
fn movies() {
    let directory = push();
    let at = directory.path();
    let small = ["--width", "120", "--frame-rate", "10"];
    let movie = |name: &str, more: &[&str]| {
        done(at, &[&["movie", "trajectories.csv", "--trial", "push", "-o", name], &small[..], more].concat());
        fs::read(at.join(name)).unwrap()
    };
    let frames = |bytes: Vec<u8>| {
        let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().unwrap();
        let control = *reader.info().animation_control().unwrap();
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        (0..control.num_frames).for_each(|_| {
            reader.next_frame(&mut pixels).unwrap();
        });
        control.num_frames
    };
    assert_eq!(frames(movie("a.png", &[])), 11);
    assert_eq!(frames(movie("b.png", &["--speed-up", "0.5", "--from", "0.2", "--until", "0.6"])), 9);
    assert!(movie("c.gif", &["--fill", "speed"]).starts_with(b"GIF89a"));
    // Without ffmpeg it is a GIF, and MP4 says what it needs.
    let without = |arguments: &[&str]| {
        let arguments = [&["movie", "trajectories.csv", "--trial", "push"], &small[..], arguments].concat();
        command(at, &arguments).env("PATH", "").output().unwrap()
    };
    assert_code(&without(&[]), 0);
    assert!(at.join("movie.gif").is_file());
    let refused = without(&["-o", "d.mp4"]);
    assert_code(&refused, 1);
    assert!(err(&refused).contains("MP4 needs the program ffmpeg") && !at.join("d.mp4").exists());
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
