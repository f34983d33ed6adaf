//! The table of FMI 2.0 variables.

use crate::plan::Plan;
use lemons_fmi::v3::Known;
use lemons_fmi::variables::units::*;
use lemons_fmi::variables::{Domain, Kind, Role, Unit, Variable};

/// The quantity of a variable; most belong to an agent.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// A quantity of one agent.
    Agent(usize, AgentQuantity),
    /// Number of agents that have arrived.
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
    Active,
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

pub(super) const ROWS: [Row; 13] = {
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
            Active,
            "Active",
            Kind::Boolean,
            Calculated,
            Finite,
            "whether it is there: it has not left by an exit",
        ),
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

/// Description of [`Quantity::Arrived`].
pub(super) const ARRIVED: &str = "how many agents have reached their last way-point, exit or goal";

/// Returns the variables of a plan's FMU; the value reference of a variable is its index.
pub fn table(plan: &Plan) -> Vec<Variable<Quantity>> {
    let mut table = vec![Variable {
        name: "Arrived".into(),
        quantity: Quantity::Arrived,
        kind: Kind::Integer,
        role: Role::Calculated,
        domain: Domain::Finite,
        description: ARRIVED.into(),
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
pub(super) fn needs(output: Quantity, on: AgentQuantity) -> bool {
    use AgentQuantity::*;
    matches!(
        (on, output),
        (PositionX | PositionY | WaypointX(_) | WaypointY(_) | WaypointRadius(_), _)
            | (Mass | FloorDamping | DesiredSpeed, Quantity::Agent(_, FpX | FpY))
            | (Theta | MomentOfInertia | AngularDamping, Quantity::Agent(_, Mp))
    )
}

/// Whether an output depends on the inputs of all agents.
pub(super) fn needs_all(plan: &Plan, output: Quantity) -> bool {
    use AgentQuantity::{FpX, FpY, Mp};
    plan.walking_model.sees_others() && matches!(output, Quantity::Agent(_, FpX | FpY | Mp))
}

/// Returns the indices of the known variables on which an output depends, ascending; `None` if it is all of them.
pub fn dependencies(
    plan: &Plan,
    table: &[Variable<Quantity>],
    output: usize,
    known: Known,
) -> Option<Vec<usize>> {
    if needs_all(plan, table[output].quantity) {
        return None;
    }
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
    let needed = places
        .filter(|&place| match table[place].quantity {
            Quantity::Agent(_, quantity) => counts(&table[place]) && needs(table[output].quantity, quantity),
            Quantity::Arrived => false,
        })
        .collect();
    Some(needed)
}
