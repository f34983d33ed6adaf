//! Lines and areas that a sweep measures at.

use crate::error::{Place, Result};
use lemons_core::files::input;
use lemons_core::plane::Vec2;
use lemons_core::trial::Wall;
use lemons_results::measure::{Line, MeasuringArea, Room};
use lemons_results::{given_area, walkable_area};
use std::path::PathBuf;

/// What `lines`, `areas` and `walkable` of a `sweep.toml` say; the numbers are those of `lemons measure`.
#[derive(Debug, Clone, Default)]
pub struct Places {
    /// With their names.
    lines: Vec<(String, Line)>,
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
        let lines = read("lines", lines, Line::of_numbers, LINE)?;
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
    pub(crate) fn line(&self, name: &str) -> Result<Line, String> {
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
    pub(crate) fn room(&self, walls: &[Wall], positions: &[Vec2]) -> Result<Room, String> {
        let positions = positions.iter().copied().filter(|position| position.is_finite());
        let area = match &self.walkable {
            Some(Walkable { path, wkt }) => {
                let given = given_area(wkt, positions);
                given.map_err(|what| format!("walkable: {}: {what}", path.display()))?
            }
            None => walkable_area(walls, positions),
        };
        Ok(Room::of(&area.polygon))
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
