//! Doors: gaps in closed walls where people can pass, and the lines behind them where people have left.

use crate::error::{PeopleError, Result, require};
use lemons_core::plane::{Foot, Ring, Vec2};
use lemons_core::trial::{Geometry, Wall};
use serde::{Deserialize, Serialize};

/// \[m\] A door further from all walls is a mistake.
const FARTHEST: f64 = 1.0;
/// \[m\] Shorter pieces between doors are rounding errors.
const SHORTEST: f64 = 1e-6;
/// \[m\] From a door to the line behind it.
const BEHIND: f64 = 1.0;
/// \[m\] By how much the line is longer than its door is wide.
const LONGER: f64 = 2.0;
/// \[1/m\] A calculated end is given to one part in so many of a metre.
const GRAINS: f64 = 1e9;

/// A gap in the wall that is nearest to a point. It may go round a corner.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Door {
    /// \[m\] The wall's point that is nearest to this one is the middle of the gap.
    pub at: Vec2,
    /// \[m\] Width, along the wall.
    pub width: f64,
}

/// A gap along a ring: from and to \[m\] from its first corner, going round.
struct Gap {
    ring: usize,
    from: f64,
    to: f64,
}

/// Returns the closed walls, in their order; doors are cut into these.
pub fn closed_walls(geometry: &Geometry) -> Vec<Ring> {
    let closed = geometry.walls.iter().filter(|wall| is_closed(wall));
    closed.filter_map(|wall| Ring::through(wall.corners.clone())).collect()
}

pub(crate) fn is_closed(wall: &Wall) -> bool {
    wall.corners.len() > 3 && wall.corners.first() == wall.corners.last()
}

/// Cuts doors into closed walls, each into the nearest. Other walls stay as they are. The first piece of a wall keeps its
/// Id, the next ones get the lowest numbers that are no Id yet, and follow it.
///
/// # Errors
/// A door is far from all closed walls, has no positive width, or leaves nothing of its wall.
pub fn cut_doors(geometry: Geometry, doors: &[Door]) -> Result<Geometry> {
    let rings = closed_walls(&geometry);
    let gaps = doors.iter().enumerate().map(|(number, door)| gap(&rings, number, *door));
    let gaps = gaps.collect::<Result<Vec<_>>>()?;
    let known: Vec<String> = geometry.walls.iter().map(|wall| wall.id.clone()).collect();
    let mut free = (0u64..).map(|number| number.to_string()).filter(|id| !known.contains(id));
    let (mut walls, mut closed) = (Vec::new(), 0..);
    for wall in geometry.walls {
        let ring = if is_closed(&wall) { closed.next() } else { None };
        let own: Vec<_> = gaps.iter().filter(|gap| Some(gap.ring) == ring).collect();
        if own.is_empty() {
            walls.push(wall);
            continue;
        }
        for (place, corners) in pieces(&rings[own[0].ring], &own).into_iter().enumerate() {
            let id = if place == 0 { Some(wall.id.clone()) } else { free.next() };
            let material_id = wall.material_id.clone();
            walls.push(Wall { id: id.unwrap_or_default(), material_id, corners });
        }
    }
    Ok(Geometry { walls, ..geometry })
}

/// The door's place along the ring whose wall is nearest.
fn gap(rings: &[Ring], number: usize, door: Door) -> Result<Gap> {
    let Door { at: at @ Vec2 { x, y }, width } = door;
    require(width > 0.0 && width.is_finite(), || {
        format!("door {number}: width = {width} m: must be positive and finite")
    })?;
    let on = nearest_wall(rings, at);
    let distance = on.map_or(f64::INFINITY, |(_, foot)| foot.distance);
    // A place that is not a number is infinitely far.
    let Some((ring, foot)) = on.filter(|_| distance <= FARTHEST) else {
        return Err(PeopleError::new(format!(
            "door {number} at ({x}, {y}) m is {distance:.2} m from the nearest closed wall; at most {FARTHEST} m is allowed"
        )));
    };
    require(width < length(&rings[ring]), || {
        format!("door {number}: there is no wall left beside its {width} m")
    })?;
    let middle = place(&rings[ring], foot);
    Ok(Gap { ring, from: middle - 0.5 * width, to: middle + 0.5 * width })
}

/// Returns the ring that is nearest to a point \[m\], and where on it; `None` without rings.
pub fn nearest_wall(rings: &[Ring], at: Vec2) -> Option<(usize, Foot)> {
    let feet = rings.iter().map(|ring| ring.nearest(at)).enumerate();
    feet.min_by(|a, b| a.1.distance.total_cmp(&b.1.distance))
}

impl Door {
    /// Returns the way \[m\] along the wall from one end of the gap to the other: corners of the ring lie between them
    /// where it goes round them. At most it goes once round. Empty without rings.
    pub fn course(&self, rings: &[Ring]) -> Vec<Vec2> {
        let Some((ring, foot)) = nearest_wall(rings, self.at) else { return Vec::new() };
        let ring = &rings[ring];
        let width = self.width.max(0.0).min(length(ring));
        piece(ring, place(ring, foot) - 0.5 * width, 0.0, width)
    }

    /// Returns the door after corners of its wall were moved: at the same share of the same side. Where its wall is as it
    /// was or has other corners, so is the door.
    #[must_use]
    pub fn carried(self, before: &[Ring], after: &[Ring]) -> Door {
        let Some((ring, Foot { side, along, .. })) = nearest_wall(before, self.at) else { return self };
        let (old, Some(new)) = (&before[ring], after.get(ring)) else { return self };
        if new == old || new.closed().len() != old.closed().len() {
            return self;
        }
        let ends = |ring: &Ring| [ring.closed()[side], ring.closed()[side + 1]];
        let ([from, to], [start, end]) = (ends(old), ends(new));
        let long = (to - from).norm();
        let share = if long > 0.0 { along / long } else { 0.0 };
        Door { at: start + (end - start) * share, ..self }
    }

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

/// \[m\] From the ring's first corner, going round.
fn place(ring: &Ring, foot: Foot) -> f64 {
    ring.sides().take(foot.side).map(|(start, end)| (end - start).norm()).sum::<f64>() + foot.along
}

fn length(ring: &Ring) -> f64 {
    ring.sides().map(|(start, end)| (end - start).norm()).sum()
}

/// The pieces of a ring between gaps.
fn pieces(ring: &Ring, gaps: &[&Gap]) -> Vec<Vec<Vec2>> {
    let round = length(ring);
    // From the first gap's end on, once round: no piece goes over the beginning.
    let origin = gaps[0].to;
    let mut closed: Vec<(f64, f64)> = gaps
        .iter()
        .map(|gap| ((gap.from - origin).rem_euclid(round), gap.to - gap.from))
        .flat_map(|(from, width)| [(from, from + width), (0.0, from + width - round)])
        .filter(|(from, to)| from < to)
        .collect();
    closed.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut pieces = Vec::new();
    let mut from = 0.0;
    for (start, end) in closed {
        if start - from > SHORTEST {
            pieces.push(piece(ring, origin, from, start));
        }
        from = f64::max(from, end);
    }
    if round - from > SHORTEST {
        pieces.push(piece(ring, origin, from, round));
    }
    pieces
}

/// The part of a ring between two places \[m\] after an origin, which is itself a place after the first corner.
fn piece(ring: &Ring, origin: f64, from: f64, to: f64) -> Vec<Vec2> {
    let round = length(ring);
    let mut corners = Vec::new();
    let mut along = 0.0;
    for (corner, next) in ring.sides() {
        let place = (along - origin).rem_euclid(round);
        if place > from && place < to {
            corners.push((place, corner));
        }
        along += (next - corner).norm();
    }
    corners.sort_by(|a, b| a.0.total_cmp(&b.0));
    let ends = [from, to].map(|place| point_at(ring, (origin + place).rem_euclid(round)));
    std::iter::once(ends[0]).chain(corners.into_iter().map(|(_, corner)| corner)).chain([ends[1]]).collect()
}

/// The point at a place \[m\] after the first corner.
fn point_at(ring: &Ring, place: f64) -> Vec2 {
    let mut left = place;
    for (start, end) in ring.sides() {
        let side = (end - start).norm();
        if left <= side && side > 0.0 {
            return start + (end - start) * (left / side);
        }
        left -= side;
    }
    ring.corners()[0]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::walls;
    use lemons_core::plane::{Bounds, vec2};

    fn box_of(low: Vec2, high: Vec2) -> Ring {
        Ring::around(Bounds { low, high })
    }

    fn room() -> Vec<Ring> {
        vec![box_of(Vec2::ZERO, vec2(4.0, 3.0)), box_of(vec2(1.0, 1.0), vec2(2.0, 2.0))]
    }

    fn door(x: f64, y: f64, width: f64) -> Door {
        Door { at: vec2(x, y), width }
    }

    fn cut(doors: &[Door]) -> Vec<Vec<Vec2>> {
        let geometry = cut_doors(walls(&room(), "concrete"), doors).unwrap();
        geometry.walls.into_iter().map(|wall| wall.corners).collect()
    }

    fn long(corners: &[Vec2]) -> f64 {
        corners.windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum()
    }

    fn near(found: &[Vec2], by_hand: &[Vec2]) -> bool {
        found.len() == by_hand.len() && found.iter().zip(by_hand).all(|(a, b)| (*a - *b).norm() < 1e-12)
    }

    #[test]
    fn doors_may_be_many_overlap_and_go_round_corners() {
        let found = cut(&[door(4.2, 1.5, 0.8)]);
        let by_hand = [(4.0, 1.9), (4.0, 3.0), (0.0, 3.0), (0.0, 0.0), (4.0, 0.0), (4.0, 1.1)];
        assert!(near(&found[0], &by_hand.map(|(x, y)| vec2(x, y))), "{found:?}");
        assert_eq!(found[1..], [room()[1].closed()]);
        let found =
            cut(&[door(2.0, 0.0, 1.0), door(2.6, 0.0, 1.0), door(0.0, 0.0, 1.0), door(2.0, 1.5, 0.2)]);
        assert_eq!(found.len(), 3, "{found:?}");
        let left: f64 = found.iter().map(|corners| long(corners)).sum();
        assert!((left - (14.0 - 1.6 - 1.0 + 4.0 - 0.2)).abs() < 1e-9, "{left}");
        assert!(!found.iter().flatten().any(|point| point.norm() < 0.49));
        // Edge to edge along the lower wall, with places and widths whose sums are rounded: one door.
        for k in 0..200 {
            let (from, first, second) = (0.9 + 0.003 * f64::from(k), 0.31 + 0.001 * f64::from(k), 0.47);
            let beside = |from: f64, width: f64| door(from + 0.5 * width, -0.1, width);
            let found = cut(&[beside(from, first), beside(from + first, second)]);
            assert_eq!(found.len(), 2, "{k}: {found:?}");
            assert!((long(&found[0]) - (14.0 - first - second)).abs() < 1e-9);
        }
    }

    #[test]
    fn the_course_of_a_door_is_what_it_takes_of_the_wall() {
        let course = |x, y, width| door(x, y, width).course(&room());
        assert!(near(&course(4.2, 1.5, 0.8), &[vec2(4.0, 1.1), vec2(4.0, 1.9)]));
        assert!(near(&course(1.5, 1.2, 0.4), &[vec2(1.3, 1.0), vec2(1.7, 1.0)]));
        // Round a corner, also the one where the ring begins.
        assert!(near(&course(3.9, 0.0, 1.0), &[vec2(3.4, 0.0), vec2(4.0, 0.0), vec2(4.0, 0.4)]));
        assert!(near(&course(0.0, 0.1, 1.0), &[vec2(0.0, 0.6), Vec2::ZERO, vec2(0.4, 0.0)]));
        // Wider than can be; far away.
        assert!((long(&course(2.0, 0.0, 99.0)) - 14.0).abs() < 1e-12);
        assert!(near(&course(9.0, 1.5, 1.0), &[vec2(4.0, 1.0), vec2(4.0, 2.0)]));
        assert!(door(0.0, 0.0, 1.0).course(&[]).is_empty());
        let point = Ring::through(vec![vec2(1.0, 1.0); 3]).unwrap();
        let nothing = door(0.0, 0.0, 1.0).course(&[point]);
        assert!(nothing.iter().all(|end| *end == vec2(1.0, 1.0)), "{nothing:?}");
    }

    #[test]
    fn a_door_goes_along_with_its_wall() {
        let (outer, inner) = (door(4.1, 0.75, 0.8), door(1.5, 1.0, 0.2));
        let moved = [box_of(Vec2::ZERO, vec2(6.0, 5.0)), room().remove(1)];
        // A quarter of the way up, as before.
        assert_eq!(outer.carried(&room(), &moved), door(6.0, 1.25, 0.8));
        assert_eq!(inner.carried(&room(), &moved), inner);
        let fewer = Ring::through(vec![Vec2::ZERO, vec2(4.0, 0.0), vec2(4.0, 3.0)]).unwrap();
        for after in [&room()[..], &[], &[fewer]] {
            assert_eq!(outer.carried(&room(), after), outer);
        }
    }

    #[test]
    fn impossible_doors_are_refused() {
        for (door, said) in [
            (door(9.0, 9.0, 1.0), "door 0 at (9, 9) m is 7.81 m from the nearest closed wall"),
            (door(f64::NAN, 0.0, 1.0), "door 0"),
            (door(4.0, 1.0, -1.0), "must be positive"),
            (door(1.5, 1.0, 4.0), "no wall left"),
        ] {
            let refused = cut_doors(walls(&room(), "concrete"), &[door]).unwrap_err().to_string();
            assert!(refused.contains(said), "{refused}");
        }
    }

    #[test]
    fn walls_keep_their_ids_and_materials() {
        let mut geometry = walls(&[box_of(Vec2::ZERO, vec2(8.0, 6.0))], "concrete");
        geometry.walls[0].id = "room".into();
        for (place, id) in [(0, "0"), (2, "1")] {
            let corners = vec![Vec2::ZERO, vec2(8.0, 3.0)];
            geometry.walls.insert(place, Wall { id: id.into(), material_id: "wood".into(), corners });
        }
        let right = door(8.1, 3.0, 1.0);
        let cut = cut_doors(geometry.clone(), &[right, door(4.0, 0.0, 2.0)]).unwrap();
        let ids: Vec<&str> = cut.walls.iter().map(|wall| &*wall.id).collect();
        assert_eq!(ids, ["0", "room", "2", "1"]);
        assert!(cut.walls[0] == geometry.walls[0] && cut.walls[3] == geometry.walls[2]);
        assert!(cut.walls[1..3].iter().all(|wall| wall.material_id == "concrete"));
        let left: f64 = cut.walls[1..3].iter().map(|wall| long(&wall.corners)).sum();
        assert!((left - 25.0).abs() < 1e-9);
        assert_eq!(right.wall(&geometry), Some(&geometry.walls[1]));
        assert_eq!(right.wall(&walls(&[], "")), None);
    }

    #[test]
    fn the_exit_is_behind_the_door_on_the_side_of_fewer_people() {
        let inside = [vec2(4.0, 3.0), vec2(5.0, 3.0), vec2(12.0, 3.0)];
        let exit = |ring: Ring, door: Door, people: &[Vec2]| {
            let [a, b] = door.exit(&[ring], people.iter().copied()).unwrap();
            if (a.x, a.y) <= (b.x, b.y) { [a, b] } else { [b, a] }
        };
        let ring = box_of(Vec2::ZERO, vec2(8.0, 6.0));
        for ring in [ring.clone(), ring.reversed()] {
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
        let off = [(a + b) * 0.5 - middle, (b - a) - vec2(3.0, 4.0)];
        assert!(off.iter().all(|off| off.norm() < 1e-8), "{a:?} {b:?}");
        assert_eq!(door(0.0, 0.0, 1.0).exit(&[], std::iter::empty()), None);
    }
}
