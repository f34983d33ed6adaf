//! A run under way, and what is recorded of it.

use crate::simulation::{Simulation, refused};
use crowd_mechanics::engine::{World, Wrench, vec2};
use lemons_results::columns::{CONTACTS, Groups, MOTION, OF_STEP, Quantity, SQUEEZE};
use lemons_results::measure::{LATEST, Leaving, Over, REACH, STANDSTILL};
use lemons_sim::stop::places;
use lemons_sim::{Clock, Model, SimError};
use numpy::{IntoPyArray, PyArray, PyArray1, PyArray2, PyArray3, PyArrayMethods, PyReadonlyArray3};
use pyo3::exceptions::{PyMemoryError, PyValueError};
use pyo3::prelude::*;
use std::ops::ControlFlow;
use std::time::{Duration, Instant};

/// The real outputs of an agent, in the order of the last axis of their array: pose, velocity, squeeze.
pub const REALS: [Quantity; 10] = [
    MOTION[0], MOTION[1], MOTION[4], MOTION[2], MOTION[3], MOTION[5], SQUEEZE, OF_STEP[0], OF_STEP[1],
    OF_STEP[2],
];
/// How many numbers of contacts an agent has.
pub const COUNTS: usize = CONTACTS.len();

/// Names of the columns of a table, in their order; those of contacts and `active` among them.
pub fn table() -> Vec<String> {
    let all = Groups { contacts: true, of_step: true, active: true, totals: true };
    all.columns().into_iter().map(|column| column.name).collect()
}

/// Appends the outputs of everybody.
pub fn observe(world: &World, reals: &mut Vec<f64>, counts: &mut Vec<i32>) {
    let (state, contacts) = (world.state(), world.contacts());
    for (i, (pose, twist)) in state.poses.iter().zip(&state.twists).enumerate() {
        let (body, exposure) = (&contacts.bodies[i], &world.exposures()[i]);
        reals.extend([pose.position.x, pose.position.y, pose.orientation]);
        reals.extend([twist.velocity.x, twist.velocity.y, twist.angular_velocity, body.squeeze]);
        reals.extend([exposure.mean_force, exposure.peak_force, exposure.peak_overlap]);
        counts.extend([body.agent_contacts, body.wall_contacts, body.touching_bodies].map(|n| n as i32));
    }
}

/// A run: its communication points, what pushes people in it, when it ends, and its frames.
#[pyclass(module = "lemons_fmu._native")]
pub struct Recording {
    clock: Clock,
    /// Steps that were made.
    index: u64,
    people: usize,
    /// If it ends when people have left.
    leaving: Option<Leaving>,
    /// Of each step the pushes of these agents, if there are such.
    pushed: Vec<usize>,
    pushes: Vec<f64>,
    times: Vec<f64>,
    reals: Vec<f64>,
    counts: Vec<i32>,
    active: Vec<bool>,
}

/// A simulation whose agents are pushed before each step.
struct Pushed<'a> {
    simulation: &'a mut lemons_sim::Simulation,
    agents: &'a [usize],
    /// Of the steps that follow.
    pushes: std::slice::ChunksExact<'a, f64>,
}

impl Model for Pushed<'_> {
    type Error = SimError;

    fn step_to(&mut self, time: f64) -> Result<(), SimError> {
        let pushes = self.pushes.next().unwrap_or_default().chunks_exact(3);
        for (agent, push) in self.agents.iter().zip(pushes) {
            let push = Wrench { force: vec2(push[0], push[1]), torque: push[2] };
            self.simulation.push(*agent, push);
        }
        self.simulation.step_to(time)
    }
}

/// What was recorded: times, reals, counts, whether people are there.
type Arrays<'py> = (
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray3<f64>>,
    Bound<'py, PyArray3<i32>>,
    Bound<'py, PyArray2<bool>>,
);

#[pymethods]
impl Recording {
    /// Begins the record of a run until a time \[s\], with this communication step \[s\]; without a time, until everybody has
    /// left who has an exit. `whole`: it surely goes on until its time.
    #[new]
    fn new(simulation: &Simulation, until: Option<f64>, step: f64, whole: bool) -> PyResult<Recording> {
        let leave = simulation.leaving.iter().filter(|leaves| **leaves).count();
        if until.is_none() && leave == 0 {
            return Err(refused(
                "until='left': nobody can leave: people do not walk, or have no exits (give a time)",
            ));
        }
        let who = simulation.leaving.clone();
        let leaving = until.is_none().then(|| Leaving::of(leave).among(who));
        let simulation = &simulation.simulation;
        let clock = Clock::new(simulation.time(), step, until.unwrap_or(LATEST));
        let clock = clock.map_err(|error| PyValueError::new_err(error.to_string()))?;
        let people = simulation.ids().len();
        let mut recording = Recording {
            clock,
            index: 0,
            people,
            leaving,
            pushed: Vec::new(),
            pushes: Vec::new(),
            times: Vec::new(),
            reals: Vec::new(),
            counts: Vec::new(),
            active: Vec::new(),
        };
        if whole && recording.leaving.is_none() {
            recording.reserve()?;
        }
        recording.see(simulation);
        Ok(recording)
    }

    /// All communication points \[s\], from the first to the last.
    fn points<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        let steps = (0..self.clock.steps).map(|k| self.clock.end(k));
        let points: Vec<f64> = [self.clock.start].into_iter().chain(steps).collect();
        points.into_pyarray(py)
    }

    /// Pushes these agents in each step: shape (steps, agents, 3).
    fn push(&mut self, agents: Vec<usize>, pushes: PyReadonlyArray3<'_, f64>) -> PyResult<()> {
        (self.pushed, self.pushes) = (agents, pushes.as_slice()?.to_vec());
        Ok(())
    }

    /// The number of all steps, and of those that were made.
    #[getter]
    fn steps(&self) -> (u64, u64) {
        (self.clock.steps, self.index)
    }

    /// Whether the last step was made, or people have left.
    #[getter]
    fn is_over(&self) -> bool {
        self.index == self.clock.steps || self.over().is_some()
    }

    /// Whether all have left who were to leave.
    #[getter]
    fn have_left(&self) -> bool {
        self.over() == Some(Over::Left)
    }

    /// Why a run ends from which people were to leave who stay.
    fn why_some_stay(&self) -> Option<String> {
        let leaving = self.leaving.as_ref().filter(|_| !self.have_left())?;
        let (leave, left) = leaving.counts();
        let why = match self.over() {
            Some(_) => format!("in the last {STANDSTILL} s nobody has left or got further than {REACH} m"),
            None => "this is the latest end".to_owned(),
        };
        let time = self.times.last().copied().unwrap_or_default();
        let stay = leave.saturating_sub(left);
        Some(format!("{stay} of {leave} people have not left: {why}; the run ends at t = {time} s"))
    }

    /// Makes at most so many steps, for about so long \[s\].
    fn advance(
        &mut self,
        py: Python<'_>,
        simulation: &mut Simulation,
        most: u64,
        seconds: f64,
    ) -> PyResult<()> {
        py.detach(|| self.advance_for(&mut simulation.simulation, most, Duration::from_secs_f64(seconds)))
            .map_err(refused)
    }

    /// Gives what was recorded, without a copy.
    fn finish<'py>(&mut self, py: Python<'py>) -> PyResult<Arrays<'py>> {
        let (frames, people) = (self.times.len(), self.people);
        Ok((
            taken(py, &mut self.times),
            taken(py, &mut self.reals).reshape([frames, people, REALS.len()])?,
            taken(py, &mut self.counts).reshape([frames, people, COUNTS])?,
            taken(py, &mut self.active).reshape([frames, people])?,
        ))
    }
}

/// An array that owns these values.
fn taken<'py, T: numpy::Element>(py: Python<'py>, values: &mut Vec<T>) -> Bound<'py, PyArray<T, numpy::Ix1>> {
    std::mem::take(values).into_pyarray(py)
}

impl Recording {
    fn over(&self) -> Option<Over> {
        self.leaving.as_ref().and_then(Leaving::over)
    }

    /// Makes room for all frames.
    fn reserve(&mut self) -> PyResult<()> {
        let all =
            usize::try_from(self.clock.steps + 1).ok().and_then(|frames| frames.checked_mul(self.people));
        let reserved = all.is_some_and(|rows| {
            rows.checked_mul(REALS.len()).is_some_and(|reals| self.reals.try_reserve_exact(reals).is_ok())
                && self.counts.try_reserve_exact(rows * COUNTS).is_ok()
                && self.active.try_reserve_exact(rows).is_ok()
        });
        if reserved {
            return Ok(());
        }
        let (steps, people) = (self.clock.steps, self.people);
        Err(PyMemoryError::new_err(format!("the memory does not hold {steps} steps of {people} people")))
    }

    fn advance_for(
        &mut self,
        simulation: &mut lemons_sim::Simulation,
        most: u64,
        time: Duration,
    ) -> Result<(), SimError> {
        let (begin, clock, first) = (Instant::now(), self.clock, self.index);
        let (agents, pushes) = (std::mem::take(&mut self.pushed), std::mem::take(&mut self.pushes));
        let of_step = 3 * agents.len().max(1);
        let mut rest = pushes.chunks_exact(of_step);
        if first > 0 {
            rest.nth(first as usize - 1);
        }
        let mut pushed = Pushed { simulation, agents: &agents, pushes: rest };
        let done = lemons_sim::run::<_, SimError>(&mut pushed, &clock, first, |pushed, point| {
            self.index = point.steps;
            self.see(pushed.simulation);
            let enough = point.steps - first >= most || begin.elapsed() >= time;
            Ok(if enough || self.is_over() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) })
        });
        (self.pushed, self.pushes) = (agents, pushes);
        done.map(drop)
    }

    /// Records the present communication point.
    fn see(&mut self, simulation: &lemons_sim::Simulation) {
        let Some(world) = simulation.world() else { return };
        self.times.push(simulation.time());
        observe(world, &mut self.reals, &mut self.counts);
        self.active.extend(world.present());
        if let Some(leaving) = &mut self.leaving {
            leaving.see(simulation.time(), &places(&simulation.frame()));
        }
    }
}
