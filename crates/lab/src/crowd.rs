//! A crowd: a scenario -> a Trial.

use crate::loaded::{LoadedTrial, PlacedCrowd, UneditedTrial};
use crate::reply::{told, words};
use crate::{Refused, room, within};
use lemons_core::files::source::Memory;
use lemons_core::message::message;
use lemons_core::rule::parts::OF;
use lemons_people::CrowdStatistics;
use lemons_people::placing::Watch;
use lemons_scenario::{Scenario, ScenarioDocuments};
use std::path::Path;

/// Largest number of people: what a page can pack and show.
pub const MOST_PEOPLE: u32 = 5000;

/// Largest seed: the largest integer that a page's numbers hold exactly.
pub const LARGEST_SEED: u64 = (1 << 53) - 1;

/// Draws people and places them without overlap, as `lemons crowd --seed` does.
///
/// # Errors
/// A number is out of range, there is no room, or `watch` stopped the placing.
pub fn crowd(
    scenario: &Scenario,
    files: &[(&str, &[u8])],
    watch: &mut Watch,
) -> Result<UneditedTrial, Refused> {
    let mut memory = Memory::default();
    files.iter().for_each(|(name, file)| memory.put(Path::new(name), file.to_vec()));
    documents_of(scenario, None, &memory, watch)
}

/// Makes a scenario of a file.
///
/// # Errors
/// As those of [`Scenario::read`] and [`Scenario::documents`].
pub fn of_file(path: &Path, files: &Memory, watch: &mut Watch) -> Result<UneditedTrial, Refused> {
    let scenario = Scenario::read(files, path).map_err(told)?;
    let name = path.file_stem().map(|stem| stem.to_string_lossy().into_owned());
    documents_of(&scenario, name, files, watch)
        .map_err(|Refused(why)| Refused(message!(OF, of = path.display().to_string(), finding = why)))
}

fn documents_of(
    of: &Scenario,
    name: Option<String>,
    files: &Memory,
    watch: &mut Watch,
) -> Result<UneditedTrial, Refused> {
    within("seed", of.seed() as f64, [0.0, LARGEST_SEED as f64])?;
    room::check_drawn(of)?;
    let ScenarioDocuments { mut trial, agents, crowd, place, drive, decision, notes } =
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
    let notes = notes.iter().map(|note| words(note).into()).collect();
    let mut loaded = LoadedTrial::alone(trial, Some(agents));
    loaded.push(drive);
    Ok(UneditedTrial {
        loaded: loaded.decided(decision.map(|(config, _)| config))?,
        notes,
        placing: Some(made),
    })
}
