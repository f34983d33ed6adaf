//! The variables of a model by their names, with values as text.

use crate::error::SimError;
use lemons_core::files::words;
use lemons_fmi::variables::{Known, Scalar, VariableType};
use lemons_fmi::{Answer, Model, Phase};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::OnceLock;

/// The value of a variable.
#[derive(Debug, Clone, PartialEq)]
#[allow(missing_docs)] // FMI's types
pub enum Value {
    Real(f64),
    Integer(i32),
    Boolean(bool),
    Text(String),
}

/// Stands for all agents in the name of a variable.
const EVERY_AGENT: &str = "agent[*].";

/// Returns the variables that a name stands for: `agent[*].Mass` stands for those of all known agents, any other name
/// for itself.
pub fn expanded(name: &str, known: impl Fn(&str) -> bool) -> Vec<String> {
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
    let exists = expanded(&with_own, |name| all.contains(name)).iter().all(|name| all.contains(name));
    Some(if exists { with_own } else { (*first).clone() })
}

/// A model, and its variables by name.
pub(crate) struct IndexedModel<M: Model> {
    pub model: M,
    /// Made when they are first needed: thousands of names take longer than a crowd.
    variables: OnceLock<BTreeMap<String, Scalar<M::Quantity>>>,
}

impl<M: Model> IndexedModel<M> {
    pub fn of(model: M) -> IndexedModel<M> {
        IndexedModel { model, variables: OnceLock::new() }
    }

    /// Returns the variables by their names.
    pub fn variables(&self) -> &BTreeMap<String, Scalar<M::Quantity>> {
        let scalars = || self.model.scalars().into_iter();
        self.variables.get_or_init(|| scalars().map(|scalar| (scalar.name.clone(), scalar)).collect())
    }

    /// Returns the variables that a name stands for; `None` if one of them is unknown.
    pub fn find(&self, name: &str) -> Option<Vec<Scalar<M::Quantity>>> {
        let all = expanded(name, |name| self.variables().contains_key(name));
        all.iter().map(|name| self.variables().get(name).cloned()).collect()
    }

    pub fn meant(&self, name: &str) -> Option<String> {
        meant(name, self.variables().keys().cloned())
    }

    /// Sets variables to the value that a text means, before initialization.
    pub fn set(&mut self, scalars: &[Scalar<M::Quantity>], text: &str) -> Result<(), SimError> {
        let Some(first) = scalars.first() else { return Ok(()) };
        let wrong =
            |why: &str| SimError::Value { name: first.name.clone(), text: text.to_owned(), why: why.into() };
        if !Known::Starts.includes(first.variable.role) {
            return Err(wrong("it is computed, and cannot be set"));
        }
        let number = match first.variable.kind {
            VariableType::String => {
                let values: Vec<_> = scalars.iter().map(|scalar| (scalar.variable.quantity, text)).collect();
                return Ok(self.model.set_texts(&values)?);
            }
            VariableType::Real(_) => text.trim().parse().map_err(|_| wrong("not a number"))?,
            VariableType::Integer => {
                f64::from(text.trim().parse::<i32>().map_err(|_| wrong("not a number"))?)
            }
            VariableType::Boolean => match text {
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

    pub fn value(&mut self, scalar: &Scalar<M::Quantity>) -> Answer<Value> {
        let (quantity, element) = (scalar.variable.quantity, scalar.element);
        Ok(match scalar.variable.kind {
            VariableType::Real(_) => Value::Real(self.model.number(quantity, element)?),
            VariableType::Integer => Value::Integer(self.model.number(quantity, element)? as i32),
            VariableType::Boolean => Value::Boolean(self.model.number(quantity, element)? != 0.0),
            VariableType::String => Value::Text(self.model.text(quantity, element).to_owned()),
        })
    }
}
