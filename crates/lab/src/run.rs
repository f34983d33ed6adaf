//! A Trial, moving.

use crate::body;
use crate::frame::{self, COLUMNS};
use crate::loaded::LoadedTrial;
use crate::loads::Loads;
use crate::map::Map;
use crate::{Refused, Reply, require};
use crowd_mechanics::engine::{PairForce, World};
use lemons_core::plane::Pose;
use lemons_core::trial::Link;
use lemons_people::Figure;
use lemons_results::Frame;
use lemons_sim::{Algorithm, Clock, Observer, Replay, Simulation, Stepper};
use serde::Serialize;
use std::cell::OnceCell;
use std::ops::ControlFlow;

/// Most communication steps of a request: a page wants to be heard between them.
pub const MOST_STEPS: u32 = 1000;
/// \[byte\] Largest answer to a request for steps.
pub const MOST_BYTES: u64 = 100_000_000;
/// Most mechanical steps of a person in a communication step, for all people together: about a quarter of a minute.
pub const MOST_WORK: f64 = 5e8;

/// Numbers of each further step.
#[derive(Default, Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub(crate) struct Advanced {
    /// \[m\] Deepest overlap so far.
    overlaps: Vec<f64>,
    /// How many of those who walk have arrived or left.
    arrived: Vec<usize>,
}

/// A Trial and its simulation.
pub struct LabRun {
    /// The Trial that runs.
    pub loaded: LoadedTrial,
    /// Its simulation.
    pub simulation: Simulation,
    points: Stepper,
    /// What frames have besides.
    pub loads: Loads,
    /// \[m\] Deepest overlap so far.
    overlap: f64,
    /// Everybody in three dimensions, once somebody has asked for it: a hundredth of a second each.
    bodies: OnceCell<Vec<Option<Figure>>>,
    /// The map that a page has asked for last.
    pub map: Option<Map>,
}

impl LabRun {
    /// At the Trial's beginning.
    ///
    /// # Errors
    /// Materials that can touch have no usable contact, too many people are at one place, or no ways to exits and goals
    /// can be found.
    pub fn begin(loaded: LoadedTrial) -> Result<LabRun, Refused> {
        let mut simulation = Simulation::new(loaded.documents(), Algorithm::Jacobi)?;
        simulation.begin(0.0, None)?;
        // Communication points are multiples, as those of `lemons run`.
        let points = Stepper::new(Clock::endless(0.0, loaded.trial.parameters.time_step), 1, None);
        let loads = Loads::of(&loaded.trial, simulation.world().expect("it has begun"));
        Ok(LabRun { loaded, simulation, points, loads, overlap: 0.0, bodies: OnceCell::new(), map: None })
    }

    /// Everybody in three dimensions, with what goes along.
    ///
    /// # Errors
    /// As those of [`body::of_everybody`].
    pub fn bodies(&self) -> Result<&[Option<Figure>], Refused> {
        if let Some(bodies) = self.bodies.get() {
            return Ok(bodies);
        }
        let bodies = body::of_everybody(&self.loaded)?;
        Ok(self.bodies.get_or_init(|| bodies))
    }

    /// Its bodies.
    pub fn world(&self) -> &World {
        self.simulation.world().expect("a run has begun")
    }

    /// Returns the links of its plan.
    pub fn links(&self) -> &[Link] {
        &self.loaded.trial.geometry.links
    }

    /// How many people there are.
    pub fn people(&self) -> usize {
        self.loaded.trial.agents.len()
    }

    /// Advances by communication steps, which an observer sees.
    ///
    /// # Errors
    /// The engine refuses one; the run is then where it was before that one. Or those of the observer.
    pub fn advance_with<O: Observer<Simulation>>(
        &mut self,
        observer: &mut O,
        steps: u32,
    ) -> Result<(), O::Error> {
        self.points.advance(&mut self.simulation, observer, steps.into())
    }

    /// Advances by communication steps. Returns, of each, the deepest overlap since the beginning and how many have arrived,
    /// and all frames, one after the other.
    ///
    /// # Errors
    /// Too many steps, or the engine refuses one; the run is then where it was before that one.
    pub fn advance(&mut self, steps: u32) -> Result<Reply, Refused> {
        require(steps <= MOST_STEPS, || format!("{steps} steps at once: at most {MOST_STEPS}"))?;
        let people = self.people();
        let columns = COLUMNS + self.loads.columns();
        require((8 * columns * people) as u64 * u64::from(steps) <= MOST_BYTES, || {
            format!("{steps} steps of {people} people at once have more than 100 MB")
        })?;
        self.check_work()?;
        let (mut bytes, mut advanced, mut overlap) = (Vec::new(), Advanced::default(), self.overlap);
        let loads = self.loads.clone();
        let mut add = |_: &Stepper, simulation: &mut Simulation, frames: Vec<Frame>, _| {
            let going = simulation.going()?;
            let world = simulation.world().expect("it has begun");
            for frame in &frames {
                bytes.extend(frame::bytes(frame, &going, &loads.numbers(frame, world)));
            }
            overlap = overlap.max(world.largest_overlap());
            advanced.overlaps.push(overlap);
            advanced.arrived.push(simulation.arrived()?);
            Ok::<_, Refused>(ControlFlow::Continue(()))
        };
        let done = self.advance_with(&mut add, steps);
        self.overlap = overlap;
        done?;
        Reply::with(advanced, bytes)
    }

    /// Checks that a communication step is not too much work for a page.
    ///
    /// # Errors
    /// It is.
    pub fn check_work(&self) -> Result<(), Refused> {
        let parameters = &self.loaded.trial.parameters;
        let mechanical = parameters.time_step / parameters.time_step_mechanical;
        let people = self.people();
        Ok(require(mechanical * people as f64 <= MOST_WORK, || {
            format!(
                "a TimeStep of {} s has {mechanical:.3e} mechanical steps: too many for a page with {people} people",
                parameters.time_step
            )
        })?)
    }

    /// Returns the present frame as pages keep it.
    ///
    /// # Errors
    /// No ways to exits and goals can be found.
    pub fn frame(&mut self) -> Result<Vec<u8>, Refused> {
        let (frame, going) = (self.simulation.frame(), self.simulation.going()?);
        Ok(frame::bytes(&frame, &going, &self.loads.numbers(&frame, self.world())))
    }

    /// Returns who presses whom in a frame of a time \[s\]: x, y \[m\] of one, x, y of the other or of the wall, and their
    /// force \[N\].
    ///
    /// # Errors
    /// It is not a frame of these people.
    pub fn forces(&self, bytes: &[u8], time: f64) -> Result<Reply, Refused> {
        let frame = Frame { time, ..frame::frame(bytes, self.people())? };
        let forces = self.pair_forces(&frame)?.into_iter();
        let numbers = forces.flat_map(|of| [of.from.x, of.from.y, of.to.x, of.to.y, of.normal_force]);
        Reply::with(serde_json::json!({}), numbers.flat_map(f64::to_le_bytes).collect())
    }

    /// The same for pictures.
    ///
    /// # Errors
    /// Too many people are at one place.
    pub fn pair_forces(&self, frame: &Frame) -> Result<Vec<PairForce>, Refused> {
        let mut replay = Replay::new(&self.loaded.trial)?;
        replay.put(frame)?;
        let poses: Vec<Pose> = frame.agents.iter().map(|motion| motion.pose).collect();
        Ok(replay.forces(&poses))
    }
}
