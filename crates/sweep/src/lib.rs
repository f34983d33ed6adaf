//! Parameter sweeps: many runs of one FMU with other parameters, on all processors.
//!
//! A [`Spec`] (`sweep.toml`) says what is run, which parameters take which values and what is measured of each
//! run. [`sweep`] simulates the points that a [`Directory`] does not hold yet and writes them as they come; one
//! that is killed goes on where it was. The directory is that of the Python package `lemons_fmu`, whose README
//! says it exactly.

mod directory;
mod measure;
mod points;
mod simulate;
mod spec;
mod sweep;

pub use directory::{Directory, Finished};
pub use measure::{Measure, Of, Take};
pub use points::{Points, Values};
pub use spec::Spec;
pub use sweep::{Progress, sweep};
