//! The record of a run: written, read, exported.
//!
//! One program for all of them: linking takes longer than compiling.

mod columns;
mod programs;
mod round_trip;
mod table;
mod trajectories;
mod written;
