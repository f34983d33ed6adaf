//! Measures: the numbers of a run that become columns of the table.

pub(crate) mod across;
pub(crate) mod area;
pub(crate) mod line;
mod number;
pub(crate) mod output;
pub(crate) mod squeeze;

use crate::error::{Error, Result};
use crate::places::Places;
use crate::points::Points;
use area::InArea;
use lemons_results::measure::within;
use line::OverLine;
use output::OfOutput;
use squeeze::OfSqueeze;

/// A measure. docs/measure.md defines those of lines, areas and squeeze.
#[derive(Debug, Clone, PartialEq)]
pub enum Measure {
    /// `of`: of the values of an output.
    Output(OfOutput),
    /// `line`: of people who cross it.
    Line(OverLine),
    /// `area`: of people in it.
    Area(InArea),
    /// `squeeze`: what people were exposed to.
    Squeeze(OfSqueeze),
}

/// One of these says what is measured.
const KINDS: [&str; 4] = ["of", "line", "area", "squeeze"];

impl Measure {
    /// Reads a measure: its key among `of`, `line`, `area` and `squeeze` says of which kind it is.
    ///
    /// # Errors
    /// A sentence with the key that is missing, unknown or of another type.
    pub(crate) fn read(value: toml::Value) -> Result<Measure> {
        let has = |kind: &&str| value.as_table().is_some_and(|table| table.contains_key(*kind));
        let kinds: Vec<&str> = KINDS.into_iter().filter(has).collect();
        match kinds[..] {
            ["of"] => Ok(Measure::Output(value.try_into()?)),
            ["line"] => Ok(Measure::Line(value.try_into()?)),
            ["area"] => Ok(Measure::Area(value.try_into()?)),
            ["squeeze"] => Ok(Measure::Squeeze(value.try_into()?)),
            _ => Err(Error::Spec(format!("must be a table with one of the keys {}", KINDS.join(", ")))),
        }
    }

    /// Returns from when until when communication points count \[s\].
    fn times(&self) -> [Option<f64>; 2] {
        match self {
            Measure::Output(_) => [None, None],
            Measure::Line(of) => [of.from, of.until],
            Measure::Area(of) => [of.from, of.until],
            Measure::Squeeze(of) => [of.from, of.until],
        }
    }

    /// Returns whether the communication point at a time \[s\] counts.
    pub(crate) fn counts(&self, time: f64) -> bool {
        let [from, until] = self.times();
        within(time, from, until)
    }

    /// Checks what can be known before a model is loaded.
    ///
    /// # Errors
    /// A sentence with the key.
    pub(crate) fn check(&self, places: &Places, points: &Points) -> Result<(), String> {
        let times = self.times();
        if times.iter().flatten().any(|time| !(*time >= 0.0 && time.is_finite())) {
            return Err("from and until must be finite numbers of seconds, not below 0".into());
        }
        if let [Some(from), Some(until)] = times
            && from >= until
        {
            return Err(format!("from = {from:?}, until = {until:?}: the beginning is not before the end"));
        }
        match self {
            // How many values or agents there are is known later.
            Measure::Output(measure) => measure.check(1),
            Measure::Line(measure) => measure.check(places, points),
            Measure::Area(measure) => measure.check(places),
            Measure::Squeeze(measure) => measure.check(1),
        }
    }
}
