//! Interfaces -> the structure that connects every output with the inputs of the same name.

use crate::document::{Component, Connection, Connector, Kind, Port, SystemStructure, Type};
use crate::error::{Error, Result};
use crate::interface::{Interface, Variable};
use crate::unit::{Affine, Unit, conversion};
use std::collections::{BTreeMap, HashMap, HashSet};

/// An FMU to connect.
pub struct Participant<'a> {
    /// The component's.
    pub name: String,
    /// Where the archive holds the FMU.
    pub source: String,
    /// Its variables.
    pub interface: &'a Interface,
}

/// What came of connecting.
pub struct Connected {
    /// The whole.
    pub structure: SystemStructure,
    /// Of each component the names of its inputs that nothing feeds.
    pub unconnected: Vec<Vec<String>>,
}

/// The most mistakes of one kind that a message lists.
const LISTED: usize = 5;

/// Connects every output of one component to the input of the same name in every other. Type and unit must
/// agree; a value without a unit agrees with every unit.
///
/// # Errors
/// They do not, an input is fed by two outputs, a unit has two meanings, or nothing is connected.
pub fn connect(name: &str, participants: &[Participant]) -> Result<Connected> {
    let mut outputs: HashMap<&str, Vec<(usize, &Variable)>> = HashMap::new();
    for (place, participant) in participants.iter().enumerate() {
        for output in of_kind(participant, Kind::Output) {
            outputs.entry(&output.name).or_default().push((place, output));
        }
    }
    let mut problems = Vec::new();
    let mut pairs = Vec::new();
    let mut unconnected = Vec::new();
    for (place, participant) in participants.iter().enumerate() {
        let mut free = Vec::new();
        for input in of_kind(participant, Kind::Input) {
            let sources = outputs.get(input.name.as_str()).map_or(&[][..], Vec::as_slice);
            match sources {
                [] => free.push(input.name.clone()),
                [(from, output)] => {
                    let source = &participants[*from];
                    if let Some(why) = disagreement((source, output), (participant, input)) {
                        problems.push(why);
                    }
                    pairs.push((*from, place, input.name.as_str()));
                }
                [(first, _), (second, _), ..] => problems.push(format!(
                    "the input {} of {} is fed by two outputs, of {} and of {}",
                    input.name, participant.name, participants[*first].name, participants[*second].name
                )),
            }
        }
        unconnected.push(free);
    }
    if !problems.is_empty() {
        let more = problems.len().saturating_sub(LISTED);
        problems.truncate(LISTED);
        if more > 0 {
            problems.push(format!("… and {more} more like these"));
        }
        return Err(Error::DoNotFit(problems.join("\n")));
    }
    if pairs.is_empty() {
        let sides: Vec<String> = participants.iter().map(summary).collect();
        return Err(Error::NothingToConnect(sides.join("\n")));
    }
    let structure = assemble(name, participants, &pairs)?;
    Ok(Connected { structure, unconnected })
}

fn of_kind<'a>(participant: &Participant<'a>, kind: Kind) -> impl Iterator<Item = &'a Variable> {
    participant.interface.variables.iter().filter(move |variable| variable.kind == Some(kind))
}

/// Why an output and an input of one name cannot be connected.
fn disagreement(
    (source, output): (&Participant, &Variable),
    (target, input): (&Participant, &Variable),
) -> Option<String> {
    let name = &input.name;
    let (from, to) = (&source.name, &target.name);
    if output.of.name() != input.of.name() {
        let (a, b) = (output.of.name(), input.of.name());
        return Some(format!("{name}: the output of {from} is of type {a}, the input of {to} of type {b}"));
    }
    if matches!(output.of, Type::Enumeration(_)) {
        return Some(format!("{name}: connections of type Enumeration are not served"));
    }
    let (a, b) = (output.of.unit(), input.of.unit());
    let defined = |participant: &Participant, unit: Option<&str>| {
        unit.and_then(|unit| participant.interface.unit(unit)).cloned()
    };
    let (from_unit, to_unit) = (defined(source, a), defined(target, b));
    match conversion((a, from_unit.as_ref()), (b, to_unit.as_ref())) {
        Ok(Affine::IDENTITY) => None,
        _ => {
            let (a, b) = (a.unwrap_or_default(), b.unwrap_or_default());
            Some(if a == b {
                format!("{name}: {from} and {to} do not mean the same by its unit {a:?}")
            } else {
                format!("{name}: the output of {from} is in {a:?}, the input of {to} in {b:?}")
            })
        }
    }
}

/// Outputs and inputs of a participant, a line each: the first few by name.
fn summary(participant: &Participant) -> String {
    let line = |kind: Kind| {
        let names: Vec<&str> = of_kind(participant, kind).map(|variable| variable.name.as_str()).collect();
        let shown = match names.len() {
            0 => String::new(),
            1 | 2 => format!(": {}", names.join(", ")),
            _ => format!(": {}, …", names[..2].join(", ")),
        };
        format!("{}: {} {}s{shown}", participant.name, names.len(), kind.name())
    };
    format!("{}\n{}", line(Kind::Output), line(Kind::Input))
}

fn assemble(
    name: &str,
    participants: &[Participant],
    pairs: &[(usize, usize, &str)],
) -> Result<SystemStructure> {
    let mut structure = SystemStructure { name: name.to_owned(), ..SystemStructure::default() };
    let mut ports: HashMap<(usize, &str), Port> = HashMap::new();
    let used: HashSet<(usize, &str)> =
        pairs.iter().flat_map(|&(from, to, name)| [(from, name), (to, name)]).collect();
    for (place, participant) in participants.iter().enumerate() {
        let mut connectors = Vec::new();
        for variable in &participant.interface.variables {
            // Only inputs that are fed: FMPy 0.3.32 connects every other one to a wrong output. Outputs are
            // there to be looked at, where FMPy fails at Strings, and Enumerations need their items.
            let connected = used.contains(&(place, variable.name.as_str()));
            let shown = variable.kind == Some(Kind::Output)
                && matches!(variable.of, Type::Real(_) | Type::Integer | Type::Boolean);
            if !connected && !shown {
                continue;
            }
            ports.insert((place, &variable.name), Port { component: place, connector: connectors.len() });
            connectors.push(connector(participant, variable, &mut structure.units)?);
        }
        structure.components.push(Component {
            name: participant.name.clone(),
            source: participant.source.clone(),
            connectors,
            ..Component::default()
        });
    }
    for &(from, to, name) in pairs {
        structure.connections.push(Connection {
            from: ports[&(from, name)],
            to: ports[&(to, name)],
            transformation: None,
            suppress_unit_conversion: false,
            line: 0,
        });
    }
    let times =
        |time: fn(&Interface) -> Option<f64>| participants.iter().filter_map(move |p| time(p.interface));
    structure.stop = times(|interface| interface.stop).reduce(f64::max);
    // pyssp_standard 0.9.1 reads both times or none.
    structure.step = times(|interface| interface.step).filter(|step| *step > 0.0).reduce(f64::min);
    structure.start = times(|interface| interface.start).reduce(f64::min).or(structure.stop.map(|_| 0.0));
    Ok(structure)
}

/// The connector of a variable; its unit joins the units of the system.
fn connector(
    participant: &Participant,
    variable: &Variable,
    units: &mut BTreeMap<String, Unit>,
) -> Result<Connector> {
    let mut of = variable.of.clone();
    if let Some(name) = of.unit() {
        match (participant.interface.unit(name), units.get(name)) {
            (Some(unit), Some(known)) if !unit.is_same(known) => {
                return Err(Error::UnitDiffers {
                    variable: variable.name.clone(),
                    participant: participant.name.clone(),
                    unit: name.to_owned(),
                });
            }
            (Some(_), Some(_)) => {}
            (Some(unit), None) => {
                units.insert(name.to_owned(), unit.clone());
            }
            // SSP wants a definition of every unit that it names.
            (None, _) => of = Type::Real(None),
        }
    }
    let kind = variable.kind.unwrap_or(Kind::Output);
    Ok(Connector { name: variable.name.clone(), kind, of: Some(of), line: 0 })
}
