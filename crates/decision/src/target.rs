//! Exits and goals: lines and areas to which people walk around walls.

use crate::error::{EXIT, GOAL, PlanError};
use crate::field::{Doors, Field, Gates, Grid, LAST};
use lemons_core::message::{Message, message};
use lemons_core::plane::{InPlane, Ring, Vec2, nearest_on_segment, segments_touch, vec2};
use lemons_core::trial::{Link, OpeningTimes};
use serde::{Deserialize, Serialize};
use std::cmp::Ordering;
use std::collections::BTreeSet;

/// \[m\] Whoever is this near to an exit, or the area of a goal, is there: on a line by rounding errors there is no way to it.
const ROUNDING: f64 = 1e-6;
/// \[m\] Whoever is this near to the line of a goal is there.
const NEAR: f64 = 0.3;
/// \[m\] No body is larger: an area where one can be so far from walls is reached inside.
const WIDEST: f64 = 1.0;
/// \[m\] Nearer than this to the line or the middle of a goal, people walk more and more slowly.
const SLOW: f64 = 1.0;
/// Steps of the grid on foot from a line, where metres may count four times, beyond which the way to it is not straight.
const LAST_ON_FOOT: f64 = 8.0;
/// \[m\] Distance on foot at which people stand in front of an exit or a door that is closed.
const FRONT: f64 = 0.5;

/// Returns the part of the desired speed at a distance \[m\] in front of what is closed: people slow down and stand.
pub(crate) fn share_before_closed(distance: f64) -> f64 {
    ((distance - FRONT) / SLOW).clamp(0.0, 1.0)
}

/// An exit or a goal.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
#[serde(deny_unknown_fields)]
pub struct Target {
    /// No two targets have the same.
    pub name: String,
    /// Whether people stay there; else they leave.
    pub stay: bool,
    /// \[m\] The corners (x, y): two of a line, more of an area.
    pub corners: Vec<[f64; 2]>,
    /// When people can leave by it; `None`: always.
    #[cfg_attr(feature = "typescript", ts(as = "Option<Vec<[f64; 2]>>", optional))]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub open: Option<OpeningTimes>,
    /// So many leave by it, each time that it opens; for others it is closed then.
    #[cfg_attr(feature = "typescript", ts(optional))]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub most: Option<u32>,
    /// Factor of the expected time by it, for those who choose an exit by time.
    #[serde(default = "unchanged", skip_serializing_if = "is_unchanged")]
    pub time_factor: f64,
}

fn unchanged() -> f64 {
    1.0
}

fn is_unchanged(factor: &f64) -> bool {
    *factor == unchanged()
}

/// Destination of an agent after the last way-point.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Destination {
    /// Nowhere.
    #[default]
    None,
    /// Exit that is nearest on foot, wherever the agent is.
    NearestExit,
    /// Target with this index.
    Target(usize),
}

impl Target {
    /// Returns what it is, and its name, for messages.
    pub(crate) fn label(&self) -> Message {
        if self.stay { message!(GOAL, name = &self.name) } else { message!(EXIT, name = &self.name) }
    }

    /// Returns whether people can leave by it at a time \[s\].
    pub fn is_open(&self, time: f64) -> bool {
        self.open.as_ref().is_none_or(|open| open.is_open(time))
    }

    /// \[m\] Returns how far it is from a place, in a straight line.
    pub fn distance(&self, at: Vec2) -> f64 {
        match self.area() {
            Some(ring) if ring.contains(at) => 0.0,
            Some(ring) => ring.nearest(at).distance,
            None => {
                let points = self.points();
                (nearest_on_segment(points[0], points[1], at) - at).norm()
            }
        }
    }

    fn points(&self) -> Vec<Vec2> {
        self.corners.iter().map(|&[x, y]| vec2(x, y)).collect()
    }

    /// `None` for a line.
    pub fn area(&self) -> Option<Ring> {
        if self.corners.len() > 2 { Ring::through(self.points()) } else { None }
    }
}

/// The shape of a target.
#[derive(Debug, Clone)]
enum Shape {
    Line([Vec2; 2]),
    /// A ring with its middle: the inner point that is furthest from the sides.
    Area(Ring, Vec2),
}

impl Shape {
    fn of(target: &Target) -> Shape {
        let points = target.points();
        match target.area() {
            Some(ring) => {
                let middle = middle_of(&ring);
                Shape::Area(ring, middle)
            }
            None => Shape::Line([points[0], points.get(1).copied().unwrap_or(points[0])]),
        }
    }

    fn nearest(&self, at: Vec2) -> Vec2 {
        match self {
            Shape::Line([from, to]) => nearest_on_segment(*from, *to, at),
            Shape::Area(ring, _) if ring.contains(at) => at,
            Shape::Area(ring, _) => ring.nearest(at).place,
        }
    }

    /// Returns whether somebody who walked from one place to the other is there, or was on the way: over a line, through an
    /// area, or at one where people stay.
    fn holds(&self, from: Vec2, to: Vec2, stay: bool) -> bool {
        let within = |far: f64| (self.nearest(to) - to).norm() <= far;
        match self {
            Shape::Line(_) if stay => within(NEAR),
            Shape::Line([a, b]) => segments_touch(from, to, *a, *b) || within(ROUNDING),
            Shape::Area(ring, _) => {
                let crosses = || ring.sides().any(|(a, b)| segments_touch(from, to, a, b));
                within(ROUNDING) || !stay && crosses()
            }
        }
    }
}

/// Returns the exit that is nearest in a straight line. Lines beyond neighbouring doors may overlap: there, that whose
/// middle is nearest.
pub fn nearest_exit(targets: &[Target], at: Vec2) -> Option<usize> {
    let far = |k: &usize| {
        let points = targets[*k].points();
        let middle =
            points.iter().fold(Vec2::zeros(), |sum, point| sum + *point) * (1.0 / points.len() as f64);
        [targets[*k].distance(at).max(NEAR), (middle - at).norm()]
    };
    let exits = (0..targets.len()).filter(|k| !targets[*k].stay);
    exits.min_by(|a, b| far(a).partial_cmp(&far(b)).unwrap_or(Ordering::Equal))
}

fn lines_and_areas<'a>(shapes: impl Iterator<Item = &'a Shape>) -> (Vec<[Vec2; 2]>, Vec<Ring>) {
    let (mut lines, mut areas) = (Vec::new(), Vec::new());
    for shape in shapes {
        match shape {
            Shape::Line(ends) => lines.push(*ends),
            Shape::Area(ring, _) => areas.push(ring.clone()),
        }
    }
    (lines, areas)
}

/// The best of a grid of points: as exact as a step in a room need be.
fn middle_of(ring: &Ring) -> Vec2 {
    let (bounds, count) = (ring.bounds(), 32);
    let size = bounds.size();
    let points = (0..count * count).map(|k| {
        let share = |k: i32| (f64::from(k) + 0.5) / f64::from(count);
        bounds.low + vec2(share(k % count) * size.x, share(k / count) * size.y)
    });
    let depth = |at: &Vec2| ring.nearest(*at).distance;
    let inside = points.filter(|at| ring.contains(*at));
    inside.max_by(|a, b| depth(a).total_cmp(&depth(b))).unwrap_or(ring.corners()[0])
}

/// Ways to all targets of a plan.
#[derive(Debug, Clone)]
pub struct Ways {
    grid: Grid,
    shapes: Vec<Shape>,
    stay: Vec<bool>,
    /// Distances to each target, if somebody goes there.
    to_each: Vec<Option<Field>>,
    /// Distances to the nearest exit, if somebody goes there.
    to_nearest: Option<Field>,
    /// Free widths of the ways to each target, if they were measured.
    widths: Vec<Field>,
    /// Doors that open and close, and those on the ways to each target.
    doors: Doors,
    gates: Vec<Option<Gates>>,
}

/// Way that a destination asks of somebody.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Leg {
    /// Unit vector; `None` on the middle of a goal.
    pub direction: Option<Vec2>,
    /// Part of the desired speed.
    pub share: f64,
    /// \[m\] How far it is on foot; infinite if no way leads there.
    pub distance: f64,
}

impl Ways {
    /// Finds the ways around walls, given as polylines, for people who start at these places.
    ///
    /// # Errors
    /// The area is too large.
    pub fn new(
        walls: &[Vec<Vec2>],
        links: &[Link],
        targets: &[Target],
        people: impl Iterator<Item = (Vec2, Destination)> + Clone,
    ) -> Result<Ways, PlanError> {
        let shapes: Vec<Shape> = targets.iter().map(Shape::of).collect();
        let places = targets.iter().flat_map(Target::points).chain(people.clone().map(|(at, _)| at));
        let ends = links.iter().flat_map(|link| link.lines.as_flattened()).copied();
        let grid = Grid::new(walls, places.chain(ends))?;
        let grid = grid.with_passages(links.iter().flat_map(Link::passages));
        let field = |wanted: &[usize]| {
            let (lines, areas) = lines_and_areas(wanted.iter().map(|k| &shapes[*k]));
            grid.field(&lines, &areas)
        };
        let wanted: BTreeSet<Destination> = people.map(|(_, to)| to).collect();
        grid.check_fields(wanted.len())?;
        let to_each =
            (0..targets.len()).map(|k| wanted.contains(&Destination::Target(k)).then(|| field(&[k])));
        let to_each = to_each.collect();
        let exits: Vec<usize> = (0..targets.len()).filter(|k| !targets[*k].stay).collect();
        let to_nearest = wanted.contains(&Destination::NearestExit).then(|| field(&exits));
        let stay = targets.iter().map(|target| target.stay).collect();
        let (widths, doors, gates) = Default::default();
        Ok(Ways { grid, shapes, stay, to_each, to_nearest, widths, doors, gates })
    }

    /// Measures how wide the ways to each target are.
    ///
    /// # Errors
    /// The area is too large.
    pub fn with_widths(mut self) -> Result<Ways, PlanError> {
        let fields = self.to_each.iter().chain([&self.to_nearest]).flatten().count();
        self.grid.check_fields(2 * fields)?;
        let widths =
            |field: &Option<Field>| field.as_ref().map_or(Field::new(), |field| self.grid.widths(field));
        self.widths = self.to_each.iter().map(widths).collect();
        Ok(self)
    }

    /// Finds which doors, each of straight pieces, are on the ways to each target.
    ///
    /// # Errors
    /// The area is too large.
    pub fn with_doors(mut self, doors: Vec<Vec<[Vec2; 2]>>) -> Result<Ways, PlanError> {
        let fields = self.to_each.iter().chain([&self.to_nearest]).flatten().count();
        self.grid.check_fields(3 * fields)?;
        let doors = self.grid.doors(doors);
        let gates = |(shape, field): (&Shape, &Option<Field>)| {
            field.as_ref().map(|field| self.grid.gates(field, &doors, |at| shape.nearest(at)))
        };
        self.gates = self.shapes.iter().zip(&self.to_each).map(gates).collect();
        self.doors = doors;
        Ok(self)
    }

    /// Returns the doors on the way from a place to a target, in its order, with how far \[m\] it is from each to the target;
    /// none if they were not looked for.
    pub fn doors_to(&self, target: usize, at: Vec2) -> impl Iterator<Item = (usize, f64)> {
        let gates = self.gates.get(target).and_then(Option::as_ref);
        gates.into_iter().flat_map(move |gates| self.grid.gates_from(gates, &self.doors, at))
    }

    /// \[m\] Returns the width of a target for people at these places: of the free widths of the narrowest places on their
    /// ways, the one that a quarter exceed, and at most the length of its line. Who has no narrow place ahead is through.
    /// Infinite if nobody has, or it was not measured.
    pub fn width(&self, target: usize, places: impl Iterator<Item = Vec2>) -> f64 {
        let widths = self.widths.get(target).map_or(&[][..], |widths| &widths[..]);
        let mut all: Vec<f64> = places.filter_map(|at| self.grid.width(widths, at)).collect();
        all.sort_by(f64::total_cmp);
        let way = all.get(all.len() * 3 / 4).copied().unwrap_or(f64::INFINITY);
        match self.shapes[target] {
            Shape::Line([a, b]) => way.min((b - a).norm()),
            Shape::Area(..) => way,
        }
    }

    /// Targets that no place is near enough to: they lie on walls. Only those to which somebody goes.
    pub fn shut(&self) -> Vec<usize> {
        let wanted = |k: &usize| self.to_each[*k].is_some() || (self.to_nearest.is_some() && !self.stay[*k]);
        let all = (0..self.shapes.len()).filter(wanted);
        let shut = |k: &usize| {
            let (lines, areas) = lines_and_areas(std::iter::once(&self.shapes[*k]));
            !self.grid.begins(&lines, &areas)
        };
        all.filter(shut).collect()
    }

    fn field(&self, to: Destination) -> Option<&Field> {
        match to {
            Destination::None => None,
            Destination::NearestExit => self.to_nearest.as_ref(),
            Destination::Target(k) => self.to_each.get(k)?.as_ref(),
        }
    }

    fn targets(&self, to: Destination) -> impl Iterator<Item = usize> {
        let wanted = move |k: &usize| match to {
            Destination::None => false,
            Destination::NearestExit => !self.stay[*k],
            Destination::Target(target) => *k == target,
        };
        (0..self.shapes.len()).filter(wanted)
    }

    /// \[m\] How far it is on foot; infinite if no way leads there.
    pub fn distance(&self, to: Destination, at: Vec2) -> f64 {
        self.field(to).map_or(f64::INFINITY, |field| self.grid.distance(field, at))
    }

    /// Returns at which target somebody has arrived who walked from one place to another; if it is an exit, at one that is
    /// `open`. Somebody has arrived, too, who gets no nearer to an area with a `body` of this radius \[m\], because of a wall behind its rim.
    pub fn arrived(
        &self,
        to: Destination,
        from: Vec2,
        at: Vec2,
        body: impl Fn() -> f64,
        open: impl Fn(usize) -> bool,
    ) -> Option<usize> {
        let holds = |k: &usize| {
            let (shape, stay) = (&self.shapes[*k], self.stay[*k]);
            let is_near = || match shape {
                Shape::Area(..) if !stay => self.is_stopped_at(shape.nearest(at), at, &body),
                _ => false,
            };
            open(*k) && (shape.holds(from, at, stay) || is_near())
        };
        self.targets(to).find(holds)
    }

    /// Returns whether a wall keeps a body from a place that it touches: one that it reaches behind the place, and none
    /// before it. Doors that open and close count as walls before it.
    fn is_stopped_at(&self, place: Vec2, at: Vec2, body: impl Fn() -> f64) -> bool {
        let way = place - at;
        let far = way.norm();
        if far > WIDEST {
            return false;
        }
        let reach = body().clamp(NEAR, WIDEST);
        let stopped = || way.unit(1e-9).is_some_and(|way| !self.grid.sees(at, at + way * reach));
        far <= reach && self.grid.sees(at, place) && !self.doors.are_between(at, place) && stopped()
    }

    /// Returns which way to go. Where the grid knows none (behind a wall, or far outside), straight on. In front of a `closed`
    /// exit, people slow down and stand.
    pub fn leg(&self, to: Destination, at: Vec2, closed: bool) -> Leg {
        let towards = |place: Vec2| (place - at).unit(1e-9);
        let goal = match to {
            Destination::Target(k) if self.stay[k] => Some(&self.shapes[k]),
            _ => None,
        };
        // Where people come to rest, and whether the grid is too coarse for the last steps.
        let (rest, near) = match goal {
            Some(Shape::Area(ring, middle)) if ring.contains(at) => (*middle, f64::INFINITY),
            Some(line @ Shape::Line(_)) => (line.nearest(at), NEAR),
            _ => (vec2(f64::INFINITY, 0.0), 0.0),
        };
        let left = (rest - at).norm();
        let share = (left / SLOW).min(1.0);
        let way = self.field(to).map(|field| self.grid.way(field, at));
        let (distance, found) = way.unwrap_or((f64::INFINITY, None));
        let share = if closed { share_before_closed(distance) } else { share };
        if left <= near {
            return Leg { direction: towards(rest), share, distance };
        }
        let straight = || {
            let nearest = self.targets(to).map(|k| self.shapes[k].nearest(at));
            let nearest = nearest.min_by(|a, b| (*a - at).norm().total_cmp(&(*b - at).norm()))?;
            towards(nearest)
        };
        let near = distance < LAST_ON_FOOT * self.grid.step();
        let last = if near { self.last_step(to, at) } else { None };
        let direction = last.and_then(towards).or(found).or_else(straight);
        Leg { direction, share, distance }
    }
}

impl Ways {
    /// Returns where the last step leads to an exit, or into the area of a goal. The distance falls from both sides of a
    /// line, so that in the squares of the grid which it cuts no way down leads over it.
    fn last_step(&self, to: Destination, at: Vec2) -> Option<Vec2> {
        let is_line = |k: &usize| matches!(self.shapes[*k], Shape::Line(_));
        let wanted = self.targets(to).filter(|k| !(self.stay[*k] && is_line(k)));
        let near = wanted.map(|k| self.shapes[k].nearest(at)).map(|place| (place, (place - at).norm()));
        let near = near.filter(|(_, far)| *far < LAST * self.grid.step());
        let (place, _) = near.min_by(|(_, a), (_, b)| a.total_cmp(b))?;
        self.grid.sees(at, place).then_some(place)
    }
}

/// Action of somebody at a target.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Arrival {
    /// At a goal.
    Stays,
    /// At an exit.
    Leaves,
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Everybody within its bounds had left at the start.
    #[test]
    fn who_stands_beside_a_slanted_exit_has_not_left() {
        let corners = vec![[0.0, 0.0], [4.0, 4.0]];
        let exit =
            Target { name: "exit".into(), stay: false, corners, open: None, most: None, time_factor: 1.0 };
        let (beside, on) = (vec2(3.0, 1.0), vec2(2.0, 2.0));
        let people = [beside, on].map(|at| (at, Destination::NearestExit));
        let ways = Ways::new(&[], &[], &[exit], people.into_iter()).unwrap();
        let arrived = |at| ways.arrived(Destination::NearestExit, at, at, || 0.2, |_| true);
        assert_eq!((arrived(beside), arrived(on)), (None, Some(0)));
    }

    /// The outside: by hand. Bodies keep 0.2 m to 0.3 m from the wall at x = 10 m.
    #[test]
    fn an_area_along_a_wall_is_reached_from_beside_it() {
        let wall = vec![vec2(10.0, 0.0), vec2(10.0, 8.0)];
        let left = |depth: f64, body: f64, at: Vec2| {
            let corners = vec![[10.0 - depth, 2.0], [10.0, 2.0], [10.0, 6.0], [10.0 - depth, 6.0]];
            let exit =
                Target { name: "a".into(), stay: false, corners, open: None, most: None, time_factor: 1.0 };
            let people = std::iter::once((at, Destination::NearestExit));
            let ways = Ways::new(std::slice::from_ref(&wall), &[], &[exit], people).unwrap();
            ways.arrived(Destination::NearestExit, at, at, || body, |_| true).is_some()
        };
        for depth in [0.06, 0.15, 0.25] {
            assert_eq!([9.71, 9.68].map(|x| left(depth, 0.2, vec2(x, 4.0))), [true, false], "{depth}");
            // Beside its end, and behind the wall.
            assert!(!left(depth, 0.2, vec2(9.8, 6.3)) && !left(depth, 0.2, vec2(10.05, 4.0)));
        }
        // A wheelchair.
        assert_eq!([9.36, 9.33].map(|x| left(0.15, 0.65, vec2(x, 4.0))), [true, false]);
        // Where bodies get into the area, they have to.
        assert_eq!([9.51, 9.49].map(|x| left(0.5, 0.2, vec2(x, 4.0))), [true, false]);
    }

    /// The outside: by hand. Walls beside the way into an area stop nobody, and a door that opens and closes is a wall.
    #[test]
    fn an_area_is_reached_early_only_where_a_wall_stops_who_goes_to_it() {
        let left = |walls: &[Vec<Vec2>], doors: &[[Vec2; 2]], [x, y, right, top]: [f64; 4], at: Vec2| {
            let corners = vec![[x, y], [right, y], [right, top], [x, top]];
            let exit =
                Target { name: "a".into(), stay: false, corners, open: None, most: None, time_factor: 1.0 };
            let people = std::iter::once((at, Destination::NearestExit));
            let mut ways = Ways::new(walls, &[], &[exit], people).unwrap();
            ways.doors = ways.grid.doors(vec![doors.to_vec()]);
            ways.arrived(Destination::NearestExit, at, at, || 0.8, |_| true).is_some()
        };
        let line = |ends: [[f64; 2]; 2]| ends.map(Vec2::from).to_vec();
        // A corridor of 1 m, and its end.
        let corridor = [line([[6.0, 1.5], [9.0, 1.5]]), line([[6.0, 2.5], [9.0, 2.5]])];
        let area = [8.0, 1.5, 9.0, 2.5];
        assert!(!left(&corridor, &[], area, vec2(7.9, 2.0)) && left(&corridor, &[], area, vec2(8.1, 2.0)));
        // Across a wall, and past a corner of the room.
        let room = [[[8.0, 0.0], [8.0, 6.0]], [[8.0, 6.0], [0.0, 6.0]]].map(line);
        assert!(left(&room, &[], [7.9, 1.0, 10.0, 5.0], vec2(7.7, 3.0)));
        assert!(left(&room, &[], [7.92, 0.5, 8.0, 7.5], vec2(7.7, 3.0)));
        // A niche behind a door.
        let niche = [line([[8.1, 2.0], [8.1, 4.0]])];
        let door = [[[8.0, 2.0], [8.0, 4.0]].map(Vec2::from)];
        let area = [8.02, 2.0, 8.1, 4.0];
        assert!(left(&niche, &[], area, vec2(7.8, 3.0)) && !left(&niche, &door, area, vec2(7.8, 3.0)));
    }
}
