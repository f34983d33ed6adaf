//! The one loop of all runs: a model steps from one communication point to the next, until the run ends.
//!
//! A frame goes from the model to the condition that may end the run, and to the observer, which writes rows, adds to
//! measures, or keeps it.

use crate::clock::Clock;
use crate::error::SimError;
use crate::simulation::Simulation;
use crate::stop::StopCondition;
use lemons_results::Frame;
use lemons_results::measure::Leaving;
use std::ops::ControlFlow;

/// A model that a run steps: a Trial in memory, or FMUs.
pub trait RunModel {
    /// Error of a step.
    type Error;

    /// Steps to a communication point \[s\].
    ///
    /// # Errors
    /// It refuses the step, or fails.
    fn step_to(&mut self, time: f64) -> Result<(), Self::Error>;

    /// \[s\] Returns the last communication point.
    fn time(&self) -> f64;

    /// Returns its crowds at the last communication point.
    ///
    /// # Errors
    /// They cannot be read.
    fn frames(&self) -> Result<Vec<Frame>, Self::Error>;
}

impl RunModel for Simulation {
    type Error = SimError;

    fn step_to(&mut self, time: f64) -> Result<(), SimError> {
        Simulation::step_to(self, time)
    }

    fn time(&self) -> f64 {
        Simulation::time(self)
    }

    fn frames(&self) -> Result<Vec<Frame>, SimError> {
        Ok(vec![self.frame()])
    }
}

/// A communication point that is observed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PointKind {
    /// The first one: its rows are written, and there has been no step.
    Start,
    /// The point from which a saved run goes on: its rows are in the table of the run before.
    Resumed,
    /// The end of a step, whose rows are written.
    Written,
    /// The end of a step, whose squeeze goes into the next rows.
    Passed,
}

/// An observer of a run.
pub trait Observer<M: RunModel + ?Sized> {
    /// Error that ends the run.
    type Error: From<M::Error>;

    /// Prepares the step from the k-th communication point.
    fn before_step(&mut self, _model: &mut M, _k: u64) {}

    /// Sees the crowds at a communication point. After `Break` no further step is made.
    ///
    /// # Errors
    /// Those of the observer.
    fn see(
        &mut self,
        run: &Stepper,
        model: &mut M,
        frames: Vec<Frame>,
        kind: PointKind,
    ) -> Result<ControlFlow<()>, Self::Error>;
}

/// A function that sees each communication point.
impl<M: RunModel + ?Sized, E: From<M::Error>, F> Observer<M> for F
where
    F: FnMut(&Stepper, &mut M, Vec<Frame>, PointKind) -> Result<ControlFlow<()>, E>,
{
    type Error = E;

    fn see(
        &mut self,
        run: &Stepper,
        model: &mut M,
        frames: Vec<Frame>,
        kind: PointKind,
    ) -> Result<ControlFlow<()>, E> {
        self(run, model, frames, kind)
    }
}

/// The communication points of a run, when it ends, and how far it is.
pub struct Stepper {
    /// The communication points.
    pub clock: Clock,
    every: u64,
    stop: Option<StopCondition>,
    /// The point from which it goes on.
    first: u64,
    /// Steps that lead to the last communication point from the first one of the clock.
    steps: u64,
    /// Whether `stop` has ended it.
    stopped: bool,
}

impl Stepper {
    /// Begins at the first communication point, and ends at the last one or before, by a condition. One point in `every`
    /// is written.
    pub fn new(clock: Clock, every: u64, stop: Option<StopCondition>) -> Stepper {
        Stepper { clock, every, stop, first: 0, steps: 0, stopped: false }
    }

    /// Goes on from the `index`-th communication point of a saved run.
    #[must_use]
    pub fn from(self, index: u64) -> Stepper {
        Stepper { first: index, steps: index, ..self }
    }

    /// Shows the model, which has begun, to the observer, and makes all steps.
    ///
    /// # Errors
    /// Those of the model and of the observer.
    pub fn run<M: RunModel + ?Sized, O: Observer<M>>(
        &mut self,
        model: &mut M,
        observer: &mut O,
        kind: PointKind,
    ) -> Result<(), O::Error> {
        if self.observe(model, observer, kind)?.is_continue() {
            self.advance(model, observer, u64::MAX)?;
        }
        Ok(())
    }

    /// Makes at most so many steps, until the run is over or the observer breaks it off.
    ///
    /// # Errors
    /// Those of the model and of the observer.
    pub fn advance<M: RunModel + ?Sized, O: Observer<M>>(
        &mut self,
        model: &mut M,
        observer: &mut O,
        most: u64,
    ) -> Result<(), O::Error> {
        for _ in 0..most {
            if self.is_over() {
                break;
            }
            observer.before_step(model, self.steps);
            model.step_to(self.clock.end(self.steps))?;
            self.steps += 1;
            let written = self.steps.is_multiple_of(self.every);
            let kind = if written { PointKind::Written } else { PointKind::Passed };
            if self.observe(model, observer, kind)?.is_break() {
                break;
            }
        }
        Ok(())
    }

    /// Shows the present communication point to the condition and to the observer.
    ///
    /// # Errors
    /// Those of the model and of the observer.
    pub fn observe<M: RunModel + ?Sized, O: Observer<M>>(
        &mut self,
        model: &mut M,
        observer: &mut O,
        kind: PointKind,
    ) -> Result<ControlFlow<()>, O::Error> {
        let frames = model.frames()?;
        if let Some(stop) = &mut self.stop {
            let stepped = matches!(kind, PointKind::Written | PointKind::Passed);
            let over = stop.see(model.time(), &frames, stepped);
            self.stopped = over
                && match kind {
                    PointKind::Start | PointKind::Written => true,
                    PointKind::Resumed => false,
                    // A table has the frame in which all have left.
                    PointKind::Passed => !stop.have_left(),
                };
        }
        observer.see(self, model, frames, kind)
    }

    /// Returns how many steps were made.
    pub fn steps(&self) -> u64 {
        self.steps - self.first
    }

    /// Returns the last point that is one of every longer run: the last step may be a shorter one.
    pub fn index(&self) -> u64 {
        match self.steps.checked_sub(1) {
            Some(k) if self.clock.end(k) != self.clock.point(k + 1) => k,
            _ => self.steps,
        }
    }

    /// Returns whether the last step was made, or the run has ended before.
    pub fn is_over(&self) -> bool {
        self.stopped || self.steps >= self.clock.steps
    }

    /// Returns who leaves, of a run that ends when they have.
    pub fn leaving(&self) -> Option<&Leaving> {
        match &self.stop {
            Some(StopCondition::Left(leaving)) => Some(leaving),
            _ => None,
        }
    }
}
