//! The variables and units of an FMU 2.0, from its `modelDescription.xml`.
//!
//! `fmi-rs` 0.3.4 reads neither the unit definitions nor more than one type definition of an FMI 2.0 file.

use crate::document::{Kind, Type};
use crate::read::read_unit;
use crate::unit::Unit;
use crate::xml::{Document, Element};
use anyhow::Result;
use std::collections::HashMap;

/// What can be connected.
#[derive(Debug, Clone, Default)]
pub struct Interface {
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
    /// Whether the FMU is for co-simulation.
    pub co_simulation: bool,
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
}

impl Interface {
    /// Reads a `modelDescription.xml`.
    ///
    /// # Errors
    /// It is broken.
    pub fn read(bytes: &[u8]) -> Result<Interface> {
        let document = Document::parse("modelDescription.xml", bytes)?;
        let root = document.root("fmiModelDescription")?;
        let mut interface =
            Interface { co_simulation: root.child("CoSimulation").is_some(), ..Interface::default() };
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
            interface.places.insert(variable.name.clone(), interface.variables.len());
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

fn read_variable(element: Element, declared: &HashMap<&str, &str>) -> Result<Variable> {
    let causality = element.optional("causality").unwrap_or("local");
    let kind = Kind::NAMES.iter().find(|(name, _)| *name == causality).map(|(_, kind)| *kind);
    let typed = element.elements().find_map(|child| {
        let declared_type = child.optional("declaredType");
        Some(match child.name() {
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
        })
    });
    Ok(Variable {
        name: element.text("name")?.to_owned(),
        reference: element
            .parsed("valueReference", "a number from 0 to 4294967295")?
            .ok_or_else(|| element.problem("has no valueReference"))?,
        kind,
        of: typed.ok_or_else(|| element.problem("has no type"))?,
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
        assert!(interface.co_simulation);
    }

    #[test]
    fn a_declared_type_gives_the_unit() {
        let text = br#"<fmiModelDescription><TypeDefinitions>
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
