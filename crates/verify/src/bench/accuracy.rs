//! Errors of poses against the mechanical step, for five kinds of scene.
//!
//! An error is how far any point of a body is from where it would be: |Δr| + R |Δθ|, with R from the centre of mass to the
//! rim. The reference is the same engine with a step of 1e-7 s; for random collisions, the independent integrator of
//! tests/fmpy/reference.py.

use crate::bench::{crowd, sparse};
use crate::checks::Result;
use crate::checks::reference;
use crate::checks::scenes::Random;
use cpu_time::ThreadTime;
use crowd_mechanics::engine::{World, Wrench};
use crowd_mechanics::setup::{self, Setup};
use include_dir::{Dir, include_dir};
use lemons_core::plane::{Pose, Vec2, vec2};
use lemons_core::trial::Trial;
use lemons_core::trial::{DriveChoice, DriveTable};
use std::f64::consts::PI;
use tempfile::TempDir;

pub(crate) static PUSH: Dir = include_dir!("$CARGO_MANIFEST_DIR/../../resources/Trial_push");
static DOOR: Dir = include_dir!("$CARGO_MANIFEST_DIR/../../resources/Trial_door");

/// \[s\] The step that counts as exact.
const EXACT: f64 = 1e-7;
/// \[s\] The steps that are measured.
pub const STEPS: [f64; 9] = [2e-7, 1e-6, 2e-6, 5e-6, 1e-5, 2e-5, 5e-5, 1e-4, 2e-4];

/// Wrenches of all people at a time \[s\].
type Rule = Box<dyn Fn(f64, &World) -> Vec<Wrench>>;

/// What drives a scene over a stage.
enum Drive {
    /// These wrenches of each stage.
    Stages(Vec<Vec<Wrench>>),
    /// A function of the time \[s\] at the beginning of the stage, and of the poses there.
    Rule(Rule),
}

/// A motion from its start.
struct Motion {
    start: World,
    drive: Drive,
    /// Poses at the ends of stages, if somebody else knows them.
    known: Option<Vec<Vec<Pose>>>,
}

/// A kind of scene: motions that are looked at together.
pub struct Scene {
    /// What it is called in docs/step.md.
    pub name: &'static str,
    /// \[s\] ends of the stages, over which drives are constant.
    times: Vec<f64>,
    motions: Vec<Motion>,
}

/// What was found for one step.
pub struct Found {
    /// \[s\]
    pub step: f64,
    /// \[s\] of processor time per simulated second.
    pub cost: f64,
    /// \[m\] errors of all bodies in ascending order, at the end of each stage.
    pub errors: Vec<Vec<f64>>,
}

impl Found {
    /// \[m\] Returns the error that this share of the bodies does not exceed at the end of a stage.
    pub fn error(&self, stage: usize, share: f64) -> f64 {
        let errors = &self.errors[stage];
        errors[(share * (errors.len() - 1) as f64).round() as usize]
    }
}

impl Scene {
    /// \[s\] Returns the ends of the stages.
    pub fn times(&self) -> &[f64] {
        &self.times
    }

    /// Returns the number of people.
    pub fn people(&self) -> usize {
        self.motions.iter().map(|motion| motion.start.scene().bodies.len()).sum()
    }

    /// Runs the scene with each step, and compares it.
    ///
    /// # Errors
    /// The simulation diverges.
    pub fn measure(&self, steps: &[f64]) -> Result<Vec<Found>> {
        let exact = self.motions.iter().map(|motion| match &motion.known {
            Some(known) => Ok(known.clone()),
            None => Ok(motion.run(&self.times, EXACT)?.0),
        });
        let exact = exact.collect::<Result<Vec<_>>>()?;
        steps.iter().map(|&step| self.compare(step, &exact)).collect()
    }

    fn compare(&self, step: f64, exact: &[Vec<Vec<Pose>>]) -> Result<Found> {
        let mut errors = vec![Vec::new(); self.times.len()];
        let mut seconds = 0.0;
        for (motion, exact) in self.motions.iter().zip(exact) {
            let (found, cost) = motion.run(&self.times, step)?;
            seconds += cost;
            for (stage, (found, exact)) in found.iter().zip(exact).enumerate() {
                let bodies = &motion.start.scene().bodies;
                let poses = found.iter().zip(exact);
                let apart = bodies
                    .iter()
                    .zip(poses)
                    .map(|(body, (one, other))| one.apart(other, body.bounding_radius));
                errors[stage].extend(apart);
            }
        }
        for errors in &mut errors {
            errors.sort_by(f64::total_cmp);
        }
        let simulated = self.times.last().copied().unwrap_or(1.0) * self.motions.len() as f64;
        Ok(Found { step, cost: seconds / simulated, errors })
    }
}

impl Motion {
    /// Returns the poses at the end of each stage, and the processor time \[s\].
    fn run(&self, times: &[f64], step: f64) -> Result<(Vec<Vec<Pose>>, f64)> {
        let mut world = self.start.clone();
        world.mechanical_step = step;
        let (mut time, mut poses) = (0.0, Vec::new());
        let begun = ThreadTime::now();
        for (stage, &end) in times.iter().enumerate() {
            world.drive = match &self.drive {
                Drive::Stages(stages) => stages[stage].clone(),
                Drive::Rule(rule) => rule(time, &world),
            };
            world.advance(end - time)?;
            time = end;
            poses.push(world.state().poses.clone());
        }
        Ok((poses, begun.elapsed().as_secs_f64()))
    }
}

/// \[s\] Ends of stages of a twentieth of a second.
fn twentieths(until: f64) -> Vec<f64> {
    (1..=(20.0 * until).round() as u32).map(|k| f64::from(k) / 20.0).collect()
}

/// Returns the five kinds of scene.
///
/// # Errors
/// A Trial cannot be read, or a crowd cannot be made.
pub fn scenes() -> Result<Vec<Scene>> {
    Ok(vec![push()?, collisions()?, dense()?, door()?, walkers()?])
}

pub(crate) fn trial(files: &Dir<'_>) -> Result<(Trial, TempDir)> {
    let directory = TempDir::with_prefix("lemons-bench-")?;
    files.extract(directory.path())?;
    let (trial, _) = setup::read(directory.path())?;
    Ok((trial, directory))
}

/// The default Trial with its own push.
fn push() -> Result<Scene> {
    let (trial, _directory) = trial(&PUSH)?;
    let table = DriveTable::of(Some(&trial), &DriveChoice::Own)?;
    let start = Setup::of(&trial).world().map_err(crate::checks::Error::from)?;
    let ids: Vec<String> = trial.agents.iter().map(|agent| agent.id.clone()).collect();
    let rule = move |time: f64, _: &World| {
        let of = |id: &String| table.at(id, time).unwrap_or_default();
        ids.iter().map(of).map(|[x, y, torque]| Wrench { force: vec2(x, y), torque }).collect()
    };
    let motions = vec![Motion { start, drive: Drive::Rule(Box::new(rule)), known: None }];
    Ok(Scene { name: "push", times: twentieths(2.0), motions })
}

/// Random cases of four to six, with the default materials.
fn collisions() -> Result<Scene> {
    let cases = reference::usual()?;
    let times = cases.first().map(|case| case.times.clone()).unwrap_or_default();
    let motions = cases.iter().map(|case| {
        let stages = 0..case.times.len();
        let poses = |stage| case.solution(stage).into_iter().map(|(pose, _)| pose).collect();
        Ok(Motion {
            start: case.world(EXACT)?,
            drive: Drive::Stages(stages.clone().map(|stage| case.drive(stage)).collect()),
            known: Some(stages.map(poses).collect()),
        })
    });
    let motions = motions.collect::<Result<Vec<_>>>()?;
    Ok(Scene { name: "collisions", times, motions })
}

/// A hundred people who stand at six per square metre; those at the left are pushed.
fn dense() -> Result<Scene> {
    let start = crowd(100, vec2(0.32, 0.521), 0.5, 0.0);
    let rule = |time: f64, world: &World| {
        let pushed = |pose: &Pose| pose.position.x < 0.3;
        let force = if time < 0.6 { 600.0 * (PI * (time + 0.025) / 0.6).sin() } else { 0.0 };
        let of = |pose: &Pose| Wrench {
            force: Vec2 { x: if pushed(pose) { force } else { 0.0 }, y: 0.0 },
            torque: 0.0,
        };
        world.state().poses.iter().map(of).collect()
    };
    let motions = vec![Motion { start, drive: Drive::Rule(Box::new(rule)), known: None }];
    Ok(Scene { name: "dense crowd", times: twentieths(1.0), motions })
}

/// The thirty people of the Trial who have come to the door.
fn door() -> Result<Scene> {
    let (trial, _directory) = trial(&DOOR)?;
    let mut start = Setup::of(&trial).world().map_err(crate::checks::Error::from)?;
    let mut numbers = Random(4);
    let wished: Vec<f64> = start.scene().bodies.iter().map(|_| 1.4 + 0.3 * numbers.signed()).collect();
    let rule = move |_: f64, world: &World| {
        let bodies = world.scene().bodies.iter().zip(&world.state().poses).zip(&wished);
        let of = |((body, pose), speed): ((&crowd_mechanics::engine::Body, &Pose), &f64)| {
            let goal = if pose.position.x < 5.0 { vec2(5.1, 2.5) } else { vec2(30.0, 2.5) };
            let way = goal - pose.position;
            Wrench { force: way * (speed * body.mass * body.translation_rate / way.norm()), torque: 0.0 }
        };
        bodies.map(of).collect()
    };
    start.mechanical_step = 1e-4;
    for _ in 0..60 {
        start.drive = rule(0.0, &start);
        start.advance(0.05)?;
    }
    let motions = vec![Motion { start, drive: Drive::Rule(Box::new(rule)), known: None }];
    Ok(Scene { name: "door", times: twentieths(1.0), motions })
}

/// One person per 2 m², each walking somewhere.
fn walkers() -> Result<Scene> {
    let start = sparse(100)?;
    let drive = Drive::Stages(vec![start.drive.clone(); 20]);
    let motions = vec![Motion { start, drive, known: None }];
    Ok(Scene { name: "walkers", times: twentieths(1.0), motions })
}
