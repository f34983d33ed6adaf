//! Foundations of all other crates.
//!
//! - [`plane`]: geometry of the plane
//! - [`xml`]: XML, parsed safely and written
//! - [`trial`]: the documents of a Trial
//! - [`distribution`]: distributions of one number, the same draws on every machine
//! - [`mod@message`]: sentences with values; [`rule`]: rules by which documents are examined
//! - [`files`]: files read with limits, written whole or not at all

pub mod distribution;
pub mod files;
pub mod message;
pub mod plane;
pub mod rule;
pub mod trial;
pub mod xml;

/// Checks a condition; `error` says what is wrong if it does not hold.
///
/// # Errors
/// It does not hold.
pub fn require<E>(holds: bool, error: impl FnOnce() -> E) -> Result<(), E> {
    if holds { Ok(()) } else { Err(error()) }
}
