//! Who crosses a line; how dense a crowd is in an area, and how fast.

use crate::measure::{check_number, number_of};
use crate::places::Places;
use crate::points::Points;
use lemons_master::ensure;
use lemons_results::measure::{Crossings, Density, Line, MeanMax, Passages, Way};
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
        let fits = self.width.is_none() || self.number == "specific_flow";
        ensure(fits, || "width is for number = \"specific_flow\"".to_owned())?;
        (0..points.count).try_for_each(|point| self.width_at(point, line, points).map(drop))
    }

    /// Returns the width at a point \[m\].
    pub(crate) fn width_at(&self, point: usize, line: Line, points: &Points) -> Result<f64, String> {
        let width = match &self.width {
            None => line.length(),
            Some(Width::Metres(width)) => *width,
            Some(Width::Parameter(name)) => {
                let wrong = |why: &str| format!("width = {name:?}: {why}");
                let parameter = points.parameter(name).ok_or_else(|| wrong("there is no such parameter"))?;
                let text = parameter.at(point);
                text.parse().map_err(|_| wrong(&format!("{text:?} is not a number")))?
            }
        };
        let positive = width > 0.0 && width.is_finite();
        ensure(positive, || format!("width: {width:?} is not a positive number of metres"))?;
        Ok(width)
    }

    /// Returns the number of what was seen of so many people.
    pub(crate) fn value(&self, seen: &Passages, width: f64, people: usize) -> Option<f64> {
        number_of(&self.number, &Crossings::of(seen, self.direction, width, people))
    }
}

/// A measure of the people in an area.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct InArea {
    /// Its name in `[areas]`.
    pub area: String,
    /// A number of [`Density`].
    pub number: String,
    /// A number of [`MeanMax`], over the communication points.
    pub take: String,
}

impl InArea {
    /// Returns whether it needs the cells of people in the room, which is known at the end of a run.
    pub(crate) fn needs_room(&self) -> bool {
        self.number == "voronoi_density"
    }

    /// Checks that its area and its numbers are there.
    ///
    /// # Errors
    /// A sentence with the key.
    pub(crate) fn check(&self, places: &Places) -> Result<(), String> {
        check_number("number", &self.number, &Density::default())?;
        check_number("take", &self.take, &MeanMax::default())?;
        places.area(&self.area).map(drop)
    }

    /// Returns the number of the area over time; `None` without a communication point, or without people for a speed.
    pub(crate) fn value<'a>(&self, seen: impl Iterator<Item = &'a Density>) -> Option<f64> {
        number_of(&self.take, &MeanMax::of(seen.filter_map(|seen| number_of(&self.number, seen)))?)
    }
}
