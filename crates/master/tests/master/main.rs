//! Runs and couplings, beside loops written out here and another importer.
//!
//! One program for all of them: linking takes longer than compiling.

mod coupling;
mod fmi_rs;
mod fmi_rs_3;
mod settings;
