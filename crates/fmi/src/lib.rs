//! The co-simulation interface of all FMUs of this repository: FMI 2.0, and FMI 3.0 with arrays.
//!
//! What an FMU simulates is a [`Model`]. Everything else that FMI requires is here. The modules; each imports only from
//! those above it:
//!
//! - [`variables`]: what a variable is: type, causality, unit, domain
//! - [`lifecycle`]: the states of an instance
//! - [`location`]: resource URI or path -> directories
//! - [`model`]: what a model must offer
//! - [`slave`]: one instance: lifecycle, stepping and states
//! - `states`: the states that importers hold
//! - [`archive`]: an `.fmu`, the same bytes for the same content
//! - `units`: units in model descriptions
//! - `boundary`: what all C functions share: pointers, messages, panics
//! - `export`: what the macros that export C functions share
//! - [`v2`] and [`v3`]: what differs between the versions: the variables of an instance, the model description, the C
//!   functions
//! - [`Format`]: which of them is written

pub mod archive;
mod boundary;
mod export;
mod format;
pub mod lifecycle;
pub mod location;
pub mod model;
pub mod slave;
mod states;
mod units;
pub mod v2;
pub mod v3;
pub mod variables;

pub use boundary::{LOG_CATEGORIES, Logger2, Status, silence_panics};
pub use format::Format;
pub use lifecycle::{Function, Phase};
pub use model::{Model, StepError, fingerprint};
pub use slave::{SlaveError, Snapshot};

use model::token;
