//! `Parameters.xml`.

use crate::trial::schema::{AttributeValue, Schema};
use crate::trial::xml::{Element, document, empty};
use crate::xml::number;
use std::path::Path;

/// `Parameters.xml`.
#[derive(Debug, Clone, PartialEq, Default)]
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
    /// Returns the Static directory, relative to the Trial directory.
    pub fn static_path(&self) -> &Path {
        Path::new(self.static_directory.trim())
    }

    /// Returns the Dynamic directory, relative to the Trial directory.
    pub fn dynamic_path(&self) -> &Path {
        Path::new(self.dynamic_directory.trim())
    }

    /// Returns the file's text.
    pub fn xml(&self) -> String {
        document("Parameters", |out| {
            empty(out, &DIRECTORIES, &[&self.static_directory, &self.dynamic_directory]);
            empty(out, &TIMES, &[&number(self.time_step), &number(self.time_step_mechanical)]);
        })
    }
}

pub(crate) static PARAMETERS: Schema =
    Schema { name: "Parameters", attributes: &[], children: &[&DIRECTORIES, &TIMES] };
static DIRECTORIES: Schema = Schema {
    name: "Directories",
    attributes: &[("Static", AttributeValue::Text), ("Dynamic", AttributeValue::Text)],
    children: &[],
};
static TIMES: Schema = Schema {
    name: "Times",
    attributes: &[("TimeStep", AttributeValue::Positive), ("TimeStepMechanical", AttributeValue::Positive)],
    children: &[],
};

/// Reads the file; the directories stay empty where the file does not say them.
pub(crate) fn read(root: Element<'_>) -> Parameters {
    let mut parameters = Parameters::default();
    if let Some(directories) = root.only("Directories") {
        parameters.static_directory = directories.text("Static");
        parameters.dynamic_directory = directories.text("Dynamic");
    }
    if let Some(times) = root.only("Times") {
        parameters.time_step = times.number("TimeStep");
        parameters.time_step_mechanical = times.number("TimeStepMechanical");
        if parameters.time_step_mechanical > parameters.time_step {
            let message = format!("must be at most TimeStep, {:?}", parameters.time_step);
            times.wrong("TimeStepMechanical", message);
        }
    }
    parameters
}
