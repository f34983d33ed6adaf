//! What an FMU 2.0 says of itself in its `modelDescription.xml`: its names, abilities, variables and units.

use crate::document::{Kind, Type};
use crate::error::Result;
use crate::read::read_unit;
use crate::unit::Unit;
use lemons_xml::{Document, Element};
use std::collections::HashMap;
use std::path::Path;

/// The most elements and texts of a description: more than twice those of the largest that is read (256 MB).
const NODES: u32 = 16_000_000;

/// What an FMU says of itself.
#[derive(Debug, Clone, Default)]
pub struct Interface {
    /// `modelName`
    pub model_name: String,
    /// `guid`, which its library compares with its own.
    pub guid: String,
    /// `version`
    pub version: Option<String>,
    /// `None`: it is not for co-simulation.
    pub co_simulation: Option<CoSimulation>,
    /// `modelIdentifier` of its `<ModelExchange>`
    pub model_exchange: Option<String>,
    /// In the order of the file.
    pub variables: Vec<Variable>,
    places: HashMap<String, usize>,
    units: HashMap<String, Unit>,
    /// \[s\] `DefaultExperiment`
    pub start: Option<f64>,
    /// \[s\] `DefaultExperiment`
    pub stop: Option<f64>,
    /// \[s\] `DefaultExperiment`
    pub step: Option<f64>,
}

/// `<CoSimulation>`
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CoSimulation {
    /// `modelIdentifier`: what its library is called.
    pub identifier: String,
    /// `canNotUseMemoryManagementFunctions`
    pub cannot_use_memory_functions: bool,
    /// `canGetAndSetFMUstate`
    pub can_get_and_set_state: bool,
    /// `canSerializeFMUstate`
    pub can_serialize_state: bool,
}

/// A variable of an FMU.
#[derive(Debug, Clone, PartialEq)]
pub struct Variable {
    /// As the FMU calls it.
    pub name: String,
    /// Of the FMI functions.
    pub reference: u32,
    /// `None` for local and independent variables.
    pub kind: Option<Kind>,
    /// With its unit.
    pub of: Type,
    /// `start`
    pub start: Option<String>,
    /// `description`
    pub description: Option<String>,
}

impl Interface {
    /// Reads a `modelDescription.xml`.
    ///
    /// # Errors
    /// It is broken, or not of FMI 2.0, two variables have one name, or a start value is NaN.
    pub fn read(bytes: &[u8]) -> Result<Interface> {
        let document = Document::parse(Path::new("modelDescription.xml"), bytes, NODES)?;
        let root = document.root("fmiModelDescription")?;
        if root.text("fmiVersion")? != "2.0" {
            return Err(root
                .wrong("fmiVersion", "must be 2.0: FMUs of other versions of FMI cannot be read")
                .into());
        }
        let exchange = root.child("ModelExchange").map(|element| element.text("modelIdentifier"));
        let mut interface = Interface {
            model_name: root.text("modelName")?.to_owned(),
            guid: root.text("guid")?.to_owned(),
            version: root.optional("version").map(str::to_owned),
            co_simulation: root.child("CoSimulation").map(read_co_simulation).transpose()?,
            model_exchange: exchange.transpose()?.map(str::to_owned),
            ..Interface::default()
        };
        if let Some(experiment) = root.child("DefaultExperiment") {
            interface.start = experiment.number("startTime")?;
            interface.stop = experiment.number("stopTime")?;
            interface.step = experiment.number("stepSize")?;
        }
        for unit in root.child("UnitDefinitions").into_iter().flat_map(|units| units.children("Unit")) {
            if let Some(unit) = read_unit(unit)? {
                interface.units.insert(unit.name.clone(), unit);
            }
        }
        let types = root.child("TypeDefinitions").into_iter().flat_map(|types| types.children("SimpleType"));
        let mut declared = HashMap::new();
        for simple in types {
            if let Some(unit) = simple.child("Real").and_then(|real| real.optional("unit")) {
                declared.insert(simple.text("name")?, unit);
            }
        }
        let variables = root.child("ModelVariables").into_iter();
        for element in variables.flat_map(|variables| variables.children("ScalarVariable")) {
            let variable = read_variable(element, &declared)?;
            let place = interface.variables.len();
            if let Some(other) = interface.places.insert(variable.name.clone(), place) {
                let (one, other) = (interface.variables[other].reference, variable.reference);
                let why =
                    format!("two variables have this name, with the value references {one} and {other}");
                return Err(element.wrong("name", &why).into());
            }
            interface.variables.push(variable);
        }
        Ok(interface)
    }

    /// A variable by name.
    pub fn variable(&self, name: &str) -> Option<&Variable> {
        self.places.get(name).map(|&place| &self.variables[place])
    }

    /// The definition of a unit.
    pub fn unit(&self, name: &str) -> Option<&Unit> {
        self.units.get(name)
    }
}

fn read_co_simulation(element: Element) -> Result<CoSimulation> {
    let flag = |name| lemons_xml::Result::Ok(element.boolean(name)?.unwrap_or(false));
    Ok(CoSimulation {
        identifier: element.text("modelIdentifier")?.to_owned(),
        cannot_use_memory_functions: flag("canNotUseMemoryManagementFunctions")?,
        can_get_and_set_state: flag("canGetAndSetFMUstate")?,
        can_serialize_state: flag("canSerializeFMUstate")?,
    })
}

fn read_variable(element: Element, declared: &HashMap<&str, &str>) -> Result<Variable> {
    let causality = element.optional("causality").unwrap_or("local");
    let kind = Kind::NAMES.iter().find(|(name, _)| *name == causality).map(|(_, kind)| *kind);
    let nan = |child: &Element| {
        let start = child.optional("start").and_then(|start| start.trim().parse::<f64>().ok());
        child.name() == "Real" && start.is_some_and(f64::is_nan)
    };
    if let Some(real) = element.elements().find(nan) {
        let variable = element.text("name")?;
        return Err(real.wrong("start", format!("of the variable {variable:?} is not a number")).into());
    }
    let typed = element.elements().find_map(|child| {
        let declared_type = child.optional("declaredType");
        let of = match child.name() {
            "Real" => {
                let unit = child.optional("unit");
                let unit = unit.or_else(|| declared_type.and_then(|name| declared.get(name).copied()));
                Type::Real(unit.filter(|unit| !unit.is_empty()).map(str::to_owned))
            }
            "Integer" => Type::Integer,
            "Boolean" => Type::Boolean,
            "String" => Type::String,
            "Enumeration" => Type::Enumeration(declared_type.unwrap_or_default().to_owned()),
            _ => return None,
        };
        Some((of, child.optional("start").map(str::to_owned)))
    });
    let (of, start) = typed.ok_or_else(|| element.problem("has no type"))?;
    Ok(Variable {
        name: element.text("name")?.to_owned(),
        reference: element
            .parsed("valueReference", "a number from 0 to 4294967295")?
            .ok_or_else(|| element.problem("has no valueReference"))?,
        kind,
        of,
        start,
        description: element.optional("description").map(str::to_owned),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_crowds_own_description_is_read() {
        let interface = Interface::read(include_bytes!("../../../fmu/modelDescription.xml")).unwrap();
        let input = interface.variable("agent[2].Fp.x").unwrap();
        assert_eq!((input.kind, &input.of), (Some(Kind::Input), &Type::Real(Some("N".into()))));
        assert_eq!(interface.unit("N").unwrap().exponents, [1, 1, -2, 0, 0, 0, 0, 0]);
        assert_eq!(interface.variable("agent[2].AgentContacts").unwrap().of, Type::Integer);
        assert_eq!((interface.start, interface.stop, interface.step), (Some(0.0), Some(5.0), Some(0.05)));
        let own = interface.co_simulation.as_ref().unwrap();
        assert_eq!(own.identifier, "CrowdMechanics");
        assert!(own.can_get_and_set_state && own.can_serialize_state && own.cannot_use_memory_functions);
        assert_eq!((interface.model_exchange.as_deref(), input.start.as_deref()), (None, Some("0.0")));
        assert!(interface.guid.starts_with('{') && !interface.model_name.is_empty());
        assert!(input.description.as_ref().is_some_and(|text| !text.is_empty()));
    }

    #[test]
    fn what_makes_no_fmu_of_version_2_is_named() {
        let said = |attributes: &str| {
            let text = format!("<fmiModelDescription {attributes}><ModelVariables/></fmiModelDescription>");
            Interface::read(text.as_bytes()).map_or_else(|error| error.to_string(), |_| "read".to_owned())
        };
        assert_eq!(said("fmiVersion=\"2.0\" modelName=\"m\" guid=\"g\""), "read");
        let place = "modelDescription.xml:1: <fmiModelDescription>";
        assert_eq!(
            said("fmiVersion=\"3.0\" modelName=\"m\""),
            format!("{place} fmiVersion=\"3.0\": must be 2.0: FMUs of other versions of FMI cannot be read")
        );
        assert_eq!(said("modelName=\"m\" guid=\"g\""), format!("{place}: has no fmiVersion"));
        assert_eq!(said("fmiVersion=\"2.0\" guid=\"g\""), format!("{place}: has no modelName"));
        assert_eq!(said("fmiVersion=\"2.0\" modelName=\"m\""), format!("{place}: has no guid"));
    }

    fn said_of_variables(variables: &str) -> String {
        let text = format!(
            "<fmiModelDescription fmiVersion=\"2.0\" modelName=\"m\" guid=\"g\"><ModelVariables>\n{variables}\n\
             </ModelVariables></fmiModelDescription>"
        );
        Interface::read(text.as_bytes()).map_or_else(|error| error.to_string(), |_| "read".to_owned())
    }

    /// `--set` went to the last one.
    #[test]
    fn two_variables_of_one_name_are_refused_with_their_references() {
        let variable = |name: &str, reference: u32| {
            format!(
                "<ScalarVariable name=\"{name}\" valueReference=\"{reference}\"><Real/></ScalarVariable>\n"
            )
        };
        assert_eq!(said_of_variables(&(variable("a", 3) + &variable("b", 3))), "read");
        let said = said_of_variables(&(variable("a", 3) + &variable("b", 4) + &variable("a", 5)));
        let expected = "modelDescription.xml:4: <ScalarVariable> name=\"a\": two variables have this name, with the value \
                        references 3 and 5";
        assert_eq!(said, expected);
    }

    #[test]
    fn a_start_value_that_is_no_number_is_refused() {
        let start = |start: &str| {
            said_of_variables(&format!(
                "<ScalarVariable name=\"a\" valueReference=\"1\"><Real start=\"{start}\"/></ScalarVariable>"
            ))
        };
        assert_eq!(start("1e3"), "read");
        let expected = "modelDescription.xml:2: <Real> start=\"NaN\": of the variable \"a\" is not a number";
        assert_eq!(start("NaN"), expected);
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
        assert_eq!((variable.kind, variable.of.unit(), variable.reference), (None, Some("N"), 7));
        let broken = String::from_utf8_lossy(text).replace("\"7\"", "\"-7\"");
        let said = Interface::read(broken.as_bytes()).unwrap_err().to_string();
        assert!(said.contains("modelDescription.xml:4: <ScalarVariable> valueReference=\"-7\""), "{said}");
    }
}
