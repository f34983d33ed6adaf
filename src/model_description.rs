//! `modelDescription.xml`, from the variable table.

use crate::trial::Trial;
use crate::variables::{Kind, Quantity, Role, UNITS, Unit, Variable, guid, in_documents, table};
use quick_xml::Writer;
use quick_xml::events::{BytesDecl, BytesEnd, BytesStart, Event};
use std::io;

/// `modelName`
pub const MODEL_NAME: &str = "LEMONS crowd mechanics";
/// `modelIdentifier`: the stem of the binaries' names.
pub const MODEL_IDENTIFIER: &str = "CrowdMechanics";
/// The categories of log messages, with what each holds.
pub const LOG_CATEGORIES: [(&str, &str); 4] = [
    ("logStatusWarning", "what may be a mistake"),
    ("logStatusError", "why a call was refused or failed"),
    ("logStatusFatal", "a fault of the FMU itself"),
    ("logAll", "everything"),
];
/// \[s\] `DefaultExperiment.stopTime`
pub const DEFAULT_STOP_TIME: f64 = 5.0;

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

/// The model description of a Trial's FMU.
pub fn model_description(trial: &Trial, naming: Naming) -> String {
    let mut bytes = Vec::new();
    // Writing into memory does not fail.
    let _ = write(&mut Writer::new_with_indent(&mut bytes, b' ', 2), trial, naming);
    bytes.push(b'\n');
    String::from_utf8_lossy(&bytes).into_owned()
}

type Out<'a> = Writer<&'a mut Vec<u8>>;

fn write(out: &mut Out, trial: &Trial, naming: Naming) -> io::Result<()> {
    let table = table(trial);
    out.write_event(Event::Decl(BytesDecl::new("1.0", Some("UTF-8"), None)))?;
    let root = element(
        "fmiModelDescription",
        &[
            ("fmiVersion", "2.0"),
            ("modelName", MODEL_NAME),
            ("guid", &guid(&table).braced().to_string()),
            (
                "description",
                "contact mechanics of a dense crowd: rigid bodies of disks, damped springs, Coulomb friction, walls",
            ),
            ("version", env!("CARGO_PKG_VERSION")),
            ("license", "MIT OR Apache-2.0"),
            ("generationTool", concat!("LEMONS-FMU ", env!("CARGO_PKG_VERSION"))),
            (
                "variableNamingConvention",
                match naming {
                    Naming::Structured => "structured",
                    Naming::Flat => "flat",
                },
            ),
        ],
    );
    nest(out, root, |out| {
        let co_simulation = [
            ("modelIdentifier", MODEL_IDENTIFIER),
            ("canHandleVariableCommunicationStepSize", "true"),
            ("canNotUseMemoryManagementFunctions", "true"),
            ("canGetAndSetFMUstate", "true"),
            ("canSerializeFMUstate", "true"),
        ];
        out.write_event(Event::Empty(element("CoSimulation", &co_simulation)))?;
        nest(out, element("UnitDefinitions", &[]), |out| {
            UNITS.iter().try_for_each(|unit| write_unit(out, unit))
        })?;
        nest(out, element("LogCategories", &[]), |out| {
            LOG_CATEGORIES.iter().try_for_each(|(name, description)| {
                let category = [("name", *name), ("description", *description)];
                out.write_event(Event::Empty(element("Category", &category)))
            })
        })?;
        let experiment = [
            ("startTime", number(0.0)),
            ("stopTime", number(DEFAULT_STOP_TIME)),
            ("stepSize", number(trial.parameters.time_step)),
        ];
        let experiment = experiment.each_ref().map(|(name, value)| (*name, value.as_str()));
        out.write_event(Event::Empty(element("DefaultExperiment", &experiment)))?;
        nest(out, element("ModelVariables", &[]), |out| {
            table
                .iter()
                .enumerate()
                .try_for_each(|(reference, variable)| write_variable(out, trial, reference, variable))
        })?;
        nest(out, element("ModelStructure", &[]), |out| {
            // Held inputs do not reach the outputs at a communication point: no dependencies.
            write_unknowns(out, "Outputs", &table, |role| matches!(role, Role::Exact | Role::Calculated))?;
            write_unknowns(out, "InitialUnknowns", &table, |role| role == Role::Calculated)
        })
    })
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
fn number(value: f64) -> String {
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

fn write_variable(out: &mut Out, trial: &Trial, reference: usize, variable: &Variable) -> io::Result<()> {
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
        if let Some(start) = start(trial, variable) {
            kind.push_attribute(("start", start.as_str()));
        }
        out.write_event(Event::Empty(kind))
    })
}

fn start(trial: &Trial, variable: &Variable) -> Option<String> {
    match variable.quantity {
        Quantity::Threads => Some("1".into()),
        Quantity::Trial => Some(trial.name.clone()),
        Quantity::OutputDirectory => Some(String::new()),
        quantity => in_documents(trial, quantity).map(number),
    }
}

fn write_unknowns(
    out: &mut Out,
    name: &str,
    table: &[Variable],
    wanted: impl Fn(Role) -> bool,
) -> io::Result<()> {
    nest(out, element(name, &[]), |out| {
        let unknowns = table.iter().enumerate().filter(|(_, variable)| wanted(variable.role));
        unknowns.into_iter().try_for_each(|(place, _)| {
            let unknown = [("index", (place + 1).to_string()), ("dependencies", String::new())];
            let unknown = unknown.each_ref().map(|(name, value)| (*name, value.as_str()));
            out.write_event(Event::Empty(element("Unknown", &unknown)))
        })
    })
}
