//! Answers, and why there is none, in words of the page.

use lemons_core::message::{Message, Sentence, message};
use lemons_core::require;
use lemons_core::rule::parts::OF;
use lemons_decision::PlanError;
use lemons_people::PeopleError;
use lemons_scenario::{ScenarioError, with_names};
use serde::Serialize;
use serde_json::Value;
use std::any::Any;
#[cfg(feature = "typescript")]
use std::collections::BTreeMap;
use std::fmt::Display;

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

/// Why there is no answer, for the person before the page. Any error or text becomes one. What readers of XML, TOML, zips
/// and drawings say of a file, and serde of a request, has no id and stays English: they may be wrong in any way.
#[derive(Debug, Clone, PartialEq)]
pub struct Refused(pub Message);

impl<E: Display + 'static> From<E> for Refused {
    fn from(error: E) -> Refused {
        let any: &dyn Any = &error;
        let message = any.downcast_ref().cloned();
        let of_plan = || match any.downcast_ref()? {
            PlanError::Impossible(message) => Some(message.clone()),
            _ => None,
        };
        let message = message.or_else(of_plan).or_else(|| any.downcast_ref().map(PeopleError::told));
        Refused(message.unwrap_or_else(|| error.to_string().into()))
    }
}

/// A message as the page gets it.
#[cfg(feature = "typescript")]
#[derive(ts_rs::TS)]
#[ts(rename = "Message")]
#[allow(dead_code)] // only its type counts
pub(crate) struct MessageShown {
    id: String,
    values: BTreeMap<String, MessageShown>,
    text: String,
}

lemons_core::sentences! {
    THE_MIX "key.mix" "the mix of kinds";
    THE_REGIONS "key.regions" "the region where people are placed";
    THE_UNIT "key.unit" "length of a unit [m]";
    THE_GAP "key.gap" "width of a gap [m]";
    TOO_MANY_EDITS "edits.many" "{count} changes by hand: at most {most}";
    NOBODY_LEFT "edits.nobody" "nobody would be left";
    NO_SUCH_ID "edits.id" "there is nobody with the Id {id:?}";
    OVERLAPS "edits.overlaps" "person {id:?} would overlap somebody by {depth:.1} mm";
    OVERLAPS_WALL "edits.overlaps-wall" "person {id:?} would overlap a wall or somebody by {depth:.1} mm";
    NONE_CLOSED "room.open" "none of its {count} walls is closed, so nothing is inside";
    TOO_MANY_CORNERS "room.corners" "{count} corners: at most {most} are allowed";
    NOT_TAKEN "upload.not-taken" "not used here, and not taken along: {files}";
    NO_PARAMETERS "upload.parameters" "it has no Parameters.xml: the communication step is {step} s, the mechanical step {mechanical} s";
    TOO_MANY_PEOPLE "upload.people" "{people} people are too many for a page: at most {most}";
    NO_WAY "walk.no-way" "nobody can walk: there is no way";
}

/// Checks that a number is in its range. `what` names it, with its unit.
pub(crate) fn within(what: &str, value: f64, [low, high]: [f64; 2]) -> Result<f64, Refused> {
    require((low..=high).contains(&value), || format!("{what} = {value}: must be {low} to {high}"))?;
    Ok(value)
}

/// Keys of a scenario, as the page calls them.
const WORDS: [(&str, Sentence); 5] = [
    ("mix", THE_MIX),
    ("regions", THE_REGIONS),
    ("drawing.unit", THE_UNIT),
    ("drawing.close", THE_GAP),
    ("drawing.widest", THE_GAP),
];

fn word(key: &str) -> Option<Sentence> {
    Some(WORDS.iter().find(|(own, _)| *own == key)?.1)
}

/// A text about a scenario in words of the page.
pub(crate) fn words(text: &str) -> String {
    with_names(text, |key| Some(word(key)?.text.to_owned())).replace('`', "")
}

/// An error in words of the page.
pub(crate) fn told(error: ScenarioError) -> Refused {
    match error {
        ScenarioError::Toml(what) => what.into(),
        ScenarioError::NoRoom { what, .. } => Refused(what),
        ScenarioError::Impossible(message) => Refused(Message { text: words(&message.text), ..message }),
        ScenarioError::People { of, error } => {
            let key = word(of.trim_matches('`')).map(|key| Message::new(key, &[]));
            let of = key.unwrap_or_else(|| words(&of).into());
            Refused(message!(OF, of, finding = error.told()))
        }
        error => words(&error.to_string()).into(),
    }
}
