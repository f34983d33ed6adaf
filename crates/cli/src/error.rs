//! Failures that have an exit code of their own, and how failures are told.

use anyhow::Result;

/// A Trial has errors; they have been printed.
#[derive(Debug, thiserror::Error)]
#[error("the Trial has errors")]
pub struct TrialHasErrors;

/// The options make no sense together; what clap cannot see.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct Misused(pub String);

/// Prints the errors of a Trial; any other error is returned as it is.
pub fn report_problems(error: lemons_master::Error) -> anyhow::Error {
    let lemons_master::Error::Broken { path, problems } = error else { return error.into() };
    note!("{problems}");
    note!("lemons: {} has errors", path.display());
    TrialHasErrors.into()
}

/// Returns what becomes of several files, each of which is put into its place whatever became of the others: the first error
/// counts, further ones are told.
pub fn and_then(done: Result<()>, next: Result<()>) -> Result<()> {
    match (done, next) {
        (Err(first), Err(second)) => {
            note!("lemons: {}", full_message(&second));
            Err(first)
        }
        (done, next) => done.and(next),
    }
}

/// An error with its causes; many of them say their cause themselves, which is not said again.
pub fn full_message(error: &anyhow::Error) -> String {
    let mut text = String::new();
    for cause in error.chain().map(ToString::to_string).filter(|cause| !cause.is_empty()) {
        if text.ends_with(&cause) {
            continue;
        }
        if !text.is_empty() {
            text += ": ";
        }
        text += &cause;
    }
    text
}
