//! Errors of a Trial, printed.

use crate::error::TrialHasErrors;
use anyhow::Result;
use lemons_core::trial::{Problems, Trial};
use lemons_master::{Error, TrialInput};
use std::path::Path;

/// Prints the errors of a Trial; any other error is returned as it is.
pub fn report_problems(error: Error) -> anyhow::Error {
    match error {
        Error::Broken { path, problems } => report_broken(&path, &problems),
        error => error.into(),
    }
}

/// Reads a Trial with its warnings. Errors are printed.
pub fn read_or_report(given: &TrialInput) -> Result<(Trial, Problems)> {
    given.read().map_err(|problems| report_broken(given.path(), &problems))
}

/// Prints the errors of a Trial.
pub fn report_broken(path: &Path, problems: &Problems) -> anyhow::Error {
    note!("{problems}");
    note!("lemons: {} has errors", path.display());
    TrialHasErrors.into()
}
