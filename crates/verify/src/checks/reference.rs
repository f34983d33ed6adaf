//! Random cases, compared with the independent reference integrator (tests/fmpy/reference.py: scipy, eighth order, from
//! event to event, its own formulas). Its solutions are committed, and a test computes them again.

use crate::checks::scenarios::read;
use crate::checks::{Figure, Result, apart_in_pose, apart_in_twist, ensure, largest};
use anyhow::Context;
use crowd_mechanics::engine::{World, Wrench};
use crowd_mechanics::scenes::{motion, motions};
use crowd_mechanics::setup::Setup;
use lemons_core::plane::{Motion, vec2};
use lemons_core::trial::Trial;
use serde::Deserialize;
use std::collections::BTreeMap;

static CASES: &str = include_str!("../../../../tests/reference/cases.json");
/// Cases with the materials of the default Trial.
static USUAL: &str = include_str!("../../../../tests/reference/usual.json");

pub(crate) const FIGURES: &[Figure] = &[
    || Ok(largest(differences(CASES, 1e-6)?.into_iter().map(|[poses, _]| poses))),
    || Ok(largest(differences(CASES, 1e-6)?.into_iter().map(|[_, twists]| twists))),
    || median(1e-5),
    || Ok((2.0 - (median(1e-4)? / median(1e-5)?).log10()).max(0.0)),
    as_accurate_as_wished,
];

/// A case of these files; its format is described in reference.py.
#[derive(Deserialize)]
pub(crate) struct Case {
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
        read(&self.files.iter().map(|(name, text)| (name.as_str(), text.as_bytes())).collect::<Vec<_>>())
    }

    /// Returns the drive of a stage, which is constant.
    pub fn drive(&self, stage: usize) -> Vec<Wrench> {
        self.drive[stage].iter().map(|[x, y, m]| Wrench { force: vec2(*x, *y), torque: *m }).collect()
    }

    /// Returns motions at the end of a stage, by the independent integrator.
    pub fn solution(&self, stage: usize) -> Vec<Motion> {
        self.states[stage].iter().map(motion).collect()
    }

    /// Runs it. Returns the world at the end of each stage.
    fn run(&self, mechanical_step: f64) -> Result<Vec<World>> {
        let (mut world, mut time) = (self.world(mechanical_step)?, 0.0);
        let stages = self.times.iter().enumerate().map(|(stage, &end)| {
            world.drive = self.drive(stage);
            world.advance(end - time)?;
            time = end;
            Ok(world.clone())
        });
        stages.collect()
    }
}

/// Returns the cases with the materials of the default Trial.
///
/// # Errors
/// Their file is damaged.
pub(crate) fn usual() -> Result<Vec<Case>> {
    Ok(serde_json::from_str(USUAL)?)
}

/// Returns the largest differences of poses \[m, rad\] and velocities \[m/s, rad/s\] in each case of a text.
fn differences(cases: &str, mechanical_step: f64) -> Result<Vec<[f64; 2]>> {
    let cases: Vec<Case> = serde_json::from_str(cases)?;
    ensure!(cases.len() >= 12, "there are at least 12 cases: {}", cases.len());
    let difference = |case: &Case| {
        let (mut poses, mut twists) = (0.0, 0.0);
        for (stage, world) in case.run(mechanical_step)?.iter().enumerate() {
            for (own, known) in motions(world).iter().zip(case.solution(stage)) {
                poses = largest([poses, apart_in_pose(&own.pose, &known.pose)]);
                twists = largest([twists, apart_in_twist(&own.twist, &known.twist)]);
            }
        }
        Ok([poses, twists])
    };
    cases.iter().map(difference).collect()
}

/// Returns the median of the largest differences of poses of the cases with default materials. A single case is noisy:
/// the times within a step at which contacts begin change with every step.
fn median(mechanical_step: f64) -> Result<f64> {
    let mut poses: Vec<f64> =
        differences(USUAL, mechanical_step)?.into_iter().map(|[poses, _]| poses).collect();
    poses.sort_by(f64::total_cmp);
    Ok(poses[poses.len() / 2])
}

/// Returns the error of a pose that nine of ten people do not exceed at the end, divided by the accuracy that the steps
/// were chosen for. An error is how far any point of a body is from where it would be.
fn as_accurate_as_wished() -> Result<f64> {
    let mut worst = 0.0f64;
    for accuracy in [1e-3, 1e-4, 1e-6] {
        let mut errors = Vec::new();
        for case in usual()? {
            let step = Setup::of(&case.trial()?).steps().and_then(|steps| steps.accurate_to(accuracy));
            let worlds = case.run(step.context("there is a step")?)?;
            let last = worlds.len() - 1;
            let bodies = worlds[last].scene().bodies.iter().zip(&worlds[last].state().poses);
            let known = case.solution(last);
            errors.extend(
                bodies.zip(known).map(|((body, pose), known)| pose.apart(&known.pose, body.bounding_radius)),
            );
        }
        errors.sort_by(f64::total_cmp);
        worst = worst.max(errors[errors.len() * 9 / 10] / accuracy);
    }
    Ok(worst)
}
