//! Lines and areas, and what is measured at them: who crosses a line; how dense a crowd is in an area, and how fast.

use crate::error::{ErrorPlace, Result};
use crate::measure::{check_number, number_of};
use crate::points::Points;
use lemons_core::files::input;
use lemons_core::plane::{InPlane, Vec2};
use lemons_core::require;
use lemons_core::trial::Wall;
use lemons_results::measure::{
    CountingLine, Crossings, Density, MeanMax, MeasuringArea, Passages, VoronoiRoom, Way,
};
use lemons_results::{given_area, walkable_area};
use serde::Deserialize;
use std::path::PathBuf;

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
    /// \[s\] From this time on.
    pub from: Option<f64>,
    /// \[s\] Up to this time.
    pub until: Option<f64>,
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
        require(fits, || "width is for number = \"specific_flow\"".to_owned())?;
        (0..points.count).try_for_each(|point| self.width_at(point, line, points).map(drop))
    }

    /// Returns the width at a point \[m\].
    pub(crate) fn width_at(&self, point: usize, line: CountingLine, points: &Points) -> Result<f64, String> {
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
        require(positive, || format!("width: {width:?} is not a positive number of metres"))?;
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
    /// \[s\] From this time on.
    pub from: Option<f64>,
    /// \[s\] Up to this time.
    pub until: Option<f64>,
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

/// `lines`, `areas` and `walkable` of a `sweep.toml`; the numbers are those of `lemons measure`.
#[derive(Debug, Clone, Default)]
pub struct Places {
    /// With their names.
    lines: Vec<(String, CountingLine)>,
    pub(crate) areas: Vec<(String, MeasuringArea)>,
    pub(crate) walkable: Option<Walkable>,
}

/// Where people can be, as a user gives it.
#[derive(Debug, Clone)]
pub(crate) struct Walkable {
    pub path: PathBuf,
    pub wkt: String,
}

/// \[bytes\] A polygon of more is a mistake.
const LARGEST_WALKABLE: u64 = 16 << 20;

impl Places {
    /// Reads the tables `[lines]` and `[areas]`, and the file of `walkable`.
    ///
    /// # Errors
    /// A sentence with the key and what is wrong.
    pub(crate) fn read(lines: toml::Table, areas: toml::Table, walkable: Option<PathBuf>) -> Result<Places> {
        let lines = read("lines", lines, CountingLine::of_numbers, LINE)?;
        let areas = read("areas", areas, MeasuringArea::of_numbers, AREA)?;
        let walkable = walkable.map(|path| -> Result<Walkable> {
            let place = || format!("walkable: {}", path.display());
            let wkt = input::read_text(&path, LARGEST_WALKABLE).place(place)?;
            // Whether it is a polygon at all; who is outside is known later.
            given_area(&wkt, std::iter::empty()).place(place)?;
            Ok(Walkable { path, wkt })
        });
        Ok(Places { lines, areas, walkable: walkable.transpose()? })
    }

    /// Returns a line by its name.
    ///
    /// # Errors
    /// A sentence: there is none.
    pub(crate) fn line(&self, name: &str) -> Result<CountingLine, String> {
        find("line", &self.lines, name).copied()
    }

    /// Returns an area by its name.
    ///
    /// # Errors
    /// A sentence: there is none.
    pub(crate) fn area(&self, name: &str) -> Result<&MeasuringArea, String> {
        find("area", &self.areas, name)
    }

    /// Returns where people could be who were at these positions \[m\].
    ///
    /// # Errors
    /// A sentence: somebody was outside of the polygon of `walkable`.
    pub(crate) fn room(&self, walls: &[Wall], positions: &[Vec2]) -> Result<VoronoiRoom, String> {
        let positions = positions.iter().copied().filter(|position| position.is_finite());
        let area = match &self.walkable {
            Some(Walkable { path, wkt }) => {
                let given = given_area(wkt, positions);
                given.map_err(|what| format!("walkable: {}: {what}", path.display()))?
            }
            None => walkable_area(walls, positions),
        };
        Ok(VoronoiRoom::of(&area.polygon))
    }
}

/// Finds a line or an area by its name.
fn find<'a, T>(what: &str, all: &'a [(String, T)], name: &str) -> Result<&'a T, String> {
    if let Some((_, found)) = all.iter().find(|(known, _)| known == name) {
        return Ok(found);
    }
    let known: Vec<String> = all.iter().map(|(name, _)| format!("{name:?}")).collect();
    Err(match &known[..] {
        [] => format!("{what} = {name:?}: the file has no [{what}s]"),
        known => format!("{what} = {name:?}: there is none in [{what}s], only {}", known.join(", ")),
    })
}

const LINE: &str = "two different points [m] within 1e6 m, as in [8, 2.5, 8, 3.5]";
const AREA: &str = "the lower left and the upper right corner [m], as in [3, 1, 5, 4], or at least three corners of a \
                    polygon that does not cross itself; all within 1e6 m";

/// Reads a table of lines or areas: lists of numbers.
fn read<T>(
    key: &str,
    table: toml::Table,
    made: impl Fn(&[f64]) -> Option<T>,
    must: &str,
) -> Result<Vec<(String, T)>> {
    let read = |(name, value): (String, toml::Value)| {
        let numbers: Vec<f64> = value.try_into().unwrap_or_default();
        let made = made(&numbers).ok_or_else(|| format!("{key}: {name}: must be {must}"))?;
        Ok((name, made))
    };
    table.into_iter().map(read).collect()
}
