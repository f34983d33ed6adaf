//! How people walk among others: from where they want to go to a velocity, or a force.
//!
//! A model is a file beside this one and a row of `with_models!`.

mod collision_free_speed;
mod near;
mod rotational;
mod social_force;
mod straight;

pub use collision_free_speed::CollisionFreeSpeed;
pub use rotational::Rotational;
pub use social_force::SocialForce;
pub use straight::Straight;

use crate::error::PlanError;
use lemons_core::plane::Vec2;
use lemons_core::trial::Rule;
use serde::{Deserialize, Serialize};
use std::ops::Deref;

/// A model of walking, with its constants.
pub trait Walk {
    /// Refuses constants that make no sense.
    ///
    /// # Errors
    /// One of them.
    fn check(&self) -> Result<(), PlanError>;

    /// \[s\] Returns the time gap of those who have none of their own.
    fn time_gap(&self) -> f64 {
        1.0
    }

    /// \[m\] Returns the gap at a standstill of those who have none of their own.
    fn standstill_gap(&self) -> f64 {
        0.0
    }

    /// \[s\] Returns the reaction time of those who have none of their own.
    fn reaction_time(&self) -> f64 {
        0.0
    }

    /// \[m/s\] Returns the standard deviation of the noise of speeds.
    fn speed_noise(&self) -> f64 {
        0.0
    }

    /// Returns whether people see others and walls.
    fn sees_others(&self) -> bool {
        true
    }

    /// Returns whether people turn their shoulders in narrow places.
    fn turns_shoulders(&self) -> bool {
        false
    }

    /// Returns the rules that warn of the model where it is known to fail: where people leave, and where many walk
    /// against each other.
    fn unfit(&self) -> [Option<Rule>; 2];

    /// Returns what everybody wants; `None` for those who are not there, whom nobody sees.
    fn desired(&self, people: &[Option<Walking<'_>>], faces: &[[Vec2; 2]]) -> Vec<DesiredMotion>;
}

/// Gives a macro the models: name, word in a `decision.toml`, and the field of
/// [`DecisionConfig`](crate::config::DecisionConfig) for its constants, if it has some.
macro_rules! with_models {
    ($make:ident) => {
        $make! {
            Rotational = "rotational", rotational;
            CollisionFreeSpeed = "collision-free-speed", collision_free_speed;
            SocialForce = "social-force", social_force;
            #[default]
            Straight = "straight";
        }
    };
}
pub(crate) use with_models;

macro_rules! models {
    ($($(#[$usual:meta])? $name:ident = $word:literal $(, $constants:ident)?;)*) => {
        /// Name of a model of how people walk among others.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
        #[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
        pub enum WalkingModelName {
            $(
                #[doc = concat!("See [`", stringify!($name), "`].")]
                #[serde(rename = $word)]
                $(#[$usual])?
                $name,
            )*
        }

        impl WalkingModelName {
            /// All of them.
            pub const ALL: &[WalkingModelName] = &[$(WalkingModelName::$name),*];

            /// Returns its word in a `decision.toml`.
            pub fn name(self) -> &'static str {
                match self { $(WalkingModelName::$name => $word),* }
            }
        }

        /// A model with its constants, as which it is written.
        #[derive(Debug, Clone, Copy, PartialEq, Serialize)]
        #[serde(untagged)]
        pub enum WalkingModel {
            $(#[doc = concat!("See [`", stringify!($name), "`].")] $name($name),)*
        }

        impl Deref for WalkingModel {
            type Target = dyn Walk;

            fn deref(&self) -> &(dyn Walk + 'static) {
                match self { $(WalkingModel::$name(of) => of),* }
            }
        }

        impl WalkingModel {
            /// Returns a model with its usual constants.
            pub fn usual(name: WalkingModelName) -> WalkingModel {
                match name { $(WalkingModelName::$name => WalkingModel::$name($name::default())),* }
            }

            /// Returns its name.
            pub fn name(&self) -> WalkingModelName {
                match self { $(WalkingModel::$name(_) => WalkingModelName::$name),* }
            }
        }
    };
}

with_models!(models);

/// Ranges: from a gap of so many on, repulsion is not counted. It is below 1e-5 of that at a gap of 0.
const FAR: f64 = 12.0;
/// \[m\] Who is nearer than this behind somebody may queue.
const CLOSE: f64 = 0.5;

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
