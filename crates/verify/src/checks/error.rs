//! Why a figure cannot be measured.

use crowd_mechanics::engine::{AdvanceError, Crowded, ThreadsError};
use crowd_mechanics::pack::PackError;
use crowd_mechanics::setup::WorldError;
use lemons_core::files::WriteError;
use lemons_core::trial::Problems;
use std::io;

/// The result of a measurement.
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// Why a figure cannot be measured.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A case is not what it is made to be, so its figure would say nothing.
    #[error("is not so: {0}")]
    Premise(String),
    /// A world does not advance.
    #[error(transparent)]
    Advance(#[from] AdvanceError),
    /// Too many bodies are near each other.
    #[error(transparent)]
    Crowded(#[from] Crowded),
    /// Threads cannot be started.
    #[error(transparent)]
    Threads(#[from] ThreadsError),
    /// There is no world of a Trial.
    #[error(transparent)]
    World(#[from] WorldError),
    /// A Trial has errors.
    #[error(transparent)]
    Trial(#[from] Problems),
    /// A Trial cannot be packed.
    #[error(transparent)]
    Pack(#[from] PackError),
    /// Threads have led to other results.
    #[error("{name} {agents}: results differ with threads")]
    OtherResults {
        /// Name of the crowd.
        name: &'static str,
        /// Number of agents.
        agents: usize,
    },
    /// There is no run to take a median of.
    #[error("no run")]
    NoRun,
    /// The FMU refuses something.
    #[error(transparent)]
    Fmu(#[from] lemons_master::Error),
    /// The C entry point refuses the Trial's files.
    #[error("CrowdMechanics returned {0}")]
    CrowdMechanics(i32),
    /// The library of the C entry point cannot be loaded.
    #[error(transparent)]
    Library(#[from] libloading::Error),
    /// The reference cases cannot be read.
    #[error(transparent)]
    Cases(#[from] serde_json::Error),
    /// The files of a Trial cannot be written.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// A temporary file cannot be written.
    #[error(transparent)]
    Io(#[from] io::Error),
}

/// That a case is what it is made to be; else [`Error::Premise`].
macro_rules! ensure {
    ($so:expr, $($text:tt)*) => {
        let so: bool = $so;
        if !so {
            return Err($crate::checks::Error::Premise(format!($($text)*)));
        }
    };
}
pub(crate) use ensure;
