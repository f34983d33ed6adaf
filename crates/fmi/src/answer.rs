//! Answers of calls: what they return, or why they were refused, in words.

use crate::Version;

/// `fmi2Status`; without `Pending`, `fmi3Status`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(missing_docs)] // FMI's own names
pub enum Status {
    Ok = 0,
    Warning = 1,
    Discard = 2,
    Error = 3,
    Fatal = 4,
    Pending = 5,
}

/// Why a call was refused or failed, in words.
#[derive(Debug)]
pub struct Refusal {
    /// Status that the importer gets.
    pub status: Status,
    /// Message that is logged.
    pub message: String,
}

impl Refusal {
    /// Makes the refusal of a call.
    pub fn new(message: impl Into<String>) -> Refusal {
        Refusal { status: Status::Error, message: message.into() }
    }
}

impl std::fmt::Display for Refusal {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.message)
    }
}

impl<E: std::error::Error> From<E> for Refusal {
    fn from(error: E) -> Refusal {
        Refusal::new(error.to_string())
    }
}

/// Refuses a value out of its range, as both versions do: nothing has changed, and other values may do.
pub(crate) fn out_of_range<T>(message: String) -> Answer<T> {
    Err(Refusal { status: Status::Discard, message })
}

/// Answers for FMI 3.0 a call that a model refuses: nothing has changed, and other values may do.
pub(crate) fn discard<T>(version: Version, answer: Answer<T>) -> Answer<T> {
    answer.map_err(|refusal| match (version, refusal.status) {
        (Version::V3, Status::Error) => Refusal { status: Status::Discard, ..refusal },
        _ => refusal,
    })
}

/// The result of a call.
pub type Answer<T> = Result<T, Refusal>;

/// Refuses a call.
///
/// # Errors
/// Always.
pub fn refuse<T>(message: impl Into<String>) -> Answer<T> {
    Err(Refusal::new(message))
}

/// Refuses a saved state.
///
/// # Errors
/// Always.
pub fn damaged<T>(why: &str) -> Answer<T> {
    refuse(format!("the state is damaged or is not a state of this FMU: {why}"))
}
