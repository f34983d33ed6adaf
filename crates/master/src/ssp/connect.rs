//! Interfaces -> the structure that connects every output with the inputs of the same name.

use crate::error::{Result, ensure};
use crate::ssp::document::Kind;
use crate::ssp::interface::{Interface, Variable};
use crate::ssp::unit::{Affine, conversion};
use crate::ssp::write::to_xml;
use std::collections::HashMap;

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
    /// `SystemStructure.ssd`
    pub structure: String,
    /// From which participant to which, by their places, and the name: that of a value, or of an array.
    pub connections: Vec<(usize, usize, String)>,
    /// The names of the inputs of each component that nothing feeds.
    pub unconnected: Vec<Vec<String>>,
}

/// The most mistakes of one kind that a message lists.
const LISTED: usize = 5;

/// A value of a participant.
#[derive(Clone, Copy)]
pub(super) struct End<'a> {
    pub(super) participant: usize,
    pub(super) variable: &'a Variable,
    pub(super) element: usize,
}

impl<'a> End<'a> {
    /// Returns whose variable it is of, and the name of that.
    pub(super) fn place(&self) -> (usize, &'a str) {
        (self.participant, &self.variable.name)
    }
}

/// Two ends to be connected: single values, or arrays as a whole.
pub(super) struct Pair<'a> {
    pub(super) from: End<'a>,
    pub(super) to: End<'a>,
    pub(super) whole: bool,
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
    if problems.len() > LISTED {
        let more = problems.split_off(LISTED).len();
        problems.push(format!("… and {more} more like these"));
    }
    ensure(problems.is_empty(), || problems.join("\n"))?;
    ensure(!pairs.is_empty(), || {
        let why = "no output has the name of an input of another FMU: nothing to connect";
        format!("{why}\n{}", participants.iter().map(summary).collect::<Vec<String>>().join("\n"))
    })?;
    let structure = to_xml(name, participants, &pairs)?;
    let connection = |pair: Pair| (pair.from.participant, pair.to.participant, pair.name);
    Ok(Connected { structure, connections: pairs.into_iter().map(connection).collect(), unconnected })
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
