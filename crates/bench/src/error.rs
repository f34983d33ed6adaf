//! Why something cannot be measured.

use crowd_mechanics::engine::{AdvanceError, ThreadsError};
use crowd_mechanics::pack::PackError;
use lemons_files::WriteError;
use lemons_trial::Problems;
use std::io;

/// The result of a measurement.
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// Why something cannot be measured.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A crowd does not advance.
    #[error(transparent)]
    Advance(#[from] AdvanceError),
    /// A scene cannot be made.
    #[error(transparent)]
    Scene(#[from] lemons_verify::Error),
    /// Threads cannot be started.
    #[error(transparent)]
    Threads(#[from] ThreadsError),
    /// Threads have led to other results.
    #[error("{name} {agents}: results differ with threads")]
    OtherResults {
        /// Of the case.
        name: &'static str,
        /// How many there are.
        agents: usize,
    },
    /// The FMU refuses something.
    #[error(transparent)]
    Fmu(#[from] lemons_master::Error),
    /// A run cannot be prepared.
    #[error(transparent)]
    Prepare(#[from] lemons_master::PrepareError),
    /// A Trial has errors.
    #[error(transparent)]
    Trial(#[from] Problems),
    /// A Trial cannot be packed.
    #[error(transparent)]
    Pack(#[from] PackError),
    /// The files of a Trial cannot be written.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// A temporary file cannot be written.
    #[error(transparent)]
    Io(#[from] io::Error),
    /// A median of nothing.
    #[error("no run")]
    NoRun,
}
