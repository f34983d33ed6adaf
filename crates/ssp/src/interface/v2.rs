//! The variables of a description of FMI 2.0: single values.

use super::{Interface, Variable, read_kind, read_reference};
use crate::document::{Native, Type};
use crate::error::Result;
use lemons_xml::Element;
use std::collections::HashMap;

/// The units of declared types, by the names of these.
pub fn declared_units<'a>(root: Element<'a>) -> Result<HashMap<&'a str, &'a str>> {
    let types = root.child("TypeDefinitions").into_iter().flat_map(|types| types.children("SimpleType"));
    let mut declared = HashMap::new();
    for simple in types {
        if let Some(unit) = simple.child("Real").and_then(|real| real.optional("unit")) {
            declared.insert(simple.text("name")?, unit);
        }
    }
    Ok(declared)
}

/// Adds the variables to the interface.
pub fn read_variables(
    interface: &mut Interface,
    root: Element,
    declared: &HashMap<&str, &str>,
) -> Result<()> {
    let variables = root.child("ModelVariables").into_iter();
    for element in variables.flat_map(|variables| variables.children("ScalarVariable")) {
        interface.add(read_variable(element, declared)?, element)?;
    }
    Ok(())
}

fn read_variable(element: Element, declared: &HashMap<&str, &str>) -> Result<Variable> {
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
        let (of, native) = match child.name() {
            "Real" => {
                let unit = child.optional("unit");
                let unit = unit.or_else(|| declared_type.and_then(|name| declared.get(name).copied()));
                let unit = unit.filter(|unit| !unit.is_empty()).map(str::to_owned);
                (Type::Real(unit), Native::Float64)
            }
            "Integer" => (Type::Integer, Native::Int32),
            "Boolean" => (Type::Boolean, Native::Boolean),
            "String" => (Type::String, Native::String),
            "Enumeration" => (Type::Enumeration(declared_type.unwrap_or_default().to_owned()), Native::Int32),
            _ => return None,
        };
        Some((of, native, child.optional("start").map(str::to_owned)))
    });
    let (of, native, start) = typed.ok_or_else(|| element.problem("has no type"))?;
    Ok(Variable {
        name: element.text("name")?.to_owned(),
        reference: read_reference(element)?,
        kind: read_kind(element),
        of,
        native,
        dimensions: Vec::new(),
        start: start.into_iter().collect(),
        description: element.optional("description").map(str::to_owned),
    })
}
