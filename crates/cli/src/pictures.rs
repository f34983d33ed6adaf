//! Pictures and movies of runs: `lemons plot`, `lemons movie`.

mod look;
mod measured;
mod moment;
pub mod movie;
pub mod plot;
mod series;
mod source;
mod spread;
