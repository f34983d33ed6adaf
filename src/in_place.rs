//! Steps of a Trial in its own files, as the paper's scripts make them (section 4.5).
//!
//! Each call reads the XML files, advances one `TimeStep` and writes `AgentDynamics.xml` and
//! `AgentInteractions.xml` back. Nothing is kept between calls: changed files are read again, and another call may name
//! another directory. Numbers are written such that the same double is read back.

use crate::model::output;
use crate::setup::{self, Setup, WorldError};
use lemons_core::files::source::LocalFiles;
use lemons_core::files::{WriteError, change_all};
use lemons_core::trial::{FileNames, Problems};
use std::path::Path;
use thiserror::Error;

/// Why a call failed. No file has changed.
#[derive(Debug, Error)]
#[allow(missing_docs)] // the messages say it
pub enum CallError {
    #[error("{0}")]
    Trial(Problems),
    #[error(transparent)]
    World(#[from] WorldError),
    #[error("{0}")]
    Advance(String),
    #[error(transparent)]
    Write(#[from] WriteError),
}

/// Advances the Trial that these files make by one `TimeStep`.
///
/// `parameters` is a path; the others are names in the directories that it gives, which are relative to
/// the directory of `parameters`.
///
/// # Errors
/// Something cannot be read, computed or written. Then no file has changed.
pub fn advance_files(parameters: &Path, names: &FileNames) -> Result<(), CallError> {
    let directory = parameters.parent().unwrap_or(Path::new(""));
    let (trial, _) = setup::read_from(&LocalFiles, directory, names).map_err(CallError::Trial)?;
    let mut world = Setup::of(&trial).world()?;
    world
        .advance(trial.parameters.time_step)
        .map_err(|error| CallError::Advance(Setup::of(&trial).name_body(&error)))?;
    Setup::of(&trial).carry_over_links(&mut world)?;
    let FileNames { dynamics, interactions, .. } = trial.places(names);
    Ok(change_all(&output(&trial, &world, dynamics, interactions))?)
}
