//! How people walk among others: from where they want to go to a velocity, or a force.
//!
//! - straight: the desired speed, whoever is in the way (the paper's eq. 4).
//! - collision-free speed: Tordeux, Chraibi, Seyfried, *Collision-free speed model for pedestrian dynamics*, 2016
//!   (arXiv 1512.05597): people turn aside, and are so fast that they would reach the one in front of them only after
//!   the time gap. The defaults are those of JuPedSim 1.4.
//! - social force: Helbing, Farkas, Vicsek, *Simulating dynamical features of escape panic*, Nature 407 (2000) 487,
//!   without its contact forces, which the mechanics computes.
//!
//! Instead of circles of one radius, each body has its own outline: gaps are measured between outlines on the line of
//! the centres of mass. Somebody is in front of a person if the shadows of their outlines on a line across the way overlap
//! by more than a third.

mod rotational;

pub use rotational::Rotational;

use crate::cells::{Cells, nearest_points, sees};
use crate::error::{PlanError, moderate, not_negative, positive};
use lemons_core::plane::{InPlane, Vec2, rotation, vec2};
use serde::{Deserialize, Serialize};

/// Constants of the collision-free speed model.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct CollisionFreeSpeed {
    /// \[s\] Time gap T to who is in front.
    pub time_gap: f64,
    /// Strength a of turning aside from others.
    pub neighbour_strength: f64,
    /// \[m\] Its range D.
    pub neighbour_range: f64,
    /// Strength of turning aside from walls.
    pub wall_strength: f64,
    /// \[m\] Its range.
    pub wall_range: f64,
}

impl Default for CollisionFreeSpeed {
    fn default() -> CollisionFreeSpeed {
        CollisionFreeSpeed {
            time_gap: 1.0,
            neighbour_strength: 8.0,
            neighbour_range: 0.1,
            wall_strength: 5.0,
            wall_range: 0.02,
        }
    }
}

/// Constants of the social force model.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SocialForce {
    /// \[N\] Repulsion A at a gap of 0, by others and by walls.
    pub strength: f64,
    /// \[m\] Its range B.
    pub range: f64,
}

impl Default for SocialForce {
    fn default() -> SocialForce {
        SocialForce { strength: 2000.0, range: 0.08 }
    }
}

/// A model with its constants.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum WalkingModel {
    /// Straight on.
    #[default]
    Straight,
    /// See [`CollisionFreeSpeed`].
    CollisionFreeSpeed(CollisionFreeSpeed),
    /// See [`SocialForce`].
    SocialForce(SocialForce),
    /// See [`Rotational`].
    Rotational(Rotational),
}

/// Somebody who walks, and where to.
#[derive(Debug, Clone, Copy)]
pub struct Walking<'a> {
    /// \[m\] centre of mass.
    pub at: Vec2,
    /// \[m/s\] velocity.
    pub velocity: Vec2,
    /// \[rad\] orientation.
    pub theta: f64,
    /// Disks relative to the centre of mass when the gaze is along x: x, y, radius \[m\].
    pub disks: &'a [[f64; 3]],
    /// Unit vector of the direction, if there is one.
    pub direction: Option<Vec2>,
    /// \[m/s\] desired speed.
    pub speed: f64,
    /// Part of swaying and of noise: below 1 of who is slow also when nobody is in the way.
    pub pace: f64,
    /// \[m\] How far it is.
    pub to_go: f64,
    /// People with the same destination have the same number.
    pub destination: usize,
    /// \[m\] next way-point, if there is one.
    pub waypoint: Option<Vec2>,
    /// \[s\] relaxation time of the velocity.
    pub relaxation: f64,
    /// \[s\] time gap to who is ahead.
    pub time_gap: f64,
    /// \[m\] gap to who is ahead when standing.
    pub standstill_gap: f64,
    /// \[s\] reaction time to gaps that change.
    pub reaction_time: f64,
    /// \[rad\] angle from the way to the direction of walking, or only of the gaze.
    pub steering: f64,
    /// \[m/s\] noise of the speed.
    pub noise: f64,
    /// \[m\] breadth of the body across the gaze.
    pub breadth: f64,
    /// \[m\] depth of the body along the gaze.
    pub depth: f64,
    /// \[rad\] phase of swaying from one foot to the other.
    pub phase: f64,
    /// Whether the person does not get on.
    pub stuck: bool,
}

/// Motion that a person wants.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct DesiredMotion {
    /// \[m/s\] velocity.
    pub velocity: Vec2,
    /// \[m/s\] Speed along the way, without swaying and noise.
    pub speed: f64,
    /// \[N\] force besides that for the velocity.
    pub force: Vec2,
    /// Unit vector towards which the body turns, if it turns.
    pub facing: Option<Vec2>,
    /// Whether the person queues: close behind somebody who is nearer to the end of the way.
    pub queues: bool,
    /// \[rad\] Angle from the way to which the direction of walking, or only of the gaze, relaxes.
    pub steering: f64,
}

/// \[m\] Radius of a body whose outline is not known.
const USUAL_RADIUS: f64 = 0.2;
/// Ranges: from a gap of so many on, repulsion is not counted. It is below 1e-5 of that at a gap of 0.
const FAR: f64 = 12.0;
/// Part of two bodies' breadth: whoever is further to the side is not in front. The paper's width of 0.3 m is that of
/// bodies 0.46 m broad: people walk in lanes that overlap, like the teeth of a zipper.
const LANE: f64 = 0.65;
/// \[m\] Who is nearer than this behind somebody may queue.
const CLOSE: f64 = 0.5;
/// \[m/s\] Slower people face the way, faster ones the direction in which they walk.
const FACING: f64 = 0.5;
/// \[m\] Gaps are not longer than this in any exponential.
const TOUCHING: f64 = 0.0;

impl WalkingModel {
    /// \[s\] Returns the time gap of those who have none of their own.
    pub(crate) fn time_gap(&self) -> f64 {
        match self {
            WalkingModel::CollisionFreeSpeed(of) => of.time_gap,
            WalkingModel::Rotational(of) => of.time_gap,
            WalkingModel::Straight | WalkingModel::SocialForce(_) => 1.0,
        }
    }

    /// \[m\] Returns the gap at a standstill of those who have none of their own.
    pub(crate) fn standstill_gap(&self) -> f64 {
        if let WalkingModel::Rotational(of) = self { of.standstill_gap } else { 0.0 }
    }

    /// \[s\] Returns the reaction time of those who have none of their own.
    pub(crate) fn reaction_time(&self) -> f64 {
        if let WalkingModel::Rotational(of) = self { of.reaction_time } else { 0.0 }
    }

    /// \[m/s\] Returns the standard deviation of the noise of speeds.
    pub(crate) fn speed_noise(&self) -> f64 {
        if let WalkingModel::Rotational(of) = self { of.speed_noise } else { 0.0 }
    }

    /// Returns whether people see others and walls.
    pub fn sees_others(&self) -> bool {
        *self != WalkingModel::Straight
    }

    /// Refuses constants that make no sense.
    pub(crate) fn check(&self) -> Result<(), PlanError> {
        match self {
            WalkingModel::Straight => Ok(()),
            WalkingModel::CollisionFreeSpeed(of) => {
                let place = "collision-free-speed";
                positive(place, "time_gap", of.time_gap)?;
                moderate(place, "neighbour_strength", of.neighbour_strength)?;
                positive(place, "neighbour_range", of.neighbour_range)?;
                moderate(place, "wall_strength", of.wall_strength)?;
                positive(place, "wall_range", of.wall_range)
            }
            WalkingModel::Rotational(of) => {
                positive("rotational", "time_gap", of.time_gap)?;
                not_negative("rotational", "standstill_gap", of.standstill_gap)?;
                not_negative("rotational", "reaction_time", of.reaction_time)?;
                positive("rotational", "acceleration", of.acceleration)?;
                moderate("rotational", "speed_noise", of.speed_noise)
            }
            WalkingModel::SocialForce(of) => {
                moderate("social-force", "strength", of.strength)?;
                positive("social-force", "range", of.range)
            }
        }
    }

    /// Returns what everybody wants; `None` for those who are not there, whom nobody sees.
    pub fn desired(&self, people: &[Option<Walking<'_>>], faces: &[[Vec2; 2]]) -> Vec<DesiredMotion> {
        let furthest = people.iter().flatten().map(|walking| extent(walking)).fold(0.0, f64::max);
        let fastest = people.iter().flatten().map(|walking| walking.speed).fold(0.0, f64::max);
        let far = match self {
            WalkingModel::Straight => {
                let wanted = |walking: &Option<Walking<'_>>| walking.as_ref().map(straight);
                return people.iter().map(|walking| wanted(walking).unwrap_or_default()).collect();
            }
            WalkingModel::CollisionFreeSpeed(of) => {
                let ranges = FAR * of.neighbour_range.max(of.wall_range);
                let longest = people.iter().flatten().map(|walking| walking.time_gap).fold(0.0, f64::max);
                ranges.max(fastest * longest).max(CLOSE)
            }
            WalkingModel::SocialForce(of) => CLOSE.max(FAR * of.range),
            WalkingModel::Rotational(of) => return rotational::desired(of, people, faces),
        };
        let sight = 2.0 * furthest + far;
        let cells = Cells::new(people, |walking| walking.at, faces, (sight, sight), |i, _| i);
        let one = |(i, walking): (usize, &Option<Walking<'_>>)| {
            let Some(walking) = walking else { return DesiredMotion::default() };
            let (others, walls) = around(i, walking, people, &cells, sight);
            match self {
                WalkingModel::Straight | WalkingModel::Rotational(_) => straight(walking),
                WalkingModel::CollisionFreeSpeed(of) => of.desired(walking, &others, &walls),
                WalkingModel::SocialForce(of) => of.desired(walking, &others, &walls),
            }
        };
        people.iter().enumerate().map(one).collect()
    }
}

/// Returns the unit vector towards which somebody turns who wants this velocity on the way to a goal.
fn facing(goal: Vec2, velocity: Vec2) -> Vec2 {
    (goal * FACING + velocity).unit(1e-9).unwrap_or(goal)
}

fn straight(walking: &Walking<'_>) -> DesiredMotion {
    let velocity = walking.direction.map_or(Vec2::zeros(), |direction| direction * walking.speed);
    DesiredMotion { velocity, speed: velocity.norm(), facing: walking.direction, ..DesiredMotion::default() }
}

/// Somebody or a wall near a person.
struct Near<'a> {
    /// Unit vector from it to the person.
    away: Vec2,
    /// \[m\] Distance of the centres of mass, or from the wall's nearest point.
    distance: f64,
    /// \[m\] Gap between the outlines on this line; negative if they overlap.
    gap: f64,
    /// Person; `None` for a wall.
    other: Option<&'a Walking<'a>>,
}

/// Returns the part of a repulsion that acts over a gap.
fn faded(gap: f64, range: f64) -> f64 {
    // Bodies that touch repel each other by the mechanics.
    if gap < FAR * range { libm::exp(-gap.max(TOUCHING) / range) } else { 0.0 }
}

/// Returns the sum of the repulsions by others or walls.
fn repulsion<'a>(near: impl IntoIterator<Item = &'a Near<'a>>, strength: f64, range: f64) -> Vec2 {
    let all = near.into_iter().map(|near| near.away * (strength * faded(near.gap, range)));
    all.fold(Vec2::zeros(), |sum, force| sum + force)
}

/// Returns those who are in front of a person who walks in a direction.
fn in_front<'a>(
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
fn queues(walking: &Walking<'_>, direction: Vec2, others: &[Near<'_>]) -> bool {
    in_front(walking, direction, others).any(|(near, other)| {
        let goes = other.direction.is_some() && other.destination == walking.destination;
        near.gap < CLOSE && goes && other.to_go < walking.to_go
    })
}

impl CollisionFreeSpeed {
    fn desired(&self, walking: &Walking<'_>, others: &[Near<'_>], walls: &[Near<'_>]) -> DesiredMotion {
        let Some(goal) = walking.direction else { return DesiredMotion::default() };
        let turned = goal
            + repulsion(others, self.neighbour_strength, self.neighbour_range)
            + repulsion(walls, self.wall_strength, self.wall_range);
        let direction = turned.unit(1e-9).unwrap_or(goal);
        let headway =
            in_front(walking, direction, others).map(|(near, _)| near.gap).fold(f64::INFINITY, f64::min);
        let speed = (headway / walking.time_gap).clamp(0.0, walking.speed);
        let queues = queues(walking, goal, others);
        let facing = facing(goal, direction * speed);
        DesiredMotion {
            velocity: direction * speed,
            speed,
            // The direction may jump from one side to the other: nobody spins with it.
            facing: Some(rotation(walking.steering) * goal),
            queues,
            steering: libm::atan2(goal.perp(&facing), goal.dot(&facing)),
            ..DesiredMotion::default()
        }
    }
}

impl SocialForce {
    fn desired(&self, walking: &Walking<'_>, others: &[Near<'_>], walls: &[Near<'_>]) -> DesiredMotion {
        let force = repulsion(others.iter().chain(walls), self.strength, self.range);
        let queues = walking.direction.is_some_and(|goal| queues(walking, goal, others));
        DesiredMotion { force, queues, ..straight(walking) }
    }
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
