//! Runs and couplings, beside loops written out here and another importer.
//!
//! One program for all of them: linking takes longer than compiling.

mod arrays;
#[path = "../../../../tests/coupling/controller.rs"]
mod controller;
mod coupling;
mod fmi_rs;
mod fmi_rs_3;
mod settings;
