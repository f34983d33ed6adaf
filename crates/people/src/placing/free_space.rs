//! The free space that walls leave of a polygon: ground for people in a room with openings, in a part of a room, between obstacles.

use super::region::{Region, SMALLEST_AREA};
use crate::error::{NO_WALLS, Result, require};
use crate::is_closed;
use lemons_core::message::message;
use lemons_core::plane::overlay::{self, Contour, InsideRule, Polygons, difference, intersection};
use lemons_core::plane::{Bounds, Ring, Vec2};
use lemons_core::trial::{Geometry, Wall};

/// A closed wall that holds more than this part of a polygon is a room.
const MOST_OF_IT: f64 = 0.5;
/// A closed wall that shares less than this part of a polygon does so by rounding.
const ROUNDING: f64 = 1e-9;
/// \[m\] A wall this near to a side of the polygon is the side.
const BESIDE: f64 = 1e-9;

/// A polygon without what walls take of it.
#[derive(Debug, Clone)]
pub struct FreeSpace {
    /// Where people may stand.
    pub region: Region,
    /// Ids of the closed walls that it lies in.
    pub rooms: Vec<String>,
    /// Ids of the closed walls that were taken out of it.
    pub obstacles: Vec<String>,
    /// Ids of the open walls in it.
    pub walls: Vec<String>,
}

impl Region {
    /// Returns what walls leave of a simple polygon \[m\].
    ///
    /// - A closed wall that holds more than half of the polygon is a room: only what is in it is left.
    /// - Any other closed wall is an obstacle: what is in it is taken out.
    /// - Open walls, and closed ones that cross themselves, have ground on both sides. Nobody stands across one.
    /// - What is in `earlier` polygons is taken out, too.
    ///
    /// # Errors
    /// The polygon does not bound a region, or nothing is left of it.
    pub fn free_space(outer: &[Vec2], walls: &Geometry, earlier: &[Region]) -> Result<FreeSpace> {
        let whole = Region::polygon(outer, &[])?;
        let ground: Vec<Contour> = whole.rings().iter().map(contour).collect();
        let mut left: Polygons = vec![ground.clone()];
        let (mut rooms, mut obstacles, mut open) = (Vec::new(), Vec::new(), Vec::new());
        let Some(bounds) = whole.bounds() else {
            return Err(message!(NO_WALLS).into());
        };
        let near =
            |wall: &&Wall| Bounds::of(wall.corners.iter().copied()).is_some_and(|wall| bounds.meets(&wall));
        for wall in walls.walls.iter().filter(near) {
            let Some(ring) = enclosing(wall) else {
                open.push(wall);
                continue;
            };
            let ring = [contour(&ring)];
            let share = area(&intersection(&ground, &ring, InsideRule::EvenOdd)) / whole.area();
            if share > MOST_OF_IT {
                left = intersection(&left.concat(), &ring, InsideRule::EvenOdd);
                rooms.push(wall.id.clone());
            } else if share > ROUNDING {
                left = difference(&left.concat(), &ring, InsideRule::EvenOdd);
                obstacles.push(wall.id.clone());
            }
        }
        for ring in earlier.iter().flat_map(|region| region.rings()) {
            left = difference(&left.concat(), &[contour(ring)], InsideRule::EvenOdd);
        }
        let rings: Vec<Ring> = left.iter().flat_map(|polygon| rings(polygon)).collect();
        let left: f64 = rings.iter().map(Ring::signed_area).sum();
        require(left >= SMALLEST_AREA, || {
            let why = match &obstacles[..] {
                [] => "earlier regions cover it".to_owned(),
                [one] => format!("the closed wall {one} is an obstacle"),
                many => format!("the closed walls {} are obstacles", many.join(", ")),
            };
            format!(
                "no ground is left: {why} (a closed wall is a room where it holds more than half of the region)"
            )
        })?;
        let mut sides = Vec::new();
        let mut within = Vec::new();
        for wall in open {
            let before = sides.len();
            let all = wall.corners.windows(2).map(|side| (side[0], side[1]));
            sides.extend(all.filter(|&(a, b)| a != b && is_in(&bounds, &rings, a, b)));
            if sides.len() > before {
                within.push(wall.id.clone());
            }
        }
        Ok(FreeSpace { region: Region::left(rings, &sides, left), rooms, obstacles, walls: within })
    }
}

/// The ring of a closed wall that does not cross itself.
fn enclosing(wall: &Wall) -> Option<Ring> {
    let mut corners = wall.corners.clone();
    corners.dedup();
    Ring::through(corners).filter(|ring| is_closed(&wall.corners) && ring.is_simple())
}

/// Returns whether a side of a wall may be in the way of people: it is near, and does not lie along a side of the polygons.
fn is_in(bounds: &Bounds, rings: &[Ring], a: Vec2, b: Vec2) -> bool {
    let along =
        |ring: &Ring| [a, b, (a + b) * 0.5].iter().all(|point| ring.nearest(*point).distance <= BESIDE);
    Bounds::of([a, b]).is_some_and(|side| bounds.meets(&side)) && !rings.iter().any(along)
}

fn contour(ring: &Ring) -> Contour {
    let mut corners = overlay::contour(ring);
    if ring.signed_area() < 0.0 {
        corners.reverse();
    }
    corners
}

/// \[m²\]
fn area(polygons: &Polygons) -> f64 {
    polygons.iter().flat_map(|polygon| rings(polygon)).map(|ring| ring.signed_area()).sum()
}

/// The outer one counter-clockwise, its holes clockwise; without those that are rounding errors.
fn rings(polygon: &[Contour]) -> impl Iterator<Item = Ring> {
    let ring = |(place, contour): (usize, &Contour)| {
        let ring = overlay::ring(contour)?;
        let right = (ring.signed_area() > 0.0) == (place == 0);
        Some(if right { ring } else { ring.reversed() })
    };
    let rings: Vec<Ring> = polygon.iter().enumerate().filter_map(ring).collect();
    let whole = rings.first().is_some_and(|outer| outer.area() >= SMALLEST_AREA);
    rings.into_iter().filter(move |ring| whole && ring.area() >= SMALLEST_AREA)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::placing::{PlacingSettings, dense};
    use crate::shape::Shape;
    use lemons_core::plane::{Disk, rotation, vec2};
    use std::ops::ControlFlow;

    fn wall(id: &str, corners: &[(f64, f64)]) -> Wall {
        let corners = corners.iter().map(|&(x, y)| vec2(x, y)).collect();
        Wall::new(id, "concrete", corners)
    }

    fn square(id: &str, x: f64, y: f64, side: f64) -> Wall {
        wall(id, &[(x, y), (x + side, y), (x + side, y + side), (x, y + side), (x, y)])
    }

    fn part(outer: &[(f64, f64)], walls: Vec<Wall>) -> Result<FreeSpace> {
        let outer: Vec<Vec2> = outer.iter().map(|&(x, y)| vec2(x, y)).collect();
        Region::free_space(&outer, &Geometry { walls, ..Geometry::default() }, &[])
    }

    const BOX: [(f64, f64); 4] = [(0.0, 0.0), (8.0, 0.0), (8.0, 6.0), (0.0, 6.0)];

    #[test]
    fn rooms_bound_and_obstacles_are_taken_out() {
        // A room of 7.5 m by 7.5 m of which the polygon covers 7.5 m by 6 m, a pillar in it, one across its side, one
        // elsewhere.
        let walls = vec![
            square("room", 0.0, -0.5, 7.5),
            square("pillar", 2.0, 2.0, 1.0),
            square("niche", 4.0, 5.5, 1.0),
            square("far", 20.0, 0.0, 1.0),
        ];
        let part = part(&BOX, walls).unwrap();
        assert_eq!(
            (part.rooms, part.obstacles),
            (vec!["room".to_owned()], vec!["pillar".into(), "niche".into()])
        );
        let area = 7.5 * 6.0 - 1.0 - 0.5;
        assert!((part.region.area() - area).abs() < 1e-6, "{}", part.region.area());
        for (x, y, inside) in [(1.0, 1.0, true), (7.7, 1.0, false), (2.5, 2.5, false), (4.5, 5.7, false)] {
            assert_eq!(part.region.contains(vec2(x, y)), inside, "{x} {y}");
        }
        assert!((part.region.depth(vec2(1.5, 2.5)) - 0.5).abs() < 1e-6);
        // Evenly spread points are evenly spread over it.
        let points = (0..40_000).map(|k| (f64::from(k % 200) + 0.5, f64::from(k / 200) + 0.5));
        let right = points.filter(|(u, v)| part.region.point_at(u / 200.0, v / 200.0).x > 3.75).count();
        let expected = (0.5 * 7.5 * 6.0 - 0.5) / area;
        assert!((right as f64 / 4e4 - expected).abs() < 2e-3, "{right}");
    }

    #[test]
    fn an_obstacle_may_part_the_ground() {
        let block = wall("block", &[(3.0, -1.0), (4.0, -1.0), (4.0, 7.0), (3.0, 7.0), (3.0, -1.0)]);
        let part = part(&BOX, vec![block]).unwrap();
        assert!((part.region.area() - 42.0).abs() < 1e-6);
        assert_eq!(part.region.rings().len(), 2);
        assert_eq!(part.region.bounds().unwrap().high, vec2(8.0, 6.0));
        for (x, inside) in [(1.0, true), (3.5, false), (7.0, true)] {
            assert_eq!(part.region.contains(vec2(x, 3.0)), inside, "{x}");
        }
    }

    #[test]
    fn open_walls_have_ground_on_both_sides() {
        let walls = vec![
            wall("screen", &[(4.0, -1.0), (4.0, 3.0), (5.0, 3.0), (5.0, 3.0)]),
            // Along the polygon's side, with a door.
            wall("room", &[(8.0, 2.5), (8.0, 0.0), (0.0, 0.0), (0.0, 6.0), (8.0, 6.0), (8.0, 3.5)]),
        ];
        let part = part(&BOX, walls).unwrap();
        assert_eq!(part.walls, ["screen"]);
        let region = part.region;
        assert!((region.area() - 48.0).abs() < 1e-12);
        // Half a metre from the screen, and from its end.
        for (x, y) in [(3.5, 2.0), (4.5, 2.5), (5.3, 3.4)] {
            assert!(region.contains(vec2(x, y)) && (region.depth(vec2(x, y)) - 0.5).abs() < 1e-12, "{x} {y}");
        }
        assert!(
            region.parted(vec2(3.9, 1.0), vec2(4.1, 1.0)) && !region.parted(vec2(3.9, 3.1), vec2(4.1, 3.1))
        );
    }

    /// Lanes of 0.7 m: at random places most people would stand across their walls, and not get off them.
    #[test]
    fn people_fill_narrow_lanes() {
        let lanes = (1..11).map(|k| wall("lane", &[(0.7 * f64::from(k), -1.0), (0.7 * f64::from(k), 5.5)]));
        let region = part(&BOX, lanes.collect()).unwrap().region;
        let disk = |x: f64, radius: f64| Disk { radius, centre: vec2(0.0, x) };
        let person = Shape { disks: vec![disk(-0.16, 0.1), disk(0.0, 0.13), disk(0.16, 0.1)] };
        let people = vec![person; 150];
        let settings = PlacingSettings { seed: 7, ..PlacingSettings::default() };
        let packing = dense(&people, &region, &settings, &mut |_| ControlFlow::Continue(())).unwrap();
        assert!(packing.complete, "{} {}", packing.largest_overlap, packing.clear_density);
        for pose in &packing.poses {
            let turn = rotation(pose.orientation);
            let at: Vec<Vec2> = people[0].disks.iter().map(|d| pose.position + turn * d.centre).collect();
            let lane = |place: &Vec2| (place.x / 0.7).floor().min(10.0);
            assert!(at[0].y > 5.4 || at[2].y > 5.4 || lane(&at[0]) == lane(&at[2]), "{at:?}");
        }
    }

    #[test]
    fn earlier_ground_is_not_shared() {
        let first = Region::rectangle(vec2(6.0, -1.0), vec2(9.0, 9.0)).unwrap();
        let outer: Vec<Vec2> = BOX.iter().map(|&(x, y)| vec2(x, y)).collect();
        let open = Geometry::default();
        let free = Region::free_space(&outer, &open, &[first]).unwrap();
        assert!((free.region.area() - 36.0).abs() < 1e-6);
        let all = Region::rectangle(vec2(-1.0, -1.0), vec2(9.0, 9.0)).unwrap();
        let none = Region::free_space(&outer, &open, &[all]).unwrap_err();
        assert!(none.to_string().starts_with("no ground is left: earlier regions cover it"), "{none}");
        let none = part(&BOX, vec![square("a", -2.0, 0.0, 6.0), square("b", 4.0, 0.0, 6.0)]).unwrap_err();
        assert!(none.to_string().contains("the closed walls a, b are obstacles"), "{none}");
    }
}
