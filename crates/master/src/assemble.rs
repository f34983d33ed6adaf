//! An `.ssp` -> a system of instances, connected and with its parameters set.

use crate::error::{ErrorPlace, MasterError, Result, require, scratch};
use crate::file_type::FileType;
use crate::fmu::Fmu;
use crate::instance::number;
use crate::ssp::{
    Affine, Allowance, ArchiveReader, Causality, Connection, Connector, Extent, FmiType, FmuVariable,
    Interface, Port, Single, SspParameter, SystemStructure, UnitOf, conversion, place_of, written, wrong_at,
};
use crate::system::{System, SystemComponent, Wire, component_of};
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
    let mut archive = ArchiveReader::open(path)?;
    let structure = archive.structure()?;
    let mut allowance = Allowance::new(Allowance::FMUS);
    let mut components = Vec::with_capacity(structure.components.len());
    for (place, described) in structure.components.iter().enumerate() {
        let wrong = |error: MasterError| wrong_at(&described.place, error.whole());
        let mut fmu = unpack(&mut archive, &described.source, &mut allowance).map_err(wrong)?;
        let parameters = texts(&structure, place, further);
        fmu.configure(parameters.into_iter()).map_err(wrong)?;
        let fmu = fmu.shown_as(&described.source);
        for (name, connector) in &described.connectors {
            meaning(name, connector, &fmu.description, &structure)?;
        }
        let instance = fmu.instantiate(&described.name).map_err(wrong)?;
        components.push(SystemComponent { name: described.name.clone(), fmu: Arc::new(fmu), instance });
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
    let own = &structure.components[place].name;
    let inside = |name: &'a str| name.strip_prefix(own.as_str())?.strip_prefix('.');
    let parameters =
        structure.parameters.iter().map(|SspParameter { component, name, text, .. }| match component {
            Some(component) => (Some(name.as_str()).filter(|_| *component == place), text.as_str()),
            None => (inside(name), text.as_str()),
        });
    let further = further.iter().map(|(name, text)| (inside(name), text.as_str()));
    parameters.chain(further).filter_map(|(name, text)| Some((name?, text))).collect()
}

fn unpack(archive: &mut ArchiveReader, source: &str, allowance: &mut Allowance) -> Result<Fmu> {
    let directory = scratch()?;
    let path = directory.path().join("component.fmu");
    let mut file = File::create(&path).place(|| "cannot make a temporary file".to_owned())?;
    archive.copy(source, &mut file, allowance)?;
    Fmu::unzip(&path, allowance)
}

/// The meaning of a connector in the FMU: a variable as a whole, or an element of an array by the element's name; and the unit.
struct Meaning<'a> {
    variable: &'a FmuVariable,
    element: Option<usize>,
    unit: UnitOf<'a>,
}

/// Finds the variable that a connector names, which must be of that kind, type, unit and size.
fn meaning<'a>(
    name: &str,
    connector: &'a Connector,
    interface: &'a Interface,
    structure: &'a SystemStructure,
) -> Result<Meaning<'a>> {
    let wrong = |why: String| wrong_at(&connector.place, why);
    let whole = interface.variable(name).map(|variable| (variable, None));
    let found = whole.or_else(|| interface.single(name).map(|it| (it.variable, Some(it.element))));
    let (variable, element) = found.ok_or_else(|| wrong("the FMU has no such variable".into()))?;
    if variable.kind != Some(connector.kind) {
        let kind = variable.kind.map_or("neither input nor output", Causality::name);
        return Err(wrong(format!("kind={:?}, but the FMU says {kind}", connector.kind.name())));
    }
    if element.is_none() || !connector.dimensions.is_empty() {
        check_sizes(connector, variable, interface).map_err(wrong)?;
    }
    let own = interface.unit_of(variable);
    let Some(of) = connector.of else { return Ok(Meaning { variable, element, unit: own }) };
    let classes = [of, variable.of].map(FmiType::class);
    if classes[0] != classes[1] {
        return Err(wrong(format!("<{}>, but the FMU says {}", classes[0], classes[1])));
    }
    let stated = connector.unit.as_deref();
    let definition = stated.and_then(|name| structure.units.get(name));
    if conversion((stated, definition), own) != Ok(Affine::IDENTITY) {
        let (stated, own) = (stated.unwrap_or_default(), own.0.unwrap_or_default());
        return Err(wrong(format!("unit={stated:?}, but the FMU says {own:?}")));
    }
    // The unit is the variable's if the connector says none.
    let unit = stated.map_or(own, |name| (stated, definition.or_else(|| interface.unit(name))));
    Ok(Meaning { variable, element, unit })
}

/// Checks that the dimensions of a connector are those of the FMU.
fn check_sizes(connector: &Connector, variable: &FmuVariable, interface: &Interface) -> Result<(), String> {
    let (stated, own) = (&connector.dimensions, &variable.dimensions);
    require(stated.len() == own.len(), || {
        format!("it has {} <Dimension>, but the FMU has an array of {}", stated.len(), own.len())
    })?;
    for (stated, own) in stated.iter().zip(own) {
        let size = match stated {
            Extent::Unsaid => continue,
            Extent::Size(size) => *size,
            Extent::Parameter(name) => {
                let parameter = interface.variable(name);
                let parameter = parameter.filter(|it| it.kind == Some(Causality::StructuralParameter));
                let size = parameter.and_then(|parameter| parameter.start_of(0)?.parse().ok());
                let none = || format!("sizeConnector={name:?}: the FMU has no such structural parameter");
                size.ok_or_else(none)?
            }
        };
        let other = || format!("its <Dimension> says {size}, but the FMU has {} there", own.size);
        require(size == own.size as u64, other)?;
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
    let fits = given == own && end.element.is_none();
    require(fits, || format!("{name:?} has {own} dimensions, not {given}"))?;
    let place = place_of(dimensions, indices)
        .ok_or_else(|| format!("{name:?} has no element {}: indices are from 1 on", written(indices)))?;
    Ok(place..place + 1)
}

fn connect<'a>(interfaces: &'a [Arc<Interface>], structure: &'a SystemStructure) -> Result<Vec<Wire<'a>>> {
    let mut wires = Vec::new();
    // The lines of the connections that feed inputs.
    let mut lines = HashMap::new();
    for Connection { from, to, transformation, suppress_unit_conversion, place } in &structure.connections {
        let source = &structure.components[from.component].name;
        let wrong = |why: String| wrong_at(place, format!("from {} of {source:?}: {why}", from.connector));
        let mean = |port: &'a Port| {
            let (_, connector) = structure.port(port);
            meaning(&port.connector, connector, &interfaces[port.component], structure)
        };
        let (start, end) = (mean(from)?, mean(to)?);
        let sent = values(&start, &from.connector, &from.indices).map_err(wrong)?;
        let taken = values(&end, &to.connector, &to.indices).map_err(wrong)?;
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
            if here.of.class() != FmiType::Real {
                return Err(wrong(format!("no <LinearTransformation> for type {}", here.of.class())));
            }
            map = map.then(*transformation);
        }
        for (sent, taken) in sent.zip(taken) {
            if let Some(Some(line)) = lines.insert((to.component, &there.name, taken), place.line) {
                return Err(wrong(format!("line {line} feeds this input already")));
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
fn elements(variable: &FmuVariable, values: &Range<usize>) -> String {
    if values.len() == 1 || !variable.is_array() {
        return "a single value".to_owned();
    }
    let sizes: Vec<String> = variable.sizes().iter().map(usize::to_string).collect();
    format!("an array of {}", sizes.join(" x "))
}

/// Sets the parameter values, those of the components first; returns those for which no component has a variable.
fn set_parameters(structure: &SystemStructure, components: &[SystemComponent]) -> Result<Vec<String>> {
    let mut ignored = Vec::new();
    for parameter in &structure.parameters {
        let target = match parameter.component {
            Some(place) => Some((place, parameter.name.as_str())),
            None => component_of(components, &parameter.name),
        };
        let found = target.filter(|(place, name)| components[*place].fmu.kind(name).is_some());
        let Some((place, name)) = found else {
            let why = wrong_at(&parameter.place, "there is no such variable, ignored");
            ignored.push(format!("warning: {why}"));
            continue;
        };
        if !components[place].fmu.is_structural(name) {
            set_parameter(&components[place], name, parameter)
                .map_err(|error| wrong_at(&parameter.place, error.whole()))?;
        }
    }
    Ok(ignored)
}

fn set_parameter(component: &SystemComponent, name: &str, parameter: &SspParameter) -> Result<()> {
    let (instance, interface) = (&component.instance, &component.fmu.description);
    let variable = interface.known(name)?.variable;
    let SspParameter { of, unit, definition, text, .. } = parameter;
    let [given, own] = [*of, variable.of].map(FmiType::class);
    if (given, own) == (FmiType::Real, FmiType::Real) {
        let unit = unit.as_deref();
        let definition = definition.as_ref().or_else(|| interface.unit(unit?));
        let value: f64 = number(text).place(|| format!("{name}={text}: not a number"))?;
        let value = conversion((unit, definition), interface.unit_of(variable))?.apply(value);
        return instance.set(&instance.select([name])?, &[value]);
    }
    let fits = given == own || (given, own) == (FmiType::Integer, FmiType::Real);
    require(fits, || format!("the FMU's variable is of type {own}"))?;
    instance.set_text(&[name], text)
}
