//! The table of variables as XML and HTML: `modelDescription.xml`, `terminalsAndIcons.xml`, rows of
//! the documentation.

use crate::boundary::LOG_CATEGORIES;
use crate::model::{Model, guid, instantiation_token, reference};
use crate::variables::units::SECOND;
use crate::variables::{
    BaseType, Dependencies, Dimension, Domain, Known, RealType, Role, Scalar, Unit, Variable, VariableType,
};
use crate::{Answer, FmuFormat, Naming, Version};
use lemons_core::xml::{Layout, XmlWriter, number};
use std::collections::{BTreeSet, HashMap};

/// Content of an FMU, as its description tells it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Packed {
    /// The name of the Trial, or of the file.
    pub name: String,
    /// Tells one content from another; see [`fingerprint`](crate::model::fingerprint).
    pub fingerprint: u128,
}

/// Returns the model description of what is loaded.
///
/// # Errors
/// A start value is not known.
pub fn model_description<M: Model>(model: &mut M, format: FmuFormat) -> Answer<String> {
    packed_description(model, format, &[])
}

/// Returns the model description for an FMU in which this is packed. An annotation says so, and what packed it.
///
/// # Errors
/// A start value is not known.
pub fn packed_description<M: Model>(model: &mut M, format: FmuFormat, packed: &[Packed]) -> Answer<String> {
    match format {
        FmuFormat::Fmi2(naming) => of_scalars(model, naming, packed),
        FmuFormat::Fmi3 => of_arrays(model, packed),
    }
}

fn of_scalars<M: Model>(model: &mut M, naming: Naming, packed: &[Packed]) -> Answer<String> {
    let scalars = model.scalars();
    let mut starts = Vec::with_capacity(scalars.len());
    for Scalar { variable, element, .. } in &scalars {
        starts.push(start(model, variable, *element, 1)?);
    }
    let naming = match naming {
        Naming::Structured => "structured",
        Naming::Flat => "flat",
    };
    let identity = [("fmiVersion", "2.0"), ("guid", &guid(&scalars).braced().to_string())];
    Ok(document(model, Version::V2, identity, naming, |out| {
        write_annotation(out, Version::V2, packed);
        out.element("ModelVariables", &[], |out| {
            for (place, (scalar, start)) in scalars.iter().zip(&starts).enumerate() {
                let Scalar { name, description, variable, .. } = scalar;
                let place = place.to_string();
                out.element("ScalarVariable", &attributes(variable, name, &place, description), |out| {
                    let mut own = Vec::new();
                    if let VariableType::Real(of) = variable.kind {
                        own.push(("declaredType", of.name));
                    }
                    let bounds = own_bounds(variable);
                    own.extend(bounds.iter().map(|(name, bound)| (*name, &**bound)));
                    own.extend(start.as_deref().map(|start| ("start", start)));
                    out.empty(variable.kind.name(), &own);
                });
            }
        });
        out.element("ModelStructure", &[], |out| {
            for (name, is_wanted, known) in UNKNOWNS {
                out.element(&format!("{name}s"), &[], |out| {
                    write_unknowns(out, model, &scalars, is_wanted, known);
                });
            }
        });
    }))
}

type IsWanted = fn(Role) -> bool;

fn is_output(role: Role) -> bool {
    matches!(role, Role::Exact | Role::Calculated)
}

/// The unknowns of a model: name of the element, which variables they are, and on what they depend.
const UNKNOWNS: [(&str, IsWanted, Known); 2] = [
    ("Output", is_output, Known::Inputs),
    ("InitialUnknown", |role| matches!(role, Role::Calculated | Role::CalculatedParameter), Known::Starts),
];

/// Returns the variables that what is loaded has: no arrays of a size of 0.
pub(crate) fn present<M: Model>(model: &M) -> impl Iterator<Item = &'static Variable<M::Quantity>> {
    let sizes: Vec<u64> = (0..M::SIZES.len()).map(|place| model.size(place)).collect();
    let absent =
        move |dimension: &Dimension| matches!(dimension, Dimension::Size(place) if sizes[*place] == 0);
    M::VARIABLES
        .iter()
        .filter(move |variable| model.has(variable.quantity) && !variable.dimensions.iter().any(&absent))
}

fn of_arrays<M: Model>(model: &mut M, packed: &[Packed]) -> Answer<String> {
    let sizes: Vec<u64> = (0..M::SIZES.len()).map(|place| model.size(place)).collect();
    let variables: Vec<&Variable<M::Quantity>> = present(model).collect();
    let mut starts = Vec::with_capacity(variables.len());
    for variable in &variables {
        let length = variable.dimensions.iter().map(|dimension| match *dimension {
            Dimension::Size(place) => sizes[place],
            Dimension::Fixed(size) => size,
        });
        starts.push(start(model, variable, 0, length.product::<u64>() as usize)?);
    }
    let token = instantiation_token::<M>().braced().to_string();
    let identity = [("fmiVersion", "3.0"), ("instantiationToken", &*token)];
    Ok(document(model, Version::V3, identity, "structured", |out| {
        out.element("ModelVariables", &[], |out| {
            write_time(out);
            for (place, (size, value)) in
                M::SIZES.iter().zip(&sizes).enumerate().filter(|(_, (_, value))| **value > 0)
            {
                let bounds = bounds(Domain::Size, BaseType::Size);
                let (reference, value) = ((place + 1).to_string(), value.to_string());
                let mut attributes = vec![
                    ("name", size.name),
                    ("valueReference", &*reference),
                    ("description", size.description),
                    ("causality", "structuralParameter"),
                    ("variability", "fixed"),
                ];
                attributes.extend(bounds.iter().map(|(name, bound)| (*name, &**bound)));
                attributes.push(("start", &*value));
                out.empty("UInt64", &attributes);
            }
            for (variable, start) in variables.iter().zip(&starts) {
                write_array(out, model, variable, start.as_deref());
            }
        });
        out.element("ModelStructure", &[], |out| {
            for (name, is_wanted, known) in UNKNOWNS {
                for variable in variables.iter().filter(|variable| is_wanted(variable.role)) {
                    // Here variables count, not their elements.
                    let on = model.dependencies(variable.quantity, known).variables();
                    let on: BTreeSet<u32> = on.into_iter().filter_map(reference::<M>).collect();
                    let own = value_reference::<M>(variable);
                    let attributes = [("valueReference", &*own), ("dependencies", &joined(on))];
                    out.empty(name, &attributes);
                }
            }
        });
        write_annotation(out, Version::V3, packed);
    }))
}

/// Name of the annotation in a description.
const ANNOTATION: &str = "org.lemons-fmu";

/// Returns the version, and the commit if one was told.
fn packed_by(commit: Option<&str>) -> Vec<(&str, &str)> {
    let commit = commit.filter(|told| !told.is_empty()).map(|told| ("commit", told));
    [("version", env!("CARGO_PKG_VERSION"))].into_iter().chain(commit).collect()
}

/// Says what was packed by what: the commit if the build was told it, which a build never asks git for.
fn write_annotation(out: &mut XmlWriter, version: Version, packed: &[Packed]) {
    if packed.is_empty() {
        return;
    }
    let [list, one, key] = match version {
        Version::V2 => ["VendorAnnotations", "Tool", "name"],
        Version::V3 => ["Annotations", "Annotation", "type"],
    };
    let by = packed_by(option_env!("LEMONS_COMMIT"));
    out.element(list, &[], |out| {
        out.element(one, &[(key, ANNOTATION)], |out| {
            out.element("Packed", &by, |out| {
                for Packed { name, fingerprint } in packed {
                    let fingerprint = format!("{fingerprint:032x}");
                    out.empty("Content", &[("name", name), ("fingerprint", &fingerprint)]);
                }
            });
        });
    });
}

/// Copyright notice, as in the licence.
const COPYRIGHT: &str = "Copyright (c) 2026 The LEMONS-FMU developers";

/// Writes what both versions have, in its order, and then the rest.
fn document<M: Model>(
    model: &M,
    version: Version,
    identity: [(&str, &str); 2],
    naming: &str,
    rest: impl FnOnce(&mut XmlWriter),
) -> String {
    let [fmi_version, token] = identity;
    let root = [
        fmi_version,
        ("modelName", M::NAME),
        token,
        ("description", M::DESCRIPTION),
        ("author", env!("CARGO_PKG_AUTHORS")),
        ("version", env!("CARGO_PKG_VERSION")),
        ("copyright", COPYRIGHT),
        ("license", env!("CARGO_PKG_LICENSE")),
        ("generationTool", concat!("LEMONS-FMU ", env!("CARGO_PKG_VERSION"))),
        ("variableNamingConvention", naming),
    ];
    XmlWriter::document(Layout::STANDARD, "fmiModelDescription", &root, |out| {
        out.empty("CoSimulation", &co_simulation::<M>(version));
        let types = types_of(model);
        out.element("UnitDefinitions", &[], |out| write_units(out, version, &types));
        out.element("TypeDefinitions", &[], |out| types.iter().for_each(|of| write_type(out, version, of)));
        out.element("LogCategories", &[], |out| {
            for (name, description) in LOG_CATEGORIES {
                out.empty("Category", &[("name", name), ("description", description)]);
            }
        });
        let (stop, step) = (number(M::STOP_TIME), number(model.step_size()));
        let times = [("startTime", &number(0.0)[..]), ("stopTime", &stop), ("stepSize", &step)];
        out.empty("DefaultExperiment", &times);
        rest(out);
    })
}

/// Returns the attributes of `CoSimulation`: what an FMU can do.
fn co_simulation<M: Model>(version: Version) -> Vec<(&'static str, &'static str)> {
    let (always, v2, v3) = (true, version == Version::V2, version == Version::V3);
    let intermediate = v3 && M::SHOWS_INTERMEDIATE_VALUES;
    let flags = [
        (always, "canHandleVariableCommunicationStepSize", "true"),
        (v3, "canGetAndSetFMUState", "true"),
        (v3, "canSerializeFMUState", "true"),
        (v3, "providesPerElementDependencies", "true"),
        (v2 && M::INTERPOLATES_INPUTS, "canInterpolateInputs", "true"),
        (M::KNOWS_DERIVATIVES, "maxOutputDerivativeOrder", "1"),
        (v2, "canNotUseMemoryManagementFunctions", "true"),
        (v2, "canGetAndSetFMUstate", "true"),
        (v2, "canSerializeFMUstate", "true"),
        (intermediate, "providesIntermediateUpdate", "true"),
        (intermediate, "canReturnEarlyAfterIntermediateUpdate", "true"),
    ];
    let set = flags.into_iter().filter(|flag| flag.0).map(|(_, name, value)| (name, value));
    [("modelIdentifier", M::IDENTIFIER)].into_iter().chain(set).collect()
}

/// Returns the types of variables, in the order of their first use.
fn types_of<M: Model>(model: &M) -> Vec<RealType> {
    let mut types: Vec<RealType> = Vec::new();
    for variable in present(model) {
        if let VariableType::Real(of) = variable.kind
            && !types.contains(&of)
        {
            types.push(of);
        }
    }
    types
}

/// Writes the units of types, in the order of their first use.
fn write_units(out: &mut XmlWriter, version: Version, types: &[RealType]) {
    let time = (version == Version::V3).then_some(SECOND);
    let mut units: Vec<Unit> = Vec::new();
    for unit in time.into_iter().chain(types.iter().map(|of| of.unit)) {
        if !units.contains(&unit) {
            units.push(unit);
        }
    }
    for unit in units {
        let base = ["kg", "m", "s", "rad"].iter().zip(unit.base).filter(|&(_, exponent)| exponent != 0);
        let base: Vec<(&str, String)> = base.map(|(name, exponent)| (*name, exponent.to_string())).collect();
        let base: Vec<(&str, &str)> = base.iter().map(|(name, exponent)| (*name, &**exponent)).collect();
        out.element("Unit", &[("name", unit.name)], |out| {
            out.empty("BaseUnit", &base);
            if let Some((name, factor)) = unit.display {
                out.empty("DisplayUnit", &[("name", name), ("factor", &number(factor))]);
            }
        });
    }
}

/// Writes what variables of a type have in common.
fn write_type(out: &mut XmlWriter, version: Version, of: &RealType) {
    let name = ("name", of.name);
    let mut attributes = vec![("quantity", of.quantity), ("unit", of.unit.name)];
    let shown = of.unit.display.filter(|_| of.is_displayed);
    attributes.extend(shown.map(|(name, _)| ("displayUnit", name)));
    let bounds = bounds(of.domain, BaseType::Real);
    attributes.extend(bounds.iter().map(|(name, bound)| (*name, &**bound)));
    let nominal = number(of.nominal);
    attributes.push(("nominal", &nominal));
    match version {
        Version::V2 => out.element("SimpleType", &[name], |out| out.empty("Real", &attributes)),
        Version::V3 => {
            attributes.insert(0, name);
            out.empty("Float64Type", &attributes);
        }
    }
}

fn attributes<'a, Q>(
    variable: &Variable<Q>,
    name: &'a str,
    reference: &'a str,
    description: &'a str,
) -> Vec<(&'static str, &'a str)> {
    let (causality, initial) = match variable.role {
        Role::Input => ("input", None),
        Role::Exact => ("output", Some("exact")),
        Role::Calculated => ("output", Some("calculated")),
        Role::Parameter | Role::Tunable => ("parameter", Some("exact")),
        Role::CalculatedParameter => ("calculatedParameter", Some("calculated")),
    };
    let variability = match (variable.role, variable.kind) {
        (Role::Parameter | Role::CalculatedParameter, _) => "fixed",
        (Role::Tunable, _) => "tunable",
        (_, VariableType::Real(_)) => "continuous",
        _ => "discrete",
    };
    let mut attributes = vec![
        ("name", name),
        ("valueReference", reference),
        ("description", description),
        ("causality", causality),
        ("variability", variability),
    ];
    attributes.extend(initial.map(|initial| ("initial", initial)));
    attributes
}

/// Returns `min` and `max`, where values of the type are refused.
fn bounds(domain: Domain, of: BaseType) -> Vec<(&'static str, String)> {
    let written = |bound: f64| if of == BaseType::Real { number(bound) } else { format!("{bound:.0}") };
    let bounds = ["min", "max"].into_iter().zip(domain.bounds(of));
    bounds.filter_map(|(name, bound)| Some((name, written(bound?)))).collect()
}

/// Returns `min` and `max` of a variable, where those of its type are others.
fn own_bounds<Q>(variable: &Variable<Q>) -> Vec<(&'static str, String)> {
    let mut own = bounds(variable.domain, variable.kind.into());
    if let VariableType::Real(of) = variable.kind {
        let declared = bounds(of.domain, BaseType::Real);
        own.retain(|bound| !declared.contains(bound));
    }
    own
}

fn write_time(out: &mut XmlWriter) {
    let attributes = [
        ("name", "time"),
        ("valueReference", "0"),
        ("description", "simulation time"),
        ("causality", "independent"),
        ("variability", "continuous"),
        ("unit", SECOND.name),
    ];
    out.empty("Float64", &attributes);
}

fn write_array<M: Model>(
    out: &mut XmlWriter,
    model: &M,
    variable: &Variable<M::Quantity>,
    start: Option<&str>,
) {
    let (own, about) = (value_reference::<M>(variable), model.about(variable));
    let mut attributes = attributes(variable, variable.name, &own, &about);
    if let VariableType::Real(of) = variable.kind {
        attributes.push(("declaredType", of.name));
        // Within a step importers may only read what is continuous and says so; inputs are not set there.
        if M::SHOWS_INTERMEDIATE_VALUES && is_output(variable.role) {
            attributes.push(("intermediateUpdate", "true"));
        }
    }
    let bounds = own_bounds(variable);
    attributes.extend(bounds.iter().map(|(name, bound)| (*name, &**bound)));
    // Only single texts can be set.
    let (number, text) = if variable.kind == VariableType::String { (None, start) } else { (start, None) };
    attributes.extend(number.map(|start| ("start", start)));
    let element = BaseType::from(variable.kind).name(Version::V3);
    if variable.dimensions.is_empty() && text.is_none() {
        return out.empty(element, &attributes);
    }
    out.element(element, &attributes, |out| {
        for dimension in variable.dimensions {
            match dimension {
                Dimension::Fixed(size) => out.empty("Dimension", &[("start", &size.to_string())]),
                Dimension::Size(place) => {
                    out.empty("Dimension", &[("valueReference", &(place + 1).to_string())]);
                }
            }
        }
        text.iter().for_each(|text| out.empty("Start", &[("value", text)]));
    });
}

/// Most numbers of lists in which each unknown of a kind depends on the same elements.
const MOST_LISTED: usize = 10_000;

/// Writes the unknowns of FMI 2.0, which counts variables from 1, with the known ones on which they
/// depend. Where each depends on the same ones and these lists would be long, there are none, which
/// FMI reads as "on all".
fn write_unknowns<M: Model>(
    out: &mut XmlWriter,
    model: &M,
    scalars: &[Scalar<M::Quantity>],
    is_wanted: IsWanted,
    known: Known,
) {
    let key = |quantity: M::Quantity, element: usize| (reference::<M>(quantity), element);
    let places: HashMap<_, usize> =
        (1..).zip(scalars).map(|(place, of)| (key(of.variable.quantity, of.element), place)).collect();
    let mut depends_on = vec![BTreeSet::<usize>::new(); scalars.len() + 1];
    let mut of_all: HashMap<_, String> = HashMap::new();
    let mut listed = 0;
    for variable in M::VARIABLES.iter().filter(|variable| is_wanted(variable.role)) {
        match model.dependencies(variable.quantity, known) {
            Dependencies::All(on) => {
                let is_on = |(_, of): &(usize, &Scalar<_>)| on.contains(&of.variable.quantity);
                let on: Vec<usize> = (1..).zip(scalars).filter(is_on).map(|(place, _)| place).collect();
                listed +=
                    on.len() * scalars.iter().filter(|of| of.variable.quantity == variable.quantity).count();
                of_all.insert(variable.name, joined(on));
            }
            Dependencies::Elements(elements) => {
                for of in elements {
                    if let Some(unknown) = places.get(&key(variable.quantity, of.dependent)) {
                        depends_on[*unknown].extend(places.get(&key(of.on, of.element)));
                    }
                }
            }
        }
    }
    for (place, scalar) in (1..).zip(scalars).filter(|(_, scalar)| is_wanted(scalar.variable.role)) {
        let index = place.to_string();
        let own = || Some(joined(&depends_on[place]));
        let on = of_all
            .get(scalar.variable.name)
            .map_or_else(own, |all| (all.is_empty() || listed <= MOST_LISTED).then(|| all.clone()));
        let mut attributes = vec![("index", &*index)];
        attributes.extend(on.as_deref().map(|on| ("dependencies", on)));
        out.empty("Unknown", &attributes);
    }
}

fn value_reference<M: Model>(variable: &Variable<M::Quantity>) -> String {
    reference::<M>(variable.quantity).map_or_else(String::new, |reference| reference.to_string())
}

fn joined(numbers: impl IntoIterator<Item = impl ToString>) -> String {
    numbers.into_iter().map(|number| number.to_string()).collect::<Vec<String>>().join(" ")
}

/// Returns the start value of a variable, if it has one: of elements from the first on. If all are
/// equal, one is written.
fn start<M: Model>(
    model: &mut M,
    variable: &Variable<M::Quantity>,
    first: usize,
    length: usize,
) -> Answer<Option<String>> {
    if !Known::Starts.includes(variable.role) {
        return Ok(None);
    }
    let mut starts = Vec::with_capacity(length);
    for element in first..first + length {
        if variable.kind == VariableType::String {
            return Ok(Some(model.text(variable.quantity, element).to_owned()));
        }
        starts.push(model.number(variable.quantity, element)?);
    }
    let written = |value: &f64| match variable.kind {
        VariableType::Integer => format!("{value:.0}"),
        VariableType::Boolean => (*value != 0.0).to_string(),
        _ => number(*value),
    };
    let alike = starts.iter().all(|value| value.to_bits() == starts[0].to_bits());
    Ok(Some(joined(starts[..if alike { length.min(1) } else { length }].iter().map(written))))
}

/// Returns `terminalsAndIcons.xml` with a terminal `crowd`, and the icon. A crowd and what drives it are
/// connected at these terminals: variables with the same names, which are arrays in FMI 3.0 and their elements
/// in FMI 2.0. Not all need to be there: the matching rule is `bus`. Without names there is only the icon.
pub fn terminals_xml<M: Model>(model: &M, version: Version, description: &str, names: &[&str]) -> String {
    // FMI 2.0 takes this file from FMI 3.0, with its version.
    let root = [("fmiVersion", "3.0")];
    XmlWriter::document(Layout::STANDARD, "fmiTerminalsAndIcons", &root, |out| {
        out.element("GraphicalRepresentation", &[], |out| {
            let corners = [("x1", "-100"), ("y1", "-100"), ("x2", "100"), ("y2", "100")];
            let mut system = corners.to_vec();
            system.push(("suggestedScalingFactorTo_mm", "0.1"));
            out.empty("CoordinateSystem", &system);
            out.empty("Icon", &corners);
        });
        if names.is_empty() {
            return;
        }
        out.element("Terminals", &[], |out| {
            let attributes = [
                ("name", "crowd"),
                ("matchingRule", "bus"),
                ("terminalKind", "org.lemons-fmu.crowd"),
                ("description", description),
            ];
            out.element("Terminal", &attributes, |out| {
                let mut member = |name: &str| {
                    let member = [("variableName", name), ("memberName", name), ("variableKind", "signal")];
                    out.empty("TerminalMemberVariable", &member);
                };
                let is_member = |variable: &Variable<_>| names.contains(&variable.name);
                match version {
                    Version::V2 => {
                        let scalars = model.scalars().into_iter();
                        scalars.filter(|of| is_member(of.variable)).for_each(|of| member(&of.name));
                    }
                    Version::V3 => {
                        present(model).filter(|of| is_member(of)).for_each(|of| member(of.name));
                    }
                }
            });
        });
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_commit_is_named_if_the_build_was_told_one() {
        assert_eq!(packed_by(Some("2cf7a0a"))[1..], [("commit", "2cf7a0a")]);
        assert_eq!(packed_by(Some("")), packed_by(None));
        assert_eq!(packed_by(None), [("version", env!("CARGO_PKG_VERSION"))]);
    }

    #[test]
    fn the_licence_names_who_holds_the_copyright() {
        assert!(include_str!("../../../LICENSE-MIT").lines().any(|line| line == COPYRIGHT));
        assert!(COPYRIGHT.ends_with(env!("CARGO_PKG_AUTHORS")));
    }
}
