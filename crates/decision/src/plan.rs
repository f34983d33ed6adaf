//! What is known before the start: a user's wishes, and the plan that they become with the people of a Trial.
//!
//! Both are TOML. Wishes name way-points and speeds, for everybody or for some agents by their Id:
//!
//! ```toml
//! desired_speed = 1.34                               # [m/s]
//! waypoints = [{ x = 6.0, y = 2.5, radius = 0.45 }, { x = 20.0, y = 2.5 }]   # [m]; radius 0.3 if it is not said
//!
//! [agents.7]
//! desired_speed = 0.9
//! ```
//!
//! A plan, `decision.toml` in the FMU's resources, says all of every agent.

use crate::rule::{Pose, Walker, Waypoint};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use thiserror::Error;

/// \[m\] of a way-point that names none.
const DEFAULT_RADIUS: f64 = 0.3;
/// \[m/s\] Of pedestrians who walk freely, on average (Weidmann 1993).
const DEFAULT_SPEED: f64 = 1.34;

/// What is wrong with wishes or a plan; the messages do not name the file.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[allow(missing_docs)] // the messages say it
pub enum PlanError {
    #[error("{0}")]
    Toml(String),
    #[error("{place}: {key} = {value}: must be {must}")]
    Value { place: String, key: &'static str, value: String, must: &'static str },
    #[error("agents.{0}: there is no agent with this Id")]
    UnknownAgent(String),
    #[error("agent {0:?} has no way-point: give `waypoints` for everybody, or in [agents.{0}]")]
    NoWaypoint(String),
    #[error("there is no agent")]
    Empty,
}

/// What a user wants people to do.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Wishes {
    desired_speed: Option<f64>,
    waypoints: Option<Vec<WantedWaypoint>>,
    #[serde(default)]
    agents: BTreeMap<String, Wish>,
}

/// Of one agent; what it does not say is as for everybody.
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
    /// From TOML.
    ///
    /// # Errors
    /// No TOML, unknown words, numbers of another type; with line and column.
    pub fn from_toml(text: &str) -> Result<Wishes, PlanError> {
        toml::from_str(text).map_err(|error| PlanError::Toml(explained(&error)))
    }
}

/// What is wrong, and of a word that nobody knows the one that was meant perhaps.
fn explained(error: &toml::de::Error) -> String {
    // The words stand between backticks: first the unknown one, then those that are expected.
    let said = error.to_string();
    let mut words = error.message().split('`').skip(1).step_by(2);
    let unknown = words.next().filter(|_| error.message().starts_with("unknown field"));
    let meant = unknown.and_then(|unknown| {
        let near = words.map(|word| (strsim::damerau_levenshtein(unknown, word), word));
        near.filter(|(apart, word)| 3 * apart <= word.len().max(6)).min().map(|(_, word)| word)
    });
    match meant {
        Some(meant) => format!("{}\ndid you mean `{meant}`?", said.trim_end()),
        None => said,
    }
}

/// An agent of a Trial, as far as a decision needs to know it.
#[derive(Debug, Clone, PartialEq)]
pub struct Person {
    /// Of Agents.xml.
    pub id: String,
    /// \[kg\]
    pub mass: f64,
    /// \[kg.m2\]
    pub moment_of_inertia: f64,
    /// \[1/s\]
    pub floor_damping: f64,
    /// \[1/s\]
    pub angular_damping: f64,
    /// Where it stands at the start.
    pub pose: Pose,
}

/// An agent of a plan.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Planned {
    /// Of Agents.xml.
    pub id: String,
    /// Start values of the inputs.
    pub pose: Pose,
    /// What the rule needs.
    pub walker: Walker,
}

/// All that the FMU starts from.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Plan {
    /// \[s\] `DefaultExperiment.stepSize`
    pub time_step: f64,
    /// In the order of Agents.xml; at least one.
    pub agents: Vec<Planned>,
}

impl Plan {
    /// The wishes of these people.
    ///
    /// # Errors
    /// A wish for nobody, an agent without way-points, numbers that make no sense.
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

    /// From TOML.
    ///
    /// # Errors
    /// As [`Wishes::from_toml`], or numbers that make no sense.
    pub fn from_toml(text: &str) -> Result<Plan, PlanError> {
        toml::from_str::<Plan>(text).map_err(|error| PlanError::Toml(error.to_string()))?.checked()
    }

    /// As TOML; every number reads back to the same double.
    ///
    /// # Errors
    /// It cannot be written.
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
