//! Connections between variables of different names, which a user chooses.

use crate::error::{Error, Result};
use crate::ssp::Participant;
use crate::ssp::document::Kind;
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
    pub(super) fn read(chosen: &'a [(String, String)], participants: &[Participant]) -> Result<Choice<'a>> {
        let end = |name: &'a str, kind: Kind| {
            let found = name.split_once('.').and_then(|(component, variable)| {
                let place = participants.iter().position(|participant| participant.name == component)?;
                let first = variable.replace(EACH, "[0]");
                let mut singles = participants[place].interface.singles();
                let known = singles.any(|(name, single)| {
                    single.variable.kind == Some(kind) && (name == first || single.variable.name == first)
                });
                known.then_some((place, variable))
            });
            found.ok_or_else(|| Error::new(format!("{name}: no component has this {}", kind.name())))
        };
        let mut outputs = HashMap::new();
        for (from, to) in chosen {
            if outputs.insert(end(to, Kind::Input)?, end(from, Kind::Output)?).is_some() {
                return Err(Error::new(format!("{to}: two outputs are chosen for this input")));
            }
        }
        Ok(Choice { outputs })
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
