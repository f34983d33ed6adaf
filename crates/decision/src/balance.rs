//! Balance of people who stand: legs under the body, whatever model they walk by.
//!
//! A person stands who does not want to go anywhere, and keeps on standing until the balance is regained. Of those who
//! stand, only the ground acts on the body, by a model of balance. Who walks has the legs under the body, and walks as
//! without legs.

mod pendulum;
mod two_level;

pub use pendulum::Pendulum;
pub use two_level::TwoLevel;

use crate::error::PlanError;
use lemons_core::plane::{InPlane, Vec2};
use serde::{Deserialize, Serialize};

/// \[m/s\] Speed up to which somebody stands who wants to go no faster.
pub const STILL: f64 = 0.1;

/// A model of balance with its constants.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum BalanceModel {
    /// See [`Pendulum`].
    Pendulum(Pendulum),
    /// See [`TwoLevel`].
    TwoLevel(TwoLevel),
}

/// OwnMotion of a person, as the own legs feel it.
#[derive(Debug, Clone, Copy)]
pub struct OwnMotion {
    /// \[m\] centre of mass.
    pub at: Vec2,
    /// \[m/s\]
    pub velocity: Vec2,
    /// \[1/s\] 1/t_transl: the rate with which the mechanics takes the velocity.
    pub damping: f64,
    /// \[m\]
    pub stature: f64,
    /// \[m/s²\] Force with which the person leans on who is in front, over the mass.
    pub lean: Vec2,
    /// Whether legs can step to keep the balance: not on stairs.
    pub steps: bool,
}

/// Legs of a person, during the simulation and in a saved state.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Legs {
    /// State of who stands, not of who walks.
    pub stands: bool,
    /// \[m\] Middle of the feet.
    pub at: Vec2,
    /// \[m/s\] Velocity of the feet; of the pendulum, that of the body at the next communication point if only the ground acts.
    velocity: Vec2,
    /// \[m/s²\] Load that the pendulum has noticed, over the mass.
    load: Vec2,
    /// \[m\] Own place, and the place to which the person walks back.
    home: Vec2,
    aim: Vec2,
    /// \[s\] Time until the feet stand elsewhere, if a step has begun.
    step: Option<f64>,
    /// \[s\] Time for which the person has stood still, or walked back.
    calm: f64,
    /// Number of steps to keep the balance.
    pub steps: u32,
    /// State of somebody who could not be saved, at some time.
    pub fallen: bool,
}

impl Legs {
    /// Makes legs at rest under a body \[m\].
    pub fn new(at: Vec2, stands: bool) -> Legs {
        Legs { stands, at, home: at, aim: at, ..Legs::default() }
    }

    /// Returns the same legs under a body, moving with it.
    pub(crate) fn under(&self, motion: &OwnMotion, stands: bool) -> Legs {
        let Legs { steps, fallen, .. } = *self;
        Legs { steps, fallen, velocity: motion.velocity, ..Legs::new(motion.at, stands) }
    }

    /// Returns whether all numbers are possible.
    pub fn is_sound(&self) -> bool {
        let places = [self.at, self.velocity, self.load, self.home, self.aim];
        let time = |time: f64| time.is_finite() && time >= 0.0;
        places.iter().all(|place| place.is_finite()) && time(self.calm) && self.step.is_none_or(time)
    }
}

impl BalanceModel {
    pub(crate) fn check(&self) -> Result<(), PlanError> {
        match self {
            BalanceModel::Pendulum(of) => of.check(),
            BalanceModel::TwoLevel(of) => of.check(),
        }
    }

    /// Returns whether the person needs no step.
    pub fn is_balanced(&self, legs: &Legs, motion: &OwnMotion) -> bool {
        match self {
            BalanceModel::Pendulum(of) => of.is_balanced(legs, motion),
            BalanceModel::TwoLevel(of) => of.is_balanced(legs, motion),
        }
    }

    /// Returns legs of somebody who wants to go somewhere, or does not. Who wants to stop stands from when the ankles can
    /// stop the body; who wants to start starts from balance.
    pub fn decided(&self, legs: Legs, motion: &OwnMotion, wants: bool) -> Legs {
        let stops = || match self {
            BalanceModel::Pendulum(of) => of.stops(motion),
            BalanceModel::TwoLevel(of) => of.stops(motion),
        };
        let changes =
            if wants { legs.stands && self.is_balanced(&legs, motion) } else { !legs.stands && stops() };
        if changes { legs.under(motion, !wants) } else { legs }
    }

    /// Returns whether somebody has fallen, and stays on the ground.
    pub fn lies(&self, legs: &Legs) -> bool {
        matches!(self, BalanceModel::Pendulum(of) if of.lies(legs))
    }

    /// \[s\] Returns the longest communication step with which the model is near to what it says, for people whose ground
    /// takes velocities with at most a rate \[1/s\].
    pub fn longest_step(&self, damping: f64) -> f64 {
        let own = match self {
            BalanceModel::Pendulum(of) => {
                (0.25 * of.step_time).clamp(0.005, 0.02).min(0.12 / of.damping.max(1e-9))
            }
            BalanceModel::TwoLevel(_) => 0.02,
        };
        own.min(0.1 / damping.max(1e-9))
    }

    /// \[m/s²\] Returns the acceleration of the drive of somebody who stands, in addition to eq. 1's relaxation.
    pub fn drive(&self, legs: &Legs, motion: &OwnMotion) -> Vec2 {
        match self {
            BalanceModel::Pendulum(of) => of.drive(legs, motion),
            BalanceModel::TwoLevel(of) => of.drive(legs, motion),
        }
    }

    /// Moves the legs of everybody who stands by a step of time \[s\]; `None` is who is not there. Of walls, the faces.
    pub fn pass(&self, people: &mut [Option<(Legs, OwnMotion)>], faces: &[[Vec2; 2]], step: f64) {
        for (legs, motion) in people.iter_mut().flatten().filter(|(legs, _)| !legs.stands) {
            *legs = legs.under(motion, false);
        }
        match self {
            BalanceModel::Pendulum(of) => {
                let feet: Vec<Vec2> = people.iter().flatten().map(|(legs, _)| legs.at).collect();
                let around = pendulum::Around { faces, feet: &feet };
                for (legs, motion) in people.iter_mut().flatten().filter(|(legs, _)| legs.stands) {
                    of.pass(legs, motion, around, step);
                }
            }
            BalanceModel::TwoLevel(of) => of.pass(people, faces, step),
        }
    }
}

/// Returns a vector, made shorter if it is longer than this.
fn at_most(vector: Vec2, length: f64) -> Vec2 {
    vector * (length / vector.norm().max(1e-12)).min(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn legs_with_impossible_numbers_are_known() {
        let forgeries: [fn(&mut Legs); 8] = [
            |legs| legs.at.y = f64::NAN,
            |legs| legs.velocity.x = f64::INFINITY,
            |legs| legs.load.y = f64::NAN,
            |legs| legs.home.x = f64::NAN,
            |legs| legs.aim.y = f64::NAN,
            |legs| legs.step = Some(-1.0),
            |legs| legs.step = Some(f64::NAN),
            |legs| legs.calm = -1.0,
        ];
        assert!(Legs::default().is_sound());
        for forge in forgeries {
            let mut legs = Legs::default();
            forge(&mut legs);
            assert!(!legs.is_sound(), "{legs:?}");
        }
    }
}
