//! The data before the start: a user's wishes, and the plan for the people of a Trial that follows from them.
//!
//! Both are TOML. Wishes give way-points and speeds, for all agents or for some agents by their Id:
//!
//! ```toml
//! desired_speed = 1.34                               # [m/s]
//! waypoints = [{ x = 6.0, y = 2.5, radius = 0.45 }, { x = 20.0, y = 2.5 }]   # [m]; radius 0.3 if it is not said
//!
//! [agents.7]
//! desired_speed = 0.9
//! ```
//!
//! A plan (`decision.toml` in the FMU's resources) gives everything for each agent.

use crate::rule::{Pose, Walker, Waypoint};
use lemons_files::words;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use thiserror::Error;

/// \[m\] Radius of a way-point that gives none.
const DEFAULT_RADIUS: f64 = 0.3;
/// \[m/s\] Mean speed of pedestrians who walk freely (Weidmann 1993).
const DEFAULT_SPEED: f64 = 1.34;

/// What is wrong with wishes or a plan. The messages do not name the file.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[allow(missing_docs)] // the messages say it
pub enum PlanError {
    #[error("{0}")]
    Toml(String),
    #[error("{place}: {key} = {value}: must be {must}")]
    Value { place: String, key: &'static str, value: String, must: &'static str },
    #[error("agents.{0}: there is no agent with this Id")]
    UnknownAgent(String),
    #[error("agent {0:?} has no way-point: give `waypoints` for all agents, or in [agents.{0}]")]
    NoWaypoint(String),
    #[error("there are no agents")]
    Empty,
}

/// A user's settings for the FMU.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Wishes {
    desired_speed: Option<f64>,
    waypoints: Option<Vec<WantedWaypoint>>,
    #[serde(default)]
    agents: BTreeMap<String, Wish>,
}

/// Settings of one agent; missing ones are those of all agents.
#[derive(Debug, Clone, PartialEq, Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct Wish {
    desired_speed: Option<f64>,
    waypoints: Option<Vec<WantedWaypoint>>,
}

#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
struct WantedWaypoint {
    x: f64,
    y: f64,
    radius: Option<f64>,
}

impl Wishes {
    /// Reads TOML.
    ///
    /// # Errors
    /// The text is not TOML, or has unknown keys or values of the wrong type; with line and column.
    pub fn from_toml(text: &str) -> Result<Wishes, PlanError> {
        toml::from_str(text).map_err(|error| PlanError::Toml(explained(&error)))
    }
}

/// Returns the message, with a suggestion for an unknown key.
fn explained(error: &toml::de::Error) -> String {
    // The keys are between backticks: first the unknown one, then the expected ones.
    let said = error.to_string();
    let mut expected = error.message().split('`').skip(1).step_by(2);
    let unknown = expected.next().filter(|_| error.message().starts_with("unknown field"));
    match unknown.and_then(|unknown| words::meant(unknown, expected)) {
        Some(meant) => format!("{}\ndid you mean `{meant}`?", said.trim_end()),
        None => said,
    }
}

/// The data of an agent of a Trial that are needed here.
#[derive(Debug, Clone, PartialEq)]
pub struct Person {
    /// Id in Agents.xml.
    pub id: String,
    /// \[kg\] mass.
    pub mass: f64,
    /// \[kg.m2\] moment of inertia.
    pub moment_of_inertia: f64,
    /// \[1/s\] inverse relaxation time of the velocity, 1/t_transl.
    pub floor_damping: f64,
    /// \[1/s\] inverse relaxation time of the angular velocity, 1/t_rot.
    pub angular_damping: f64,
    /// Pose at the start.
    pub pose: Pose,
}

/// An agent of a plan.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Planned {
    /// Id in Agents.xml.
    pub id: String,
    /// Start values of the inputs.
    pub pose: Pose,
    /// The data for the rule.
    pub walker: Walker,
}

/// The initial data of the FMU.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Plan {
    /// \[s\] `DefaultExperiment.stepSize`
    pub time_step: f64,
    /// In the order of Agents.xml; at least one.
    pub agents: Vec<Planned>,
}

impl Plan {
    /// Makes a plan from wishes for these people.
    ///
    /// # Errors
    /// There is a wish for an unknown agent, an agent without way-points, or a number out of range.
    pub fn new(people: &[Person], wishes: &Wishes, time_step: f64) -> Result<Plan, PlanError> {
        if let Some(unknown) = wishes.agents.keys().find(|id| people.iter().all(|person| person.id != **id)) {
            return Err(PlanError::UnknownAgent(unknown.clone()));
        }
        let nothing = Wish::default();
        let agents = people.iter().map(|person| {
            let own = wishes.agents.get(&person.id).unwrap_or(&nothing);
            let waypoints = own.waypoints.as_ref().or(wishes.waypoints.as_ref());
            let waypoints = waypoints.filter(|waypoints| !waypoints.is_empty());
            let waypoints = waypoints.ok_or_else(|| PlanError::NoWaypoint(person.id.clone()))?;
            Ok(Planned {
                id: person.id.clone(),
                pose: person.pose,
                walker: Walker {
                    mass: person.mass,
                    moment_of_inertia: person.moment_of_inertia,
                    floor_damping: person.floor_damping,
                    angular_damping: person.angular_damping,
                    desired_speed: own.desired_speed.or(wishes.desired_speed).unwrap_or(DEFAULT_SPEED),
                    waypoints: waypoints
                        .iter()
                        .map(|w| Waypoint { x: w.x, y: w.y, radius: w.radius.unwrap_or(DEFAULT_RADIUS) })
                        .collect(),
                },
            })
        });
        Plan { time_step, agents: agents.collect::<Result<_, PlanError>>()? }.checked()
    }

    /// Reads TOML.
    ///
    /// # Errors
    /// Those of [`Wishes::from_toml`], or numbers out of range.
    pub fn from_toml(text: &str) -> Result<Plan, PlanError> {
        toml::from_str::<Plan>(text).map_err(|error| PlanError::Toml(error.to_string()))?.checked()
    }

    /// Returns TOML. Every number is read back as the same double.
    ///
    /// # Errors
    /// The plan cannot be written.
    pub fn to_toml(&self) -> Result<String, PlanError> {
        toml::to_string(self).map_err(|error| PlanError::Toml(error.to_string()))
    }

    fn checked(self) -> Result<Plan, PlanError> {
        if self.agents.is_empty() {
            return Err(PlanError::Empty);
        }
        positive("the plan", "time_step", self.time_step)?;
        for agent in &self.agents {
            let (place, walker, pose) = (format!("agent {:?}", agent.id), &agent.walker, &agent.pose);
            positive(&place, "mass", walker.mass)?;
            positive(&place, "moment_of_inertia", walker.moment_of_inertia)?;
            not_negative(&place, "floor_damping", walker.floor_damping)?;
            not_negative(&place, "angular_damping", walker.angular_damping)?;
            not_negative(&place, "desired_speed", walker.desired_speed)?;
            for (key, value) in [("x", pose.x), ("y", pose.y), ("theta", pose.theta)] {
                number(&place, key, value, |_| true, "finite")?;
            }
            for (k, waypoint) in walker.waypoints.iter().enumerate() {
                let place = format!("{place}, way-point {k}");
                number(&place, "x", waypoint.x, |_| true, "finite")?;
                number(&place, "y", waypoint.y, |_| true, "finite")?;
                not_negative(&place, "radius", waypoint.radius)?;
            }
        }
        Ok(self)
    }
}

fn number(
    place: &str,
    key: &'static str,
    value: f64,
    good: impl Fn(f64) -> bool,
    must: &'static str,
) -> Result<(), PlanError> {
    if value.is_finite() && good(value) {
        return Ok(());
    }
    Err(PlanError::Value { place: place.to_owned(), key, value: format!("{value:?}"), must })
}

fn positive(place: &str, key: &'static str, value: f64) -> Result<(), PlanError> {
    number(place, key, value, |value| value > 0.0, "positive and finite")
}

fn not_negative(place: &str, key: &'static str, value: f64) -> Result<(), PlanError> {
    number(place, key, value, |value| value >= 0.0, "finite and at least 0")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn person(id: &str) -> Person {
        Person {
            id: id.into(),
            mass: 70.1,
            moment_of_inertia: 1.0 / 3.0,
            floor_damping: 2.0,
            angular_damping: 0.1,
            pose: Pose { x: 1e-300, y: -0.0, theta: 3.0 },
        }
    }

    fn plan(wishes: &str) -> Result<Plan, String> {
        let wishes = Wishes::from_toml(wishes).map_err(|error| error.to_string())?;
        Plan::new(&[person("0"), person("two words")], &wishes, 0.05).map_err(|error| error.to_string())
    }

    #[test]
    fn wishes_are_for_everybody_or_for_one() {
        let plan = plan(
            "desired_speed = 1\nwaypoints = [{ x = 1, y = 2.5 }]\n[agents.\"two words\"]\nwaypoints = [{ x = 0, y = 0, radius = 2 }, { x = 3, y = 4 }]",
        )
        .unwrap();
        let walkers = [&plan.agents[0].walker, &plan.agents[1].walker];
        assert_eq!(walkers[0].waypoints, [Waypoint { x: 1.0, y: 2.5, radius: DEFAULT_RADIUS }]);
        assert_eq!(walkers[1].waypoints.len(), 2);
        assert_eq!(walkers[1].waypoints[0].radius, 2.0);
        assert_eq!(walkers.map(|walker| walker.desired_speed), [1.0, 1.0]);
    }

    #[test]
    fn a_plan_reads_back_to_the_last_bit() {
        let plan = plan("waypoints = [{ x = 0.1, y = 1e-320, radius = 0 }]").unwrap();
        assert_eq!(Plan::from_toml(&plan.to_toml().unwrap()).unwrap(), plan);
    }

    #[test]
    fn mistakes_are_named() {
        for (wishes, words) in [
            ("waypoint = []", ["waypoint", "line 1"]),
            ("waypoints = [{ x = 1 }]", ["missing field `y`", "line 1"]),
            ("waypoints = [{ x = 1, y = nan }]", ["way-point 0", "y = NaN"]),
            ("waypoints = [{ x = 1, y = 0, radius = -1 }]", ["radius = -1.0", "at least 0"]),
            ("waypoints = []", ["agent \"0\"", "no way-point"]),
            ("desired_speed = 1.0", ["agent \"0\"", "no way-point"]),
            ("desired_speed = -1.0\nwaypoints = [{ x = 1, y = 0 }]", ["desired_speed = -1.0", "agent \"0\""]),
            ("desired_speed = \"fast\"", ["desired_speed", "line 1"]),
            ("waypoints = [{ x = 1, y = 0 }]\n[agents.9]", ["agents.9", "no agent"]),
            ("waypoints = [", ["line 1", "waypoints"]),
        ] {
            let message = plan(wishes).unwrap_err();
            assert!(words.iter().all(|word| message.contains(word)), "{wishes}: {message}");
        }
        assert_eq!(Plan::from_toml("time_step = 1\nagents = []"), Err(PlanError::Empty));
    }
}
