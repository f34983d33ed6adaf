//! Failures that have an exit code of their own, and the text of a failure.

use anyhow::Result;
/// Options that make no sense together, which clap cannot see.
pub use lemons_master::MasterError::Misused;

/// A Trial has errors; they have been printed.
#[derive(Debug, thiserror::Error)]
#[error("the Trial has errors")]
pub struct TrialHasErrors;

/// Combines the results of writing two files, each of which is written whatever became of the other: the first error
/// is returned, the second one is printed.
pub fn and_then(done: Result<()>, next: Result<()>) -> Result<()> {
    match (done, next) {
        (Err(first), Err(second)) => {
            note!("lemons: {}", full_message(&second));
            Err(first)
        }
        (done, next) => done.and(next),
    }
}

/// Returns an error with its causes. Many of them contain the text of their cause, which is not repeated.
pub fn full_message(error: &anyhow::Error) -> String {
    error.chain().map(ToString::to_string).fold(String::new(), |text, cause| {
        match (text.as_str(), cause.as_str()) {
            (text, cause) if text.ends_with(cause) => text.to_owned(),
            ("", cause) => cause.to_owned(),
            (text, cause) => format!("{text}: {cause}"),
        }
    })
}
