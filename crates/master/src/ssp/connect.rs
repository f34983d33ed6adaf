//! Interfaces -> the structure that connects every output with the inputs of the same name.

use crate::error::{Result, require};
use crate::ssp::choice::Choice;
use crate::ssp::document::Causality;
use crate::ssp::interface::{FmuVariable, Single};
use crate::ssp::participant::{End, EndPair, Participant, owner};
use crate::ssp::unit::{Affine, conversion};
use crate::ssp::write::to_xml;
use std::collections::HashMap;

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

/// Connects every output of one component to the input of the same name in every other: an array to an array with
/// the same sizes, else each value by itself. Type and unit must agree; a value without a unit agrees with every unit.
///
/// `chosen` are pairs of an output and an input of other names, `component.variable`: of single values, arrays as a whole,
/// or of each person with `agent[*]`. Terminals of one kind choose as well, where names differ, for inputs that are not
/// among them. Such an input is connected with nothing else.
///
/// # Errors
/// They do not, a name that was chosen is unknown, an input is fed by two outputs, a unit has two meanings, or nothing is connected.
pub fn connect(name: &str, participants: &[Participant], chosen: &[(String, String)]) -> Result<Connected> {
    let choice = Choice::read(chosen, participants)?;
    let mut outputs: HashMap<String, Vec<End>> = HashMap::new();
    for (place, participant) in participants.iter().enumerate() {
        for (name, single) in values_of(participant, Causality::Output) {
            outputs.entry(name).or_default().push((place, single));
        }
    }
    let mut problems = Vec::new();
    let mut pairs = Vec::new();
    let mut unconnected = Vec::new();
    for (place, own) in participants.iter().enumerate() {
        let mut free = Vec::new();
        let inputs =
            own.interface.variables.iter().filter(|variable| variable.kind == Some(Causality::Input));
        for variable in inputs {
            let twice = |name: &str, first: usize, second: usize| {
                let [first, second] = [first, second].map(|place| &participants[place].name);
                format!("the input {name} of {} is fed by two outputs, of {first} and of {second}", own.name)
            };
            let names = || (0..variable.count()).map(|element| own.interface.name_of(variable, element));
            let looked_for = choice.output_for(place, variable.name.clone());
            let of_elements = variable.is_array() && choice.is_made(place, names());
            if of_elements && looked_for.0.is_some() {
                let name = &variable.name;
                problems
                    .push(format!("{}.{name}: outputs are chosen for all of it and for elements", own.name));
                continue;
            }
            let arrays =
                if of_elements { Vec::new() } else { arrays_for(variable, &looked_for, participants) };
            match arrays[..] {
                [] if looked_for.0.is_some() && variable.is_array() => {
                    let (name, output) = (&variable.name, &looked_for.1);
                    problems.push(format!("{}.{name}: {output} is no array of the same sizes", own.name));
                    continue;
                }
                [] => {}
                [from] => {
                    let source = (&participants[from.0], from.1.variable);
                    problems.extend(disagreement(&variable.name, source, (own, variable)));
                    let others = names().filter_map(|name| Some((outputs.get(&name)?, name)));
                    let single = others.flat_map(|(ends, name)| {
                        ends.iter().map(move |end| (end.0, owner(end), name.clone()))
                    });
                    let mut other =
                        single.filter(|(_, one, _)| looked_for.0.is_none() && *one != owner(&from));
                    problems.extend(other.next().map(|(second, _, name)| twice(&name, from.0, second)));
                    let to = (place, Single { variable, element: 0 });
                    pairs.push(EndPair { from, to, whole: true, name: variable.name.clone() });
                    continue;
                }
                [first, second, ..] => {
                    problems.push(twice(&variable.name, first.0, second.0));
                    continue;
                }
            }
            let mut of_input: Vec<EndPair> = Vec::new();
            for element in 0..variable.count() {
                let name = own.interface.name_of(variable, element);
                let (chosen, output) = choice.output_for(place, name.clone());
                let found = outputs.get(&output).into_iter().flatten();
                match found.filter(|end| chosen.is_none_or(|own| own == end.0)).collect::<Vec<&End>>()[..] {
                    [] if chosen.is_some() => {
                        problems.push(format!("{}.{name}: no output {output}", own.name))
                    }
                    [] => free.push(name),
                    [from] => {
                        // Elements of an array agree alike.
                        if of_input.last().is_none_or(|last| owner(&last.from) != owner(from)) {
                            let source = (&participants[from.0], from.1.variable);
                            problems.extend(disagreement(&name, source, (own, variable)));
                        }
                        let to = (place, Single { variable, element });
                        of_input.push(EndPair { from: *from, to, whole: false, name });
                    }
                    [first, second, ..] => problems.push(twice(&name, first.0, second.0)),
                }
            }
            pairs.extend(of_input);
        }
        unconnected.push(free);
    }
    if problems.len() > LISTED {
        let more = problems.split_off(LISTED).len();
        problems.push(format!("… and {more} more like these"));
    }
    require(problems.is_empty(), || problems.join("\n"))?;
    require(!pairs.is_empty(), || {
        let why = "no output has the name of an input of another FMU: nothing to connect";
        format!("{why}\n{}", participants.iter().map(summary).collect::<Vec<String>>().join("\n"))
    })?;
    let structure = to_xml(name, participants, &pairs)?;
    let connection = |pair: EndPair| (pair.from.0, pair.to.0, pair.name);
    Ok(Connected { structure, connections: pairs.into_iter().map(connection).collect(), unconnected })
}

/// Returns the arrays with a name, perhaps of one participant only, and the sizes of an input that is one.
fn arrays_for<'a>(
    input: &FmuVariable,
    (chosen, name): &(Option<usize>, String),
    participants: &[Participant<'a>],
) -> Vec<End<'a>> {
    let of = |(place, participant): (usize, &Participant<'a>)| {
        let output = participant.interface.variable(name).filter(|of| of.kind == Some(Causality::Output))?;
        let alike = input.is_array() && output.is_array() && output.sizes() == input.sizes();
        alike.then_some((place, Single { variable: output, element: 0 }))
    };
    let looked_at = |&(place, _): &(usize, _)| chosen.is_none_or(|own| own == place);
    participants.iter().enumerate().filter(looked_at).filter_map(of).collect()
}

/// Returns the values of a kind of variables, with their names.
fn values_of<'a>(
    participant: &Participant<'a>,
    kind: Causality,
) -> impl Iterator<Item = (String, Single<'a>)> + use<'a> {
    participant.interface.singles().filter(move |(_, single)| single.variable.kind == Some(kind))
}

/// Returns why an output and an input of one name cannot be connected.
fn disagreement(
    name: &str,
    (source, output): (&Participant, &FmuVariable),
    (target, input): (&Participant, &FmuVariable),
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
    let line = |kind: Causality| {
        let names: Vec<String> = values_of(participant, kind).map(|(name, _)| name).collect();
        let shown = match names.len() {
            0 => String::new(),
            1 | 2 => format!(": {}", names.join(", ")),
            _ => format!(": {}, …", names[..2].join(", ")),
        };
        format!("{}: {} {}s{shown}", participant.name, names.len(), kind.name())
    };
    format!("{}\n{}", line(Causality::Output), line(Causality::Input))
}
