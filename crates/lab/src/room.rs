//! Rooms: an outline, obstacles, doors. While they are drawn, when they are made, and from a file.

use crate::{Refused, Reply, require, within};
use lemons_core::plane::{Bounds, Ring, Vec2};
use lemons_core::trial::Geometry;
use lemons_people::placing::Region;
use lemons_people::room::{Edit, Room};
use lemons_people::{Door, nearest_wall};
use serde::Deserialize;
use serde_json::json;
use std::path::Path;

/// Most corners of all walls of a room together.
const MOST_CORNERS: usize = 2000;
/// In messages.
pub const REGION: &str = "the region where people are placed";
/// \[m\] Range of coordinates.
const REACH: [f64; 2] = [-1000.0, 1000.0];

/// A question about a room that is drawn.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RoomRequest {
    /// As it was.
    pub room: Room,
    /// A change of it.
    pub edit: Option<Edit>,
    /// \[m\] A place: where is the nearest wall?
    pub near: Option<[f64; 2]>,
}

/// Returns the room after the edit. It may have walls that cross, and any size: it is not made yet. With it, of each door
/// its way along the wall; of each ring, width, height, left and low of the rectangle around it, whether it is that
/// rectangle, and the middles of its sides; and the nearest wall.
///
/// # Errors
/// The edit is of something that is not there, or an outline has no corners.
pub fn drawn(RoomRequest { room, edit, near }: &RoomRequest) -> Result<Reply, Refused> {
    let mut room = room.clone();
    if let Some(edit) = edit {
        room.change(*edit)?;
    }
    let rings = room.rings()?;
    let course = |door: &Door| points(&door.course(&rings));
    let shape = |ring: &Ring| {
        let (Bounds { low, .. }, size) = (ring.bounds(), ring.bounds().size());
        let middles: Vec<Vec2> = ring.sides().map(|(start, end)| (start + end) * 0.5).collect();
        let bounds = [size.x, size.y, low.x, low.y];
        json!({ "bounds": bounds, "upright": ring.is_upright(), "middles": points(&middles) })
    };
    let near = near.and_then(|place| nearest_wall(&rings, place.into()));
    let near = near.map(|(ring, foot)| {
        json!({ "ring": ring, "side": foot.side, "at": <[f64; 2]>::from(foot.place), "away": foot.distance })
    });
    let doors: Vec<_> = room.doors.iter().map(course).collect();
    let rings: Vec<_> = rings.iter().map(shape).collect();
    Ok(Reply::of(json!({ "room": room, "doors": doors, "rings": rings, "near": near })))
}

fn points(of: &[Vec2]) -> Vec<[f64; 2]> {
    of.iter().map(|point| [point.x, point.y]).collect()
}

fn check<'a>(corners: impl IntoIterator<Item = &'a Vec2>) -> Result<(), Refused> {
    corners.into_iter().try_for_each(|corner| {
        within("x of a corner [m]", corner.x, REACH)?;
        within("y of a corner [m]", corner.y, REACH).map(|_| ())
    })
}

/// Returns the room's inside, and its walls with doors.
///
/// # Errors
/// It is too large, walls cross, an obstacle is not inside, or a door is not at a wall.
pub fn built(room: &Room) -> Result<(Region, Geometry), Refused> {
    let corners = || room.outline.iter().chain(room.obstacles.iter().flatten());
    let count = corners().count();
    require(count <= MOST_CORNERS, || format!("{count} corners: at most {MOST_CORNERS} are allowed"))?;
    check(corners())?;
    Ok(room.built("concrete")?)
}

/// Returns a part of a room: where people are placed.
///
/// # Errors
/// Its sides cross, or it goes beyond the room.
pub fn part(whole: &Region, corners: &[[f64; 2]]) -> Result<Region, Refused> {
    let corners: Vec<Vec2> = corners.iter().copied().map(Vec2::from).collect();
    check(&corners)?;
    whole.part(&corners).map_err(|error| Refused(format!("{REGION}: {error}")))
}

/// Returns the room in a Geometry.xml: the largest wall is its outline, the others are obstacles.
///
/// # Errors
/// The file has errors, or its walls are not closed.
pub fn upload(name: &str, bytes: &[u8]) -> Result<Reply, Refused> {
    let mut files = lemons_core::files::source::Memory::default();
    files.put(Path::new(name), bytes.to_vec());
    let (geometry, warnings) = Geometry::read_from(&files, Path::new(name))?;
    let region = Region::from_walls(&geometry).map_err(|error| Refused(format!("{name}: {error}")))?;
    let mut rings = region.rings().iter().map(|ring| points(ring.corners()));
    let outline = rings.next();
    let notes: Vec<String> = warnings.iter().map(ToString::to_string).collect();
    let obstacles: Vec<_> = rings.collect();
    Ok(Reply::of(json!({ "outline": outline, "obstacles": obstacles, "doors": [], "notes": notes })))
}
