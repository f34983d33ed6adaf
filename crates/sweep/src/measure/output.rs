//! Numbers computed from the values of an output at the communication points.

use crate::measure::check_across;
use crate::output::Of;
use lemons_core::require;
use lemons_results::measure::Across;
use serde::Deserialize;

/// How the values of an output over time become one number.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Take {
    /// The largest value.
    Max,
    /// The smallest value.
    Min,
    /// The mean of all values except that at the start.
    Mean,
    /// The value at the end.
    Last,
    /// The value at the end minus that at the start.
    Change,
    /// The largest distance from the value at the start.
    Reach,
    /// \[s\] The first time at which the value is above `level`; missing if it never is.
    FirstAbove,
    /// \[s\] The first time at which the value is `level` or more; missing if it never is.
    FirstAtLeast,
}

/// A measure of an output.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OfOutput {
    /// The output.
    pub of: Of,
    /// The function of its values over time.
    pub take: Take,
    /// The level for [`Take::FirstAbove`] and [`Take::FirstAtLeast`].
    pub level: Option<f64>,
    /// Ids of agents in Agents.xml; empty: all agents.
    #[serde(default)]
    pub agents: Vec<String>,
    /// The function over several agents. If it is missing, it is that of `take` for `max`, `min` and `mean`.
    pub across: Option<Across>,
}

impl OfOutput {
    /// Checks that the measure is complete, for a number of values.
    ///
    /// # Errors
    /// A sentence that names what is missing.
    pub fn check(&self, agents: usize) -> Result<(), String> {
        self.of.check(&self.agents)?;
        let take = match self.take {
            Take::FirstAbove => Some("first_above"),
            Take::FirstAtLeast => Some("first_at_least"),
            _ => None,
        };
        match (take, self.level) {
            (Some(take), None) => return Err(format!("take = {take:?} needs a level")),
            (None, Some(_)) => {
                return Err("level needs take = \"first_above\" or \"first_at_least\"".into());
            }
            (_, level) => require(level.is_none_or(f64::is_finite), || "level is not finite")?,
        }
        let single = agents <= 1 || matches!(self.take, Take::Max | Take::Min | Take::Mean);
        check_across(self.across, if single { 1 } else { agents })
    }

    /// Adds the values of all its agents at a time \[s\]; `None` for those who have left.
    pub(crate) fn add(&self, agents: &mut Vec<Statistics>, time: f64, values: &[Option<f64>]) {
        let level = self.level.unwrap_or(f64::INFINITY);
        let or_equal = self.take == Take::FirstAtLeast;
        let begins = agents.is_empty();
        agents.resize_with(values.len(), Statistics::default);
        for (agent, value) in agents.iter_mut().zip(values) {
            let Some(value) = *value else { continue };
            agent.last = value;
            agent.least = agent.least.min(value);
            agent.greatest = agent.greatest.max(value);
            // A mean is that of the steps, not of the start.
            if !begins {
                agent.sum += value;
                agent.steps += 1;
            }
            agent.first.get_or_insert(value);
            if agent.reached.is_none() && (value > level || or_equal && value == level) {
                agent.reached = Some(time);
            }
        }
    }

    /// Returns the result. It is `None` where an agent that counts never reached the level: the latest of several, and
    /// their mean, have all of them; the earliest has those who did.
    pub(crate) fn value(&self, agents: &[Statistics]) -> Option<f64> {
        let of = |agent: &Statistics| match self.take {
            Take::Max => Some(agent.greatest),
            Take::Min => Some(agent.least),
            Take::Mean => Some(agent.sum / f64::from(agent.steps)),
            Take::Last => Some(agent.last),
            Take::Change => Some(agent.last - agent.first?),
            Take::Reach => Some((agent.greatest - agent.first?).max(agent.first? - agent.least)),
            Take::FirstAbove | Take::FirstAtLeast => agent.reached,
        };
        // Who never was there says nothing, nor does who was there in no step.
        let steps = if self.take == Take::Mean { 1 } else { 0 };
        let known = agents.iter().filter(|agent| agent.first.is_some() && agent.steps >= steps);
        // Who never reaches it does so later than anybody else.
        let values = known.map(|agent| of(agent).unwrap_or(f64::INFINITY));
        let across = self.across.unwrap_or(match self.take {
            Take::Max => Across::Max,
            Take::Min => Across::Min,
            _ => Across::Mean,
        });
        let seeks = matches!(self.take, Take::FirstAbove | Take::FirstAtLeast);
        across.of(values).filter(|value| !(seeks && value.is_infinite()))
    }
}

/// The values of one agent so far, as long as it is there.
pub(crate) struct Statistics {
    /// `None` as long as it was not there.
    first: Option<f64>,
    last: f64,
    least: f64,
    greatest: f64,
    sum: f64,
    steps: u32,
    /// \[s\] When the level was reached.
    reached: Option<f64>,
}

impl Default for Statistics {
    fn default() -> Statistics {
        let (least, greatest) = (f64::INFINITY, f64::NEG_INFINITY);
        Statistics { first: None, last: 0.0, least, greatest, sum: 0.0, steps: 0, reached: None }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value(text: &str, steps: &[(f64, [Option<f64>; 2])]) -> Option<f64> {
        let measure: OfOutput = toml::from_str(text).unwrap();
        let mut agents = Vec::new();
        steps.iter().for_each(|(time, values)| measure.add(&mut agents, *time, values));
        measure.value(&agents)
    }

    #[test]
    fn numbers_of_two_agents() {
        let both = [(0.0, [1.0, 4.0]), (0.5, [3.0, 0.0]), (1.0, [2.0, 2.0])];
        let both = both.map(|(time, values)| (time, values.map(Some)));
        // The second of them leaves after half a second.
        let mut leaves = both;
        leaves[2].1[1] = None;
        // A mean over no step is not known.
        let (start, step) = ([(0.0, [Some(3.0), Some(5.0)])], [both[0], (0.5, [Some(2.0), None])]);
        for (text, expected, steps) in [
            ("take = 'max'", Some(4.0), &both[..]),
            ("take = 'min'", Some(0.0), &both),
            ("take = 'max'\nacross = 'min'", Some(3.0), &both),
            ("take = 'mean'", Some(1.75), &both),
            ("take = 'last'\nacross = 'mean'", Some(2.0), &both),
            ("take = 'change'\nacross = 'min'", Some(-2.0), &both),
            ("take = 'reach'\nacross = 'max'", Some(4.0), &both),
            ("take = 'first_above'\nlevel = 2.5\nacross = 'max'", Some(0.5), &both),
            ("take = 'first_above'\nlevel = 2.5\nacross = 'min'", Some(0.0), &both),
            ("take = 'first_above'\nlevel = 5\nacross = 'min'", None, &both),
            ("take = 'first_above'\nlevel = 3\nacross = 'min'", Some(0.0), &both),
            ("take = 'first_at_least'\nlevel = 3\nacross = 'max'", Some(0.5), &both),
            ("take = 'first_at_least'\nlevel = 4\nacross = 'min'", Some(0.0), &both),
            // One of the two never gets there.
            ("take = 'first_above'\nlevel = 3\nacross = 'max'", None, &both),
            ("take = 'first_above'\nlevel = 3\nacross = 'mean'", None, &both),
            ("take = 'mean'\nacross = 'min'", Some(0.0), &leaves),
            ("take = 'mean'\nacross = 'max'", Some(2.5), &leaves),
            ("take = 'last'\nacross = 'min'", Some(0.0), &leaves),
            ("take = 'min'\nacross = 'max'", Some(1.0), &leaves),
            ("take = 'mean'", None, &start),
            ("take = 'mean'", Some(2.0), &step),
        ] {
            assert_eq!(value(&format!("of = 'x'\n{text}"), steps), expected, "{text}");
        }
    }

    #[test]
    fn what_is_missing_is_said() {
        for (text, agents, message) in [
            ("of = 'x'\ntake = 'last'", 2, "across"),
            ("of = 'x'\ntake = 'first_above'", 1, "\"first_above\" needs a level"),
            ("of = 'x'\ntake = 'max'\nlevel = 1", 1, "level needs take"),
            ("of = 'x'\ntake = 'first_at_least'", 1, "\"first_at_least\" needs a level"),
        ] {
            let error = toml::from_str::<OfOutput>(text).unwrap().check(agents).unwrap_err();
            assert!(error.contains(message), "{text}: {error}");
        }
    }
}
