//! `Parameters.xml`.

use super::Parameters;
use super::problem::Problems;
use super::xml::{Bound, Element, Out, number};

/// The directories stay empty where the file does not say them.
pub(super) fn read(root: Element<'_>, problems: &mut Problems) -> Parameters {
    let mut parameters = Parameters {
        static_directory: String::new(),
        dynamic_directory: String::new(),
        time_step: f64::NAN,
        time_step_mechanical: f64::NAN,
    };
    if let Some(directories) = root.only("Directories", problems) {
        parameters.static_directory = directories.text("Static", problems);
        parameters.dynamic_directory = directories.text("Dynamic", problems);
    }
    if let Some(times) = root.only("Times", problems) {
        parameters.time_step = times.number("TimeStep", Bound::Positive, problems);
        parameters.time_step_mechanical = times.number("TimeStepMechanical", Bound::Positive, problems);
        if parameters.time_step_mechanical > parameters.time_step {
            let message = format!("must be at most TimeStep, {:?}", parameters.time_step);
            problems.push(times.wrong("TimeStepMechanical", &message));
        }
    }
    parameters
}

pub(super) fn xml(parameters: &Parameters) -> String {
    Out::document("Parameters", |out| {
        out.empty(
            "Directories",
            &[("Static", &parameters.static_directory), ("Dynamic", &parameters.dynamic_directory)],
        );
        out.empty(
            "Times",
            &[
                ("TimeStep", &number(parameters.time_step)),
                ("TimeStepMechanical", &number(parameters.time_step_mechanical)),
            ],
        );
    })
}
