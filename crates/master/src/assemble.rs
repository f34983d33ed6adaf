//! An `.ssp` -> a system of instances, connected and with its parameters set.

use crate::channel::Wire;
use crate::error::{Error, Place, Result, ensure, scratch};
use crate::file_type::FileType;
use crate::fmu::Fmu;
use crate::instance::number;
use crate::ssp::{
    Affine, Allowance, Archive, Connection, Connector, Extent, Interface, Kind, Parameter, ParameterSet,
    Single, SystemStructure, Type, UnitOf, Variable, conversion, located, place_of, written,
};
use crate::system::{Component, System, component_of};
use lemons_sim::Algorithm;
use std::collections::HashMap;
use std::fs::File;
use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

/// The system of an `.ssp`, ready to be initialized.
pub struct Assembled {
    /// Not yet initialized.
    pub system: System,
    /// \[s\] `DefaultExperiment` of the structure
    pub start: Option<f64>,
    /// \[s\] `DefaultExperiment` of the structure
    pub stop: Option<f64>,
    /// Warnings: parameter values that no component has a variable for, which SSP wants ignored.
    pub warnings: Vec<String>,
}

/// Reads an `.ssp`, loads its FMUs, connects them and sets their parameters. Of `further` parameters, whose names are
/// `component.name`, only those are used that choose the sizes of arrays: they must be known before.
///
/// # Errors
/// The archive or one of its files is broken, holds what is not served, or does not fit together.
pub fn assemble(path: &Path, algorithm: Algorithm, further: &[(String, String)]) -> Result<Assembled> {
    FileType::expect(path, &FileType::ARCHIVES, "an SSP")?;
    assemble_archive(path, algorithm, further).place(|| path.display().to_string())
}

fn assemble_archive(path: &Path, algorithm: Algorithm, further: &[(String, String)]) -> Result<Assembled> {
    let mut archive = Archive::open(path)?;
    let structure = archive.structure()?;
    let mut allowance = Allowance::new(Allowance::FMUS);
    let mut components = Vec::with_capacity(structure.components.len());
    for (place, described) in structure.components.iter().enumerate() {
        let wrong = |error: Error| {
            let (line, source, why) = (described.line, &described.source, error.whole());
            Error::from(located(line, "Component", "source", source, why))
        };
        let mut fmu = unpack(&mut archive, &described.source, &mut allowance).map_err(wrong)?;
        let parameters = texts(&structure, place, further);
        fmu.configure(parameters.into_iter()).map_err(wrong)?;
        let fmu = fmu.shown_as(&described.source);
        for connector in &described.connectors {
            meaning(connector, &fmu.description, &structure)?;
        }
        let instance = fmu.instantiate(&described.name).map_err(wrong)?;
        components.push(Component { name: described.name.clone(), fmu: Arc::new(fmu), instance });
    }
    let warnings = set_parameters(&structure, &components)?;
    let descriptions: Vec<_> = components.iter().map(|component| component.fmu.description.clone()).collect();
    let wires = connect(&descriptions, &structure)?;
    let system = System::new(components, algorithm, &wires, structure.connections.len());
    Ok(Assembled { system, start: structure.start, stop: structure.stop, warnings })
}

/// Returns the parameters of a component, in the order in which they count.
fn texts<'a>(
    structure: &'a SystemStructure,
    place: usize,
    further: &'a [(String, String)],
) -> Vec<(&'a str, &'a str)> {
    let own = &structure.components[place];
    let inside = |name: &'a str| name.strip_prefix(own.name.as_str())?.strip_prefix('.');
    let of = |sets: &'a [ParameterSet]| sets.iter().flat_map(|set| &set.parameters);
    let own = of(&own.parameters).map(|parameter| (Some(parameter.name.as_str()), parameter.text.as_str()));
    let outer = of(&structure.parameters).map(|parameter| (inside(&parameter.name), parameter.text.as_str()));
    let further = further.iter().map(|(name, text)| (inside(name), text.as_str()));
    own.chain(outer).chain(further).filter_map(|(name, text)| Some((name?, text))).collect()
}

fn unpack(archive: &mut Archive, source: &str, allowance: &mut Allowance) -> Result<Fmu> {
    let directory = scratch()?;
    let path = directory.path().join("component.fmu");
    let mut file = File::create(&path).place(|| "cannot make a temporary file".to_owned())?;
    archive.copy(source, &mut file, allowance)?;
    Fmu::unzip(&path, allowance)
}

/// The meaning of a connector in the FMU: a variable as a whole, or an element of an array by the element's name; and the unit.
struct Meaning<'a> {
    variable: &'a Variable,
    element: Option<usize>,
    unit: UnitOf<'a>,
}

/// Finds the variable that a connector names, which must be of that kind, type, unit and size.
fn meaning<'a>(
    connector: &'a Connector,
    interface: &'a Interface,
    structure: &'a SystemStructure,
) -> Result<Meaning<'a>> {
    let name = &connector.name;
    let wrong = |why: String| Error::from(located(connector.line, "Connector", "name", name, why));
    let whole = interface.variable(name).map(|variable| (variable, None));
    let found = whole.or_else(|| interface.single(name).map(|it| (it.variable, Some(it.element))));
    let (variable, element) = found.ok_or_else(|| wrong("the FMU has no such variable".into()))?;
    if variable.kind != Some(connector.kind) {
        let kind = variable.kind.map_or("neither input nor output", Kind::name);
        return Err(wrong(format!("kind={:?}, but the FMU says {kind}", connector.kind.name())));
    }
    if element.is_none() || !connector.dimensions.is_empty() {
        check_sizes(connector, variable, interface).map_err(wrong)?;
    }
    let own = interface.unit_of(variable);
    let Some(of) = connector.of else { return Ok(Meaning { variable, element, unit: own }) };
    let classes = [of, variable.of].map(Type::class);
    if classes[0] != classes[1] {
        return Err(wrong(format!("<{}>, but the FMU says {}", classes[0], classes[1])));
    }
    let said = connector.unit.as_deref();
    let definition = said.and_then(|name| structure.units.get(name));
    if conversion((said, definition), own) != Ok(Affine::IDENTITY) {
        let (said, own) = (said.unwrap_or_default(), own.0.unwrap_or_default());
        return Err(wrong(format!("unit={said:?}, but the FMU says {own:?}")));
    }
    // The unit is the variable's if the connector says none.
    let unit = said.map_or(own, |name| (said, definition.or_else(|| interface.unit(name))));
    Ok(Meaning { variable, element, unit })
}

/// Checks that the dimensions of a connector are those of the FMU.
fn check_sizes(connector: &Connector, variable: &Variable, interface: &Interface) -> Result<(), String> {
    let (said, own) = (&connector.dimensions, &variable.dimensions);
    if said.len() != own.len() {
        let (said, own) = (said.len(), own.len());
        return Err(format!("it has {said} <Dimension>, but the FMU has an array of {own}"));
    }
    for (said, own) in said.iter().zip(own) {
        let size = match said {
            Extent::Unsaid => continue,
            Extent::Size(size) => *size,
            Extent::Parameter(name) => {
                let parameter =
                    interface.variable(name).filter(|it| it.kind == Some(Kind::StructuralParameter));
                let size = parameter.and_then(|parameter| parameter.start_of(0)?.parse().ok());
                size.ok_or_else(|| {
                    format!("sizeConnector={name:?}: the FMU has no such structural parameter")
                })?
            }
        };
        if size != own.size as u64 {
            return Err(format!("its <Dimension> says {size}, but the FMU has {} there", own.size));
        }
    }
    Ok(())
}

/// Returns which values of its variable an end of a connection means.
fn values(end: &Meaning, name: &str, indices: &[usize]) -> Result<Range<usize>, String> {
    let dimensions = &end.variable.dimensions;
    if indices.is_empty() {
        return Ok(end.element.map_or(0..end.variable.count(), |element| element..element + 1));
    }
    let (given, own) = (indices.len(), dimensions.len());
    if given != own || end.element.is_some() {
        return Err(format!("{name:?} has {own} dimensions, not {given}"));
    }
    let place = place_of(dimensions, indices)
        .ok_or_else(|| format!("{name:?} has no element {}: indices are from 1 on", written(indices)))?;
    Ok(place..place + 1)
}

fn connect<'a>(interfaces: &'a [Arc<Interface>], structure: &'a SystemStructure) -> Result<Vec<Wire<'a>>> {
    let mut wires = Vec::new();
    // The lines of the connections that feed inputs.
    let mut lines = HashMap::new();
    for Connection { from, to, transformation, suppress_unit_conversion, line } in &structure.connections {
        let ((source, output), (_, input)) = (structure.port(from), structure.port(to));
        let wrong = |why: String| {
            let why = format!("from {} of {:?}: {why}", output.name, source.name);
            Error::from(located(*line, "Connection", "endConnector", &input.name, why))
        };
        let start = meaning(output, &interfaces[from.component], structure)?;
        let end = meaning(input, &interfaces[to.component], structure)?;
        let sent = values(&start, &output.name, &from.indices).map_err(wrong)?;
        let taken = values(&end, &input.name, &to.indices).map_err(wrong)?;
        let (here, there) = (start.variable, end.variable);
        here.of.check_sent_to(there.of).map_err(wrong)?;
        if sent.len() != taken.len() || (sent.len() > 1 && here.sizes() != there.sizes()) {
            let what = [elements(here, &sent), elements(there, &taken)];
            return Err(wrong(format!("{} does not become {}", what[0], what[1])));
        }
        let mut map = Affine::IDENTITY;
        if !suppress_unit_conversion {
            map = conversion(start.unit, end.unit).map_err(wrong)?;
        }
        if let Some(transformation) = transformation {
            if here.of.class() != Type::Real {
                return Err(wrong(format!("no <LinearTransformation> for type {}", here.of.class())));
            }
            map = map.then(*transformation);
        }
        for (sent, taken) in sent.zip(taken) {
            if let Some(first) = lines.insert((to.component, &there.name, taken), line) {
                return Err(wrong(format!("line {first} feeds this input already")));
            }
            wires.push(Wire {
                from: (from.component, Single { variable: here, element: sent }),
                to: (to.component, Single { variable: there, element: taken }),
                map,
            });
        }
    }
    wires.sort_by_key(|wire| wire.from.1.variable.of.class());
    Ok(wires)
}

/// Says how many values of a variable.
fn elements(variable: &Variable, values: &Range<usize>) -> String {
    if values.len() == 1 || !variable.is_array() {
        return "a single value".to_owned();
    }
    let sizes: Vec<String> = variable.sizes().iter().map(usize::to_string).collect();
    format!("an array of {}", sizes.join(" x "))
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
                Error::new(format!("{file}:{line}: <Parameter> name={:?}: {why}", parameter.name))
            };
            let target = match owner {
                Some(place) => Some((place, parameter.name.as_str())),
                None => component_of(components, &parameter.name),
            };
            let found = target.filter(|(place, name)| components[*place].fmu.kind(name).is_some());
            let Some((place, name)) = found else {
                ignored.push(format!(
                    "warning: {}:{}: <Parameter> name={:?}: there is no such variable, ignored",
                    set.file, parameter.line, parameter.name
                ));
                continue;
            };
            if components[place].fmu.is_structural(name) {
                continue;
            }
            set_parameter(&components[place], name, parameter, set, structure).map_err(wrong)?;
        }
    }
    Ok(ignored)
}

fn set_parameter(
    component: &Component,
    name: &str,
    parameter: &Parameter,
    set: &ParameterSet,
    structure: &SystemStructure,
) -> Result<()> {
    let (instance, interface) = (&component.instance, &component.fmu.description);
    let variable = interface.known(name)?.variable;
    let Parameter { of, unit, text, .. } = parameter;
    let [given, own] = [*of, variable.of].map(Type::class);
    if (given, own) == (Type::Real, Type::Real) {
        let defined = |name: &String| {
            set.units.get(name).or_else(|| structure.units.get(name)).or_else(|| interface.unit(name))
        };
        let here = (unit.as_deref(), unit.as_ref().and_then(defined));
        let there = interface.unit_of(variable);
        let value: f64 = number(text).place(|| format!("{name}={text}: not a number"))?;
        let value = conversion(here, there)?.apply(value);
        return instance.set(&instance.select([name])?, &[value]);
    }
    let fits = given == own || (given, own) == (Type::Integer, Type::Real);
    ensure(fits, || format!("the FMU's variable is of type {own}"))?;
    instance.set_text(&[name], text)
}
