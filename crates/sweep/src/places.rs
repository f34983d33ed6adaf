//! Lines and areas that a sweep measures at.

use crate::error::{Error, Place, Result};
use lemons_core::files::input;
use lemons_core::plane::{Vec2, polygon_from_wkt};
use lemons_core::trial::Wall;
use lemons_results::measure::{Line, MeasuringArea, Room};
use lemons_results::{given_area, walkable_area};
use sha2::{Digest, Sha256};
use std::path::{Path, PathBuf};

/// What `lines`, `areas` and `walkable` of a `sweep.toml` say; the numbers are those of `lemons measure`.
#[derive(Debug, Clone, Default)]
pub struct Places {
    /// With their names.
    lines: Vec<(String, Line)>,
    areas: Vec<(String, MeasuringArea)>,
    walkable: Option<Walkable>,
}

/// Where people can be, as a user gives it.
#[derive(Debug, Clone)]
struct Walkable {
    path: PathBuf,
    wkt: String,
}

/// \[bytes\] A polygon of more is a mistake.
const LARGEST_WALKABLE: u64 = 16 << 20;

impl Places {
    /// Reads the tables `[lines]` and `[areas]`, and the file of `walkable`.
    ///
    /// # Errors
    /// A sentence with the key and what is wrong.
    pub(crate) fn read(lines: toml::Table, areas: toml::Table, walkable: Option<PathBuf>) -> Result<Places> {
        let lines = lines.into_iter().map(|(name, value)| {
            let line = Line::of_numbers(&numbers(value)).ok_or_else(|| {
                Error::Spec(format!(
                    "lines: {name}: must be two different points [m] within 1e6 m, as in [8, 2.5, 8, 3.5]"
                ))
            });
            Ok((name, line?))
        });
        let areas = areas.into_iter().map(|(name, value)| {
            let area = MeasuringArea::of_numbers(&numbers(value)).ok_or_else(|| {
                Error::Spec(format!(
                    "areas: {name}: must be the lower left and the upper right corner [m], as in [3, 1, 5, 4], or at \
                     least three corners of a polygon that does not cross itself; all within 1e6 m"
                ))
            });
            Ok((name, area?))
        });
        let walkable = walkable.map(|path| {
            let wkt = input::read_text(&path, LARGEST_WALKABLE);
            let place = || format!("walkable: {}", path.display());
            let wkt = wkt.place(place)?;
            // Whether it is a polygon at all; who is outside is known later.
            given_area(&wkt, std::iter::empty())
                .map_err(|what| Error::Spec(format!("{}: {what}", place())))?;
            Ok::<_, Error>(Walkable { path, wkt })
        });
        Ok(Places {
            lines: lines.collect::<Result<_>>()?,
            areas: areas.collect::<Result<_>>()?,
            walkable: walkable.transpose()?,
        })
    }

    /// The file of the walkable area, if one is given.
    pub(crate) fn input(&self) -> Option<&Path> {
        self.walkable.as_ref().map(|walkable| walkable.path.as_path())
    }

    /// Whether an area is given for nothing.
    pub(crate) fn only_walkable(&self) -> bool {
        self.walkable.is_some() && self.areas.is_empty()
    }

    /// A line by its name.
    ///
    /// # Errors
    /// A sentence: there is none.
    pub(crate) fn line(&self, name: &str) -> Result<Line, String> {
        let found = self.lines.iter().find(|(known, _)| known == name).map(|(_, line)| *line);
        found.ok_or_else(|| missing("line", "lines", name, self.lines.iter().map(|(name, _)| name)))
    }

    /// An area by its name.
    ///
    /// # Errors
    /// A sentence: there is none.
    pub(crate) fn area(&self, name: &str) -> Result<&MeasuringArea, String> {
        let found = self.areas.iter().find(|(known, _)| known == name).map(|(_, area)| area);
        found.ok_or_else(|| missing("area", "areas", name, self.areas.iter().map(|(name, _)| name)))
    }

    /// Whether a user says where people can be.
    pub(crate) fn has_walkable(&self) -> bool {
        self.walkable.is_some()
    }

    /// Where people could be who were at these positions \[m\].
    ///
    /// # Errors
    /// A sentence: somebody was outside of the polygon of `walkable`.
    pub(crate) fn room(
        &self,
        walls: &[Wall],
        positions: impl Iterator<Item = Vec2> + Clone,
    ) -> Result<Room, String> {
        let positions = positions.filter(|position| position.is_finite());
        let area = match &self.walkable {
            Some(Walkable { path, wkt }) => {
                let given = given_area(wkt, positions);
                given.map_err(|what| format!("walkable: {}: {what}", path.display()))?
            }
            None => walkable_area(walls, positions),
        };
        let rings = polygon_from_wkt(&area.wkt)?;
        Room::of(&rings).ok_or_else(|| "the walkable area has no ring".into())
    }

    /// The SHA-256 of the walkable area, if one is given.
    pub(crate) fn walkable_digest(&self) -> Option<String> {
        self.walkable.as_ref().map(|walkable| crate::points::hex(&Sha256::digest(&walkable.wkt)))
    }
}

fn missing<'a>(one: &str, all: &str, name: &str, known: impl Iterator<Item = &'a String>) -> String {
    let known: Vec<String> = known.map(|name| format!("{name:?}")).collect();
    match &known[..] {
        [] => format!("{one} = {name:?}: the file has no [{all}]"),
        known => format!("{one} = {name:?}: there is none in [{all}], only {}", known.join(", ")),
    }
}

/// None at all where they are no finite numbers.
fn numbers(value: toml::Value) -> Vec<f64> {
    let numbers: Vec<f64> = value.try_into().unwrap_or_default();
    if numbers.iter().all(|number| number.is_finite()) { numbers } else { Vec::new() }
}
