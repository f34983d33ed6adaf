//! Which function is allowed in which state (FMI 3.0, section 4.2.1), as data.

use crate::lifecycle::{Function, Phase};

/// Returns the states in which FMI 3.0 (section 4.2.1) allows a function of a co-simulation FMU without events.
pub fn allowed(function: Function) -> &'static [Phase] {
    use Phase::*;
    match function {
        Function::SetDebugLogging => {
            &[Instantiated, Configuration, Initialization, StepComplete, Intermediate, Terminated, Error]
        }
        Function::Reset | Function::State => {
            &[Instantiated, Configuration, Initialization, StepComplete, Terminated, Error]
        }
        Function::EnterConfigurationMode | Function::EnterInitializationMode => &[Instantiated],
        Function::ExitConfigurationMode => &[Configuration],
        Function::ExitInitializationMode => &[Initialization],
        Function::Terminate | Function::DoStep => &[StepComplete],
        Function::Get => &[Configuration, Initialization, StepComplete, Intermediate, Terminated, Error],
        Function::Set => &[Instantiated, Configuration, Initialization, StepComplete],
        Function::GetVariableDependencies => {
            &[Instantiated, Configuration, Initialization, StepComplete, Terminated, Error]
        }
        Function::GetDirectionalDerivative => {
            &[Initialization, StepComplete, Intermediate, Terminated, Error]
        }
        Function::GetOutputDerivatives => &[StepComplete, Intermediate, Terminated, Error],
        Function::Unsupported => &[StepComplete],
        // Of FMI 2.0.
        Function::SetupExperiment
        | Function::SetInputDerivatives
        | Function::CancelStep
        | Function::GetStatus => &[],
    }
}
