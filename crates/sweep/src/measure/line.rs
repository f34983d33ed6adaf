//! Who crosses a line.

use crate::measure::number::{check_number, number_of};
use crate::places::Places;
use crate::points::Points;
use lemons_results::measure::{Crossings, Line, Passages, Way};
use serde::Deserialize;

/// A measure of people who cross a line in a direction.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OverLine {
    /// Its name in `[lines]`.
    pub line: String,
    /// In which direction, seen from the first point to the second one.
    pub direction: Way,
    /// A number of [`Crossings`].
    pub number: String,
    /// For the specific flow; `None`: the length of the line.
    pub width: Option<Width>,
}

/// \[m\] A width, or the parameter that has it.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(untagged)]
pub enum Width {
    /// At all points.
    Metres(f64),
    /// The name of a parameter.
    Parameter(String),
}

impl OverLine {
    /// Checks that its line, its width and its number are there.
    ///
    /// # Errors
    /// A sentence with the key.
    pub(crate) fn check(&self, places: &Places, points: &Points) -> Result<(), String> {
        check_number("number", &self.number, &Crossings::default())?;
        let line = places.line(&self.line)?;
        if self.width.is_some() && self.number != "specific_flow" {
            return Err("width is for number = \"specific_flow\"".into());
        }
        (0..points.count).try_for_each(|point| self.width_at(point, line, points).map(drop))
    }

    /// Returns the width at a point \[m\].
    pub(crate) fn width_at(&self, point: usize, line: Line, points: &Points) -> Result<f64, String> {
        let width = match &self.width {
            None => line.length(),
            Some(Width::Metres(width)) => *width,
            Some(Width::Parameter(name)) => {
                let parameter = points.parameter(name);
                let parameter =
                    parameter.ok_or_else(|| format!("width = {name:?}: there is no such parameter"))?;
                let text = parameter.at(point);
                text.parse().map_err(|_| format!("width = {name:?}: {text:?} is not a number"))?
            }
        };
        let positive = width > 0.0 && width.is_finite();
        positive
            .then_some(width)
            .ok_or_else(|| format!("width: {width:?} is not a positive number of metres"))
    }

    /// Returns the number of what was seen of so many people.
    pub(crate) fn value(&self, seen: &Passages, width: f64, people: usize) -> Option<f64> {
        number_of(&self.number, &Crossings::of(seen, self.direction, width, people))
    }
}
