//! Random cases, compared with the independent reference integrator (tests/fmpy/reference.py: scipy, eighth order, from
//! event to event, its own formulas). Its solutions are committed, and a test computes them again.

use crate::error::{Result, ensure};
use crate::{Check, largest};
use crowd_mechanics::engine::Wrench;
use crowd_mechanics::setup::{self, Setup};
use lemons_plane::vec2;
use serde::Deserialize;
use std::collections::BTreeMap;

static CASES: &str = include_str!("../../../tests/reference/cases.json");

pub(crate) const CHECKS: &[Check] = &[
    Check::new(
        "random cases of 1 to 6 agents, dt = 1e-6 s: poses",
        "independent integrator",
        "m, rad",
        5e-7,
        || Ok(worst(1e-6)?.0),
    ),
    Check::new("the same: velocities", "independent integrator", "SI", 1e-5, || Ok(worst(1e-6)?.1)),
    Check::new(
        "the same: 1/fall of the median from dt = 1.6e-5 s",
        "1/256: second order",
        "",
        1.0 / 64.0,
        fall,
    ),
    Check::new(
        "20 random cases of 4 to 6 agents, default materials, dt = 1e-5 s: median of poses",
        "independent integrator",
        "m, rad",
        5e-6,
        || median(USUAL, 1e-5),
    ),
    Check::new("the same: order short of 2 from dt = 1e-4 s", "2: second order", "", 0.35, || {
        Ok((2.0 - (median(USUAL, 1e-4)? / median(USUAL, 1e-5)?).log10()).max(0.0))
    }),
];

/// With the materials of the default Trial.
static USUAL: &str = include_str!("../../../tests/reference/usual.json");

/// A case of these files; its format is described in reference.py.
#[derive(Deserialize)]
struct Case {
    name: String,
    files: BTreeMap<String, String>,
    times: Vec<f64>,
    drive: Vec<Vec<[f64; 3]>>,
    states: Vec<Vec<[f64; 6]>>,
}

/// Returns the largest differences of poses \[m, rad\] and velocities \[m/s, rad/s\] in a case.
fn differences(case: &Case, mechanical_step: f64) -> Result<(f64, f64)> {
    let directory = tempfile::tempdir()?;
    for (name, text) in &case.files {
        let path = directory.path().join(name);
        std::fs::create_dir_all(path.parent().unwrap_or(directory.path()))?;
        std::fs::write(path, text)?;
    }
    let (trial, _) = setup::read(directory.path())?;
    let mut world = Setup::of(&trial).world()?;
    world.mechanical_step = mechanical_step;
    let (mut time, mut worst) = (0.0, (0.0, 0.0));
    for ((&end, drive), states) in case.times.iter().zip(&case.drive).zip(&case.states) {
        world.drive = drive.iter().map(|[x, y, m]| Wrench { force: vec2(*x, *y), torque: *m }).collect();
        world.advance(end - time)?;
        time = end;
        let motions = world.state().poses.iter().zip(&world.state().twists);
        for ((pose, twist), [x, y, theta, vx, vy, omega]) in motions.zip(states) {
            let place = (pose.position - vec2(*x, *y)).norm();
            let velocity = (twist.velocity - vec2(*vx, *vy)).norm();
            worst.0 = largest([worst.0, place, (pose.orientation - theta).abs()]);
            worst.1 = largest([worst.1, velocity, (twist.angular_velocity - omega).abs()]);
        }
    }
    Ok(worst)
}

/// Returns names and largest differences of all cases.
///
/// # Errors
/// A case cannot be run.
pub fn all(mechanical_step: f64) -> Result<Vec<(String, f64, f64)>> {
    let cases = of(CASES, mechanical_step)?;
    ensure!(cases.len() >= 12, "there are at least 12 cases: {}", cases.len());
    Ok(cases)
}

/// Returns names and largest differences of the cases in a text that `reference.py` wrote.
///
/// # Errors
/// A case cannot be run.
pub fn of(text: &str, mechanical_step: f64) -> Result<Vec<(String, f64, f64)>> {
    let cases: Vec<Case> = serde_json::from_str(text)?;
    cases
        .iter()
        .map(|case| differences(case, mechanical_step).map(|(pose, twist)| (case.name.clone(), pose, twist)))
        .collect()
}

fn worst(mechanical_step: f64) -> Result<(f64, f64)> {
    let all = all(mechanical_step)?;
    Ok((largest(all.iter().map(|case| case.1)), largest(all.iter().map(|case| case.2))))
}

fn median(cases: &str, mechanical_step: f64) -> Result<f64> {
    let mut poses: Vec<f64> = of(cases, mechanical_step)?.into_iter().map(|case| case.1).collect();
    poses.sort_by(f64::total_cmp);
    Ok(poses[poses.len() / 2])
}

/// A single case is noisy: the times within a step at which contacts begin change with every step.
fn fall() -> Result<f64> {
    Ok(median(CASES, 1e-6)? / median(CASES, 1.6e-5)?)
}
