//! People who wait press those in front of them: a queue that pushes.
//!
//! Who wants to get on, is slow, and touches somebody or a wall ahead leans on it. The force is the person's own: drawn from
//! a distribution, and drawn anew slowly. It is at most what feet hold: m g s/l, where the support s is the greatest distance
//! of the ground's force from the middle of the feet, and l the height of the centre of mass, as of a
//! [`Pendulum`].
//!
//! That somebody leans and lets go within tens of seconds is an assumption, and so are all values of the force:
//! docs/walking.md shows what follows from them.

use crate::balance::Pendulum;
use crate::error::{PlanError, number};
use crate::spread::Spread;
use crate::stuck::normal;
use crate::walking_model::Walking;
use lemons_core::plane::{Vec2, nearest_on_segment, rotation, vec2};
use serde::{Deserialize, Serialize};

/// \[m\] Outlines that are nearer than this touch: a person does not let go between two small bounces.
pub(crate) const TOUCHING: f64 = 0.01;
/// Cosine of the greatest angle between the way and somebody ahead: 60°.
const AHEAD: f64 = 0.5;
/// \[m/s\] Speed along the way from which on nobody leans; below, the force falls with the speed in a line.
const WALKING: f64 = 0.3;
/// Draws of a person that are those of the force.
const DRAWS: u64 = u64::MAX / 16;

/// How people who wait press those in front.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct QueueConfig {
    /// \[N\] Force with which who waits leans on who is in front.
    pub push: Spread,
    /// \[s\] Time after which the force of a person is another one, if it is drawn.
    pub push_time: f64,
}

impl Default for QueueConfig {
    fn default() -> QueueConfig {
        QueueConfig { push: Spread::Same(0.0), push_time: 20.0 }
    }
}

impl QueueConfig {
    pub(crate) fn check(&self) -> Result<(), PlanError> {
        self.push.check("queue.push")?;
        let time = |time: f64| (0.1..=1e6).contains(&time);
        number("queue", "push_time", self.push_time, time, "from 0.1 to 1e6 s")
    }

    /// Returns whether nobody ever leans.
    pub(crate) fn is_idle(&self) -> bool {
        self.push == Spread::Same(0.0)
    }

    /// \[N\] Returns the force of somebody who leans with all of it.
    pub(crate) fn force(&self, state: &QueueState) -> f64 {
        self.push.at(0.5 * libm::erfc(-state.drift * std::f64::consts::FRAC_1_SQRT_2))
    }
}

/// Force of a person, during the simulation and in a saved state.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct QueueState {
    /// Standard normal number whose quantile the force is.
    drift: f64,
    /// How many numbers were drawn.
    draws: u64,
}

impl QueueState {
    /// Makes the state of a person at the start.
    pub(crate) fn new(seed: u64, person: u64) -> QueueState {
        QueueState { drift: normal(seed, person, DRAWS), draws: 1 }
    }

    /// Lets a step \[s\] pass: an Ornstein-Uhlenbeck process of unit variance.
    pub(crate) fn pass(&mut self, queue: &QueueConfig, step: f64, seed: u64, person: u64) {
        if let Spread::Drawn(_) = queue.push {
            let kept = libm::exp(-step / queue.push_time);
            let drawn = normal(seed, person, DRAWS + self.draws);
            self.drift = kept * self.drift + (1.0 - kept * kept).sqrt() * drawn;
            self.draws += 1;
        }
    }

    /// Returns whether the numbers are possible.
    pub(crate) fn is_sound(&self) -> bool {
        self.drift.is_finite() && self.draws < DRAWS
    }
}

/// How somebody leans on who is in front.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Lean {
    /// Unit vector.
    pub direction: Vec2,
    /// \[N\] Force of who does not move.
    pub force: f64,
    /// Part from 0 to 1 of who moves slowly.
    pub part: f64,
}

/// \[N\] Returns what feet of somebody hold for long.
pub(crate) fn feet_hold(pendulum: &Pendulum, mass: f64, stature: f64) -> f64 {
    mass * pendulum.stiffness(stature) * pendulum.support
}

/// Returns the part of the own force with which somebody leans who goes in a direction: 0 for who walks, or touches nobody
/// ahead. `others` and walls, as segments, are those nearby.
pub(crate) fn part<'a>(
    walking: &Walking<'_>,
    mut others: impl Iterator<Item = &'a Walking<'a>>,
    faces: &[[Vec2; 2]],
) -> f64 {
    let Some(direction) = walking.direction else { return 0.0 };
    let part = 1.0 - walking.velocity.dot(&direction) / WALKING;
    if part <= 0.0 {
        return 0.0;
    }
    let ahead = |to: Vec2| direction.dot(&to) > AHEAD * to.norm();
    let own = disks(walking);
    let touches = |other: &Walking<'_>| {
        ahead(other.at - walking.at)
            && disks(other).any(|(at, radius)| {
                own.clone().any(|(own, reach)| (at - own).norm() < radius + reach + TOUCHING)
            })
    };
    let touches_wall = |face: &[Vec2; 2]| {
        own.clone().any(|(own, reach)| {
            let nearest = nearest_on_segment(face[0], face[1], own);
            (nearest - own).norm() < reach + TOUCHING && ahead(nearest - walking.at)
        })
    };
    let leans = others.any(touches) || faces.iter().any(touches_wall);
    if leans { part.min(1.0) } else { 0.0 }
}

/// Centres and radii of somebody's disks \[m\].
fn disks<'a>(walking: &'a Walking<'_>) -> impl Iterator<Item = (Vec2, f64)> + Clone + 'a {
    let turned = rotation(walking.theta);
    walking.disks.iter().map(move |&[x, y, radius]| (walking.at + turned * vec2(x, y), radius))
}
