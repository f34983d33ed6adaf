//! The `lemons` command as its users meet it.
//!
//! One program for all of them: linking takes longer than compiling.

mod accuracy;
mod checks;
mod command;
mod common;
mod coupling;
mod fmi3;
mod leaving;
#[cfg(unix)]
mod outputs;
mod people;
mod pictures;
mod reference;
mod results;
mod rooms;
mod sweep;
mod version;
mod walked_sweep;
mod walking;
