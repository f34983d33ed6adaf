//! How dense a crowd is in an area, and how fast.

use crate::measure::number::{check_number, number_of};
use crate::places::Places;
use lemons_results::measure::{Density, MeanMax};
use serde::Deserialize;

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
