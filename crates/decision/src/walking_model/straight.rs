//! Straight on, whoever is in the way: the paper's eq. 4.

use super::{DesiredMotion, Walk, Walking};
use crate::error::PlanError;
use lemons_core::plane::Vec2;
use lemons_core::trial::Rule;
use serde::Serialize;

/// The model, which has no constants.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct Straight;

impl Walk for Straight {
    fn check(&self) -> Result<(), PlanError> {
        Ok(())
    }

    fn sees_others(&self) -> bool {
        false
    }

    fn unfit(&self) -> [Option<Rule>; 2] {
        [Some(Rule::StraightLeaves), Some(Rule::StraightMeets)]
    }

    fn desired(&self, people: &[Option<Walking<'_>>], _: &[[Vec2; 2]]) -> Vec<DesiredMotion> {
        people.iter().map(|walking| walking.as_ref().map(straight).unwrap_or_default()).collect()
    }
}

pub(super) fn straight(walking: &Walking<'_>) -> DesiredMotion {
    let velocity = walking.direction.map_or(Vec2::zeros(), |direction| direction * walking.speed);
    DesiredMotion { velocity, speed: velocity.norm(), facing: walking.direction, ..DesiredMotion::default() }
}
