//! What `SystemStructure.ssd` holds.

use crate::unit::{Affine, Unit};
use lemons_xml::{Problem, Severity};
use std::collections::BTreeMap;

/// The default structure of an archive.
pub const STRUCTURE_FILE: &str = "SystemStructure.ssd";

/// A system of components, checked: names are unique, connections lead from an output to an input, no input is
/// fed twice.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SystemStructure {
    /// Of the whole.
    pub name: String,
    /// In the order of the file, which is that of Gauss-Seidel.
    pub components: Vec<Component>,
    /// From outputs to inputs.
    pub connections: Vec<Connection>,
    /// What connectors name, by name.
    pub units: BTreeMap<String, Unit>,
    /// \[s\] `DefaultExperiment`
    pub start: Option<f64>,
    /// \[s\] `DefaultExperiment`
    pub stop: Option<f64>,
    /// \[s\] Communication step that the components propose. SSP 1.0 has no place for it: it is written in an annotation
    /// for OMSimulator, and not read.
    pub step: Option<f64>,
    /// Values for `component.variable`; they come after the components' own.
    pub parameters: Vec<ParameterSet>,
}

/// An FMU in the system.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Component {
    /// Name, unique in the system.
    pub name: String,
    /// Where the FMU is: an URI, relative to the structure.
    pub source: String,
    /// At least those that are connected.
    pub connectors: Vec<Connector>,
    /// Values for its variables; later ones count.
    pub parameters: Vec<ParameterSet>,
    /// In the file; 0 if there is none.
    pub line: u32,
}

/// A variable of a component, as others see it.
#[derive(Debug, Clone, PartialEq)]
pub struct Connector {
    /// The variable's.
    pub name: String,
    /// The variable's causality.
    pub kind: Kind,
    /// The variable's type, if the file says it.
    pub of: Option<Type>,
    /// In the file; 0 if there is none.
    pub line: u32,
}

/// What a connector is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(missing_docs)] // SSP's own names
pub enum Kind {
    Input,
    Output,
    Parameter,
    CalculatedParameter,
    InOut,
}

impl Kind {
    /// SSP's names, which are FMI's.
    pub const NAMES: [(&str, Kind); 5] = [
        ("input", Kind::Input),
        ("output", Kind::Output),
        ("parameter", Kind::Parameter),
        ("calculatedParameter", Kind::CalculatedParameter),
        ("inout", Kind::InOut),
    ];

    /// As in the file.
    pub fn name(self) -> &'static str {
        Kind::NAMES.iter().find(|(_, kind)| *kind == self).map_or("", |(name, _)| name)
    }
}

/// The type of a variable or connector.
#[derive(Debug, Clone, PartialEq, Eq)]
#[allow(missing_docs)] // FMI's own names
pub enum Type {
    /// With its unit, if it has one.
    Real(Option<String>),
    Integer,
    Boolean,
    String,
    /// With its name.
    Enumeration(String),
    /// Not in FMI 2.0.
    Binary,
}

impl Type {
    /// As in the file.
    pub fn name(&self) -> &'static str {
        match self {
            Type::Real(_) => "Real",
            Type::Integer => "Integer",
            Type::Boolean => "Boolean",
            Type::String => "String",
            Type::Enumeration(_) => "Enumeration",
            Type::Binary => "Binary",
        }
    }

    /// A Real's.
    pub fn unit(&self) -> Option<&str> {
        match self {
            Type::Real(unit) => unit.as_deref(),
            _ => None,
        }
    }
}

/// A connector by its places in the lists.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Port {
    /// In [`SystemStructure::components`].
    pub component: usize,
    /// In [`Component::connectors`].
    pub connector: usize,
}

/// From an output to an input.
#[derive(Debug, Clone, PartialEq)]
pub struct Connection {
    /// The output.
    pub from: Port,
    /// The input.
    pub to: Port,
    /// `LinearTransformation`, after the conversion to the unit of the input.
    pub transformation: Option<Affine>,
    /// `suppressUnitConversion`
    pub suppress_unit_conversion: bool,
    /// In the file; 0 if there is none.
    pub line: u32,
}

/// `ParameterSet`, inline or from an `.ssv`.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ParameterSet {
    /// In the order of the file.
    pub parameters: Vec<Parameter>,
    /// What its Reals name, by name.
    pub units: BTreeMap<String, Unit>,
    /// The file that holds it.
    pub file: String,
}

/// A value for a variable.
#[derive(Debug, Clone, PartialEq)]
pub struct Parameter {
    /// The variable's, with the binding's prefix.
    pub name: String,
    /// What it is set to.
    pub value: Value,
    /// In the file.
    pub line: u32,
}

/// With its type.
#[derive(Debug, Clone, PartialEq)]
#[allow(missing_docs)] // FMI's own names
pub enum Value {
    /// With its unit, if it has one.
    Real(f64, Option<String>),
    Integer(i32),
    Boolean(bool),
    String(String),
}

impl SystemStructure {
    /// A connector and its component.
    pub fn port(&self, port: Port) -> (&Component, &Connector) {
        let component = &self.components[port.component];
        (component, &component.connectors[port.connector])
    }

    /// A unit by name.
    pub fn unit(&self, name: &str) -> Option<&Unit> {
        self.units.get(name)
    }
}

/// An error at a place of the structure: `SystemStructure.ssd:12: <Connector> name="x": …`
pub fn located(
    line: u32,
    element: &str,
    attribute: &str,
    value: &str,
    message: impl Into<String>,
) -> Problem {
    Problem {
        severity: Severity::Error,
        file: STRUCTURE_FILE.into(),
        line: Some(line),
        element: Some(element.into()),
        attribute: Some(attribute.into()),
        value: Some(value.into()),
        message: message.into(),
    }
}
