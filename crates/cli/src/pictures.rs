//! Pictures and movies of runs: `lemons plot`, `lemons movie`.

pub mod look;
mod measured;
pub mod moment;
pub mod movie;
pub mod plot;
mod quantity;
mod series;
pub mod source;
mod spread;
