//! The states of an instance, and the functions whose use depends on them.

use crate::Version;
use serde::{Deserialize, Serialize};

/// The states of a slave (FMI 2.0, section 4.2.4; FMI 3.0, section 4.2.1). A slave with synchronous
/// steps has no others.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Phase {
    /// After it was made or reset.
    Instantiated,
    /// FMI 3.0: between `fmi3EnterConfigurationMode` and `fmi3ExitConfigurationMode`.
    Configuration,
    /// While start values are set.
    Initialization,
    /// Ready for the next step.
    StepComplete,
    /// FMI 3.0: within `fmi3DoStep`, while the importer's callback runs.
    Intermediate,
    /// After the end.
    Terminated,
    /// FMI 2.0: after a step that failed. In FMI 3.0 that is [`Phase::Terminated`].
    Error,
}

/// The functions whose use depends on the phase, of both versions of FMI.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(missing_docs)] // FMI's own names
pub enum Function {
    SetDebugLogging,
    SetupExperiment,
    EnterConfigurationMode,
    ExitConfigurationMode,
    EnterInitializationMode,
    ExitInitializationMode,
    Terminate,
    Reset,
    Get,
    Set,
    State,
    GetVariableDependencies,
    GetDirectionalDerivative,
    SetInputDerivatives,
    GetOutputDerivatives,
    DoStep,
    CancelStep,
    GetStatus,
    /// Of what is not offered, such as events.
    Unsupported,
}

/// Returns whether a version of FMI allows a function in a phase.
pub fn allowed(function: Function, version: Version, phase: Phase) -> bool {
    // A letter for each phase, in their order; FMI 2.0 has neither Configuration nor Intermediate,
    // FMI 3.0 no Error.
    // A synchronous slave is never in the middle of a step, so that there is nothing to cancel.
    let [of_2, of_3] = match function {
        Function::SetDebugLogging => ["I-IS-TE", "ICISIT-"],
        Function::SetupExperiment | Function::EnterInitializationMode => ["I------", "I------"],
        Function::EnterConfigurationMode => ["-------", "I------"],
        Function::ExitConfigurationMode => ["-------", "-C-----"],
        Function::ExitInitializationMode => ["--I----", "--I----"],
        Function::Terminate | Function::DoStep => ["---S---", "---S---"],
        Function::Reset | Function::State => ["I-IS-TE", "ICIS-T-"],
        Function::Get => ["--IS-TE", "ICISIT-"],
        Function::Set => ["I-IS---", "ICIS---"],
        Function::GetVariableDependencies => ["-------", "ICIS-T-"],
        Function::GetDirectionalDerivative => ["--IS-TE", "--ISIT-"],
        Function::SetInputDerivatives => ["I-IS---", "-------"],
        Function::GetOutputDerivatives => ["---S-TE", "---SIT-"],
        Function::CancelStep => ["-------", "-------"],
        Function::GetStatus => ["---S-T-", "-------"],
        Function::Unsupported => ["-------", "---S---"],
    };
    let phases = if version == Version::V2 { of_2 } else { of_3 };
    phases.as_bytes()[phase as usize] != b'-'
}
