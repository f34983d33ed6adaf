//! The states of an instance, and the functions whose use depends on them.

use serde::{Deserialize, Serialize};

/// The states of a slave (FMI 2.0, section 4.2.4; FMI 3.0, section 4.2.1). A slave with synchronous steps has no others.
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
    /// After a step that failed.
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
