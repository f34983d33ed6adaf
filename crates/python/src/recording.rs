//! A run under way, and what is recorded of it.

use crate::arrays::{append, numbers_of_each};
use crate::model::{FindingRow, found};
use crate::simulation::{PySimulation, check_finite, check_shape, condition, in_order, refused, until_of};
use crowd_mechanics::engine::{Wrench, vec2};
use lemons_decision::Plan;
use lemons_results::Frame;
use lemons_results::measure::Over;
use lemons_sim::lint::RunEnd;
use lemons_sim::{Clock, Observer, PointKind, SimError, Stepper};
use numpy::{IntoPyArray, PyArray1, PyArray3, PyArrayMethods, PyReadonlyArray3, PyUntypedArrayMethods};
use pyo3::exceptions::{PyIndexError, PyMemoryError, PyValueError};
use pyo3::prelude::*;
use std::ops::ControlFlow;
use std::time::{Duration, Instant};

/// A duration \[s\] as Python gives it.
pub fn duration(seconds: f64) -> PyResult<Duration> {
    Duration::try_from_secs_f64(seconds)
        .map_err(|error| PyValueError::new_err(format!("a duration of {seconds:?} s: {error}")))
}

/// A run: when it ends, and what is recorded of it.
#[pyclass(module = "lemons_fmu._native")]
pub struct Recording {
    run: Stepper,
    recorded: Recorded,
}

/// Frames of a run as arrays, and what pushes people in it.
struct Recorded {
    people: usize,
    /// How many numbers an agent has.
    each: usize,
    /// Of each step the pushes of these agents, if there are such.
    pushed: Vec<usize>,
    pushes: Vec<f64>,
    times: Vec<f64>,
    /// Those of each agent at each of these times.
    numbers: Vec<f64>,
    /// Time at which Python is to be heard again.
    pause: Option<Instant>,
    end: RunEnd,
}

impl Observer<lemons_sim::Simulation> for Recorded {
    type Error = SimError;

    fn before_step(&mut self, simulation: &mut lemons_sim::Simulation, k: u64) {
        let mut of_steps = self.pushes.chunks_exact(3 * self.pushed.len().max(1));
        let pushes = of_steps.nth(k as usize).unwrap_or_default().chunks_exact(3);
        for (agent, push) in self.pushed.iter().zip(pushes) {
            simulation.push(*agent, Wrench { force: vec2(push[0], push[1]), torque: push[2] });
        }
    }

    fn see(
        &mut self,
        _: &Stepper,
        _: &mut lemons_sim::Simulation,
        frames: Vec<Frame>,
        _: PointKind,
    ) -> Result<ControlFlow<()>, SimError> {
        for frame in frames {
            self.times.push(frame.time);
            append(&frame, &mut self.numbers);
            self.end.see(frame);
        }
        let pauses = self.pause.is_some_and(|pause| Instant::now() >= pause);
        Ok(if pauses { ControlFlow::Break(()) } else { ControlFlow::Continue(()) })
    }
}

#[pymethods]
impl Recording {
    /// Begins the record of a run until a time \[s\], with this communication step \[s\]; without a time, until everybody has
    /// left who has an exit. `whole`: it surely goes on until its time.
    #[new]
    fn new(simulation: &mut PySimulation, until: Option<f64>, step: f64, whole: bool) -> PyResult<Recording> {
        let until = until_of(until);
        let stop = condition(until, simulation.plan.as_ref().map(Plan::leaving).unwrap_or_default())?;
        let simulation = &mut simulation.simulation;
        simulation.world().ok_or_else(|| refused(SimError::NotBegun))?;
        let clock = Clock::new(simulation.time(), step, until.latest());
        let clock = clock.map_err(|error| PyValueError::new_err(error.to_string()))?;
        let mut recorded = Recorded {
            people: simulation.ids().len(),
            each: numbers_of_each(&simulation.frame()),
            pushed: Vec::new(),
            pushes: Vec::new(),
            times: Vec::new(),
            numbers: Vec::new(),
            pause: None,
            end: RunEnd::default(),
        };
        if whole && stop.is_none() {
            recorded.reserve(clock.steps)?;
        }
        let mut run = Stepper::new(clock, 1, stop);
        let seen = run.observe(simulation, &mut recorded, PointKind::Start);
        seen.map(|_| Recording { run, recorded }).map_err(refused)
    }

    /// All communication points \[s\], from the first to the last.
    fn points<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let Clock { start, steps, .. } = self.run.clock;
        let mut points = Vec::new();
        points
            .try_reserve_exact(steps as usize + 1)
            .map_err(|_| PyMemoryError::new_err(format!("the memory does not hold {steps} steps")))?;
        points.push(start);
        points.extend(self.run.clock.points(0));
        Ok(points.into_pyarray(py))
    }

    /// Pushes these agents in each step: shape (steps, agents, 3).
    fn push(&mut self, agents: Vec<usize>, pushes: PyReadonlyArray3<'_, f64>) -> PyResult<()> {
        let people = self.recorded.people;
        if let Some(agent) = agents.iter().find(|agent| **agent >= people) {
            return Err(PyIndexError::new_err(format!("agent {agent}: there are {people} agents")));
        }
        check_shape(pushes.shape(), &[self.run.clock.steps as usize, agents.len(), 3])?;
        let pushes = in_order(&pushes);
        check_finite(&pushes, |k| agents[k % agents.len()])?;
        (self.recorded.pushed, self.recorded.pushes) = (agents, pushes);
        Ok(())
    }

    /// The number of all steps, and of those that were made.
    #[getter]
    fn steps(&self) -> (u64, u64) {
        (self.run.clock.steps, self.run.steps())
    }

    /// Whether the last step was made, or people have left.
    #[getter]
    fn is_over(&self) -> bool {
        self.run.is_over()
    }

    /// Whether all have left who were to leave.
    #[getter]
    fn have_left(&self) -> bool {
        self.run.leaving().is_some_and(|leaving| leaving.over() == Some(Over::Left))
    }

    /// Why a run ends from which people were to leave who stay.
    fn why_some_stay(&self) -> Option<String> {
        self.run.leaving()?.why_some_stay(*self.recorded.times.last()?)
    }

    /// Returns what is found at the end of a run; `whole`: it began with the crowd.
    fn findings(&self, simulation: &PySimulation, whole: bool) -> Vec<FindingRow> {
        let world = simulation.simulation.world();
        let forces: Option<Vec<_>> = world.map(|world| world.drive.iter().map(|drive| drive.force).collect());
        let all = simulation
            .plan
            .iter()
            .flat_map(|plan| self.recorded.end.findings(plan, forces.as_deref(), whole));
        all.map(|problem| found(&problem)).collect()
    }

    /// Makes at most so many steps, for about so long \[s\].
    fn advance(
        &mut self,
        py: Python<'_>,
        simulation: &mut PySimulation,
        most: u64,
        seconds: f64,
    ) -> PyResult<()> {
        let own = &mut simulation.simulation;
        if own.ids().len() != self.recorded.people {
            return Err(refused("the run is that of another simulation"));
        }
        let Recording { run, recorded } = self;
        recorded.pause = Instant::now().checked_add(duration(seconds)?);
        py.detach(|| run.advance(own, recorded, most)).map_err(refused)
    }

    /// Gives what was recorded, without a copy: times, and the numbers of all agents.
    #[allow(clippy::type_complexity)] // two arrays
    fn finish<'py>(
        &mut self,
        py: Python<'py>,
    ) -> PyResult<(Bound<'py, PyArray1<f64>>, Bound<'py, PyArray3<f64>>)> {
        let Recorded { people, each, times, numbers, .. } = &mut self.recorded;
        let shape = [times.len(), *people, *each];
        let (times, numbers) = (std::mem::take(times), std::mem::take(numbers));
        Ok((times.into_pyarray(py), numbers.into_pyarray(py).reshape(shape)?))
    }
}

impl Recorded {
    /// Makes room for all frames.
    fn reserve(&mut self, steps: u64) -> PyResult<()> {
        let (people, frames) = (self.people, usize::try_from(steps + 1).ok());
        let all = frames.and_then(|frames| frames.checked_mul(self.each)?.checked_mul(people));
        if all.is_some_and(|all| self.numbers.try_reserve_exact(all).is_ok()) {
            return Ok(());
        }
        Err(PyMemoryError::new_err(format!("the memory does not hold {steps} steps of {people} people")))
    }
}
