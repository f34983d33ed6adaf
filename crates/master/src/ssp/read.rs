//! `SystemStructure.ssd` and the `.ssv` files that it names -> [`SystemStructure`].

use crate::error::{Result, require};
use crate::ssp::document::{
    Causality, Connection, Connector, Extent, FmiType, Port, STRUCTURE_FILE, SspComponent, SspParameter,
    SystemStructure,
};
use crate::ssp::unit::{Affine, SspUnit};
use lemons_core::xml::{Document, Element};
use std::collections::BTreeMap;
use std::path::Path;

const FMU_TYPE: &str = "application/x-fmu-sharedlibrary";
const PARAMETER_TYPE: &str = "application/x-ssp-parameter-set";
/// The most elements and texts of a file.
const NODES: u32 = 4_000_000;

/// Returns the content of the files that a structure names.
type Load<'a> = &'a mut dyn FnMut(&str) -> Result<Vec<u8>>;

/// Reads a structure; `load` returns the content of the files that it names.
///
/// # Errors
/// It is broken, or it holds what is not served.
pub(crate) fn read(bytes: &[u8], load: Load) -> Result<SystemStructure> {
    let document = Document::parse(Path::new(STRUCTURE_FILE), bytes, NODES)?;
    let root = document.root("SystemStructureDescription")?;
    let version = root.text("version")?;
    let served = ["1.", "2."].iter().any(|begin| version.trim().starts_with(begin));
    require(served, || root.wrong("version", "only SSP 1.x and 2.x are served"))?;
    let system = root.child("System").ok_or_else(|| root.problem("has no <System>"))?;
    let mut structure = SystemStructure { units: read_units(root, "Units")?, ..SystemStructure::default() };
    if let Some(experiment) = root.child("DefaultExperiment") {
        structure.start = experiment.number("startTime")?;
        structure.stop = experiment.number("stopTime")?;
    }
    for element in system.child("Elements").into_iter().flat_map(Element::elements) {
        if element.name() != "Component" {
            let message = "is not served: only components that are FMUs are";
            let named = element.has("name").then(|| element.wrong("name", message));
            return Err(named.unwrap_or_else(|| element.problem(message)).into());
        }
        let component = read_component(element)?;
        let known = structure.components.iter().any(|other| other.name == component.name);
        require(!known, || element.wrong("name", "two components have this name"))?;
        read_bindings(element, Some(structure.components.len()), &mut structure, load)?;
        structure.components.push(component);
    }
    require(!structure.components.is_empty(), || system.problem("has no <Component>"))?;
    read_bindings(system, None, &mut structure, load)?;
    let outside = read_connectors(system)?;
    for element in system.child("Connections").into_iter().flat_map(|list| list.children("Connection")) {
        structure.connections.extend(read_connection(element, &structure, &outside)?);
    }
    Ok(structure)
}

/// Reads a component, but for its parameters.
fn read_component(element: Element) -> Result<SspComponent> {
    let (name, source) = (element.text("name")?.to_owned(), element.text("source")?.to_owned());
    require(!name.is_empty(), || element.wrong("name", "must not be empty"))?;
    let is_fmu = element.optional("type").is_none_or(|of| of == FMU_TYPE);
    require(is_fmu, || element.wrong("type", "is not served: only FMUs are"))?;
    let exchange = element.optional("implementation") == Some("ModelExchange");
    require(!exchange, || element.wrong("implementation", "is not served: only co-simulation is"))?;
    let (connectors, place) = (read_connectors(element)?, element.wrong("source", ""));
    Ok(SspComponent { name, source, connectors, place })
}

/// The connectors of a component or of the system, by name.
fn read_connectors(owner: Element) -> Result<BTreeMap<String, Connector>> {
    let mut connectors = BTreeMap::new();
    for element in owner.child("Connectors").into_iter().flat_map(|list| list.children("Connector")) {
        let kind = Causality::from_name(element.text("kind")?);
        let typed = read_type(element)?;
        let of = typed.map(|(of, _)| of);
        let attribute = |name: &str| typed.and_then(|(_, typed)| typed.optional(name)).map(str::to_owned);
        let connector = Connector {
            kind: kind.ok_or_else(|| element.wrong("kind", "is not a kind of connector"))?,
            of,
            unit: attribute("unit").filter(|_| of.is_some_and(|of| of.class() == FmiType::Real)),
            dimensions: element.children("Dimension").map(read_dimension).collect::<Result<_>>()?,
            place: element.wrong("name", ""),
        };
        let same = connectors.insert(element.text("name")?.to_owned(), connector);
        require(same.is_none(), || element.wrong("name", "two connectors have this name"))?;
    }
    Ok(connectors)
}

/// The type of a connector's values, and the element that says it.
fn read_type(connector: Element) -> Result<Option<(FmiType, Element)>> {
    let others = ["ConnectorGeometry", "Annotations", "Dimension"];
    let Some(element) = connector.elements().find(|element| !others.contains(&element.name())) else {
        return Ok(None);
    };
    match FmiType::from_name(element.name()) {
        Some(FmiType::Clock) => Err(element.problem("is not served: clocks are not").into()),
        Some(FmiType::Enumeration) => {
            Ok(element.text("name").map(|_| Some((FmiType::Enumeration, element)))?)
        }
        Some(of) => Ok(Some((of, element))),
        None => Err(element.problem("is not a type of SSP").into()),
    }
}

fn read_dimension(element: Element) -> Result<Extent> {
    let size = element.parsed("size", "a whole number that is not negative")?;
    Ok(match (size, element.optional("sizeConnector")) {
        (Some(_), Some(_)) => return Err(element.problem("has both a size and a sizeConnector").into()),
        (Some(size), None) => Extent::Size(size),
        (None, Some(name)) => Extent::Parameter(name.to_owned()),
        (None, None) => Extent::Unsaid,
    })
}

/// `None` for what leads to an output of the system: nobody is outside to see it.
fn read_connection(
    element: Element,
    structure: &SystemStructure,
    outside: &BTreeMap<String, Connector>,
) -> Result<Option<Connection>> {
    let read = |end| read_end(element, end, structure, outside);
    let (Some(start), Some(end)) = (read("start")?, read("end")?) else { return Ok(None) };
    // Start and end say nothing about the direction, the connectors' kinds do.
    let [one, other] = [&start, &end].map(|port| structure.port(port).1.kind);
    let (from, to) = match (one, other) {
        (Causality::Output, Causality::Input) => (start, end),
        (Causality::Input, Causality::Output) => (end, start),
        (a, b) => {
            let ends = format!("{} {:?} with {} {:?}", a.name(), start.connector, b.name(), end.connector);
            let why = format!("connects {ends}: only an output and an input are served");
            return Err(element.problem(why).into());
        }
    };
    let mut transformation = None;
    for child in element.elements() {
        match child.name() {
            "ConnectionGeometry" | "Annotations" => {}
            "LinearTransformation" => {
                transformation = Some(Affine {
                    factor: child.number("factor")?.unwrap_or(1.0),
                    offset: child.number("offset")?.unwrap_or(0.0),
                });
            }
            _ => return Err(child.problem("is not served").into()),
        }
    }
    Ok(Some(Connection {
        from,
        to,
        transformation,
        suppress_unit_conversion: element.boolean("suppressUnitConversion")?.unwrap_or(false),
        place: element.wrong("endConnector", ""),
    }))
}

/// One end of a connection, `start` or `end`; `None` for an output of the system itself.
fn read_end(
    element: Element,
    end: &str,
    structure: &SystemStructure,
    outside: &BTreeMap<String, Connector>,
) -> Result<Option<Port>> {
    let [owner, connector, indices] = ["Element", "Connector", "Indices"].map(|of| format!("{end}{of}"));
    let name = element.text(&connector)?;
    let Some(owner_name) = element.optional(&owner) else {
        let why = match outside.get(name).map(|own| own.kind) {
            Some(Causality::Output) => return Ok(None),
            Some(_) => "connectors of the system are not served, except outputs",
            None => "the system has no such connector",
        };
        return Err(element.wrong(&connector, why).into());
    };
    let component = structure.components.iter().position(|component| component.name == owner_name);
    let component = component.ok_or_else(|| element.wrong(&owner, "there is no such component"))?;
    let known = structure.components[component].connectors.contains_key(name);
    require(known, || element.wrong(&connector, format!("component {owner_name:?} has no such connector")))?;
    // The indices of an element of an array connector, from 1; empty for all of it.
    let all = element.optional(&indices).unwrap_or_default().split_whitespace();
    let all = all.map(|text| text.parse().ok().filter(|index| *index > 0)).collect::<Option<Vec<usize>>>();
    let all = all.ok_or_else(|| element.wrong(&indices, "must be a list of whole numbers from 1 on"))?;
    Ok(Some(Port { component, connector: name.to_owned(), indices: all }))
}

/// Reads the units in an element of this name, which SSP took from FMI 2.0, by name: of two with one name the first, and
/// none without a definition, as FMI allows it.
pub(super) fn read_units(owner: Element, list: &str) -> Result<BTreeMap<String, SspUnit>> {
    let mut units = BTreeMap::new();
    for element in owner.child(list).into_iter().flat_map(|units| units.children("Unit")) {
        let name = element.text("name")?.to_owned();
        let Some(base) = element.child("BaseUnit") else { continue };
        let mut exponents = [0; 8];
        for (exponent, name) in exponents.iter_mut().zip(SspUnit::BASE) {
            *exponent = base.parsed(name, "a whole number")?.unwrap_or(0);
        }
        let factor = base.number("factor")?.unwrap_or(1.0);
        require(factor != 0.0, || base.wrong("factor", "must not be zero"))?;
        let offset = base.number("offset")?.unwrap_or(0.0);
        units.entry(name.clone()).or_insert(SspUnit { name, exponents, factor, offset });
    }
    Ok(units)
}

/// Adds the parameter values of a component or of the system, in the order in which they count.
fn read_bindings(
    owner: Element,
    component: Option<usize>,
    structure: &mut SystemStructure,
    load: Load,
) -> Result<()> {
    let bindings = owner.child("ParameterBindings").into_iter();
    for binding in bindings.flat_map(|bindings| bindings.children("ParameterBinding")) {
        let is_set = binding.optional("type").is_none_or(|of| of == PARAMETER_TYPE);
        require(is_set, || binding.wrong("type", "is not served: only parameter sets of SSP are"))?;
        let inside = binding.optional("sourceBase").is_none_or(|base| base == "SSD");
        require(inside, || binding.wrong("sourceBase", "is not served: only files of the archive are"))?;
        if let Some(mapping) = binding.child("ParameterMapping") {
            return Err(mapping.problem("is not served").into());
        }
        let prefix = binding.optional("prefix").unwrap_or_default();
        if let Some(source) = binding.optional("source") {
            let bytes = load(source).map_err(|error| binding.wrong("source", error.whole()))?;
            let document = Document::parse(Path::new(source), &bytes, NODES)?;
            read_parameters(document.root("ParameterSet")?, component, prefix, structure)?;
        } else {
            let values = binding.child("ParameterValues");
            let set = values.and_then(|values| values.child("ParameterSet"));
            let set = set.ok_or_else(|| binding.problem("has neither a source nor a <ParameterSet>"))?;
            read_parameters(set, component, prefix, structure)?;
        }
    }
    Ok(())
}

fn read_parameters(
    set: Element,
    component: Option<usize>,
    prefix: &str,
    structure: &mut SystemStructure,
) -> Result<()> {
    let units = read_units(set, "Units")?;
    for element in set.child("Parameters").into_iter().flat_map(|list| list.children("Parameter")) {
        let typed = element.elements().find(|child| child.name() != "Annotations");
        let typed = typed.ok_or_else(|| element.problem("has no value"))?;
        if let Some(dimension) = element.child("Dimension") {
            return Err(dimension.problem("is not served: set the elements by their names").into());
        }
        let served = |of: &FmiType| {
            [FmiType::Real, FmiType::Integer, FmiType::Boolean, FmiType::String].contains(&of.class())
        };
        let of = FmiType::from_name(typed.name()).filter(served);
        let of = of.ok_or_else(|| typed.problem("is not served as a parameter's type"))?;
        let text = typed.optional("value").ok_or_else(|| typed.problem("has no value"))?.to_owned();
        match of.class() {
            FmiType::Real => typed.number("value").map(drop)?,
            FmiType::Integer => typed.parsed::<i32>("value", "a whole number").map(drop)?,
            FmiType::Boolean => typed.boolean("value").map(drop)?,
            _ => {}
        }
        let unit = typed.optional("unit").filter(|_| of.class() == FmiType::Real);
        let definition = unit.and_then(|unit| units.get(unit).or(structure.units.get(unit)));
        structure.parameters.push(SspParameter {
            component,
            name: format!("{prefix}{}", element.text("name")?),
            of,
            unit: unit.map(str::to_owned),
            definition: definition.cloned(),
            text,
            place: element.wrong("name", ""),
        });
    }
    Ok(())
}
