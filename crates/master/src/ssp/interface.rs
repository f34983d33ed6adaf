//! The description of an FMU in its `modelDescription.xml`, of FMI 2.0 or 3.0: names, abilities, variables and units.

mod elements;
mod variables;

pub(crate) use elements::{place_of, written};

use crate::error::Result;
use crate::ssp::document::{Causality, FmiType};
use crate::ssp::read::read_units;
use crate::ssp::unit::{SspUnit, UnitOf};
use lemons_core::xml::{Document, Element};
use lemons_fmi::Version;
use std::collections::{BTreeMap, HashMap};
use std::fmt;
use std::path::Path;

/// The most elements and texts of a description: more than twice those of the largest that is read (256 MB).
const NODES: u32 = 16_000_000;

/// The description of an FMU.
#[derive(Debug, Clone, Default)]
pub struct Interface {
    /// `fmiVersion`
    pub fmi: Version,
    /// `modelName`
    pub model_name: String,
    /// `guid`, in FMI 3.0 `instantiationToken`, which its library compares with its own.
    pub guid: String,
    /// `version`
    pub version: Option<String>,
    /// `None`: it is not for co-simulation.
    pub co_simulation: Option<CoSimulation>,
    /// In the order of the file.
    pub variables: Vec<FmuVariable>,
    /// By name, and by an FMI 3.0 `<Alias>`.
    places: HashMap<String, usize>,
    units: BTreeMap<String, SspUnit>,
    /// \[s\] `DefaultExperiment`
    pub start: Option<f64>,
    /// \[s\] `DefaultExperiment`
    pub stop: Option<f64>,
    /// \[s\] `DefaultExperiment`
    pub step: Option<f64>,
    /// `DefaultExperiment`; a number that is no tolerance is left out.
    pub tolerance: Option<f64>,
}

/// `<CoSimulation>`
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CoSimulation {
    /// `modelIdentifier`: what its library is called.
    pub identifier: String,
    /// `canNotUseMemoryManagementFunctions`; FMI 3.0 knows no such functions.
    pub cannot_use_memory_functions: bool,
    /// `canGetAndSetFMUstate`, in FMI 3.0 `canGetAndSetFMUState`
    pub can_get_and_set_state: bool,
    /// `canSerializeFMUstate`, in FMI 3.0 `canSerializeFMUState`
    pub can_serialize_state: bool,
}

/// A variable of an FMU.
#[derive(Debug, Clone, PartialEq)]
pub struct FmuVariable {
    /// As the FMU calls it.
    pub name: String,
    /// The value reference.
    pub reference: u32,
    /// `None` for local and independent variables, and for what is known in Event Mode only.
    pub kind: Option<Causality>,
    /// Its type.
    pub of: FmiType,
    /// A Real's, if it has one.
    pub unit: Option<String>,
    /// The declared type of an Enumeration.
    pub enumeration: Option<String>,
    /// From the outermost; none for a single value. Elements are in row-major order.
    pub dimensions: Vec<ArrayDimension>,
    /// `start`: none, one for all elements, or one for each.
    pub start: Vec<String>,
    /// `description`
    pub description: Option<String>,
}

/// A dimension of an array.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ArrayDimension {
    /// The number of elements.
    pub size: usize,
    /// The structural parameter that says this number: its place among the variables.
    pub parameter: Option<usize>,
}

impl FmuVariable {
    /// Returns the number of its values.
    pub fn count(&self) -> usize {
        self.dimensions.iter().map(|dimension| dimension.size).product()
    }

    /// Returns the number of its values, if it is one.
    pub(super) fn checked_count(&self) -> Option<usize> {
        self.dimensions.iter().map(|dimension| dimension.size).try_fold(1, usize::checked_mul)
    }

    /// Returns the sizes of its dimensions.
    pub fn sizes(&self) -> Vec<usize> {
        self.dimensions.iter().map(|dimension| dimension.size).collect()
    }

    /// Returns the indices of one of its elements, from 1; none of a single value.
    pub fn indices(&self, element: usize) -> Vec<usize> {
        let mut rest = element;
        let mut indices: Vec<usize> = Vec::with_capacity(self.dimensions.len());
        for dimension in self.dimensions.iter().rev() {
            indices.push(rest % dimension.size.max(1) + 1);
            rest /= dimension.size.max(1);
        }
        indices.reverse();
        indices
    }

    /// Returns whether it is an array, perhaps of one element.
    pub fn is_array(&self) -> bool {
        !self.dimensions.is_empty()
    }

    /// Returns the start value of an element.
    pub fn start_of(&self, element: usize) -> Option<&str> {
        let one_for_all = self.start.len() == 1;
        self.start.get(if one_for_all { 0 } else { element }).map(String::as_str)
    }
}

/// A single value: a variable, or an element of an array.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Single<'a> {
    /// The variable of which it is one.
    pub variable: &'a FmuVariable,
    /// Among the values of the variable, from 0, in row-major order.
    pub element: usize,
}

impl Single<'_> {
    /// Returns whether it is a parameter.
    pub fn is_parameter(self) -> bool {
        self.variable.kind == Some(Causality::Parameter)
    }
}

/// Its value reference; of an array also the place of the element, from 0.
impl fmt::Display for Single<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Single { variable, element } = self;
        write!(f, "{}", variable.reference)?;
        if variable.is_array() { write!(f, "[{element}]") } else { Ok(()) }
    }
}

impl Interface {
    /// Reads a `modelDescription.xml`.
    ///
    /// # Errors
    /// It is broken, or neither of FMI 2.0 nor of FMI 3.0, two variables have one name, a start value is NaN; in FMI 3.0
    /// also dimensions without a size, or start values that are not as many as the elements.
    pub fn read(bytes: &[u8]) -> Result<Interface> {
        let document = Document::parse(Path::new("modelDescription.xml"), bytes, NODES)?;
        let root = document.root("fmiModelDescription")?;
        let fmi = match root.text("fmiVersion")? {
            "2.0" => Version::V2,
            version if version.starts_with("3.") => Version::V3,
            _ => {
                let why = "must be 2.0 or 3.0: FMUs of other versions of FMI cannot be read";
                return Err(root.wrong("fmiVersion", why).into());
            }
        };
        let token = if fmi == Version::V2 { "guid" } else { "instantiationToken" };
        root.child("ModelExchange").map(identifier).transpose()?;
        let mut interface = Interface {
            fmi,
            model_name: root.text("modelName")?.to_owned(),
            guid: root.text(token)?.to_owned(),
            version: root.optional("version").map(str::to_owned),
            units: read_units(root, "UnitDefinitions")?,
            co_simulation: root.child("CoSimulation").map(|own| read_co_simulation(own, fmi)).transpose()?,
            ..Interface::default()
        };
        if let Some(experiment) = root.child("DefaultExperiment") {
            interface.start = experiment.number("startTime")?;
            interface.stop = experiment.number("stopTime")?;
            interface.step = experiment.number("stepSize")?;
            let tolerance = experiment.number("tolerance")?;
            interface.tolerance = tolerance.filter(|tolerance| *tolerance > 0.0 && tolerance.is_finite());
        }
        variables::read_variables(&mut interface, root)?;
        Ok(interface)
    }

    /// Returns a variable by name, whole.
    pub fn variable(&self, name: &str) -> Option<&FmuVariable> {
        self.places.get(name).map(|&place| &self.variables[place])
    }

    /// Returns the definition of a unit.
    pub fn unit(&self, name: &str) -> Option<&SspUnit> {
        self.units.get(name)
    }

    /// Returns the unit of a variable.
    pub fn unit_of<'a>(&'a self, variable: &'a FmuVariable) -> UnitOf<'a> {
        let name = variable.unit.as_deref();
        (name, name.and_then(|name| self.unit(name)))
    }

    /// Adds a name of the variable at a place, with its value reference.
    fn add_name(&mut self, name: &str, place: usize, reference: u32, element: Element) -> Result<()> {
        if let Some(other) = self.places.insert(name.to_owned(), place) {
            let other = self.variables.get(other).map_or(reference, |other| other.reference);
            let why =
                format!("two variables have this name, with the value references {other} and {reference}");
            return Err(element.wrong("name", why).into());
        }
        Ok(())
    }
}

/// \[byte\] Of a modelIdentifier: with a platform's suffix it is the name of a file.
const LONGEST_IDENTIFIER: usize = 200;

/// Reads a modelIdentifier, which must be what FMI wants, an identifier of C: it is a part of the path of a library that is
/// loaded.
fn identifier(element: Element<'_>) -> Result<&str> {
    let name = element.text("modelIdentifier")?;
    if name.len() > LONGEST_IDENTIFIER {
        let length = name.len();
        let why = format!("modelIdentifier has {length} bytes: must have at most {LONGEST_IDENTIFIER}");
        return Err(element.problem(why).into());
    }
    let letters = name.bytes().all(|byte| byte == b'_' || byte.is_ascii_alphanumeric());
    if !letters || name.is_empty() || name.as_bytes()[0].is_ascii_digit() {
        let why = "must be a name in C: letters from A to Z, digits and _, without a digit at the beginning";
        return Err(element.wrong("modelIdentifier", why).into());
    }
    Ok(name)
}

fn read_co_simulation(element: Element, fmi: Version) -> Result<CoSimulation> {
    let flag = |name| lemons_core::xml::Result::Ok(element.boolean(name)?.unwrap_or(false));
    let [state, serialize] = match fmi {
        Version::V2 => ["canGetAndSetFMUstate", "canSerializeFMUstate"],
        Version::V3 => ["canGetAndSetFMUState", "canSerializeFMUState"],
    };
    Ok(CoSimulation {
        identifier: identifier(element)?.to_owned(),
        cannot_use_memory_functions: fmi == Version::V3 || flag("canNotUseMemoryManagementFunctions")?,
        can_get_and_set_state: flag(state)?,
        can_serialize_state: flag(serialize)?,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_crowds_own_description_is_read() {
        let interface = Interface::read(include_bytes!("../../../../fmu/modelDescription.xml")).unwrap();
        let input = interface.variable("agent[2].Fp.x").unwrap();
        assert_eq!(
            (input.kind, input.of, input.unit.as_deref()),
            (Some(Causality::Input), FmiType::Real, Some("N"))
        );
        assert_eq!(interface.unit("N").unwrap().exponents, [1, 1, -2, 0, 0, 0, 0, 0]);
        assert_eq!(interface.variable("agent[2].AgentContacts").unwrap().of, FmiType::Integer);
        assert_eq!((interface.start, interface.stop, interface.step), (Some(0.0), Some(5.0), Some(0.05)));
        let own = interface.co_simulation.as_ref().unwrap();
        assert_eq!(own.identifier, "CrowdMechanics");
        assert!(own.can_get_and_set_state && own.can_serialize_state && own.cannot_use_memory_functions);
        assert_eq!(input.start_of(0), Some("0.0"));
        assert!(interface.guid.starts_with('{') && !interface.model_name.is_empty());
        assert!(input.description.as_ref().is_some_and(|text| !text.is_empty()));
    }

    #[test]
    fn a_declared_type_gives_the_unit() {
        let text = br#"<fmiModelDescription fmiVersion="2.0" modelName="m" guid="g"><TypeDefinitions>
            <SimpleType name="Length"><Real unit="m"/></SimpleType>
            <SimpleType name="Force"><Real unit="N"/></SimpleType></TypeDefinitions><ModelVariables>
            <ScalarVariable name="f" valueReference="7"><Real declaredType="Force"/></ScalarVariable>
            </ModelVariables></fmiModelDescription>"#;
        let interface = Interface::read(text).unwrap();
        let variable = interface.variable("f").unwrap();
        assert_eq!((variable.kind, variable.unit.as_deref(), variable.reference), (None, Some("N"), 7));
    }
}
