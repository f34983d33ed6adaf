//! Failures that have an exit code of their own, and how failures are told.

use anyhow::Result;
use lemons_master::{FileType, Unexpected};
use std::error::Error;

/// A Trial has errors; they have been printed.
#[derive(Debug, thiserror::Error)]
#[error("the Trial has errors")]
pub struct TrialHasErrors;

/// The options make no sense together; what clap cannot see.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct Misused(pub String);

/// Combines what became of several files, each of which is put into its place whatever became of the others: the first
/// error counts, further ones are told.
pub fn and_then(done: Result<()>, next: Result<()>) -> Result<()> {
    match (done, next) {
        (Err(first), Err(second)) => {
            note!("lemons: {}", full_message(&second));
            Err(first)
        }
        (done, next) => done.and(next),
    }
}

/// Returns the text of an error with its causes; many of them say their cause themselves, which is not said again.
pub fn full_message(error: &anyhow::Error) -> String {
    let mut text = String::new();
    for cause in error.chain().map(with_option).filter(|cause| !cause.is_empty()) {
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

/// Returns the text of a library's error, and which option or command has to do with it: libraries know of none.
fn with_option(cause: &(dyn Error + 'static)) -> String {
    let of_master = match find::<lemons_sweep::Error>(cause) {
        Some(lemons_sweep::Error::Master(error)) => Some(error),
        _ => find::<lemons_master::Error>(cause),
    };
    let unexpected = match of_master {
        Some(lemons_master::Error::Unexpected(error)) => Some(error),
        _ => find::<Unexpected>(cause),
    };
    let (before, after) = match of_master {
        _ if unexpected.is_some_and(|error| error.kind == FileType::SavedRun) => {
            ("", "; lemons run --resume continues it")
        }
        Some(lemons_master::Error::NoVariable(_)) => ("", "; see lemons info"),
        Some(lemons_master::Error::IsSsp) => ("", ": lemons run FILE.ssp"),
        Some(lemons_master::Error::Algorithm { .. }) => ("--algorithm: ", ""),
        _ => ("", ""),
    };
    format!("{before}{cause}{after}")
}

/// An error of a type, which may be in a box as a cause of another.
fn find<'a, T: Error + 'static>(cause: &'a (dyn Error + 'static)) -> Option<&'a T> {
    cause.downcast_ref().or_else(|| cause.downcast_ref::<Box<T>>().map(|boxed| &**boxed))
}
