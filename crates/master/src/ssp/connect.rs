//! Interfaces -> the structure that connects every output with the inputs of the same name.

use crate::error::{Error, Result};
use crate::ssp::document::{Component, Connection, Connector, Extent, Kind, Port, SystemStructure, Type};
use crate::ssp::interface::{Dimension, Interface, Variable};
use crate::ssp::unit::{Affine, Unit, conversion};
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

/// The result of connecting.
pub struct Connected {
    /// The whole.
    pub structure: SystemStructure,
    /// The names of its connections: that of a value, or of an array.
    pub names: Vec<String>,
    /// The names of the inputs of each component that nothing feeds.
    pub unconnected: Vec<Vec<String>>,
}

/// The most mistakes of one kind that a message lists.
const LISTED: usize = 5;

/// A value of a participant.
#[derive(Clone, Copy)]
struct End<'a> {
    participant: usize,
    variable: &'a Variable,
    element: usize,
}

impl<'a> End<'a> {
    /// Returns whose variable it is of, and the name of that.
    fn place(&self) -> (usize, &'a str) {
        (self.participant, &self.variable.name)
    }
}

/// Two ends to be connected: single values, or arrays as a whole.
struct Pair<'a> {
    from: End<'a>,
    to: End<'a>,
    whole: bool,
    name: String,
}

/// Connects every output of one component to the input of the same name in every other: an array to an array where all
/// elements agree, else each value by itself. Type and unit must agree; a value without a unit agrees with every unit.
///
/// # Errors
/// They do not, an input is fed by two outputs, a unit has two meanings, or nothing is connected.
pub fn connect(name: &str, participants: &[Participant]) -> Result<Connected> {
    let mut outputs: HashMap<String, Vec<End>> = HashMap::new();
    for (participant, own) in participants.iter().enumerate() {
        for variable in of_kind(own, Kind::Output) {
            for element in 0..variable.count() {
                let end = End { participant, variable, element };
                outputs.entry(own.interface.name_of(variable, element)).or_default().push(end);
            }
        }
    }
    let mut problems = Vec::new();
    let mut pairs = Vec::new();
    let mut unconnected = Vec::new();
    for (participant, own) in participants.iter().enumerate() {
        let mut free = Vec::new();
        for variable in of_kind(own, Kind::Input) {
            let mut of_input: Vec<Pair> = Vec::new();
            for element in 0..variable.count() {
                let name = own.interface.name_of(variable, element);
                let to = End { participant, variable, element };
                match outputs.get(&name).map_or(&[][..], Vec::as_slice) {
                    [] => free.push(name),
                    [from] => {
                        // Elements of an array agree alike.
                        if of_input.last().is_none_or(|last| last.from.place() != from.place()) {
                            let source = (&participants[from.participant], from.variable);
                            problems.extend(disagreement(&name, source, (own, variable)));
                        }
                        of_input.push(Pair { from: *from, to, whole: false, name });
                    }
                    [first, second, ..] => problems.push(format!(
                        "the input {name} of {} is fed by two outputs, of {} and of {}",
                        own.name, participants[first.participant].name, participants[second.participant].name
                    )),
                }
            }
            let array = as_array(variable, &of_input);
            pairs.extend(array.map_or(of_input, |whole| vec![whole]));
        }
        unconnected.push(free);
    }
    if !problems.is_empty() {
        let more = problems.len().saturating_sub(LISTED);
        problems.truncate(LISTED);
        if more > 0 {
            problems.push(format!("… and {more} more like these"));
        }
        return Err(Error::new(problems.join("\n")));
    }
    if pairs.is_empty() {
        let sides: Vec<String> = participants.iter().map(summary).collect();
        let why = "no output has the name of an input of another FMU: nothing to connect";
        return Err(Error::new(format!("{why}\n{}", sides.join("\n"))));
    }
    let structure = assemble(name, participants, &pairs)?;
    let names = pairs.into_iter().map(|pair| pair.name).collect();
    Ok(Connected { structure, names, unconnected })
}

/// Returns all pairs of an input as one of whole arrays, if each of its elements is fed by the same one of an array.
fn as_array<'a>(input: &Variable, pairs: &[Pair<'a>]) -> Option<Pair<'a>> {
    let Pair { from, to, .. } =
        *pairs.first().filter(|_| input.is_array() && pairs.len() == input.count())?;
    let mut ends = pairs.iter().map(|pair| pair.from).enumerate();
    let alike = ends.all(|(element, end)| end.element == element && end.place() == from.place());
    let whole = from.variable.is_array() && from.variable.sizes() == input.sizes() && alike;
    whole.then(|| Pair { from, to, whole: true, name: input.name.clone() })
}

fn of_kind<'a>(participant: &Participant<'a>, kind: Kind) -> impl Iterator<Item = &'a Variable> {
    participant.interface.variables.iter().filter(move |variable| variable.kind == Some(kind))
}

/// Returns why an output and an input of one name cannot be connected.
fn disagreement(
    name: &str,
    (source, output): (&Participant, &Variable),
    (target, input): (&Participant, &Variable),
) -> Option<String> {
    let units = [source.interface.unit_of(output), target.interface.unit_of(input)];
    let why = match (output.of.check_sent_to(input.of), conversion(units[0], units[1])) {
        (Ok(()), Ok(Affine::IDENTITY)) => return None,
        (Err(why), _) => why,
        (Ok(()), _) => {
            let [a, b] = units.map(|(name, _)| name.unwrap_or_default());
            format!("the output is in {a:?}, the input in {b:?}, as each FMU defines its unit")
        }
    };
    Some(format!("{name}, from {} to {}: {why}", source.name, target.name))
}

/// Outputs and inputs of a participant, a line each: the first few by name.
fn summary(participant: &Participant) -> String {
    let line = |kind: Kind| {
        let interface = participant.interface;
        let all = of_kind(participant, kind).flat_map(|variable| {
            (0..variable.count()).map(move |element| interface.name_of(variable, element))
        });
        let names: Vec<String> = all.collect();
        let shown = match names.len() {
            0 => String::new(),
            1 | 2 => format!(": {}", names.join(", ")),
            _ => format!(": {}, …", names[..2].join(", ")),
        };
        format!("{}: {} {}s{shown}", participant.name, names.len(), kind.name())
    };
    format!("{}\n{}", line(Kind::Output), line(Kind::Input))
}

fn assemble(name: &str, participants: &[Participant], pairs: &[Pair]) -> Result<SystemStructure> {
    let mut structure = SystemStructure { name: name.to_owned(), ..SystemStructure::default() };
    let mut places: HashMap<(usize, &str), usize> = HashMap::new();
    let ends = || pairs.iter().flat_map(|pair| [&pair.from, &pair.to]);
    let mut used: HashSet<(usize, &str)> = ends().map(End::place).collect();
    // SSP 1.0 has no arrays.
    let arrays = ends().any(|end| end.variable.is_array());
    for (place, participant) in participants.iter().enumerate() {
        let variables = &participant.interface.variables;
        // Only inputs that are fed: FMPy 0.3.32 connects every other one to a wrong output. Outputs are there to be looked
        // at, where FMPy fails at Strings, and Enumerations need their items.
        let shown = of_kind(participant, Kind::Output).filter(|variable| {
            matches!(variable.of.class(), Type::Real | Type::Integer | Type::Boolean)
                && (arrays || !variable.is_array())
        });
        used.extend(shown.map(|variable| (place, variable.name.as_str())));
        // What says how large they are.
        let own = variables.iter().filter(|variable| used.contains(&(place, variable.name.as_str())));
        let dimensions = own.flat_map(|variable| &variable.dimensions);
        let sizes =
            dimensions.filter_map(|dimension| Some((place, variables[dimension.parameter?].name.as_str())));
        used.extend(sizes.collect::<Vec<_>>());
        let mut connectors = Vec::new();
        for variable in variables {
            let name = (place, variable.name.as_str());
            if used.contains(&name) {
                places.insert(name, connectors.len());
                connectors.push(connector(participant, variable, &mut structure.units)?);
            }
        }
        structure.components.push(Component {
            name: participant.name.clone(),
            source: participant.source.clone(),
            connectors,
            ..Component::default()
        });
    }
    for Pair { from, to, whole, .. } in pairs {
        let port = |end: &End| Port {
            component: end.participant,
            connector: places[&end.place()],
            indices: if *whole { Vec::new() } else { end.variable.indices(end.element) },
        };
        structure.connections.push(Connection {
            from: port(from),
            to: port(to),
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
    let mut unit = variable.unit.clone();
    if let Some(name) = &variable.unit {
        match (participant.interface.unit(name), units.get(name)) {
            (Some(unit), Some(known)) if !unit.is_same(known) => {
                let (of, by) = (&variable.name, &participant.name);
                let why = format!("{of}: {by} means another unit by {name:?} than another FMU");
                return Err(Error::new(why));
            }
            (Some(_), Some(_)) => {}
            (Some(unit), None) => {
                units.insert(name.to_owned(), unit.clone());
            }
            // SSP wants a definition of every unit that it names.
            (None, _) => unit = None,
        }
    }
    let kind = variable.kind.unwrap_or(Kind::Output);
    let interface = participant.interface;
    let extent = |dimension: &Dimension| match dimension.parameter {
        Some(place) => Extent::Parameter(interface.variables[place].name.clone()),
        None => Extent::Size(dimension.size as u64),
    };
    let dimensions = variable.dimensions.iter().map(extent).collect();
    Ok(Connector {
        name: variable.name.clone(),
        kind,
        of: Some(variable.of),
        unit,
        enumeration: variable.enumeration.clone(),
        dimensions,
        line: 0,
    })
}
