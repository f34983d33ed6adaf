//! Parameter sweeps: many runs of one FMU with different parameters, on all processors.
//!
//! A [`Spec`] (`sweep.toml`) gives the model, the values of the parameters and the measures. [`sweep`] simulates the
//! points that are not yet in a [`Directory`] and writes their results as they finish; a sweep that was killed
//! continues there. The directory has the format of the Python package `lemons_fmu`; its README describes it exactly.

mod directory;
mod error;
mod measure;
mod points;
mod simulate;
mod spec;
mod sweep;

pub use directory::{Directory, Finished};
pub use error::{Error, Result};
pub use measure::{Measure, Of, Take};
pub use points::{Points, Values};
pub use spec::Spec;
pub use sweep::{How, Progress, sweep};
