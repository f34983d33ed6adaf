//! A crowd: a scenario -> a Trial.

use crate::base::{Basis, Driven};
use crate::{Refused, room, within};
use lemons_core::files::source::Memory;
use lemons_people::CrowdStatistics;
use lemons_people::placing::Watch;
use lemons_scenario::{Made, Scenario, ScenarioError, named};
use serde::Serialize;
use std::path::Path;

/// Largest number of people: what a page can pack and show.
pub const MOST_PEOPLE: u32 = 5000;

/// Largest seed: the largest integer that a page's numbers hold exactly.
pub const LARGEST_SEED: u64 = (1 << 53) - 1;

/// How a crowd was placed.
#[derive(Debug, Clone, Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub(crate) struct PlacedCrowd {
    density: f64,
    area: f64,
    iterations: u64,
    largest_overlap: f64,
    statistics: CrowdStatistics,
}

/// Draws people and places them without overlap, as `lemons crowd --seed` does.
///
/// # Errors
/// A number is out of range, there is no room, or `watch` stopped the placing.
pub fn crowd(scenario: &Scenario, files: &[(&str, &[u8])], watch: &mut Watch) -> Result<Basis, Refused> {
    let mut memory = Memory::default();
    files.iter().for_each(|(name, file)| memory.put(Path::new(name), file.to_vec()));
    made(scenario, None, &memory, watch)
}

/// Keys of a scenario, as the page calls them.
const WORDS: [(&str, &str); 5] = [
    ("mix", "the mix of kinds"),
    ("regions", "the region where people are placed"),
    ("drawing.unit", "length of a unit [m]"),
    ("drawing.close", "width of a gap [m]"),
    ("drawing.widest", "width of a gap [m]"),
];

/// A text about a scenario in words of the page.
fn words(text: &str) -> String {
    named(text, |key| Some(WORDS.iter().find(|(own, _)| *own == key)?.1.to_owned())).replace('`', "")
}

/// An error in words of the page.
pub fn told(error: ScenarioError) -> Refused {
    match error {
        ScenarioError::Toml(what) | ScenarioError::NoRoom { what, .. } => Refused(what),
        error => Refused(words(&error.to_string())),
    }
}

/// Makes a scenario of a file.
///
/// # Errors
/// As those of [`Scenario::read`] and [`Scenario::documents`].
pub fn of_file(path: &Path, files: &Memory, watch: &mut Watch) -> Result<Basis, Refused> {
    let scenario = Scenario::read(files, path).map_err(told)?;
    let name = path.file_stem().map(|stem| stem.to_string_lossy().into_owned());
    made(&scenario, name, files, watch).map_err(|Refused(why)| Refused(format!("{}: {why}", path.display())))
}

fn made(of: &Scenario, name: Option<String>, files: &Memory, watch: &mut Watch) -> Result<Basis, Refused> {
    within("seed", of.seed() as f64, [0.0, LARGEST_SEED as f64])?;
    room::check_drawn(of)?;
    let Made { mut trial, agents, crowd, place, drive, decision, notes } =
        of.documents("", MOST_PEOPLE, files, watch).map_err(told)?;
    trial.name = name.unwrap_or_else(|| format!("crowd_{}_seed_{}", agents.len(), of.seed()));
    let packing = &crowd.packing;
    let made = PlacedCrowd {
        density: packing.density,
        area: place.area_of(packing),
        iterations: packing.iterations,
        largest_overlap: packing.largest_overlap,
        statistics: CrowdStatistics::of(&agents),
    };
    let notes = notes.iter().map(|note| words(note)).collect();
    let mut driven = Driven::alone(trial, Some(agents));
    driven.push(drive);
    Ok(Basis { driven: driven.decided(decision.map(|(config, _)| config))?, notes, made: Some(made) })
}
