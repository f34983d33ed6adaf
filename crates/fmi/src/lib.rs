//! The co-simulation interface of all FMUs of this repository: FMI 2.0, and FMI 3.0 with arrays.
//!
//! An FMU simulates a [`Model`]. Everything else that FMI requires is here. The modules; each imports only from
//! those above it:
//!
//! - [`Version`], [`FmuFormat`]: the versions of FMI, and what can be chosen when an FMU is written
//! - [`variables`]: the rows of a model's table: name, type, causality, unit, domain, sizes; their elements (FMI 2.0)
//! - [`lifecycle`]: the states of an instance, and in which of them a version of FMI allows a function
//! - [`Answer`], [`Refusal`]: what calls return, or why not
//! - [`location`]: resource URI or path -> directories
//! - [`model`]: what a model must offer
//! - [`slave`]: one instance: lifecycle, variables, stepping and states
//! - `states`: the states that importers hold
//! - [`archive`]: an `.fmu`, the same bytes for the same content
//! - [`boundary`]: what all C functions share: pointers, messages, panics
//! - [`description`], [`documentation`]: the table as XML, and as HTML
//! - [`calls`], [`v2`], [`v3`]: the bodies of the C functions: of both versions, of one of them
//! - [`export_fmi2!`], [`export_fmi3!`]: the C functions for a model
//! - `testing` (feature `testing`): what an importer is, and whether a model keeps what it declares

mod answer;
#[cfg(feature = "archive")]
pub mod archive;
pub mod boundary;
pub mod calls;
pub mod description;
pub mod documentation;
mod format;
mod functions;
pub mod lifecycle;
pub mod location;
pub mod model;
pub mod slave;
mod states;
#[cfg(feature = "testing")]
pub mod testing;
pub mod v2;
pub mod v3;
pub mod variables;

pub use answer::{Answer, Refusal, Status, damaged, refuse};
pub use boundary::{LOG_CATEGORIES, Logger2, silence_panics};
pub use format::{FmuFormat, Naming, Version};
pub use lifecycle::{Function, Phase};
pub use model::{Model, Step, StepError, fingerprint, guid, instantiation_token, reference};
pub use slave::{Slave, Snapshot};
