//! Errors of poses against the mechanical step, for five kinds of scene.
//!
//! An error is how far any point of a body is from where it would be: |Δr| + R |Δθ|, with R from the centre of mass to the
//! rim. The reference is the same engine with a step of 1e-7 s; for random collisions, the independent integrator of
//! tests/fmpy/reference.py.

use crate::bench::{DENSE, crowd, sparse};
use crate::checks::reference;
use crate::checks::scenarios::{Files, files_of, read};
use anyhow::Result;
use cpu_time::ThreadTime;
use crowd_mechanics::engine::{World, Wrench};
use crowd_mechanics::scenes::Random;
use crowd_mechanics::setup::Setup;
use lemons_core::plane::{Pose, vec2};
use lemons_core::trial::{Agent, DriveTable};
use std::f64::consts::PI;

pub(crate) const PUSH: &Files = files_of!("resources/Trial_push");
const PUSH_DRIVE: &[u8] = include_bytes!("../../../../resources/Trial_push/drive.csv");
const DOOR: &Files = files_of!("resources/Trial_door");

/// \[s\] The step that counts as exact.
const EXACT: f64 = 1e-7;
/// \[s\] The steps that are measured.
pub const STEPS: [f64; 9] = [2e-7, 1e-6, 2e-6, 5e-6, 1e-5, 2e-5, 5e-5, 1e-4, 2e-4];

/// Wrenches of all people over a stage, from the time \[s\] at which it begins, and from where they are then.
type Drive = Box<dyn Fn(usize, f64, &World) -> Vec<Wrench>>;

/// A motion from its start.
struct Motion {
    start: World,
    drive: Drive,
    /// Poses at the ends of stages, if somebody else knows them.
    known: Option<Vec<Vec<Pose>>>,
}

/// A kind of scene: motions that are looked at together.
pub struct AccuracyScene {
    /// Name in docs/step.md.
    pub name: &'static str,
    /// \[s\] ends of the stages, over which drives are constant.
    pub times: Vec<f64>,
    motions: Vec<Motion>,
}

/// Errors and cost of one step.
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

impl AccuracyScene {
    /// Returns the number of people.
    pub fn people(&self) -> usize {
        self.motions.iter().map(|motion| motion.start.scene().bodies.len()).sum()
    }

    /// Runs the scene with each of [`STEPS`], and compares it.
    ///
    /// # Errors
    /// The simulation diverges.
    pub fn measure(&self) -> Result<Vec<Found>> {
        let mut all: Vec<Found> = STEPS.map(|step| Found { step, cost: 0.0, errors: Vec::new() }).into();
        let simulated = self.times.last().copied().unwrap_or(1.0) * self.motions.len() as f64;
        for motion in &self.motions {
            let exact = match &motion.known {
                Some(known) => known.clone(),
                None => motion.run(&self.times, EXACT)?.0,
            };
            for found in &mut all {
                let (poses, seconds) = motion.run(&self.times, found.step)?;
                found.cost += seconds / simulated;
                found.errors.resize(self.times.len(), Vec::new());
                for ((errors, poses), exact) in found.errors.iter_mut().zip(&poses).zip(&exact) {
                    let bodies = motion.start.scene().bodies.iter().zip(poses).zip(exact);
                    errors.extend(bodies.map(|((body, one), other)| one.apart(other, body.bounding_radius)));
                }
            }
        }
        all.iter_mut().flat_map(|found| &mut found.errors).for_each(|errors| errors.sort_by(f64::total_cmp));
        Ok(all)
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
            world.drive = (self.drive)(stage, time, &world);
            world.advance(end - time)?;
            time = end;
            poses.push(world.state().poses.clone());
        }
        Ok((poses, begun.elapsed().as_secs_f64()))
    }
}

/// Returns the five kinds of scene.
///
/// # Errors
/// A Trial cannot be read, or a crowd cannot be made.
pub fn scenes() -> Result<Vec<AccuracyScene>> {
    Ok(vec![push()?, collisions()?, dense(), door()?, walkers()?])
}

/// A scene of one motion, over twentieths of a second.
fn scene(name: &'static str, until: f64, start: World, drive: Drive) -> AccuracyScene {
    let times = (1..=(20.0 * until).round() as u32).map(|k| f64::from(k) / 20.0).collect();
    AccuracyScene { name, times, motions: vec![Motion { start, drive, known: None }] }
}

/// The default Trial with its own push.
fn push() -> Result<AccuracyScene> {
    let trial = read(PUSH)?;
    let table = DriveTable::from_csv(PUSH_DRIVE)?;
    let start = Setup::of(&trial).world()?;
    let drive = move |_, time: f64, _: &World| {
        let of = |agent: &Agent| table.at(&agent.id, time).unwrap_or_default();
        trial.agents.iter().map(of).map(|[x, y, torque]| Wrench { force: vec2(x, y), torque }).collect()
    };
    Ok(scene("push", 2.0, start, Box::new(drive)))
}

/// Random cases of four to six, with the default materials.
fn collisions() -> Result<AccuracyScene> {
    let cases = reference::usual()?;
    let times = cases[0].times.clone();
    let motions = cases.into_iter().map(|case| {
        let poses = |stage| case.solution(stage).into_iter().map(|known| known.pose).collect();
        Ok(Motion {
            start: case.world(EXACT)?,
            known: Some((0..case.times.len()).map(poses).collect()),
            drive: Box::new(move |stage, _, _| case.drive(stage)),
        })
    });
    Ok(AccuracyScene { name: "collisions", times, motions: motions.collect::<Result<_>>()? })
}

/// A hundred people who stand at six per square metre; those at the left are pushed.
fn dense() -> AccuracyScene {
    let drive = |_, time: f64, world: &World| {
        let force = if time < 0.6 { 600.0 * (PI * (time + 0.025) / 0.6).sin() } else { 0.0 };
        let of = |pose: &Pose| Wrench {
            force: vec2(if pose.position.x < 0.3 { force } else { 0.0 }, 0.0),
            torque: 0.0,
        };
        world.state().poses.iter().map(of).collect()
    };
    scene("dense crowd", 1.0, crowd(100, DENSE, 0.5, 0.0), Box::new(drive))
}

/// The thirty people of the Trial who have come to the door.
fn door() -> Result<AccuracyScene> {
    let mut start = Setup::of(&read(DOOR)?).world()?;
    let mut numbers = Random(4);
    let speeds: Vec<f64> = start.scene().bodies.iter().map(|_| 1.4 + 0.3 * numbers.signed()).collect();
    let drive = move |_, _, world: &World| {
        let bodies = world.scene().bodies.iter().zip(&world.state().poses).zip(&speeds);
        let of = |((body, pose), speed): ((&crowd_mechanics::engine::Body, &Pose), &f64)| {
            let goal = if pose.position.x < 5.0 { vec2(5.1, 2.5) } else { vec2(30.0, 2.5) };
            let way = goal - pose.position;
            Wrench { force: way * (speed * body.mass * body.translation_rate / way.norm()), torque: 0.0 }
        };
        bodies.map(of).collect()
    };
    start.mechanical_step = 1e-4;
    for _ in 0..60 {
        start.drive = drive(0, 0.0, &start);
        start.advance(0.05)?;
    }
    Ok(scene("door", 1.0, start, Box::new(drive)))
}

/// One person per 2 m², each walking somewhere.
fn walkers() -> Result<AccuracyScene> {
    let start = sparse(100)?;
    let drive = start.drive.clone();
    Ok(scene("walkers", 1.0, start, Box::new(move |_, _, _| drive.clone())))
}
