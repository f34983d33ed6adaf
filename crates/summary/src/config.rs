//! What of a Trial is in which slot: `summary.toml`, as it was told when the FMU was packed.

use crate::quantities::{SummaryQuantity, What};
use lemons_core::plane::Vec2;
use lemons_core::trial::{DRIVE_FILE, Wall};
use lemons_decision::DECISION_FILE;
use lemons_results::measure::{LIMIT, MeasuringArea};
use lemons_results::walkable_area;
use lemons_sim::Documents;
use serde::{Deserialize, Serialize};
use std::fmt::Display;
use thiserror::Error;

/// Name of the settings among the resources.
pub const SUMMARY_FILE: &str = "summary.toml";

/// What of a Trial is in the slots. Where nothing is said, all that there is, in its order.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SummaryConfig {
    /// \[N\] Limit of the squeeze; [`LIMIT`] if it is not said.
    pub limit: Option<f64>,
    /// Names of exits.
    pub exits: Vec<String>,
    /// Ids of walls that open and close.
    pub doors: Vec<String>,
    /// Panels of walls, numbered as in `barrier[k].Load`.
    pub panels: Vec<usize>,
    /// Areas in which people are measured.
    pub areas: Vec<AreaConfig>,
}

/// An area in which people are measured.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AreaConfig {
    /// As descriptions name it.
    pub name: String,
    /// \[m\] As [`MeasuringArea::of_numbers`] wants them.
    pub corners: Vec<f64>,
}

/// Why a Trial has no such summary.
#[derive(Debug, Error)]
#[allow(missing_docs)] // the messages say it
pub enum SummaryError {
    #[error("{SUMMARY_FILE}: {0}")]
    Toml(String),
    #[error(
        "there are {} {what}, and a summary has room for {room}: choose with {option}, in the order of {first}1 to \
         {first}{room}:{}",
        .all.len(),
        listed(.all)
    )]
    TooMany { what: &'static str, all: Vec<String>, room: usize, option: &'static str, first: &'static str },
    #[error("{option} {given}: {why}{}", known(.all))]
    Unknown { option: &'static str, given: String, why: &'static str, all: Vec<String> },
    #[error("the area {0:?} must be a rectangle or a polygon that does not cross itself")]
    Area(String),
    #[error("a limit of {0:?} N: must be positive and finite")]
    Limit(f64),
    #[error(transparent)]
    Sim(#[from] lemons_sim::SimError),
}

/// A line for each of the first of them.
fn listed(all: &[String]) -> String {
    const MOST: usize = 50;
    let more = (all.len() > MOST).then(|| format!("\n  … {} more", all.len() - MOST));
    all.iter().take(MOST).map(|one| format!("\n  {one}")).chain(more).collect()
}

/// \[m\] As messages write a place.
fn at(x: f64, y: f64) -> String {
    let [x, y] = [x, y].map(|number| (1e6 * number).round() / 1e6);
    format!("({x:?}, {y:?})")
}

fn known(all: &[String]) -> String {
    if all.is_empty() { String::new() } else { format!(" (there are {})", all.join(", ")) }
}

/// What is in the slots.
#[derive(Debug)]
pub(crate) struct Slots {
    /// Exits, by their places among the targets of the plan.
    pub exits: Vec<usize>,
    /// Inputs that open and shut, and what: as [`Simulation::set_open`](lemons_sim::Simulation::set_open) names it.
    pub operated: Vec<(SummaryQuantity, String)>,
    pub panels: Vec<usize>,
    pub areas: Vec<MeasuringArea>,
    /// \[N\]
    pub limit: f64,
    /// Of each of them, how descriptions name it.
    names: [Vec<String>; 4],
}

/// Things of which some are chosen.
struct Choice {
    what: &'static str,
    option: &'static str,
    /// How names of variables begin.
    first: &'static str,
    room: usize,
}

impl Choice {
    /// Returns the places of the chosen ones, by their names; without any, all places. `told` says what each is.
    fn of(
        &self,
        all: &[String],
        chosen: &[impl Display],
        told: impl Fn(&usize) -> String,
    ) -> Result<Vec<usize>, SummaryError> {
        let Choice { what, option, first, room } = *self;
        let mut places: Vec<usize> = (0..all.len()).collect();
        if !chosen.is_empty() {
            places.clear();
        }
        for given in chosen.iter().map(ToString::to_string) {
            let refused =
                |why| SummaryError::Unknown { option, given: given.clone(), why, all: all.to_vec() };
            let place = all.iter().position(|name| *name == given).ok_or_else(|| refused("is not there"))?;
            if places.contains(&place) {
                return Err(refused("is given twice"));
            }
            places.push(place);
        }
        if places.len() > room {
            let all = places.iter().map(told).collect();
            return Err(SummaryError::TooMany { what, all, room, option, first });
        }
        Ok(places)
    }
}

impl SummaryConfig {
    /// Reads TOML.
    ///
    /// # Errors
    /// The text is not TOML, or has unknown keys or values of the wrong type.
    pub fn from_toml(text: &str) -> Result<SummaryConfig, SummaryError> {
        toml::from_str(text).map_err(|error| SummaryError::Toml(error.to_string()))
    }

    /// Returns the text of the file.
    ///
    /// # Errors
    /// The settings cannot be written.
    pub fn to_toml(&self) -> Result<String, SummaryError> {
        toml::to_string(self).map_err(|error| SummaryError::Toml(error.to_string()))
    }

    /// Returns what somebody may not have meant: an area in which nobody is, and that nobody walks.
    pub fn notes(&self, documents: &Documents) -> Vec<String> {
        let (trial, mut notes) = (&documents.trial, Vec::new());
        if documents.plan.is_none() {
            notes.push(format!(
                "nobody walks, since there is no {DECISION_FILE}: people move by Fp and Mp of AgentDynamics.xml and by \
                 {DRIVE_FILE}, and there are no exits, speed_factor, push and stop"
            ));
        }
        let starts = trial.dynamics.iter().map(|own| own.motion().pose.position);
        let there = walkable_area(&trial.geometry.walls, starts);
        let around = if there.boxed { "of people and walls" } else { "of the walls around people" };
        let outside = self.areas.iter().filter(|area| {
            MeasuringArea::of_numbers(&area.corners).is_some_and(|area| !area.meets(&there.polygon))
        });
        notes.extend(outside.map(|AreaConfig { name, .. }| {
            format!("the area {name:?} is outside {around}: it is empty until somebody comes out")
        }));
        notes
    }

    /// Finds what is in the slots.
    ///
    /// # Errors
    /// There is more than fits, something is not there or twice, or an area is none.
    pub(crate) fn slots(&self, documents: &Documents) -> Result<Slots, SummaryError> {
        let limit = self.limit.unwrap_or(LIMIT.0);
        if !(limit > 0.0 && limit.is_finite()) {
            return Err(SummaryError::Limit(limit));
        }
        let targets = documents.plan.as_ref().map_or(&[][..], |plan| &plan.targets);
        let exits: Vec<usize> = (0..targets.len()).filter(|k| !targets[*k].stay).collect();
        let named: Vec<String> = exits.iter().map(|k| targets[*k].name.clone()).collect();
        let choice = |what, option, first, of: What| Choice { what, option, first, room: of.slots() };
        let exit = |k: &usize| format!("exit {:?}", named[*k]);
        let exit_at = |k: &usize| {
            let corners: Vec<String> = targets[exits[*k]].corners.iter().map(|[x, y]| at(*x, *y)).collect();
            format!("{}: {} m", exit(k), corners.join(" "))
        };
        let chosen =
            choice("exits", "--exit NAME", "exit", What::ExitLeft).of(&named, &self.exits, exit_at)?;
        let geometry = &documents.trial.geometry;
        let of_doors: Vec<&Wall> = geometry.doors().map(|(_, door)| door).collect();
        let ids: Vec<String> = of_doors.iter().map(|door| door.id.clone()).collect();
        let door = |k: &usize| format!("door, wall {:?}", ids[*k]);
        let door_at = |k: &usize| {
            let corners: Vec<String> = of_doors[*k].corners.iter().map(|end| at(end.x, end.y)).collect();
            format!("{}: {} m", door(k), corners.join(" "))
        };
        let doors = choice("doors", "--door ID", "door", What::DoorOpen).of(&ids, &self.doors, door_at)?;
        let places: Vec<(&Wall, [Vec2; 2])> = geometry.panels().collect();
        let panel = |k: &usize| {
            let (wall, [from, to]) = places[*k];
            let [from, to] = [from, to].map(|end| at(end.x, end.y));
            format!("panel {k}, of the wall {:?} from {from} to {to} m", wall.id)
        };
        let numbers: Vec<String> = (0..places.len()).map(|k| k.to_string()).collect();
        let panels = choice("panels of walls", "--panel NUMBER", "barrier", What::BarrierLoad).of(
            &numbers,
            &self.panels,
            panel,
        )?;
        let names: Vec<String> = self.areas.iter().map(|area| area.name.clone()).collect();
        let named_area = |k: &usize| format!("area {:?}", names[*k]);
        choice("areas", "fewer --area", "area", What::AreaDensity).of(&names, &names, named_area)?;
        let area = |AreaConfig { name, corners }: &AreaConfig| {
            MeasuringArea::of_numbers(corners).ok_or_else(|| SummaryError::Area(name.clone()))
        };
        let input = |what, slot| SummaryQuantity { what, slot };
        let of_exits =
            chosen.iter().enumerate().map(|(slot, k)| (input(What::ExitOpen, slot), format!("exit[{k}]")));
        let of_operated =
            doors.iter().enumerate().map(|(slot, k)| (input(What::DoorOpen, slot), format!("door[{k}]")));
        Ok(Slots {
            names: [
                chosen.iter().map(exit).collect(),
                doors.iter().map(door).collect(),
                panels.iter().map(panel).collect(),
                (0..names.len()).map(|k| named_area(&k)).collect(),
            ],
            exits: chosen.iter().map(|k| exits[*k]).collect(),
            operated: of_exits.chain(of_operated).collect(),
            panels,
            areas: self.areas.iter().map(area).collect::<Result<_, _>>()?,
            limit,
        })
    }
}

impl Slots {
    /// Returns how descriptions name what is in the slots of something; `None` of what is of the whole crowd.
    pub fn names(&self, what: What) -> Option<&[String]> {
        let [exits, doors, panels, areas] = &self.names;
        Some(match what {
            What::ExitLeft | What::ExitFlow | What::ExitQueue | What::ExitOpen => exits,
            What::DoorOpen => doors,
            What::BarrierLoad => panels,
            What::AreaDensity
            | What::AreaSqueezeMean
            | What::AreaSqueeze95
            | What::AreaSqueezeMax
            | What::AreaAbove => areas,
            _ => return None,
        })
    }
}
