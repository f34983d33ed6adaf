//! The shared library of the crowd's FMU, and all of `lemons_crowd` for programs in Rust: the C functions of FMI 2.0 and
//! FMI 3.0, and the C entry point of the paper's scripts.
//!
//! It is a separate crate: the library of another FMU that has a crowd in it would have each function twice.

pub mod c_api;
pub mod fmi2;
pub mod fmi3;

pub use lemons_crowd::*;
