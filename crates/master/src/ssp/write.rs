//! FMUs and connections between them -> `SystemStructure.ssd`.

use crate::error::{Result, require};
use crate::ssp::document::{Causality, FmiType};
use crate::ssp::interface::{FmuVariable, Interface};
use crate::ssp::participant::{End, EndPair, Participant, owner};
use crate::ssp::unit::SspUnit;
use lemons_core::xml::{Layout, XmlWriter, number};
use lemons_fmi::Version;
use std::collections::{BTreeMap, HashSet};

/// Returns XML of SSP 1.0, or of SSP 2.0 if one is of FMI 3.0, which SSP 1.0 does not know, without parameters and conversions; the same FMUs give the
/// same text.
///
/// # Errors
/// A unit has two meanings.
pub(super) fn to_xml(name: &str, participants: &[Participant], pairs: &[EndPair]) -> Result<String> {
    let ends = || pairs.iter().flat_map(|pair| [&pair.from, &pair.to]);
    let second = participants.iter().any(|participant| participant.interface.fmi == Version::V3);
    let used: HashSet<(usize, &str)> = ends().map(owner).collect();
    let connectors = participants.iter().enumerate();
    let connectors: Vec<Vec<&FmuVariable>> =
        connectors.map(|(place, own)| connectors_of(place, own, &used, second)).collect();
    let units = units_of(participants, &connectors)?;
    let times = |time: fn(&Interface) -> Option<f64>| {
        participants.iter().filter_map(move |participant| time(participant.interface))
    };
    let stop = times(|interface| interface.stop).reduce(f64::max);
    let step = times(|interface| interface.step).filter(|step| *step > 0.0).reduce(f64::min);
    // pyssp_standard 0.9.1 reads both times or none.
    let start = times(|interface| interface.start).reduce(f64::min).or(stop.map(|_| 0.0));
    let root = [
        ("xmlns:ssc", "http://ssp-standard.org/SSP1/SystemStructureCommon"),
        ("xmlns:ssd", "http://ssp-standard.org/SSP1/SystemStructureDescription"),
        ("version", if second { "2.0" } else { "1.0" }),
        ("name", name),
        ("generationTool", concat!("LEMONS-FMU ", env!("CARGO_PKG_VERSION"))),
    ];
    Ok(XmlWriter::document(Layout::STANDARD, "ssd:SystemStructureDescription", &root, |out| {
        out.element("ssd:System", &[("name", name)], |out| {
            out.element("ssd:Elements", &[], |out| {
                for (participant, connectors) in participants.iter().zip(&connectors) {
                    write_component(out, participant, connectors, second);
                }
            });
            out.element("ssd:Connections", &[], |out| {
                pairs.iter().for_each(|pair| write_connection(out, participants, pair));
            });
            if let Some(step) = step {
                write_annotation(out, step);
            }
        });
        if !units.is_empty() {
            out.element("ssd:Units", &[], |out| units.values().for_each(|unit| write_unit(out, unit)));
        }
        let times = [("startTime", start), ("stopTime", stop)];
        let times = times.map(|(name, time)| time.map(|time| (name, number(time))));
        let times: Vec<_> = times.iter().flatten().map(|(name, time)| (*name, time.as_str())).collect();
        if !times.is_empty() {
            out.empty("ssd:DefaultExperiment", &times);
        }
    }))
}

/// Returns the variables that others see. Only inputs that are fed: FMPy 0.3.32 connects every other one to a wrong output.
/// Outputs are there to be looked at, where FMPy fails at Strings, and Enumerations need their items. And what says how
/// large they are.
fn connectors_of<'a>(
    place: usize,
    participant: &Participant<'a>,
    used: &HashSet<(usize, &str)>,
    second: bool,
) -> Vec<&'a FmuVariable> {
    let variables = &participant.interface.variables;
    let is_number = |variable: &FmuVariable| {
        matches!(variable.of.class(), FmiType::Real | FmiType::Integer | FmiType::Boolean)
            && (second || !variable.is_array())
    };
    let is_shown = |variable: &&FmuVariable| {
        used.contains(&(place, &*variable.name))
            || variable.kind == Some(Causality::Output) && is_number(variable)
    };
    let dimensions = variables.iter().filter(is_shown).flat_map(|variable| &variable.dimensions);
    let sizes: HashSet<usize> = dimensions.filter_map(|dimension| dimension.parameter).collect();
    let all = variables.iter().enumerate();
    let all = all.filter(|(place, variable)| is_shown(variable) || sizes.contains(place));
    all.map(|(_, variable)| variable).collect()
}

/// Returns the units of connectors that are defined, by name: SSP wants a definition of every unit that it names.
fn units_of<'a>(
    participants: &[Participant<'a>],
    connectors: &[Vec<&FmuVariable>],
) -> Result<BTreeMap<&'a str, &'a SspUnit>> {
    let mut units = BTreeMap::new();
    for (participant, connectors) in participants.iter().zip(connectors) {
        for variable in connectors {
            let unit = variable.unit.as_ref().and_then(|name| participant.interface.unit(name));
            let Some(unit) = unit else { continue };
            let is_same = units.entry(&*unit.name).or_insert(unit).is_same(unit);
            require(is_same, || {
                let (of, by, name) = (&variable.name, &participant.name, &unit.name);
                format!("{of}: {by} means another unit by {name:?} than another FMU")
            })?;
        }
    }
    Ok(units)
}

/// OMSimulator reads the kind of a system from here, and refuses a structure without it. `oms-ma` is its algorithm with
/// a fixed communication step \[s\].
fn write_annotation(out: &mut XmlWriter, step: f64) {
    const SCHEMA: &str = "https://raw.githubusercontent.com/OpenModelica/OMSimulator/master/schema/oms.xsd";
    let step = number(step);
    let master = [("description", "oms-ma"), ("stepSize", &step)];
    out.element("ssd:Annotations", &[], |out| {
        out.element("ssc:Annotation", &[("type", "org.openmodelica")], |out| {
            out.element("oms:Annotations", &[("xmlns:oms", SCHEMA)], |out| {
                out.element("oms:SimulationInformation", &[], |out| {
                    out.empty("oms:FixedStepMaster", &master);
                });
            });
        });
    });
}

fn write_component(
    out: &mut XmlWriter,
    participant: &Participant,
    connectors: &[&FmuVariable],
    second: bool,
) {
    let attributes = [
        ("name", participant.name.as_str()),
        ("type", "application/x-fmu-sharedlibrary"),
        ("source", &participant.source),
        ("implementation", "CoSimulation"),
    ];
    if connectors.is_empty() {
        return out.empty("ssd:Component", &attributes);
    }
    out.element("ssd:Component", &attributes, |out| {
        out.element("ssd:Connectors", &[], |out| {
            for variable in connectors {
                write_connector(out, participant.interface, variable, second);
            }
        });
    });
}

fn write_connector(out: &mut XmlWriter, interface: &Interface, variable: &FmuVariable, second: bool) {
    let kind = variable.kind.map_or("output", Causality::name);
    out.element("ssd:Connector", &[("name", &variable.name), ("kind", kind)], |out| {
        let unit = variable.unit.as_deref().filter(|unit| interface.unit(unit).is_some());
        let detail = [("unit", unit), ("name", variable.enumeration.as_deref())];
        let detail = detail.into_iter().filter_map(|(name, text)| Some((name, text?)));
        let of = if second { variable.of } else { variable.of.class() };
        out.empty(&format!("ssc:{of}"), &detail.collect::<Vec<_>>());
        for dimension in &variable.dimensions {
            match dimension.parameter {
                Some(place) => {
                    out.empty("ssc:Dimension", &[("sizeConnector", &interface.variables[place].name)]);
                }
                None => out.empty("ssc:Dimension", &[("size", &dimension.size.to_string())]),
            }
        }
    });
}

fn write_connection(
    out: &mut XmlWriter,
    participants: &[Participant],
    EndPair { from, to, whole, .. }: &EndPair,
) {
    let indices = |(_, single): &End| {
        let indices = if *whole { Vec::new() } else { single.variable.indices(single.element) };
        indices.iter().map(usize::to_string).collect::<Vec<_>>().join(" ")
    };
    let [start, end] = [from, to].map(|end| &participants[end.0].name);
    let (of_start, of_end) = (indices(from), indices(to));
    let attributes = [
        ("startElement", start),
        ("startConnector", &from.1.variable.name),
        ("startIndices", &of_start),
        ("endElement", end),
        ("endConnector", &to.1.variable.name),
        ("endIndices", &of_end),
    ];
    let there = |(name, value): &(&str, &String)| !name.ends_with("Indices") || !value.is_empty();
    let attributes = attributes.into_iter().filter(there).map(|(name, value)| (name, value.as_str()));
    out.empty("ssd:Connection", &attributes.collect::<Vec<_>>());
}

fn write_unit(out: &mut XmlWriter, unit: &SspUnit) {
    let exponents = SspUnit::BASE.iter().zip(unit.exponents).filter(|&(_, exponent)| exponent != 0);
    let exponents = exponents.map(|(name, exponent)| (*name, exponent.to_string()));
    let scale = [("factor", unit.factor, 1.0), ("offset", unit.offset, 0.0)];
    let scale = scale.iter().filter(|(_, value, default)| value != default);
    let scale = scale.map(|&(name, value, _)| (name, number(value)));
    let base: Vec<(&str, String)> = exponents.chain(scale).collect();
    let base: Vec<(&str, &str)> = base.iter().map(|(name, value)| (*name, value.as_str())).collect();
    out.element("ssc:Unit", &[("name", &unit.name)], |out| out.empty("ssc:BaseUnit", &base));
}
