//! Helpers for the tests, benches and fuzzers of several packages. No program contains them.
//!
//! - [`places`]: where the repository, its Trials and the shared data are; copies of directories
//! - [`pe`]: the header of a shared library for Windows
//! - [`fmi2`], [`fmi3`]: the FMI functions as an importer sees them, of a shared library or of a model, and a log

mod answer;
pub mod fmi2;
pub mod fmi3;
mod headers;
pub mod places;

pub use headers::pe;
pub use places::{copy_tree, repository, shared, trial_door, trial_push};
