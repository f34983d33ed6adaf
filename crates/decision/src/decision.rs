//! The model of the FMU: poses are inputs, drives are outputs.

use crate::plan::{Plan, PlanError};
use crate::rule::{Pose, Propulsion, Walker};
use lemons_files::input;
use lemons_fmi::location::{Location, LocationError};
use lemons_fmi::v3::Known;
use lemons_fmi::variables::units::*;
use lemons_fmi::variables::{Domain, Kind, Role, Unit, Variable};
use lemons_fmi::{Model, Phase, StepError, fingerprint};
use serde::{Deserialize, Serialize};
use std::path::PathBuf;
use thiserror::Error;

pub mod arrays;

/// Name of the plan's file in the FMU's resources.
pub const PLAN_FILE: &str = "decision.toml";

/// The quantity of a variable; most belong to an agent.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// A quantity of one agent.
    Agent(usize, AgentQuantity),
    /// Number of agents that have reached their last way-point.
    Arrived,
}

/// A quantity of one agent.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(missing_docs)] // the names of the variables
pub enum AgentQuantity {
    PositionX,
    PositionY,
    Theta,
    FpX,
    FpY,
    Mp,
    NextWaypoint,
    Mass,
    MomentOfInertia,
    FloorDamping,
    AngularDamping,
    DesiredSpeed,
    WaypointX(usize),
    WaypointY(usize),
    WaypointRadius(usize),
}

type Row = (AgentQuantity, &'static str, Kind, Role, Domain, &'static str);

const ROWS: [Row; 12] = {
    use AgentQuantity::*;
    use Domain::*;
    use Role::*;
    const fn real(unit: Unit) -> Kind {
        Kind::Real(unit)
    }
    [
        (PositionX, "Position.x", real(METRE), Input, Finite, "x of the centre of mass"),
        (PositionY, "Position.y", real(METRE), Input, Finite, "y of the centre of mass"),
        (Theta, "Theta", real(RADIAN), Input, Finite, "orientation: angle from the x axis to the gaze"),
        (FpX, "Fp.x", real(NEWTON), Calculated, Finite, "propulsion force along x"),
        (FpY, "Fp.y", real(NEWTON), Calculated, Finite, "propulsion force along y"),
        (Mp, "Mp", real(NEWTON_METRE), Calculated, Finite, "propulsion torque"),
        (
            NextWaypoint,
            "NextWaypoint",
            Kind::Integer,
            Calculated,
            Finite,
            "which way-point it walks to; their number after the last one",
        ),
        (Mass, "Mass", real(KILOGRAM), Parameter, Positive, "mass"),
        (
            MomentOfInertia,
            "MomentOfInertia",
            real(KILOGRAM_METRE_SQUARED),
            Parameter,
            Positive,
            "moment of inertia about the centre of mass",
        ),
        (
            FloorDamping,
            "FloorDamping",
            real(PER_SECOND),
            Parameter,
            NonNegative,
            "relaxation rate of the velocity, 1/t_transl",
        ),
        (
            AngularDamping,
            "AngularDamping",
            real(PER_SECOND),
            Parameter,
            NonNegative,
            "relaxation rate of the angular velocity, 1/t_rot",
        ),
        (DesiredSpeed, "DesiredSpeed", real(METRE_PER_SECOND), Parameter, NonNegative, "desired speed v0"),
    ]
};

/// Returns the variables of a plan's FMU; the value reference of a variable is its index.
pub fn table(plan: &Plan) -> Vec<Variable<Quantity>> {
    let mut table = vec![Variable {
        name: "Arrived".into(),
        quantity: Quantity::Arrived,
        kind: Kind::Integer,
        role: Role::Calculated,
        domain: Domain::Finite,
        description: "how many agents have reached their last way-point".into(),
    }];
    for (i, agent) in plan.agents.iter().enumerate() {
        let mut add = |quantity, name: String, kind, role, domain, description: &str| {
            table.push(Variable {
                name: format!("agent[{i}].{name}"),
                quantity: Quantity::Agent(i, quantity),
                kind,
                role,
                domain,
                description: format!("agent Id {}: {description}", agent.id),
            });
        };
        for (quantity, name, kind, role, domain, description) in ROWS {
            add(quantity, name.to_owned(), kind, role, domain, description);
        }
        for k in 0..agent.walker.waypoints.len() {
            use AgentQuantity::{WaypointRadius, WaypointX, WaypointY};
            for (quantity, name, domain, description) in [
                (WaypointX(k), "x", Domain::Finite, "x of a way-point"),
                (WaypointY(k), "y", Domain::Finite, "y of a way-point"),
                (
                    WaypointRadius(k),
                    "Radius",
                    Domain::NonNegative,
                    "it is reached when the agent is this near",
                ),
            ] {
                let name = format!("Waypoint[{k}].{name}");
                add(quantity, name, Kind::Real(METRE), Role::Parameter, domain, description);
            }
        }
    }
    table
}

/// Whether an output depends on an input or a parameter of the same agent.
fn needs(output: Quantity, on: AgentQuantity) -> bool {
    use AgentQuantity::*;
    matches!(
        (on, output),
        (PositionX | PositionY | WaypointX(_) | WaypointY(_) | WaypointRadius(_), _)
            | (Mass | FloorDamping | DesiredSpeed, Quantity::Agent(_, FpX | FpY))
            | (Theta | MomentOfInertia | AngularDamping, Quantity::Agent(_, Mp))
    )
}

/// Returns the indices of the known variables on which an output depends, ascending.
pub fn dependencies(table: &[Variable<Quantity>], output: usize, known: Known) -> Vec<usize> {
    let agent_of = |variable: &Variable<Quantity>| match variable.quantity {
        Quantity::Arrived => None,
        Quantity::Agent(i, _) => Some(i),
    };
    // The variables of an agent are adjacent. A variable of no agent depends on all.
    let places = match agent_of(&table[output]) {
        None => 0..table.len(),
        agent => {
            table.partition_point(|row| agent_of(row) < agent)
                ..table.partition_point(|row| agent_of(row) <= agent)
        }
    };
    let counts = |row: &Variable<Quantity>| match row.role {
        Role::Input => true,
        Role::Parameter => known == Known::InputsAndParameters,
        _ => false,
    };
    places
        .filter(|&place| match table[place].quantity {
            Quantity::Agent(_, quantity) => counts(&table[place]) && needs(table[output].quantity, quantity),
            Quantity::Arrived => false,
        })
        .collect()
}

/// Why the FMU fails.
#[derive(Debug, Error)]
#[allow(missing_docs)] // the messages say it
pub enum DecisionError {
    #[error(transparent)]
    Location(#[from] LocationError),
    #[error("the resource location {location:?} is {path:?}, which has no {PLAN_FILE}")]
    NoPlan { location: String, path: PathBuf },
    #[error("{path}: {error}", path = path.display())]
    Read { path: PathBuf, error: std::io::Error },
    #[error("{path}: {error}", path = path.display())]
    Plan { path: PathBuf, error: PlanError },
    #[error("agent {agent:?} has only {count} way-points: what is beyond them must be 0")]
    NoWaypoint { agent: String, count: usize },
    #[error("the state belongs to another model, with another plan")]
    OtherPlan,
    #[error("{agent}: {name} is not finite: check mass, desired speed, damping and way-points")]
    NotFinite { agent: String, name: &'static str },
    #[error(
        "the state is damaged or is not a state of this FMU: it has other agents or way-points, or impossible values"
    )]
    Saved,
}

/// The saved state, without the location of the resources.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Saved {
    /// Fingerprint of the plan.
    fingerprint: u128,
    agents: Vec<Agent>,
}

/// An agent during the simulation, and in a saved state.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Agent {
    pose: Pose,
    walker: Walker,
    /// Index of the next way-point. It is updated by steps: a way-point that was reached stays reached.
    next: usize,
}

impl Agent {
    /// Index of the next way-point, seen from the present pose.
    fn next(&self) -> usize {
        self.walker.next(self.next, self.pose)
    }
}

/// The paper's eq. 4 for a crowd.
pub struct Decision {
    plan: Plan,
    /// Fingerprint of the plan.
    fingerprint: u128,
    agents: Vec<Agent>,
    /// Largest number of way-points of an agent, at least 1.
    most_waypoints: usize,
}

impl Decision {
    /// Makes the model at the start of a plan.
    pub fn new(plan: Plan) -> Decision {
        let agents =
            plan.agents.iter().map(|agent| Agent { pose: agent.pose, walker: agent.walker.clone(), next: 0 });
        let fingerprint = fingerprint(format!("{plan:?}").as_bytes());
        let most = plan.agents.iter().map(|agent| agent.walker.waypoints.len()).max();
        let most_waypoints = most.unwrap_or(0).max(1);
        Decision { agents: agents.collect(), plan, fingerprint, most_waypoints }
    }

    /// The drive of an agent at its present pose.
    fn drive(&self, i: usize) -> Propulsion {
        let agent = &self.agents[i];
        agent.walker.drive(agent.next(), agent.pose)
    }

    /// Returns the number behind a quantity that can be set; `None` for a computed one.
    pub(crate) fn place(&mut self, quantity: Quantity) -> Option<&mut f64> {
        let Quantity::Agent(i, quantity) = quantity else { return None };
        let Agent { pose, walker, .. } = self.agents.get_mut(i)?;
        Some(match quantity {
            AgentQuantity::PositionX => &mut pose.x,
            AgentQuantity::PositionY => &mut pose.y,
            AgentQuantity::Theta => &mut pose.theta,
            AgentQuantity::Mass => &mut walker.mass,
            AgentQuantity::MomentOfInertia => &mut walker.moment_of_inertia,
            AgentQuantity::FloorDamping => &mut walker.floor_damping,
            AgentQuantity::AngularDamping => &mut walker.angular_damping,
            AgentQuantity::DesiredSpeed => &mut walker.desired_speed,
            AgentQuantity::WaypointX(k) => &mut walker.waypoints.get_mut(k)?.x,
            AgentQuantity::WaypointY(k) => &mut walker.waypoints.get_mut(k)?.y,
            AgentQuantity::WaypointRadius(k) => &mut walker.waypoints.get_mut(k)?.radius,
            AgentQuantity::FpX | AgentQuantity::FpY | AgentQuantity::Mp | AgentQuantity::NextWaypoint => {
                return None;
            }
        })
    }
}

fn finite(i: usize, name: &'static str, value: f64) -> Result<f64, DecisionError> {
    if value.is_finite() {
        return Ok(value);
    }
    Err(DecisionError::NotFinite { agent: format!("agent[{i}]"), name })
}

impl Model for Decision {
    type Quantity = Quantity;
    type Saved = Saved;
    type Error = DecisionError;

    const INTERPOLATES_INPUTS: bool = false;
    const STATE_VERSION: u32 = 2;

    fn load(location: Location<'_>) -> Result<Decision, DecisionError> {
        let candidates = location.directories()?;
        let path = candidates.iter().map(|directory| directory.join(PLAN_FILE)).find(|path| path.exists());
        let path = path.ok_or_else(|| DecisionError::NoPlan {
            location: location.text().to_owned(),
            path: candidates[0].clone(),
        })?;
        let text = input::read_text(&path, input::LARGEST_SETTINGS)
            .map_err(|error| DecisionError::Read { path: path.clone(), error })?;
        Ok(Decision::new(Plan::from_toml(&text).map_err(|error| DecisionError::Plan { path, error })?))
    }

    fn table(&self) -> Vec<Variable<Quantity>> {
        table(&self.plan)
    }

    fn take_warnings(&mut self) -> Vec<String> {
        Vec::new()
    }

    fn real(&mut self, quantity: Quantity) -> Result<f64, DecisionError> {
        if let Some(place) = self.place(quantity) {
            return Ok(*place);
        }
        let Quantity::Agent(i, quantity) = quantity else { return Ok(0.0) };
        let drive = self.drive(i);
        match quantity {
            AgentQuantity::FpX => finite(i, "Fp.x", drive.force[0]),
            AgentQuantity::FpY => finite(i, "Fp.y", drive.force[1]),
            _ => finite(i, "Mp", drive.torque),
        }
    }

    fn integer(&mut self, quantity: Quantity) -> Result<i32, DecisionError> {
        let number = match quantity {
            Quantity::Arrived => {
                self.agents.iter().filter(|agent| agent.next() == agent.walker.waypoints.len()).count()
            }
            Quantity::Agent(i, _) => self.agents[i].next(),
        };
        Ok(i32::try_from(number).unwrap_or(i32::MAX))
    }

    fn string(&self, _: Quantity) -> &str {
        ""
    }

    fn set_real(&mut self, quantity: Quantity, value: f64, _: Phase) {
        if let Some(place) = self.place(quantity) {
            *place = value;
        }
    }

    fn set_integer(&mut self, _: Quantity, _: i32) {}

    fn set_strings(&mut self, _: &[(Quantity, &str)]) -> Result<(), DecisionError> {
        Ok(())
    }

    fn initialize(&mut self) -> Result<(), DecisionError> {
        Ok(())
    }

    /// The poses are those at the beginning of the step; way-points reached there stay reached.
    fn advance(&mut self, _: f64, _: f64) -> Result<(), StepError<DecisionError>> {
        for agent in &mut self.agents {
            agent.next = agent.next();
        }
        Ok(())
    }

    fn reset(&mut self) -> Result<(), DecisionError> {
        *self = Decision::new(self.plan.clone());
        Ok(())
    }

    fn save(&self) -> Saved {
        Saved { fingerprint: self.fingerprint, agents: self.agents.clone() }
    }

    fn restore(&mut self, saved: &Saved) -> Result<(), DecisionError> {
        let Saved { fingerprint, agents: saved } = saved;
        if *fingerprint != self.fingerprint {
            return Err(DecisionError::OtherPlan);
        }
        let alike = |(a, b): (&Agent, &Agent)| {
            let count = b.walker.waypoints.len();
            a.walker.waypoints.len() == count && a.next <= count
        };
        if saved.len() != self.agents.len() || !saved.iter().zip(&self.agents).all(alike) {
            return Err(DecisionError::Saved);
        }
        let mut restored = Decision { agents: saved.clone(), ..Decision::new(self.plan.clone()) };
        for row in self.table() {
            if restored.place(row.quantity).is_some_and(|value| row.domain.check(*value).is_err()) {
                return Err(DecisionError::Saved);
            }
        }
        self.agents = restored.agents;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::{Person, Wishes};

    fn decision(wishes: &str) -> Decision {
        let person = Person {
            id: "0".into(),
            mass: 70.0,
            moment_of_inertia: 1.3,
            floor_damping: 2.0,
            angular_damping: 4.0,
            pose: Pose::default(),
        };
        let wishes = Wishes::from_toml(wishes).unwrap();
        Decision::new(Plan::new(&[person], &wishes, 0.05).unwrap())
    }

    #[test]
    fn a_state_of_another_plan_is_refused() {
        let (one, mut other) =
            (decision("waypoints = [{ x = 1, y = 2 }]"), decision("waypoints = [{ x = 1, y = 3 }]"));
        let before = other.save();
        assert!(matches!(other.restore(&one.save()), Err(DecisionError::OtherPlan)));
        assert_eq!(other.save(), before);
    }

    #[test]
    fn a_drive_beyond_all_numbers_is_an_error_that_names_it() {
        let mut decision = decision("waypoints = [{ x = -1e308, y = 0 }]");
        decision.set_real(Quantity::Agent(0, AgentQuantity::PositionX), 1.7e308, Phase::StepComplete);
        let error = decision.real(Quantity::Agent(0, AgentQuantity::FpX)).unwrap_err().to_string();
        assert!(error.contains("agent[0]") && error.contains("Fp.x"), "{error}");
    }

    #[test]
    fn states_with_impossible_numbers_are_refused() {
        let mut decision = decision("waypoints = [{ x = 1, y = 2 }]");
        let good = decision.save();
        let forgeries: [fn(&mut Agent); 3] = [
            |agent| agent.pose.x = f64::NAN,
            |agent| agent.walker.mass = 0.0,
            |agent| agent.walker.waypoints[0].radius = -1.0,
        ];
        for forge in forgeries {
            let mut forged = good.clone();
            forge(&mut forged.agents[0]);
            assert!(decision.restore(&forged).is_err(), "{forged:?}");
            assert_eq!(decision.save(), good);
        }
        decision.restore(&good).unwrap();
    }
}
