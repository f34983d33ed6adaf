//! A Trial, moving.

use crate::base::Driven;
use crate::body;
use crate::frame::{COLUMNS, frame};
use crate::{Refused, Reply, require};
use crowd_mechanics::engine::{BodyId, PairForce, State, Vec2, World, vec2};
use crowd_mechanics::setup::Setup;
use lemons_people::Body3d;
use lemons_results::Frame;
use lemons_sim::{Algorithm, Documents, Model, Simulation};
use serde_json::json;
use std::cell::OnceCell;

/// Most communication steps of a request: a page wants to be heard between them.
pub const MOST_STEPS: u32 = 1000;
/// \[byte\] Largest answer to a request for steps.
pub const MOST_BYTES: u64 = 100_000_000;
/// Most mechanical steps of a person in a communication step, for all people together: about a quarter of a minute.
pub const MOST_WORK: f64 = 5e8;
/// A Trial and its simulation.
#[derive(Debug)]
pub struct Run {
    driven: Driven,
    simulation: Simulation,
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
        let Driven { trial, table, plan, .. } = driven.clone();
        let documents = Documents { trial, drive: table, plan };
        let mut simulation = Simulation::new(documents, Algorithm::Jacobi)?;
        simulation.begin(0.0, None)?;
        Ok(Run { driven, simulation, steps: 0, overlap: 0.0, bodies: OnceCell::new() })
    }

    /// Returns what runs.
    pub fn driven(&self) -> &Driven {
        &self.driven
    }

    /// Everybody's body in three dimensions.
    ///
    /// # Errors
    /// As those of [`body::of_everybody`].
    pub fn bodies(&self) -> Result<&[Option<Body3d>], Refused> {
        if let Some(bodies) = self.bodies.get() {
            return Ok(bodies);
        }
        let bodies = body::of_everybody(&self.driven)?;
        Ok(self.bodies.get_or_init(|| bodies))
    }

    /// Its bodies.
    pub fn world(&self) -> &World {
        self.simulation.world().expect("a run has begun")
    }

    /// How many people there are.
    pub fn people(&self) -> usize {
        self.driven.trial.agents.len()
    }

    /// Advances by one communication step.
    ///
    /// # Errors
    /// The engine refuses it; the run is then where it was.
    pub fn step(&mut self) -> Result<(), Refused> {
        // Communication points are multiples, as those of `lemons run`.
        self.simulation.step_to(self.time_at(self.steps + 1))?;
        self.steps += 1;
        self.overlap = self.overlap.max(self.world().largest_overlap());
        Ok(())
    }

    /// Advances by communication steps. Returns time, deepest overlap since the beginning, how many have arrived, and all
    /// frames, one after the other.
    ///
    /// # Errors
    /// Too many steps, or the engine refuses one; the run is then where it was before that one.
    pub fn advance(&mut self, steps: u32) -> Result<Reply, Refused> {
        require(steps <= MOST_STEPS, || format!("{steps} steps at once: at most {MOST_STEPS}"))?;
        let people = self.people();
        require((8 * COLUMNS * people) as u64 * u64::from(steps) <= MOST_BYTES, || {
            format!("{steps} steps of {people} people at once have more than 100 MB")
        })?;
        self.check_work()?;
        let mut bytes = Vec::new();
        for _ in 0..steps {
            self.step()?;
            bytes.extend(self.frame());
        }
        let arrived = self.simulation.arrived()?;
        let value = json!({ "time": self.time_at(self.steps), "overlap": self.overlap, "arrived": arrived });
        Ok(Reply { value, bytes })
    }

    /// Checks that a communication step is not too much work for a page.
    ///
    /// # Errors
    /// It is.
    pub fn check_work(&self) -> Result<(), Refused> {
        let parameters = &self.driven.trial.parameters;
        let mechanical = parameters.time_step / parameters.time_step_mechanical;
        let people = self.people();
        require(mechanical * people as f64 <= MOST_WORK, || {
            format!(
                "a TimeStep of {} s has {mechanical:.3e} mechanical steps: too many for a page with {people} people",
                parameters.time_step
            )
        })
    }

    /// \[s\]
    fn time_at(&self, steps: u64) -> f64 {
        steps as f64 * self.driven.trial.parameters.time_step
    }

    /// [`COLUMNS`] doubles for each agent, little-endian. The place of who has left is not a number.
    pub fn frame(&self) -> Vec<u8> {
        let frame = self.observed();
        let mut bytes = Vec::with_capacity(8 * COLUMNS * frame.agents.len());
        let observed = frame.observed.iter().flatten();
        for ((k, motion), observed) in frame.agents.iter().enumerate().zip(observed) {
            let (pose, twist) = (motion.pose, motion.twist);
            let touched = observed.agent_contacts + observed.wall_contacts;
            let place = if frame.is_there(k) { pose.position } else { vec2(f64::NAN, f64::NAN) };
            let numbers: [f64; COLUMNS] = [
                place.x,
                place.y,
                pose.orientation,
                twist.velocity.x,
                twist.velocity.y,
                twist.angular_velocity,
                observed.of_step.map_or(0.0, |step| step.mean_normal_force),
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
        let forces = self.pair_forces(bytes)?.into_iter();
        let numbers = forces.flat_map(|of| [of.from.x, of.from.y, of.to.x, of.to.y, of.normal_force]);
        Ok(Reply { value: json!({}), bytes: numbers.flat_map(f64::to_le_bytes).collect() })
    }

    /// The same for pictures.
    ///
    /// # Errors
    /// It is not a frame of these people.
    pub fn pair_forces(&self, bytes: &[u8]) -> Result<Vec<PairForce>, Refused> {
        let (mut poses, twists): (Vec<_>, Vec<_>) =
            frame(bytes, self.people())?.into_iter().map(|motion| (motion.pose, motion.twist)).unzip();
        let mut shadow = Setup::of(&self.driven.trial).world()?;
        for (b, pose) in poses.iter_mut().enumerate().filter(|(_, pose)| !pose.position.is_finite()) {
            shadow.set_present(BodyId::from(b), false);
            pose.position = Vec2::ZERO;
        }
        let crowded = shadow.restore(State::new(poses.clone(), twists));
        crowded.map_err(|crowded| Setup::of(&self.driven.trial).too_crowded(crowded))?;
        Ok(shadow.pair_forces(&poses))
    }

    /// Returns what the rows of the table of `lemons run` say.
    pub fn observed(&self) -> Frame {
        self.simulation.frame()
    }
}
