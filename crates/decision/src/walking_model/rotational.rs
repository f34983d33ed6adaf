//! The rotational collision-free speed model with anticipation.
//!
//! - Steering: a person turns away from the one who counts most ahead, as in the third version of JuPedSim's
//!   collision-free speed model. The angle relaxes.
//! - Spacing: the speed is that at which the gap to those ahead lasts for the time gap T (Tordeux, Chraibi, Seyfried
//!   2016). The gap is what it will be when the body has followed: its relaxation time times the rate of the gap is added.
//!   Who walks away is followed earlier: there the rate counts for [`FOLLOWING`].
//! - Oncoming people: both step aside from where the other will be (Xu et al., *Anticipation velocity model*,
//!   Transp. Res. C 133 (2021) 103464). Who will pass at the side holds up nobody.
//! - Narrow places: who does not fit through facing ahead turns the shoulders. Where two do not fit side by side for
//!   a while, people walk in single file.
//! - Swaying: who is slow shifts the weight from one foot to the other (Hoogendoorn, Daamen, Transp. Sci. 39 (2005) 147).
//!   This loosens arches in front of doors.
//! - Pushing: who is held up pushes with a limited force.
//!
//! People are seen as circles of one radius here; their bodies touch in the mechanics. The constants were chosen beside
//! trajectories of experiments (`examples/experiments.py`, `docs/validation.md`).

use super::{DesiredMotion, FAR, Walking};
use lemons_core::plane::{Rotation, Vec2, nearest_on_segment, segments_cross, vec2};
use serde::{Deserialize, Serialize};
use std::f64::consts::FRAC_PI_2;

/// Constants of the model. T and the standstill gap of a single person may be others.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Rotational {
    /// \[s\] Time gap T to who is ahead.
    pub time_gap: f64,
    /// \[m\] Gap b that is left to who is ahead by those who stand.
    pub standstill_gap: f64,
    /// \[m/s\] Standard deviation of the noise of the speed.
    pub speed_noise: f64,
    /// \[m/s²\] Greatest acceleration. Who is held up pushes with at most the mass times this.
    pub acceleration: f64,
}

impl Default for Rotational {
    fn default() -> Rotational {
        Rotational { time_gap: 0.85, standstill_gap: 0.09, speed_noise: 0.12, acceleration: 4.0 }
    }
}

/// \[m\] Radius of a person for the others.
const RADIUS: f64 = 0.15;
/// \[m\] Half the width of the lane in which those ahead hold somebody up.
const LANE: f64 = 0.26;
/// \[s\] Time by which a growing gap is anticipated.
const FOLLOWING: f64 = 1.2;
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
/// Strength of stepping aside from oncoming people, its range \[m\], and the time \[s\] that is anticipated.
const ASIDE: (f64, f64, f64) = (8.0, 0.1, 1.0);
/// Greatest speed \[m/s\] and angle \[rad\] of swaying, and the speed \[m/s\] from which on nobody sways.
const SWAY: (f64, f64, f64) = (0.5, 0.6, 0.5);
/// \[m/s\] Slower people face the way, faster ones the direction in which they walk.
const FACING: f64 = 0.5;
/// \[m\] Room that shoulders want beside them.
const ROOM: f64 = 0.1;
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
/// \[m\] Who is nearer than this behind somebody may queue.
const CLOSE: f64 = 0.5;

/// Somebody who is seen by others.
#[derive(Clone, Copy)]
struct Seen {
    at: Vec2,
    velocity: Vec2,
    /// Zero for who goes nowhere.
    direction: Vec2,
    person: usize,
    /// \[m\] Of the body, across the gaze.
    breadth: f64,
    depth: f64,
}

/// Returns what everybody wants.
pub(super) fn desired(
    model: &Rotational,
    people: &[Option<Walking<'_>>],
    faces: &[[Vec2; 2]],
) -> Vec<DesiredMotion> {
    let cells = Cells::new(people, faces);
    let one = |walking: &Option<Walking<'_>>| match walking {
        Some(walking) => of_one(model, walking, people, &cells),
        None => DesiredMotion::default(),
    };
    people.iter().map(one).collect()
}

fn of_one(
    model: &Rotational,
    walking: &Walking<'_>,
    people: &[Option<Walking<'_>>],
    cells: &Cells,
) -> DesiredMotion {
    let Some(goal) = walking.direction else { return DesiredMotion::default() };
    let Walking { at, velocity, .. } = *walking;
    let cell = cells.cell(at);
    let faces = &cells.faces[cell.1 * cells.columns + cell.0][..];
    let reference = (goal + walls(at, faces)).unit(1e-9).unwrap_or(goal);
    let direction = reference.rotated(Rotation::by(walking.steering));
    // The velocity by which people see who will pass at the side.
    let expected = (direction * walking.speed + velocity) * 0.5;
    let [here, soon] = widths(at, goal, faces);
    let (corridor, narrowest) = (here.max(soon), here.min(soon));

    let mut leader = (f64::INFINITY, 0.0);
    // Beyond this gap nobody changes the speed.
    let free = walking.speed * walking.time_gap + walking.standstill_gap;
    let mut gaps = [free; 2];
    let mut aside = Vec2::ZERO;
    let mut queues = false;
    let hidden = |other: Vec2| faces.iter().any(|&[a, b]| segments_cross(at, other, a, b));
    let fastest_approach = velocity.norm() + cells.fastest;
    let opposing = cells.opposing(goal);
    let oncoming_reach = 2.0 * RADIUS + FAR * ASIDE.1 + ASIDE.2 * fastest_approach;
    // In a corridor, distances along the way count, which are shorter.
    let reach = 2.0 * RADIUS + if corridor.is_finite() { walking.breadth } else { 0.0 };
    let rings = (SIGHT / cells.width).ceil() as usize;
    for ring in 0..=rings {
        // Nobody in this ring is nearer than this.
        let nearest = (ring as f64 - 1.0).max(0.0) * cells.width;
        let leads = leader.0 * AHEAD >= nearest;
        let holds_up = gaps[0].max(gaps[1]) + reach + walking.relaxation * fastest_approach >= nearest;
        let comes = opposing && oncoming_reach >= nearest;
        if !leads && !holds_up && !comes {
            break;
        }
        cells.ring(cell, ring, |other: &Seen| {
            let to = other.at - at;
            let square = to.dot(to);
            if square > SIGHT * SIGHT || square == 0.0 {
                return;
            }
            let oncoming = other.direction.dot(goal) < 0.0;
            let ahead = [direction.dot(to), goal.dot(to)];
            let (along, side) = (reference.dot(to), reference.cross(to));
            if along <= 0.0 && ahead[0] <= 0.0 && ahead[1] <= 0.0 {
                return;
            }
            let mut visible = None;
            let mut is_visible = || *visible.get_or_insert_with(|| !hidden(other.at));
            if along > 0.0 && !oncoming {
                let far = along / AHEAD + side.abs() / ACROSS;
                if far < leader.0 && is_visible() {
                    leader = (far, side);
                }
            }
            // Where two do not fit side by side, one goes after the other.
            let both = walking.breadth + other.breadth;
            let single = corridor < both + ROOM;
            let gives_way = || {
                narrowest < walking.depth + other.depth + ROOM
                    && people[other.person].as_ref().is_some_and(|other| {
                        other.destination == walking.destination && other.to_go < walking.to_go
                    })
            };
            let half = if single || gives_way() { 0.5 * both } else { LANE };
            let distance = square.sqrt();
            let approach = (velocity - other.velocity).dot(to) / distance;
            let passes = || {
                let relative = expected - other.velocity;
                oncoming && !single && relative.cross(to).abs() > 2.0 * RADIUS * relative.norm()
            };
            for (k, way) in [direction, goal].into_iter().enumerate() {
                if ahead[k] <= 0.0 || way.cross(to).abs() > half {
                    continue;
                }
                let time = if approach < 0.0 { FOLLOWING } else { walking.relaxation };
                let gap = if single { ahead[k] } else { distance } - 2.0 * RADIUS - time * approach;
                if gap < gaps[k] && !passes() && is_visible() {
                    gaps[k] = gap;
                }
                if k == 1 && distance < CLOSE + 2.0 * RADIUS && !queues && !passes() && is_visible() {
                    let nearer = |other: &Walking<'_>| {
                        other.direction.is_some()
                            && other.destination == walking.destination
                            && other.to_go < walking.to_go
                    };
                    queues = single && !oncoming || people[other.person].as_ref().is_some_and(nearer);
                }
            }
            if oncoming && ahead[1] > 0.0 {
                let (strength, range, time) = ASIDE;
                let gap = (distance - 2.0 * RADIUS - time * approach).max(0.0);
                if gap < FAR * range && is_visible() {
                    let across = goal.perp();
                    let later = across.dot(to + other.velocity * time);
                    let away = if later > 0.0 { across * -1.0 } else { across };
                    let weight = 1.0 + 0.5 * (1.0 - goal.dot(other.direction));
                    aside += away * (strength * weight * libm::exp(-gap / range));
                }
            }
        });
    }

    let aside = (reference + aside).unit(1e-9).filter(|_| aside != Vec2::ZERO);
    let mut steering = aside.map_or(0.0, |aside| libm::atan2(reference.cross(aside), reference.dot(aside)));
    if leader.0.is_finite() && corridor >= 2.0 * walking.breadth {
        let (weight, side) = (libm::exp(-leader.0), leader.1);
        steering -= FRAC_PI_2 * libm::tanh(weight * side / (side.abs() + OFFSET));
    }
    let spacing = ALONG * gaps[0] + (1.0 - ALONG) * gaps[1];
    let wanted = (spacing - walking.standstill_gap) / walking.time_gap + walking.noise;
    let (turned, fits) = shoulders(walking, goal, here.min(soon));
    // Who has not turned yet does not go in.
    let speed = if fits { wanted.clamp(-BACK, walking.speed) } else { -BACK };
    let change = direction * speed - velocity;
    let most = model.acceleration * walking.relaxation / change.norm().max(1e-9);
    let (sway, turn, fast) = SWAY;
    let slow = (1.0 - velocity.norm() / fast).max(0.0);
    let facing = turned.unwrap_or_else(|| (goal * FACING + direction * speed).unit(1e-9).unwrap_or(goal));
    DesiredMotion {
        velocity: velocity + change * most.min(1.0) + goal.perp() * (slow * sway * libm::sin(walking.phase)),
        force: Vec2::ZERO,
        facing: Some(facing.rotated(Rotation::by(slow * turn * libm::cos(walking.phase)))),
        queues,
        steering: steering.clamp(-FRAC_PI_2, FRAC_PI_2),
    }
}

/// Returns the repulsion of walls, relative to the direction of the way.
fn walls(at: Vec2, faces: &[[Vec2; 2]]) -> Vec2 {
    let reach = RADIUS + FAR * WALL.1;
    let foot = |face: &[Vec2; 2]| nearest_on_segment(face[0], face[1], at);
    let mut sum = Vec2::ZERO;
    for (n, face) in faces.iter().enumerate() {
        let place = foot(face);
        let distance = (at - place).norm();
        if distance >= reach || distance == 0.0 {
            continue;
        }
        // A corner counts once, and only if no piece that ends there comes nearer.
        let counted = |(m, other): (usize, &[Vec2; 2])| {
            m != n && other.contains(&place) && (foot(other) != place || m < n)
        };
        if !faces.iter().enumerate().any(counted) {
            sum += (at - place) * (WALL.0 * libm::exp((RADIUS - distance) / WALL.1) / distance);
        }
    }
    sum
}

/// \[m\] Returns the free widths across the way, here and a little ahead; infinite if there is not a wall on either side.
fn widths(at: Vec2, goal: Vec2, faces: &[[Vec2; 2]]) -> [f64; 2] {
    let across = goal.perp();
    let mut sides = [[f64::INFINITY; 2]; 2];
    for &[a, b] in faces {
        for (at, sides) in [at, at + goal * LOOK].into_iter().zip(&mut sides) {
            let (from, to) = ((a - at).dot(goal), (b - at).dot(goal));
            if (from > 0.0) != (to > 0.0) {
                let offset = (a + (b - a) * (from / (from - to)) - at).dot(across);
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
    let narrow = width - ROOM;
    if narrow >= walking.breadth {
        return (None, true);
    }
    // The outline across the way of somebody whose gaze is turned from it.
    let breadth = |turn: Rotation| {
        let edges = walking.disks.iter().map(|&[x, y, radius]| {
            let offset = vec2(x, y).rotated(turn).y;
            [offset - radius, offset + radius]
        });
        let [low, high] =
            edges.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], [a, b]| [low.min(a), high.max(b)]);
        high - low
    };
    let turns = (1..TURNS).map(|k| FRAC_PI_2 * f64::from(k) / f64::from(TURNS));
    let fitting = turns.into_iter().find(|&angle| !walking.stuck && breadth(Rotation::by(angle)) <= narrow);
    let angle = fitting.unwrap_or(FRAC_PI_2);
    let gaze = vec2(1.0, 0.0).rotated(Rotation::by(walking.theta));
    let turned = [angle, -angle].map(|angle| goal.rotated(Rotation::by(angle)));
    let now = Rotation::by(libm::atan2(goal.cross(gaze), goal.dot(gaze)));
    let fits = breadth(now) <= width - TIGHT;
    (Some(if turned[0].dot(gaze) >= turned[1].dot(gaze) { turned[0] } else { turned[1] }), fits)
}

/// People by cells of the plane, sorted, and the faces that are seen from each cell.
struct Cells {
    low: Vec2,
    width: f64,
    columns: usize,
    rows: usize,
    /// Where the people of each cell begin in `seen`; one more than cells.
    starts: Vec<u32>,
    seen: Vec<Seen>,
    faces: Vec<Vec<[Vec2; 2]>>,
    /// \[m/s\] Greatest speed of anybody.
    fastest: f64,
    /// Eighths of the circle in which somebody goes, a bit each.
    eighths: u8,
}

impl Cells {
    fn new(people: &[Option<Walking<'_>>], faces: &[[Vec2; 2]]) -> Cells {
        let there = || people.iter().flatten();
        let mut low = vec2(f64::INFINITY, f64::INFINITY);
        let mut high = vec2(f64::NEG_INFINITY, f64::NEG_INFINITY);
        for walking in there() {
            low = vec2(low.x.min(walking.at.x), low.y.min(walking.at.y));
            high = vec2(high.x.max(walking.at.x), high.y.max(walking.at.y));
        }
        if !low.x.is_finite() {
            (low, high) = (Vec2::ZERO, Vec2::ZERO);
        }
        // At most some cells a person, however far apart people are.
        let size = high - low;
        let most = 16.0 * people.len() as f64 + 1024.0;
        let width = CELL.max((size.x * size.y / most).sqrt()).max(size.x.max(size.y) / most);
        let (columns, rows) = ((size.x / width) as usize + 1, (size.y / width) as usize + 1);
        let nobody = Seen {
            at: Vec2::ZERO,
            velocity: Vec2::ZERO,
            direction: Vec2::ZERO,
            person: 0,
            breadth: 0.0,
            depth: 0.0,
        };
        let mut cells = Cells {
            low,
            width,
            columns,
            rows,
            starts: vec![0; columns * rows + 1],
            seen: vec![nobody; there().count()],
            faces: vec![Vec::new(); columns * rows],
            fastest: there().map(|walking| walking.velocity.norm()).fold(0.0, f64::max),
            eighths: there()
                .filter_map(|walking| walking.direction)
                .fold(0, |all, way| all | 1 << eighth(way)),
        };
        let index = |at: Vec2, cells: &Cells| {
            let (column, row) = cells.cell(at);
            row * columns + column
        };
        for walking in there() {
            let k = index(walking.at, &cells);
            cells.starts[k + 1] += 1;
        }
        for k in 0..columns * rows {
            cells.starts[k + 1] += cells.starts[k];
        }
        let mut next = cells.starts.clone();
        for (person, walking) in people.iter().enumerate() {
            let Some(walking) = walking else { continue };
            let k = index(walking.at, &cells);
            let direction = walking.direction.unwrap_or(Vec2::ZERO);
            let Walking { at, velocity, breadth, depth, .. } = *walking;
            cells.seen[next[k] as usize] = Seen { at, velocity, direction, person, breadth, depth };
            next[k] += 1;
        }
        let reach = SIGHT / width;
        let span = |a: f64, b: f64, count: usize| {
            let (first, last) = (a.min(b) / width - reach, a.max(b) / width + reach);
            (first.max(0.0) as usize).min(count)..((last + 1.0).max(0.0) as usize).min(count)
        };
        for &face in faces {
            let [a, b] = face.map(|end| end - low);
            for y in span(a.y, b.y, rows) {
                for x in span(a.x, b.x, columns) {
                    let k = y * columns + x;
                    let middle = vec2((x as f64 + 0.5) * width, (y as f64 + 0.5) * width);
                    let far = || (nearest_on_segment(a, b, middle) - middle).norm();
                    if cells.starts[k] < cells.starts[k + 1] && far() < SIGHT + 0.75 * width {
                        cells.faces[k].push(face);
                    }
                }
            }
        }
        cells
    }

    fn cell(&self, at: Vec2) -> (usize, usize) {
        let of = |x: f64, count: usize| ((x / self.width) as usize).min(count - 1);
        (of(at.x - self.low.x, self.columns), of(at.y - self.low.y, self.rows))
    }

    /// Returns whether anybody may go against a direction.
    fn opposing(&self, direction: Vec2) -> bool {
        let own = eighth(direction);
        (2..=6).any(|turn| self.eighths & 1 << ((own + turn) % 8) != 0)
    }

    /// Visits those in the cells whose distance from a cell is `ring`, in the same order on every machine.
    fn ring(&self, (column, row): (usize, usize), ring: usize, mut visit: impl FnMut(&Seen)) {
        let range = |middle: usize, count: usize| middle.saturating_sub(ring)..(middle + ring + 1).min(count);
        let columns = range(column, self.columns);
        let mut cells = |row: usize, columns: std::ops::Range<usize>| {
            let first = row * self.columns;
            let (from, to) = (self.starts[first + columns.start], self.starts[first + columns.end]);
            self.seen[from as usize..to as usize].iter().for_each(&mut visit);
        };
        for y in range(row, self.rows) {
            if y.abs_diff(row) == ring {
                cells(y, columns.clone());
                continue;
            }
            if column >= ring {
                cells(y, column - ring..column - ring + 1);
            }
            if column + ring < self.columns {
                cells(y, column + ring..column + ring + 1);
            }
        }
    }
}

/// Returns the eighth of the circle in which a direction lies, from 0 to 7.
fn eighth(direction: Vec2) -> u32 {
    let Vec2 { x, y } = direction;
    let second = (x < 0.0) != (y < 0.0);
    u32::from(y < 0.0) << 2 | u32::from(second) << 1 | u32::from((x.abs() < y.abs()) != second)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stuck::draw;

    fn person(at: Vec2, velocity: Vec2, direction: Vec2) -> Walking<'static> {
        Walking {
            at,
            velocity,
            theta: 0.0,
            disks: &[],
            direction: Some(direction),
            speed: 1.34,
            to_go: 10.0 - at.x,
            destination: 0,
            relaxation: 0.22,
            time_gap: 0.85,
            standstill_gap: 0.09,
            steering: 0.0,
            noise: 0.0,
            phase: 0.0,
            breadth: 0.48,
            depth: 0.25,
            stuck: false,
        }
    }

    /// Returns the speeds along x of people in a row who all walk at one speed, each a headway behind the next.
    fn row(headway: f64, speed: f64) -> f64 {
        let velocity = vec2(speed, 0.0);
        let people = [0.0, headway].map(|x| Some(person(vec2(x, 0.0), velocity, vec2(1.0, 0.0))));
        desired(&Rotational::default(), &people, &[])[0].velocity.x
    }

    #[test]
    fn the_speed_behind_somebody_is_the_gap_by_the_time_gap() {
        for headway in [0.5, 0.7, 1.0, 1.3] {
            let speed = (headway - 0.3 - 0.09) / 0.85;
            assert!((row(headway, speed) - speed).abs() < 1e-12, "{headway}");
        }
        assert!((row(5.0, 1.34) - 1.34).abs() < 1e-12);
        // Pushes are limited: 4 m/s² for 0.22 s.
        assert!((row(5.0, 0.0) - 0.88).abs() < 1e-12);
    }

    #[test]
    fn neither_the_grid_nor_the_order_of_people_nor_the_side_counts() {
        let share = |count| (draw(5, 0, count) >> 11) as f64 / (1u64 << 53) as f64;
        let mut count = 0;
        let mut next = || {
            count += 1;
            share(count)
        };
        let crowd: Vec<Walking<'_>> = (0..300)
            .map(|k| {
                let at = vec2(12.0 * next(), 8.0 * next());
                let way = vec2(if k % 3 == 0 { -1.0 } else { 1.0 }, next() - 0.5).unit(0.0).unwrap();
                Walking { phase: 0.0, ..person(at, way * next(), way) }
            })
            .collect();
        let walls = [[vec2(0.0, -0.2), vec2(12.0, -0.2)], [vec2(5.0, 3.0), vec2(6.0, 5.0)]];
        let model = Rotational::default();
        let of = |people: &[Walking<'_>], walls: &[[Vec2; 2]]| {
            let people: Vec<_> = people.iter().copied().map(Some).collect();
            desired(&model, &people, walls)
        };
        let near = |a: &DesiredMotion, b: &DesiredMotion, sign: f64| {
            let facing = (a.facing.unwrap(), b.facing.unwrap());
            (a.velocity.x - b.velocity.x).abs() < 1e-9
                && (a.velocity.y - sign * b.velocity.y).abs() < 1e-9
                && (facing.0.y - sign * facing.1.y).abs() < 1e-6
                && (a.steering - sign * b.steering).abs() < 1e-9
        };
        let plain = of(&crowd, &walls);
        let moved = |by: Vec2| {
            let people: Vec<_> = crowd.iter().map(|one| Walking { at: one.at + by, ..*one }).collect();
            of(&people, &walls.map(|wall| wall.map(|end| end + by)))
        };
        // Somebody far away makes the cells others.
        let mut others = crowd.clone();
        others.reverse();
        others.push(person(vec2(-7.13, -9.31), Vec2::ZERO, vec2(1.0, 0.0)));
        let other = of(&others, &walls);
        let mirror = |at: Vec2| vec2(at.x, -at.y);
        let mirrored: Vec<_> = crowd
            .iter()
            .map(|one| Walking {
                at: mirror(one.at),
                velocity: mirror(one.velocity),
                direction: one.direction.map(mirror),
                ..*one
            })
            .collect();
        let mirrored = of(&mirrored, &walls.map(|wall| wall.map(mirror)));
        let by = moved(vec2(0.37, -41.0));
        for (k, one) in plain.iter().enumerate() {
            assert!(near(one, &by[k], 1.0) && near(one, &other[crowd.len() - 1 - k], 1.0), "{k}");
            // Whether the left or the right foot comes first is not mirrored.
            assert!(crowd[k].velocity.norm() < SWAY.2 || near(one, &mirrored[k], -1.0), "{k}");
        }
    }
}
