//! Which outputs of a run are looked at.

use lemons_master::Model;
use lemons_record::Kind;
use lemons_record::columns;
use lemons_ssp::Type;
use serde::Deserialize;

/// What is looked at: a quantity of each agent of the crowd, one of [`QUANTITIES`], or the name of a variable, with its
/// component if that is not the crowd: `decision.Arrived`. With `agent[*]` it is one of each agent.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
#[serde(transparent)]
pub struct Of(String);

/// The quantities of agents, each with the columns of a run that it is computed from: of several, it is the length of
/// the vector.
const QUANTITIES: [(&str, &[&str]); 12] = [
    ("x", &["x"]),
    ("y", &["y"]),
    ("theta", &["theta"]),
    ("speed", &["vx", "vy"]),
    ("omega", &["omega"]),
    // At a communication point: it may miss a short collision.
    ("squeeze", &["normal_force"]),
    ("mean_squeeze", &["mean_normal_force"]),
    ("peak_squeeze", &["peak_normal_force"]),
    ("peak_overlap", &["peak_overlap"]),
    ("agent_contacts", &["agent_contacts"]),
    ("wall_contacts", &["wall_contacts"]),
    ("contacting_agents", &["contacting_agents"]),
];

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
    /// The columns of a quantity of agents.
    fn columns(&self) -> Option<impl Iterator<Item = &'static columns::Quantity>> {
        let (_, names) = QUANTITIES.iter().find(|(name, _)| *name == self.0)?;
        Some(names.iter().filter_map(|name| columns::named(name)))
    }

    /// Checks that it can be the name of a variable.
    ///
    /// # Errors
    /// A sentence with the value.
    pub fn check(&self) -> Result<(), String> {
        let name = &self.0;
        // Quantities are the only names without a capital letter or a component.
        if self.columns().is_some() || name.contains(|c: char| c == '.' || c.is_uppercase()) {
            return Ok(());
        }
        Err(format!(
            "of = {name:?}: neither a quantity (lemons sweep --help) nor the name of a variable (lemons info)"
        ))
    }

    /// Whether there is a value for each agent.
    pub fn is_of_agents(&self) -> bool {
        self.columns().is_some() || self.0.contains(EACH_AGENT)
    }

    /// The variables of a model that it is read from, for agents at these places.
    ///
    /// # Errors
    /// A sentence with the name that the model does not have.
    pub(crate) fn names(&self, model: &Model, agents: &[usize]) -> Result<Names, String> {
        let mut found = Names { place: model.parts().len() - 1, width: 1, ..Names::default() };
        if let Some(columns) = self.columns() {
            let columns: Vec<&columns::Quantity> = columns.collect();
            found.width = columns.len();
            for (agent, column) in agents.iter().flat_map(|agent| columns.iter().map(move |c| (agent, c))) {
                let name = format!("agent[{agent}].{}", column.variable);
                match column.kind() {
                    Kind::Integer => found.integers.push(name),
                    _ => found.reals.push(name),
                }
            }
            return Ok(found);
        }
        let name = &self.0;
        let (place, variable) = model.find(name);
        let names = match variable.split_once(EACH_AGENT) {
            Some((before, after)) => {
                agents.iter().map(|i| format!("{before}agent[{i}].{after}")).collect::<Vec<_>>()
            }
            None => vec![variable.to_owned()],
        };
        let fmu = &model.parts()[place].fmu;
        found.place = place;
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
