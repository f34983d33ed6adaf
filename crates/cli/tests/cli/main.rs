//! Tests that need more of the `lemons` command than its output: numbers that are computed again, signals, forged files.
//! Its output is in tests/cmd.
//!
//! One program for all of them: linking takes longer than compiling.

mod common;
mod coupling;
mod leaving;
#[cfg(unix)]
mod pages;
mod reference;
mod results;
mod scenarios;
#[cfg(unix)]
mod signals;
mod sweep;
mod version;
mod walked_sweep;
mod walking;
