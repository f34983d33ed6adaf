//! A master for FMUs of FMI 2.0 and 3.0.
//!
//! It knows of an FMU only its model description, and couples several FMUs by SSP ([`ssp`]). [`Settings`] say what is run and how;
//! [`Prepared`] is a run of an FMU or an SSP that is ready, with an example.

mod assemble;
mod calls;
mod channel;
mod decider;
mod error;
mod fmu;
mod given;
mod instance;
mod kind;
mod messages;
mod own;
mod prepared;
mod pushes;
mod refusal;
mod saved;
mod selection;
mod settings;
pub mod ssp;
mod state;
mod system;
mod unzip;

pub use assemble::{Assembled, assemble};
pub use calls::{Answer, CallError, Value};
pub use decider::{PlanChoice, plan_in, plan_of};
pub use error::{Error, Result, SavedError, whole};
pub use fmu::Fmu;
pub use given::{Given, documents_of, pack};
pub use instance::Instance;
pub use kind::{Kind, Unexpected};
pub use own::{binaries_beside, binary_beside, look_in, own_binary};
pub use prepared::{Prepared, read_saved};
pub use pushes::Pushes;
pub use refusal::{PrepareError, Warning};
pub use saved::{ComponentRecord, CrowdRecord, Saved, wiring_of, writers};
pub use selection::Selection;
pub use settings::Settings;
pub use state::{LARGEST_STATE, State};
pub use system::{Component, System};
