//! Who crosses a line.

use crate::measure::span::Span;
use crate::places::Places;
use crate::points::Points;
use lemons_measure::{Crossings, Line, Passages, Way};
use lemons_record::Frame;
use serde::{Deserialize, Serialize};

/// A measure of people who cross a line in a direction.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OverLine {
    /// Its name in `[lines]`.
    pub line: String,
    /// In which direction, seen from the first point to the second one.
    pub direction: Direction,
    /// What of it.
    pub number: OfCrossings,
    /// For the specific flow; `None`: the length of the line.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub width: Option<Width>,
    /// \[s\] From this time on.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub from: Option<f64>,
    /// \[s\] Up to this time.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub until: Option<f64>,
}

/// A direction across a line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Direction {
    /// From the left to the right.
    Right,
    /// From the right to the left.
    Left,
}

/// A number of a direction: those of [`Crossings`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[allow(missing_docs)]
pub enum OfCrossings {
    People,
    Crossings,
    First,
    Last,
    Flow,
    SpecificFlow,
    #[serde(rename = "gap_10")]
    Gap10,
    GapMedian,
    #[serde(rename = "gap_90")]
    Gap90,
    Across,
    NotAcross,
    EvacuationTime,
}

/// \[m\] A width, or the parameter that has it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Width {
    /// At all points.
    Metres(f64),
    /// The name of a parameter.
    Parameter(String),
}

impl OverLine {
    fn span(&self) -> Span {
        Span { from: self.from, until: self.until }
    }

    /// Checks that its line, its width and its time are there.
    ///
    /// # Errors
    /// A sentence with the key.
    pub(crate) fn check(&self, places: &Places, points: &Points) -> Result<(), String> {
        self.span().check()?;
        let line = places.line(&self.line)?;
        if self.width.is_some() && self.number != OfCrossings::SpecificFlow {
            return Err("width is for number = \"specific_flow\"".into());
        }
        (0..points.count).try_for_each(|point| self.width_at(point, line, points).map(drop))
    }

    fn width_at(&self, point: usize, line: Line, points: &Points) -> Result<f64, String> {
        let width = match &self.width {
            None => line.length(),
            Some(Width::Metres(width)) => *width,
            Some(Width::Parameter(name)) => {
                let column = points.columns.iter().find(|(known, _)| known == name);
                let (_, values) =
                    column.ok_or_else(|| format!("width = {name:?}: there is no such parameter"))?;
                let text = values.text(point);
                text.parse().map_err(|_| format!("width = {name:?}: {text:?} is not a number"))?
            }
        };
        let positive = width > 0.0 && width.is_finite();
        positive
            .then_some(width)
            .ok_or_else(|| format!("width: {width:?} is not a positive number of metres"))
    }
}

/// A line during a run.
pub(crate) struct Crossed<'a> {
    measure: &'a OverLine,
    passages: Passages,
    width: f64,
    people: usize,
}

impl<'a> Crossed<'a> {
    /// At a point, of so many people.
    pub fn new(
        measure: &'a OverLine,
        places: &Places,
        points: &Points,
        point: usize,
        people: usize,
    ) -> Result<Crossed<'a>, String> {
        let line = places.line(&measure.line)?;
        let width = measure.width_at(point, line, points)?;
        Ok(Crossed { measure, passages: Passages::over(line, people), width, people })
    }

    pub fn add(&mut self, frame: &Frame) {
        if self.measure.span().has(frame.time) {
            self.passages.add(frame);
        }
    }

    pub fn value(&self) -> Option<f64> {
        let way = match self.measure.direction {
            Direction::Right => Way::Right,
            Direction::Left => Way::Left,
        };
        let seen = Crossings::of(&self.passages, way, self.width, self.people);
        let count = |count: usize| Some(count as f64);
        match self.measure.number {
            OfCrossings::People => count(seen.people),
            OfCrossings::Crossings => count(seen.crossings),
            OfCrossings::First => seen.first,
            OfCrossings::Last => seen.last,
            OfCrossings::Flow => seen.flow,
            OfCrossings::SpecificFlow => seen.specific_flow,
            OfCrossings::Gap10 => seen.gap_10,
            OfCrossings::GapMedian => seen.gap_median,
            OfCrossings::Gap90 => seen.gap_90,
            OfCrossings::Across => count(seen.across),
            OfCrossings::NotAcross => count(seen.not_across),
            OfCrossings::EvacuationTime => seen.evacuation_time,
        }
    }
}
