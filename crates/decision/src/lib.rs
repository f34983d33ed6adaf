//! Where people want to go, as an FMU, FMI 2.0 or 3.0: the paper's eq. 4 with way-points, ways around walls to exits and
//! goals, and models of walking (docs/walking.md).
//!
//! ```text
//! Fp = m v* / t_transl + F        Mp = −I δθ / t_rot²
//! ```
//!
//! (Dufour, Stapelle, Nicolas: *LEMONS*, eq. 4). In the paper `v*` is the desired speed towards the next way-point and
//! `F` is zero; models of walking give others. `δθ` is the angle from the direction to the gaze, in (−π, π]. After the
//! last way-point the drive is zero.
//!
//! Poses are inputs, drives are outputs, and whether somebody has not left. They have the same names as in the crowd's
//! FMU, so that the two can be connected by name. The modules; each imports only from those above it:
//!
//! - [`rule`]: eq. 4 and the way-points
//! - [`field`]: how far it is around walls
//! - [`target`]: exits and goals
//! - [`stuck`]: what people do who are stuck
//! - [`exit_choice`]: exits chosen by the expected time
//! - [`error`]: what is wrong with a `decision.toml`
//! - `cells`: who and which walls are near somebody
//! - [`balance`]: legs under those who stand
//! - [`walking_model`]: how people walk among others
//! - [`spread`]: numbers that differ from person to person
//! - [`queue`]: people who wait press those in front
//! - [`config`]: `decision.toml`, what a user wrote
//! - [`plan`]: what it becomes, for each agent of a Trial
//! - [`decision`]: the model of the FMU; [`decision::quantities`]: its variables
//!   in FMI 2.0 and 3.0
//! - [`pack`]: writes an `.fmu` from a Trial, a plan and binaries

pub mod balance;
mod cells;
pub mod config;
pub mod decision;
mod door;
pub mod error;
pub mod exit_choice;
pub mod field;
pub mod pack;
pub mod plan;
pub mod queue;
pub mod rule;
pub mod source;
pub mod spread;
pub mod stuck;
pub mod target;
pub mod walking_model;

pub use config::{
    AgentConfig, BalanceName, DECISION_FILE, DecisionConfig, GroupsConfig, TargetConfig, WayConfig,
};
pub use decision::Decision;
pub use error::{ALL as SENTENCES, PlanError};
pub use plan::{DEFAULT_SPEED, Plan};
pub use spread::Spread;
pub use walking_model::WalkingModelName;
