//! Answers, and why there is none, in words of the page.

use lemons_core::require;
use lemons_scenario::{ScenarioError, with_names};
use serde::Serialize;
use serde_json::Value;

/// An answer.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Reply {
    /// The answer as the request describes it.
    pub value: Value,
    /// Numbers or a file.
    pub bytes: Vec<u8>,
}

impl Reply {
    pub(crate) fn of(value: impl Serialize) -> Result<Reply, Refused> {
        Reply::with(value, Vec::new())
    }

    pub(crate) fn with(value: impl Serialize, bytes: Vec<u8>) -> Result<Reply, Refused> {
        Ok(Reply { value: serde_json::to_value(value)?, bytes })
    }
}

/// Why there is no answer, for the person before the page. Any error or text becomes one.
#[derive(Debug, Clone, PartialEq)]
pub struct Refused(pub String);

impl<E: std::fmt::Display> From<E> for Refused {
    fn from(error: E) -> Refused {
        Refused(error.to_string())
    }
}

/// Checks that a number is in its range. `what` names it, with its unit.
pub(crate) fn within(what: &str, value: f64, [low, high]: [f64; 2]) -> Result<f64, Refused> {
    require((low..=high).contains(&value), || format!("{what} = {value}: must be {low} to {high}"))?;
    Ok(value)
}

/// Keys of a scenario, as the page calls them.
const WORDS: [(&str, &str); 5] = [
    ("mix", "the mix of kinds"),
    ("regions", "the region where people are placed"),
    ("drawing.unit", "length of a unit [m]"),
    ("drawing.close", "width of a gap [m]"),
    ("drawing.widest", "width of a gap [m]"),
];

/// A text about a scenario in words of the page.
pub(crate) fn words(text: &str) -> String {
    with_names(text, |key| Some(WORDS.iter().find(|(own, _)| *own == key)?.1.to_owned())).replace('`', "")
}

/// An error in words of the page.
pub(crate) fn told(error: ScenarioError) -> Refused {
    match error {
        ScenarioError::Toml(what) | ScenarioError::NoRoom { what, .. } => Refused(what),
        error => Refused(words(&error.to_string())),
    }
}
