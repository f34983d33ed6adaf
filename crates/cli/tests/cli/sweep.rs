//! `lemons sweep`: what it finds is what single runs find, and nothing is lost.

use crate::common::{assert_code, command, default_trial, done, err, lemons, out};
use crate::walked_sweep::read_csv;
use std::fs;
use std::path::Path;
use std::process::Stdio;
use std::time::Duration;
use tempfile::TempDir;

const PARAMETERS: &str = r#"
"contact.human_naked.human_naked.KineticFriction" = [0, 0.4]
"agent[*].Mass" = { from = 60, to = 90, count = 2 }
"#;

const MEASURES: &str = r#"
moved = { of = "x", take = "change", agents = ["4"] }
squeeze = { of = "squeeze", take = "max" }
mean_squeeze = { of = "mean_squeeze", take = "max" }
peak_squeeze = { of = "peak_squeeze", take = "max" }
overlap = { of = "peak_overlap", take = "max" }
contacts = { of = "agent_contacts", take = "max" }
fast = { of = "speed", take = "first_above", level = 0.5, agents = ["0"] }
never = { of = "speed", take = "first_above", level = 100, agents = ["0"] }
"#;

fn write_spec(at: &Path, until: f64, parameters: &str) {
    let trial = default_trial();
    let trial = trial.canonicalize().unwrap();
    let text = format!(
        "trial = {:?}\nuntil = {until}\n[parameters]\n{parameters}\n[measures]\n{MEASURES}",
        trial.to_str().unwrap()
    );
    fs::write(at.join("push.toml"), text).unwrap();
}

#[test]
fn a_point_is_what_a_run_with_its_parameters_is() {
    let directory = TempDir::new().unwrap();
    let at = directory.path();
    write_spec(at, 0.9, PARAMETERS);
    let said = out(&done(at, &["sweep", "push.toml"]));
    assert!(said.contains("points                      4     (4 now, 0 before)"), "{said}");
    assert!(said.lines().all(|line| line.chars().count() <= 80), "{said}");
    let table = fs::read_to_string(at.join("push.csv")).unwrap();
    let by = format!("\"program\":\"{}", env!("CARGO_PKG_VERSION"));
    assert!(table.lines().next().unwrap().contains(&by), "{table}");
    let rows = read_csv(&at.join("push.csv"));
    assert_eq!(rows.len(), 4);
    for (k, row) in rows.iter().enumerate() {
        assert_eq!((row["point"].as_str(), row["status"].as_str()), (k.to_string().as_str(), "ok"));
        let friction = &row["contact.human_naked.human_naked.KineticFriction"];
        let mass = &row["agent[*].Mass"];
        let mut settings = vec![format!("contact.human_naked.human_naked.KineticFriction={friction}")];
        settings.extend((0..5).map(|i| format!("agent[{i}].Mass={mass}")));
        let trial = default_trial();
        let mut words = vec!["run", trial.to_str().unwrap(), "--until", "0.9"];
        settings.iter().for_each(|setting| words.extend(["--set", setting.as_str()]));
        done(at, &words);
        let table = read_csv(&at.join("trajectories.csv"));
        let of = |id: &str, name: &str| -> Vec<f64> {
            let own = table.iter().filter(|row| row["id"] == id);
            own.map(|row| row[name].parse().unwrap()).collect()
        };
        let x = of("4", "x");
        let (vx, vy, t) = (of("0", "vx"), of("0", "vy"), of("0", "t"));
        let fast = (0..t.len()).find(|&k| (vx[k] * vx[k] + vy[k] * vy[k]).sqrt() > 0.5).unwrap();
        let most = |name: &str| table.iter().map(|row| row[name].parse::<f64>().unwrap()).fold(0.0, f64::max);
        for (name, expected) in [
            ("moved", x[x.len() - 1] - x[0]),
            ("squeeze", most("normal_force")),
            ("mean_squeeze", most("mean_normal_force")),
            ("peak_squeeze", most("peak_normal_force")),
            ("overlap", most("peak_overlap")),
            ("contacts", most("agent_contacts")),
            ("fast", t[fast]),
        ] {
            assert_eq!(row[name].parse::<f64>().unwrap(), expected, "point {k}: {name}");
        }
        assert_eq!(row["never"], "");
    }
    let moved: Vec<&String> = rows.iter().map(|row| &row["moved"]).collect();
    assert!(moved.iter().any(|other| *other != moved[0]), "parameters make a difference");
    // What is finished is not simulated again.
    let said = out(&done(at, &["sweep", "push.toml"]));
    assert!(said.contains("(0 now, 4 before)"), "{said}");
}

#[test]
fn a_killed_sweep_goes_on_to_the_same_table() {
    let directory = TempDir::new().unwrap();
    let at = directory.path();
    write_spec(
        at,
        1.0,
        "\"contact.human_naked.human_naked.KineticFriction\" = { from = 0, to = 1, count = 200 }",
    );
    done(at, &["sweep", "push.toml", "-o", "whole.csv", "--threads", "2"]);
    let mut running = command(at, &["sweep", "push.toml", "-o", "killed.csv", "--threads", "1"]);
    let mut running = running.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    // The comment, the names, and some points.
    let lines = || fs::read_to_string(at.join("killed.csv")).map_or(0, |text| text.lines().count());
    while lines() < 3 && running.try_wait().unwrap().is_none() {
        std::thread::sleep(Duration::from_millis(5));
    }
    running.kill().unwrap();
    running.wait().unwrap();
    assert!((3..202).contains(&lines()), "it was killed in the middle");
    let said = out(&done(at, &["sweep", "push.toml", "-o", "killed.csv"]));
    assert!(!said.contains("(200 now, 0 before)") && !said.contains("(0 now"), "{said}");
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
    let mut running = command(at, &["sweep", "push.toml", "--threads", "2"]);
    let mut running = running.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    while !at.join("push.csv").exists() {
        assert!(running.try_wait().unwrap().is_none(), "it ended by itself");
        std::thread::sleep(Duration::from_millis(1));
    }
    std::thread::sleep(Duration::from_secs(1));
    let signal = std::process::Command::new("kill").args(["-TERM", &running.id().to_string()]).status();
    assert!(signal.unwrap().success());
    let output = running.wait_with_output().unwrap();
    assert_code(&output, 130);
    assert!(err(&output).contains("0 of 3 points are finished and kept"), "{}", err(&output));
    assert!(out(&output).contains("not simulated               3"), "{}", out(&output));
    let endless = spec.replace("until = 1500", "until = 1e300");
    fs::write(at.join("push.toml"), endless).unwrap();
    let output = lemons(at, &["sweep", "push.toml", "-o", "endless.csv"]);
    assert_code(&output, 1);
    let said = err(&output);
    assert!(said.contains("until: from 0.0 to 1e300 s there are 2.0000e301 communication steps"), "{said}");
}
