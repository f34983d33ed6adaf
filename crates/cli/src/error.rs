//! Failures that have an exit code of their own, and how failures are told.

use anyhow::Result;
use lemons_master::{FileType, Unexpected};
use std::error::Error;

/// A Trial has errors; they have been printed.
#[derive(Debug)]
pub struct TrialHasErrors;

impl std::fmt::Display for TrialHasErrors {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("the Trial has errors")
    }
}

impl std::error::Error for TrialHasErrors {}

/// The options make no sense together; what clap cannot see.
#[derive(Debug)]
pub struct Misused(pub String);

impl std::fmt::Display for Misused {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for Misused {}

/// What becomes of several files, each of which is put into its place whatever became of the others: the first error
/// counts, further ones are told.
pub fn and_then(done: Result<()>, next: Result<()>) -> Result<()> {
    match (done, next) {
        (Err(first), Err(second)) => {
            note!("lemons: {}", said(&second));
            Err(first)
        }
        (done, next) => done.and(next),
    }
}

/// An error with its causes; many of them say their cause themselves, which is not said again.
pub fn said(error: &anyhow::Error) -> String {
    let mut text = String::new();
    for cause in error.chain().map(in_words).filter(|cause| !cause.is_empty()) {
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

/// The text of a library's error, and which option or command has to do with it: libraries know of none.
fn in_words(cause: &(dyn Error + 'static)) -> String {
    match advice(cause) {
        Some(Advice::Before(text)) => format!("{text}{cause}"),
        Some(Advice::After(text)) => format!("{cause}{text}"),
        None => cause.to_string(),
    }
}

enum Advice {
    Before(&'static str),
    After(&'static str),
}

fn advice(cause: &(dyn Error + 'static)) -> Option<Advice> {
    let of_master = match find::<lemons_sweep::Error>(cause) {
        Some(lemons_sweep::Error::Master(error)) => Some(error),
        _ => find::<lemons_master::Error>(cause),
    };
    let unexpected = match of_master {
        Some(lemons_master::Error::Unexpected(error)) => Some(error),
        _ => find::<Unexpected>(cause),
    };
    if unexpected.is_some_and(|error| error.kind == FileType::SavedRun) {
        return Some(Advice::After("; lemons run --resume continues it"));
    }
    match of_master? {
        lemons_master::Error::NoVariable(_) => Some(Advice::After("; see lemons info")),
        lemons_master::Error::IsSsp => Some(Advice::After(": lemons run FILE.ssp")),
        lemons_master::Error::Algorithm { .. } => Some(Advice::Before("--algorithm: ")),
        _ => None,
    }
}

/// An error of a type, which may be in a box as a cause of another.
fn find<'a, T: Error + 'static>(cause: &'a (dyn Error + 'static)) -> Option<&'a T> {
    cause.downcast_ref().or_else(|| cause.downcast_ref::<Box<T>>().map(|boxed| &**boxed))
}
