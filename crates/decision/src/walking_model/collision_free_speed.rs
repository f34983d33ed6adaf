//! The collision-free speed model: Tordeux, Chraibi, Seyfried, *Collision-free speed model for pedestrian dynamics*, 2016
//! (arXiv 1512.05597).
//!
//! People turn aside, and are so fast that they would reach the one in front of them only after the time gap. The
//! defaults are those of JuPedSim 1.4.

use super::near::{self, Near, facing, in_front, queues, repulsion};
use super::{CLOSE, DesiredMotion, FAR, Walk, Walking};
use crate::error::{PlanError, moderate, positive};
use lemons_core::plane::{InPlane, Vec2, rotation};
use lemons_core::trial::Rule;
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

impl Walk for CollisionFreeSpeed {
    fn check(&self) -> Result<(), PlanError> {
        let place = "collision-free-speed";
        positive(place, "time_gap", self.time_gap)?;
        moderate(place, "neighbour_strength", self.neighbour_strength)?;
        positive(place, "neighbour_range", self.neighbour_range)?;
        moderate(place, "wall_strength", self.wall_strength)?;
        positive(place, "wall_range", self.wall_range)
    }

    fn time_gap(&self) -> f64 {
        self.time_gap
    }

    fn unfit(&self) -> [Option<Rule>; 2] {
        [Some(Rule::SpeedLeaves), Some(Rule::SpeedMeets)]
    }

    fn desired(&self, people: &[Option<Walking<'_>>], faces: &[[Vec2; 2]]) -> Vec<DesiredMotion> {
        let fastest = people.iter().flatten().map(|walking| walking.speed).fold(0.0, f64::max);
        let longest = people.iter().flatten().map(|walking| walking.time_gap).fold(0.0, f64::max);
        let ranges = FAR * self.neighbour_range.max(self.wall_range);
        let far = ranges.max(fastest * longest).max(CLOSE);
        near::desired(people, faces, far, |walking, others, walls| self.of_one(walking, others, walls))
    }
}

impl CollisionFreeSpeed {
    fn of_one(&self, walking: &Walking<'_>, others: &[Near<'_>], walls: &[Near<'_>]) -> DesiredMotion {
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
