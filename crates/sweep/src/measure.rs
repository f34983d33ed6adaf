//! Measures: the numbers of a run that become columns of the table.

pub(crate) mod balance;
pub(crate) mod breathing;
pub(crate) mod load;
pub(crate) mod output;
pub(crate) mod places;
pub(crate) mod squeeze;

use crate::error::Result;
use crate::points::Points;
use balance::BalanceMeasure;
use breathing::BreathingMeasure;
use lemons_core::require;
use lemons_results::measure::{Across, Breathing, Kept, within};
use load::LoadMeasure;
use output::OfOutput;
use places::{InArea, OverLine, Places};
use serde::Serialize;
use serde_json::Value;
use squeeze::SqueezeMeasure;

/// A measure, over the communication points that count. docs/measure.md defines those of lines, areas, squeeze
/// and balance.
#[derive(Debug, Clone, PartialEq)]
pub struct Measure {
    /// Kind of the measure.
    pub kind: MeasureKind,
    /// \[s\] From this time on.
    pub from: Option<f64>,
    /// \[s\] Up to this time.
    pub until: Option<f64>,
}

/// Kind of the measure.
#[derive(Debug, Clone, PartialEq)]
pub enum MeasureKind {
    /// `of`: the values of an output.
    Output(OfOutput),
    /// `line`: people who cross it.
    Line(OverLine),
    /// `area`: people in it.
    Area(InArea),
    /// `squeeze`: what people are exposed to.
    Squeeze(SqueezeMeasure),
    /// `balance`: how people who have legs keep it.
    Balance(BalanceMeasure),
    /// `breathing`: how long trunks are pressed.
    Breathing(BreathingMeasure),
    /// `load`: how hard people press on walls.
    Load(LoadMeasure),
}

/// One of these says what is measured.
const KINDS: [&str; 7] = ["of", "line", "area", "squeeze", "balance", "breathing", "load"];

impl Measure {
    /// Reads a measure: its key among [`KINDS`] says of which kind it is.
    ///
    /// # Errors
    /// A sentence with the key that is missing, unknown or of another type.
    pub(crate) fn read(value: toml::Value) -> Result<Measure> {
        let has = |kind: &&str| value.as_table().is_some_and(|table| table.contains_key(*kind));
        let kind = match KINDS.into_iter().filter(has).collect::<Vec<_>>()[..] {
            ["of"] => MeasureKind::Output(value.try_into()?),
            ["line"] => MeasureKind::Line(value.try_into()?),
            ["area"] => MeasureKind::Area(value.try_into()?),
            ["squeeze"] => MeasureKind::Squeeze(value.try_into()?),
            ["balance"] => MeasureKind::Balance(value.try_into()?),
            ["breathing"] => MeasureKind::Breathing(value.try_into()?),
            ["load"] => MeasureKind::Load(value.try_into()?),
            _ => {
                return Err(format!("must be a table with one of the keys {}", KINDS.join(", ")).into());
            }
        };
        let (from, until) = match &kind {
            // An output is measured at all times.
            MeasureKind::Output(_) => (None, None),
            MeasureKind::Line(of) => (of.from, of.until),
            MeasureKind::Area(of) => (of.from, of.until),
            MeasureKind::Squeeze(of) => (of.from, of.until),
            MeasureKind::Balance(of) => (of.from, of.until),
            MeasureKind::Breathing(of) => (of.from, of.until),
            MeasureKind::Load(of) => (of.from, of.until),
        };
        Ok(Measure { kind, from, until })
    }

    /// Returns whether the communication point at a time \[s\] counts.
    pub(crate) fn counts(&self, time: f64) -> bool {
        within(time, self.from, self.until)
    }

    /// Checks what can be known before a model is loaded.
    ///
    /// # Errors
    /// A sentence with the key.
    pub(crate) fn check(&self, places: &Places, points: &Points) -> Result<(), String> {
        let Measure { kind, from, until } = self;
        let good = [from, until].into_iter().flatten().all(|time| *time >= 0.0 && time.is_finite());
        require(good, || "from and until must be finite numbers of seconds, not below 0".to_owned())?;
        if let (Some(from), Some(until)) = (from, until) {
            let why = || format!("from = {from:?}, until = {until:?}: the beginning is not before the end");
            require(from < until, why)?;
        }
        match kind {
            // How many values or agents there are is known later.
            MeasureKind::Output(of) => of.check(1),
            MeasureKind::Line(of) => of.check(places, points),
            MeasureKind::Area(of) => of.check(places),
            MeasureKind::Squeeze(of) => of.check(),
            MeasureKind::Balance(of) => check_number("balance", &of.balance, &Kept::default()),
            MeasureKind::Breathing(of) => check_number("breathing", &of.breathing, &Breathing::default()),
            MeasureKind::Load(of) => of.check(),
        }
    }
}

/// The fields of what `lemons measure` writes: numbers by their names.
fn fields(seen: &impl Serialize) -> serde_json::Map<String, Value> {
    match serde_json::to_value(seen) {
        Ok(Value::Object(fields)) => fields,
        _ => serde_json::Map::new(),
    }
}

/// Returns a number; `None` if it is not known.
pub(crate) fn number_of(name: &str, seen: &impl Serialize) -> Option<f64> {
    fields(seen).get(name)?.as_f64()
}

/// Checks that a number has the name that a key gives.
///
/// # Errors
/// A sentence with all names.
pub(crate) fn check_number(key: &str, name: &str, any: &impl Serialize) -> Result<(), String> {
    let numbers = fields(any).into_iter().filter(|(_, value)| value.is_number() || value.is_null());
    let names: Vec<String> = numbers.map(|(name, _)| name).collect();
    let known = names.iter().any(|known| known == name);
    require(known, || format!("{key} = {name:?}: must be one of {}", names.join(", ")))
}

/// Checks that the function over agents is given for a number of them.
///
/// # Errors
/// A sentence: it is missing.
pub(crate) fn check_across(given: Option<Across>, agents: usize) -> Result<(), String> {
    require(agents <= 1 || given.is_some(), || {
        format!(
            "has {agents} agents: it needs across = \"max\", \"min\", \"mean\", \"median\" or \"quantile_90\""
        )
    })
}
