//! Pictures and movies of runs: `lemons plot`, `lemons movie`.

mod measured;
pub mod movie;
pub mod plot;
mod quantity;
pub mod source;
pub mod style;
pub mod trial_run;
