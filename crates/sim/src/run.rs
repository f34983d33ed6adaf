//! The one loop of a run.

use crate::clock::Clock;
use std::ops::ControlFlow;

/// What steps from one communication point to the next: a Trial in memory, or FMUs.
pub trait Model {
    /// Why a step fails.
    type Error;

    /// Advances to a communication point \[s\].
    ///
    /// # Errors
    /// The model refuses the step, or fails.
    fn step_to(&mut self, time: f64) -> Result<(), Self::Error>;
}

/// A communication point that a run has come to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Point {
    /// How many steps lead there from the first point of the clock.
    pub steps: u64,
    /// \[s\]
    pub time: f64,
    /// Whether it is a point of every longer run: the last step may be a shorter one.
    pub regular: bool,
}

/// Steps from the `first`-th point of the clock to its end, or until `observe` breaks. It is called after each step.
///
/// # Errors
/// Those of the model, or of `observe`.
pub fn run<M: Model + ?Sized, E: From<M::Error>>(
    model: &mut M,
    clock: &Clock,
    first: u64,
    mut observe: impl FnMut(&mut M, Point) -> Result<ControlFlow<()>, E>,
) -> Result<ControlFlow<()>, E> {
    for k in first..clock.steps {
        let time = clock.end(k);
        model.step_to(time)?;
        let point = Point { steps: k + 1, time, regular: time == clock.point(k + 1) };
        if observe(model, point)?.is_break() {
            return Ok(ControlFlow::Break(()));
        }
    }
    Ok(ControlFlow::Continue(()))
}
