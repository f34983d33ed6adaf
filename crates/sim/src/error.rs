//! Why a simulation does not begin or go on.

use lemons_fmi::{Refusal, StepError};

/// Why a simulation does not begin or go on.
#[derive(Debug, thiserror::Error)]
pub enum SimError {
    /// The crowd or Decision refuses it.
    #[error("{0}")]
    Model(Refusal),
    /// The crowd refuses a step, and has not moved: another one may be tried.
    #[error("{0}")]
    Refused(Refusal),
    /// A text is not a value of a variable.
    #[error("{name}={text}: {why}")]
    Value {
        /// Of the variable.
        name: String,
        /// The text that was given.
        text: String,
        /// Why it is none.
        why: String,
    },
    /// There is no such variable.
    #[error(
        "{given}: there is no such variable{}",
        meant.as_ref().map(|meant| format!("; did you mean {meant:?}?")).unwrap_or_default()
    )]
    Unknown {
        /// Its name, or `NAME=VALUE` where it was to be set.
        given: String,
        /// The name that is probably meant.
        meant: Option<String>,
    },
    /// A start time is not finite.
    #[error("start time {0:?} s: must be finite")]
    Start(f64),
    /// There is no such communication point.
    #[error("communication step to {to:?} s: must be finite, and after {from:?} s")]
    Step {
        /// \[s\] What was given.
        to: f64,
        /// \[s\] The last communication point.
        from: f64,
    },
    /// It steps before it has begun.
    #[error("the simulation has not begun")]
    NotBegun,
    /// A saved state is damaged, or of other documents.
    #[error("the state is damaged or is not a state of this Trial")]
    State,
}

impl From<Refusal> for SimError {
    fn from(refusal: Refusal) -> SimError {
        SimError::Model(refusal)
    }
}

impl From<StepError> for SimError {
    fn from(error: StepError) -> SimError {
        match error {
            StepError::Refused(refusal) => SimError::Refused(refusal),
            StepError::Failed(refusal) => SimError::Model(refusal),
        }
    }
}
