//! The social force model: Helbing, Farkas, Vicsek, *Simulating dynamical features of escape panic*, Nature 407 (2000)
//! 487, without its contact forces, which the mechanics computes.

use super::near::{self, Near, queues, repulsion};
use super::straight::straight;
use super::{CLOSE, DesiredMotion, FAR, Walk, Walking};
use crate::error::{PlanError, moderate, positive};
use lemons_core::plane::Vec2;
use lemons_core::trial::Rule;
use serde::{Deserialize, Serialize};

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

impl Walk for SocialForce {
    fn check(&self) -> Result<(), PlanError> {
        moderate("social-force", "strength", self.strength)?;
        positive("social-force", "range", self.range)
    }

    fn unfit(&self) -> [Option<Rule>; 2] {
        [Some(Rule::ForceLeaves), Some(Rule::ForceMeets)]
    }

    fn desired(&self, people: &[Option<Walking<'_>>], faces: &[[Vec2; 2]]) -> Vec<DesiredMotion> {
        let far = CLOSE.max(FAR * self.range);
        near::desired(people, faces, far, |walking, others, walls| self.of_one(walking, others, walls))
    }
}

impl SocialForce {
    fn of_one(&self, walking: &Walking<'_>, others: &[Near<'_>], walls: &[Near<'_>]) -> DesiredMotion {
        let force = repulsion(others.iter().chain(walls), self.strength, self.range);
        let queues = walking.direction.is_some_and(|goal| queues(walking, goal, others));
        DesiredMotion { force, queues, ..straight(walking) }
    }
}
