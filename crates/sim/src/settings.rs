//! Parameters and start values of a Trial by the names of its FMUs' variables, with values as text.

use crate::error::SimError;
use crate::simulation::Simulation;
pub use crate::variables::{Value, expanded, meant};
use crowd_mechanics::quantities::CrowdQuantity;
use lemons_decision::decision;
use lemons_fmi::variables::{Role, Scalar, VariableType};
use lemons_fmi::{Answer, Model};
use std::collections::BTreeMap;

/// Prefix of the variables of the crowd.
pub const CROWD: &str = "crowd";
/// Prefix of the variables of Decision.
pub const DECISION: &str = "decision";

/// The meaning of a name: variables of the crowd, of Decision, or parameters of people that both have.
struct Meaning {
    crowd: Vec<Scalar<CrowdQuantity>>,
    decision: Vec<Scalar<decision::DecisionQuantity>>,
}

impl Meaning {
    /// Returns the first input among these variables that the coupling feeds: not those of doors and exits.
    fn input(&self) -> Option<&str> {
        let crowd = self.crowd.iter().map(|scalar| (scalar.variable.role, &scalar.name));
        let decision = self.decision.iter().map(|scalar| (scalar.variable.role, &scalar.name));
        let fed = |(role, name): &(Role, &String)| *role == Role::Input && !is_operated(name);
        crowd.chain(decision).find(fed).map(|(_, name)| name.as_str())
    }
}

impl Simulation {
    /// Returns what a name means.
    ///
    /// # Errors
    /// There is no such variable: the name that is probably meant, if any.
    fn meaning(&self, name: &str) -> Result<Meaning, Option<String>> {
        let of_crowd = within(CROWD, name);
        let of_decision = self.decision.as_ref().zip(within(DECISION, name));
        let variable = of_crowd.or(of_decision.map(|(_, variable)| variable)).unwrap_or(name);
        let crowd = self.crowd.find(variable);
        let decision = self.decision.as_ref().and_then(|decision| decision.find(variable));
        let prefixed = |meant: Option<String>| Some(name.strip_suffix(variable)?.to_owned() + &meant?);
        match (of_decision, crowd, decision) {
            (Some(_), _, Some(decision)) => Ok(Meaning { crowd: Vec::new(), decision }),
            (Some(_), Some(_), None) => Err(Some(format!("{CROWD}.{variable}"))),
            (Some((model, _)), None, None) => Err(prefixed(model.meant(variable))),
            (None, Some(crowd), decision) => {
                // What only Decision has needs its prefix: the crowd may get such a variable later.
                let decision = decision.unwrap_or_default();
                let parameters = decision.iter().all(|of| of.variable.role.is_parameter());
                let both =
                    of_crowd.is_none() && (name.starts_with("agent[") && parameters || is_operated(name));
                Ok(Meaning { crowd, decision: if both { decision } else { Vec::new() } })
            }
            (None, None, Some(_)) => Err(Some(format!("{DECISION}.{variable}"))),
            (None, None, None) => Err(prefixed(self.crowd.meant(variable))),
        }
    }

    /// Sets a parameter or a start value, before [`Simulation::begin`]: `Threads`, `agent[*].Mass`,
    /// `crowd.agent[0].Mass`, `decision.agent[3].DesiredSpeed`. Of people who walk, a parameter that crowd and Decision
    /// have is set in both. Returns the input that the coupling overwrites, if the name means such.
    ///
    /// # Errors
    /// There is no such variable, it is computed, or the text is no value of it.
    pub fn set(&mut self, name: &str, text: &str) -> Result<Option<String>, SimError> {
        let unknown = |meant| SimError::Unknown { given: format!("{name}={text}"), meant };
        let meaning = self.meaning(name).map_err(unknown)?;
        self.crowd.set(&meaning.crowd, text)?;
        for Scalar { variable, element, .. } in &meaning.crowd {
            match variable.quantity {
                CrowdQuantity::Fp => self.crowd.model.keep_drive_from(element / 2),
                CrowdQuantity::Mp => self.crowd.model.keep_drive_from(*element),
                _ => {}
            }
        }
        let Some(decision) = &mut self.decision else { return Ok(None) };
        decision.set(&meaning.decision, text)?;
        Ok(meaning.input().map(str::to_owned))
    }

    /// Returns the full names of the variables that a name sets: `crowd.agent[0].Mass`.
    ///
    /// # Errors
    /// There is no such variable: the name that is probably meant, if any.
    pub fn resolve(&self, name: &str) -> Result<Vec<String>, Option<String>> {
        let Meaning { crowd, decision } = self.meaning(name)?;
        let crowd = crowd.iter().map(|scalar| format!("{CROWD}.{}", scalar.name));
        Ok(crowd.chain(decision.iter().map(|scalar| format!("{DECISION}.{}", scalar.name))).collect())
    }

    /// Returns parameters of people that differ between crowd and Decision: for each quantity the name of the first of
    /// these people, both values, and the number of people.
    ///
    /// # Errors
    /// Decision cannot tell them.
    pub fn differing(&mut self) -> Result<Vec<(String, [f64; 2], usize)>, SimError> {
        let Some(decision) = &mut self.decision else { return Ok(Vec::new()) };
        let variables = decision.variables().clone();
        let mut found: BTreeMap<&str, (String, [f64; 2], usize)> = BTreeMap::new();
        for (name, of_decision) in &variables {
            let (variable, element) = (of_decision.variable, of_decision.element);
            let parameter = variable.role.is_parameter() && matches!(variable.kind, VariableType::Real(_));
            let Some(of_crowd) = self.crowd.variables().get(name).filter(|_| parameter) else { continue };
            let values = [
                decision.model.number(variable.quantity, element)?,
                self.crowd.model.number(of_crowd.variable.quantity, of_crowd.element)?,
            ];
            if values[0] != values[1] {
                let quantity = name.split_once("].").map_or("", |(_, quantity)| quantity);
                found.entry(quantity).or_insert_with(|| (name.clone(), values, 0)).2 += 1;
            }
        }
        Ok(found.into_values().collect())
    }

    /// Returns the outputs of Decision; none where nobody walks.
    pub fn decision_outputs(&self) -> Vec<Scalar<decision::DecisionQuantity>> {
        let scalars = self.decision.as_ref().map(|decision| decision.model.scalars()).unwrap_or_default();
        scalars.into_iter().filter(|scalar| scalar.variable.role == Role::Calculated).collect()
    }

    /// Returns the names of all variables; those of Decision with their prefix.
    pub fn variables(&self) -> Vec<String> {
        let decision = self.decision.iter().flat_map(|decision| decision.variables().keys());
        let decision = decision.map(|name| format!("{DECISION}.{name}"));
        self.crowd.variables().keys().cloned().chain(decision).collect()
    }

    /// Returns the value of a variable; of `agent[*].…` that of the first agent.
    ///
    /// # Errors
    /// There is no such variable, or Decision cannot compute it.
    pub fn value(&mut self, name: &str) -> Result<Value, SimError> {
        let unknown = |meant| SimError::Unknown { given: name.to_owned(), meant };
        let Meaning { crowd, decision } = self.meaning(name).map_err(unknown)?;
        match (crowd.first(), decision.first(), &mut self.decision) {
            (Some(found), ..) => Ok(self.crowd.value(found)?),
            (None, Some(found), Some(decision)) => Ok(decision.value(found)?),
            _ => Err(unknown(None)),
        }
    }

    /// Returns whether a variable, by its full name, is an input that crowd and Decision feed each other.
    pub fn is_fed(&self, full: &str) -> bool {
        self.walks() && self.meaning(full).is_ok_and(|meaning| meaning.input().is_some())
    }

    /// Finds variables that are read together, in an order: of people whom both have, those of the crowd.
    ///
    /// # Errors
    /// There is no such variable, or it is a text: its name, and the one that is probably meant, if any.
    pub fn select(&self, names: &[String]) -> Result<VariableSelection, (String, Option<String>)> {
        let mut all = Vec::new();
        for name in names {
            let Meaning { crowd, decision } = self.meaning(name).map_err(|meant| (name.clone(), meant))?;
            let decision = if crowd.is_empty() { decision } else { Vec::new() };
            let kinds = crowd.iter().map(|of| of.variable.kind);
            if kinds
                .chain(decision.iter().map(|of| of.variable.kind))
                .any(|kind| kind == VariableType::String)
            {
                return Err((name.clone(), None));
            }
            all.extend(crowd.iter().map(|of| Selected::Crowd(of.variable.quantity, of.element)));
            all.extend(decision.iter().map(|of| Selected::Decision(of.variable.quantity, of.element)));
        }
        Ok(VariableSelection(all))
    }

    /// Returns the present values of selected variables.
    ///
    /// # Errors
    /// Decision cannot compute them.
    pub fn read(&mut self, selection: &VariableSelection) -> Result<Vec<f64>, SimError> {
        let number = |selected: &Selected| match (*selected, &mut self.decision) {
            (Selected::Crowd(quantity, element), _) => self.crowd.model.number(quantity, element),
            (Selected::Decision(quantity, element), Some(own)) => own.model.number(quantity, element),
            (Selected::Decision(..), None) => Ok(0.0),
        };
        Ok(selection.0.iter().map(number).collect::<Answer<_>>()?)
    }
}

/// Variables that are read together.
#[derive(Debug, Clone)]
pub struct VariableSelection(Vec<Selected>);

/// An element of a quantity.
#[derive(Debug, Clone, Copy)]
enum Selected {
    Crowd(CrowdQuantity, usize),
    Decision(decision::DecisionQuantity, usize),
}

/// Whether a name is of an input of doors or exits, which whoever runs the simulation operates.
fn is_operated(name: &str) -> bool {
    name.starts_with("door[") || name.starts_with("exit[")
}

/// The rest of a name after a prefix and a point.
fn within<'a>(prefix: &str, name: &'a str) -> Option<&'a str> {
    name.strip_prefix(prefix)?.strip_prefix('.')
}
