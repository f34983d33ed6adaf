//! Values of a scenario's keys that are checked while they are read.

use crate::error::{Result, impossible, require, within};
use crate::range;
use lemons_core::plane::{Ring, Vec2};
use lemons_core::trial::{FARTHEST, Ground, Incline, Link, OpeningTimes};
use lemons_people::drawing::{DEVIATION, Enclosing, PlanSettings, Reading, WIDEST_DOOR};
use lemons_people::{Door, PeopleError, Slabs};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Share of the downhill force that feet hold: an assumption, which fits the two slopes of the Green Guide
/// (docs/slopes.md).
const USUALLY_HELD: f64 = 0.5;

/// Two numbers. An array of TOML that is too long would be cut otherwise.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS), ts(as = "[f64; 2]", rename = "Pair"))]
#[serde(try_from = "Vec<f64>", into = "Vec<f64>")]
pub struct TwoNumbers(pub [f64; 2]);

impl TryFrom<Vec<f64>> for TwoNumbers {
    type Error = String;

    fn try_from(numbers: Vec<f64>) -> Result<TwoNumbers, String> {
        let count = numbers.len();
        numbers.try_into().map(TwoNumbers).map_err(|_| format!("must be two numbers, not {count}"))
    }
}

impl From<TwoNumbers> for Vec<f64> {
    fn from(TwoNumbers(numbers): TwoNumbers) -> Vec<f64> {
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
        DoorForm::of(&numbers).ok_or_else(|| format!("{numbers:?}: {}", DoorForm::rule()))
    }
}

impl From<DoorForm> for Vec<f64> {
    fn from(DoorForm(Door { at, width, open }): DoorForm) -> Vec<f64> {
        let times = open.iter().flat_map(OpeningTimes::numbers);
        [at.x, at.y, width].into_iter().chain(times).collect()
    }
}

impl DoorForm {
    /// Makes a door of its numbers, if they follow the [`rule`](DoorForm::rule).
    pub fn of(numbers: &[f64]) -> Option<DoorForm> {
        let door = Door::of_numbers(numbers)?;
        let near = [door.at.x, door.at.y].iter().all(|x| x.abs() <= FARTHEST);
        (near && (0.1..=1e3).contains(&door.width)).then_some(DoorForm(door))
    }

    /// Returns what the numbers must be.
    pub fn rule() -> String {
        let times = OpeningTimes::RULE;
        format!(
            "must be x, y and a width in m, as in 8,3,1; the width is from 0.1 to 1000, x and y are from -1e9 to 1e9; \
             then, if it opens and closes, {times}, as in 8,3,1,20,60; the last time may be left out"
        )
    }

    pub(crate) fn check(&self) -> Result<()> {
        let again = DoorForm::try_from(Vec::from(self.clone()));
        again.map(drop).map_err(|why| impossible(format!("`doors`: {why}")))
    }
}

/// A part of the ground, and how many people stand there.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
#[serde(deny_unknown_fields)]
pub struct RegionForm {
    /// \[m\] Corners.
    pub corners: Vec<TwoNumbers>,
    /// Number of people.
    pub number: Option<u32>,
    /// \[1/m²\] Density of people. With neither, as the scenario says.
    pub density: Option<f64>,
}

impl RegionForm {
    /// Makes a region of corners \[m\], with as many people as the scenario says.
    pub fn of(corners: &[Vec2]) -> RegionForm {
        RegionForm {
            corners: corners.iter().map(|&corner| TwoNumbers(corner.into())).collect(),
            ..RegionForm::default()
        }
    }

    /// Returns the corners \[m\].
    pub fn corners(&self) -> Vec<Vec2> {
        self.corners.iter().map(|corner| corner.0.into()).collect()
    }

    /// Checks the region of a place in the list.
    pub(crate) fn check(&self, k: usize) -> Result<()> {
        require(self.number.is_none() || self.density.is_none(), || {
            format!("`regions`: region {k}: number and density: give one of them")
        })?;
        let (number, density) = (self.number.map_or(1.0, f64::from), self.density.unwrap_or(1.0));
        within(format_args!("`regions`: region {k}: number"), number, range("number"))?;
        within(format_args!("`regions`: region {k}: density"), density, range("density"))
    }
}

/// A slope or stairs.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
#[serde(deny_unknown_fields)]
pub struct GroundForm {
    /// \[m\] Corners.
    pub corners: Vec<TwoNumbers>,
    /// \[°\] Direction in which it falls.
    pub downhill: f64,
    /// \[°\] Angle of a slope.
    pub angle: Option<f64>,
    /// Share of the downhill force that feet hold; if it is not said, 0.5.
    pub held: Option<f64>,
    /// \[m\] Height of a step of stairs.
    pub riser: Option<f64>,
    /// \[m\] Depth of a step of stairs.
    pub tread: Option<f64>,
    /// Factor of the speed of who walks straight down.
    pub speed_down: Option<f64>,
    /// The same, up.
    pub speed_up: Option<f64>,
}

impl GroundForm {
    /// Returns the ground of a place in the list.
    pub(crate) fn ground(&self, k: usize) -> Result<Ground> {
        let wrong = |why: String| impossible(format!("`grounds`: ground {k}: {why}"));
        let incline = match (self.angle, self.held, self.riser, self.tread) {
            (Some(angle), held, None, None) => {
                Incline::Slope { angle: angle.to_radians(), held: held.unwrap_or(USUALLY_HELD) }
            }
            (None, None, Some(riser), Some(tread)) => Incline::Stairs { riser, tread },
            _ => return Err(wrong("give an angle, of a slope, or riser and tread, of stairs".into())),
        };
        let area = Ring::through(self.corners.iter().map(|corner| corner.0.into()).collect());
        let ground = Ground {
            id: k.to_string(),
            area: area.ok_or_else(|| wrong("has no corners".into()))?,
            downhill: self.downhill.to_radians(),
            incline,
            speeds: [self.speed_down, self.speed_up],
        };
        ground.check().map_err(wrong)?;
        Ok(ground)
    }
}

/// Two lines that are one.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
#[serde(deny_unknown_fields)]
pub struct LinkForm {
    /// \[m\] Ends of a line; the ground is to its left.
    pub here: [TwoNumbers; 2],
    /// \[m\] Ends of the other line, the same way.
    pub there: [TwoNumbers; 2],
}

impl LinkForm {
    /// Returns the link of a place in the list.
    pub(crate) fn link(&self, k: usize) -> Result<Link> {
        let lines = [self.here, self.there].map(|line| line.map(|end| end.0.into()));
        let link = Link { id: k.to_string(), lines };
        link.check().map_err(|why| impossible(format!("`links`: link {k}: {why}")))?;
        Ok(link)
    }
}

/// Reading of a drawing.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
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
    /// Checks each value.
    ///
    /// # Errors
    /// A length is out of range, or a key is for another.
    pub fn check(&self) -> Result<()> {
        for (key, value, [low, high]) in [
            ("drawing.unit", self.unit, [1e-6, 1e6]),
            ("drawing.close", self.close, [1e-6, 100.0]),
            ("drawing.deviation", self.deviation, [1e-6, 100.0]),
            ("drawing.widest", self.widest, [1e-6, 100.0]),
        ] {
            within(format_args!("`{key}`"), value.unwrap_or(low), [low, high])?;
        }
        let enclosed = self.enclosed || (self.obstacles.is_empty() && self.widest.is_none());
        Ok(require(enclosed, || "`drawing`: obstacles and widest are for enclosed".to_owned())?)
    }

    /// Returns how its lines are read.
    pub fn reading(&self) -> Reading {
        Reading { unit: self.unit, deviation: self.deviation.unwrap_or(DEVIATION) }
    }

    /// Returns what its lines mean.
    pub fn settings(&self) -> PlanSettings {
        let widest = self.widest.unwrap_or(WIDEST_DOOR);
        PlanSettings {
            close: self.close,
            to_origin: self.origin,
            walls: self.walls.clone(),
            enclosing: self.enclosed.then(|| Enclosing { obstacles: self.obstacles.clone(), widest }),
        }
    }
}

/// Levels in which people have disks.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
#[serde(untagged, expecting = "expected a number of levels, or their heights in m, as in [1.0, 1.3]")]
pub enum LevelsForm {
    /// So many equal ones.
    Number(u32),
    /// \[m\] About these heights.
    Heights(Vec<f64>),
}

impl LevelsForm {
    /// Returns them.
    ///
    /// # Errors
    /// There are too few or too many, or the heights are not possible.
    pub fn slabs(&self) -> Result<Slabs, PeopleError> {
        match self {
            LevelsForm::Number(count) => Slabs::equal(*count as usize),
            LevelsForm::Heights(heights) => Slabs::about(heights),
        }
    }
}

/// The share of a kind.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(untagged, expecting = "expected a number, or \"rest\": what the others leave of 100")]
pub enum Share {
    /// Relative to the others.
    Number(f64),
    /// The rest that the others leave of 100.
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
    let number = |share: &Share| if let Share::Number(number) = share { Some(*number) } else { None };
    let numbers: Vec<f64> = mix.values().filter_map(number).collect();
    require(numbers.len() + 1 >= mix.len(), || {
        "`mix`: \"rest\" is there twice: only one kind can be the rest".to_owned()
    })?;
    let sum: f64 = numbers.iter().sum();
    let rest = 100.0 - sum;
    require(numbers.len() == mix.len() || rest >= 0.0, || {
        format!("`mix`: the others have {sum} together: nothing of 100 is left for the \"rest\"")
    })?;
    Ok(mix.iter().map(|(name, share)| (name.clone(), number(share).unwrap_or(rest))).collect())
}

/// Orientation of people.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
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
        ["free", "fixed", "towards"][self as usize]
    }
}
