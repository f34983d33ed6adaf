//! The other side of the boundary, for tests and fuzzers of models. No program contains it.
//!
//! - [`functions`]: the FMI functions as an importer sees them, of a shared library or of a model
//! - [`instance`]: an instance of either version, with its messages
//! - [`bounds`]: whether a model keeps the bounds that it declares
//! - [`dependencies`]: what moves when a known number is changed, beside what a model declares

#![allow(unsafe_code)] // the C boundary, from the other side

pub mod bounds;
pub mod dependencies;
pub mod functions;
pub mod instance;

pub use crate::Version;
pub use functions::{fmi2, fmi3};
pub use instance::{LoggedMessage, TestInstance};
