//! Texts about settings that are probably not meant, in the words of `lemons run`: for runs of FMUs, and of a Trial in
//! memory.

use crate::error::MasterError;
use lemons_core::trial::DRIVE_FILE;
use lemons_decision::DECISION_FILE;

/// Says that nothing moves a Trial's people: no drive, no `decision.toml`, no force and no speed at the start.
pub fn still() -> String {
    format!(
        "note: nobody is driven: neither {DECISION_FILE} (where people walk) nor {DRIVE_FILE} is used, and \
         AgentDynamics.xml has no force and no speed (lemons decide --help, --drive)"
    )
}

/// Says that a connection feeds an input that is set.
pub fn overwritten(name: &str, value: &str, input: &str) -> String {
    format!("warning: --set {name}={value}: overwritten by the connection that feeds {input}")
}

/// Says that a parameter has other values in one component than in another that is connected by the names of the same people: so
/// many, the first of them by name.
pub fn differs(name: &str, [(one, here), (other, there)]: [(&str, f64); 2], people: usize) -> String {
    let people = if people == 1 { "1 person".to_owned() } else { format!("{people} people") };
    format!("warning: {name} is {here:?} in {one}, but {there:?} in {other} (of {people}): set it in both")
}

/// Says that a connection feeds Fp or Mp of people whom the drive in the FMU of this component would drive.
pub fn drive_replaced(component: &str) -> String {
    format!(
        "note: {component}: the {DRIVE_FILE} in it does not act on people whose Fp or Mp is connected; of a Trial with \
         {DECISION_FILE}, lemons run TRIAL adds it to the forces with which they walk"
    )
}

/// Says that a parameter names no variable, but its name is like one, or another component has it.
pub fn no_such_variable(name: &str, value: &str, meant: &str) -> MasterError {
    let question = format!("did you mean --set {meant}={value}?");
    MasterError::new(format!("--set {name}={value}: there is no such variable; {question}"))
}
