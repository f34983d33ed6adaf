//! From a Trial's documents to the engine's world and back, and warnings about the Trial.

mod advice;
mod plausible;
mod steps;
mod usual;
mod within;
mod world;

pub use steps::{FINEST_ACCURACY, Steps};
pub use usual::{doubts_of_drive, reasons};
pub use world::{WorldError, dynamics_of, interactions_of};

use lemons_core::files::source::{FileSource, LocalFiles};
use lemons_core::trial::{FileNames, Problems, Trial};
use std::ops::Deref;
use std::path::Path;

/// A Trial, prepared for the engine.
#[derive(Debug, Clone, Copy)]
pub struct Setup<'a>(&'a Trial);

impl<'a> Setup<'a> {
    /// Prepares a Trial.
    pub fn of(trial: &'a Trial) -> Setup<'a> {
        Setup(trial)
    }
}

impl Deref for Setup<'_> {
    type Target = Trial;

    fn deref(&self) -> &Trial {
        self.0
    }
}

/// Reads and checks a Trial directory. Returns the Trial and all warnings, including those about its mechanics.
///
/// # Errors
/// All errors in its files, or more people at one place than can be simulated.
pub fn read(directory: &Path) -> Result<(Trial, Problems), Problems> {
    read_from(&LocalFiles, directory, &FileNames::default())
}

/// Like [`read`], from these files, with these names.
///
/// # Errors
/// Those of [`read`].
pub fn read_from(
    files: &dyn FileSource,
    directory: &Path,
    names: &FileNames,
) -> Result<(Trial, Problems), Problems> {
    let (trial, mut problems) = Trial::read_from(files, directory, names)?;
    problems.extend(Setup::of(&trial).advice(&trial.places(names)));
    if problems.has_errors() { Err(problems) } else { Ok((trial, problems)) }
}
