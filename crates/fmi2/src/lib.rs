//! The FMI 2.0 co-simulation interface of all FMUs of this repository.
//!
//! What an FMU simulates is a [`Model`]. Everything else that FMI requires is here. The modules; each imports only from
//! those above it:
//!
//! - [`variables`]: the table of variables, its types, units and GUID
//! - [`lifecycle`]: which function is allowed in which state, as data
//! - [`model`]: what a model must offer
//! - [`slave`]: one instance, with lifecycle, variables, stepping and states
//! - [`description`]: table -> `modelDescription.xml`
//! - [`location`]: resource URI -> directories
//! - [`archive`]: an `.fmu`, the same bytes for the same content
//! - [`component`]: the bodies of the C functions, which check pointers and return statuses
//! - [`export!`](crate::export): the 34 C functions for a model

pub mod archive;
pub mod component;
pub mod description;
mod export;
pub mod lifecycle;
pub mod location;
pub mod model;
pub mod slave;
pub mod variables;

pub use component::{CallbackFunctions, Status, silence_panics};
pub use lifecycle::Phase;
pub use model::{Model, StepError, fingerprint};
pub use slave::{Slave, SlaveError, Snapshot};
