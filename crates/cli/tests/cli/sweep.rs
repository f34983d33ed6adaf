//! `lemons sweep`: nothing is lost. That it finds what single runs find is in walked_sweep.rs.

use crate::common::{assert_code, default_trial, done, err, out, signalled, started};
use std::fs;
use std::path::Path;
use std::time::Duration;
use tempfile::TempDir;

fn write_spec(at: &Path, until: f64, parameters: &str) {
    let trial = default_trial();
    let trial = trial.canonicalize().unwrap();
    let text = format!(
        "trial = {:?}\nuntil = {until}\n[parameters]\n{parameters}\n[measures]\nmoved = {{ of = \"x\", take = \"change\", agents = [\"4\"] }}\n",
        trial.to_str().unwrap()
    );
    fs::write(at.join("push.toml"), text).unwrap();
}

#[test]
#[cfg(unix)]
fn a_killed_sweep_goes_on_to_the_same_table() {
    let directory = TempDir::new().unwrap();
    let at = directory.path();
    write_spec(
        at,
        1.0,
        "\"contact.human_naked.human_naked.KineticFriction\" = { from = 0, to = 1, count = 200 }",
    );
    done(at, &["sweep", "push.toml", "-o", "whole.csv", "--threads", "2"]);
    // The comment, the names, and some points.
    let lines = || fs::read_to_string(at.join("killed.csv")).map_or(0, |text| text.lines().count());
    let running = started(at, &["sweep", "push.toml", "-o", "killed.csv", "--threads", "1"]);
    signalled(running, "-KILL", || lines() >= 3);
    assert!((3..202).contains(&lines()), "it was killed in the middle");
    let message = out(&done(at, &["sweep", "push.toml", "-o", "killed.csv"]));
    assert!(!message.contains("(200 now, 0 before)") && !message.contains("(0 now"), "{message}");
    assert!(fs::read(at.join("whole.csv")).unwrap() == fs::read(at.join("killed.csv")).unwrap());
}

#[test]
#[cfg(unix)]
fn a_sweep_of_long_steps_can_be_interrupted() {
    let directory = TempDir::new().unwrap();
    let at = directory.path();
    write_spec(at, 1500.0, "\"agent[2].Mass\" = [60, 70, 80]");
    let spec = fs::read_to_string(at.join("push.toml")).unwrap();
    // All press against a wall: nobody is ever free, which would take no time.
    done(at, &["crowd", "-n", "40", "--box", "4x4", "--speed", "1", "-o", "pressed"]);
    let (trial, _) = spec.split_once('\n').unwrap();
    let pressed = spec.replace(trial, "trial = \"pressed\"").replace("until =", "step = 1500\nuntil =");
    fs::write(at.join("push.toml"), pressed).unwrap();
    let output = signalled(started(at, &["sweep", "push.toml", "--threads", "2"]), "-TERM", || {
        let begun = at.join("push.csv").exists();
        std::thread::sleep(Duration::from_secs(begun.into()));
        begun
    });
    assert_code(&output, 130);
    assert!(err(&output).contains("0 of 3 points are finished and kept"), "{}", err(&output));
    assert!(out(&output).contains("not simulated               3"), "{}", out(&output));
}
