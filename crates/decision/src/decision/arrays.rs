//! The decision as arrays (FMI 3.0).
//!
//! Names are those of FMI 2.0 where possible. Arrays have an element for each agent, in the order of Agents.xml. Agents
//! may have different numbers of way-points: an agent's row is as long as the longest, and `WaypointCount` says how much
//! of it counts. What is beyond is 0 and stays 0.

use super::table::{ARRIVED, AgentQuantity, Quantity, ROWS, needs, needs_all};
use super::{Decision, DecisionError, finite};
use lemons_fmi::v3::arrays::Dependency;
use lemons_fmi::v3::{Array, ArrayModel, Dimension, Known, Size};
use lemons_fmi::variables::units::METRE;
use lemons_fmi::variables::{Domain, Kind, Role};
use lemons_fmi::{Model, Phase, StepError};

/// The structural parameters.
const SIZES: [Size; 2] = [
    Size { name: "Agents", description: "number of agents" },
    Size { name: "Waypoints", description: "largest number of way-points of an agent" },
];
const AGENTS: Dimension = Dimension::Size(0);
const WAYPOINTS: Dimension = Dimension::Size(1);

/// Dependencies of each on all are listed for up to so many agents.
const MOST_LISTED: usize = 1000;

/// An array.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Block {
    /// Number of agents that have reached their last way-point.
    Arrived,
    /// These quantities of each agent.
    Agents(&'static [AgentQuantity]),
    /// x and y of each way-point of each agent.
    Waypoint,
    /// Radius of each way-point of each agent.
    WaypointRadius,
    /// Number of way-points of each agent.
    WaypointCount,
    /// Ids of the agents.
    AgentIds,
}

/// Name, quantities, and the description where it is not that of the one quantity.
const OF_AGENTS: [(&str, &[AgentQuantity], &str); 11] = {
    use AgentQuantity::*;
    [
        ("Position", &[PositionX, PositionY], "x and y of the centre of mass"),
        ("Theta", &[Theta], ""),
        ("Fp", &[FpX, FpY], "propulsion force along x and y"),
        ("Mp", &[Mp], ""),
        ("Active", &[Active], ""),
        ("NextWaypoint", &[NextWaypoint], ""),
        ("Mass", &[Mass], ""),
        ("MomentOfInertia", &[MomentOfInertia], ""),
        ("FloorDamping", &[FloorDamping], ""),
        ("AngularDamping", &[AngularDamping], ""),
        ("DesiredSpeed", &[DesiredSpeed], ""),
    ]
};

fn arrays() -> Vec<Array<Block>> {
    let mut arrays = vec![Array {
        name: "Arrived",
        block: Block::Arrived,
        kind: Kind::Integer,
        role: Role::Calculated,
        domain: Domain::Finite,
        dimensions: &[],
        description: ARRIVED,
    }];
    for (name, quantities, of_both) in OF_AGENTS {
        let row = ROWS.into_iter().find(|row| row.0 == quantities[0]);
        let (_, _, kind, role, domain, of_one) = row.expect("each is in the table of FMI 2.0");
        arrays.push(Array {
            name,
            block: Block::Agents(quantities),
            kind,
            role,
            domain,
            dimensions: if quantities.len() == 2 { &[AGENTS, Dimension::Fixed(2)] } else { &[AGENTS] },
            description: if of_both.is_empty() { of_one } else { of_both },
        });
    }
    arrays.extend([
        Array {
            name: "Waypoint",
            block: Block::Waypoint,
            kind: Kind::Real(METRE),
            role: Role::Parameter,
            domain: Domain::Finite,
            dimensions: &[AGENTS, WAYPOINTS, Dimension::Fixed(2)],
            description: "x and y of the way-points in order; 0 beyond WaypointCount",
        },
        Array {
            name: "WaypointRadius",
            block: Block::WaypointRadius,
            kind: Kind::Real(METRE),
            role: Role::Parameter,
            domain: Domain::NonNegative,
            dimensions: &[AGENTS, WAYPOINTS],
            description: "a way-point is reached when the agent is this near; 0 beyond WaypointCount",
        },
        Array {
            name: "WaypointCount",
            block: Block::WaypointCount,
            kind: Kind::Integer,
            role: Role::CalculatedParameter,
            domain: Domain::Finite,
            dimensions: &[AGENTS],
            description: "how many way-points an agent has",
        },
        Array {
            name: "AgentId",
            block: Block::AgentIds,
            kind: Kind::String,
            role: Role::CalculatedParameter,
            domain: Domain::Finite,
            dimensions: &[AGENTS],
            description: "Ids of the agents",
        },
    ]);
    arrays
}

/// The start value of an array; `None` if it is computed.
pub(crate) fn starts(decision: &mut Decision, block: Block) -> Option<Vec<f64>> {
    let array = arrays().into_iter().find(|array| array.block == block)?;
    if !matches!(array.role, Role::Input | Role::Parameter) {
        return None;
    }
    let length = decision.length(block);
    let start = |k| {
        let place = decision.element(block, k).and_then(|quantity| decision.place(quantity));
        place.map_or(0.0, |value| *value)
    };
    Some((0..length).map(start).collect())
}

/// One of the quantities of an output.
fn representative(block: Block) -> Option<Quantity> {
    use AgentQuantity::{Active, FpX, Mp, NextWaypoint};
    match block {
        Block::Arrived => Some(Quantity::Arrived),
        Block::Agents(&[of @ (FpX | Mp | Active | NextWaypoint), ..]) => Some(Quantity::Agent(0, of)),
        _ => None,
    }
}

impl Block {
    /// Quantities of FMI 2.0 for an agent; of a way-point, those of the first.
    fn quantities(self) -> &'static [AgentQuantity] {
        match self {
            Block::Agents(quantities) => quantities,
            Block::Waypoint => &[AgentQuantity::WaypointX(0), AgentQuantity::WaypointY(0)],
            Block::WaypointRadius => &[AgentQuantity::WaypointRadius(0)],
            Block::Arrived | Block::WaypointCount | Block::AgentIds => &[],
        }
    }
}

impl Decision {
    /// Returns the quantity behind an element of an array of Reals; `None` for way-points that an agent does not have.
    fn element(&self, block: Block, k: usize) -> Option<Quantity> {
        let of_waypoint = |k: usize| {
            let (i, waypoint) = (k / self.most_waypoints, k % self.most_waypoints);
            (waypoint < self.agents.get(i)?.walker.waypoints.len()).then_some((i, waypoint))
        };
        Some(match block {
            Block::Agents(quantities) => {
                Quantity::Agent(k / quantities.len(), quantities[k % quantities.len()])
            }
            Block::Waypoint => {
                let (i, waypoint) = of_waypoint(k / 2)?;
                let axes = [AgentQuantity::WaypointX(waypoint), AgentQuantity::WaypointY(waypoint)];
                Quantity::Agent(i, axes[k % 2])
            }
            Block::WaypointRadius => {
                let (i, waypoint) = of_waypoint(k)?;
                Quantity::Agent(i, AgentQuantity::WaypointRadius(waypoint))
            }
            Block::Arrived | Block::WaypointCount | Block::AgentIds => return None,
        })
    }

    /// The dependencies of an output; with those of other agents if `all`.
    pub(crate) fn dependencies_on(&self, block: Block, known: Known, all: bool) -> Vec<Dependency<Block>> {
        let Some(output) = representative(block) else { return Vec::new() };
        let counts = |array: &Array<Block>| match array.role {
            Role::Input => true,
            Role::Parameter => known == Known::InputsAndParameters,
            _ => false,
        };
        // Of others, the outline counts, too.
        let needed = |block: &Block| {
            let seen = needs_all(&self.plan, output) && *block == Block::Agents(&[AgentQuantity::Theta]);
            seen || block.quantities().iter().any(|on| needs(output, *on))
        };
        let on: Vec<Block> =
            arrays().into_iter().filter(counts).map(|array| array.block).filter(needed).collect();
        let mut dependencies = Vec::new();
        for dependent in 0..self.length(block) {
            // The number of all depends on everybody, the others on their own agent.
            let agents = match block {
                Block::Agents(quantities) if !all => {
                    let i = dependent / quantities.len();
                    i..i + 1
                }
                _ => 0..self.agents.len(),
            };
            for i in agents {
                for &on in &on {
                    let of_each = self.length(on) / self.agents.len();
                    // Not on way-points that it does not have.
                    let elements =
                        (i * of_each..(i + 1) * of_each).filter(|k| self.element(on, *k).is_some());
                    dependencies.extend(elements.map(|element| Dependency { dependent, on, element }));
                }
            }
        }
        dependencies
    }

    /// The number of elements of an array.
    fn length(&self, block: Block) -> usize {
        let agents = self.agents.len();
        match block {
            Block::Arrived => 1,
            Block::Agents(quantities) => agents * quantities.len(),
            Block::Waypoint => 2 * agents * self.most_waypoints,
            Block::WaypointRadius => agents * self.most_waypoints,
            Block::WaypointCount | Block::AgentIds => agents,
        }
    }
}

impl ArrayModel for Decision {
    type Block = Block;

    const SIZES: &'static [Size] = &SIZES;

    fn arrays() -> Vec<Array<Block>> {
        arrays()
    }

    fn sizes(&self) -> Vec<u64> {
        vec![self.agents.len() as u64, self.most_waypoints as u64]
    }

    fn read_reals(&mut self, block: Block, values: &mut [f64]) -> Result<(), DecisionError> {
        if let Block::Agents([AgentQuantity::FpX, AgentQuantity::FpY]) = block {
            // Both from one evaluation of the rule.
            for (i, value) in values.as_chunks_mut().0.iter_mut().enumerate() {
                let [x, y] = self.drive(i)?.force;
                *value = [finite(i, "Fp.x", x)?, finite(i, "Fp.y", y)?];
            }
            return Ok(());
        }
        for (k, value) in values.iter_mut().enumerate() {
            *value = match self.element(block, k) {
                Some(quantity) => self.real(quantity)?,
                None => 0.0,
            };
        }
        Ok(())
    }

    fn read_integers(&mut self, block: Block, values: &mut [i32]) -> Result<(), DecisionError> {
        for (i, value) in values.iter_mut().enumerate() {
            *value = match block {
                Block::Arrived => self.integer(Quantity::Arrived)?,
                Block::WaypointCount => {
                    i32::try_from(self.agents[i].walker.waypoints.len()).unwrap_or(i32::MAX)
                }
                Block::Agents(&[of]) => self.integer(Quantity::Agent(i, of))?,
                _ => 0,
            };
        }
        Ok(())
    }

    fn texts(&self, block: Block) -> Vec<&str> {
        match block {
            Block::AgentIds => self.plan.agents.iter().map(|agent| &agent.id[..]).collect(),
            _ => Vec::new(),
        }
    }

    fn check_reals(&self, block: Block, values: &[f64]) -> Result<(), DecisionError> {
        let beyond = |k: &usize| values[*k] != 0.0 && self.element(block, *k).is_none();
        let Some(k) = (0..values.len()).find(beyond) else { return Ok(()) };
        let i = k / (values.len() / self.agents.len());
        let count = self.agents[i].walker.waypoints.len();
        Err(DecisionError::NoWaypoint { agent: self.plan.agents[i].id.clone(), count })
    }

    fn write_reals(&mut self, block: Block, values: &[f64], phase: Phase) {
        for (k, &value) in values.iter().enumerate() {
            if let Some(quantity) = self.element(block, k) {
                self.set_real(quantity, value, phase);
            }
        }
    }

    fn write_integers(&mut self, _: Block, _: &[i32], _: Phase) {}

    fn write_texts(&mut self, _: &[(Block, &str)]) -> Result<(), DecisionError> {
        Ok(())
    }

    fn dependencies(&self, block: Block, known: Known) -> Option<Vec<Dependency<Block>>> {
        let all = representative(block).is_some_and(|output| needs_all(&self.plan, output));
        if all && self.agents.len() > MOST_LISTED {
            return None;
        }
        Some(self.dependencies_on(block, known, all))
    }

    fn advance_part(
        &mut self,
        from: f64,
        part: f64,
        _so_far: f64,
        _at_end: Option<f64>,
    ) -> Result<(), StepError<DecisionError>> {
        self.advance(from, part)
    }
}
