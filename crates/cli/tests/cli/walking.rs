//! Runs of a Trial whose people walk by its `decision.toml`.

use crate::common::{copy_tree, decision_library, default_trial, done, err, joined, number, read_csv, root};
use crowd_mechanics::setup;
use lemons_core::trial::Trial;
use lemons_results::Run;
use std::fs;
use std::path::Path;
use tempfile::TempDir;

/// A copy of the shipped Trial, and its two FMUs coupled by hand.
pub fn door() -> TempDir {
    decision_library();
    let directory = TempDir::new().unwrap();
    let at = directory.path();
    copy_tree(&root().join("resources/Trial_door"), &at.join("T"));
    done(at, &["decide", "T", "-o", "decision.fmu"]);
    done(at, &["pack", "T", "-o", "crowd.fmu"]);
    done(at, &["connect", "decision.fmu", "crowd.fmu", "-o", "x.ssp"]);
    directory
}

/// Masses and dampings are in both FMUs: a name set those of one, and walkers reached 5.6 m/s.
#[test]
fn a_name_without_a_component_sets_what_both_have() {
    let directory = door();
    let at = directory.path();
    // Everybody walks on without meeting anybody: the speed is the desired one, whatever mass and damping are.
    fs::write(at.join("T/decision.toml"), "desired_speed = 1.25\nwaypoints = [{ x = 500, y = 2.5 }]\n")
        .unwrap();
    let agents = fs::read_to_string(at.join("T/static/Agents.xml")).unwrap();
    let first = agents.find("</Agent>").unwrap() + "</Agent>".len();
    let one = agents[..first].to_owned() + "\n</Agents>\n";
    copy_tree(&at.join("T"), &at.join("edited/T"));
    let dynamics = fs::read_to_string(at.join("T/dynamic/AgentDynamics.xml")).unwrap();
    let first = dynamics.find("</Agent>").unwrap() + "</Agent>".len();
    let edited = one.replace("Mass=\"78.0\"", "Mass=\"40\"").replace("Damping=\"4.50\"", "Damping=\"1\"");
    for (trial, agents) in [("T", &one), ("edited/T", &edited)] {
        fs::write(at.join(trial).join("static/Agents.xml"), agents).unwrap();
        let dynamics = dynamics[..first].to_owned() + "\n</Agents>\n";
        fs::write(at.join(trial).join("dynamic/AgentDynamics.xml"), dynamics).unwrap();
        fs::write(at.join(trial).join("static/Geometry.xml"), GEOMETRY).unwrap();
    }
    let set = [
        "--set",
        "agent[*].Mass=40",
        "--set",
        "agent[*].FloorDamping=1",
        "--set",
        "agent[0].AngularDamping=1",
    ];
    let until = ["--until", "9"];
    let both = done(at, &[&["run", "T", "-o", "poses.csv"][..], &until, &set].concat());
    assert_eq!(err(&both), "");
    let poses = read_csv(&at.join("poses.csv"));
    let last = poses.last().unwrap();
    let speed = number(last, "vx").hypot(number(last, "vy"));
    assert!((speed - 1.25).abs() < 0.001, "{speed}");
    // As an edited Trial; also in a picture and a sweep.
    done(at, &[&["run", "edited/T", "-o", "edited.csv"][..], &until].concat());
    assert!(fs::read(at.join("poses.csv")).unwrap() == fs::read(at.join("edited.csv")).unwrap());
    let plot = |trial: &str, options: &[&str]| {
        done(at, &[&["plot", trial, "-o", "x.svg", "--force", "--at", "9"][..], options].concat());
        fs::read(at.join("x.svg")).unwrap()
    };
    assert!(plot("T", &set) == plot("edited/T", &[]) && plot("T", &[]) != plot("edited/T", &[]));
    let spec = "trial = \"T\"\nuntil = 9\n[parameters]\n\"agent[*].Mass\" = [40]\n\"agent[*].FloorDamping\" = [1]\n\
                \"agent[0].AngularDamping\" = [1]\n[measures]\nx = { of = \"x\", take = \"last\", across = \"max\" }\n";
    fs::write(at.join("sweep.toml"), spec).unwrap();
    done(at, &["sweep", "sweep.toml", "-o", "table.csv"]);
    assert_eq!(number(&read_csv(&at.join("table.csv"))[0], "x"), number(last, "x"));
    // Who names a component means it, and is told.
    done(at, &["decide", "T", "-o", "decision.fmu", "--force"]);
    done(at, &["pack", "T", "-o", "crowd.fmu", "--force"]);
    done(at, &["connect", "decision.fmu", "crowd.fmu", "-o", "x.ssp", "--force"]);
    for input in ["T", "x.ssp"] {
        let one = ["run", input, "--until", "0.1", "--force", "--set", "crowd.agent[*].Mass=40"];
        let said =
            "warning: agent[0].Mass is 78.0 in decision, but 40.0 in crowd (of 1 person): set it in both\n";
        assert_eq!(err(&done(at, &one)), said);
        assert_eq!(err(&done(at, &[&one[..], &["--set", "decision.agent[*].Mass=40"]].concat())), "");
    }
}

const GEOMETRY: &str = "<Geometry><Dimensions Lx=\"10\" Ly=\"10\"/></Geometry>";

/// One person in the open.
fn alone(at: &Path, plan: &str) -> Trial {
    decision_library();
    let (mut trial, _) = setup::read(&default_trial()).unwrap();
    trial.agents.truncate(1);
    trial.dynamics.truncate(1);
    trial.geometry.walls.clear();
    trial.write(&at.join("T")).unwrap();
    fs::write(at.join("T/decision.toml"), plan).unwrap();
    trial
}

/// A walker with eq. 4 alone has the force m v0 γ. With a constant force F beside it, and the floor's friction, the way is
/// (v0 + F / (m γ)) (t − (1 − exp(−γ t)) / γ): of both algorithms, in a run, in a run that goes on, and in a sweep.
#[test]
fn a_drive_is_added_to_how_people_walk() {
    let directory = TempDir::new().unwrap();
    let at = directory.path();
    let trial = alone(at, "desired_speed = 1.3\nwaypoints = [{ x = 1000, y = 0 }]");
    fs::write(at.join("push.csv"), "t,agent,Fp.x,Fp.y,Mp\n0,0,120,0,0\n9,0,120,0,0\n").unwrap();
    let (mass, rate, until) = (trial.agents[0].mass, trial.agents[0].floor_damping, 2.0);
    let way = |force: f64| (1.3 + force / (mass * rate)) * (until - (1.0 - (-rate * until).exp()) / rate);
    let end = |name: &str| {
        Run::read_table(&at.join(name)).unwrap().frames.last().unwrap().agents[0].pose.position.x
    };
    let near =
        |found: f64, expected: f64| assert!((found / expected - 1.0).abs() < 1e-9, "{found} {expected}");
    assert!(way(120.0) > 1.2 * way(0.0));
    let run = |options: &[&str]| {
        let run = ["run", "T", "--until", "2", "-o", "x.parquet", "--force"];
        done(at, &[&run[..], options].concat());
        end("x.parquet")
    };
    near(run(&[]), way(0.0));
    for algorithm in ["jacobi", "gauss-seidel"] {
        near(run(&["--drive", "push.csv", "--algorithm", algorithm]), way(120.0));
    }
    let options = ["--drive", "push.csv", "--algorithm", "gauss-seidel"];
    for part in [
        ["-o", "whole.csv", "--until", "2", "--state", "b.run"],
        ["-o", "1.csv", "--until", "1", "--state", "a.run"],
        ["-o", "2.csv", "--until", "2", "--resume", "a.run"],
    ] {
        done(at, &[&["run", "T"], &part[..], &options].concat());
    }
    assert!(joined(at, &["1.csv", "2.csv"]) == fs::read(at.join("whole.csv")).unwrap());
    let sweep = "trial = \"T\"\nuntil = 2\ndrive = \"push.csv\"\n[parameters]\n\"agent[0].Theta\" = [0.0, 0.0]\n\
                 [measures]\nx = { of = \"x\", take = \"last\", across = \"max\" }\n";
    fs::write(at.join("sweep.toml"), sweep).unwrap();
    done(at, &["sweep", "sweep.toml", "-o", "swept.csv"]);
    let rows = read_csv(&at.join("swept.csv"));
    assert_eq!(rows.len(), 2);
    rows.iter().for_each(|row| near(number(row, "x"), way(120.0)));
}
