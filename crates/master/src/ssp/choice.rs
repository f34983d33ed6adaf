//! Connections between variables of different names, which a user chooses.

use crate::error::{MasterError, Result};
use crate::ssp::document::Causality;
use crate::ssp::participant::Participant;
use std::collections::HashMap;

/// Stands for the index of each person.
const EACH: &str = "[*]";

/// Outputs that are chosen for inputs: place of the participant and name of each.
#[derive(Default)]
pub(super) struct Choice<'a> {
    outputs: HashMap<(usize, &'a str), (usize, &'a str)>,
}

impl<'a> Choice<'a> {
    /// Reads pairs of an output and an input, `component.variable`, of single values, arrays, or with `agent[*]`.
    /// A choice for an input comes before what terminals say.
    pub(super) fn read(
        chosen: &'a [(String, String)],
        participants: &'a [Participant<'a>],
    ) -> Result<Choice<'a>> {
        let end = |name: &'a str, kind: Causality| {
            let found = name.split_once('.').and_then(|(component, variable)| {
                let place = participants.iter().position(|participant| participant.name == component)?;
                let first = variable.replace(EACH, "[0]");
                let mut singles = participants[place].interface.singles();
                let known = singles.any(|(name, single)| {
                    single.variable.kind == Some(kind) && (name == first || single.variable.name == first)
                });
                known.then_some((place, variable))
            });
            found.ok_or_else(|| MasterError::new(format!("{name}: no component has this {}", kind.name())))
        };
        let mut outputs = HashMap::new();
        for (from, to) in chosen {
            if outputs.insert(end(to, Causality::Input)?, end(from, Causality::Output)?).is_some() {
                return Err(MasterError::new(format!("{to}: two outputs are chosen for this input")));
            }
        }
        let chosen = Choice { outputs };
        let by_terminals = chosen.by_terminals(participants)?;
        Ok(Choice { outputs: chosen.outputs.into_iter().chain(by_terminals).collect() })
    }

    /// Returns the inputs and outputs of other names that terminals of one kind bring together, without the inputs for
    /// which an output is chosen.
    ///
    /// # Errors
    /// An input gets two outputs.
    fn by_terminals(
        &self,
        participants: &'a [Participant<'a>],
    ) -> Result<HashMap<VariableAt<'a>, VariableAt<'a>>> {
        let mut outputs = HashMap::new();
        let terminals = || {
            let each = participants.iter().enumerate();
            each.flat_map(|(place, of)| of.terminals.iter().map(move |terminal| (place, terminal)))
        };
        let kind = |(place, name): VariableAt| participants[place].interface.variable(name)?.kind;
        for (from, terminal) in terminals() {
            for (to, other) in terminals().filter(|(to, _)| *to != from) {
                for (output, input) in
                    terminal.pairs(other).into_iter().filter(|(output, input)| output != input)
                {
                    let (output, input) = ((from, output), (to, input));
                    let known =
                        (kind(output), kind(input)) == (Some(Causality::Output), Some(Causality::Input));
                    if !known || self.output_for(to, input.1.to_owned()).0.is_some() {
                        continue;
                    }
                    if let Some(first) = outputs.insert(input, output).filter(|first| *first != output) {
                        let [input, first, second] = [input, first, output]
                            .map(|(place, name)| format!("{}.{name}", participants[place].name));
                        return Err(MasterError::new(format!(
                            "{input}: terminals give it two outputs, {first} and {second}; choose one of them"
                        )));
                    }
                }
            }
        }
        Ok(outputs)
    }

    /// Returns whether an output is chosen for one of some inputs.
    pub(super) fn is_made(&self, place: usize, mut inputs: impl Iterator<Item = String>) -> bool {
        !self.outputs.is_empty() && inputs.any(|input| self.output_for(place, input).0.is_some())
    }

    /// Returns the output for an input: its participant, if one is chosen, and its name.
    pub(super) fn output_for(&self, place: usize, input: String) -> (Option<usize>, String) {
        if let Some(&(from, output)) = self.outputs.get(&(place, input.as_str())) {
            return (Some(from), output.to_owned());
        }
        let of_each = || {
            let (before, rest) = input.split_once('[')?;
            let (index, after) = rest.split_once(']')?;
            let &(from, output) = self.outputs.get(&(place, format!("{before}{EACH}{after}").as_str()))?;
            Some((Some(from), output.replace(EACH, &format!("[{index}]"))))
        };
        let each = if self.outputs.is_empty() { None } else { of_each() };
        each.unwrap_or((None, input))
    }
}

/// A variable: the place of its participant, and its name.
type VariableAt<'a> = (usize, &'a str);
