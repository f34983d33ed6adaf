//! `lemons sweep` of people who walk: its points are the runs of `lemons run TRIAL`.

use crate::common::{NamedCells, assert_code, copy_tree, done, err, lemons, number, read_csv, root};
use std::fs;
use std::path::Path;
use tempfile::TempDir;

/// Of the shipped Trial with a door, in two copies: the people of the second walk more slowly.
const DOOR: &str = r#"
trial = "T_{case}"
until = 9
algorithm = "gauss-seidel"
stop = { of = "decision.Arrived", at_least = 2 }

[parameters]
case = [1, 2]
"crowd.TimeStepMechanical" = [1e-4]
MostMechanicalSteps = [1e6]
"decision.agent[3].DesiredSpeed" = [0.5, 1.8]

[measures]
first = { of = "decision.Arrived", take = "first_at_least", level = 1 }
never = { of = "decision.Arrived", take = "first_at_least", level = 31 }
arrived = { of = "decision.Arrived", take = "last" }
x = { of = "x", take = "last", across = "max" }
speed = { of = "speed", take = "max" }
push = { of = "decision.agent[*].Fp.x", take = "max", agents = ["3"] }
"#;

/// Returns the message about a file that is refused.
fn refused(at: &Path, arguments: &[&str]) -> String {
    let output = lemons(at, arguments);
    assert_code(&output, 1);
    err(&output)
}

/// The crowds are those of `lemons crowd`, to the last bit, and their people walk at the speeds of their kinds.
#[test]
fn a_population_is_drawn_and_placed_as_the_command_does_it() {
    let directory = TempDir::new().unwrap();
    let at = directory.path();
    let text = r#"
until = 4
[population]
number = 16
box = [6, 5]
doors = [[6, 2.5, 1.5], [0, 2.5, 1.2, 1, 60]]
start = { min = 0, max = 1.5 }
groups = 0.5
mix = { adult = "rest", child = 20, suitcase = 10 }
[parameters]
"population.mix.wheelchair" = [0, 20]
"population.seed" = [3, 4]
[measures]
x = { of = "x", take = "last", agents = ["5"] }
y = { of = "y", take = "max", across = "mean" }
squeeze = { of = "peak_squeeze", take = "max" }
"#;
    fs::write(at.join("sweep.toml"), text).unwrap();
    done(at, &["sweep", "sweep.toml", "-o", "table.csv"]);
    let rows = read_csv(&at.join("table.csv"));
    assert_eq!(rows.len(), 4);
    for (k, row) in rows.iter().enumerate() {
        let (chairs, seed) = (number(row, "population.mix.wheelchair"), &row["population.seed"]);
        let (trial, mix) =
            (format!("T_{k}"), format!("adult={},child=20,suitcase=10,wheelchair={chairs}", 70.0 - chairs));
        let crowd = [
            "crowd",
            "--number",
            "16",
            "--box",
            "6x5",
            "--door",
            "6,2.5,1.5",
            "--door",
            "0,2.5,1.2,1,60",
            "--leave",
            "--start",
            "0,1.5",
            "--groups",
            "0.5",
        ];
        done(at, &[&crowd[..], &["--mix", &mix, "--seed", seed, "-o", &trial]].concat());
        let sweep = format!(
            "trial = \"{trial}\"\ndecision = true\nuntil = 4\n[parameters]\nMostMechanicalSteps = [1e6]\n{}",
            &text[text.find("[measures]").unwrap()..]
        );
        fs::write(at.join("one.toml"), sweep).unwrap();
        done(at, &["sweep", "one.toml", "-o", &format!("one_{k}.csv")]);
        let one = read_csv(&at.join(format!("one_{k}.csv"))).remove(0);
        for measure in ["x", "y", "squeeze"] {
            assert_eq!(one[measure], row[measure], "{measure} of {mix}, seed {seed}");
        }
    }
    assert!(rows[0]["x"] != rows[1]["x"] && rows[0]["x"] != rows[2]["x"]);
    // It goes on, and does nothing again; another population is another sweep.
    done(at, &["sweep", "sweep.toml", "-o", "table.csv"]);
    let other = text.replace("child = 20", "child = 21");
    fs::write(at.join("sweep.toml"), &other).unwrap();
    assert!(refused(at, &["sweep", "sweep.toml", "-o", "table.csv"]).contains("table.csv"));
    for (part, to, message) in [
        (
            "child = 20",
            "adlt = 20",
            "sweep.toml: population: `mix`: there is no kind \"adlt\" (did you mean \"adult\"?)",
        ),
        (
            "child = 20",
            "child = 95",
            "population: `mix`: the others have 105 together: nothing of 100 is left for the \"rest\"",
        ),
        ("box = [6, 5]", "box = [6, 5, 3]", "must be two numbers, not 3"),
        ("groups = 0.5", "groups = 1.5", "population: `groups` = 1.5: must be from 0 to 1"),
        ("min = 0", "min = 2", "population: everybody: start: min = 2, max = 1.5: min must be below max"),
        (", 1, 60]", ", 60, 1]", "[0.0, 2.5, 1.2, 60.0, 1.0]: must be x, y and a width"),
        (
            "doors = [[6, 2.5, 1.5], [0, 2.5, 1.2, 1, 60]]",
            "",
            "population: `groups`: nobody walks without `leave`",
        ),
        ("number = 16", "number = 0", "population: `number` = 0: must be from 1"),
        (
            "number = 16",
            "number = 600",
            "population: a box of 6 m x 5 m, `packing` dense: 600 people do not fit on 30.00 m² without overlap; about ",
        ),
        (
            "mix.wheelchair\" = [0, 20]",
            "men\" = [0, 20]",
            "parameters: population.men = 20, population.seed = 3: `men` = 20: must be from 0 to 1",
        ),
        (
            "mix.wheelchair\" = [0, 20]",
            "mix.car\" = [0, 20]",
            "parameters: population.mix.car = 0, population.seed = 3: `mix`: there is no kind \"car\"",
        ),
        (
            "mix.wheelchair\" = [0, 20]",
            "wheels\" = [0, 20]",
            "parameters: population.wheels: unknown field `wheels`",
        ),
        ("until = 4", "until = 4\ndecision = false", "decision: is not for a [population]"),
        (
            "until = 4",
            "until = 4\ntrial = \"T_0\"",
            "give one of the keys trial, fmu and scenario, or [population]",
        ),
    ] {
        assert!(text.contains(part), "{part}");
        fs::write(at.join("sweep.toml"), text.replace(part, to)).unwrap();
        let refusal = refused(at, &["sweep", "sweep.toml", "-o", "new.csv"]);
        assert!(refusal.contains(message) && !at.join("new.csv").exists(), "{to}: {refusal}");
    }
}

#[test]
fn a_point_is_what_a_run_of_its_trial_is() {
    let directory = TempDir::new().unwrap();
    let at = directory.path();
    for (name, speed) in [("T_1", 1.5), ("T_2", 0.9)] {
        copy_tree(&root().join("resources/Trial_door"), &at.join(name));
        // Somebody arrives soon: all others may still walk.
        let way = "waypoints = [{ x = 5.1, y = 2.5, radius = 0.4 }, { x = 6.0, y = 2.5 }]";
        fs::write(at.join(name).join("decision.toml"), format!("desired_speed = {speed}\n{way}\n")).unwrap();
    }
    fs::write(at.join("sweep.toml"), DOOR).unwrap();
    done(at, &["sweep", "sweep.toml", "-o", "table.csv"]);
    let rows = read_csv(&at.join("table.csv"));
    assert_eq!(rows.len(), 4);
    for row in &rows {
        let trial = format!("T_{}", row["case"]);
        let speed = &row["decision.agent[3].DesiredSpeed"];
        let speed = format!("decision.agent[3].DesiredSpeed={speed}");
        let run = ["run", &trial, "--algorithm", "gauss-seidel", "--until", "4", "--set", &speed];
        let run = [&run[..], &["--set", "TimeStepMechanical=1e-4", "--outputs", "outputs.csv"]].concat();
        done(at, &run);
        // Of the first communication point at which two have arrived.
        let outputs = read_csv(&at.join("outputs.csv"));
        let arrived = |least: f64| outputs.iter().find(|row| number(row, "decision.Arrived") >= least);
        let end = arrived(2.0).expect("two arrive within 4 s");
        let until = number(end, "t");
        let poses = read_csv(&at.join("trajectories.csv"));
        let poses: Vec<&NamedCells> = poses.iter().filter(|row| number(row, "t") <= until).collect();
        let last = poses.iter().filter(|row| number(row, "t") == until).map(|row| number(row, "x"));
        let speed = |row: &&NamedCells| (number(row, "vx").powi(2) + number(row, "vy").powi(2)).sqrt();
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

/// Sixteen people leave a room of 4 m x 3 m by a door of 1 m, in two crowds.
const ROOM: &str = r#"
trial = "room_{seed}"
until = "left"

[parameters]
seed = [1, 2]

[lines]
door = [4, 1, 4, 2]

[areas]
front = [2.5, 0.5, 4, 2.5]
corner = [2, 1, 4, 1, 4, 2]

[measures]
people = { line = "door", direction = "right", number = "people" }
back = { line = "door", direction = "left", number = "crossings" }
flow = { line = "door", direction = "right", number = "flow" }
specific = { line = "door", direction = "right", number = "specific_flow" }
by_seed = { line = "door", direction = "right", number = "specific_flow", width = "seed" }
gap = { line = "door", direction = "right", number = "gap_90" }
out = { line = "door", direction = "right", number = "evacuation_time" }
late = { line = "door", direction = "right", number = "people", from = 4.0 }
dense = { area = "front", number = "voronoi_density", take = "mean" }
densest = { area = "corner", number = "density", take = "max" }
speed = { area = "front", number = "speed", take = "mean" }
early = { area = "front", number = "people", take = "max", until = 2.0 }
part = { area = "front", number = "voronoi_density", take = "mean", from = 1.0, until = 2.0 }
felt = { squeeze = "largest_mean", over = 1, across = "max" }
often = { squeeze = "time_above", level = 100, across = "quantile_90" }
long = { squeeze = "time_above", level = 50, over = 0.5, across = "max" }
middle = { squeeze = "impulse", across = "median" }
wall = { squeeze = "largest_mean", over = 1, by = "walls", across = "max" }
others = { squeeze = "impulse", by = "people", across = "max" }
peak = { squeeze = "peak", across = "max" }
"#;

/// Returns the measures by `lemons measure` of the same Trial, which is run again.
fn measured(at: &Path, trial: &str, more: &[&str]) -> serde_json::Value {
    let above = if more.contains(&"--above") { &[][..] } else { &["--above", "100"] };
    measured_at(at, trial, &[&["--until", "left"], above, more].concat())
}

fn measured_at(at: &Path, what: &str, more: &[&str]) -> serde_json::Value {
    let all = [
        &["measure", what, "--line", "door=4,1,4,2", "--area", "front=2.5,0.5,4,2.5"],
        &["--area", "corner=2,1,4,1,4,2", "--summary", "seen.json", "--force"][..],
        more,
    ];
    done(at, &all.concat());
    serde_json::from_str(&fs::read_to_string(at.join("seen.json")).unwrap()).unwrap()
}

#[test]
fn measures_of_a_sweep_are_those_of_lemons_measure() {
    let directory = TempDir::new().unwrap();
    let at = directory.path();
    for seed in ["1", "2"] {
        let name = format!("room_{seed}");
        let make =
            ["crowd", "--number", "16", "--box", "4x3", "--door", "4,1.5,1", "--leave", "--seed", seed];
        done(at, &[&make[..], &["-o", &name]].concat());
    }
    fs::write(at.join("sweep.toml"), ROOM).unwrap();
    done(at, &["sweep", "sweep.toml", "-o", "table.csv"]);
    let rows = read_csv(&at.join("table.csv"));
    assert_eq!(rows.len(), 2);
    for row in &rows {
        let trial = format!("room_{}", row["seed"]);
        let seen = measured(at, &trial, &[]);
        let (right, left) = (&seen["lines"][0]["directions"][0], &seen["lines"][0]["directions"][1]);
        let (front, corner, squeeze) = (&seen["areas"][0], &seen["areas"][1], &seen["exposure"]);
        for (name, expected) in [
            ("people", &right["people"]),
            ("back", &left["crossings"]),
            ("flow", &right["flow"]),
            ("specific", &right["specific_flow"]),
            ("gap", &right["gap_90"]),
            ("out", &right["evacuation_time"]),
            ("dense", &front["voronoi_density"]["mean"]),
            ("densest", &corner["density"]["max"]),
            ("speed", &front["speed"]["mean"]),
            ("felt", &squeeze["largest_mean"][1]["mean"]["max"]),
            ("often", &squeeze["time_above"][0]["time"]["quantile_90"]),
            ("middle", &squeeze["impulse"]["median"]),
            ("wall", &squeeze["by_walls"]["largest_mean"][1]["mean"]["max"]),
            ("others", &squeeze["by_people"]["impulse"]["max"]),
            ("peak", &squeeze["peak"]["max"]),
            ("ended", &seen["left"]["evacuation_time"]),
        ] {
            assert_eq!(number(row, name), expected.as_f64().unwrap(), "{trial}: {name}");
        }
        assert_eq!(number(row, "people"), 16.0);
        assert_eq!(number(row, "by_seed"), number(row, "flow") / number(row, "seed"));
        let over = measured(at, &trial, &["--over", "0.5", "--above", "50"]);
        assert_eq!(number(row, "long"), over["exposure"]["time_above"][0]["time"]["max"].as_f64().unwrap());
        let late = measured(at, &trial, &["--from", "4"]);
        assert_eq!(number(row, "late"), late["lines"][0]["directions"][0]["people"].as_f64().unwrap());
        assert!(number(row, "late") < 16.0 && number(row, "peak") > number(row, "felt"));
        assert!(number(row, "wall") > 0.0 && number(row, "others") > 0.0);
        // Of the table of the run: where people could be is what all of it says.
        done(at, &["run", &trial, "--until", "left", "-o", "run.csv", "--force"]);
        let part = measured_at(at, "run.csv", &["--trial", &trial, "--from", "1", "--until", "2"]);
        assert_eq!(number(row, "part"), part["areas"][0]["voronoi_density"]["mean"].as_f64().unwrap());
        assert!(number(row, "early") >= 1.0 && number(row, "dense") > 0.0 && number(row, "middle") > 0.0);
    }
    fs::write(at.join("hall.wkt"), "POLYGON ((-5 -5, 20 -5, 20 20, -5 20, -5 -5))").unwrap();
    fs::write(at.join("sweep.toml"), ROOM.replace("[parameters]", "walkable = \"hall.wkt\"\n[parameters]"))
        .unwrap();
    done(at, &["sweep", "sweep.toml", "-o", "hall.csv"]);
    let seen = measured(at, "room_1", &["--walkable", "hall.wkt"]);
    let dense = number(&read_csv(&at.join("hall.csv"))[0], "dense");
    assert_eq!(dense, seen["areas"][0]["voronoi_density"]["mean"].as_f64().unwrap());
    assert!(dense < number(&rows[0], "dense"), "walls hold the cells back");
}
