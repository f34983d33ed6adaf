//! Measures: the numbers of a run that become columns of the table.

pub(crate) mod across;
pub(crate) mod area;
pub(crate) mod line;
mod number;
pub(crate) mod output;
pub(crate) mod squeeze;

use crate::error::{Place, Result};
use crate::places::Places;
use crate::points::Points;
use area::InArea;
use lemons_results::measure::within;
use line::OverLine;
use output::OfOutput;
use squeeze::OfSqueeze;

/// A measure, over the communication points that count. docs/measure.md defines those of lines, areas and squeeze.
#[derive(Debug, Clone, PartialEq)]
pub struct Measure {
    /// What is measured.
    pub kind: Kind,
    /// \[s\] From this time on.
    pub from: Option<f64>,
    /// \[s\] Up to this time.
    pub until: Option<f64>,
}

/// What is measured.
#[derive(Debug, Clone, PartialEq)]
pub enum Kind {
    /// `of`: the values of an output.
    Output(OfOutput),
    /// `line`: people who cross it.
    Line(OverLine),
    /// `area`: people in it.
    Area(InArea),
    /// `squeeze`: what people are exposed to.
    Squeeze(OfSqueeze),
}

/// One of these says what is measured.
const KINDS: [&str; 4] = ["of", "line", "area", "squeeze"];

impl Measure {
    /// Reads a measure: its key among `of`, `line`, `area` and `squeeze` says of which kind it is.
    ///
    /// # Errors
    /// A sentence with the key that is missing, unknown or of another type.
    pub(crate) fn read(mut value: toml::Value) -> Result<Measure> {
        let has = |kind: &&str| value.as_table().is_some_and(|table| table.contains_key(*kind));
        let kinds: Vec<&str> = KINDS.into_iter().filter(has).collect();
        // An output is measured at all times.
        let mut time = |key: &str| -> Result<Option<f64>> {
            let table = value.as_table_mut().filter(|_| kinds != ["of"]);
            let time = table.and_then(|table| table.remove(key));
            time.map(toml::Value::try_into).transpose().place(|| key.to_owned())
        };
        let (from, until) = (time("from")?, time("until")?);
        let kind = match kinds[..] {
            ["of"] => Kind::Output(value.try_into()?),
            ["line"] => Kind::Line(value.try_into()?),
            ["area"] => Kind::Area(value.try_into()?),
            ["squeeze"] => Kind::Squeeze(value.try_into()?),
            _ => {
                return Err(format!("must be a table with one of the keys {}", KINDS.join(", ")).into());
            }
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
        if [from, until].into_iter().flatten().any(|time| !(*time >= 0.0 && time.is_finite())) {
            return Err("from and until must be finite numbers of seconds, not below 0".into());
        }
        if let (Some(from), Some(until)) = (from, until)
            && from >= until
        {
            return Err(format!("from = {from:?}, until = {until:?}: the beginning is not before the end"));
        }
        match kind {
            // How many values or agents there are is known later.
            Kind::Output(of) => of.check(1),
            Kind::Line(of) => of.check(places, points),
            Kind::Area(of) => of.check(places),
            Kind::Squeeze(of) => of.check(1),
        }
    }
}
