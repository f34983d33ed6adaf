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
use lemons_core::plane::Vec2;
use serde::{Deserialize, Serialize};

/// \[m/s\] Who wants to go no faster stands.
pub const STILL: f64 = 0.1;

/// A model of balance with its constants.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Balance {
    /// See [`Pendulum`].
    Pendulum(Pendulum),
    /// See [`TwoLevel`].
    TwoLevel(TwoLevel),
}

/// Motion of a person, as the own legs feel it.
#[derive(Debug, Clone, Copy)]
pub struct Motion {
    /// \[m\] centre of mass.
    pub at: Vec2,
    /// \[m/s\]
    pub velocity: Vec2,
    /// \[1/s\] 1/t_transl: the rate with which the ground takes the velocity of who keeps the balance.
    pub damping: f64,
    /// \[m\]
    pub stature: f64,
}

/// Legs of a person, during the simulation and in a saved state.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Legs {
    /// Whether the person stands.
    pub stands: bool,
    /// \[m\] Middle of the feet.
    pub at: Vec2,
    /// \[m/s\] Velocity of the feet.
    velocity: Vec2,
    /// \[m\] Own place, and the place to which the person walks back.
    home: Vec2,
    aim: Vec2,
    /// \[s\] Time until the feet stand elsewhere, if a step has begun.
    step: Option<f64>,
    /// \[s\] For how long the person has stood still, or walked back.
    calm: f64,
    /// Number of steps to keep the balance.
    pub steps: u32,
    /// Whether no step could save the person, at some time.
    pub fallen: bool,
}

impl Legs {
    /// Makes legs of somebody who is here \[m\].
    pub fn new(at: Vec2, stands: bool) -> Legs {
        Legs {
            stands,
            at,
            velocity: Vec2::ZERO,
            home: at,
            aim: at,
            step: None,
            calm: 0.0,
            steps: 0,
            fallen: false,
        }
    }

    /// Returns the same legs under a body \[m\].
    pub fn under(&self, at: Vec2, stands: bool) -> Legs {
        Legs { steps: self.steps, fallen: self.fallen, ..Legs::new(at, stands) }
    }

    /// Returns whether a model can have left such legs.
    pub fn is_sound(&self) -> bool {
        let places = [self.at, self.velocity, self.home, self.aim];
        let time = |time: f64| time.is_finite() && time >= 0.0;
        places.iter().all(|place| place.is_finite()) && time(self.calm) && self.step.is_none_or(time)
    }
}

impl Balance {
    pub(crate) fn check(&self) -> Result<(), PlanError> {
        match self {
            Balance::Pendulum(of) => of.check(),
            Balance::TwoLevel(of) => of.check(),
        }
    }

    /// Returns whether the person needs no step.
    pub fn is_balanced(&self, legs: &Legs, motion: &Motion) -> bool {
        match self {
            Balance::Pendulum(of) => of.is_balanced(legs, motion),
            Balance::TwoLevel(of) => of.is_balanced(legs, motion),
        }
    }

    /// Returns legs of somebody who wants to go somewhere, or does not. Who wants to stop stands from when the ankles can
    /// stop the body; who wants to start starts from balance.
    pub fn decided(&self, legs: Legs, motion: &Motion, wants: bool) -> Legs {
        let stops = || match self {
            Balance::Pendulum(of) => of.stops(motion),
            Balance::TwoLevel(_) => true,
        };
        let changes =
            if wants { legs.stands && self.is_balanced(&legs, motion) } else { !legs.stands && stops() };
        if changes { legs.under(motion.at, !wants) } else { legs }
    }

    /// \[m/s²\] Returns the acceleration of the drive of somebody who stands, in addition to eq. 1's relaxation.
    pub fn drive(&self, legs: &Legs, motion: &Motion) -> Vec2 {
        match self {
            Balance::Pendulum(of) => of.drive(legs, motion),
            Balance::TwoLevel(of) => of.drive(legs, motion),
        }
    }

    /// Moves the legs of everybody who stands by a step of time \[s\]; `None` is who is not there. Of walls, the faces.
    pub fn pass(&self, people: &mut [Option<(Legs, Motion)>], faces: &[[Vec2; 2]], step: f64) {
        match self {
            Balance::Pendulum(of) => {
                for (legs, motion) in people.iter_mut().flatten().filter(|(legs, _)| legs.stands) {
                    of.pass(legs, motion, step);
                }
            }
            Balance::TwoLevel(of) => of.pass(people, faces, step),
        }
        for (legs, motion) in people.iter_mut().flatten().filter(|(legs, _)| !legs.stands) {
            *legs = legs.under(motion.at, false);
        }
    }
}

/// Returns a vector, made shorter if it is longer than this.
fn at_most(vector: Vec2, length: f64) -> Vec2 {
    vector * (length / vector.norm().max(1e-12)).min(1.0)
}
