//! `lemons sweep` of people who walk: its points are the runs of `lemons run TRIAL`.

use crate::common::{assert_code, command, done, err, lemons, out};
use crate::walking::{copy, door};
use std::collections::HashMap;
use std::fs;
use std::path::Path;
use std::process::Stdio;
use std::time::Duration;

type Row = HashMap<String, String>;

fn read_csv(path: &Path) -> Vec<Row> {
    let mut reader = csv::Reader::from_path(path).unwrap();
    reader.deserialize().map(|row| row.unwrap()).collect()
}

fn number(row: &Row, name: &str) -> f64 {
    row[name].parse().unwrap_or_else(|_| panic!("{name}: {row:?}"))
}

/// Somebody arrives soon: all others may still walk.
const NEAR: &str = "waypoints = [{ x = 5.1, y = 2.5, radius = 0.4 }, { x = 6.0, y = 2.5 }]\n";

/// Trials `T_1` and `T_2`, whose people walk to the door and, of the second, more slowly.
fn two(at: &Path) {
    for (name, speed) in [("T_1", 1.5), ("T_2", 0.9)] {
        copy(&at.join("T"), &at.join(name));
        fs::write(at.join(name).join("decision.toml"), format!("desired_speed = {speed}\n{NEAR}")).unwrap();
    }
}

const MEASURES: &str = r#"
[measures]
first = { of = "decision.Arrived", take = "first_at_least", level = 1 }
never = { of = "decision.Arrived", take = "first_at_least", level = 31 }
arrived = { of = "decision.Arrived", take = "last" }
x = { of = "x", take = "last", across = "max" }
speed = { of = "speed", take = "max" }
push = { of = "decision.agent[*].Fp.x", take = "max", agents = ["3"] }
"#;

fn sweep_of(at: &Path, head: &str, parameters: &str) {
    fs::write(at.join("sweep.toml"), format!("{head}\n[parameters]\n{parameters}\n{MEASURES}")).unwrap();
}

#[test]
fn a_point_is_what_a_run_of_its_trial_is() {
    let directory = door();
    let at = directory.path();
    two(at);
    let head = "trial = \"T_{case}\"\nuntil = 9\nalgorithm = \"gauss-seidel\"\n\
                stop = { of = \"decision.Arrived\", at_least = 2 }";
    let parameters = "case = [1, 2]\n\"crowd.TimeStepMechanical\" = [1e-4]\nMostMechanicalSteps = [1e6]\n\
                      \"decision.agent[3].DesiredSpeed\" = [0.5, 1.8]";
    sweep_of(at, head, parameters);
    done(at, &["sweep", "sweep.toml", "--csv", "table.csv"]);
    let rows = read_csv(&at.join("table.csv"));
    assert_eq!(rows.len(), 4);
    for row in &rows {
        let trial = format!("T_{}", row["case"]);
        let speed = &row["decision.agent[3].DesiredSpeed"];
        let speed = format!("decision.agent[3].DesiredSpeed={speed}");
        let run = ["run", &trial, "--algorithm", "gauss-seidel", "--until", "4", "--set", &speed];
        let run = [&run[..], &["--set", "TimeStepMechanical=1e-4", "--force"]].concat();
        done(at, &run);
        // Of the first communication point at which two have arrived.
        let outputs = read_csv(&at.join("outputs.csv"));
        let arrived = |least: f64| outputs.iter().find(|row| number(row, "decision.Arrived") >= least);
        let end = arrived(2.0).expect("two arrive within 4 s");
        let until = number(end, "t");
        let poses = read_csv(&at.join("trajectories.csv"));
        let poses: Vec<&Row> = poses.iter().filter(|row| number(row, "t") <= until).collect();
        let last = poses.iter().filter(|row| number(row, "t") == until).map(|row| number(row, "x"));
        let speed = |row: &&Row| (number(row, "vx").powi(2) + number(row, "vy").powi(2)).sqrt();
        let outputs = || outputs.iter().filter(|row| number(row, "t") <= until);
        let push = outputs().map(|row| number(row, "decision.agent[3].Fp.x"));
        for (name, expected) in [
            ("first", number(arrived(1.0).unwrap(), "t")),
            ("arrived", number(end, "decision.Arrived")),
            ("x", last.fold(f64::NEG_INFINITY, f64::max)),
            ("speed", poses.iter().map(speed).fold(0.0, f64::max)),
            ("push", push.fold(f64::NEG_INFINITY, f64::max)),
        ] {
            assert_eq!(number(row, name), expected, "{row:?}: {name}");
        }
        assert_eq!((row["never"].as_str(), row["status"].as_str()), ("", "ok"));
    }
    let of = |name: &str| rows.iter().map(|row| number(row, name)).collect::<Vec<_>>();
    let (first, push) = (of("first"), of("push"));
    assert!(first[0] < first[2] && push[0] != push[1], "{first:?} {push:?}");
}

#[test]
fn a_killed_sweep_of_several_trials_goes_on_to_the_same_table() {
    let directory = door();
    let at = directory.path();
    two(at);
    let axis = "case = [1, 2]\n\"decision.agent[3].DesiredSpeed\" = { from = 0.5, to = 2, count = 100 }";
    sweep_of(at, "trial = \"T_{case}\"\nuntil = 2", axis);
    done(at, &["sweep", "sweep.toml", "-o", "whole", "--threads", "2"]);
    let mut running = command(at, &["sweep", "sweep.toml", "-o", "killed", "--threads", "1"]);
    let mut running = running.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    let part = at.join("killed/part-000001.parquet");
    while !part.exists() && running.try_wait().unwrap().is_none() {
        std::thread::sleep(Duration::from_millis(5));
    }
    running.kill().unwrap();
    running.wait().unwrap();
    assert!(part.exists() && !at.join("killed/table.parquet").exists(), "it was killed in the middle");
    let again = ["sweep", "sweep.toml", "-o", "killed"];
    // A plan, a Trial and the condition that ends a point belong to the sweep.
    let changed = |file: &str, text: &str, key: &str| {
        let before = fs::read_to_string(at.join(file)).unwrap();
        fs::write(at.join(file), text.replace("BEFORE", &before)).unwrap();
        let output = lemons(at, &again);
        assert_code(&output, 1);
        let said = format!("its sweep.json differs in {key};");
        assert!(err(&output).contains(&said), "{}", err(&output));
        fs::write(at.join(file), before).unwrap();
    };
    changed("T_2/decision.toml", &format!("desired_speed = 0.8\n{NEAR}"), "models");
    changed(
        "T_1/Parameters.xml",
        &fs::read_to_string(at.join("T_1/Parameters.xml")).unwrap().replace("0.05", "0.1"),
        "models",
    );
    changed("sweep.toml", "stop = { of = \"x\", at_least = 9 }\nBEFORE", "stop");
    let said = out(&done(at, &again));
    assert!(!said.contains("(200 now, 0 before)") && !said.contains("(0 now"), "{said}");
    let table = |name: &str| fs::read(at.join(name).join("table.parquet")).unwrap();
    assert!(table("whole") == table("killed"));
}

#[test]
fn plans_are_chosen_and_belong_to_the_sweep() {
    let directory = door();
    let at = directory.path();
    fs::write(at.join("T/drive.csv"), "t,agent,Fp.x,Fp.y,Mp\n0,2,100,0,0\n1,2,100,0,0\n").unwrap();
    fs::write(at.join("back_1.toml"), "waypoints = [{ x = -9, y = 2 }]").unwrap();
    let measures = "[measures]\nx = { of = \"x\", take = \"last\", agents = [\"2\"] }\n";
    let swept = |head: &str, parameters: &str, to: &str| {
        let text = format!("trial = \"T\"\nuntil = 0.5\n{head}\n[parameters]\n{parameters}\n{measures}");
        fs::write(at.join("sweep.toml"), text).unwrap();
        lemons(at, &["sweep", "sweep.toml", "-o", to, "--csv", "x.csv", "--force"])
    };
    let x = |head: &str, parameters: &str, to: &str| {
        let output = swept(head, parameters, to);
        assert_code(&output, 0);
        (number(&read_csv(&at.join("x.csv"))[0], "x"), err(&output))
    };
    let of_run = |options: &[&str]| {
        done(at, &[&["run", "T", "--until", "0.5", "-o", "run.csv", "--force"], options].concat());
        let rows = read_csv(&at.join("run.csv"));
        number(rows.iter().rfind(|row| row["id"] == "2").unwrap(), "x")
    };
    let mass = "\"agent[2].Mass\" = [70]";
    let set = ["--set", "agent[2].Mass=70"];
    let (own, noted) = x("", mass, "own");
    assert!(noted.contains("note: T: drive.csv is not used, because T/decision.toml says"), "{noted}");
    assert_eq!(own, of_run(&set));
    let (back, _) = x("plan = \"back_{way}.toml\"", &format!("way = [1]\n{mass}"), "back");
    assert_eq!(back, of_run(&[&set[..], &["--plan", "back_1.toml"]].concat()));
    let (still, noted) = x("plan = false", mass, "still");
    assert_eq!((still, noted.as_str()), (of_run(&[&set[..], &["--no-plan"]].concat()), ""));
    assert!(back < still && still < own, "{back} {still} {own}");
    for (head, parameters, to, said) in [
        ("plan = false", mass, "own", "differs in drive, algorithm, plan"),
        ("plan = \"back_1.toml\"", mass, "own", "differs in plan"),
        ("algorithm = \"gauss-seidel\"", mass, "own", "differs in algorithm"),
        ("drive = \"T/drive.csv\"", mass, "new", "drive: people who walk (T/decision.toml) are not driven"),
        ("plan = \"nothing.toml\"", mass, "new", "nothing.toml: cannot be read"),
        ("", "\"agent[2].DesiredSpeed\" = [1]", "new", "did you mean \"decision.agent[2].DesiredSpeed\"?"),
        (
            "",
            "\"agent[2].Mass\" = [70]\n\"crowd.agent[2].Mass\" = [80]",
            "new",
            "another parameter sets the same",
        ),
        ("stop = { of = \"Arrived\", at_least = 1 }", mass, "new", "did you mean \"decision.Arrived\"?"),
    ] {
        let output = swept(head, parameters, to);
        assert_code(&output, 1);
        assert!(err(&output).contains(said), "{head}: {}", err(&output));
    }
    // What a connection feeds cannot be set, and a Trial that is missing is named.
    let output = swept("", "\"agent[2].Fp.x\" = [5]", "fed");
    assert_code(&output, 1);
    assert!(
        out(&output).contains("overwritten by the connection that feeds agent[2].Fp.x"),
        "{}",
        out(&output)
    );
    let text = fs::read_to_string(at.join("sweep.toml")).unwrap();
    fs::write(
        at.join("sweep.toml"),
        text.replace("\"T\"", "\"T{case}\"").replace("[parameters]", "[parameters]\ncase = [\"\", \"_9\"]"),
    )
    .unwrap();
    let output = lemons(at, &["sweep", "sweep.toml", "-o", "new"]);
    assert_code(&output, 1);
    assert!(err(&output).contains("T_9: "), "{}", err(&output));
    fs::remove_file(at.join("T/decision.toml")).unwrap();
    let output = swept("plan = true", mass, "new");
    assert!(err(&output).contains("plan = true: T has no decision.toml"), "{}", err(&output));
}
