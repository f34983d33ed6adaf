//! Values of a scenario's keys that are checked while they are read.

use crate::MOST_PEOPLE;
use crate::error::{Result, require};
use crate::within;
use lemons_core::plane::{Vec2, vec2};
use lemons_core::trial::{FARTHEST, OpeningTimes};
use lemons_people::Door;
use lemons_people::drawing::{DEVIATION, Enclosing, PlanSettings, Reading, WIDEST_DOOR};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Two numbers. An array of TOML that is too long would be cut otherwise.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Vec<f64>", into = "Vec<f64>")]
pub struct Pair(pub [f64; 2]);

impl TryFrom<Vec<f64>> for Pair {
    type Error = String;

    fn try_from(numbers: Vec<f64>) -> Result<Pair, String> {
        let count = numbers.len();
        numbers.try_into().map(Pair).map_err(|_| format!("must be two numbers, not {count}"))
    }
}

impl From<Pair> for Vec<f64> {
    fn from(Pair(numbers): Pair) -> Vec<f64> {
        numbers.to_vec()
    }
}

/// A door as numbers: x, y and width \[m\], then the times \[s\] from and to which it is open. The last time may be left out.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Vec<f64>", into = "Vec<f64>")]
pub struct DoorForm(pub Door);

impl TryFrom<Vec<f64>> for DoorForm {
    type Error = String;

    fn try_from(numbers: Vec<f64>) -> Result<DoorForm, String> {
        Door::of_numbers(&numbers).map(DoorForm).ok_or_else(|| {
            let rule = OpeningTimes::RULE;
            format!("{numbers:?}: must be x, y and a width, in m; then, if it opens and closes, {rule}")
        })
    }
}

impl From<DoorForm> for Vec<f64> {
    fn from(DoorForm(Door { at, width, open }): DoorForm) -> Vec<f64> {
        let times = open.iter().flat_map(OpeningTimes::numbers);
        [at.x, at.y, width].into_iter().chain(times).collect()
    }
}

impl DoorForm {
    pub(crate) fn check(&self) -> Result<()> {
        let Door { at, width, .. } = self.0;
        let good = [at.x, at.y].iter().all(|x| x.abs() <= FARTHEST) && (0.1..=1e3).contains(&width);
        let numbers: Vec<f64> = self.clone().into();
        require(good, || {
            format!("`doors`: {numbers:?}: the width must be from 0.1 to 1000 m, x and y from -1e9 to 1e9")
        })
    }
}

/// A part of the ground, and how many people stand there.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RegionForm {
    /// \[m\] Corners.
    pub corners: Vec<Pair>,
    /// Number of people.
    pub number: Option<u32>,
    /// \[1/m²\] Density of people. With neither, as the scenario says.
    pub density: Option<f64>,
}

impl RegionForm {
    /// Makes a region of corners \[m\], with as many people as the scenario says.
    pub fn of(corners: &[Vec2]) -> RegionForm {
        RegionForm {
            corners: corners.iter().map(|&corner| Pair(corner.into())).collect(),
            ..RegionForm::default()
        }
    }

    /// Returns the corners \[m\].
    pub fn corners(&self) -> Vec<Vec2> {
        self.corners.iter().map(|Pair([x, y])| vec2(*x, *y)).collect()
    }

    /// Checks the region of a place in the list.
    pub(crate) fn check(&self, k: usize) -> Result<()> {
        require(self.number.is_none() || self.density.is_none(), || {
            format!("`regions`: region {k}: number and density: give one of them")
        })?;
        let (number, density) = (self.number.unwrap_or(1), self.density.unwrap_or(1.0));
        require((1..=MOST_PEOPLE).contains(&number), || {
            format!("`regions`: region {k}: number = {number}: must be from 1 to {MOST_PEOPLE}")
        })?;
        require((1e-6..=100.0).contains(&density), || {
            format!("`regions`: region {k}: density = {density}: must be from 0.000001 to 100")
        })
    }
}

/// Reading of a drawing.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct DrawingForm {
    /// \[m\] Length of a unit; none: as the file says.
    pub unit: Option<f64>,
    /// \[m\] Ends of lines that are at most so far apart are joined.
    pub close: Option<f64>,
    /// \[m\] Largest distance of the straight pieces of a curve from it.
    pub deviation: Option<f64>,
    /// True if the lower left corner of all walls goes to the origin.
    pub origin: bool,
    /// The layers that are walls.
    pub walls: Vec<String>,
    /// True if the room is what walls enclose.
    pub enclosed: bool,
    /// Layers whose closed lines are obstacles.
    pub obstacles: Vec<String>,
    /// \[m\] Widest gap of a wall that is closed.
    pub widest: Option<f64>,
}

impl DrawingForm {
    pub(crate) fn check(&self) -> Result<()> {
        for (key, value, [low, high]) in [
            ("drawing.unit", self.unit, [1e-6, 1e6]),
            ("drawing.close", self.close, [1e-6, 100.0]),
            ("drawing.deviation", self.deviation, [1e-6, 100.0]),
            ("drawing.widest", self.widest, [1e-6, 100.0]),
        ] {
            within(key, value.unwrap_or(low), [low, high])?;
        }
        let enclosed = self.enclosed || (self.obstacles.is_empty() && self.widest.is_none());
        require(enclosed, || "`drawing`: obstacles and widest are for enclosed".into())
    }

    /// Returns how its lines are read.
    pub fn reading(&self) -> Reading {
        Reading { unit: self.unit, deviation: self.deviation.unwrap_or(DEVIATION) }
    }

    /// Returns how walls enclose a room, if they do.
    pub fn enclosing(&self) -> Option<Enclosing> {
        let widest = self.widest.unwrap_or(WIDEST_DOOR);
        self.enclosed.then(|| Enclosing { obstacles: self.obstacles.clone(), widest })
    }

    /// Returns what its lines mean.
    pub fn settings(&self) -> PlanSettings {
        PlanSettings {
            close: self.close,
            to_origin: self.origin,
            walls: self.walls.clone(),
            enclosing: self.enclosing(),
        }
    }
}

/// The share of a kind.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(untagged, expecting = "expected a number, or \"rest\": what the others leave of 100")]
pub enum Share {
    /// Relative to the others.
    Number(f64),
    /// What the others leave of 100.
    Rest(Rest),
}

/// The word `rest`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Rest {
    /// See [`Share::Rest`].
    Rest,
}

/// The shares of kinds as numbers.
pub(crate) fn shares(mix: &BTreeMap<String, Share>) -> Result<BTreeMap<String, f64>> {
    let numbers = mix.values().filter_map(|share| match share {
        Share::Number(share) => Some(share),
        Share::Rest(_) => None,
    });
    let (sum, count) = (numbers.clone().sum::<f64>(), numbers.count());
    require(count + 1 >= mix.len(), || {
        "`mix`: \"rest\" is there twice: only one kind can be the rest".into()
    })?;
    let rest = 100.0 - sum;
    require(count == mix.len() || rest >= 0.0, || {
        format!("`mix`: the others have {sum} together: nothing of 100 is left for the \"rest\"")
    })?;
    let share = |(name, share): (&String, &Share)| {
        let share = if let Share::Number(share) = share { *share } else { rest };
        (name.clone(), share)
    };
    Ok(mix.iter().map(share).collect())
}

/// Orientation of people.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum OrientationName {
    /// Any way.
    Free,
    /// Exactly along the direction.
    Fixed,
    /// First along the direction, then turned by their neighbours.
    Towards,
}

impl OrientationName {
    /// All of them.
    pub const ALL: [OrientationName; 3] =
        [OrientationName::Free, OrientationName::Fixed, OrientationName::Towards];

    /// Returns "free", "fixed" or "towards".
    pub fn name(self) -> &'static str {
        match self {
            OrientationName::Free => "free",
            OrientationName::Fixed => "fixed",
            OrientationName::Towards => "towards",
        }
    }
}
