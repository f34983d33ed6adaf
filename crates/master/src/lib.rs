//! A master for FMUs of FMI 2.0 and 3.0.
//!
//! It knows of an FMU only its model description, and couples several FMUs by SSP ([`ssp`]). [`RunSettings`] say what is run and how;
//! [`PreparedSystem`] is a run of an FMU or an SSP that is ready, with an example.

mod assemble;
mod bundled_library;
mod calls;
mod error;
mod file_type;
mod fmu;
mod instance;
mod messages;
pub mod notes;
mod prepared;
mod reference;
mod saved;
mod settings;
pub mod ssp;
mod system;
mod trial_input;
mod unzip;

pub use assemble::{Assembled, assemble};
pub use bundled_library::{binaries_beside, binary_beside, look_in, own_binary};
pub use calls::{FmiValue, FmuInstance, LARGEST_STATE};
pub use error::{MasterError, Result, require, whole};
pub use file_type::FileType;
pub use fmu::Fmu;
pub use instance::ValueSelection;
pub use prepared::{DriveFeed, PreparedSystem};
pub use reference::{Difference, Experiment, ReplayedExperiment, add_reference, replay};
pub use saved::{ComponentRecord, CrowdRecord, SavedRun, writers};
pub use settings::RunSettings;
pub use system::{System, SystemComponent};
pub use trial_input::{DecisionChoice, TrialInput, documents_of, pack, plan_in, plan_of};
