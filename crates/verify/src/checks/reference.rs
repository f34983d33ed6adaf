//! Random cases, compared with the independent reference integrator (tests/fmpy/reference.py: scipy, eighth order, from
//! event to event, its own formulas). Its solutions are committed, and a test computes them again.

use crate::checks::error::{Error, Result, ensure};
use crate::checks::scenes::motions;
use crate::checks::{Check, apart_in_pose, apart_in_twist, largest};
use crowd_mechanics::engine::{World, Wrench};
use crowd_mechanics::setup::{self, Setup};
use lemons_core::plane::{Pose, Twist, vec2};
use lemons_core::trial::Trial;
use serde::Deserialize;
use std::collections::BTreeMap;

static CASES: &str = include_str!("../../../../tests/reference/cases.json");

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
        1.0 / 128.0,
        fall,
    ),
    Check::new(
        "20 random cases of 4 to 6 agents, default materials, dt = 1e-5 s: median of poses",
        "independent integrator",
        "m, rad",
        5e-6,
        || median(USUAL, 1e-5),
    ),
    Check::new("the same: order short of 2 from dt = 1e-4 s", "2: second order", "", 0.3, || {
        Ok((2.0 - (median(USUAL, 1e-4)? / median(USUAL, 1e-5)?).log10()).max(0.0))
    }),
    Check::new(
        "the same at the steps for 1 mm, 0.1 mm, 1 µm: error of nine of ten people / accuracy asked for",
        "independent integrator",
        "",
        1.0,
        as_accurate_as_wished,
    ),
];

/// With the materials of the default Trial.
static USUAL: &str = include_str!("../../../../tests/reference/usual.json");

/// A case of these files; its format is described in reference.py.
#[derive(Deserialize)]
pub struct Case {
    /// What meets.
    pub name: String,
    files: BTreeMap<String, String>,
    /// \[s\] ends of the stages; the first begins at 0.
    pub times: Vec<f64>,
    drive: Vec<Vec<[f64; 3]>>,
    states: Vec<Vec<[f64; 6]>>,
}

impl Case {
    /// Returns the world at its start.
    ///
    /// # Errors
    /// Its files cannot be read.
    pub fn world(&self, mechanical_step: f64) -> Result<World> {
        let mut world = Setup::of(&self.trial()?).world()?;
        world.mechanical_step = mechanical_step;
        Ok(world)
    }

    fn trial(&self) -> Result<Trial> {
        let directory = tempfile::tempdir()?;
        for (name, text) in &self.files {
            let path = directory.path().join(name);
            std::fs::create_dir_all(path.parent().unwrap_or(directory.path()))?;
            std::fs::write(path, text)?;
        }
        Ok(setup::read(directory.path())?.0)
    }

    /// Returns the drive of a stage, which is constant.
    pub fn drive(&self, stage: usize) -> Vec<Wrench> {
        self.drive[stage].iter().map(|[x, y, m]| Wrench { force: vec2(*x, *y), torque: *m }).collect()
    }

    /// Returns poses and twists at the end of a stage, by the independent integrator.
    pub fn solution(&self, stage: usize) -> Vec<(Pose, Twist)> {
        let states = self.states[stage].iter();
        let motions = states.map(|[x, y, theta, vx, vy, omega]| {
            let pose = Pose { position: vec2(*x, *y), orientation: *theta };
            (pose, Twist { velocity: vec2(*vx, *vy), angular_velocity: *omega })
        });
        motions.collect()
    }
}

/// Returns the cases with the materials of the default Trial.
///
/// # Errors
/// Their file is damaged.
pub fn usual() -> Result<Vec<Case>> {
    Ok(serde_json::from_str(USUAL)?)
}

/// Returns the largest differences of poses \[m, rad\] and velocities \[m/s, rad/s\] in a case.
fn differences(case: &Case, mechanical_step: f64) -> Result<(f64, f64)> {
    let mut world = case.world(mechanical_step)?;
    let (mut time, mut worst) = (0.0, (0.0, 0.0));
    for (stage, &end) in case.times.iter().enumerate() {
        world.drive = case.drive(stage);
        world.advance(end - time)?;
        time = end;
        for ((pose, twist), (known, moving)) in motions(&world).iter().zip(case.solution(stage)) {
            worst.0 = largest([worst.0, apart_in_pose(pose, &known)]);
            worst.1 = largest([worst.1, apart_in_twist(twist, &moving)]);
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

/// Returns the error of a pose that nine of ten people do not exceed at the end, divided by the accuracy that the steps
/// were chosen for. An error is how far any point of a body is from where it would be.
fn as_accurate_as_wished() -> Result<f64> {
    let mut worst = 0.0f64;
    for accuracy in [1e-3, 1e-4, 1e-6] {
        let mut errors = Vec::new();
        for case in usual()? {
            let step = Setup::of(&case.trial()?).steps().and_then(|steps| steps.accurate_to(accuracy));
            let mut world = case.world(step.ok_or_else(|| Error::Premise("there is a step".to_owned()))?)?;
            let mut time = 0.0;
            for (stage, &end) in case.times.iter().enumerate() {
                world.drive = case.drive(stage);
                world.advance(end - time)?;
                time = end;
            }
            let known = case.solution(case.times.len() - 1);
            let bodies = world.scene().bodies.iter().zip(&world.state().poses);
            errors.extend(
                bodies.zip(known).map(|((body, pose), (known, _))| pose.apart(&known, body.bounding_radius)),
            );
        }
        errors.sort_by(f64::total_cmp);
        worst = worst.max(errors[errors.len() * 9 / 10] / accuracy);
    }
    Ok(worst)
}
