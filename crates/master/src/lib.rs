//! A master for FMUs of FMI 2.0 and 3.0, and runs without a command line.
//!
//! It knows of an FMU only its model description, and couples several FMUs by SSP. [`Settings`] say what is run and how:
//! a Trial, an FMU or an SSP; a Trial whose people walk is coupled with its Decision FMU. [`Prepared`] is a run that is ready, with an example; [`simulate()`] is its loop.

mod assemble;
mod calls;
mod channel;
mod clock;
mod decider;
mod error;
mod extremes;
mod fmu;
mod given;
mod instance;
mod kind;
mod library;
mod messages;
mod model;
mod own;
mod prepared;
mod progress;
mod pushes;
mod refusal;
mod saved;
mod selection;
mod settings;
mod simulate;
mod state;
mod system;
mod unzip;

pub use assemble::{Assembled, assemble};
pub use calls::{Answer, CallError};
pub use clock::{Clock, ClockError};
pub use decider::{PlanChoice, plan_in, plan_of};
pub use error::{Error, Result, SavedError, whole};
pub use extremes::{Extremes, Greatest, Since};
pub use fmu::{Fmu, Platform, meant, named};
pub use given::{Given, pack};
pub use instance::Instance;
pub use kind::{Kind, Unexpected};
pub use library::{LibraryError, check_library, glibc_needed};
pub use model::{Model, Part};
pub use own::{binaries_beside, binary_beside, own_binary};
pub use prepared::Prepared;
pub use progress::{Kept, Progress};
pub use pushes::{Inputs, Pushes};
pub use refusal::{PrepareError, Warning};
pub use saved::{ComponentRecord, CrowdRecord, Saved, wiring_of, writers};
pub use selection::Selection;
pub use settings::Settings;
pub use simulate::{Observer, Reached, Stepped, simulate};
pub use state::{LARGEST_STATE, State};
pub use system::{Algorithm, Component, System};
pub use unzip::{UnzipError, unzip_trial};

use std::time::Duration;

/// Of a user who wants to stop: steps under way that take longer are given up.
pub const PATIENCE: Duration = Duration::from_millis(500);
