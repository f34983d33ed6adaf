//! `modelDescription.xml`, from a table of variables.

use crate::variables::{Kind, Role, Unit, Variable, guid};
use quick_xml::Writer;
use quick_xml::events::{BytesDecl, BytesEnd, BytesStart, Event};
use std::io;

/// The categories of log messages, with what each holds.
pub const LOG_CATEGORIES: [(&str, &str); 4] = [
    ("logStatusWarning", "what may be a mistake"),
    ("logStatusError", "why a call was refused or failed"),
    ("logStatusFatal", "a fault of the FMU itself"),
    ("logAll", "everything"),
];

/// `variableNamingConvention`. Names are the same; tools that check structured names are slow at
/// thousands of them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Naming {
    /// "structured"
    #[default]
    Structured,
    /// "flat"
    Flat,
}

/// What a model description says.
pub struct Description<'a, Q> {
    /// `modelName`
    pub model_name: &'a str,
    /// `modelIdentifier`: the stem of the binaries' names.
    pub model_identifier: &'a str,
    /// For people.
    pub description: &'a str,
    /// Of the variables.
    pub naming: Naming,
    /// `canInterpolateInputs`
    pub interpolates_inputs: bool,
    /// \[s\] `DefaultExperiment.stopTime`; it starts at 0.
    pub stop_time: f64,
    /// \[s\] `DefaultExperiment.stepSize`
    pub step_size: f64,
    /// The variables.
    pub table: &'a [Variable<Q>],
    /// The start value as XML has it of the variable at a place of the table; none for computed ones.
    pub start: &'a dyn Fn(usize) -> Option<String>,
    /// The places of the inputs that the output at a place depends on at a communication point, ascending.
    pub dependencies: &'a dyn Fn(usize) -> Vec<usize>,
    /// The places of the inputs and start values that a computed output depends on in initialization.
    pub initial_dependencies: &'a dyn Fn(usize) -> Vec<usize>,
}

type Out<'a> = Writer<&'a mut Vec<u8>>;

impl<Q> Description<'_, Q> {
    /// As XML.
    pub fn xml(&self) -> String {
        let mut bytes = Vec::new();
        // Writing into memory does not fail.
        let _ = self.write(&mut Writer::new_with_indent(&mut bytes, b' ', 2));
        bytes.push(b'\n');
        String::from_utf8_lossy(&bytes).into_owned()
    }

    fn write(&self, out: &mut Out) -> io::Result<()> {
        out.write_event(Event::Decl(BytesDecl::new("1.0", Some("UTF-8"), None)))?;
        let root = element(
            "fmiModelDescription",
            &[
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
            ],
        );
        nest(out, root, |out| {
            let mut co_simulation = element(
                "CoSimulation",
                &[
                    ("modelIdentifier", self.model_identifier),
                    ("canHandleVariableCommunicationStepSize", "true"),
                ],
            );
            if self.interpolates_inputs {
                co_simulation.push_attribute(("canInterpolateInputs", "true"));
            }
            for flag in ["canNotUseMemoryManagementFunctions", "canGetAndSetFMUstate", "canSerializeFMUstate"]
            {
                co_simulation.push_attribute((flag, "true"));
            }
            out.write_event(Event::Empty(co_simulation))?;
            nest(out, element("UnitDefinitions", &[]), |out| {
                self.units().iter().try_for_each(|unit| write_unit(out, unit))
            })?;
            nest(out, element("LogCategories", &[]), |out| {
                LOG_CATEGORIES.iter().try_for_each(|(name, description)| {
                    let category = [("name", *name), ("description", *description)];
                    out.write_event(Event::Empty(element("Category", &category)))
                })
            })?;
            let experiment = [
                ("startTime", number(0.0)),
                ("stopTime", number(self.stop_time)),
                ("stepSize", number(self.step_size)),
            ];
            let experiment = experiment.each_ref().map(|(name, value)| (*name, value.as_str()));
            out.write_event(Event::Empty(element("DefaultExperiment", &experiment)))?;
            nest(out, element("ModelVariables", &[]), |out| {
                let mut rows = self.table.iter().enumerate();
                rows.try_for_each(|(reference, variable)| self.write_variable(out, reference, variable))
            })?;
            nest(out, element("ModelStructure", &[]), |out| {
                let output = |role| matches!(role, Role::Exact | Role::Calculated);
                self.write_unknowns(out, "Outputs", output, self.dependencies)?;
                let computed = |role| role == Role::Calculated;
                self.write_unknowns(out, "InitialUnknowns", computed, self.initial_dependencies)
            })
        })
    }

    /// The units of the table, in the order of their first use.
    fn units(&self) -> Vec<Unit> {
        let mut units = Vec::new();
        for variable in self.table {
            if let Kind::Real(unit) = variable.kind
                && !units.contains(&unit)
            {
                units.push(unit);
            }
        }
        units
    }

    fn write_variable(&self, out: &mut Out, reference: usize, variable: &Variable<Q>) -> io::Result<()> {
        let mut scalar = element(
            "ScalarVariable",
            &[
                ("name", &variable.name),
                ("valueReference", &reference.to_string()),
                ("description", &variable.description),
            ],
        );
        let (causality, initial) = match variable.role {
            Role::Input => ("input", None),
            Role::Exact => ("output", Some("exact")),
            Role::Calculated => ("output", Some("calculated")),
            Role::Parameter => ("parameter", Some("exact")),
        };
        let variability = match (variable.role, variable.kind) {
            (Role::Parameter, _) => "fixed",
            (_, Kind::Real(_)) => "continuous",
            _ => "discrete",
        };
        scalar.push_attribute(("causality", causality));
        scalar.push_attribute(("variability", variability));
        if let Some(initial) = initial {
            scalar.push_attribute(("initial", initial));
        }
        nest(out, scalar, |out| {
            let mut kind = BytesStart::new(variable.kind.name());
            if let Kind::Real(unit) = variable.kind {
                kind.push_attribute(("unit", unit.name));
            }
            if let Some(start) = (self.start)(reference) {
                kind.push_attribute(("start", start.as_str()));
            }
            out.write_event(Event::Empty(kind))
        })
    }

    fn write_unknowns(
        &self,
        out: &mut Out,
        name: &str,
        wanted: fn(Role) -> bool,
        dependencies: &dyn Fn(usize) -> Vec<usize>,
    ) -> io::Result<()> {
        nest(out, element(name, &[]), |out| {
            let mut unknowns = self.table.iter().enumerate().filter(|(_, variable)| wanted(variable.role));
            unknowns.try_for_each(|(place, _)| {
                // FMI counts from 1.
                let known: Vec<String> =
                    dependencies(place).iter().map(|place| (place + 1).to_string()).collect();
                let unknown = [("index", (place + 1).to_string()), ("dependencies", known.join(" "))];
                let unknown = unknown.each_ref().map(|(name, value)| (*name, value.as_str()));
                out.write_event(Event::Empty(element("Unknown", &unknown)))
            })
        })
    }
}

fn element<'a>(name: &'a str, attributes: &[(&str, &str)]) -> BytesStart<'a> {
    let mut element = BytesStart::new(name);
    for &attribute in attributes {
        element.push_attribute(attribute);
    }
    element
}

fn nest(
    out: &mut Out,
    start: BytesStart,
    content: impl FnOnce(&mut Out) -> io::Result<()>,
) -> io::Result<()> {
    let end = BytesEnd::new(start.name().as_ref().to_owned());
    out.write_event(Event::Start(start))?;
    content(out)?;
    out.write_event(Event::End(end))
}

/// So that it reads back to the same double.
pub fn number(value: f64) -> String {
    format!("{value:?}")
}

fn write_unit(out: &mut Out, unit: &Unit) -> io::Result<()> {
    nest(out, element("Unit", &[("name", unit.name)]), |out| {
        let mut base = BytesStart::new("BaseUnit");
        for (name, exponent) in ["kg", "m", "s", "rad"].iter().zip(unit.base) {
            if exponent != 0 {
                base.push_attribute((*name, exponent.to_string().as_str()));
            }
        }
        out.write_event(Event::Empty(base))
    })
}
