//! Doors: gaps in walls where people can pass, and the lines behind them where people have left.

use crate::error::{PeopleError, Result, require};
use lemons_core::plane::{Foot, InPlane, Ring, Vec2, is_closed, nearest_on_line, vec2};
use lemons_core::trial::{Geometry, OpeningTimes, Wall};
use serde::{Deserialize, Serialize};

/// \[m\] A door further from all walls is a mistake.
const FARTHEST: f64 = 1.0;
/// \[s\] In so long everybody who came through a door has reached the line behind it.
const BEYOND: f64 = 30.0;
/// \[m\] Shorter pieces between doors are rounding errors.
const SHORTEST: f64 = 1e-6;
/// \[m\] From a door to the line behind it.
const BEHIND: f64 = 1.0;
/// \[m\] By how much the line is longer than its door is wide.
const LONGER: f64 = 2.0;
/// \[1/m\] A calculated end is given to one part in so many of a metre.
const GRAINS: f64 = 1e9;

/// A gap in the wall that is nearest to a point. It may go round a corner.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
#[serde(deny_unknown_fields)]
pub struct Door {
    /// \[m\] The wall's point that is nearest to this one is the middle of the gap.
    #[cfg_attr(feature = "typescript", ts(as = "[f64; 2]"))]
    pub at: Vec2,
    /// \[m\] Width, along the wall.
    pub width: f64,
    /// When it is open, if a wall closes it at other times; `None` if it is always open.
    #[cfg_attr(feature = "typescript", ts(as = "Option<Vec<[f64; 2]>>", optional))]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub open: Option<OpeningTimes>,
}

/// A gap along a wall: from and to \[m\] from its first corner, going round if it is closed.
struct Gap<'a> {
    line: usize,
    from: f64,
    to: f64,
    door: &'a Door,
}

/// Returns the closed walls, in their order; doors are cut into these.
pub fn closed_walls(geometry: &Geometry) -> Vec<Ring> {
    geometry.walls.iter().filter_map(|wall| Ring::of_closed(&wall.corners)).collect()
}

/// Cuts doors into closed walls, each into the nearest. Other walls stay as they are. The first piece of a wall keeps its
/// Id, the next ones get the lowest numbers that are no Id yet, and follow it, and so do the walls that close doors.
///
/// # Errors
/// A door is far from all closed walls, has no positive width, or leaves nothing of its wall.
pub fn cut_doors(geometry: Geometry, doors: &[Door]) -> Result<Geometry> {
    cut(geometry, doors, |wall| is_closed(&wall.corners), "closed wall")
}

/// Cuts doors as [`cut_doors`] does, also into open walls.
///
/// # Errors
/// As [`cut_doors`], of all walls.
pub fn cut_doors_in_all(geometry: Geometry, doors: &[Door]) -> Result<Geometry> {
    cut(geometry, doors, |_| true, "wall")
}

/// Cuts doors into the walls that `may` have them, which messages call `kind`.
fn cut(geometry: Geometry, doors: &[Door], may: fn(&Wall) -> bool, kind: &str) -> Result<Geometry> {
    let lines: Vec<Vec<Vec2>> =
        geometry.walls.iter().filter(|wall| may(wall)).map(|wall| wall.corners.clone()).collect();
    let gaps = doors.iter().enumerate().map(|(number, door)| gap(&lines, number, door, kind));
    let gaps = gaps.collect::<Result<Vec<_>>>()?;
    refuse_walls_in_gaps(&gaps, &lines)?;
    let known: Vec<String> = geometry.walls.iter().map(|wall| wall.id.clone()).collect();
    let mut free = (0u64..).map(|number| number.to_string()).filter(|id| !known.contains(id));
    let (mut walls, mut places) = (Vec::new(), 0..);
    for wall in geometry.walls {
        let line = if may(&wall) { places.next() } else { None };
        let own: Vec<_> = gaps.iter().filter(|gap| Some(gap.line) == line).collect();
        if own.is_empty() {
            walls.push(wall);
            continue;
        }
        for (place, corners) in pieces(&wall.corners, &own).into_iter().enumerate() {
            let id = if place == 0 { Some(wall.id.clone()) } else { free.next() };
            walls.push(Wall { id: id.unwrap_or_default(), corners, ..wall.clone() });
        }
        for Gap { door, .. } in own.iter().filter(|gap| gap.door.open.is_some()) {
            let (id, corners) = (free.next().unwrap_or_default(), door.course(&[&wall.corners]));
            walls.push(Wall { id, corners, open: door.open.clone(), ..wall.clone() });
        }
    }
    Ok(Geometry { walls, ..geometry })
}

/// A wall that closes a door must not stand in the gap of another one.
fn refuse_walls_in_gaps(gaps: &[Gap<'_>], lines: &[Vec<Vec2>]) -> Result<()> {
    for (k, a) in gaps.iter().enumerate() {
        for (j, b) in gaps.iter().enumerate().skip(k + 1) {
            // A closed wall goes round.
            let round = if is_closed(&lines[a.line]) { length(&lines[a.line]) } else { 0.0 };
            let meets = |by: f64| a.from < b.to + by - SHORTEST && b.from + by < a.to - SHORTEST;
            let timed = a.door.open.is_some() || b.door.open.is_some();
            require(!(timed && a.line == b.line && [-round, 0.0, round].into_iter().any(meets)), || {
                format!(
                    "doors {k} and {j} overlap, and one of them opens and closes: only doors that are always open may"
                )
            })?;
        }
    }
    Ok(())
}

/// The door's place along the line that is nearest.
fn gap<'a>(lines: &[Vec<Vec2>], number: usize, door: &'a Door, kind: &str) -> Result<Gap<'a>> {
    let &Door { at, width, .. } = door;
    require(width > 0.0 && width.is_finite(), || {
        format!("door {number}: width = {width} m: must be positive and finite")
    })?;
    let on = nearest_wall(lines, at);
    let distance = on.map_or(f64::INFINITY, |(_, foot)| foot.distance);
    // A place that is not a number is infinitely far.
    let Some((line, foot)) = on.filter(|_| distance <= FARTHEST) else {
        return Err(PeopleError::new(format!(
            "door {number} at ({}, {}) m is {distance:.2} m from the nearest {kind}; at most {FARTHEST} m is allowed",
            at.x, at.y
        )));
    };
    require(width < length(&lines[line]), || {
        format!("door {number}: there is no wall left beside its {width} m")
    })?;
    let middle = place(&lines[line], foot);
    Ok(Gap { line, from: middle - 0.5 * width, to: middle + 0.5 * width, door })
}

/// Returns the wall that is nearest to a point \[m\], and where on it; `None` without walls. The first corner of a closed
/// wall is repeated at its end.
pub fn nearest_wall<L: AsRef<[Vec2]>>(lines: &[L], at: Vec2) -> Option<(usize, Foot)> {
    let lines = lines.iter().map(AsRef::as_ref).enumerate().filter(|(_, line)| line.len() > 1);
    let feet = lines.map(|(number, line)| (number, nearest_on_line(line, at)));
    feet.min_by(|a, b| a.1.distance.total_cmp(&b.1.distance))
}

impl Door {
    /// Makes a door that is always open.
    pub fn new(at: Vec2, width: f64) -> Door {
        Door { at, width, open: None }
    }

    /// Makes a door of x, y and width \[m\] and the times \[s\] from and to which it is open; without the last time it does
    /// not close any more. `None` if they are not three numbers and such times.
    pub fn of_numbers(numbers: &[f64]) -> Option<Door> {
        let &[x, y, width, ref times @ ..] = numbers else { return None };
        let open = if times.is_empty() { None } else { Some(OpeningTimes::of_numbers(times).ok()?) };
        Some(Door { open, ..Door::new(vec2(x, y), width) })
    }

    /// Returns when people can leave behind it: when it is open, and a little longer for who has come through it; `None`:
    /// always.
    pub fn exit_times(&self) -> Option<OpeningTimes> {
        Some(self.open.as_ref()?.lengthened(BEYOND))
    }

    /// Returns the way \[m\] along the wall from one end of the gap to the other: corners of the wall lie between them
    /// where it goes round them. At most it goes once round, or from end to end. Empty without walls.
    pub fn course<L: AsRef<[Vec2]>>(&self, lines: &[L]) -> Vec<Vec2> {
        let Some((line, foot)) = nearest_wall(lines, self.at) else { return Vec::new() };
        let line = lines[line].as_ref();
        let width = self.width.max(0.0).min(length(line));
        let from = place(line, foot) - 0.5 * width;
        if is_closed(line) {
            piece(line, from, 0.0, width)
        } else {
            piece(line, 0.0, from.max(0.0), (from + width).min(length(line)))
        }
    }

    /// Returns the door after corners of its wall were moved: at the same share of the same side. Where its wall is as it
    /// was or has other corners, so is the door.
    #[must_use]
    pub fn carried<L: AsRef<[Vec2]>>(&self, before: &[L], after: &[L]) -> Door {
        let Some((line, Foot { side, along, .. })) = nearest_wall(before, self.at) else {
            return self.clone();
        };
        let (old, Some(new)) = (before[line].as_ref(), after.get(line).map(AsRef::as_ref)) else {
            return self.clone();
        };
        if new == old || new.len() != old.len() {
            return self.clone();
        }
        let ends = |line: &[Vec2]| [line[side], line[side + 1]];
        let ([from, to], [start, end]) = (ends(old), ends(new));
        let long = (to - from).norm();
        let share = if long > 0.0 { along / long } else { 0.0 };
        Door { at: start + (end - start) * share, ..self.clone() }
    }

    /// Returns the closed wall that [`cut_doors`] cuts it into; `None` without any.
    pub fn wall<'a>(&self, geometry: &'a Geometry) -> Option<&'a Wall> {
        let (place, _) = nearest_wall(&closed_walls(geometry), self.at)?;
        geometry.walls.iter().filter(|wall| is_closed(&wall.corners)).nth(place)
    }

    /// Returns the line \[m\] that people cross when they have left by this door: parallel to the wall, 1 m behind it, and
    /// 2 m longer than the door is wide. Behind is the side of the wall where fewer of the `people` are \[m\]. `None`
    /// without walls.
    pub fn exit<L: AsRef<[Vec2]>>(
        &self,
        lines: &[L],
        people: impl Iterator<Item = Vec2>,
    ) -> Option<[Vec2; 2]> {
        let (line, foot) = nearest_wall(lines, self.at)?;
        let line = lines[line].as_ref();
        let (from, to) = (*line.get(foot.side)?, *line.get(foot.side + 1)?);
        let along = (to - from) * (1.0 / (to - from).norm());
        let ring = Ring::of_closed(line);
        let is_left = |place: Vec2| match &ring {
            // The inside of a counter-clockwise ring is to the left of its sides.
            Some(ring) => ring.contains(place) == (ring.signed_area() > 0.0),
            None => along.left().dot(&(place - from)) > 0.0,
        };
        let mut left = 0i64;
        people.for_each(|place| left += if is_left(place) { 1 } else { -1 });
        // Of as many on both sides, those of a room are inside.
        let inside_left = ring.as_ref().is_none_or(|ring| ring.signed_area() > 0.0);
        let to_the_right = left > 0 || (left == 0 && inside_left);
        let out = if to_the_right { -along.left() } else { along.left() };
        let middle = foot.place + out * BEHIND;
        let half = along * (0.5 * (self.width + LONGER));
        // The sum turns −0 into 0.
        let whole = |x: f64| libm::round(x * GRAINS) / GRAINS + 0.0;
        Some([middle - half, middle + half].map(|end| vec2(whole(end.x), whole(end.y))))
    }
}

/// \[m\] From the line's first corner.
fn place(line: &[Vec2], foot: Foot) -> f64 {
    sides(line).take(foot.side).map(|(start, end)| (end - start).norm()).sum::<f64>() + foot.along
}

fn length(line: &[Vec2]) -> f64 {
    sides(line).map(|(start, end)| (end - start).norm()).sum()
}

fn sides(line: &[Vec2]) -> impl Iterator<Item = (Vec2, Vec2)> {
    line.windows(2).map(|side| (side[0], side[1]))
}

/// The pieces of a line between gaps.
fn pieces(line: &[Vec2], gaps: &[&Gap]) -> Vec<Vec<Vec2>> {
    let (long, round) = (length(line), is_closed(line));
    // From the first gap's end on, once round: no piece goes over the beginning.
    let origin = if round { gaps[0].to } else { 0.0 };
    let around = |gap: &&Gap| {
        let (from, width) = ((gap.from - origin).rem_euclid(long), gap.to - gap.from);
        [(from, from + width), (0.0, from + width - long)]
    };
    let along = |gap: &&Gap| [(gap.from, gap.to); 2];
    let mut closed: Vec<(f64, f64)> = gaps
        .iter()
        .flat_map(|gap| if round { around(gap) } else { along(gap) })
        .filter(|(from, to)| from < to)
        .collect();
    closed.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut pieces = Vec::new();
    let mut from = 0.0;
    for (start, end) in closed {
        if start - from > SHORTEST {
            pieces.push(piece(line, origin, from, start));
        }
        from = f64::max(from, end);
    }
    if long - from > SHORTEST {
        pieces.push(piece(line, origin, from, long));
    }
    pieces
}

/// The part of a line between two places \[m\] after an origin, which is itself a place after the first corner: 0 of an
/// open line.
fn piece(line: &[Vec2], origin: f64, from: f64, to: f64) -> Vec<Vec2> {
    let (long, round) = (length(line), is_closed(line));
    let turned = |place: f64| if round { place.rem_euclid(long) } else { place };
    let mut corners = Vec::new();
    let mut along = 0.0;
    for (corner, next) in sides(line) {
        let place = turned(along - origin);
        if place > from && place < to {
            corners.push((place, corner));
        }
        along += (next - corner).norm();
    }
    corners.sort_by(|a, b| a.0.total_cmp(&b.0));
    let ends = [from, to].map(|place| point_at(line, turned(origin + place)));
    std::iter::once(ends[0]).chain(corners.into_iter().map(|(_, corner)| corner)).chain([ends[1]]).collect()
}

/// The point at a place \[m\] after the first corner.
fn point_at(line: &[Vec2], place: f64) -> Vec2 {
    let (mut left, last) = (place, line[line.len() - 1]);
    // Not by sums, which are rounded.
    if !is_closed(line) && place >= length(line) {
        return last;
    }
    for (start, end) in sides(line) {
        let side = (end - start).norm();
        if left <= side && side > 0.0 {
            return start + (end - start) * (left / side);
        }
        left -= side;
    }
    last
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
        vec![box_of(Vec2::zeros(), vec2(4.0, 3.0)), box_of(vec2(1.0, 1.0), vec2(2.0, 2.0))]
    }

    fn door(x: f64, y: f64, width: f64) -> Door {
        Door::new(vec2(x, y), width)
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
    fn a_line_there_and_back_has_no_inside() {
        let (a, b, c) = (Vec2::zeros(), vec2(1.0, 0.0), vec2(0.0, 1.0));
        assert!(!is_closed(&[a, b, a]) && is_closed(&[a, b, c, a]) && !is_closed(&[a, b, c]));
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
        assert!(near(&course(0.0, 0.1, 1.0), &[vec2(0.0, 0.6), Vec2::zeros(), vec2(0.4, 0.0)]));
        // Wider than can be; far away.
        assert!((long(&course(2.0, 0.0, 99.0)) - 14.0).abs() < 1e-12);
        assert!(near(&course(9.0, 1.5, 1.0), &[vec2(4.0, 1.0), vec2(4.0, 2.0)]));
        assert!(door(0.0, 0.0, 1.0).course::<Ring>(&[]).is_empty());
        let point = Ring::through(vec![vec2(1.0, 1.0); 3]).unwrap();
        let nothing = door(0.0, 0.0, 1.0).course(&[point]);
        assert!(nothing.iter().all(|end| *end == vec2(1.0, 1.0)), "{nothing:?}");
    }

    #[test]
    fn open_walls_have_doors_too() {
        let corners = vec![vec2(0.0, 0.0), vec2(3.0, 0.0), vec2(3.0, 4.0)];
        let line = Wall::new("partition", "wood", corners.clone());
        let mut geometry = walls(&room(), "concrete");
        geometry.walls.insert(1, line);
        let cut = |doors: &[Door]| cut_doors_in_all(geometry.clone(), doors).unwrap().walls;
        // 1 m about (3, 2), and 2 m that would go 0.5 m beyond the end.
        let found = cut(&[door(3.1, 2.0, 1.0), door(3.0, 3.5, 2.0)]);
        let of = |id: &str| found.iter().find(|wall| wall.id == id).map(|wall| wall.corners.clone());
        assert!(near(&of("partition").unwrap(), &[corners[0], corners[1], vec2(3.0, 1.5)]));
        // What is between them is no piece: 2.5 m to 2.5 m. Nothing is left behind the second.
        assert_eq!(found.len(), 3, "{found:?}");
        let found = cut(&[door(3.0, 2.0, 1.0)]);
        let left: Vec<_> = found.iter().filter(|wall| wall.material_id == "wood").collect();
        assert_eq!(left.iter().map(|wall| &*wall.id).collect::<Vec<_>>(), ["partition", "2"]);
        // Ends that were not cut are those of the wall, to the last bit.
        assert_eq!((left[0].corners[0], left[1].corners.last()), (corners[0], corners.last()));
        let lines = std::slice::from_ref(&corners);
        assert!(near(&door(0.0, 0.0, 1.0).course(lines), &[vec2(0.0, 0.0), vec2(0.5, 0.0)]));
        assert!(near(&door(3.0, 0.0, 1.0).course(lines), &[vec2(2.5, 0.0), corners[1], vec2(3.0, 0.5)]));
        // Behind it is where fewer people are.
        let people = [vec2(1.0, 2.0), vec2(2.0, 2.0), vec2(4.0, 2.0)];
        let exit = |people: &[Vec2]| door(3.0, 2.0, 1.0).exit(lines, people.iter().copied()).unwrap();
        assert!(exit(&people).iter().all(|end| end.x == 4.0), "{:?}", exit(&people));
        assert!(exit(&people[2..]).iter().all(|end| end.x == 2.0));
        let refused = cut_doors_in_all(geometry.clone(), &[door(9.0, 9.0, 1.0)]).unwrap_err().to_string();
        assert!(refused.contains("from the nearest wall"), "{refused}");
        // Only closed ones, for those who ask for that.
        assert_eq!(super::cut_doors(geometry.clone(), &[door(3.9, 2.0, 1.0)]).unwrap().walls.len(), 3);
        let ids = |walls: Vec<Wall>| walls.into_iter().filter(|wall| wall.id == "partition").count();
        assert_eq!(ids(super::cut_doors(geometry.clone(), &[door(3.9, 2.0, 1.0)]).unwrap().walls), 1);
    }

    #[test]
    fn a_door_goes_along_with_its_wall() {
        let (outer, inner) = (door(4.1, 0.75, 0.8), door(1.5, 1.0, 0.2));
        let moved = [box_of(Vec2::zeros(), vec2(6.0, 5.0)), room().remove(1)];
        // A quarter of the way up, as before.
        assert_eq!(outer.carried(&room(), &moved), door(6.0, 1.25, 0.8));
        assert_eq!(inner.carried(&room(), &moved), inner);
        let fewer = Ring::through(vec![Vec2::zeros(), vec2(4.0, 0.0), vec2(4.0, 3.0)]).unwrap();
        for after in [&room()[..], &[], &[fewer]] {
            assert_eq!(outer.carried(&room(), after), outer);
        }
    }

    #[test]
    fn impossible_doors_are_refused() {
        for (door, message) in [
            (door(9.0, 9.0, 1.0), "door 0 at (9, 9) m is 7.81 m from the nearest closed wall"),
            (door(f64::NAN, 0.0, 1.0), "door 0"),
            (door(4.0, 1.0, -1.0), "must be positive"),
            (door(1.5, 1.0, 4.0), "no wall left"),
        ] {
            let refused = cut_doors(walls(&room(), "concrete"), &[door]).unwrap_err().to_string();
            assert!(refused.contains(message), "{refused}");
        }
    }

    #[test]
    fn walls_keep_their_ids_and_materials() {
        let mut geometry = walls(&[box_of(Vec2::zeros(), vec2(8.0, 6.0))], "concrete");
        geometry.walls[0].id = "room".into();
        for (place, id) in [(0, "0"), (2, "1")] {
            let corners = vec![Vec2::zeros(), vec2(8.0, 3.0)];
            geometry.walls.insert(place, Wall::new(id, "wood", corners));
        }
        let right = door(8.1, 3.0, 1.0);
        let cut = cut_doors(geometry.clone(), &[right.clone(), door(4.0, 0.0, 2.0)]).unwrap();
        let ids: Vec<&str> = cut.walls.iter().map(|wall| &*wall.id).collect();
        assert_eq!(ids, ["0", "room", "2", "1"]);
        assert!(cut.walls[0] == geometry.walls[0] && cut.walls[3] == geometry.walls[2]);
        assert!(cut.walls[1..3].iter().all(|wall| wall.material_id == "concrete"));
        let left: f64 = cut.walls[1..3].iter().map(|wall| long(&wall.corners)).sum();
        assert!((left - 25.0).abs() < 1e-9);
        assert_eq!(right.wall(&geometry), Some(&geometry.walls[1]));
        assert_eq!(right.wall(&walls(&[], "")), None);
        // A door that opens at 20 s is a gap with a wall in it.
        let opens = Door { open: OpeningTimes::of_numbers(&[20.0, 60.0]).ok(), ..right };
        let closed = cut_doors(geometry.clone(), &[opens.clone(), door(4.0, 0.0, 2.0)]).unwrap();
        let wall = &closed.walls[3];
        assert_eq!((&*wall.id, &*wall.material_id, &wall.open), ("3", "concrete", &opens.open));
        assert_eq!(wall.corners, [vec2(8.0, 2.5), vec2(8.0, 3.5)]);
        assert!(closed.fixed_walls().eq(&cut.walls));
    }

    #[test]
    fn the_exit_is_behind_the_door_on_the_side_of_fewer_people() {
        let inside = [vec2(4.0, 3.0), vec2(5.0, 3.0), vec2(12.0, 3.0)];
        let exit = |ring: Ring, door: Door, people: &[Vec2]| {
            let [a, b] = door.exit(&[ring], people.iter().copied()).unwrap();
            if (a.x, a.y) <= (b.x, b.y) { [a, b] } else { [b, a] }
        };
        let ring = box_of(Vec2::zeros(), vec2(8.0, 6.0));
        for ring in [ring.clone(), ring.reversed()] {
            let right = door(8.0, 3.0, 1.0);
            assert_eq!(exit(ring.clone(), right.clone(), &inside), [vec2(9.0, 1.5), vec2(9.0, 4.5)]);
            assert_eq!(exit(ring.clone(), right, &inside[2..]), [vec2(7.0, 1.5), vec2(7.0, 4.5)]);
            // Beside the wall: the gap is at the wall's nearest point.
            assert_eq!(exit(ring, door(2.0, -0.3, 2.0), &inside), [vec2(0.0, -1.0), vec2(4.0, -1.0)]);
        }
        let slanted = Ring::through(vec![Vec2::zeros(), vec2(3.0, 4.0), vec2(-4.0, 3.0)]).unwrap();
        let [a, b] = exit(slanted, door(1.5, 2.0, 3.0), &[vec2(-0.5, 2.5)]);
        // The outward normal of the first side is (4, −3)/5.
        let middle = vec2(1.5 + 0.8, 2.0 - 0.6);
        let off = [(a + b) * 0.5 - middle, (b - a) - vec2(3.0, 4.0)];
        assert!(off.iter().all(|off| off.norm() < 1e-8), "{a:?} {b:?}");
        assert_eq!(door(0.0, 0.0, 1.0).exit::<Ring>(&[], std::iter::empty()), None);
    }
}
