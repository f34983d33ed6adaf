//! A crowd: what a page asks for, as a scenario -> a Trial.

use crate::base::{Basis, Driven, split};
use crate::{Refused, require, room, within};
use lemons_core::files::source::{Memory, Source};
use lemons_people::placing::Watch;
use lemons_people::room::Room;
use lemons_people::{CrowdStatistics, Sex};
use lemons_scenario::{Four, Made, People, RegionForm, Scenario, ScenarioError, Share, named};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::Path;

/// Largest number of people: what a page can pack and show.
pub const MOST_PEOPLE: u32 = 5000;

/// Largest seed: the largest integer that a page's numbers hold exactly.
pub const LARGEST_SEED: u64 = (1 << 53) - 1;

/// A crowd as a page asks for it: keys of a [`Scenario`].
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
#[allow(missing_docs)] // as there
pub struct CrowdRequest {
    pub number: Option<u32>,
    pub density: Option<f64>,
    pub seed: u64,
    pub room: Room,
    /// \[m\] Corners of the part of the room where they are placed.
    pub region: Option<Vec<[f64; 2]>>,
    pub people: PeopleRequest,
    #[serde(default)]
    pub mix: BTreeMap<String, f64>,
    pub men: f64,
    pub direction: Option<f64>,
    pub speed: f64,
    #[cfg_attr(feature = "typescript", ts(type = "Material"))]
    pub material: String,
    #[serde(default)]
    pub friction: Option<f64>,
    #[serde(default)]
    pub round: bool,
}

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

/// Whom people are drawn from.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
#[serde(tag = "kind", rename_all = "kebab-case")]
#[allow(missing_docs)] // as in a scenario
pub enum PeopleRequest {
    Survey,
    Statistics {
        male: Box<Four>,
        female: Box<Four>,
    },
    /// Sex, name and length of each table. The bytes are their contents.
    Table {
        files: Vec<(Sex, String, usize)>,
    },
}

impl PeopleRequest {
    /// The same in a scenario, and the files that it names.
    fn read(&self, bytes: &[u8]) -> Result<(People, Memory), Refused> {
        let mut memory = Memory::default();
        let people = match self.clone() {
            PeopleRequest::Survey => People::Survey {},
            PeopleRequest::Statistics { male, female } => People::Statistics { male, female },
            PeopleRequest::Table { files } => {
                let named: Vec<_> = files.iter().map(|(_, name, length)| (name.clone(), *length)).collect();
                let [mut male, mut female] = [None, None];
                for ((sex, ..), (name, content)) in files.iter().zip(split(&named, bytes)?) {
                    // Both may have one name.
                    let used = memory.paths().any(|path| path == Path::new(name));
                    let path =
                        if used { Path::new(sex.name()).join(name) } else { Path::new(name).to_owned() };
                    memory.put(&path, content.to_vec());
                    let own = if *sex == Sex::Male { &mut male } else { &mut female };
                    require(own.is_none(), || format!("{name}: there are two tables of one sex"))?;
                    *own = Some(path);
                }
                People::Tables { male, female }
            }
        };
        Ok((people, memory))
    }
}

impl CrowdRequest {
    fn scenario(&self, people: People) -> Scenario {
        let region = self.region.iter().map(|corners| {
            let corners: Vec<_> = corners.iter().map(|&corner| corner.into()).collect();
            RegionForm::of(&corners)
        });
        Scenario {
            number: self.number,
            density: self.density,
            seed: self.seed,
            room: Some(self.room.clone()),
            regions: region.collect(),
            people,
            mix: self.mix.iter().map(|(kind, share)| (kind.clone(), Share::Number(*share))).collect(),
            men: Some(self.men),
            direction: self.direction,
            speed: Some(self.speed),
            material: self.material.clone(),
            friction: self.friction,
            round: self.round,
            ..Scenario::default()
        }
    }
}

/// Draws people and places them without overlap, as `lemons crowd --seed` does.
///
/// # Errors
/// A number is out of range, there is no room, or `watch` stopped the placing.
pub fn crowd(wanted: &CrowdRequest, bytes: &[u8], watch: &mut Watch) -> Result<Basis, Refused> {
    within("seed", wanted.seed as f64, [0.0, LARGEST_SEED as f64])?;
    require(wanted.number.is_some() != wanted.density.is_some(), || {
        "give either the number of people or their density".into()
    })?;
    room::check_drawn(&wanted.room, wanted.region.as_deref())?;
    let (people, files) = wanted.people.read(bytes)?;
    made(&wanted.scenario(people), None, &files, watch)
}

/// Keys of a scenario, as the page calls them.
const WORDS: [(&str, &str); 2] =
    [("mix", "the mix of kinds"), ("regions", "the region where people are placed")];

/// A text about a scenario in words of the page.
fn words(text: &str) -> String {
    named(text, |key| Some(WORDS.iter().find(|(own, _)| *own == key)?.1.to_owned())).replace('`', "")
}

fn told(error: ScenarioError) -> Refused {
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
    let named = |Refused(why)| Refused(format!("{}: {why}", path.display()));
    within("seed", scenario.seed as f64, [0.0, LARGEST_SEED as f64]).map_err(named)?;
    scenario.room.iter().try_for_each(|room| room::check_drawn(room, None)).map_err(named)?;
    let name = path.file_stem().map(|stem| stem.to_string_lossy().into_owned());
    made(&scenario, name, files, watch).map_err(named)
}

fn made(
    scenario: &Scenario,
    name: Option<String>,
    files: &dyn Source,
    watch: &mut Watch,
) -> Result<Basis, Refused> {
    let Made { mut trial, agents, crowd, place, drive, decision, notes } =
        scenario.documents("", MOST_PEOPLE, files, watch).map_err(told)?;
    trial.name = name.unwrap_or_else(|| format!("crowd_{}_seed_{}", agents.len(), scenario.seed));
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
