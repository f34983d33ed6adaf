//! The content of `SystemStructure.ssd`.

use crate::error::MasterError;
use crate::ssp::unit::{Affine, SspUnit};
use lemons_core::message::Message;
use lemons_core::xml::Problem;
use serde::Deserialize;
use serde::de::{self, value::StrDeserializer};
use std::collections::BTreeMap;
use std::fmt;

/// The default structure of an archive.
pub const STRUCTURE_FILE: &str = "SystemStructure.ssd";

/// A system of components, checked: names are unique, connections lead from an output to an input. Places in files are
/// problems without a message.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SystemStructure {
    /// In the order of the file, which is that of Gauss-Seidel.
    pub components: Vec<SspComponent>,
    /// From outputs to inputs.
    pub connections: Vec<Connection>,
    /// Units that connectors name, by name.
    pub units: BTreeMap<String, SspUnit>,
    /// \[s\] `DefaultExperiment`
    pub start: Option<f64>,
    /// \[s\] `DefaultExperiment`
    pub stop: Option<f64>,
    /// Values for variables; later ones count.
    pub parameters: Vec<SspParameter>,
}

/// An FMU in the system.
#[derive(Debug, Clone, PartialEq)]
pub struct SspComponent {
    /// Name, unique in the system.
    pub name: String,
    /// Where the FMU is: an URI, relative to the structure.
    pub source: String,
    /// At least those that are connected, by the names of the variables.
    pub connectors: BTreeMap<String, Connector>,
    /// In the file.
    pub place: Problem,
}

/// A variable of a component, as others see it.
#[derive(Debug, Clone, PartialEq)]
pub struct Connector {
    /// The variable's causality.
    pub kind: Causality,
    /// The variable's type, if the file says it.
    pub of: Option<FmiType>,
    /// A Real's, if it has one.
    pub unit: Option<String>,
    /// SSP 2.0: those of an array, from the outermost.
    pub dimensions: Vec<Extent>,
    /// In the file.
    pub place: Problem,
}

/// How many elements an array connector has in a dimension.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Extent {
    /// So many.
    Size(u64),
    /// As many as the structural parameter with this name says.
    Parameter(String),
    /// The FMU says it.
    Unsaid,
}

/// The purpose of a connector.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(missing_docs)] // SSP's own names
pub enum Causality {
    Input,
    Output,
    Parameter,
    CalculatedParameter,
    StructuralParameter,
    InOut,
}

impl Causality {
    /// SSP's names, which are FMI's.
    const NAMES: [(&str, Causality); 6] = [
        ("input", Causality::Input),
        ("output", Causality::Output),
        ("parameter", Causality::Parameter),
        ("calculatedParameter", Causality::CalculatedParameter),
        ("structuralParameter", Causality::StructuralParameter),
        ("inout", Causality::InOut),
    ];

    /// Returns the kind with this name.
    pub fn from_name(name: &str) -> Option<Causality> {
        Causality::NAMES.iter().find(|(known, _)| *known == name).map(|(_, kind)| *kind)
    }

    /// Returns the name in the file.
    pub fn name(self) -> &'static str {
        Causality::NAMES.iter().find(|(_, kind)| *kind == self).map_or("", |(name, _)| name)
    }
}

/// A type of variables: those of FMI 2.0 and of FMI 3.0, of which SSP takes both.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default, Deserialize)]
#[allow(missing_docs)] // FMI's own names
pub enum FmiType {
    #[default]
    Real,
    Integer,
    Boolean,
    String,
    Enumeration,
    Float64,
    Float32,
    Int8,
    UInt8,
    Int16,
    UInt16,
    Int32,
    UInt32,
    Int64,
    UInt64,
    Binary,
    Clock,
}

impl fmt::Display for FmiType {
    /// Its name in FMI.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Debug::fmt(self, f)
    }
}

impl FmiType {
    /// Returns the type with this name.
    pub fn from_name(name: &str) -> Option<FmiType> {
        FmiType::deserialize(StrDeserializer::<de::value::Error>::new(name)).ok()
    }

    /// Returns the type of FMI 2.0 with such values; a Binary and a Clock, which it has not, are what they are.
    pub fn class(self) -> FmiType {
        match self {
            FmiType::Float64 | FmiType::Float32 => FmiType::Real,
            of if (FmiType::Int8..=FmiType::UInt64).contains(&of) => FmiType::Integer,
            of => of,
        }
    }

    /// Checks that values of this type can be sent to a variable of another one.
    ///
    /// # Errors
    /// A sentence with both, or with the type that is not served.
    pub(crate) fn check_sent_to(self, input: FmiType) -> Result<(), String> {
        let (from, to) = (self.class(), input.class());
        match from {
            _ if from != to => Err(format!("{from} does not become {to}")),
            FmiType::Enumeration | FmiType::Binary | FmiType::Clock => {
                Err(format!("type {from} is not served"))
            }
            _ => Ok(()),
        }
    }
}

/// An end of a connection.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Port {
    /// Its place in [`SystemStructure::components`].
    pub component: usize,
    /// Its name among [`SspComponent::connectors`].
    pub connector: String,
    /// SSP 2.0: the element of an array, by indices from 1; empty for all of it.
    pub indices: Vec<usize>,
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
    /// In the file.
    pub place: Problem,
}

/// A value for a variable, inline or from an `.ssv`.
#[derive(Debug, Clone, PartialEq)]
pub struct SspParameter {
    /// The place of the component that has the variable; `None`: it is in the name.
    pub component: Option<usize>,
    /// The variable's, with the binding's prefix: without a component, `component.variable`.
    pub name: String,
    /// Its type.
    pub of: FmiType,
    /// A Real's, if it has one.
    pub unit: Option<String>,
    /// The definition of this unit, if the parameter set or the structure has one.
    pub definition: Option<SspUnit>,
    /// The value that it is set to, checked: a value of this type.
    pub text: String,
    /// In the file.
    pub place: Problem,
}

impl SystemStructure {
    /// Returns a connector and its component.
    pub fn port(&self, port: &Port) -> (&SspComponent, &Connector) {
        let component = &self.components[port.component];
        (component, &component.connectors[&port.connector])
    }
}

/// Makes an error at a place in a file.
pub(crate) fn wrong_at(place: &Problem, message: impl Into<Message>) -> MasterError {
    Problem { message: message.into(), ..place.clone() }.into()
}
