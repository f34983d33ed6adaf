//! The rotational collision-free speed model with anticipation.
//!
//! - Steering: a person turns away from the one who counts most ahead, as in the third version of JuPedSim's
//!   collision-free speed model. The angle relaxes.
//! - Spacing: the speed is that at which the gap to those ahead lasts for the time gap T (Tordeux, Chraibi, Seyfried
//!   2016). The gap is what it will be when the body has followed: its relaxation time times the rate of the gap is added.
//! - Oncoming people: both step aside from where the other will be (Xu et al., *Anticipation velocity model*,
//!   Transp. Res. C 133 (2021) 103464).
//! - Narrow places: who does not fit through facing ahead turns the shoulders.
//!
//! People are seen as circles of one radius here; their bodies touch in the mechanics.

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
        Rotational { time_gap: 0.85, standstill_gap: 0.0, speed_noise: 0.0, acceleration: 2.5 }
    }
}

/// \[m\] Radius of a person for the others.
const RADIUS: f64 = 0.15;
/// Repulsion of walls, and its range \[m\].
const WALL: (f64, f64) = (5.0, 0.02);
/// \[m\] Ranges along and across the way in which those ahead count for steering.
const AHEAD: f64 = 2.0;
const ACROSS: f64 = 0.8;
/// \[rad\] Largest steering angle.
const LARGEST_ANGLE: f64 = 1.57;
/// \[m\] Offset to the side from which on the angle is nearly the largest.
const OFFSET: f64 = 0.05;
/// Part of the spacing that is taken along the direction of walking; the rest is taken along the way.
const ALONG: f64 = 0.85;
/// \[m/s\] Speed backwards of those who are too close.
const BACK: f64 = 0.01;
/// Strength of stepping aside from oncoming people, its range \[m\], and the time \[s\] that is anticipated.
const ASIDE: (f64, f64, f64) = (8.0, 0.1, 1.0);
/// \[m\] Room that shoulders want beside them.
const ROOM: f64 = 0.1;
/// \[m\] How far ahead a narrow place is seen.
const LOOK: f64 = 0.35;
/// Number of angles that are tried for shoulders.
const TURNS: u32 = 16;
/// \[m\] How far people see others.
const SIGHT: f64 = 4.0;
/// \[m\] Width of the cells in which neighbours are looked for.
const CELL: f64 = 0.8;
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
    breadth: f64,
}

/// Returns what everybody wants.
pub(super) fn desired(model: &Rotational, people: &[Option<Walking<'_>>], faces: &[[Vec2; 2]]) -> Vec<DesiredMotion> {
    let cells = Cells::new(people, faces);
    let one = |(i, walking): (usize, &Option<Walking<'_>>)| match walking {
        Some(walking) => of_one(model, i, walking, people, &cells, faces),
        None => DesiredMotion::default(),
    };
    people.iter().enumerate().map(one).collect()
}

fn of_one(
    model: &Rotational,
    i: usize,
    walking: &Walking<'_>,
    people: &[Option<Walking<'_>>],
    cells: &Cells,
    faces: &[[Vec2; 2]],
) -> DesiredMotion {
    let Some(goal) = walking.direction else { return DesiredMotion::default() };
    let (at, cell) = (walking.at, cells.cell(walking.at));
    let near_faces = cells.faces[cell.1 * cells.columns + cell.0].iter().map(|&k| faces[k as usize]);
    let near_faces: &[[Vec2; 2]] = &near_faces.collect::<Vec<_>>();
    let reference = (goal + walls(at, near_faces)).unit(1e-9).unwrap_or(goal);
    let direction = reference.rotated(Rotation::by(walking.steering));

    let [here, soon] = passage(at, goal, near_faces);
    let (passage, long) = (here.min(soon), here.max(soon));
    let mut leader = (f64::INFINITY, 0.0);
    let mut gaps = [f64::INFINITY; 2];
    let mut aside = Vec2::ZERO;
    let mut queues = false;
    let hidden = |other: Vec2| near_faces.iter().any(|&[a, b]| segments_cross(at, other, a, b));
    // Beyond this gap nobody changes the speed.
    let free = walking.speed * walking.time_gap + walking.standstill_gap;
    for ring in 0..=(SIGHT / CELL).ceil() as usize {
        // Nobody in this ring is nearer than this.
        let nearest = (ring as f64 - 1.0).max(0.0) * CELL;
        let complete = leader.0 * ACROSS < nearest && leader.0 * AHEAD < nearest;
        let all =
            !complete || gaps.iter().any(|gap| gap + 2.0 * RADIUS > nearest - 1.0) && nearest < free + 1.5;
        cells.ring(cell, ring, |other: &Seen| {
            if other.person == i {
                return;
            }
            let to = other.at - at;
            let square = to.dot(to);
            let ahead = reference.dot(to);
            if square > SIGHT * SIGHT || square == 0.0 {
                return;
            }
            let oncoming = other.direction.dot(goal) < 0.0;
            if !all && !oncoming {
                return;
            }
            let side = reference.cross(to);
            let mut visible = None;
            let mut is_visible = || *visible.get_or_insert_with(|| !hidden(other.at));
            if ahead > 0.0 && !oncoming {
                let far = ahead / AHEAD + side.abs() / ACROSS;
                if far < leader.0 && is_visible() {
                    leader = (far, side);
                }
            }
            let distance = square.sqrt();
            let unit = to * (1.0 / distance);
            let approach = (walking.velocity - other.velocity).dot(unit);
            let change = if approach < 0.0 { env(6, walking.relaxation) } else { walking.relaxation } * approach;
            // Where two do not fit side by side, one goes after the other.
            let both = walking.breadth + other.breadth;
            let single = long < (both + ROOM) * env(0, 1.0);
            let half = if single { 0.5 * both } else { 2.0 * RADIUS };
            for (k, along) in [direction, goal].into_iter().enumerate() {
                let lane = along.cross(to).abs() <= half && along.dot(to) > 0.0;
                let far = if single { along.dot(to) } else { distance };
                let gap = far - 2.0 * RADIUS - change;
                if lane && gap < gaps[k] && is_visible() {
                    gaps[k] = gap;
                }
                if k == 1 && lane && distance < CLOSE + 2.0 * RADIUS && !queues && is_visible() {
                    queues = single && !oncoming || people[other.person].as_ref().is_some_and(|other| {
                        other.direction.is_some()
                            && other.destination == walking.destination
                            && other.to_go < walking.to_go
                    });
                }
            }
            if oncoming && goal.dot(to) > 0.0 {
                let (strength, range, time) = ASIDE;
                let gap = (distance - 2.0 * RADIUS - time * approach).max(0.0);
                if gap < FAR * range && is_visible() {
                    let across = goal.perp();
                    let later = across.dot(to + other.velocity * time);
                    let away = if later > 0.0 { across * -1.0 } else { across };
                    let weight = 1.0 + 0.5 * (1.0 - goal.dot(other.direction));
                    aside = aside + away * (strength * weight * libm::exp(-gap / range));
                }
            }
        });
    }

    let turned = (reference + aside).unit(1e-9).unwrap_or(reference);
    let mut steering = libm::atan2(reference.cross(turned), reference.dot(turned));
    if leader.0.is_finite() && long >= 2.0 * walking.breadth * env(0, 1.0) {
        let (weight, side) = (libm::exp(-leader.0), leader.1);
        steering += LARGEST_ANGLE * libm::tanh(-weight * side / (side.abs() + OFFSET));
    }
    let [along, on_the_way] = gaps.map(|gap| gap.min(free * env(4, 1.0)));
    let spacing = ALONG * along + (1.0 - ALONG) * on_the_way;
    let wanted = (spacing - walking.standstill_gap) / walking.time_gap + walking.noise;
    let speed = wanted.clamp(-BACK, walking.speed);
    let change = direction * speed - walking.velocity;
    let most = model.acceleration * walking.relaxation / change.norm().max(1e-9);
    let velocity = walking.velocity + change * most.min(1.0);
    let slow = (1.0 - walking.velocity.norm() / env(3, 0.5)).max(0.0);
    let velocity = velocity + goal.perp() * (slow * env(1, 0.0) * libm::sin(walking.phase));
    let facing = shoulders(walking, goal, passage).unwrap_or((goal * env(5, 0.5) + direction * speed).unit(1e-9).unwrap_or(goal));
    let facing = facing.rotated(Rotation::by(slow * env(2, 0.0) * libm::cos(walking.phase)));
    DesiredMotion {
        velocity,
        force: Vec2::ZERO,
        facing: Some(facing),
        queues,
        steering: steering.clamp(-LARGEST_ANGLE, LARGEST_ANGLE),
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
            sum = sum + (at - place) * (WALL.0 * libm::exp((RADIUS - distance) / WALL.1) / distance);
        }
    }
    sum
}

/// \[m\] Returns the free width across the way, here or a little ahead; infinite if there is not a wall on either side.
fn passage(at: Vec2, goal: Vec2, faces: &[[Vec2; 2]]) -> [f64; 2] {
    let across = goal.perp();
    let width = |at: Vec2| {
        let mut sides = [f64::INFINITY; 2];
        for &[a, b] in faces {
            let (from, to) = ((a - at).dot(goal), (b - at).dot(goal));
            if (from > 0.0) == (to > 0.0) {
                continue;
            }
            let offset = (a + (b - a) * (from / (from - to)) - at).dot(across);
            let side = usize::from(offset > 0.0);
            sides[side] = sides[side].min(offset.abs());
        }
        sides[0] + sides[1]
    };
    [width(at), width(at + goal * LOOK)]
}

/// Returns the direction of the gaze where the shoulders do not fit through facing ahead: turned to the nearer side.
fn shoulders(walking: &Walking<'_>, goal: Vec2, passage: f64) -> Option<Vec2> {
    let narrow = passage - ROOM;
    if narrow >= walking.breadth {
        return None;
    }
    // The outline across the way of somebody who has turned by an angle.
    let breadth = |angle: f64| {
        let turn = Rotation::by(angle);
        let edges = walking.disks.iter().map(|&[x, y, radius]| {
            let offset = vec2(x, y).rotated(turn).y;
            [offset - radius, offset + radius]
        });
        let [low, high] = edges
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], [a, b]| [low.min(a), high.max(b)]);
        high - low
    };
    let angle = if walking.stuck {
        FRAC_PI_2
    } else {
        let turns = (0..TURNS).map(|k| FRAC_PI_2 * f64::from(k) / f64::from(TURNS));
        turns.into_iter().find(|&angle| breadth(angle) <= narrow).unwrap_or(FRAC_PI_2)
    };
    if angle == 0.0 {
        return None;
    }
    let gaze = vec2(1.0, 0.0).rotated(Rotation::by(walking.theta));
    let turned = [angle, -angle].map(|angle| goal.rotated(Rotation::by(angle)));
    Some(if turned[0].dot(gaze) >= turned[1].dot(gaze) { turned[0] } else { turned[1] })
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
    faces: Vec<Vec<u32>>,
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
        let columns = (size.x / width) as usize + 1;
        let rows = (size.y / width) as usize + 1;
        let mut cells = Cells {
            low,
            width,
            columns,
            rows,
            starts: vec![0; columns * rows + 1],
            seen: Vec::new(),
            faces: vec![],
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
        let nobody = Seen { at: Vec2::ZERO, velocity: Vec2::ZERO, direction: Vec2::ZERO, person: 0, breadth: 0.0 };
        cells.seen = vec![nobody; there().count()];
        let mut next = cells.starts.clone();
        for (person, walking) in people.iter().enumerate() {
            let Some(walking) = walking else { continue };
            let k = index(walking.at, &cells);
            let direction = walking.direction.unwrap_or(Vec2::ZERO);
            let Walking { at, velocity, breadth, .. } = *walking;
            cells.seen[next[k] as usize] = Seen { at, velocity, direction, person, breadth };
            next[k] += 1;
        }
        cells.faces = vec![Vec::new(); columns * rows];
        for (n, face) in faces.iter().enumerate() {
            let reach = SIGHT;
            let column = |x: f64| (x - low.x) / width;
            let row = |y: f64| (y - low.y) / width;
            let span = |a: f64, b: f64, count: usize| {
                let (first, last) = (a.min(b) - reach / width, a.max(b) + reach / width);
                (first.max(0.0) as usize).min(count)..((last + 1.0).max(0.0) as usize).min(count)
            };
            for y in span(row(face[0].y), row(face[1].y), rows) {
                for x in span(column(face[0].x), column(face[1].x), columns) {
                    let k = y * columns + x;
                    if cells.starts[k] < cells.starts[k + 1] {
                        let middle = low + vec2((x as f64 + 0.5) * width, (y as f64 + 0.5) * width);
                        if (nearest_on_segment(face[0], face[1], middle) - middle).norm()
                            < reach + 0.75 * width
                        {
                            cells.faces[k].push(n as u32);
                        }
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

    /// Visits those in the cells whose distance from a cell is `ring`, in the same order on every machine.
    fn ring(&self, (column, row): (usize, usize), ring: usize, mut visit: impl FnMut(&Seen)) {
        let range = |middle: usize, count: usize| middle.saturating_sub(ring)..(middle + ring + 1).min(count);
        for y in range(row, self.rows) {
            let edge = y.abs_diff(row) == ring;
            for x in range(column, self.columns) {
                if edge || x.abs_diff(column) == ring {
                    let k = y * self.columns + x;
                    self.seen[self.starts[k] as usize..self.starts[k + 1] as usize].iter().for_each(&mut visit);
                }
            }
        }
    }
}

fn env(k: usize, other: f64) -> f64 {
    static X: std::sync::OnceLock<Vec<f64>> = std::sync::OnceLock::new();
    let x = X.get_or_init(|| std::env::var("XX").unwrap_or_default().split(',').map(|w| w.parse().unwrap_or(f64::NAN)).collect());
    x.get(k).copied().filter(|v| v.is_finite()).unwrap_or(other)
}
