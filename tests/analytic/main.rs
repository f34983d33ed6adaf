//! The engine's behaviour in small scenes. What is measured against closed forms, conservation laws and
//! independent integrators stands in the table of `lemons verify` (crates/verify).

mod doors;
mod levels;
mod ramp;
mod shortlist;
mod slopes;
mod threads;
mod walls;
