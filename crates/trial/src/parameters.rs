//! `Parameters.xml`.

use crate::problem::Problems;
use crate::xml::{Bound, Element, Kind, document};
use lemons_xml::number;
use std::path::Path;

/// `Parameters.xml`.
#[derive(Debug, Clone, PartialEq)]
pub struct Parameters {
    /// `Directories/Static`, as in the file; relative to the Trial directory.
    pub static_directory: String,
    /// `Directories/Dynamic`, as in the file; relative to the Trial directory.
    pub dynamic_directory: String,
    /// \[s\] `Times/TimeStep`: the communication step (the paper's decisional loop).
    pub time_step: f64,
    /// \[s\] `Times/TimeStepMechanical`: step of the integrator, at most `time_step`.
    pub time_step_mechanical: f64,
}

impl Parameters {
    /// The Static directory, relative to the Trial directory.
    pub fn static_path(&self) -> &Path {
        Path::new(self.static_directory.trim())
    }

    /// The Dynamic directory, relative to the Trial directory.
    pub fn dynamic_path(&self) -> &Path {
        Path::new(self.dynamic_directory.trim())
    }

    /// Returns the file's text.
    pub fn xml(&self) -> String {
        document("Parameters", |out| {
            out.empty(
                "Directories",
                &[("Static", &self.static_directory), ("Dynamic", &self.dynamic_directory)],
            );
            out.empty(
                "Times",
                &[
                    ("TimeStep", &number(self.time_step)),
                    ("TimeStepMechanical", &number(self.time_step_mechanical)),
                ],
            );
        })
    }
}

pub(crate) static PARAMETERS: Kind =
    Kind { name: "Parameters", attributes: &[], children: &[&DIRECTORIES, &TIMES] };
static DIRECTORIES: Kind = Kind { name: "Directories", attributes: &["Static", "Dynamic"], children: &[] };
static TIMES: Kind = Kind { name: "Times", attributes: &["TimeStep", "TimeStepMechanical"], children: &[] };

/// The directories stay empty where the file does not say them.
pub(crate) fn read(root: Element<'_>, problems: &mut Problems) -> Parameters {
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
