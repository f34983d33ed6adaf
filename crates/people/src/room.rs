//! A room as it is drawn: its corners and doors, changes that leave doors on their walls, and the walls in the end.

use crate::error::{PeopleError, Result};
use crate::placing::Region;
use crate::{Door, cut_doors, nearest_wall, walls};
use lemons_core::plane::{Bounds, Ring, Vec2, vec2};
use lemons_core::trial::Geometry;
use serde::{Deserialize, Serialize};

/// A room. Outlines may go round in either direction.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Room {
    /// \[m\] Corners, the first one not repeated.
    pub outline: Vec<Vec2>,
    /// \[m\] The corners of each.
    pub obstacles: Vec<Vec<Vec2>>,
    /// Gaps in the walls.
    pub doors: Vec<Door>,
}

/// A change of a room. Ring 0 is its outline, obstacles follow; side 0 begins at corner 0.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(tag = "do", rename_all = "kebab-case", deny_unknown_fields)]
#[allow(missing_docs)] // places in m
pub enum Edit {
    /// A corner goes elsewhere.
    Move { ring: usize, corner: usize, to: Vec2 },
    /// A side gets a corner.
    Insert { ring: usize, side: usize, at: Vec2 },
    /// A corner goes away.
    Remove { ring: usize, corner: usize },
    /// An obstacle goes away, with its doors.
    Clear { ring: usize },
    /// The outline gets this width and height \[m\]; its left and low ends stay.
    Stretch { width: f64, height: f64 },
}

impl Room {
    /// Returns the outline, then the obstacles. Each has as many sides as corners, also if two of them lie on each other.
    ///
    /// # Errors
    /// One has no corners.
    pub fn rings(&self) -> Result<Vec<Ring>> {
        let ring = |corners: &Vec<Vec2>| {
            Ring::through(corners.iter().chain(corners.first()).copied().collect())
                .ok_or_else(|| PeopleError::new("the outline or an obstacle has no corners"))
        };
        std::iter::once(&self.outline).chain(&self.obstacles).map(ring).collect()
    }

    /// Changes it. Where corners of a wall go elsewhere, so do its doors: to the same share of the same side, to the
    /// millimetre.
    ///
    /// # Errors
    /// There is no such corner, or none would be left. The room is then of no use.
    pub fn change(&mut self, edit: Edit) -> Result<()> {
        let before = self.rings()?;
        match edit {
            Edit::Move { ring, corner, to } => self.corners(ring, corner)?[corner] = to,
            Edit::Insert { ring, side, at } => self.corners(ring, side)?.insert(side + 1, at),
            Edit::Remove { ring, corner } => drop(self.corners(ring, corner)?.remove(corner)),
            Edit::Clear { ring } => {
                self.corners(ring, 0)?.clear();
                self.obstacles.retain(|obstacle| !obstacle.is_empty());
                let on = |door: &Door| nearest_wall(&before, door.at).is_some_and(|(on, _)| on == ring);
                self.doors.retain(|door| !on(door));
                // Others have another number now, but are where they were.
                return self.rings().map(|_| ());
            }
            Edit::Stretch { width, height } => {
                let Bounds { low, high } = before[0].bounds();
                for corner in &mut self.outline {
                    corner.x = stretched(corner.x, [low.x, high.x], width);
                    corner.y = stretched(corner.y, [low.y, high.y], height);
                }
            }
        }
        let after = self.rings()?;
        for door in &mut self.doors {
            let carried = door.carried(&before, &after);
            if carried != *door {
                let whole = |place: f64| (place * 1000.0).round() / 1000.0;
                door.at = vec2(whole(carried.at.x), whole(carried.at.y));
            }
        }
        Ok(())
    }

    /// The corners of a ring that has this one.
    fn corners(&mut self, ring: usize, corner: usize) -> Result<&mut Vec<Vec2>> {
        let mut rings = std::iter::once(&mut self.outline).chain(&mut self.obstacles);
        let found = rings.nth(ring).filter(|corners| corner < corners.len());
        found.ok_or_else(|| PeopleError::new(format!("there is no corner {corner} of ring {ring}")))
    }

    /// Returns a line \[m\] behind each door, where people have left who are in the room now: [`Door::exit`]. Empty if
    /// the outline or an obstacle has no corners.
    pub fn exits(&self, people: impl Iterator<Item = Vec2> + Clone) -> Vec<[[f64; 2]; 2]> {
        let rings = self.rings().unwrap_or_default();
        let lines = self.doors.iter().filter_map(|door| door.exit(&rings, people.clone()));
        lines.map(|line| line.map(Into::into)).collect()
    }

    /// Returns its inside, and its walls with doors, of a material.
    ///
    /// # Errors
    /// Walls cross, an obstacle is not inside, or a door is not at a wall.
    pub fn built(&self, material: &str) -> Result<(Region, Geometry)> {
        let inside = Region::polygon(&self.outline, &self.obstacles)
            .map_err(|error| PeopleError::new(format!("the room: {error} (the holes are obstacles)")))?;
        let mut geometry = cut_doors(walls(inside.rings(), material), &self.doors)?;
        for (id, wall) in geometry.walls.iter_mut().enumerate() {
            wall.id = id.to_string();
        }
        Ok((inside, geometry))
    }
}

/// A place on a side of a bounding rectangle that gets another length. Its ends are exact.
fn stretched(at: f64, [low, high]: [f64; 2], length: f64) -> f64 {
    if high > low { low + (at - low) / (high - low) * length } else { low }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn corners<const N: usize>(of: [[f64; 2]; N]) -> Vec<Vec2> {
        of.map(Vec2::from).to_vec()
    }

    /// 4 m by 3 m, with an obstacle, and a door in the wall on the right, on the left and in the obstacle.
    fn room() -> Room {
        let gap = |x, y| Door { at: vec2(x, y), width: 0.5 };
        Room {
            outline: corners([[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [0.0, 3.0]]),
            obstacles: vec![corners([[1.0, 1.0], [2.0, 1.0], [2.0, 2.0]])],
            doors: vec![gap(4.0, 0.75), gap(0.0, 1.5), gap(1.5, 1.0)],
        }
    }

    fn changed(edit: Edit) -> Room {
        let mut room = room();
        room.change(edit).unwrap();
        room
    }

    #[test]
    fn doors_stay_on_walls_whose_corners_move() {
        let after = changed(Edit::Move { ring: 0, corner: 2, to: vec2(6.0, 4.0) });
        assert_eq!(after.outline[2], vec2(6.0, 4.0));
        // A quarter of the way from (4, 0) to (6, 4).
        assert_eq!(after.doors[0], Door { at: vec2(4.5, 1.0), width: 0.5 });
        assert_eq!(after.doors[1..], room().doors[1..]);
        let after = changed(Edit::Move { ring: 1, corner: 0, to: vec2(1.0, 0.5) });
        assert_eq!(after.doors[2].at, vec2(1.5, 0.75));
        // Millimetres: a third of the way.
        let mut third = room();
        third.doors[0].at = vec2(4.0, 1.0);
        third.change(Edit::Move { ring: 0, corner: 2, to: vec2(4.0, 3.1) }).unwrap();
        assert_eq!(third.doors[0].at, vec2(4.0, 1.033));
        // Back and forth, also over its neighbour.
        for to in corners([[4.0, 0.0], [9.0, 9.0]]) {
            let mut room = room();
            room.change(Edit::Move { ring: 0, corner: 2, to }).unwrap();
            assert!(room.doors[0].at.is_finite());
        }
    }

    #[test]
    fn the_outline_is_stretched_with_its_doors() {
        let mut far = room();
        for corner in &mut far.outline {
            *corner += vec2(-1.0, 10.0);
        }
        far.doors = vec![Door { at: vec2(3.0, 10.75), width: 0.5 }];
        far.change(Edit::Stretch { width: 5.5, height: 6.0 }).unwrap();
        assert_eq!(far.outline, corners([[-1.0, 10.0], [4.5, 10.0], [4.5, 16.0], [-1.0, 16.0]]));
        assert_eq!(far.doors[0].at, vec2(4.5, 11.5));
        let mut flat = room();
        flat.outline = corners([[1.0, 0.0], [1.0, 3.0], [1.0, 1.0]]);
        flat.change(Edit::Stretch { width: 5.0, height: 6.0 }).unwrap();
        assert_eq!(flat.outline, corners([[1.0, 0.0], [1.0, 6.0], [1.0, 2.0]]));
    }

    #[test]
    fn corners_and_obstacles_come_and_go() {
        let after = changed(Edit::Insert { ring: 0, side: 3, at: vec2(-1.0, 2.0) });
        assert_eq!(after.outline[3..], corners([[0.0, 3.0], [-1.0, 2.0]]));
        assert_eq!(after.doors, room().doors);
        let after = changed(Edit::Remove { ring: 0, corner: 0 });
        assert_eq!(after.outline, room().outline[1..]);
        let after = changed(Edit::Clear { ring: 1 });
        assert_eq!((after.obstacles.len(), &after.doors[..]), (0, &room().doors[..2]));
        let refused = |edit| room().change(edit).unwrap_err().to_string();
        assert_eq!(refused(Edit::Remove { ring: 0, corner: 4 }), "there is no corner 4 of ring 0");
        assert_eq!(refused(Edit::Clear { ring: 2 }), "there is no corner 0 of ring 2");
        assert_eq!(refused(Edit::Clear { ring: 0 }), "the outline or an obstacle has no corners");
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

    #[test]
    fn corners_on_each_other_keep_their_numbers() {
        let after = changed(Edit::Move { ring: 0, corner: 3, to: vec2(0.0, 0.0) });
        assert_eq!(after.rings().unwrap()[0].sides().count(), 4);
    }
}
