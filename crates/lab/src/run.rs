//! A Trial, moving.

use crate::body;
use crate::driven::Driven;
use crate::frame::{COLUMNS, frame};
use crate::{Refused, Reply};
use crowd_mechanics::engine::{BodyId, Chain, State, Vec2, World, Wrench, vec2};
use crowd_mechanics::setup::Setup;
use lemons_decision::Decision;
use lemons_decision::decision::Act;
use lemons_decision::rule::Pose as Seen;
use lemons_people::Body3d;
use lemons_plane::Motion;
use lemons_record::{Frame, Observed, OfStep, Totals};
use serde_json::json;
use std::cell::OnceCell;

/// Most communication steps of a request: a page wants to be heard between them.
pub const MOST_STEPS: u32 = 1000;
/// \[byte\] Largest answer to a request for steps.
pub const MOST_BYTES: u64 = 100_000_000;
/// Most mechanical steps of a person in a communication step, for all people together: about a quarter of a minute.
pub const MOST_WORK: f64 = 5e8;
/// A Trial and its world.
#[derive(Debug)]
pub struct Run {
    driven: Driven,
    world: World,
    /// Those who walk.
    decision: Option<Decision>,
    /// What they will do in the next step.
    coming: Vec<Act>,
    /// Communication steps so far.
    steps: u64,
    /// \[m\] Deepest overlap so far.
    overlap: f64,
    /// Everybody's body, once somebody has asked for it: a hundredth of a second each.
    bodies: OnceCell<Vec<Option<Body3d>>>,
}

impl Run {
    /// At the Trial's beginning.
    ///
    /// # Errors
    /// Materials that can touch have no usable contact, too many people are at one place, or no ways to exits and goals
    /// can be found.
    pub fn begin(driven: Driven) -> Result<Run, Refused> {
        let mut world = Setup::of(&driven.trial).world().map_err(Refused::of)?;
        let mut decision = driven.plan.clone().map(Decision::new);
        let coming = decision.as_mut().map_or(Ok(Vec::new()), Decision::acts).map_err(Refused::of)?;
        if coming.iter().any(|act| !act.active) {
            // Who stands in an exit is never there.
            dismiss(&mut world, &coming);
            world.restore(world.state().clone()).map_err(Refused::of)?;
        }
        Ok(Run { driven, world, decision, coming, steps: 0, overlap: 0.0, bodies: OnceCell::new() })
    }

    /// What runs.
    pub fn driven(&self) -> &Driven {
        &self.driven
    }

    /// Everybody's body in three dimensions.
    ///
    /// # Errors
    /// Those of [`body::of_everybody`].
    pub fn bodies(&self) -> Result<&[Option<Body3d>], Refused> {
        if let Some(bodies) = self.bodies.get() {
            return Ok(bodies);
        }
        let bodies = body::of_everybody(&self.driven)?;
        Ok(self.bodies.get_or_init(|| bodies))
    }

    /// Its bodies.
    pub fn world(&self) -> &World {
        &self.world
    }

    /// How many people there are.
    pub fn people(&self) -> usize {
        self.driven.trial.agents.len()
    }

    /// What drives people from a communication point \[s\] on: those who walk, eq. 4 of the paper, and the rows of the
    /// drive file beside it; those whom only the file names, its rows; others, what the Trial says.
    ///
    /// Who walks decides from where he was one step before, as when `lemons run` couples the two FMUs (Jacobi).
    fn push(&mut self, time: f64) {
        if self.decision.is_some() {
            dismiss(&mut self.world, &self.coming);
            for (of, Act { drive, .. }) in self.world.drive.iter_mut().zip(&self.coming) {
                let [x, y] = drive.force;
                *of = Wrench { force: vec2(x, y), torque: drive.torque };
            }
        }
        let Driven { trial, table, .. } = &self.driven;
        for (agent, drive) in trial.agents.iter().zip(&mut self.world.drive) {
            if let Some([x, y, torque]) = table.at(&agent.id, time) {
                let walks = if self.decision.is_some() { *drive } else { Wrench::default() };
                *drive = Wrench { force: walks.force + vec2(x, y), torque: walks.torque + torque };
            }
        }
    }

    /// Advances by one communication step.
    ///
    /// # Errors
    /// The engine refuses it; the run is then where it was.
    pub fn step(&mut self) -> Result<(), Refused> {
        // Communication points are multiples, as those of `lemons run`; steps are their differences.
        let time = self.time_at(self.steps);
        let duration = self.time_at(self.steps + 1) - time;
        self.push(time);
        let before: Vec<Seen> = seen(&self.world).collect();
        let advanced = self.world.advance(duration);
        advanced.map_err(|error| Refused(Setup::of(&self.driven.trial).name_body(&error)))?;
        if let Some(decision) = &mut self.decision {
            decision.see(before.into_iter());
            decision.pass(duration).map_err(Refused::of)?;
            self.coming = decision.acts().map_err(Refused::of)?;
        }
        self.steps += 1;
        self.overlap = self.overlap.max(self.world.largest_overlap());
        Ok(())
    }

    /// Advances by communication steps. Returns time, deepest overlap since the beginning, how many have arrived, and all
    /// frames, one after the other.
    ///
    /// # Errors
    /// Too many steps, or the engine refuses one; the run is then where it was before that one.
    pub fn advance(&mut self, steps: u32) -> Result<Reply, Refused> {
        if steps > MOST_STEPS {
            return Err(Refused(format!("{steps} steps at once: at most {MOST_STEPS}")));
        }
        let people = self.people();
        if (8 * COLUMNS * people) as u64 * u64::from(steps) > MOST_BYTES {
            return Err(Refused(format!("{steps} steps of {people} people at once have more than 100 MB")));
        }
        self.check_work()?;
        let mut bytes = Vec::new();
        for _ in 0..steps {
            self.step()?;
            bytes.extend(self.frame());
        }
        let arrived = self.decision.as_mut().map_or(Ok(0), Decision::arrived).map_err(Refused::of)?;
        let value = json!({ "time": self.time_at(self.steps), "overlap": self.overlap, "arrived": arrived });
        Ok(Reply { value, bytes })
    }

    /// That a communication step is not too much work for a page.
    ///
    /// # Errors
    /// It is.
    pub fn check_work(&self) -> Result<(), Refused> {
        let parameters = &self.driven.trial.parameters;
        let mechanical = parameters.time_step / parameters.time_step_mechanical;
        let people = self.people();
        if mechanical * people as f64 <= MOST_WORK {
            return Ok(());
        }
        Err(Refused(format!(
            "a TimeStep of {} s has {mechanical:.3e} mechanical steps: too many for a page with {people} people",
            parameters.time_step
        )))
    }

    /// \[s\]
    fn time_at(&self, steps: u64) -> f64 {
        steps as f64 * self.driven.trial.parameters.time_step
    }

    /// [`COLUMNS`] doubles for each agent, little-endian. The place of who has left is not a number.
    pub fn frame(&self) -> Vec<u8> {
        let (state, contacts) = (self.world.state(), &self.world.contacts().bodies);
        let exposures = self.world.exposures();
        let mut bytes = Vec::with_capacity(8 * COLUMNS * state.poses.len());
        for (k, (pose, twist)) in state.poses.iter().zip(&state.twists).enumerate() {
            let touched = contacts[k].agent_contacts + contacts[k].wall_contacts;
            let place = if self.world.present()[k] { pose.position } else { vec2(f64::NAN, f64::NAN) };
            let numbers: [f64; COLUMNS] = [
                place.x,
                place.y,
                pose.orientation,
                twist.velocity.x,
                twist.velocity.y,
                twist.angular_velocity,
                exposures[k].mean_force,
                f64::from(touched),
            ];
            bytes.extend(numbers.into_iter().flat_map(f64::to_le_bytes));
        }
        bytes
    }

    /// Returns who presses whom in a frame: x, y \[m\] of one, x, y of the other or of the wall, and their force \[N\].
    /// The tangential springs of the frame are not known; they do not change normal forces.
    ///
    /// # Errors
    /// It is not a frame of these people.
    pub fn forces(&self, bytes: &[u8]) -> Result<Reply, Refused> {
        let forces = self.chains(bytes)?.into_iter();
        let numbers = forces.flat_map(|of| [of.from.x, of.from.y, of.to.x, of.to.y, of.normal_force]);
        Ok(Reply { value: json!({}), bytes: numbers.flat_map(f64::to_le_bytes).collect() })
    }

    /// The same for pictures.
    ///
    /// # Errors
    /// It is not a frame of these people.
    pub fn chains(&self, bytes: &[u8]) -> Result<Vec<Chain>, Refused> {
        let (mut poses, twists): (Vec<_>, Vec<_>) =
            frame(bytes, self.people())?.into_iter().map(|motion| (motion.pose, motion.twist)).unzip();
        let mut shadow = Setup::of(&self.driven.trial).world().map_err(Refused::of)?;
        for (b, pose) in poses.iter_mut().enumerate().filter(|(_, pose)| !pose.position.is_finite()) {
            shadow.set_present(BodyId::from(b), false);
            pose.position = Vec2::ZERO;
        }
        let crowded = shadow.restore(State::new(poses.clone(), twists));
        crowded.map_err(|crowded| Refused::of(Setup::of(&self.driven.trial).too_crowded(crowded)))?;
        Ok(shadow.chains(&poses))
    }

    /// What a row of the table of `lemons run` says, for each.
    pub fn observed(&self) -> Frame {
        let (state, report) = (self.world.state(), self.world.contacts());
        let agents = state.poses.iter().zip(&state.twists);
        let observed = report.bodies.iter().zip(self.world.exposures()).map(|(body, exposure)| Observed {
            agent_contacts: body.agent_contacts,
            wall_contacts: body.wall_contacts,
            contacting_agents: body.touching_bodies,
            normal_force: body.squeeze,
            of_step: Some(OfStep {
                mean_normal_force: exposure.mean_force,
                peak_normal_force: exposure.peak_force,
                peak_overlap: exposure.peak_overlap,
            }),
        });
        let totals = Totals { agent_contacts: report.agent_contacts, wall_contacts: report.wall_contacts };
        Frame {
            time: self.time_at(self.steps),
            agents: agents.map(|(pose, twist)| Motion { pose: *pose, twist: *twist }).collect(),
            observed: Some(observed.collect()),
            totals: Some(totals),
            active: self.driven.plan.is_some().then(|| self.world.present().to_vec()),
            ..Frame::default()
        }
    }
}

/// Takes those out who leave.
fn dismiss(world: &mut World, acts: &[Act]) {
    acts.iter().enumerate().for_each(|(b, act)| world.set_present(BodyId::from(b), act.active));
}

/// Everybody, as those who walk see them.
fn seen(world: &World) -> impl Iterator<Item = Seen> {
    let poses = world.state().poses.iter();
    poses.map(|pose| Seen { x: pose.position.x, y: pose.position.y, theta: pose.orientation })
}
