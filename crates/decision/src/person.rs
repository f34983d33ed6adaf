//! The people of a Trial, as far as they decide.

use crate::rule::Pose;
use lemons_core::trial::Trial;

/// The data of an agent of a Trial that are needed here.
#[derive(Debug, Clone, PartialEq)]
pub struct Person {
    /// Id in Agents.xml.
    pub id: String,
    /// \[kg\] mass.
    pub mass: f64,
    /// \[kg.m2\] moment of inertia.
    pub moment_of_inertia: f64,
    /// \[m\] stature, if it is known.
    pub stature: Option<f64>,
    /// \[1/s\] inverse relaxation time of the velocity, 1/t_transl.
    pub floor_damping: f64,
    /// \[1/s\] inverse relaxation time of the angular velocity, 1/t_rot.
    pub angular_damping: f64,
    /// Pose at the start.
    pub pose: Pose,
    /// Disks relative to the centre of mass when the gaze is along x: x, y, radius \[m\].
    pub disks: Vec<[f64; 3]>,
}

impl Person {
    /// The agents of a Trial.
    pub fn all_of(trial: &Trial) -> Vec<Person> {
        let agents = trial.agents.iter().zip(&trial.dynamics);
        agents
            .map(|(agent, dynamics)| Person {
                id: agent.id.clone(),
                mass: agent.mass,
                stature: agent.height,
                moment_of_inertia: agent.moment_of_inertia,
                floor_damping: agent.floor_damping,
                angular_damping: agent.angular_damping,
                pose: Pose { x: dynamics.position.x, y: dynamics.position.y, theta: dynamics.theta },
                disks: agent.disks_facing_x().iter().map(|(at, radius)| [at.x, at.y, *radius]).collect(),
            })
            .collect()
    }
}
