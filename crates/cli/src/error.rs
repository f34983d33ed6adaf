//! Failures that have an exit code of their own.

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

/// An error with its causes; many of them say their cause themselves, which is not said again.
pub fn said(error: &anyhow::Error) -> String {
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
