//! Which outputs of a run are looked at.

use lemons_master::Model;
use lemons_record::columns;
use lemons_ssp::Type;
use serde::{Deserialize, Serialize};

/// What is looked at.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Of {
    /// Of each agent of the crowd.
    Agent(Quantity),
    /// The name of a variable, with its component if that is not the crowd: `decision.Arrived`. With `agent[*]` it is one of
    /// each agent.
    Variable(String),
}

/// An output of each agent.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Quantity {
    /// \[m\] x of the centre of mass.
    X,
    /// \[m\] y of the centre of mass.
    Y,
    /// \[rad\] orientation.
    Theta,
    /// \[m/s\] speed.
    Speed,
    /// \[rad/s\] angular velocity.
    Omega,
    /// \[N\] sum of |F_n| over its contacts at a communication point. It may miss a short collision.
    Squeeze,
    /// \[N\] time average of the squeeze over a communication step.
    MeanSqueeze,
    /// \[N\] largest squeeze within a communication step.
    PeakSqueeze,
    /// \[m\] deepest overlap of its contacts within a communication step.
    PeakOverlap,
    /// Number of contacts with disks of other agents.
    AgentContacts,
    /// Number of contacts with walls.
    WallContacts,
    /// Number of other agents that touch it.
    ContactingAgents,
}

impl Quantity {
    /// Names of the Real outputs it is computed from, and of the Integer ones.
    fn outputs(self) -> (&'static [&'static str], &'static [&'static str]) {
        match self {
            Quantity::X => (&[columns::X.variable], &[]),
            Quantity::Y => (&[columns::Y.variable], &[]),
            Quantity::Theta => (&[columns::THETA.variable], &[]),
            Quantity::Speed => (&[columns::VX.variable, columns::VY.variable], &[]),
            Quantity::Omega => (&[columns::OMEGA.variable], &[]),
            Quantity::Squeeze => (&[columns::SQUEEZE.variable], &[]),
            Quantity::MeanSqueeze => (&[columns::MEAN_SQUEEZE.variable], &[]),
            Quantity::PeakSqueeze => (&[columns::PEAK_SQUEEZE.variable], &[]),
            Quantity::PeakOverlap => (&[columns::PEAK_OVERLAP.variable], &[]),
            Quantity::AgentContacts => (&[], &[columns::AGENT_CONTACTS.variable]),
            Quantity::WallContacts => (&[], &[columns::WALL_CONTACTS.variable]),
            Quantity::ContactingAgents => (&[], &[columns::CONTACTING_AGENTS.variable]),
        }
    }
}

/// Stands for each agent in the name of a variable.
const EACH_AGENT: &str = "agent[*].";

/// Names of variables of one component, by type. All values of one agent are of one type.
#[derive(Debug, Default)]
pub(crate) struct Names {
    /// Of the component.
    pub place: usize,
    pub reals: Vec<String>,
    pub integers: Vec<String>,
    pub booleans: Vec<String>,
    /// The number of values that become one: the components of a vector.
    pub width: usize,
}

impl Names {
    /// The number of values, of which each is one number over time.
    pub fn values(&self) -> usize {
        (self.reals.len() + self.integers.len() + self.booleans.len()) / self.width
    }

    /// For each value of an agent, the variable that says whether the agent is there; empty if some are of no agent.
    pub fn there(&self) -> Vec<String> {
        let all = self.reals.iter().chain(&self.integers).chain(&self.booleans).step_by(self.width.max(1));
        let name = |name: &String| {
            Some(format!("{}.Active", name.starts_with("agent[").then(|| name.split_once('.'))??.0))
        };
        all.map(name).collect::<Option<Vec<String>>>().unwrap_or_default()
    }
}

impl Of {
    /// Checks that it can be the name of a variable.
    ///
    /// # Errors
    /// A sentence with the value.
    pub fn check(&self) -> Result<(), String> {
        match self {
            // The names above are the only ones without a capital letter or a component.
            Of::Variable(name) if !name.contains(|c: char| c == '.' || c.is_uppercase()) => Err(format!(
                "of = {name:?}: neither a quantity (lemons sweep --help) nor the name of a variable (lemons info)"
            )),
            Of::Agent(_) | Of::Variable(_) => Ok(()),
        }
    }

    /// Whether there is a value for each agent.
    pub fn is_of_agents(&self) -> bool {
        match self {
            Of::Agent(_) => true,
            Of::Variable(name) => name.contains(EACH_AGENT),
        }
    }

    /// The variables of a model that it is read from, for agents at these places.
    ///
    /// # Errors
    /// A sentence with the name that the model does not have.
    pub(crate) fn names(&self, model: &Model, agents: &[usize]) -> Result<Names, String> {
        let of_each = |names: &[&str]| -> Vec<String> {
            agents.iter().flat_map(|i| names.iter().map(move |name| format!("agent[{i}].{name}"))).collect()
        };
        let name = match self {
            Of::Agent(quantity) => {
                let (reals, integers) = quantity.outputs();
                let width = reals.len().max(integers.len());
                let (place, booleans) = (model.parts().len() - 1, Vec::new());
                return Ok(Names {
                    place,
                    reals: of_each(reals),
                    integers: of_each(integers),
                    booleans,
                    width,
                });
            }
            Of::Variable(name) => name,
        };
        let (place, variable) = model.find(name);
        let names = match variable.split_once(EACH_AGENT) {
            Some((before, after)) => {
                agents.iter().map(|i| format!("{before}agent[{i}].{after}")).collect::<Vec<_>>()
            }
            None => vec![variable.to_owned()],
        };
        let fmu = &model.parts()[place].fmu;
        let mut found = Names { place, width: 1, ..Names::default() };
        for single in names {
            let unknown = || {
                let meant = model.meant(name).map(|meant| format!("; did you mean {meant:?}?"));
                format!("of = {name:?}: there is no variable {single:?}{}", meant.unwrap_or_default())
            };
            match fmu.kind(&single).ok_or_else(unknown)? {
                Type::Real(_) => found.reals.push(single),
                Type::Integer => found.integers.push(single),
                Type::Boolean => found.booleans.push(single),
                other => return Err(format!("of = {name:?}: its type {} is no number", other.name())),
            }
        }
        Ok(found)
    }
}
