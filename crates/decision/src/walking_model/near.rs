//! Those who are near somebody, and walls, as models without anticipation see them.
//!
//! Instead of circles of one radius, each body has its own outline: gaps are measured between outlines on the line of
//! the centres of mass. Somebody is in front of a person if the shadows of their outlines on a line across the way overlap
//! by more than a third.

use super::{CLOSE, DesiredMotion, FAR, Walking};
use crate::cells::{Cells, nearest_points, sees};
use lemons_core::plane::{InPlane, Vec2, rotation, vec2};

/// \[m\] Radius of a body whose outline is not known.
const USUAL_RADIUS: f64 = 0.2;
/// Part of two bodies' breadth: whoever is further to the side is not in front. The paper's width of 0.3 m is that of
/// bodies 0.46 m broad: people walk in lanes that overlap, like the teeth of a zipper.
const LANE: f64 = 0.65;
/// \[m\] Gaps are not longer than this in any exponential.
const TOUCHING: f64 = 0.0;

/// \[m/s\] Slower people face the way, faster ones the direction in which they walk.
const FACING: f64 = 0.5;

/// Returns the unit vector towards which somebody turns who wants this velocity on the way to a goal.
pub(super) fn facing(goal: Vec2, velocity: Vec2) -> Vec2 {
    (goal * FACING + velocity).unit(1e-9).unwrap_or(goal)
}

/// Returns what everybody wants who sees others and walls nearer than `far` \[m\] to the own body.
pub(super) fn desired(
    people: &[Option<Walking<'_>>],
    faces: &[[Vec2; 2]],
    far: f64,
    one: impl Fn(&Walking<'_>, &[Near<'_>], &[Near<'_>]) -> DesiredMotion,
) -> Vec<DesiredMotion> {
    let furthest = people.iter().flatten().map(|walking| extent(walking)).fold(0.0, f64::max);
    let sight = 2.0 * furthest + far;
    let cells = Cells::new(people, |walking| walking.at, faces, (sight, sight), |i, _| i);
    let of = |(i, walking): (usize, &Option<Walking<'_>>)| {
        let Some(walking) = walking else { return DesiredMotion::default() };
        let (others, walls) = around(i, walking, people, &cells, sight);
        one(walking, &others, &walls)
    };
    people.iter().enumerate().map(of).collect()
}

/// Somebody or a wall near a person.
pub(super) struct Near<'a> {
    /// Unit vector from it to the person.
    pub(super) away: Vec2,
    /// \[m\] Distance of the centres of mass, or from the wall's nearest point.
    pub(super) distance: f64,
    /// \[m\] Gap between the outlines on this line; negative if they overlap.
    pub(super) gap: f64,
    /// Person; `None` for a wall.
    pub(super) other: Option<&'a Walking<'a>>,
}

/// Returns the part of a repulsion that acts over a gap.
pub(super) fn faded(gap: f64, range: f64) -> f64 {
    // Bodies that touch repel each other by the mechanics.
    if gap < FAR * range { libm::exp(-gap.max(TOUCHING) / range) } else { 0.0 }
}

/// Returns the sum of the repulsions by others or walls.
pub(super) fn repulsion<'a>(near: impl IntoIterator<Item = &'a Near<'a>>, strength: f64, range: f64) -> Vec2 {
    let all = near.into_iter().map(|near| near.away * (strength * faded(near.gap, range)));
    all.fold(Vec2::zeros(), |sum, force| sum + force)
}

/// Returns those who are in front of a person who walks in a direction.
pub(super) fn in_front<'a>(
    walking: &Walking<'_>,
    direction: Vec2,
    others: &'a [Near<'a>],
) -> impl Iterator<Item = (&'a Near<'a>, &'a Walking<'a>)> {
    let (across, own) = (direction.left(), half_width(walking, direction.left()));
    let known = others.iter().filter_map(|near| Some((near, near.other?)));
    known.filter(move |(near, other)| {
        let to = near.away * -near.distance;
        direction.dot(&to) > 0.0 && across.dot(&to).abs() < LANE * (own + half_width(other, across))
    })
}

/// Returns whether one of those in front is close, goes to the same place, and has a shorter way.
pub(super) fn queues(walking: &Walking<'_>, direction: Vec2, others: &[Near<'_>]) -> bool {
    in_front(walking, direction, others).any(|(near, other)| {
        let goes = other.direction.is_some() && other.destination == walking.destination;
        near.gap < CLOSE && goes && other.to_go < walking.to_go
    })
}

/// \[m\] How far the outline reaches from the centre of mass in a direction.
fn reach(walking: &Walking<'_>, direction: Vec2) -> f64 {
    if walking.disks.is_empty() {
        return USUAL_RADIUS;
    }
    let own = rotation(-walking.theta) * direction;
    let far = walking.disks.iter().filter_map(|&[x, y, radius]| {
        let (along, off) = (own.dot(&vec2(x, y)), own.perp(&vec2(x, y)));
        (off.abs() < radius).then(|| along + (radius * radius - off * off).sqrt())
    });
    far.fold(0.0, f64::max)
}

/// \[m\] Half of the outline's shadow on a line with this direction.
fn half_width(walking: &Walking<'_>, line: Vec2) -> f64 {
    if walking.disks.is_empty() {
        return USUAL_RADIUS;
    }
    let own = rotation(-walking.theta) * line;
    let ends = walking.disks.iter().map(|&[x, y, radius]| (own.dot(&vec2(x, y)), radius));
    ends.map(|(middle, radius)| middle.abs() + radius).fold(0.0, f64::max)
}

/// \[m\] Radius of a circle about the centre of mass that holds the body.
fn extent(walking: &Walking<'_>) -> f64 {
    let ends = walking.disks.iter().map(|&[x, y, radius]| libm::hypot(x, y) + radius);
    ends.fold(USUAL_RADIUS, f64::max)
}

/// Returns others and walls nearer than `reach` \[m\], in the same order on every machine.
fn around<'a>(
    i: usize,
    walking: &Walking<'_>,
    people: &'a [Option<Walking<'a>>],
    cells: &Cells<usize>,
    sight: f64,
) -> (Vec<Near<'a>>, Vec<Near<'a>>) {
    let cell = cells.cell(walking.at);
    let faces = cells.faces(cell);
    let mut others = Vec::new();
    cells.block(cell, 1, |&k| {
        let Some(other) = people[k].as_ref().filter(|_| k != i) else { return };
        let apart = walking.at - other.at;
        let distance = apart.norm();
        if distance < sight && distance > 0.0 && sees(walking.at, other.at, faces) {
            let away = apart * (1.0 / distance);
            let gap = distance - reach(walking, -away) - reach(other, away);
            others.push(Near { away, distance, gap, other: Some(other) });
        }
    });
    let walls = nearest_points(walking.at, faces, sight).filter_map(|(point, distance)| {
        let apart = walking.at - point;
        let away = apart * (1.0 / distance);
        let gap = distance - reach(walking, -away);
        sees(walking.at, point + apart * 1e-6, faces).then_some(Near { away, distance, gap, other: None })
    });
    (others, walls.collect())
}
