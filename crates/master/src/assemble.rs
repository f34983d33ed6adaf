//! An `.ssp` -> a system of instances, connected and with its parameters set.

use crate::error::{Error, Place, Result};
use crate::fmu::Fmu;
use crate::kind::Kind as FileKind;
use crate::system::{Algorithm, Component, System, Wire, Wires, component_of};
use lemons_files::Scratch;
use lemons_ssp::{
    Affine, Allowance, Archive, Connector, Interface, Kind, ParameterSet, SystemStructure, Type, Unit, Value,
    conversion, located,
};
use std::fs::File;
use std::path::Path;

/// What an `.ssp` holds, ready to be initialized.
pub struct Assembled {
    /// Not yet initialized.
    pub system: System,
    /// \[s\] `DefaultExperiment` of the structure
    pub start: Option<f64>,
    /// \[s\] `DefaultExperiment` of the structure
    pub stop: Option<f64>,
    /// Parameter values that no component has a variable for: SSP wants them ignored.
    pub ignored: Vec<String>,
}

/// Reads an `.ssp`, loads its FMUs, connects them and sets their parameters.
///
/// # Errors
/// The archive or one of its files is broken, holds what is not served, or does not fit together.
pub fn assemble(path: &Path, algorithm: Algorithm) -> Result<Assembled> {
    FileKind::expect(path, &FileKind::ARCHIVES, "an SSP")?;
    assemble_archive(path, algorithm).place(|| path.display().to_string())
}

fn assemble_archive(path: &Path, algorithm: Algorithm) -> Result<Assembled> {
    let mut archive = Archive::open(path)?;
    let structure = archive.structure()?;
    let mut allowance = Allowance::new(Allowance::FMUS);
    let mut components = Vec::with_capacity(structure.components.len());
    for described in &structure.components {
        let wrong = |error: Error| {
            let (line, source, why) = (described.line, &described.source, error.whole());
            Error::ssp(located(line, "Component", "source", source, why))
        };
        let fmu = unpack(&mut archive, &described.source, &mut allowance).map_err(wrong)?;
        let fmu = fmu.shown_as(&described.source);
        for connector in &described.connectors {
            check(connector, &fmu.description, &structure)?;
        }
        let instance = fmu.instantiate(&described.name).map_err(wrong)?;
        components.push(Component { name: described.name.clone(), fmu, instance });
    }
    let ignored = set_parameters(&structure, &components)?;
    let mut system = System::new(components, algorithm);
    connect(&mut system, &structure)?;
    Ok(Assembled { system, start: structure.start, stop: structure.stop, ignored })
}

fn unpack(archive: &mut Archive, source: &str, allowance: &mut Allowance) -> Result<Fmu> {
    let scratch = Scratch::new().map_err(Error::io("cannot make a temporary directory"))?;
    let path = scratch.path().join("component.fmu");
    let mut file = File::create(&path).map_err(Error::io("cannot make a temporary file"))?;
    archive.copy(source, &mut file, allowance)?;
    Fmu::unzip(&path, allowance)
}

/// Whether the FMU has the variable that a connector names, of that kind, type and unit.
fn check(connector: &Connector, interface: &Interface, structure: &SystemStructure) -> Result<()> {
    let wrong = |why: String| Error::ssp(located(connector.line, "Connector", "name", &connector.name, why));
    let variable = interface.variable(&connector.name);
    let variable = variable.ok_or_else(|| wrong("the FMU has no such variable".into()))?;
    if variable.kind != Some(connector.kind) {
        let kind = variable.kind.map_or("neither input nor output", Kind::name);
        return Err(wrong(format!("kind={:?}, but the FMU says {kind}", connector.kind.name())));
    }
    let Some(of) = &connector.of else { return Ok(()) };
    if of.name() != variable.of.name() {
        return Err(wrong(format!("<{}>, but the FMU says {}", of.name(), variable.of.name())));
    }
    let (here, there) = (of.unit(), variable.of.unit());
    let definition = here.and_then(|unit| structure.unit(unit));
    let same = conversion((here, definition), (there, there.and_then(|unit| interface.unit(unit))));
    if same != Ok(Affine::IDENTITY) {
        let (here, there) = (here.unwrap_or_default(), there.unwrap_or_default());
        return Err(wrong(format!("unit={here:?}, but the FMU says {there:?}")));
    }
    Ok(())
}

fn connect(system: &mut System, structure: &SystemStructure) -> Result<()> {
    let mut wires = Wires::default();
    let interface = |component: usize| &system.components()[component].fmu.description;
    for connection in &structure.connections {
        let line = connection.line;
        let ((source, output), (_, input)) = (structure.port(connection.from), structure.port(connection.to));
        let wrong = |why: String| {
            let text = format!("{} of {:?}: {why}", output.name, source.name);
            Error::ssp(located(line, "Connection", "endConnector", &input.name, format!("from {text}")))
        };
        let variable = |connector: &Connector, component: usize| {
            let variable = interface(component).variable(&connector.name);
            variable.ok_or_else(|| wrong("the FMU has no such variable".into()))
        };
        let from = variable(output, connection.from.component)?;
        let to = variable(input, connection.to.component)?;
        if from.of.name() != to.of.name() {
            return Err(wrong(format!("{} does not become {}", from.of.name(), to.of.name())));
        }
        let list = match from.of {
            Type::Real(_) => &mut wires.reals,
            Type::Integer => &mut wires.integers,
            Type::Boolean => &mut wires.booleans,
            Type::String => &mut wires.strings,
            Type::Enumeration(_) | Type::Binary => {
                return Err(wrong(format!("type {} is not served", from.of.name())));
            }
        };
        let mut map = Affine::IDENTITY;
        if !connection.suppress_unit_conversion {
            let a = unit_of(output, interface(connection.from.component), structure);
            let b = unit_of(input, interface(connection.to.component), structure);
            map = conversion(a, b).map_err(wrong)?;
        }
        if let Some(transformation) = connection.transformation {
            if !matches!(from.of, Type::Real(_)) {
                return Err(wrong(format!("no <LinearTransformation> for type {}", from.of.name())));
            }
            map = map.then(transformation);
        }
        list.push(Wire {
            from: (connection.from.component, from.reference),
            to: (connection.to.component, to.reference),
            map,
        });
    }
    system.connect(&wires);
    Ok(())
}

/// The unit of a connector, which is the variable's if the connector says none.
fn unit_of<'a>(
    connector: &'a Connector,
    interface: &'a Interface,
    structure: &'a SystemStructure,
) -> (Option<&'a str>, Option<&'a Unit>) {
    if let Some(name) = connector.of.as_ref().and_then(Type::unit) {
        return (Some(name), structure.unit(name).or_else(|| interface.unit(name)));
    }
    let name = interface.variable(&connector.name).and_then(|variable| variable.of.unit());
    (name, name.and_then(|name| interface.unit(name)))
}

/// Sets the parameter values, those of the components first; returns those for which no component has a variable.
fn set_parameters(structure: &SystemStructure, components: &[Component]) -> Result<Vec<String>> {
    let mut ignored = Vec::new();
    let own = structure.components.iter().enumerate();
    let own =
        own.flat_map(|(place, component)| component.parameters.iter().map(move |set| (set, Some(place))));
    for (set, owner) in own.chain(structure.parameters.iter().map(|set| (set, None))) {
        for parameter in &set.parameters {
            let wrong = |error: Error| {
                let (file, line, why) = (&set.file, parameter.line, error.whole());
                Error::Coupling(format!("{file}:{line}: <Parameter> name={:?}: {why}", parameter.name))
            };
            let target = match owner {
                Some(place) => Some((place, parameter.name.as_str())),
                None => component_of(components, &parameter.name),
            };
            let found = target.filter(|(place, name)| components[*place].fmu.kind(name).is_some());
            let Some((place, name)) = found else {
                ignored.push(format!(
                    "{}:{}: <Parameter> name={:?}: there is no such variable, ignored",
                    set.file, parameter.line, parameter.name
                ));
                continue;
            };
            set_parameter(&components[place], name, &parameter.value, set, structure).map_err(wrong)?;
        }
    }
    Ok(ignored)
}

fn set_parameter(
    component: &Component,
    name: &str,
    value: &Value,
    set: &ParameterSet,
    structure: &SystemStructure,
) -> Result<()> {
    let (instance, interface) = (&component.instance, &component.fmu.description);
    let Some(variable) = interface.variable(name) else { return Err(Error::NoVariable(name.to_owned())) };
    let reference = [variable.reference];
    match (value, &variable.of) {
        (Value::Real(value, unit), Type::Real(own)) => {
            let defined = |name: &String| {
                set.units.get(name).or_else(|| structure.unit(name)).or_else(|| interface.unit(name))
            };
            let own_definition = own.as_ref().and_then(|name| interface.unit(name));
            let map = conversion(
                (unit.as_deref(), unit.as_ref().and_then(defined)),
                (own.as_deref(), own_definition),
            );
            instance.set_real(&reference, &[map.map_err(Error::Coupling)?.apply(*value)])
        }
        (Value::Integer(value), Type::Real(_)) => instance.set_real(&reference, &[f64::from(*value)]),
        (Value::Integer(value), Type::Integer) => instance.set_integer(&reference, &[*value]),
        (Value::Boolean(value), Type::Boolean) => instance.set_boolean(&reference, &[i32::from(*value)]),
        (Value::String(value), Type::String) => instance.set_string(&reference, &[value]),
        (_, of) => Err(Error::Coupling(format!("the FMU's variable is of type {}", of.name()))),
    }
}
