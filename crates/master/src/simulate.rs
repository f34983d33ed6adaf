//! The one loop of a run: whoever makes a run drives, steps and looks in this order, at these times.

use crate::clock::Clock;
use crate::error::{Error, Result};
use crate::instance::Instance;
use crate::pushes::{Inputs, Pushes};
use crate::system::System;
use std::ops::ControlFlow;

/// What can be stepped: an instance of one FMU, or coupled ones.
pub trait Stepped {
    /// Gives inputs of the crowd the values of a drive, for the steps from now on. To what another component feeds them,
    /// they are added.
    ///
    /// # Errors
    /// The FMU refuses the call.
    fn push(&mut self, inputs: &Inputs, values: &[f64]) -> Result<()>;

    /// From a communication point to the next \[s\].
    ///
    /// # Errors
    /// An FMU's refusal or failure.
    fn step(&mut self, from: f64, to: f64) -> Result<()>;
}

impl Stepped for Instance {
    fn push(&mut self, inputs: &Inputs, values: &[f64]) -> Result<()> {
        self.set_real(&inputs.selection, values)
    }

    fn step(&mut self, from: f64, to: f64) -> Result<()> {
        Instance::step(self, from, to - from)
    }
}

impl Stepped for System {
    fn push(&mut self, inputs: &Inputs, values: &[f64]) -> Result<()> {
        self.push_crowd(inputs, values)
    }

    fn step(&mut self, _: f64, to: f64) -> Result<()> {
        self.step_to(to)
    }
}

/// A communication point that a run has come to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reached {
    /// How many steps lead there from the first point of the clock.
    pub steps: u64,
    /// \[s\]
    pub time: f64,
    /// Whether it is a point of every longer run: the last step may be a shorter one.
    pub regular: bool,
}

/// Who looks at a run.
pub trait Observer<S: Stepped> {
    /// What can end a run: an FMU, or something of the observer's own.
    type Error: From<Error>;

    /// Before each step, whether the run goes on.
    fn goes_on(&mut self, _stepped: &S) -> bool {
        true
    }

    /// After a step.
    ///
    /// # Errors
    /// Whatever ends the run.
    fn look(&mut self, stepped: &mut S, reached: Reached) -> Result<(), Self::Error>;
}

/// Steps from the `first`-th point of the clock to its end, which the last step is shortened to, or until the observer
/// ends the run: then `Break`. What is stepped is initialized, and at that point.
///
/// # Errors
/// An FMU's refusal or failure, or the observer's.
pub fn simulate<S: Stepped, O: Observer<S>>(
    stepped: &mut S,
    clock: &Clock,
    first: u64,
    pushes: &Pushes,
    observer: &mut O,
) -> Result<ControlFlow<()>, O::Error> {
    for k in first..clock.steps {
        if !observer.goes_on(stepped) {
            return Ok(ControlFlow::Break(()));
        }
        let (from, to) = (clock.point(k), clock.end(k));
        let values = pushes.at(from);
        if !values.is_empty() {
            stepped.push(pushes.inputs(), &values)?;
        }
        stepped.step(from, to)?;
        let regular = to == clock.point(k + 1);
        observer.look(stepped, Reached { steps: k + 1, time: to, regular })?;
    }
    Ok(ControlFlow::Continue(()))
}
