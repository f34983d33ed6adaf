//! One simulation of a Trial: its documents become a world, a decision and a drive, which step from one communication
//! point to the next. Whoever simulates a Trial uses it: the command, sweeps, pictures, the lab and Python. Nothing here
//! reads or writes files, and all of it builds for WebAssembly. SI units.
//!
//! - [`Simulation`]: the Trial's crowd, and who decides where its people walk, coupled as their FMUs are
//! - [`settings`]: parameters by the names of their FMUs' variables
//! - [`Clock`]: the communication points to which a run steps
//! - [`Stepper`]: the loop of a run, with a model and an observer
//! - [`lint`]: what is probably not meant where people walk, in a drive, and at the end of a run
//! - [`exposure`]: greatest squeeze and overlap, and what passes between two rows of a table
//! - [`Replay`]: the contacts of a Trial's agents in the frames of a run
//! - [`stop`]: when a run ends

mod clock;
mod error;
pub mod exposure;
pub mod lint;
mod replay;
pub mod settings;
mod simulation;
mod stepper;
pub mod stop;
mod variables;

pub use clock::{Clock, ClockError};
pub use error::SimError;
pub use exposure::{ExposureSum, Extremes, Greatest};
pub use replay::Replay;
pub use simulation::{Algorithm, Documents, Exchange, Simulation};
pub use stepper::{Observer, PointKind, RunModel, Stepper};
pub use stop::{StopCondition, Until};
