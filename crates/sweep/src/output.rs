//! Which outputs of a run are looked at, and when they end a point before its time.

use lemons_core::require;
use lemons_core::trial::Trial;
use lemons_results::Frame;
use lemons_sim::settings::VariableSelection;
use lemons_sim::{SimError, Simulation};
use serde::Deserialize;

/// An output: a quantity of each agent of the crowd, such as `x` or `mean_squeeze`, or the name of a variable, with its
/// component if that is not the crowd: `decision.Arrived`. With `agent[*]` it is one of each agent.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
#[serde(transparent)]
pub struct Of(String);

/// The quantities of agents, each with the variables that it is computed from: of two, it is the length of the vector.
const QUANTITIES: [(&str, &[&str]); 12] = [
    ("x", &["Position.x"]),
    ("y", &["Position.y"]),
    ("theta", &["Theta"]),
    ("speed", &["Velocity.x", "Velocity.y"]),
    ("omega", &["Omega"]),
    // At a communication point: it may miss a short collision.
    ("squeeze", &["NormalForce"]),
    ("mean_squeeze", &["MeanNormalForce"]),
    ("peak_squeeze", &["PeakNormalForce"]),
    ("peak_overlap", &["PeakOverlap"]),
    ("agent_contacts", &["AgentContacts"]),
    ("wall_contacts", &["WallContacts"]),
    ("contacting_agents", &["ContactingAgents"]),
];

/// Stands for each agent in the name of a variable.
const EACH_AGENT: &str = "agent[*].";

/// Values that are read together.
pub(crate) struct Reading {
    selection: VariableSelection,
    /// The number of variables that become one value: the components of a vector.
    width: usize,
    /// The place of the agent of each value; empty if they are of no agents.
    agents: Vec<usize>,
}

impl Reading {
    /// Returns the number of values, of which each is one number over time.
    pub fn values(&self) -> usize {
        self.agents.len().max(1)
    }

    /// Returns the values at a communication point; `None` of agents who have left.
    pub fn read(&self, simulation: &mut Simulation, frame: &Frame) -> Result<Vec<Option<f64>>, SimError> {
        let numbers = simulation.read(&self.selection)?;
        let values = numbers.chunks_exact(self.width).map(|of| match of {
            [value] => *value,
            parts => parts.iter().map(|part| part * part).sum::<f64>().sqrt(),
        });
        let there = |place| self.agents.get(place).is_none_or(|agent| frame.is_there(*agent));
        Ok(values.enumerate().map(|(place, value)| there(place).then_some(value)).collect())
    }
}

impl Of {
    /// Returns the variables of a quantity of agents.
    fn variables(&self) -> Option<&'static [&'static str]> {
        QUANTITIES.iter().find(|(name, _)| *name == self.0).map(|(_, variables)| *variables)
    }

    /// Checks that it can be the name of a variable, of agents if there are Ids of some.
    ///
    /// # Errors
    /// A sentence with the value.
    pub fn check(&self, agents: &[String]) -> Result<(), String> {
        let name = &self.0;
        // Quantities are the only names without a capital letter or a component.
        let known = self.variables().is_some() || name.contains(|c: char| c == '.' || c.is_uppercase());
        require(known, || {
            format!(
                "of = {name:?}: neither a quantity (lemons sweep --help) nor the name of a variable (lemons info)"
            )
        })?;
        let fits = self.is_of_agents() || agents.is_empty();
        require(fits, || "agents: it is one value, and not one of each agent".into())
    }

    /// Returns whether there is a value for each agent.
    pub fn is_of_agents(&self) -> bool {
        self.variables().is_some() || self.0.contains(EACH_AGENT)
    }

    /// Finds the variables that it is read from, for agents of a Trial with these Ids, by default all of them.
    ///
    /// # Errors
    /// A sentence with the name that the simulation does not have.
    pub(crate) fn reading(
        &self,
        simulation: &Simulation,
        trial: &Trial,
        agents: &[String],
    ) -> Result<Reading, String> {
        let name = &self.0;
        let agents = if self.is_of_agents() { agents_named(trial, agents)? } else { Vec::new() };
        let (names, width): (Vec<String>, usize) = match (self.variables(), name.split_once(EACH_AGENT)) {
            (Some(of), _) => {
                let of_each = |i| of.iter().map(move |variable| format!("agent[{i}].{variable}"));
                (agents.iter().flat_map(of_each).collect(), of.len())
            }
            (None, Some((before, after))) => {
                (agents.iter().map(|i| format!("{before}agent[{i}].{after}")).collect(), 1)
            }
            (None, None) => (vec![name.clone()], 1),
        };
        let selection = simulation.select(&names).map_err(|(single, meant)| {
            let meant = meant.map(|meant| format!("; did you mean {meant:?}?")).unwrap_or_default();
            format!("of = {name:?}: there is no variable {single:?} with a number{meant}")
        })?;
        Ok(Reading { selection, width, agents })
    }
}

/// Returns the places of agents by their Ids; without Ids, all of them.
///
/// # Errors
/// A sentence with an Id.
pub(crate) fn agents_named(trial: &Trial, ids: &[String]) -> Result<Vec<usize>, String> {
    let known = &trial.agents;
    if ids.is_empty() {
        return Ok((0..known.len()).collect());
    }
    let mut places = Vec::new();
    for id in ids {
        let place = known.iter().position(|agent| agent.id == *id);
        let place = place.ok_or_else(|| format!("there is no agent {id:?}"))?;
        require(!places.contains(&place), || format!("agents: {id:?} is named twice"))?;
        places.push(place);
    }
    Ok(places)
}

/// A condition that ends a point at the first communication point where it holds.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Stop {
    /// The output.
    pub of: Of,
    /// The value is this or more.
    pub at_least: Option<f64>,
    /// The value is this or less.
    pub at_most: Option<f64>,
    /// Ids of agents in Agents.xml, for all of which it must hold; empty: all agents.
    #[serde(default)]
    pub agents: Vec<String>,
}

impl Stop {
    /// Checks that it is complete.
    ///
    /// # Errors
    /// A sentence that names what is missing.
    pub fn check(&self) -> Result<(), String> {
        self.of.check(&self.agents)?;
        let ((Some(limit), None) | (None, Some(limit))) = (self.at_least, self.at_most) else {
            return Err("it needs one of at_least and at_most".into());
        };
        require(limit.is_finite(), || "its limit must be a finite number".into())
    }

    /// Returns whether it holds for all these values. Those of agents who have left (`None`) do not count; for nobody it does not
    /// hold.
    pub(crate) fn holds(&self, values: &[Option<f64>]) -> bool {
        let beyond = |value: f64| {
            self.at_least.is_none_or(|least| value >= least) && self.at_most.is_none_or(|most| value <= most)
        };
        let mut there = values.iter().flatten().copied().peekable();
        there.peek().is_some() && there.all(beyond)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_holds_for_all_or_not_at_all() {
        let stop = |text: &str| toml::from_str::<Stop>(text).unwrap();
        let least = stop("of = 'x'\nat_least = 2");
        assert!(least.holds(&[2.0, 3.0].map(Some)) && !least.holds(&[2.0, 1.9].map(Some)));
        assert!(!least.holds(&[2.0, f64::NAN].map(Some)));
        assert!(least.holds(&[None, Some(2.0)]) && !least.holds(&[None, None]));
        let most = stop("of = 'decision.Left'\nat_most = 0");
        assert!(most.holds(&[0.0].map(Some)) && !most.holds(&[1.0].map(Some)));
        for (text, message) in [
            ("of = 'x'", "one of at_least and at_most"),
            ("of = 'x'\nat_least = 1\nat_most = 2", "one of at_least and at_most"),
            ("of = 'x'\nat_least = inf", "finite"),
            ("of = 'mood'\nat_least = 1", "of = \"mood\": neither a quantity"),
            ("of = 'decision.Arrived'\nat_least = 1\nagents = ['3']", "agents"),
        ] {
            let error = stop(text).check().unwrap_err();
            assert!(error.contains(message), "{error}");
        }
    }
}
