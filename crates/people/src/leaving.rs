//! Doors in the walls of a Geometry.xml, and the lines behind them where people have left.

use crate::doors::{Door, DoorError, gap, nearest_wall, pieces};
use lemons_core::plane::{Ring, Vec2};
use lemons_core::trial::{Geometry, Wall};

/// \[m\] From a door to the line behind it.
const BEHIND: f64 = 1.0;
/// \[m\] By how much the line is longer than its door is wide.
const LONGER: f64 = 2.0;
/// \[1/m\] A calculated end is given to one part in so many of a metre.
const GRAINS: f64 = 1e9;

/// Returns the closed walls, in their order; doors are cut into these.
pub fn closed_walls(geometry: &Geometry) -> Vec<Ring> {
    let closed = geometry.walls.iter().filter(|wall| is_closed(wall));
    closed.filter_map(|wall| Ring::through(wall.corners.clone())).collect()
}

fn is_closed(wall: &Wall) -> bool {
    wall.corners.len() > 3 && wall.corners.first() == wall.corners.last()
}

/// Cuts doors into closed walls, each into the nearest. Other walls stay as they are. The first piece of a wall keeps its
/// Id, the next ones get the lowest numbers that are no Id yet, and follow it.
///
/// # Errors
/// A door is far from all closed walls, has no positive width, or leaves nothing of its wall.
pub fn cut_doors(geometry: Geometry, doors: &[Door]) -> Result<Geometry, DoorError> {
    let rings = closed_walls(&geometry);
    let gaps = doors.iter().enumerate().map(|(number, door)| gap(&rings, number, *door));
    let gaps = gaps.collect::<Result<Vec<_>, _>>()?;
    let known: Vec<String> = geometry.walls.iter().map(|wall| wall.id.clone()).collect();
    let mut free = (0u64..).map(|number| number.to_string()).filter(|id| !known.contains(id));
    let (mut walls, mut ring) = (Vec::new(), 0);
    for wall in geometry.walls {
        if !is_closed(&wall) {
            walls.push(wall);
            continue;
        }
        let own: Vec<_> = gaps.iter().filter(|gap| gap.ring == ring).collect();
        ring += 1;
        if own.is_empty() {
            walls.push(wall);
            continue;
        }
        for (place, corners) in pieces(&rings[ring - 1], &own).into_iter().enumerate() {
            let id = if place == 0 { Some(wall.id.clone()) } else { free.next() };
            let material_id = wall.material_id.clone();
            walls.push(Wall { id: id.unwrap_or_default(), material_id, corners });
        }
    }
    Ok(Geometry { walls, ..geometry })
}

impl Door {
    /// Returns the closed wall that [`cut_doors`] cuts it into; `None` without any.
    pub fn wall<'a>(&self, geometry: &'a Geometry) -> Option<&'a Wall> {
        let (place, _) = nearest_wall(&closed_walls(geometry), self.at)?;
        geometry.walls.iter().filter(|wall| is_closed(wall)).nth(place)
    }

    /// Returns the line \[m\] that people cross when they have left by this door of closed walls: parallel to the wall,
    /// 1 m behind it, and 2 m longer than the door is wide. Behind is the side of the wall where fewer of the `people`
    /// are \[m\]. `None` without rings.
    pub fn exit(&self, rings: &[Ring], people: impl Iterator<Item = Vec2>) -> Option<[Vec2; 2]> {
        let (ring, foot) = nearest_wall(rings, self.at)?;
        let ring = &rings[ring];
        let (from, to) = ring.sides().nth(foot.side)?;
        let along = (to - from) * (1.0 / (to - from).norm());
        let mut balance = 0i64;
        people.for_each(|place| balance += if ring.contains(place) { 1 } else { -1 });
        // The outside of a counter-clockwise ring is to the right of its sides.
        let right = -along.perp();
        let out = if (balance >= 0) == (ring.signed_area() > 0.0) { right } else { -right };
        let middle = foot.place + out * BEHIND;
        let half = along * (0.5 * (self.width + LONGER));
        // The sum turns −0 into 0.
        let whole = |x: f64| libm::round(x * GRAINS) / GRAINS + 0.0;
        Some([middle - half, middle + half].map(|end| Vec2 { x: whole(end.x), y: whole(end.y) }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{walls, with_doors};
    use lemons_core::plane::{Bounds, vec2};

    fn box_of(x: f64, y: f64) -> Ring {
        Ring::around(Bounds { low: Vec2::ZERO, high: vec2(x, y) })
    }

    fn door(x: f64, y: f64, width: f64) -> Door {
        Door { at: vec2(x, y), width }
    }

    #[test]
    fn a_box_gets_the_doors_that_the_lab_cuts() {
        let rings = [box_of(8.0, 6.0), Ring::around(Bounds { low: vec2(2.0, 2.0), high: vec2(3.0, 3.0) })];
        for doors in [vec![], vec![door(8.0, 3.0, 1.0)], vec![door(8.0, 3.0, 1.0), door(0.0, 2.0, 0.9)]] {
            let geometry = walls(&rings[..1], "concrete");
            let expected = with_doors(geometry.clone(), &rings[..1], &doors).unwrap();
            assert_eq!(cut_doors(geometry, &doors).unwrap(), expected);
        }
    }

    #[test]
    fn walls_keep_their_ids_and_materials() {
        let mut geometry = walls(&[box_of(8.0, 6.0)], "concrete");
        geometry.walls[0].id = "room".into();
        let open = |id: &str| Wall {
            id: id.into(),
            material_id: "wood".into(),
            corners: vec![Vec2::ZERO, vec2(8.0, 3.0)],
        };
        geometry.walls.insert(0, open("0"));
        geometry.walls.push(open("1"));
        let cut = cut_doors(geometry.clone(), &[door(8.1, 3.0, 1.0), door(4.0, 0.0, 2.0)]).unwrap();
        let ids: Vec<&str> = cut.walls.iter().map(|wall| &*wall.id).collect();
        assert_eq!(ids, ["0", "room", "2", "1"]);
        assert!(cut.walls[0] == geometry.walls[0] && cut.walls[3] == geometry.walls[2]);
        assert_eq!(door(8.1, 3.0, 1.0).wall(&geometry), Some(&geometry.walls[1]));
        assert_eq!(door(8.1, 3.0, 1.0).wall(&walls(&[], "")), None);
        assert!(cut.walls[1..3].iter().all(|wall| wall.material_id == "concrete"));
        let length =
            |wall: &Wall| wall.corners.windows(2).map(|side| (side[1] - side[0]).norm()).sum::<f64>();
        assert!((cut.walls[1..3].iter().map(length).sum::<f64>() - 25.0).abs() < 1e-9);
        let far = cut_doors(geometry, &[door(20.0, 3.0, 1.0)]).unwrap_err();
        assert!(
            far.to_string().contains("door 0 at (20, 3) m is 12.00 m from the nearest closed wall"),
            "{far}"
        );
    }

    #[test]
    fn the_exit_is_behind_the_door_on_the_side_of_fewer_people() {
        let inside = [vec2(4.0, 3.0), vec2(5.0, 3.0), vec2(12.0, 3.0)];
        let exit = |ring: Ring, door: Door, people: &[Vec2]| {
            let [a, b] = door.exit(&[ring], people.iter().copied()).unwrap();
            if (a.x, a.y) <= (b.x, b.y) { [a, b] } else { [b, a] }
        };
        for ring in [box_of(8.0, 6.0), box_of(8.0, 6.0).reversed()] {
            let right = door(8.0, 3.0, 1.0);
            assert_eq!(exit(ring.clone(), right, &inside), [vec2(9.0, 1.5), vec2(9.0, 4.5)]);
            assert_eq!(exit(ring.clone(), right, &inside[2..]), [vec2(7.0, 1.5), vec2(7.0, 4.5)]);
            // Beside the wall: the gap is at the wall's nearest point.
            assert_eq!(exit(ring, door(2.0, -0.3, 2.0), &inside), [vec2(0.0, -1.0), vec2(4.0, -1.0)]);
        }
        let slanted = Ring::through(vec![Vec2::ZERO, vec2(3.0, 4.0), vec2(-4.0, 3.0)]).unwrap();
        let [a, b] = exit(slanted, door(1.5, 2.0, 3.0), &[vec2(-0.5, 2.5)]);
        // The outward normal of the first side is (4, −3)/5.
        let middle = vec2(1.5 + 0.8, 2.0 - 0.6);
        assert!(
            ((a + b) * 0.5 - middle).norm() < 1e-8 && ((b - a) - vec2(3.0, 4.0)).norm() < 1e-8,
            "{a:?} {b:?}"
        );
        assert_eq!(door(0.0, 0.0, 1.0).exit(&[], std::iter::empty()), None);
    }
}
