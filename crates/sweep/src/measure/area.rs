//! How dense a crowd is in an area, and how fast.

use crate::measure::span::Span;
use crate::places::Places;
use lemons_measure::{Density, MeanMax};
use serde::{Deserialize, Serialize};

/// A measure of the people in an area.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct InArea {
    /// Its name in `[areas]`.
    pub area: String,
    /// What of it.
    pub number: OfDensity,
    /// Over the communication points.
    pub take: MeanOrMax,
    /// \[s\] From this time on.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub from: Option<f64>,
    /// \[s\] Up to this time.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub until: Option<f64>,
}

/// A number of an area at a communication point.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum OfDensity {
    /// In the area.
    People,
    /// \[1/m²\] Their number over the area.
    Density,
    /// \[1/m²\] By the Voronoi cells.
    VoronoiDensity,
    /// \[m/s\] Their mean speed; only of communication points with anybody.
    Speed,
}

/// How values over time become one number.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum MeanOrMax {
    /// The mean.
    Mean,
    /// The greatest.
    Max,
}

impl InArea {
    /// Whether it needs the cells of people in the room, which is known at the end of a run.
    pub(crate) fn needs_room(&self) -> bool {
        self.number == OfDensity::VoronoiDensity
    }

    pub(crate) fn span(&self) -> Span {
        Span { from: self.from, until: self.until }
    }

    /// Checks that its area and its time are there.
    ///
    /// # Errors
    /// A sentence with the key.
    pub(crate) fn check(&self, places: &Places) -> Result<(), String> {
        self.span().check()?;
        places.area(&self.area).map(drop)
    }

    /// Of the area over time; `None` without a communication point in the time, or without people for a speed.
    pub(crate) fn value(&self, seen: &[Density]) -> Option<f64> {
        let span = self.span();
        let number = |seen: &Density| match self.number {
            OfDensity::People => Some(seen.people as f64),
            OfDensity::Density => Some(seen.classic),
            OfDensity::VoronoiDensity => seen.voronoi,
            OfDensity::Speed => seen.speed,
        };
        let all = MeanMax::of(seen.iter().filter(|seen| span.has(seen.time)).filter_map(number))?;
        Some(match self.take {
            MeanOrMax::Mean => all.mean,
            MeanOrMax::Max => all.max,
        })
    }
}
