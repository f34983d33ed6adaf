//! Runs of a Trial whose people walk by its `decision.toml`.

use crate::common::{default_trial, done, number, read_csv};
use crowd_mechanics::setup;
use lemons_results::Run;
use std::fs;
use tempfile::TempDir;

/// A walker with eq. 4 alone has the force m v0 γ. With a constant force F beside it, and the floor's friction, the way is
/// (v0 + F / (m γ)) (t − (1 − exp(−γ t)) / γ): of both algorithms, in a run and in a sweep.
#[test]
fn a_drive_is_added_to_how_people_walk() {
    let directory = TempDir::new().unwrap();
    let at = directory.path();
    // One person in the open.
    let (mut trial, _) = setup::read(&default_trial()).unwrap();
    trial.agents.truncate(1);
    trial.dynamics.truncate(1);
    trial.geometry.walls.clear();
    trial.write(&at.join("T")).unwrap();
    fs::write(at.join("T/decision.toml"), "desired_speed = 1.3\nwaypoints = [{ x = 1000, y = 0 }]").unwrap();
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
    let sweep = "trial = \"T\"\nuntil = 2\ndrive = \"push.csv\"\n[parameters]\n\"agent[0].Theta\" = [0.0, 0.0]\n\
                 [measures]\nx = { of = \"x\", take = \"last\", across = \"max\" }\n";
    fs::write(at.join("sweep.toml"), sweep).unwrap();
    done(at, &["sweep", "sweep.toml", "-o", "swept.csv"]);
    let rows = read_csv(&at.join("swept.csv"));
    assert_eq!(rows.len(), 2);
    rows.iter().for_each(|row| near(number(row, "x"), way(120.0)));
}
