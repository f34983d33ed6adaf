//! Which function is allowed in which state (FMI 2.0, section 4.2.4), as data.

use serde::{Deserialize, Serialize};

/// The states of the slave (FMI 2.0, section 4.2.4). A slave with synchronous steps has no others.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Phase {
    /// After `fmi2Instantiate` or `fmi2Reset`.
    Instantiated,
    /// Between `fmi2EnterInitializationMode` and `fmi2ExitInitializationMode`.
    Initialization,
    /// Ready for the next step.
    StepComplete,
    /// After `fmi2Terminate`.
    Terminated,
    /// After a step that failed.
    Error,
}

/// The functions whose use depends on the phase.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(missing_docs)] // FMI's own names
pub enum Function {
    SetDebugLogging,
    SetupExperiment,
    EnterInitializationMode,
    ExitInitializationMode,
    Terminate,
    Reset,
    Get,
    Set,
    State,
    GetDirectionalDerivative,
    SetRealInputDerivatives,
    GetRealOutputDerivatives,
    DoStep,
    CancelStep,
    GetStatus,
}

/// Returns the states in which FMI 2.0 (section 4.2.4) allows a function.
pub fn allowed(function: Function) -> &'static [Phase] {
    use Phase::*;
    match function {
        Function::SetDebugLogging | Function::Reset | Function::State => {
            &[Instantiated, Initialization, StepComplete, Terminated, Error]
        }
        Function::SetupExperiment | Function::EnterInitializationMode => &[Instantiated],
        Function::ExitInitializationMode => &[Initialization],
        Function::Terminate | Function::DoStep => &[StepComplete],
        Function::Get | Function::GetDirectionalDerivative => {
            &[Initialization, StepComplete, Terminated, Error]
        }
        Function::Set | Function::SetRealInputDerivatives => &[Instantiated, Initialization, StepComplete],
        Function::GetRealOutputDerivatives => &[StepComplete, Terminated, Error],
        // A synchronous slave is never in the middle of a step.
        Function::CancelStep => &[],
        Function::GetStatus => &[StepComplete, Terminated],
    }
}
