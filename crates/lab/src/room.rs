//! Rooms: an outline, obstacles, further walls, doors. While they are drawn, when they are made, in place of a Trial's
//! walls, and from a file.

#[cfg(feature = "typescript")]
use crate::reply::MessageShown;
use crate::reply::{NONE_CLOSED, TOO_MANY_CORNERS, told};
use crate::{Refused, Reply, require, within};
use crowd_mechanics::setup::Setup;
use lemons_core::files::source::Memory;
use lemons_core::message::{Message, message};
use lemons_core::plane::{Bounds, Ring, Vec2};
use lemons_core::trial::{ContactCoefficients, FARTHEST, Geometry, Trial};
use lemons_people::drawing::{
    Drawing, DrawingFormat, FloorPlan, Gap, LARGEST_DRAWING, Layer, Leads, NamedPlace, PlanSettings,
    Proposal, Read, sizes,
};
use lemons_people::room::{Room, RoomEdit};
use lemons_people::{Door, PeopleError, nearest_wall};
use lemons_scenario::{DrawingForm, RegionForm, Scenario, WALLS};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// Most corners of all walls of a room together.
const MOST_CORNERS: usize = 5000;
/// \[m\] Largest coordinate of a room that is drawn.
const REACH: f64 = 1000.0;

/// A question about a room that is drawn.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
#[serde(deny_unknown_fields)]
pub struct RoomRequest {
    /// As it was.
    pub room: Room,
    /// A change of it.
    pub edit: Option<RoomEdit>,
    /// \[m\] A place: where is the nearest wall?
    pub near: Option<[f64; 2]>,
}

/// A room as it is drawn.
#[derive(Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub(crate) struct Drawn {
    room: Room,
    /// The way of each door along its wall, from end to end.
    doors: Vec<Vec<[f64; 2]>>,
    rings: Vec<Outline>,
    near: Option<Near>,
}

/// A line of a room.
#[derive(Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub(crate) struct Outline {
    /// Width, height, left and low of the rectangle around it.
    bounds: [f64; 4],
    /// Whether it is this rectangle.
    upright: bool,
    /// Middles of its sides.
    middles: Vec<[f64; 2]>,
}

/// The place on a wall that is nearest to the place that was asked for.
#[derive(Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub(crate) struct Near {
    ring: usize,
    side: usize,
    at: [f64; 2],
    away: f64,
}

/// Returns the room after the edit. It may have walls that cross, and any size: it is not made yet. With it, of each door
/// its way along the wall; of each line, width, height, left and low of the rectangle around it, whether it is that
/// rectangle, and the middles of its sides; and the nearest wall.
///
/// # Errors
/// The edit is of something that is not there, or an obstacle has no corners.
pub fn drawn(RoomRequest { room, edit, near }: &RoomRequest) -> Result<Reply, Refused> {
    let mut room = room.clone();
    if let Some(edit) = edit {
        room.change(*edit)?;
    }
    let lines = room.lines()?;
    let course = |door: &Door| points(&door.course(&lines));
    let shape = |line: &Vec<Vec2>| {
        let Bounds { low, high } = Bounds::of(line.iter().copied()).unwrap_or(Bounds::UNIT);
        let size = high - low;
        let middles: Vec<Vec2> = line.windows(2).map(|side| (side[0] + side[1]) * 0.5).collect();
        let bounds = [size.x, size.y, low.x, low.y];
        let ring = Ring::of_closed(line);
        let upright = ring.is_some_and(|ring| ring.is_upright());
        Outline { bounds, upright, middles: points(&middles) }
    };
    let near = near.and_then(|place| nearest_wall(&lines, place.into()));
    let near =
        near.map(|(ring, foot)| Near { ring, side: foot.side, at: foot.place.into(), away: foot.distance });
    let doors = room.doors.iter().map(course).collect();
    let rings = lines.iter().map(shape).collect();
    Reply::of(Drawn { room, doors, rings, near })
}

fn points(of: &[Vec2]) -> Vec<[f64; 2]> {
    of.iter().map(|point| [point.x, point.y]).collect()
}

/// Checks how many corners a room has, and how far they and others are.
fn check(room: &Room, others: Vec<Vec2>, reach: f64) -> Result<(), Refused> {
    let count = room.every_corner().count();
    require(count <= MOST_CORNERS, || message!(TOO_MANY_CORNERS, count, most = MOST_CORNERS))?;
    room.every_corner().chain(&others).try_for_each(|corner| {
        within("x of a corner [m]", corner.x, [-reach, reach])?;
        within("y of a corner [m]", corner.y, [-reach, reach]).map(drop)
    })
}

/// Checks a room that is drawn, and the corners of the regions where people are placed.
///
/// # Errors
/// There are too many corners, or one is too far.
pub fn check_drawn(Scenario { room, regions, .. }: &Scenario) -> Result<(), Refused> {
    let regions = || regions.iter().flat_map(RegionForm::corners).collect();
    room.as_ref().map_or(Ok(()), |room| check(room, regions(), REACH))
}

/// Returns the walls that a room has in place of a Trial's. New ones are of the material of its first wall, else of one that
/// has a contact with everybody's, concrete before others.
///
/// # Errors
/// There are too many corners, a wall is none that a Trial may have, a door is not at a wall, or there is no material.
pub fn replacing(room: &Room, trial: &Trial) -> Result<Geometry, Refused> {
    check(room, Vec::new(), FARTHEST)?;
    let of_people: BTreeSet<&str> =
        trial.agents.iter().flat_map(|agent| &agent.shapes).map(|disk| &*disk.material_id).collect();
    let touches = |one: &str, other: &str| {
        trial.materials.binary.iter().any(|ContactCoefficients { id1, id2, .. }| {
            (id1 == one && id2 == other) || (id1 == other && id2 == one)
        })
    };
    let mut known: Vec<&str> = trial.materials.intrinsic.iter().map(|material| &*material.id).collect();
    known.sort_by_key(|id| *id != WALLS);
    let usable = || known.iter().copied().find(|wall| of_people.iter().all(|other| touches(wall, other)));
    let material = trial.geometry.walls.first().map(|wall| &*wall.material_id).or_else(usable);
    let none =
        || Refused::from("no material of this Trial has a contact with everybody's: no wall can be added");
    Ok(room.replacing(&trial.geometry, material.ok_or_else(none)?)?)
}

/// Says what is odd about a Trial with other walls and was not before: people in walls or pillars, or outside.
pub fn unfit(before: &Trial, after: &Trial) -> Vec<Message> {
    let messages_of = |trial: &Trial| -> Vec<Message> {
        let advice = Setup::of(trial).advice_as_edited().into_iter();
        advice.map(|problem| problem.message).collect()
    };
    let before = messages_of(before);
    messages_of(after).into_iter().filter(|message| !before.contains(message)).collect()
}

/// Content of a drawing.
#[derive(Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub(crate) struct Understood {
    /// `None`: no wall is closed, but there are proposals.
    room: Option<Room>,
    exits: Vec<ExitFound>,
    /// Where people stand.
    distributions: Vec<Vec<[f64; 2]>>,
    waypoints: usize,
    /// \[m²\]
    area: Option<f64>,
    /// As `lemons room` says it: what, and how.
    said: Vec<(String, String)>,
    /// Those of which some can be chosen as walls.
    layers: Vec<String>,
    /// Why its outline may not be the room.
    #[cfg_attr(feature = "typescript", ts(as = "Option<MessageShown>"))]
    doubt: Option<Message>,
    proposal: Option<Proposed>,
}

/// An exit of a drawing.
#[derive(Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub(crate) struct ExitFound {
    name: String,
    corners: Vec<[f64; 2]>,
}

/// Meaning that a drawing seems to have: [`Proposal`].
#[derive(Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub(crate) struct Proposed {
    layers: Vec<LayerFound>,
    walls: Vec<String>,
    obstacles: Vec<String>,
    widest: f64,
    close: Option<f64>,
    areas: [f64; 2],
    ground: Vec<Vec<[f64; 2]>>,
    gaps: Vec<GapFound>,
    questions: Vec<String>,
}

/// A layer of a drawing.
#[derive(Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub(crate) struct LayerFound {
    name: String,
    sort: &'static str,
    lines: usize,
}

/// A gap in a wall of a drawing.
#[derive(Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub(crate) struct GapFound {
    kind: &'static str,
    door: Door,
    outside: bool,
    #[cfg_attr(feature = "typescript", ts(as = "MessageShown"))]
    said: Message,
}

/// A drawing, or a Geometry.xml, and how it is understood.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub struct DrawingRequest {
    /// The file's name, which says the format.
    pub name: String,
    /// Reading of a drawing.
    #[serde(flatten)]
    pub drawing: DrawingForm,
    /// Further doors: exits on the nearest closed walls.
    #[serde(default)]
    pub doors: Vec<Door>,
}

/// Most doors of a drawing.
const MOST_DOORS: usize = 100;

/// Returns the room in a file; its exits, with lines behind those that are doors; where people are placed; its layers; its
/// area \[m²\]; what was understood, as `lemons room` says it; why it may not be the room; and what is proposed instead.
///
/// # Errors
/// The file has errors, does not say its unit, is no drawing, a door is not at a wall, or none of its walls is closed and
/// there is nothing to propose.
pub fn read(wanted: &DrawingRequest, bytes: &[u8]) -> Result<Reply, Refused> {
    let DrawingRequest { name, drawing: form, doors } = wanted;
    let wrong = |why: String| Refused::from(format!("{name}: {why}"));
    require(doors.len() <= MOST_DOORS, || {
        format!("{name}: {} doors: at most {MOST_DOORS} are allowed", doors.len())
    })?;
    let (mut doubt, mut proposal) = (None, None);
    let (mut plan, messages, layers) = if let Some(format) = DrawingFormat::of(Path::new(name)) {
        form.check().map_err(told)?;
        require(bytes.len() as u64 <= LARGEST_DRAWING, || {
            format!("{name}: more than {} MB", LARGEST_DRAWING / 1_000_000)
        })?;
        let (reading, settings) = (form.reading(), form.settings());
        let read = Read::of(format, bytes, &reading, &settings).map_err(|error| wrong(explained(error)))?;
        if read.doubt.is_some() || read.plan.outline.is_none() || form.enclosed {
            let drawing = Drawing::read(format, bytes, &reading)?;
            let PlanSettings { close, walls, enclosing, .. } = settings;
            // Only a hint: a drawing with too many lines has none.
            let found = Proposal::of(&drawing, &walls, close, enclosing.as_ref()).ok().flatten();
            proposal = found.map(|found| if form.origin { found.at_origin() } else { found });
        }
        doubt.clone_from(&read.doubt);
        let messages = read.messages(name).into_iter().map(|(what, how)| (what.to_owned(), how)).collect();
        (read.plan, messages, read.layers)
    } else {
        let mut files = Memory::default();
        files.put(Path::new(name), bytes.to_vec());
        let (geometry, warnings) = Geometry::read_from(&files, Path::new(name))?;
        let messages: Vec<_> =
            warnings.iter().map(|warning| ("warning".to_owned(), warning.to_string())).collect();
        (FloorPlan::of_geometry(&geometry, Vec::new()), messages, Vec::new())
    };
    for door in doors {
        plan.add_door(door).map_err(|error| wrong(error.to_string()))?;
    }
    let none = || {
        let advice = "close gaps, or take it as a picture and draw the outline over it";
        wrong(format!("none of its {} walls is closed, so nothing is inside: {advice}", plan.walls.len()))
    };
    let room = Room::of(&plan);
    if room.is_none() {
        if proposal.as_ref().is_none_or(|found| found.ground.is_empty()) {
            return Err(none());
        }
        doubt = Some(message!(NONE_CLOSED, count = plan.walls.len()));
    }
    let lines = room.as_ref().map_or_else(|| Ok(Vec::new()), Room::lines)?;
    let doors: BTreeMap<usize, Door> = plan.doors().into_iter().collect();
    let exit = |(k, NamedPlace { name, corners }): (usize, &NamedPlace)| {
        let beyond = doors.get(&k).and_then(|door| door.exit(&lines, std::iter::empty()));
        let corners = beyond.map_or_else(|| corners.clone(), |line| line.to_vec());
        ExitFound { name: name.clone(), corners: points(&corners) }
    };
    Reply::of(Understood {
        exits: plan.exits.iter().enumerate().map(exit).collect(),
        distributions: plan.distributions.iter().map(|place| points(&place.corners)).collect(),
        waypoints: plan.waypoints.len(),
        area: plan.area(),
        proposal: proposal.as_ref().map(proposed),
        room,
        said: messages,
        layers,
        doubt,
    })
}

/// Returns a proposal for the page.
fn proposed(found: &Proposal) -> Proposed {
    let gap = |gap: &Gap| GapFound {
        kind: gap.kind(),
        door: gap.door(),
        outside: gap.leads == Leads::Outside,
        said: gap.described(),
    };
    let layer =
        |layer: &Layer| LayerFound { name: layer.name.clone(), sort: layer.sort.name(), lines: layer.lines };
    Proposed {
        layers: found.layers.iter().map(layer).collect(),
        walls: found.walls.clone(),
        obstacles: found.enclosing.obstacles.clone(),
        widest: found.enclosing.widest,
        close: found.close,
        areas: found.areas,
        ground: found.ground.iter().map(|rim| points(rim)).collect(),
        gaps: found.gaps.iter().map(gap).collect(),
        questions: found.questions.clone(),
    }
}

/// Adds what to do where the unit is not known.
fn explained(error: PeopleError) -> String {
    match error {
        PeopleError::NoUnit { size, .. } => {
            let size = size.map(|size| format!("; {}", sizes(size))).unwrap_or_default();
            format!("it does not say what its unit is: choose the unit{size}")
        }
        error => error.to_string(),
    }
}
