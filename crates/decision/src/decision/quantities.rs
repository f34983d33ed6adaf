//! The quantities of the FMU: one table with the name, unit, causality, shape and domain of each.
//! FMI 3.0 has each row as one array, FMI 2.0 has the elements.
//!
//! Arrays have an element for each agent, in the order of Agents.xml. Agents may have different
//! numbers of way-points: an agent's row is as long as the longest, and `WaypointCount` says how
//! much of it counts. What is beyond is 0 and stays 0.

use super::Decision;
use crate::balance::BalanceModel;
use lemons_fmi::variables::types::*;
use lemons_fmi::variables::{
    Dependencies, Dependency, Dimension, Domain, Known, Role, Scalar, Size, Variable, VariableType, row,
};

/// A quantity: a row of [`QUANTITIES`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(missing_docs)] // the table says it
pub enum DecisionQuantity {
    Arrived,
    Position,
    Theta,
    Velocity,
    DoorOpen,
    ExitOpen,
    Fp,
    Mp,
    Active,
    NextWaypoint,
    Legs,
    Lean,
    Steps,
    Balanced,
    Fallen,
    Mass,
    MomentOfInertia,
    FloorDamping,
    AngularDamping,
    DesiredSpeed,
    TimeGap,
    StandstillGap,
    ReactionTime,
    Start,
    Push,
    Waypoint,
    WaypointRadius,
    WaypointCount,
    AgentId,
}

/// The structural parameters.
pub(super) const SIZES: [Size; 4] = [
    Size::new("Agents", "number of agents"),
    Size::new("Waypoints", "largest number of way-points of an agent"),
    Size { optional: true, ..Size::new("Doors", "number of walls that open") },
    Size { optional: true, ..Size::new("Exits", "number of exits") },
];

const AGENTS: &[Dimension] = &[Dimension::Size(0)];
const VECTORS: &[Dimension] = &[Dimension::Size(0), Dimension::Fixed(2)];
const DOORS: &[Dimension] = &[Dimension::Size(2)];
const EXITS: &[Dimension] = &[Dimension::Size(3)];
const WAYPOINTS: &[Dimension] = &[Dimension::Size(0), Dimension::Size(1)];
const WAYPOINT_VECTORS: &[Dimension] = &[Dimension::Size(0), Dimension::Size(1), Dimension::Fixed(2)];

/// The table.
pub static QUANTITIES: [Variable<DecisionQuantity>; 29] = {
    use DecisionQuantity::*;
    use Domain::*;
    use VariableType::*;
    [
        row(Arrived, "Arrived", &[], Integer)
            .calculated("how many agents have reached their last way-point, exit or goal"),
        row(Position, "Position", VECTORS, Real(POSITION)).input("x and y of the centre of mass"),
        row(Theta, "Theta", AGENTS, Real(ANGLE)).input("orientation: angle from the x axis to the gaze"),
        row(Velocity, "Velocity", VECTORS, Real(VELOCITY)).input("velocity along x and y"),
        row(DoorOpen, "DoorOpen", DOORS, Boolean)
            .input("whether the door is open, at the times at which it may be; connect what the crowd gets"),
        row(ExitOpen, "ExitOpen", EXITS, Boolean).input(
            "whether the exit is open, at the times at which it may be: people choose another one, or wait",
        ),
        row(Fp, "Fp", VECTORS, Real(FORCE)).calculated("propulsion force along x and y"),
        row(Mp, "Mp", AGENTS, Real(TORQUE)).calculated("propulsion torque"),
        row(Active, "Active", AGENTS, Boolean)
            .calculated("whether it is there: it has come, and has not left by an exit"),
        row(NextWaypoint, "NextWaypoint", AGENTS, Integer)
            .calculated("which way-point it walks to; their number after the last one"),
        row(Legs, "Legs", VECTORS, Real(POSITION)).calculated("x and y of the middle of the feet"),
        row(Lean, "Lean", AGENTS, Real(DISTANCE)).calculated("distance of the centre of mass from the feet"),
        row(Steps, "Steps", AGENTS, Integer).calculated("how many steps it took to keep the balance"),
        row(Balanced, "Balanced", AGENTS, Boolean).calculated("whether it needs no step to keep the balance"),
        row(Fallen, "Fallen", AGENTS, Boolean)
            .calculated("whether it could not be saved from a fall, at some time"),
        row(Mass, "Mass", AGENTS, Real(MASS)).parameter(Positive, "mass"),
        row(MomentOfInertia, "MomentOfInertia", AGENTS, Real(INERTIA))
            .parameter(Positive, "moment of inertia about the centre of mass"),
        row(FloorDamping, "FloorDamping", AGENTS, Real(RATE))
            .parameter(NonNegative, "relaxation rate of the velocity, 1/t_transl"),
        row(AngularDamping, "AngularDamping", AGENTS, Real(RATE))
            .parameter(NonNegative, "relaxation rate of the angular velocity, 1/t_rot"),
        row(DesiredSpeed, "DesiredSpeed", AGENTS, Real(VELOCITY))
            .parameter(NonNegative, "desired speed v0")
            .tunable(),
        row(TimeGap, "TimeGap", AGENTS, Real(DURATION))
            .parameter(Positive, "time gap T to who is ahead")
            .tunable(),
        row(StandstillGap, "StandstillGap", AGENTS, Real(DISTANCE))
            .parameter(NonNegative, "gap to who is ahead when standing")
            .tunable(),
        row(ReactionTime, "ReactionTime", AGENTS, Real(DURATION))
            .parameter(NonNegative, "reaction time to gaps that change")
            .tunable(),
        row(Start, "Start", AGENTS, Real(DURATION))
            .parameter(NonNegative, "time from which on it walks; it stands before"),
        row(Push, "Push", AGENTS, Real(FORCE))
            .parameter(NonNegative, "greatest force with which it pushes ahead; 1e9 or more: no limit")
            .tunable(),
        row(Waypoint, "Waypoint", WAYPOINT_VECTORS, Real(POSITION))
            .parameter(Finite, "x and y of the way-points in order; 0 beyond WaypointCount"),
        row(WaypointRadius, "WaypointRadius", WAYPOINTS, Real(DISTANCE)).parameter(
            NonNegative,
            "a way-point is reached when the agent is this near; 0 beyond WaypointCount",
        ),
        row(WaypointCount, "WaypointCount", AGENTS, Integer)
            .calculated_parameter("how many way-points an agent has"),
        row(AgentId, "AgentId", AGENTS, String).calculated_parameter("Ids of the agents"),
    ]
};

impl DecisionQuantity {
    /// Returns its row of the table.
    pub fn row(self) -> &'static Variable<DecisionQuantity> {
        &QUANTITIES[self as usize]
    }

    /// Returns whether it has an element for each way-point of an agent.
    fn is_of_waypoints(self) -> bool {
        matches!(self, DecisionQuantity::Waypoint | DecisionQuantity::WaypointRadius)
    }

    /// Returns whether an output depends on an input or a parameter of the same agent, or of doors and exits.
    fn needs(self, on: DecisionQuantity) -> bool {
        use DecisionQuantity::*;
        match on {
            // Counted in steps.
            _ if matches!(self, Steps | Fallen) => false,
            _ if matches!(self, Legs | Lean | Balanced) => on == Position,
            Position | Waypoint | WaypointRadius | Start => true,
            Mass | FloorDamping | DesiredSpeed | Velocity | Push => self == Fp,
            Theta | MomentOfInertia | AngularDamping => self == Mp,
            DoorOpen => matches!(self, Fp | Mp),
            ExitOpen => matches!(self, Fp | Mp | Active | Arrived),
            _ => false,
        }
    }
}

impl Decision {
    /// Returns the number of elements of a quantity that each agent has.
    pub(super) fn elements_of_each(&self, quantity: DecisionQuantity) -> usize {
        let waypoints = if quantity.is_of_waypoints() { self.most_waypoints } else { 1 };
        if quantity.row().is_vector() { 2 * waypoints } else { waypoints }
    }

    /// Returns how many doors or exits an input operates; `None` if it is of no such.
    pub(super) fn operable(&self, quantity: DecisionQuantity) -> Option<usize> {
        match quantity {
            DecisionQuantity::DoorOpen => Some(self.plan.doors.len()),
            DecisionQuantity::ExitOpen => Some(self.exits().count()),
            _ => None,
        }
    }

    /// Returns whether an agent has an element of a quantity: not of way-points that it does not
    /// have.
    pub(super) fn has(&self, quantity: DecisionQuantity, element: usize) -> bool {
        if !quantity.is_of_waypoints() {
            return true;
        }
        let each = self.elements_of_each(quantity);
        let count = self.agents[element / each].walker.waypoints.len();
        element % each < count * each / self.most_waypoints
    }

    /// Returns the number behind an element that can be set; `None` for a computed one, and for
    /// way-points that an agent does not have.
    pub(crate) fn field(&mut self, quantity: DecisionQuantity, element: usize) -> Option<&mut f64> {
        let each = self.elements_of_each(quantity);
        let (i, k) = (element / each, element % each);
        let super::AgentState { pose, velocity, walker, .. } = self.agents.get_mut(i)?;
        let x = k % 2 == 0;
        Some(match quantity {
            DecisionQuantity::Position if x => &mut pose.position.x,
            DecisionQuantity::Position => &mut pose.position.y,
            DecisionQuantity::Theta => &mut pose.orientation,
            DecisionQuantity::Velocity => &mut velocity[k],
            DecisionQuantity::Mass => &mut walker.mass,
            DecisionQuantity::MomentOfInertia => &mut walker.moment_of_inertia,
            DecisionQuantity::FloorDamping => &mut walker.floor_damping,
            DecisionQuantity::AngularDamping => &mut walker.angular_damping,
            DecisionQuantity::DesiredSpeed => &mut walker.desired_speed,
            DecisionQuantity::TimeGap => &mut walker.time_gap,
            DecisionQuantity::StandstillGap => &mut walker.standstill_gap,
            DecisionQuantity::ReactionTime => &mut walker.reaction_time,
            DecisionQuantity::Start => &mut walker.start,
            DecisionQuantity::Push => &mut walker.push,
            DecisionQuantity::Waypoint if x => &mut walker.waypoints.get_mut(k / 2)?.x,
            DecisionQuantity::Waypoint => &mut walker.waypoints.get_mut(k / 2)?.y,
            DecisionQuantity::WaypointRadius => &mut walker.waypoints.get_mut(k)?.radius,
            _ => return None,
        })
    }

    /// Returns the variables of FMI 2.0. A value reference is an index in this list.
    pub(super) fn scalars_of_plan(&self) -> Vec<Scalar<DecisionQuantity>> {
        let mut scalars: Vec<Scalar<DecisionQuantity>> =
            DecisionQuantity::Arrived.row().scalars(0, "", "").collect();
        let of_agents = || {
            QUANTITIES.iter().filter(|row| {
                row.role != Role::CalculatedParameter && [AGENTS, VECTORS].contains(&row.dimensions)
            })
        };
        for (i, agent) in self.plan.agents.iter().enumerate() {
            let (prefix, about) = (format!("agent[{i}]."), format!("agent Id {}: ", agent.id));
            scalars.extend(of_agents().flat_map(|row| row.scalars(i, &prefix, &about)));
            for k in 0..agent.walker.waypoints.len() {
                let at = i * self.most_waypoints + k;
                let scalar = |quantity: DecisionQuantity, element, name, description| Scalar {
                    name: format!("{prefix}Waypoint[{k}].{name}"),
                    description: format!("{about}{description}"),
                    variable: quantity.row(),
                    element,
                };
                let near = "it is reached when the agent is this near";
                scalars.extend([
                    scalar(DecisionQuantity::Waypoint, 2 * at, "x", "x of a way-point"),
                    scalar(DecisionQuantity::Waypoint, 2 * at + 1, "y", "y of a way-point"),
                    scalar(DecisionQuantity::WaypointRadius, at, "Radius", near),
                ]);
            }
        }
        let doors = self.plan.doors.iter().map(|door| format!("wall Id {}: ", door.id));
        let exits = self.exits().map(|k| format!("exit {}: ", self.plan.targets[k].name));
        let mut operated = |quantity: DecisionQuantity, what, k, about: String| {
            let scalars_of_it = quantity.row().scalars(k, "", &about);
            scalars.extend(scalars_of_it.map(|of| Scalar { name: format!("{what}[{k}].Open"), ..of }));
        };
        doors.enumerate().for_each(|(k, about)| operated(DecisionQuantity::DoorOpen, "door", k, about));
        exits.enumerate().for_each(|(k, about)| operated(DecisionQuantity::ExitOpen, "exit", k, about));
        scalars
    }

    /// Returns whether an output depends on the inputs of all agents.
    fn needs_all(&self, output: DecisionQuantity) -> bool {
        let groups = !self.plan.groups.is_empty() || self.plan.counts();
        match output {
            DecisionQuantity::Active => self.plan.counts(),
            DecisionQuantity::Fp => {
                groups || self.plan.walking_model.sees_others() || self.plan.queue.is_some()
            }
            DecisionQuantity::Mp => groups || self.plan.walking_model.sees_others(),
            // Before the first step, who stands follows from where the whole group is.
            DecisionQuantity::Legs | DecisionQuantity::Lean | DecisionQuantity::Balanced => {
                groups && self.plan.balance.is_some()
            }
            _ => false,
        }
    }

    /// Returns the dependencies of an output on the inputs and parameters of the same agent, and on doors and exits; of the
    /// number of those who have arrived, on those of everybody.
    pub(super) fn dependencies_of(
        &self,
        output: DecisionQuantity,
        known: Known,
    ) -> Dependencies<DecisionQuantity> {
        if output.row().role != Role::Calculated {
            return Dependencies::Elements(Vec::new());
        }
        // Where people see each other, outlines and motions count, too.
        let seen = |on: DecisionQuantity| {
            use DecisionQuantity::*;
            let of_motion = matches!(on, Theta | Velocity | FloorDamping | DesiredSpeed);
            let of_way = matches!(on, Waypoint | WaypointRadius);
            let counts = of_motion || of_way || matches!(on, TimeGap | StandstillGap | ReactionTime | Start);
            let extrapolates =
                matches!(self.plan.balance, Some(BalanceModel::Pendulum(_))) && output == Balanced;
            self.needs_all(output) && counts || extrapolates && on == Velocity
        };
        let needed = |row: &&Variable<DecisionQuantity>| {
            self.operable(row.quantity) != Some(0)
                && known.includes(row.role)
                && (output.needs(row.quantity) || seen(row.quantity))
        };
        let on: Vec<DecisionQuantity> = QUANTITIES.iter().filter(needed).map(|row| row.quantity).collect();
        if self.needs_all(output) {
            return Dependencies::All(on);
        }
        let each = self.elements_of_each(output);
        let (operated, on): (Vec<_>, Vec<_>) = on.into_iter().partition(|on| self.operable(*on).is_some());
        let mut dependencies = Vec::new();
        let all = if output == DecisionQuantity::Arrived { 1 } else { each * self.agents.len() };
        for on in operated {
            let elements = 0..self.operable(on).unwrap_or(0);
            let pairs =
                (0..all).flat_map(|dependent| elements.clone().map(move |element| (dependent, element)));
            dependencies.extend(pairs.map(|(dependent, element)| Dependency { dependent, on, element }));
        }
        for i in 0..self.agents.len() {
            let dependents =
                if output == DecisionQuantity::Arrived { 0..1 } else { i * each..(i + 1) * each };
            for (dependent, &on) in dependents.flat_map(|dependent| on.iter().map(move |on| (dependent, on)))
            {
                let of_each = self.elements_of_each(on);
                let elements = (i * of_each..(i + 1) * of_each).filter(|element| self.has(on, *element));
                dependencies.extend(elements.map(|element| Dependency { dependent, on, element }));
            }
        }
        Dependencies::Elements(dependencies)
    }
}
