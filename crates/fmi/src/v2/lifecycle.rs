//! Which function is allowed in which state (FMI 2.0, section 4.2.4), as data.

use crate::lifecycle::{Function, Phase};

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
        Function::Set | Function::SetInputDerivatives => &[Instantiated, Initialization, StepComplete],
        Function::GetOutputDerivatives => &[StepComplete, Terminated, Error],
        Function::GetStatus => &[StepComplete, Terminated],
        // A synchronous slave is never in the middle of a step; the others are not of FMI 2.0.
        Function::CancelStep
        | Function::EnterConfigurationMode
        | Function::ExitConfigurationMode
        | Function::GetVariableDependencies
        | Function::Unsupported => &[],
    }
}
