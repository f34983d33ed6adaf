//! `modelDescription.xml`, from a table of variables.

use super::table::guid;
use crate::boundary::LOG_CATEGORIES;
use crate::units::{units_of, write_unit};
use crate::variables::{Kind, Role, Variable};
use lemons_core::xml::{Layout, Out, number};

/// `variableNamingConvention`. The names are the same in both cases. Tools that check structured names are slow if there
/// are thousands of them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Naming {
    /// "structured"
    #[default]
    Structured,
    /// "flat"
    Flat,
}

/// The content of a model description.
pub struct Description<'a, Q> {
    /// `modelName`
    pub model_name: &'a str,
    /// `modelIdentifier`: the stem of the binaries' names.
    pub model_identifier: &'a str,
    /// Description for users.
    pub description: &'a str,
    /// Of the variables.
    pub naming: Naming,
    /// `canInterpolateInputs`
    pub interpolates_inputs: bool,
    /// `maxOutputDerivativeOrder` is 1, not 0.
    pub knows_derivatives: bool,
    /// \[s\] `DefaultExperiment.stopTime`; the start time is 0.
    pub stop_time: f64,
    /// \[s\] `DefaultExperiment.stepSize`
    pub step_size: f64,
    /// The variables.
    pub table: &'a [Variable<Q>],
    /// Returns the start value, as text for XML, of the variable at a place of the table; `None` if it is computed.
    pub start: &'a dyn Fn(usize) -> Option<String>,
    /// Returns the places of the inputs on which an output depends at a communication point, ascending.
    /// `None` if it depends on all.
    pub dependencies: &'a dyn Fn(usize) -> Option<Vec<usize>>,
    /// Returns the places of the inputs and start values on which a computed output depends in initialization.
    /// `None` if it depends on all.
    pub initial_dependencies: &'a dyn Fn(usize) -> Option<Vec<usize>>,
}

impl<Q> Description<'_, Q> {
    /// As XML.
    pub fn xml(&self) -> String {
        let root = [
            ("fmiVersion", "2.0"),
            ("modelName", self.model_name),
            ("guid", &guid(self.table).braced().to_string()),
            ("description", self.description),
            ("version", env!("CARGO_PKG_VERSION")),
            ("license", "MIT OR Apache-2.0"),
            ("generationTool", concat!("LEMONS-FMU ", env!("CARGO_PKG_VERSION"))),
            (
                "variableNamingConvention",
                match self.naming {
                    Naming::Structured => "structured",
                    Naming::Flat => "flat",
                },
            ),
        ];
        Out::document(Layout::STANDARD, "fmiModelDescription", &root, |out| {
            let mut co_simulation = vec![
                ("modelIdentifier", self.model_identifier),
                ("canHandleVariableCommunicationStepSize", "true"),
            ];
            if self.interpolates_inputs {
                co_simulation.push(("canInterpolateInputs", "true"));
            }
            if self.knows_derivatives {
                co_simulation.push(("maxOutputDerivativeOrder", "1"));
            }
            for flag in ["canNotUseMemoryManagementFunctions", "canGetAndSetFMUstate", "canSerializeFMUstate"]
            {
                co_simulation.push((flag, "true"));
            }
            out.empty("CoSimulation", &co_simulation);
            out.element("UnitDefinitions", &[], |out| {
                let kinds = self.table.iter().map(|variable| variable.kind);
                units_of(kinds).iter().for_each(|unit| write_unit(out, unit));
            });
            out.element("LogCategories", &[], |out| {
                for (name, description) in LOG_CATEGORIES {
                    out.empty("Category", &[("name", name), ("description", description)]);
                }
            });
            let (stop, step) = (number(self.stop_time), number(self.step_size));
            let times = [("startTime", &number(0.0)[..]), ("stopTime", &stop), ("stepSize", &step)];
            out.empty("DefaultExperiment", &times);
            out.element("ModelVariables", &[], |out| {
                let rows = self.table.iter().enumerate();
                rows.for_each(|(reference, variable)| self.write_variable(out, reference, variable));
            });
            out.element("ModelStructure", &[], |out| {
                let output = |role| matches!(role, Role::Exact | Role::Calculated);
                self.write_unknowns(out, "Outputs", output, self.dependencies);
                let computed = |role| role == Role::Calculated;
                self.write_unknowns(out, "InitialUnknowns", computed, self.initial_dependencies);
            });
        })
    }

    fn write_variable(&self, out: &mut Out, reference: usize, variable: &Variable<Q>) {
        let (causality, initial) = match variable.role {
            Role::Input => ("input", None),
            Role::Exact => ("output", Some("exact")),
            Role::Calculated => ("output", Some("calculated")),
            Role::Parameter => ("parameter", Some("exact")),
            Role::CalculatedParameter => ("calculatedParameter", Some("calculated")),
        };
        let variability = match (variable.role, variable.kind) {
            (Role::Parameter | Role::CalculatedParameter, _) => "fixed",
            (_, Kind::Real(_)) => "continuous",
            _ => "discrete",
        };
        let place = reference.to_string();
        let mut scalar = vec![
            ("name", &variable.name[..]),
            ("valueReference", &place),
            ("description", &variable.description),
            ("causality", causality),
            ("variability", variability),
        ];
        scalar.extend(initial.map(|initial| ("initial", initial)));
        out.element("ScalarVariable", &scalar, |out| {
            let start = (self.start)(reference);
            let mut kind = Vec::new();
            if let Kind::Real(unit) = variable.kind {
                kind.push(("unit", unit.name));
            }
            kind.extend(start.as_deref().map(|start| ("start", start)));
            out.empty(variable.kind.name(), &kind);
        });
    }

    fn write_unknowns(
        &self,
        out: &mut Out,
        name: &str,
        wanted: fn(Role) -> bool,
        dependencies: &dyn Fn(usize) -> Option<Vec<usize>>,
    ) {
        out.element(name, &[], |out| {
            let unknowns = self.table.iter().enumerate().filter(|(_, variable)| wanted(variable.role));
            for (place, _) in unknowns {
                // FMI counts from 1.
                let index = (place + 1).to_string();
                match dependencies(place) {
                    None => out.empty("Unknown", &[("index", &index)]),
                    Some(known) => {
                        let known: Vec<String> = known.iter().map(|place| (place + 1).to_string()).collect();
                        out.empty("Unknown", &[("index", &index), ("dependencies", &known.join(" "))]);
                    }
                }
            }
        });
    }
}
