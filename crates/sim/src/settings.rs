//! Parameters and start values of a Trial by the names of its FMUs' variables, with values as text.

use crate::simulation::{SimError, Simulation};
use crowd_mechanics::quantities::Quantity;
use lemons_core::files::words;
use lemons_decision::decision;
use lemons_fmi::variables::{Kind, Role, Scalar};
use lemons_fmi::{Answer, Model, Phase};
use std::collections::{BTreeMap, BTreeSet};

/// Prefix of the variables of the crowd.
pub const CROWD: &str = "crowd";
/// Prefix of the variables of Decision.
pub const DECISION: &str = "decision";

/// Stands for all agents in the name of a variable.
const EVERY_AGENT: &str = "agent[*].";

/// Returns the variables that a name stands for: `agent[*].Mass` stands for those of all known agents, any other name
/// for itself.
pub fn named(name: &str, known: impl Fn(&str) -> bool) -> Vec<String> {
    let of_all = name.strip_prefix(EVERY_AGENT).map(|rest| {
        let names = (0..).map(|i| format!("agent[{i}].{rest}"));
        names.take_while(|name| known(name)).collect::<Vec<_>>()
    });
    of_all.filter(|all| !all.is_empty()).unwrap_or_else(|| vec![name.to_owned()])
}

/// Returns which of all names an unknown one most likely means, with the indices of the unknown one if there is such a
/// name; `None` if only its indices are wrong.
pub fn meant(unknown: &str, all: impl Iterator<Item = String>) -> Option<String> {
    // Every other part is an index.
    let parts = |name: &str| name.split(['[', ']']).map(str::to_owned).collect::<Vec<_>>();
    let kind = |name: &str| parts(name).into_iter().step_by(2).collect::<Vec<_>>().join("[]");
    let (own, all) = (kind(unknown), all.collect::<BTreeSet<String>>());
    let kinds: BTreeMap<String, &String> = all.iter().rev().map(|name| (kind(name), name)).collect();
    let (found, first) = kinds.get_key_value(words::meant(&own, kinds.keys().map(String::as_str))?)?;
    if *found == own {
        return None;
    }
    let mut indices = parts(unknown).into_iter().skip(1).step_by(2);
    let with_own = found.split("[]").map(str::to_owned).reduce(|name, rest| {
        let index = indices.next().unwrap_or_default();
        format!("{name}[{index}]{rest}")
    })?;
    let exists = named(&with_own, |name| all.contains(name)).iter().all(|name| all.contains(name));
    Some(if exists { with_own } else { (*first).clone() })
}

/// A model, and its variables by name.
pub(crate) struct Named<M: Model> {
    pub model: M,
    variables: BTreeMap<String, Scalar<M::Quantity>>,
}

impl<M: Model> Named<M> {
    pub fn of(model: M) -> Named<M> {
        let scalars = model.scalars().into_iter();
        Named { variables: scalars.map(|scalar| (scalar.name.clone(), scalar)).collect(), model }
    }

    /// Returns the variables that a name stands for; `None` if one of them is unknown.
    fn find(&self, name: &str) -> Option<Vec<Scalar<M::Quantity>>> {
        let all = named(name, |name| self.variables.contains_key(name));
        all.iter().map(|name| self.variables.get(name).cloned()).collect()
    }

    fn meant(&self, name: &str) -> Option<String> {
        meant(name, self.variables.keys().cloned())
    }

    /// Sets variables to the value that a text means, before initialization.
    fn set(&mut self, scalars: &[Scalar<M::Quantity>], text: &str) -> Result<(), SimError> {
        let Some(first) = scalars.first() else { return Ok(()) };
        let wrong =
            |why: &str| SimError::Value { name: first.name.clone(), text: text.to_owned(), why: why.into() };
        if !matches!(first.variable.role, Role::Input | Role::Parameter | Role::Exact) {
            return Err(wrong("it is computed, and cannot be set"));
        }
        let number = match first.variable.kind {
            Kind::String => {
                let values: Vec<_> = scalars.iter().map(|scalar| (scalar.variable.quantity, text)).collect();
                return Ok(self.model.set_texts(&values)?);
            }
            Kind::Real(_) => text.trim().parse().map_err(|_| wrong("not a number"))?,
            Kind::Integer => f64::from(text.trim().parse::<i32>().map_err(|_| wrong("not a number"))?),
            Kind::Boolean => match text {
                "true" | "1" => 1.0,
                "false" | "0" => 0.0,
                _ => return Err(wrong("neither true nor false")),
            },
        };
        first.variable.domain.check(number).map_err(|must| wrong(&format!("must be {must}")))?;
        for Scalar { variable, element, .. } in scalars {
            self.model.set(variable.quantity, *element, number, Phase::Instantiated);
        }
        Ok(())
    }

    fn value(&mut self, scalar: &Scalar<M::Quantity>) -> Answer<Value> {
        let (quantity, element) = (scalar.variable.quantity, scalar.element);
        Ok(match scalar.variable.kind {
            Kind::Real(_) => Value::Real(self.model.number(quantity, element)?),
            Kind::Integer => Value::Integer(self.model.number(quantity, element)? as i32),
            Kind::Boolean => Value::Boolean(self.model.number(quantity, element)? != 0.0),
            Kind::String => Value::Text(self.model.text(quantity, element).to_owned()),
        })
    }
}

/// The meaning of a name: variables of the crowd, of Decision, or parameters of people that both have.
struct Meaning {
    crowd: Vec<Scalar<Quantity>>,
    decision: Vec<Scalar<decision::Quantity>>,
}

impl Meaning {
    /// Returns the first input among these variables.
    fn input(&self) -> Option<&str> {
        let crowd = self.crowd.iter().map(|scalar| (scalar.variable.role, &scalar.name));
        let decision = self.decision.iter().map(|scalar| (scalar.variable.role, &scalar.name));
        crowd.chain(decision).find(|(role, _)| *role == Role::Input).map(|(_, name)| name.as_str())
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
                let both = of_crowd.is_none() && name.starts_with("agent[");
                let decision = decision.unwrap_or_default();
                let both = both && decision.iter().all(|of| of.variable.role == Role::Parameter);
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
                Quantity::Fp => self.crowd.model.keep_drive_from(element / 2),
                Quantity::Mp => self.crowd.model.keep_drive_from(*element),
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
        let mut found: BTreeMap<&str, (String, [f64; 2], usize)> = BTreeMap::new();
        for (name, of_decision) in &decision.variables {
            let (variable, element) = (of_decision.variable, of_decision.element);
            let parameter = variable.role == Role::Parameter && matches!(variable.kind, Kind::Real(_));
            let Some(of_crowd) = self.crowd.variables.get(name).filter(|_| parameter) else { continue };
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
    pub fn decision_outputs(&self) -> Vec<Scalar<decision::Quantity>> {
        let scalars = self.decision.as_ref().map(|decision| decision.model.scalars()).unwrap_or_default();
        scalars.into_iter().filter(|scalar| scalar.variable.role == Role::Calculated).collect()
    }

    /// Returns the names of all variables; those of Decision with their prefix.
    pub fn variables(&self) -> Vec<String> {
        let decision = self.decision.iter().flat_map(|decision| decision.variables.keys());
        let decision = decision.map(|name| format!("{DECISION}.{name}"));
        self.crowd.variables.keys().cloned().chain(decision).collect()
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
    pub fn select(&self, names: &[String]) -> Result<Selection, (String, Option<String>)> {
        let mut all = Vec::new();
        for name in names {
            let Meaning { crowd, decision } = self.meaning(name).map_err(|meant| (name.clone(), meant))?;
            let decision = if crowd.is_empty() { decision } else { Vec::new() };
            let kinds = crowd.iter().map(|of| of.variable.kind);
            if kinds.chain(decision.iter().map(|of| of.variable.kind)).any(|kind| kind == Kind::String) {
                return Err((name.clone(), None));
            }
            all.extend(crowd.iter().map(|of| Selected::Crowd(of.variable.quantity, of.element)));
            all.extend(decision.iter().map(|of| Selected::Decision(of.variable.quantity, of.element)));
        }
        Ok(Selection(all))
    }

    /// Returns the present values of selected variables.
    ///
    /// # Errors
    /// Decision cannot compute them.
    pub fn read(&mut self, selection: &Selection) -> Result<Vec<f64>, SimError> {
        let number = |selected: &Selected| match (*selected, &mut self.decision) {
            (Selected::Crowd(quantity, element), _) => self.crowd.model.number(quantity, element),
            (Selected::Decision(quantity, element), Some(own)) => own.model.number(quantity, element),
            (Selected::Decision(..), None) => Ok(0.0),
        };
        Ok(selection.0.iter().map(number).collect::<Answer<_>>()?)
    }
}

/// The value of a variable.
#[derive(Debug, Clone, PartialEq)]
#[allow(missing_docs)] // FMI's types
pub enum Value {
    Real(f64),
    Integer(i32),
    Boolean(bool),
    Text(String),
}

/// Variables that are read together.
#[derive(Debug, Clone)]
pub struct Selection(Vec<Selected>);

/// An element of a quantity.
#[derive(Debug, Clone, Copy)]
enum Selected {
    Crowd(Quantity, usize),
    Decision(decision::Quantity, usize),
}

/// The rest of a name after a prefix and a point.
fn within<'a>(prefix: &str, name: &'a str) -> Option<&'a str> {
    name.strip_prefix(prefix)?.strip_prefix('.')
}
