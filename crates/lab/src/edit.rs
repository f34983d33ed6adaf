//! Changes by hand: people are moved, copied, put there, taken away; the walls of a Trial are others.

use crate::frame::overlapping;
use crate::loaded::LoadedTrial;
use crate::person::PersonRequest;
use crate::reply::{NO_SUCH_ID, NOBODY_LEFT, OVERLAPS, OVERLAPS_WALL, TOO_MANY_EDITS};
use crate::{Refused, require, room, within};
use crowd_mechanics::setup::Setup;
use lemons_core::message::{Message, message};
use lemons_core::plane::{Vec2, vec2};
use lemons_core::trial::{Agent, AgentDynamics, Interactions, Trial};
use lemons_people::room::Room;
use lemons_people::{
    BodyDisk, CrowdMember, PART_MATERIALS, Person, SKINS, Shape, chest_height, choose_mechanical_step,
};
use lemons_scenario::Scenario;
use serde::Deserialize;
use std::collections::{BTreeMap, BTreeSet};

/// Most changes of a Trial.
const MOST: usize = 10_000;

/// A change of one person: whom it is, and to where \[m, rad\]; or of the walls.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
#[serde(tag = "do", rename_all = "kebab-case", deny_unknown_fields)]
#[allow(missing_docs)] // as said
pub enum Edit {
    /// Elsewhere, or turned.
    Move { id: String, x: f64, y: f64, theta: f64 },
    /// Another one with the same shape, at rest, with an Id of its own.
    Copy { id: String, r#as: String, x: f64, y: f64, theta: f64 },
    /// A new one with these measures, of the material of the first one, driven like it.
    Put { id: String, person: PersonRequest, x: f64, y: f64, theta: f64 },
    /// Nobody any more.
    Delete { id: String },
    /// The walls of a Trial that is no crowd of the page.
    Room { room: Box<Room> },
}

/// Makes the changes one after the other; `crowd` is the scenario of a crowd of the page. Contacts that the Trial remembers are forgotten if there are any. A crowd's
/// mechanical step is chosen again: whoever is lighter than the others needs a shorter one.
///
/// # Errors
/// There is nobody with an Id, an Id is there already, nobody would be left, a measure is no person's, or a number is
/// not finite.
pub fn edited(
    mut loaded: LoadedTrial,
    edits: &[Edit],
    crowd: Option<&Scenario>,
) -> Result<LoadedTrial, Refused> {
    require(edits.len() <= MOST, || message!(TOO_MANY_EDITS, count = edits.len(), most = MOST))?;
    for edit in edits {
        change(&mut loaded, edit, crowd)?;
        loaded.trial.interactions = Interactions::default();
    }
    require(!loaded.trial.agents.is_empty(), || message!(NOBODY_LEFT))?;
    if crowd.is_some() && !edits.is_empty() {
        choose_mechanical_step(&mut loaded.trial);
    }
    Ok(loaded)
}

/// Returns the room that was drawn last, if one was.
pub fn room_of(edits: &[Edit]) -> Option<&Room> {
    edits.iter().rev().find_map(|edit| match edit {
        Edit::Room { room } => Some(&**room),
        _ => None,
    })
}

/// Makes those of the changes that fit: of people who are there, to places where they overlap neither others nor walls. Returns
/// which others there are, and why they do not fit. Whoever overlaps stays as without changes: first the one who overlaps most.
///
/// # Errors
/// Nobody would be left, or too many people are at one place.
pub fn fitting(
    before: &LoadedTrial,
    edits: &[Edit],
    crowd: Option<&Scenario>,
) -> Result<(LoadedTrial, BTreeMap<usize, Message>), Refused> {
    let mut left_out = BTreeMap::new();
    loop {
        let mut made = Vec::new();
        let mut loaded = before.clone();
        for (k, edit) in edits.iter().enumerate() {
            if left_out.contains_key(&k) {
                continue;
            }
            // What is impossible changes nothing.
            match change(&mut loaded, edit, crowd) {
                Ok(()) => made.push(edit.clone()),
                Err(Refused(why)) => _ = left_out.insert(k, why),
            }
        }
        let loaded = edited(before.clone(), &made, crowd)?;
        let world = Setup::of(&loaded.trial).world()?;
        let put: BTreeSet<&str> = made.iter().filter_map(Edit::put).collect();
        let agents = loaded.trial.agents.iter().enumerate().filter(|(_, agent)| put.contains(&*agent.id));
        let depths = agents.map(|(place, agent)| (overlapping(&world, Some(place)), &agent.id));
        let deepest = depths.max_by(|((_, _, one), _), ((_, _, other), _)| one.total_cmp(other));
        let Some(((_, wall, depth), id)) = deepest.filter(|((_, _, depth), _)| *depth > 0.0) else {
            return Ok((loaded, left_out));
        };
        let depth = 1e3 * depth;
        let why = if wall { message!(OVERLAPS_WALL, id, depth) } else { message!(OVERLAPS, id, depth) };
        for (k, _) in edits.iter().enumerate().filter(|(_, edit)| edit.put() == Some(id)) {
            left_out.entry(k).or_insert_with(|| why.clone());
        }
    }
}

impl Edit {
    /// Whom it puts somewhere.
    fn put(&self) -> Option<&str> {
        match self {
            Edit::Move { id, .. } | Edit::Copy { r#as: id, .. } | Edit::Put { id, .. } => Some(id),
            Edit::Delete { .. } | Edit::Room { .. } => None,
        }
    }
}

fn change(loaded: &mut LoadedTrial, edit: &Edit, crowd: Option<&Scenario>) -> Result<(), Refused> {
    let place_of = |id: &String| {
        let place = loaded.trial.agents.iter().position(|agent| agent.id == *id);
        place.ok_or_else(|| Refused(message!(NO_SUCH_ID, id)))
    };
    match edit {
        Edit::Room { room } => {
            require(crowd.is_none(), || "a crowd has its room already".to_owned())?;
            loaded.trial.geometry = room::replacing(room, &loaded.trial)?;
        }
        Edit::Move { id, x, y, theta } => {
            let here = place_of(id)?;
            let here = &mut loaded.trial.dynamics[here];
            (here.position, here.theta) = pose(*x, *y, *theta)?;
        }
        Edit::Copy { id, r#as: to, x, y, theta } => {
            let place = place_of(id)?;
            let here = pose(*x, *y, *theta)?;
            let person = loaded.people.as_ref().map(|people| people[place].clone());
            let (agent, drive) = (loaded.trial.agents[place].clone(), loaded.trial.dynamics[place].clone());
            put(loaded, to, agent, person, drive, here)?;
        }
        Edit::Put { id, person, x, y, theta } => {
            let (person, here) = (person.person()?, pose(*x, *y, *theta)?);
            let alone = CrowdMember::Pedestrian(person);
            let (agent, drive) = measured(&loaded.trial, &person, &alone, crowd)?;
            put(loaded, id, agent, Some(alone), drive, here)?;
        }
        Edit::Delete { id } => {
            let place = place_of(id)?;
            loaded.trial.agents.remove(place);
            loaded.trial.dynamics.remove(place);
            if let Some(people) = &mut loaded.people {
                people.remove(place);
            }
        }
    }
    Ok(())
}

/// A person of the material of the first one, driven like it.
fn measured(
    trial: &Trial,
    person: &Person,
    alone: &CrowdMember,
    crowd: Option<&Scenario>,
) -> Result<(Agent, AgentDynamics), Refused> {
    let first = trial.agents.first().zip(trial.dynamics.first());
    let (first, drive) = first.ok_or_else(|| Refused(message!(NOBODY_LEFT)))?;
    let mut shape = Shape::of(person)?;
    if crowd.is_some_and(|scenario| scenario.round) {
        shape = lemons_scenario::round(&shape);
    }
    let slabs = crowd.and_then(|scenario| scenario.settings().slabs);
    let disks = match &slabs {
        Some(slabs) => slabs.disks(alone)?,
        None => shape.disks.iter().copied().map(BodyDisk::of).collect(),
    };
    let materials = trial.agents.iter().flat_map(|agent| &agent.shapes).map(|disk| &disk.material_id);
    let own = materials.clone().find(|id| !PART_MATERIALS.contains(&&***id));
    // Where all sit in wheelchairs, nobody has a material.
    let material_id = own.map_or(SKINS[0], |id| id);
    let disk = |BodyDisk { disk, heights, .. }: BodyDisk| lemons_core::trial::ShapeElement {
        radius: disk.radius,
        material_id: material_id.to_owned(),
        position: disk.centre,
        heights,
    };
    let agent = Agent {
        mass: person.mass,
        height: Some(person.stature),
        moment_of_inertia: shape.inertia(person.mass),
        chest_height: slabs.and_then(|_| chest_height(alone, &disks)),
        shapes: disks.into_iter().map(disk).collect(),
        kind: None,
        ..first.clone()
    };
    let drive = AgentDynamics { fp: drive.fp * (person.mass / first.mass), mp: 0.0, ..drive.clone() };
    Ok((agent, drive))
}

/// Somebody more, at rest.
fn put(
    loaded: &mut LoadedTrial,
    id: &str,
    agent: Agent,
    person: Option<lemons_people::CrowdMember>,
    drive: AgentDynamics,
    (position, theta): (Vec2, f64),
) -> Result<(), Refused> {
    let trial = &mut loaded.trial;
    let odd = id.trim().is_empty() || id.len() > 100 || id.chars().any(char::is_control);
    let taken = trial.agents.iter().any(|agent| agent.id == id);
    require(!odd && !taken, || format!("the Id {id:?} is no short text, or there already"))?;
    trial.agents.push(Agent { id: id.into(), ..agent });
    trial.dynamics.push(AgentDynamics {
        position,
        theta,
        velocity: Vec2::zeros(),
        omega: 0.0,
        absent: false,
        ..drive
    });
    if let Some((people, person)) = loaded.people.as_mut().zip(person) {
        people.push(person);
    }
    Ok(())
}

fn pose(x: f64, y: f64, theta: f64) -> Result<(Vec2, f64), Refused> {
    for (what, value) in [("x [m]", x), ("y [m]", y), ("the angle [rad]", theta)] {
        within(what, value, [-1e6, 1e6])?;
    }
    Ok((vec2(x, y), theta))
}
