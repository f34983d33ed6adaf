//! A room as it is drawn: its corners and doors, changes that leave doors on their walls, and the walls in the end.

use crate::drawing::FloorPlan;
use crate::error::{PeopleError, Result, require};
use crate::placing::Region;
use crate::{Door, cut_doors_in_all, is_closed, nearest_wall, walls};
use lemons_core::plane::{Bounds, Vec2, vec2};
use lemons_core::trial::{Geometry, Wall};
use serde::{Deserialize, Serialize};

/// A room. Outlines may go round in either direction.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
#[serde(deny_unknown_fields)]
pub struct Room {
    /// \[m\] Corners, the first one not repeated; none where the walls of a Trial are changed.
    #[cfg_attr(feature = "typescript", ts(as = "Vec<[f64; 2]>"))]
    pub outline: Vec<Vec2>,
    /// \[m\] The corners of each.
    #[cfg_attr(feature = "typescript", ts(as = "Vec<Vec<[f64; 2]>>"))]
    pub obstacles: Vec<Vec<Vec2>>,
    /// Further walls, open ones too.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub walls: Vec<RoomWall>,
    /// Gaps in the walls.
    pub doors: Vec<Door>,
}

/// A wall that need not be closed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS), ts(rename = "Further"))]
#[serde(deny_unknown_fields)]
pub struct RoomWall {
    /// \[m\] Corners; the first one is repeated at the end of a closed wall.
    #[cfg_attr(feature = "typescript", ts(as = "Vec<[f64; 2]>"))]
    pub corners: Vec<Vec2>,
    /// The Id of the Trial's wall that it was: it keeps Id and material.
    #[serde(default)]
    pub of: Option<String>,
}

impl RoomWall {
    fn is_closed(&self) -> bool {
        is_closed(&self.corners)
    }
}

/// A change of a room. Line 0 is its outline, obstacles and further walls follow; side 0 begins at corner 0.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
#[serde(tag = "do", rename_all = "kebab-case", deny_unknown_fields)]
#[allow(missing_docs)] // places in m
pub enum RoomEdit {
    /// A corner goes elsewhere.
    Move {
        ring: usize,
        corner: usize,
        #[cfg_attr(feature = "typescript", ts(as = "[f64; 2]"))]
        to: Vec2,
    },
    /// A side gets a corner.
    Insert {
        ring: usize,
        side: usize,
        #[cfg_attr(feature = "typescript", ts(as = "[f64; 2]"))]
        at: Vec2,
    },
    /// A corner goes away.
    Remove { ring: usize, corner: usize },
    /// An obstacle or a further wall goes away, with its doors.
    Clear { ring: usize },
    /// The outline gets this width and height \[m\]; its left and low ends stay.
    Stretch { width: f64, height: f64 },
}

impl Room {
    /// Returns the room of a plan. Closed walls are obstacles, if they lie side by side inside the outline; else they
    /// stay as they are, and so do open ones. Exits on walls are doors. `None` without an outline.
    pub fn of(plan: &FloorPlan) -> Option<Room> {
        let outline = plan.outline?;
        let corners = |wall: &RoomWall| wall.corners[..wall.corners.len() - 1].to_vec();
        let wall = |corners: &Vec<Vec2>| RoomWall { corners: corners.clone(), of: None };
        let mut all: Vec<RoomWall> = plan.walls.iter().map(wall).collect();
        let outline = corners(&all.remove(outline));
        let (closed, open): (Vec<RoomWall>, Vec<RoomWall>) =
            all.iter().cloned().partition(RoomWall::is_closed);
        let obstacles: Vec<Vec<Vec2>> = closed.iter().map(corners).collect();
        let doors = plan.doors().into_iter().map(|(_, door)| door).collect();
        Some(if Region::polygon(&outline, &obstacles).is_ok() {
            Room { outline, obstacles, walls: open, doors }
        } else {
            Room { outline, obstacles: Vec::new(), walls: all, doors }
        })
    }

    /// Returns the outline, the obstacles and the further walls, as lines: the first corner of a closed one is repeated at
    /// its end. The line of an outline that is not there is empty.
    ///
    /// # Errors
    /// An obstacle or a wall has no corners, or the outline that obstacles are in.
    pub fn lines(&self) -> Result<Vec<Vec<Vec2>>> {
        let round = |corners: &Vec<Vec2>| corners.iter().chain(corners.first()).copied().collect();
        let lines = std::iter::once(&self.outline).chain(&self.obstacles).map(round);
        let lines: Vec<Vec<Vec2>> = lines.chain(self.walls.iter().map(|wall| wall.corners.clone())).collect();
        let missing =
            |(k, line): (usize, &Vec<Vec2>)| line.is_empty() && (k > 0 || !self.obstacles.is_empty());
        require(!lines.iter().enumerate().any(missing), || {
            "the outline or an obstacle has no corners".to_owned()
        })?;
        Ok(lines)
    }

    /// Changes it. Where corners of a wall go elsewhere, so do its doors: to the same share of the same side, to the
    /// millimetre.
    ///
    /// # Errors
    /// There is no such corner, or none would be left. The room is then of no use.
    pub fn change(&mut self, edit: RoomEdit) -> Result<()> {
        let before = self.lines()?;
        match edit {
            RoomEdit::Move { ring, corner, to } => {
                let closed = self.closed_wall(ring);
                let corners = self.corners(ring, corner)?;
                corners[corner] = to;
                let last = corners.len() - 1;
                if closed && (corner == 0 || corner == last) {
                    (corners[0], corners[last]) = (to, to);
                }
            }
            RoomEdit::Insert { ring, side, at } => self.corners(ring, side)?.insert(side + 1, at),
            RoomEdit::Remove { ring, corner } => {
                let closed = self.closed_wall(ring);
                let corners = self.corners(ring, corner)?;
                if closed {
                    corners.pop();
                    corners.remove(corner % corners.len());
                    // Of a triangle one side is left: there and back it would be two walls on each other.
                    corners.extend(corners.first().copied().filter(|_| corners.len() > 2));
                } else {
                    corners.remove(corner);
                }
            }
            RoomEdit::Clear { ring } => {
                self.corners(ring, 0)?.clear();
                require(!self.outline.is_empty() || before[0].is_empty(), || {
                    "the outline or an obstacle has no corners".to_owned()
                })?;
                self.obstacles.retain(|obstacle| !obstacle.is_empty());
                self.walls.retain(|wall| !wall.corners.is_empty());
                let on = |door: &Door| nearest_wall(&before, door.at).is_some_and(|(on, _)| on == ring);
                self.doors.retain(|door| !on(door));
                // Others have another number now, but are where they were.
                return Ok(());
            }
            RoomEdit::Stretch { width, height } => {
                let Some(Bounds { low, high }) = Bounds::of(before[0].iter().copied()) else { return Ok(()) };
                for corner in &mut self.outline {
                    corner.x = stretched(corner.x, [low.x, high.x], width);
                    corner.y = stretched(corner.y, [low.y, high.y], height);
                }
            }
        }
        let after = self.lines()?;
        for door in &mut self.doors {
            let carried = door.carried(&before, &after);
            if carried != *door {
                let whole = |place: f64| (place * 1000.0).round() / 1000.0;
                door.at = vec2(whole(carried.at.x), whole(carried.at.y));
            }
        }
        Ok(())
    }

    /// The corners of a line that has this one.
    fn corners(&mut self, ring: usize, corner: usize) -> Result<&mut Vec<Vec2>> {
        let further = self.walls.iter_mut().map(|wall| &mut wall.corners);
        let mut rings = std::iter::once(&mut self.outline).chain(&mut self.obstacles).chain(further);
        let found = rings.nth(ring).filter(|corners| corner < corners.len());
        found.ok_or_else(|| PeopleError::new(format!("there is no corner {corner} of ring {ring}")))
    }

    /// Whether a line is a further wall that repeats its first corner.
    fn closed_wall(&self, ring: usize) -> bool {
        let place = ring.checked_sub(1 + self.obstacles.len());
        place.and_then(|place| self.walls.get(place)).is_some_and(RoomWall::is_closed)
    }

    /// Returns a line \[m\] behind each door, where people have left who are in the room now: [`Door::exit`]. Empty if
    /// the outline or an obstacle has no corners.
    pub fn exits(&self, people: impl Iterator<Item = Vec2> + Clone) -> Vec<[[f64; 2]; 2]> {
        let lines = self.lines().unwrap_or_default();
        let lines = self.doors.iter().filter_map(|door| door.exit(&lines, people.clone()));
        lines.map(|line| line.map(Into::into)).collect()
    }

    /// Returns the corners \[m\] of all its lines.
    pub fn every_corner(&self) -> impl Iterator<Item = &Vec2> {
        let further = self.walls.iter().map(|wall| &wall.corners);
        std::iter::once(&self.outline).chain(&self.obstacles).chain(further).flatten()
    }

    /// Returns its inside, and its walls without doors, of a material.
    ///
    /// # Errors
    /// Walls cross, or an obstacle is not inside. Further walls may cross.
    pub fn uncut(&self, material: &str) -> Result<(Region, Geometry)> {
        let inside = Region::polygon(&self.outline, &self.obstacles)
            .map_err(|error| PeopleError::new(format!("the room: {error} (the holes are obstacles)")))?;
        let mut geometry = walls(inside.rings(), material);
        for RoomWall { corners, .. } in &self.walls {
            let id = geometry.walls.len().to_string();
            geometry.walls.push(Wall { corners: checked(corners)?, ..wall(id, material) });
        }
        if self.walls.is_empty() {
            return Ok((inside, geometry));
        }
        Ok((Region::free_space(&self.outline, &geometry, &[])?.region, geometry))
    }

    /// Cuts the doors into walls that [`uncut`](Room::uncut) returned. Ids are places in the list.
    ///
    /// # Errors
    /// A door is not at a wall.
    pub fn with_doors(&self, uncut: Geometry) -> Result<Geometry> {
        let mut geometry = cut_doors_in_all(uncut, &self.doors)?;
        for (id, wall) in geometry.walls.iter_mut().enumerate() {
            wall.id = id.to_string();
        }
        Ok(geometry)
    }

    /// Returns the walls of a Trial that this room takes the place of. Walls that were there before keep Id and material,
    /// new ones are of a material.
    ///
    /// # Errors
    /// Two walls are of one, or of none that is there, a wall has fewer than two corners or corners at one place, or a
    /// door is not at a wall.
    pub fn replacing(&self, before: &Geometry, material: &str) -> Result<Geometry> {
        let known: Vec<&str> = before.walls.iter().map(|wall| &*wall.id).collect();
        let mut free = (0u64..).map(|number| number.to_string()).filter(|id| !known.contains(&&**id));
        let mut walls: Vec<Wall> = Vec::new();
        for RoomWall { corners, of } in &self.walls {
            let old = match of {
                Some(of) => {
                    let place = known.iter().position(|id| id == of);
                    let once = !walls.iter().any(|wall| wall.id == *of);
                    let old = place.filter(|_| once).map(|place| &before.walls[place]);
                    let wrong = || PeopleError::new(format!("wall {of:?}: it is not there, or there twice"));
                    Wall { corners: Vec::new(), ..old.ok_or_else(wrong)?.clone() }
                }
                None => wall(free.next().unwrap_or_default(), material),
            };
            walls.push(Wall { corners: checked(corners)?, ..old });
        }
        let ring = |corners: &&Vec<Vec2>| !corners.is_empty();
        for corners in std::iter::once(&self.outline).chain(&self.obstacles).filter(ring) {
            let closed: Vec<Vec2> = corners.iter().chain(corners.first()).copied().collect();
            let new = wall(free.next().unwrap_or_default(), material);
            walls.push(Wall { corners: checked(&closed)?, ..new });
        }
        cut_doors_in_all(Geometry { walls, ..before.clone() }, &self.doors)
    }
}

fn wall(id: String, material: &str) -> Wall {
    Wall::new(id, material, Vec::new())
}

/// The corners of a wall, if a Trial may have such.
fn checked(corners: &[Vec2]) -> Result<Vec<Vec2>> {
    require(corners.len() > 1, || "a wall has fewer than two corners".to_owned())?;
    match corners.windows(2).find(|side| side[0] == side[1]) {
        Some(side) => Err(PeopleError::new(format!(
            "a wall has two corners in a row at ({}, {}) m",
            side[0].x, side[0].y
        ))),
        _ => Ok(corners.to_vec()),
    }
}

/// A place on a side of a bounding rectangle that gets another length. Its ends are exact.
fn stretched(at: f64, [low, high]: [f64; 2], length: f64) -> f64 {
    if high > low { low + (at - low) / (high - low) * length } else { low }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lemons_core::plane::InPlane;

    fn corners<const N: usize>(of: [[f64; 2]; N]) -> Vec<Vec2> {
        of.map(Vec2::from).to_vec()
    }

    /// 4 m by 3 m, with an obstacle, and a door in the wall on the right, on the left and in the obstacle.
    fn room() -> Room {
        let gap = |x, y| Door::new(vec2(x, y), 0.5);
        Room {
            outline: corners([[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [0.0, 3.0]]),
            obstacles: vec![corners([[1.0, 1.0], [2.0, 1.0], [2.0, 2.0]])],
            walls: Vec::new(),
            doors: vec![gap(4.0, 0.75), gap(0.0, 1.5), gap(1.5, 1.0)],
        }
    }

    fn changed(edit: RoomEdit) -> Room {
        let mut room = room();
        room.change(edit).unwrap();
        room
    }

    #[test]
    fn doors_stay_on_walls_whose_corners_move() {
        let after = changed(RoomEdit::Move { ring: 0, corner: 2, to: vec2(6.0, 4.0) });
        assert_eq!(after.outline[2], vec2(6.0, 4.0));
        // A quarter of the way from (4, 0) to (6, 4).
        assert_eq!(after.doors[0], Door::new(vec2(4.5, 1.0), 0.5));
        assert_eq!(after.doors[1..], room().doors[1..]);
        let after = changed(RoomEdit::Move { ring: 1, corner: 0, to: vec2(1.0, 0.5) });
        assert_eq!(after.doors[2].at, vec2(1.5, 0.75));
        // Millimetres: a third of the way.
        let mut third = room();
        third.doors[0].at = vec2(4.0, 1.0);
        third.change(RoomEdit::Move { ring: 0, corner: 2, to: vec2(4.0, 3.1) }).unwrap();
        assert_eq!(third.doors[0].at, vec2(4.0, 1.033));
        // Back and forth, also over its neighbour.
        for to in corners([[4.0, 0.0], [9.0, 9.0]]) {
            let mut room = room();
            room.change(RoomEdit::Move { ring: 0, corner: 2, to }).unwrap();
            assert!(room.doors[0].at.is_finite());
        }
    }

    #[test]
    fn the_outline_is_stretched_with_its_doors() {
        let mut far = room();
        for corner in &mut far.outline {
            *corner += vec2(-1.0, 10.0);
        }
        far.doors = vec![Door::new(vec2(3.0, 10.75), 0.5)];
        far.change(RoomEdit::Stretch { width: 5.5, height: 6.0 }).unwrap();
        assert_eq!(far.outline, corners([[-1.0, 10.0], [4.5, 10.0], [4.5, 16.0], [-1.0, 16.0]]));
        assert_eq!(far.doors[0].at, vec2(4.5, 11.5));
        let mut flat = room();
        flat.outline = corners([[1.0, 0.0], [1.0, 3.0], [1.0, 1.0]]);
        flat.change(RoomEdit::Stretch { width: 5.0, height: 6.0 }).unwrap();
        assert_eq!(flat.outline, corners([[1.0, 0.0], [1.0, 6.0], [1.0, 2.0]]));
    }

    #[test]
    fn corners_and_obstacles_come_and_go() {
        let after = changed(RoomEdit::Insert { ring: 0, side: 3, at: vec2(-1.0, 2.0) });
        assert_eq!(after.outline[3..], corners([[0.0, 3.0], [-1.0, 2.0]]));
        assert_eq!(after.doors, room().doors);
        let after = changed(RoomEdit::Remove { ring: 0, corner: 0 });
        assert_eq!(after.outline, room().outline[1..]);
        let after = changed(RoomEdit::Clear { ring: 1 });
        assert_eq!((after.obstacles.len(), &after.doors[..]), (0, &room().doors[..2]));
        let refused = |edit| room().change(edit).unwrap_err().to_string();
        assert_eq!(refused(RoomEdit::Remove { ring: 0, corner: 4 }), "there is no corner 4 of ring 0");
        assert_eq!(refused(RoomEdit::Clear { ring: 2 }), "there is no corner 0 of ring 2");
        assert_eq!(refused(RoomEdit::Clear { ring: 0 }), "the outline or an obstacle has no corners");
    }

    #[test]
    fn exits_are_a_metre_beyond_the_doors() {
        let people = [vec2(0.5, 0.5), vec2(3.0, 2.5)];
        let mut room = room();
        let lines = room.exits(people.into_iter());
        // 2 m longer than the doors; of an obstacle, inside of it: nobody is there.
        let sorted = |mut line: [[f64; 2]; 2]| {
            line.sort_by(|a, b| a.partial_cmp(b).unwrap());
            line
        };
        let expected = [[[5.0, -0.5], [5.0, 2.0]], [[-1.0, 0.25], [-1.0, 2.75]], [[0.25, 2.0], [2.75, 2.0]]];
        assert_eq!(lines.into_iter().map(sorted).collect::<Vec<_>>(), expected);
        room.outline.clear();
        assert!(room.exits(people.into_iter()).is_empty());
    }

    /// A Trial's walls: an open one, and a closed one.
    fn opened() -> (Geometry, Room) {
        let open = corners([[0.0, 0.0], [5.0, 0.0], [5.0, 4.0]]);
        let closed = corners([[1.0, 1.0], [2.0, 1.0], [2.0, 2.0], [1.0, 1.0]]);
        let wall = |id: &str, corners| Wall::new(id, format!("material of {id}"), corners);
        let geometry = Geometry {
            dimensions: Some(vec2(5.0, 4.0)),
            walls: vec![wall("a", open.clone()), wall("0", closed.clone())],
            ..Geometry::default()
        };
        let further = |id: &str, corners| RoomWall { corners, of: Some(id.into()) };
        let walls = vec![further("a", open), further("0", closed)];
        (geometry, Room { outline: Vec::new(), obstacles: Vec::new(), walls, doors: Vec::new() })
    }

    #[test]
    fn the_walls_of_a_trial_are_changed_and_keep_ids_and_materials() {
        let (before, mut room) = opened();
        assert_eq!(room.replacing(&before, "new").unwrap(), before);
        room.change(RoomEdit::Move { ring: 1, corner: 2, to: vec2(5.5, 4.0) }).unwrap();
        // The first corner of a closed wall is its last one, too.
        room.change(RoomEdit::Move { ring: 2, corner: 3, to: vec2(0.5, 0.5) }).unwrap();
        room.change(RoomEdit::Insert { ring: 1, side: 0, at: vec2(2.0, -1.0) }).unwrap();
        room.walls.push(RoomWall { corners: corners([[3.0, 3.0], [4.0, 3.0]]), of: None });
        room.doors = vec![Door::new(vec2(3.5, 3.1), 0.4)];
        let after = room.replacing(&before, "new").unwrap();
        assert_eq!(after.dimensions, before.dimensions);
        let walls: Vec<_> = after.walls.iter().map(|wall| (&*wall.id, &*wall.material_id)).collect();
        let [a, b] = ["material of a", "material of 0"];
        assert_eq!(walls, [("a", a), ("0", b), ("1", "new"), ("2", "new")]);
        assert_eq!(after.walls[0].corners, corners([[0.0, 0.0], [2.0, -1.0], [5.0, 0.0], [5.5, 4.0]]));
        assert_eq!(after.walls[1].corners, corners([[0.5, 0.5], [2.0, 1.0], [2.0, 2.0], [0.5, 0.5]]));
        assert_eq!(after.walls[2].corners[0], vec2(3.0, 3.0));
        assert_eq!(after.walls[3].corners[1], vec2(4.0, 3.0));
        // Doors of open walls go along with them.
        room.change(RoomEdit::Move { ring: 3, corner: 1, to: vec2(5.0, 3.0) }).unwrap();
        assert_eq!(room.doors[0].at, vec2(4.0, 3.0));
        room.change(RoomEdit::Clear { ring: 3 }).unwrap();
        assert!(room.walls.len() == 2 && room.doors.is_empty());
        room.change(RoomEdit::Remove { ring: 2, corner: 0 }).unwrap();
        assert_eq!(room.walls[1].corners, corners([[2.0, 1.0], [2.0, 2.0]]));
        room.change(RoomEdit::Clear { ring: 2 }).unwrap();
        room.change(RoomEdit::Clear { ring: 1 }).unwrap();
        assert!(room.replacing(&before, "new").unwrap().walls.is_empty());
    }

    #[test]
    fn walls_that_no_trial_may_have_are_refused() {
        let (before, room) = opened();
        let refused = |walls: &[(&[Vec2], Option<&str>)]| {
            let further = |&(corners, of): &(&[Vec2], Option<&str>)| RoomWall {
                corners: corners.to_vec(),
                of: of.map(Into::into),
            };
            let room = Room { walls: walls.iter().map(further).collect(), ..room.clone() };
            room.replacing(&before, "new").unwrap_err().to_string()
        };
        let line = corners([[0.0, 0.0], [1.0, 0.0]]);
        assert_eq!(refused(&[(&line, Some("b"))]), "wall \"b\": it is not there, or there twice");
        let twice = [(&line[..], Some("a")), (&line[..], Some("a"))];
        assert_eq!(refused(&twice), "wall \"a\": it is not there, or there twice");
        assert_eq!(refused(&[(&line[..1], None)]), "a wall has fewer than two corners");
        let double = [line[0], line[1], line[1]];
        assert_eq!(refused(&[(&double, None)]), "a wall has two corners in a row at (1, 0) m");
    }

    #[test]
    fn people_stand_on_both_sides_of_an_open_wall_and_not_across_it() {
        let mut room = Room { doors: Vec::new(), obstacles: Vec::new(), ..room() };
        let (whole, _) = room.uncut("concrete").unwrap();
        room.walls.push(RoomWall { corners: corners([[2.0, 0.0], [2.0, 2.0]]), of: None });
        room.doors.push(Door::new(vec2(2.0, 1.0), 0.5));
        let (parted, uncut) = room.uncut("concrete").unwrap();
        let geometry = room.with_doors(uncut.clone()).unwrap();
        assert_eq!((whole.area(), parted.area()), (12.0, 12.0));
        assert_eq!((whole.depth(vec2(1.9, 1.5)), parted.depth(vec2(1.5, 1.5))), (1.5, 0.5));
        // The outline, and the wall in two pieces.
        assert_eq!(geometry.walls.len(), 3);
        let left = corners([[0.0, 0.0], [2.5, 0.0], [2.5, 3.0], [0.0, 3.0]]);
        let part = Region::free_space(&left, &uncut, &[]).unwrap().region;
        assert_eq!((part.area(), part.depth(vec2(1.5, 1.5))), (7.5, 0.5));
    }

    #[test]
    fn corners_on_each_other_keep_their_numbers() {
        let after = changed(RoomEdit::Move { ring: 0, corner: 3, to: vec2(0.0, 0.0) });
        assert_eq!(after.lines().unwrap()[0].len(), 5);
    }
}
