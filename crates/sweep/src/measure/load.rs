//! How hard people press on walls.

use crate::measure::number_of;
use lemons_core::require;
use lemons_core::trial::Geometry;
use lemons_results::measure::{LoadsOverTime, WallLoad};
use serde::Deserialize;

/// A measure of the loads on walls, which have the usual panels where the Trial does not say it.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LoadMeasure {
    /// A number of [`WallLoad`].
    pub load: String,
    /// Id of a wall; if it is missing, of any.
    pub wall: Option<String>,
    /// True for the load on a wall in all, instead of the one on a panel.
    #[serde(default)]
    pub whole: bool,
    /// \[s\] From this time on.
    pub from: Option<f64>,
    /// \[s\] Up to this time.
    pub until: Option<f64>,
}

/// The numbers that can be asked for.
const NUMBERS: [&str; 5] = ["load_step", "load_1", "load_10", "load_peak", "impulse"];

impl LoadMeasure {
    /// Checks that there is such a number.
    ///
    /// # Errors
    /// A sentence with the key.
    pub(crate) fn check(&self) -> Result<(), String> {
        let load = &*self.load;
        require(NUMBERS.contains(&load), || {
            format!("load = {load:?}: must be one of {}", NUMBERS.join(", "))
        })?;
        require(!self.whole || load != "load_peak", || {
            "load = \"load_peak\" is of panels: the peaks of a whole wall's panels are at different instants"
                .to_owned()
        })
    }

    /// Begins to sum up the loads.
    ///
    /// # Errors
    /// There is no such wall, or none at all.
    pub(crate) fn begin(&self, geometry: &Geometry) -> Result<LoadsOverTime, String> {
        require(!geometry.walls.is_empty(), || "load: there are no walls".to_owned())?;
        if let Some(id) = &self.wall {
            let known = geometry.walls.iter().any(|wall| wall.id == *id);
            require(known, || format!("wall = {id:?}: there is no such wall"))?;
        }
        Ok(LoadsOverTime::of(geometry))
    }

    /// Returns the greatest number of the walls or panels; `None` if the record is too short for it.
    pub(crate) fn value(&self, seen: LoadsOverTime) -> Option<f64> {
        let seen = seen.finish()?;
        let counts = |id: &String| self.wall.as_ref().is_none_or(|wall| wall == id);
        let walls = seen.walls.iter().map(|(id, load)| (id, load)).filter(|_| self.whole);
        let panels = seen.panels.iter().map(|(panel, load)| (&panel.wall, load)).filter(|_| !self.whole);
        let loads = walls.chain(panels).filter(|(id, _)| counts(id));
        let numbers = loads.map(|(_, load): (_, &WallLoad)| number_of(&self.load, load));
        // All are known, or none.
        numbers.collect::<Option<Vec<f64>>>()?.into_iter().reduce(f64::max)
    }
}
