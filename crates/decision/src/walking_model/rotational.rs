//! The rotational collision-free speed model with anticipation.
//!
//! - Steering: a person turns away from the one who counts most ahead, as in the third version of JuPedSim's
//!   collision-free speed model. The angle relaxes.
//! - Spacing: the speed is that at which the gap to those ahead lasts for the time gap T (Tordeux, Chraibi, Seyfried
//!   2016). The gap is what it will be when the body has followed: its relaxation time times the rate of the gap is added.
//!   Who walks away is followed earlier: there the rate counts for [`FOLLOWING`].
//! - Oncoming people with another destination: both step aside early, by what is missing of the clearance to where the
//!   other will be. Nobody turns into the way of somebody oncoming to overtake: there, people walk behind somebody who goes
//!   the same way. Who will pass at the side holds up nobody. That people look ahead in time is an idea of Xu et al.,
//!   *Anticipation velocity model*, Transp. Res. C 133 (2021) 103464.
//! - Narrow places: who has little room beside the shoulders, or passes close to somebody oncoming, turns them.
//!   Where two do not fit side by side for a while, people walk in single file.
//! - Swaying: who is slow shifts the weight from one foot to the other (Hoogendoorn, Daamen, Transp. Sci. 39 (2005) 147).
//!   This loosens arches in front of doors. Who wants to be slow sways less.
//! - Pushing: who is held up pushes with a limited force.
//!
//! People are seen as circles of one radius here; their bodies touch in the mechanics. The constants were chosen beside
//! trajectories of experiments (`examples/experiments.py`, `docs/validation.md`).

use super::near::facing;
use super::{CLOSE, DesiredMotion, FAR, Walk, Walking};
use crate::cells::{Cells, nearest_points, sees};
use crate::error::{PlanError, moderate, not_negative, positive};
use lemons_core::plane::{InPlane, Rotation, Vec2, rotation, vec2};
use lemons_core::trial::Rule;
use serde::{Deserialize, Serialize};
use std::f64::consts::FRAC_PI_2;

/// Constants of the model. T and the standstill gap of a single person may be others.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
#[serde(deny_unknown_fields, default)]
pub struct Rotational {
    /// \[s\] Time gap T to who is ahead.
    pub time_gap: f64,
    /// \[m\] Gap b that is left to who is ahead by those who stand.
    pub standstill_gap: f64,
    /// \[s\] Reaction time to gaps that change.
    pub reaction_time: f64,
    /// \[m/s\] Standard deviation of the noise of the speed.
    pub speed_noise: f64,
    /// \[m/s²\] Greatest acceleration. Who is held up pushes with at most the mass times this.
    pub acceleration: f64,
}

impl Default for Rotational {
    fn default() -> Rotational {
        Rotational {
            time_gap: 0.9,
            standstill_gap: 0.09,
            reaction_time: 0.0,
            speed_noise: 0.15,
            acceleration: 4.0,
        }
    }
}

/// \[m\] Radius of a person for the others.
const RADIUS: f64 = 0.15;
/// \[m\] Half the width of the lane in which those ahead hold somebody up.
const LANE: f64 = 0.28;
/// \[s\] Times by which a growing gap is anticipated: where there is room at the side, and in single file, where who is ahead
/// can only go on.
const FOLLOWING: [f64; 2] = [1.2, 2.0];
/// Repulsion of walls, and its range \[m\].
const WALL: (f64, f64) = (5.0, 0.02);
/// \[m\] Ranges along and across the way in which those ahead count for steering.
const AHEAD: f64 = 2.0;
const ACROSS: f64 = 0.8;
/// \[m\] Offset to the side from which on the steering angle is nearly the largest.
const OFFSET: f64 = 0.05;
/// Part of the spacing that is taken along the direction of walking; the rest is taken along the way.
const ALONG: f64 = 0.85;
/// \[m/s\] Speed backwards of those who are too close.
const BACK: f64 = 0.01;
/// \[m\] Lateral distance of centres with which oncoming people want to pass.
const CLEARANCE: f64 = 0.6;
/// \[m\] Free distance beyond the clearance without which nobody evades a leader to that side.
const OVERTAKING: f64 = 0.3;
/// \[rad\] Greatest angle by which people steer to walk behind somebody where they do not overtake because of oncoming people.
const BEHIND: f64 = 0.8;
/// \[m\] Lateral distance of centres from which on oncoming people pass without being slower.
const PASSING: f64 = 0.2;
/// \[m\] Distance of centres within which people turn the shoulders when they pass somebody oncoming, and by which angle
/// \[rad\].
const TURNING: (f64, f64) = (0.7, 1.3);
/// \[s\] Times: how early people step aside, the shortest time that counts, and that by which others are extrapolated.
const EARLY: (f64, f64, f64) = (4.0, 0.25, 1.0);
/// Angle per sideways velocity \[rad s/m\], which is also the greatest angle \[rad\].
const ASIDE: f64 = 0.8;
/// \[m/s\] Smallest speed at which oncoming people are expected to come nearer.
const CLOSING: f64 = 0.3;
/// Greatest speed \[m/s\] and angle \[rad\] of swaying, and the speed \[m/s\] from which on nobody sways.
const SWAY: (f64, f64, f64) = (0.5, 0.6, 0.5);
/// \[m\] Room that two people want beside them who walk side by side, or pass through at the same time.
const ROOM: f64 = 0.1;
/// \[m\] By how much a passage is wider than the shoulders, or they are turned. Tuned at a measured gate; Warren, Whang, J. Exp.
/// Psychol. 13 (1987) 371, found that people turn where a passage is less than 1.3 times as wide as they are.
const SHOULDER_ROOM: f64 = 0.18;
/// \[m\] Room without which nobody goes into a narrow place.
const TIGHT: f64 = 0.02;
/// \[m\] How far ahead a narrow place is seen.
const LOOK: f64 = 0.35;
/// Number of angles that are tried for shoulders.
const TURNS: u32 = 16;
/// \[m\] How far people see others.
const SIGHT: f64 = 4.0;
/// \[m\] Width of the cells in which neighbours are looked for.
const CELL: f64 = 0.5;

/// Somebody, as others see it.
#[derive(Clone, Copy)]
struct Other {
    at: Vec2,
    velocity: Vec2,
    /// Zero for who goes nowhere.
    direction: Vec2,
    person: usize,
    /// \[m\] Of the body, across the gaze.
    breadth: f64,
    depth: f64,
}

impl Walk for Rotational {
    fn check(&self) -> Result<(), PlanError> {
        positive("rotational", "time_gap", self.time_gap)?;
        not_negative("rotational", "standstill_gap", self.standstill_gap)?;
        not_negative("rotational", "reaction_time", self.reaction_time)?;
        positive("rotational", "acceleration", self.acceleration)?;
        moderate("rotational", "speed_noise", self.speed_noise)
    }

    fn time_gap(&self) -> f64 {
        self.time_gap
    }

    fn standstill_gap(&self) -> f64 {
        self.standstill_gap
    }

    fn reaction_time(&self) -> f64 {
        self.reaction_time
    }

    fn speed_noise(&self) -> f64 {
        self.speed_noise
    }

    fn turns_shoulders(&self) -> bool {
        true
    }

    fn unfit(&self) -> [Option<Rule>; 2] {
        [None; 2]
    }

    fn desired(&self, people: &[Option<Walking<'_>>], faces: &[[Vec2; 2]]) -> Vec<DesiredMotion> {
        let surroundings = Surroundings::new(people, faces);
        let one = |walking: &Option<Walking<'_>>| match walking {
            Some(walking) => of_one(self, walking, people, &surroundings),
            None => DesiredMotion::default(),
        };
        people.iter().map(one).collect()
    }
}

/// Surroundings that everybody sees.
struct Surroundings {
    cells: Cells<Other>,
    /// \[m/s\] Greatest speed of anybody.
    fastest: f64,
    /// Eighths of the circle in which somebody goes, a bit each; none if all have one destination.
    eighths: u8,
}

impl Surroundings {
    fn new(people: &[Option<Walking<'_>>], faces: &[[Vec2; 2]]) -> Surroundings {
        let there = || people.iter().flatten();
        let mut going = there().filter(|walking| walking.direction.is_some());
        let first = going.next();
        let several = first.is_some_and(|first| going.any(|other| parts(first, other)));
        let ways = there().filter_map(|walking| walking.direction.filter(|_| several));
        Surroundings {
            cells: Cells::new(
                people,
                |walking| walking.at,
                faces,
                (CELL, SIGHT),
                |person, walking| {
                    let direction = walking.direction.unwrap_or(Vec2::zeros());
                    let Walking { at, velocity, breadth, depth, .. } = *walking;
                    Other { at, velocity, direction, person, breadth, depth }
                },
            ),
            fastest: there().map(|walking| walking.velocity.norm()).fold(0.0, f64::max),
            eighths: ways.fold(0, |all, way| all | 1 << eighth(way)),
        }
    }

    /// Returns whether anybody with another destination may go against a direction.
    fn opposing(&self, direction: Vec2) -> bool {
        let own = eighth(direction);
        (2..=6).any(|turn| self.eighths & 1 << ((own + turn) % 8) != 0)
    }
}

/// Somebody who walks, and what does not depend on the others.
struct View<'a> {
    walking: &'a Walking<'a>,
    people: &'a [Option<Walking<'a>>],
    faces: &'a [[Vec2; 2]],
    /// Unit vectors: the direction of walking, and that of the way.
    ways: [Vec2; 2],
    /// Unit vector of the way, turned away from walls.
    reference: Vec2,
    /// \[m/s\] Velocity by which people see who will pass at the side.
    expected: Vec2,
    /// \[m\] Free widths across the way: the greater and the smaller one of here and a little ahead.
    corridor: f64,
    narrowest: f64,
}

/// View that somebody has of the others.
#[derive(Debug, PartialEq)]
struct Seen {
    /// The person who counts most ahead: the distance with the ranges of steering, and the offset to the side \[m\].
    leader: (f64, f64),
    /// Whether the leader goes the same way: neither stands nor crosses.
    leads_on: bool,
    /// \[m\] Smallest gaps, along both ways.
    gaps: [f64; 2],
    /// \[m/s\] Sideways velocities that the clearance to those who come on the right and on the left demands.
    demanded: [f64; 2],
    /// Whether they leave no room for overtaking.
    blocked: [bool; 2],
    /// Whether somebody oncoming passes closely.
    passes_close: bool,
    queues: bool,
}

impl<'a> View<'a> {
    fn new(
        walking: &'a Walking<'a>,
        goal: Vec2,
        people: &'a [Option<Walking<'a>>],
        surroundings: &'a Surroundings,
    ) -> View<'a> {
        let (at, cells) = (walking.at, &surroundings.cells);
        let faces = cells.faces(cells.cell(at));
        let reference = (goal + walls(at, faces)).unit(1e-9).unwrap_or(goal);
        let direction = rotation(walking.steering) * reference;
        let [here, soon] = widths(at, goal, faces);
        View {
            walking,
            people,
            faces,
            ways: [direction, goal],
            reference,
            expected: (direction * walking.speed + walking.velocity) * 0.5,
            corridor: here.max(soon),
            narrowest: here.min(soon),
        }
    }

    /// Returns the view before anybody is seen.
    fn nobody(&self) -> Seen {
        // Beyond this gap nobody changes the speed.
        let free = self.walking.speed * self.walking.time_gap + self.walking.standstill_gap;
        Seen {
            leader: (f64::INFINITY, 0.0),
            leads_on: false,
            gaps: [free; 2],
            demanded: [0.0; 2],
            blocked: [false; 2],
            passes_close: false,
            queues: false,
        }
    }

    fn is_visible(&self, other: &Other) -> bool {
        sees(self.walking.at, other.at, self.faces)
    }

    /// Returns whether another person goes elsewhere next. Who comes from the other side of a common door is not evaded.
    fn parts(&self, other: &Other) -> bool {
        self.people[other.person].as_ref().is_some_and(|other| parts(self.walking, other))
    }

    /// Returns whether another person has the same destination, and less far to go.
    fn is_nearer(&self, other: &Other) -> bool {
        let walking = self.walking;
        let nearer =
            |other: &Walking<'_>| other.destination == walking.destination && other.to_go < walking.to_go;
        self.people[other.person].as_ref().is_some_and(nearer)
    }

    /// Sees another person.
    fn see(&self, other: &Other, seen: &mut Seen) {
        let walking = self.walking;
        let to = other.at - walking.at;
        let square = to.dot(&to);
        let ahead = self.ways.map(|way| way.dot(&to));
        let along = self.reference.dot(&to);
        let is_ahead = along > 0.0 || ahead[0] > 0.0 || ahead[1] > 0.0;
        let close = square < TURNING.0 * TURNING.0 && ahead[1] > -2.0 * RADIUS;
        if !is_ahead && !close || square > SIGHT * SIGHT || square == 0.0 {
            return;
        }
        let oncoming = other.direction.dot(&self.ways[1]) < 0.0;
        if oncoming && close && !seen.passes_close {
            seen.passes_close = self.parts(other) && self.is_visible(other);
        }
        if !is_ahead {
            return;
        }
        if !oncoming && along > 0.0 {
            let side = self.reference.perp(&to);
            let far = along / AHEAD + side.abs() / ACROSS;
            if far < seen.leader.0 && self.is_visible(other) {
                seen.leader = (far, side);
                seen.leads_on = other.direction.dot(&self.ways[1]) > 0.0;
            }
        }
        // Where two do not fit side by side, one goes after the other.
        let both = walking.breadth + other.breadth;
        let single = self.corridor < both + ROOM;
        let gives_way = || self.narrowest < walking.depth + other.depth + ROOM && self.is_nearer(other);
        let half = if single || gives_way() { 0.5 * both } else { LANE };
        let in_lane = [0, 1].map(|k| ahead[k] > 0.0 && self.ways[k].perp(&to).abs() <= half);
        if in_lane != [false; 2] {
            let relative = self.expected - other.velocity;
            let passes = oncoming && !single && relative.perp(&to).abs() > PASSING * relative.norm();
            if !passes {
                let distance = square.sqrt();
                let approach = (walking.velocity - other.velocity).dot(&to) / distance;
                let time = if approach < 0.0 { FOLLOWING[usize::from(single)] } else { walking.relaxation };
                // The gap was seen before.
                let time = time - walking.reaction_time;
                for k in 0..2 {
                    let gap = if single { ahead[k] } else { distance } - 2.0 * RADIUS - time * approach;
                    if in_lane[k] && gap < seen.gaps[k] && self.is_visible(other) {
                        seen.gaps[k] = gap;
                    }
                }
                if in_lane[1] && distance < CLOSE + 2.0 * RADIUS && !seen.queues && self.is_visible(other) {
                    let goes_on = other.direction != Vec2::zeros();
                    seen.queues = single && !oncoming || goes_on && self.is_nearer(other);
                }
            }
        }
        if oncoming && ahead[1] > 0.0 {
            self.see_oncoming(other, to, ahead[1], seen);
        }
    }

    /// Sees somebody who comes along the way.
    fn see_oncoming(&self, other: &Other, to: Vec2, ahead: f64, seen: &mut Seen) {
        let (early, least, extrapolated) = EARLY;
        let goal = self.ways[1];
        let closing = goal.dot(&(self.walking.velocity - other.velocity)).max(CLOSING);
        let time = ((ahead - 2.0 * RADIUS) / closing).max(least);
        if time >= early {
            return;
        }
        let offset = goal.perp(&(to + other.velocity * time.min(extrapolated)));
        let left = usize::from(offset > 0.0);
        let missing = CLEARANCE - offset.abs();
        let is_more = missing / time > seen.demanded[left] || missing > -OVERTAKING && !seen.blocked[left];
        if is_more && self.parts(other) && self.is_visible(other) {
            seen.demanded[left] = seen.demanded[left].max(missing / time);
            seen.blocked[left] |= missing > -OVERTAKING;
        }
    }

    /// Sees the others, from near to far, as far as they count.
    fn see_all(&self, surroundings: &Surroundings) -> Seen {
        let Surroundings { cells, fastest, .. } = surroundings;
        let walking = self.walking;
        let mut seen = self.nobody();
        let [direction, goal] = self.ways;
        // No gap is shorter than the distance by more.
        let extrapolated =
            walking.relaxation.max(walking.reaction_time) * (walking.velocity.norm() + fastest);
        // Oncoming people who are further ahead, or to the side, are not evaded.
        let evaded = surroundings.opposing(goal).then(|| {
            let closing = (goal.dot(&walking.velocity) + fastest).max(CLOSING);
            (2.0 * RADIUS + EARLY.0 * closing, CLEARANCE + OVERTAKING + EARLY.2 * fastest)
        });
        // In a corridor, distances along the way count, which are shorter.
        let reach = 2.0 * RADIUS + if self.corridor.is_finite() { walking.breadth } else { 0.0 };
        let (cell, rings) = (cells.cell(walking.at), (SIGHT / cells.width).ceil() as usize);
        // In crowds, hardly anybody else counts.
        cells.block(cell, 2, |other| self.see(other, &mut seen));
        for ring in 3..=rings {
            // Nobody in this ring is nearer than this.
            let nearest = (ring as f64 - 1.0) * cells.width;
            let leads = seen.leader.0 * AHEAD >= nearest;
            let holds_up = seen.gaps[0].max(seen.gaps[1]) + reach + extrapolated >= nearest;
            let queues = !seen.queues && nearest < CLOSE + 2.0 * RADIUS;
            let all = leads || holds_up || queues;
            if !all && evaded.is_none_or(|(far, aside)| nearest >= libm::hypot(far, aside)) {
                break;
            }
            let counts = |low: Vec2, high: Vec2| {
                let (low, high) = (low - walking.at, high - walking.at);
                let most =
                    |way: Vec2| (way.x * low.x).max(way.x * high.x) + (way.y * low.y).max(way.y * high.y);
                if all {
                    return most(goal) > -2.0 * RADIUS || most(direction) > 0.0 || most(self.reference) > 0.0;
                }
                evaded.is_some_and(|(far, aside)| {
                    most(goal) > -2.0 * RADIUS
                        && -most(-goal) < far
                        && most(goal.left()) > -aside
                        && most(-goal.left()) > -aside
                })
            };
            cells.ring(cell, ring, counts, |other| self.see(other, &mut seen));
        }
        seen
    }
}

fn of_one(
    model: &Rotational,
    walking: &Walking<'_>,
    people: &[Option<Walking<'_>>],
    surroundings: &Surroundings,
) -> DesiredMotion {
    let Some(goal) = walking.direction else { return DesiredMotion::default() };
    let velocity = walking.velocity;
    let view = View::new(walking, goal, people, surroundings);
    let (direction, seen) = (view.ways[0], view.see_all(surroundings));

    let demanded = seen.demanded[0] - seen.demanded[1];
    let mut steering = (ASIDE * demanded).clamp(-ASIDE, ASIDE);
    let (far, side) = seen.leader;
    if far.is_finite() {
        let weight = libm::tanh(libm::exp(-far) * side / (side.abs() + OFFSET));
        let overtakes = !seen.blocked[usize::from(side < 0.0)] && view.corridor >= 2.0 * walking.breadth;
        // Among oncoming people, who goes the same way makes room.
        let follows = seen.leads_on && seen.blocked != [false; 2];
        steering += if overtakes {
            -FRAC_PI_2 * weight
        } else if follows {
            BEHIND * weight
        } else {
            0.0
        };
    }
    let spacing = ALONG * seen.gaps[0] + (1.0 - ALONG) * seen.gaps[1];
    // Who is alone keeps the desired speed.
    let free = walking.speed * walking.time_gap + walking.standstill_gap;
    let noise = if seen.gaps == [free; 2] { 0.0 } else { walking.pace * walking.noise };
    let quiet = (spacing - walking.standstill_gap) / walking.time_gap;
    let wanted = quiet + noise;
    let (turned, fits) = shoulders(walking, goal, view.narrowest);
    // Who has not turned yet does not go in.
    let speed = if fits { wanted.clamp(-BACK, walking.speed) } else { -BACK };
    let change = direction * speed - velocity;
    let most = model.acceleration * walking.relaxation / change.norm().max(1e-9);
    let (sway, turn, fast) = SWAY;
    let slow = walking.pace * (1.0 - velocity.norm() / fast).max(0.0);
    let turned = turned.or_else(|| seen.passes_close.then(|| sideways(goal, TURNING.1, walking.theta)));
    let facing = turned.unwrap_or_else(|| facing(goal, direction * speed));
    DesiredMotion {
        velocity: velocity + change * most.min(1.0) + goal.left() * (slow * sway * libm::sin(walking.phase)),
        speed: if fits { quiet.clamp(0.0, walking.speed) } else { 0.0 },
        force: Vec2::zeros(),
        facing: Some(rotation(slow * turn * libm::cos(walking.phase)) * facing),
        queues: seen.queues,
        steering: steering.clamp(-FRAC_PI_2, FRAC_PI_2),
    }
}

/// Returns whether two people go to different places next.
fn parts(one: &Walking<'_>, other: &Walking<'_>) -> bool {
    one.waypoint != other.waypoint || one.waypoint.is_none() && one.destination != other.destination
}

/// Returns the repulsion of walls, relative to the direction of the way.
fn walls(at: Vec2, faces: &[[Vec2; 2]]) -> Vec2 {
    let near = nearest_points(at, faces, RADIUS + FAR * WALL.1);
    let repulsion = near.map(|(point, distance)| {
        (at - point) * (WALL.0 * libm::exp((RADIUS - distance) / WALL.1) / distance)
    });
    repulsion.fold(Vec2::zeros(), |sum, force| sum + force)
}

/// \[m\] Returns the free widths across the way, here and a little ahead; infinite if there is not a wall on either side.
fn widths(at: Vec2, goal: Vec2, faces: &[[Vec2; 2]]) -> [f64; 2] {
    let across = goal.left();
    let mut sides = [[f64::INFINITY; 2]; 2];
    for &[a, b] in faces {
        for (at, sides) in [at, at + goal * LOOK].into_iter().zip(&mut sides) {
            let (from, to) = ((a - at).dot(&goal), (b - at).dot(&goal));
            if (from > 0.0) != (to > 0.0) {
                let offset = (a + (b - a) * (from / (from - to)) - at).dot(&across);
                let side = &mut sides[usize::from(offset > 0.0)];
                *side = side.min(offset.abs());
            }
        }
    }
    sides.map(|[left, right]| left + right)
}

/// Returns the direction of the gaze where the shoulders do not fit through facing ahead, turned to the nearer side, and
/// whether the body fits as it is turned now. Who does not get on turns fully.
fn shoulders(walking: &Walking<'_>, goal: Vec2, width: f64) -> (Option<Vec2>, bool) {
    let narrow = width - SHOULDER_ROOM;
    if narrow >= walking.breadth {
        return (None, true);
    }
    // The outline across the way of somebody whose gaze is turned from it.
    let breadth = |turn: Rotation| {
        let edges = walking.disks.iter().map(|&[x, y, radius]| {
            let offset = (turn * vec2(x, y)).y;
            [offset - radius, offset + radius]
        });
        let [low, high] =
            edges.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], [a, b]| [low.min(a), high.max(b)]);
        high - low
    };
    let turns = (1..TURNS).map(|k| FRAC_PI_2 * f64::from(k) / f64::from(TURNS));
    let fitting = turns.into_iter().find(|&angle| !walking.stuck && breadth(rotation(angle)) <= narrow);
    let angle = fitting.unwrap_or(FRAC_PI_2);
    let gaze = rotation(walking.theta) * vec2(1.0, 0.0);
    let now = rotation(libm::atan2(goal.perp(&gaze), goal.dot(&gaze)));
    let fits = breadth(now) <= width - TIGHT;
    (Some(sideways(goal, angle, walking.theta)), fits)
}

/// Returns a direction turned by an angle to the side that is nearer to a gaze at `theta`.
fn sideways(way: Vec2, angle: f64, theta: f64) -> Vec2 {
    let gaze = rotation(theta) * vec2(1.0, 0.0);
    let [left, right] = [angle, -angle].map(|angle| rotation(angle) * way);
    if left.dot(&gaze) >= right.dot(&gaze) { left } else { right }
}

/// Returns the eighth of the circle in which a direction lies, from 0 to 7.
fn eighth(direction: Vec2) -> u32 {
    let [x, y] = direction.into();
    let second = (x < 0.0) != (y < 0.0);
    u32::from(y < 0.0) << 2 | u32::from(second) << 1 | u32::from((x.abs() < y.abs()) != second)
}

#[cfg(test)]
mod tests;
