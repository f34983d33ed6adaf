//! Parameter sweeps: many runs with different parameters, on all processors: of a Trial, alone or with the `decision.toml` by which
//! its people walk, or of several Trials.
//!
//! A [`Spec`] (`sweep.toml`) gives the model, the values of the parameters and the measures. [`sweep`] simulates the
//! points that are not yet in its [`SweepTable`] and appends their results as they finish; a sweep that was killed goes on
//! there.

mod accumulators;
mod error;
pub mod identity;
mod measure;
mod models;
mod output;
mod points;
mod population;
mod simulate;
mod spec;
mod summary;
mod sweep;
mod table;
mod threads;

pub use error::{Result, SweepError};
pub use models::{Models, SweepDecision, SweepModel, Template};
pub use points::{Points, SweepParameter};
pub use simulate::check_parameters;
pub use spec::Spec;
pub use summary::{check_over, summary};
pub use sweep::{Options, SweepProgress, Swept, sweep};
pub use table::{Finished, MeasuredValue, SweepTable};
pub use threads::{SimulatedPoints, in_threads};
