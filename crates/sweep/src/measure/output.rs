//! Numbers computed from the values of an output at the communication points.

use crate::measure::across::Across;
use crate::output::Of;
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
        self.of.check()?;
        let (take, seeks) = match self.take {
            Take::FirstAbove => ("first_above", true),
            Take::FirstAtLeast => ("first_at_least", true),
            _ => ("", false),
        };
        match self.level {
            None if seeks => return Err(format!("take = {take:?} needs a level")),
            Some(level) if seeks && !level.is_finite() => return Err("level is not finite".into()),
            Some(_) if !seeks => {
                return Err("level needs take = \"first_above\" or \"first_at_least\"".into());
            }
            _ => {}
        }
        if !self.of.is_of_agents() && !self.agents.is_empty() {
            return Err("agents: it is one value, and not one of each agent".into());
        }
        let single = matches!(self.take, Take::Max | Take::Min | Take::Mean);
        if agents > 1 && !single && self.across.is_none() {
            return Err(format!("has {agents} agents: {}", Across::NEEDED));
        }
        Ok(())
    }

    fn across(&self) -> Across {
        self.across.unwrap_or(match self.take {
            Take::Max => Across::Max,
            Take::Min => Across::Min,
            _ => Across::Mean,
        })
    }
}

/// A measure during its run.
pub(crate) struct OutputAccumulator<'a> {
    measure: &'a OfOutput,
    agents: Vec<Statistics>,
}

/// The values of one agent so far, as long as it is there.
struct Statistics {
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

impl<'a> OutputAccumulator<'a> {
    pub fn new(measure: &'a OfOutput) -> OutputAccumulator<'a> {
        OutputAccumulator { measure, agents: Vec::new() }
    }

    /// Adds the values of all its agents at a time \[s\]; `None` for those who have left.
    pub fn add(&mut self, time: f64, values: &[Option<f64>]) {
        let level = self.measure.level.unwrap_or(f64::INFINITY);
        let or_equal = self.measure.take == Take::FirstAtLeast;
        let reaches = |value: f64| value > level || (or_equal && value == level);
        let begins = self.agents.is_empty();
        for (k, value) in values.iter().enumerate() {
            if begins {
                self.agents.push(Statistics::default());
            }
            let (Some(agent), Some(value)) = (self.agents.get_mut(k), *value) else { continue };
            agent.last = value;
            agent.least = agent.least.min(value);
            agent.greatest = agent.greatest.max(value);
            // A mean is that of the steps, not of the start.
            if !begins {
                agent.sum += value;
                agent.steps += 1;
            }
            agent.first.get_or_insert(value);
            if agent.reached.is_none() && reaches(value) {
                agent.reached = Some(time);
            }
        }
    }

    /// Returns the result. It is `None` where an agent that counts never reached the level: the latest of several, and
    /// their mean, have all of them; the earliest has those who did.
    pub fn value(&self) -> Option<f64> {
        let of = |agent: &Statistics| match self.measure.take {
            Take::Max => Some(agent.greatest),
            Take::Min => Some(agent.least),
            Take::Mean => Some(agent.sum / f64::from(agent.steps)),
            Take::Last => Some(agent.last),
            Take::Change => Some(agent.last - agent.first?),
            Take::Reach => Some((agent.greatest - agent.first?).max(agent.first? - agent.least)),
            Take::FirstAbove | Take::FirstAtLeast => agent.reached,
        };
        // Who never was there says nothing, nor does who was there in no step.
        let steps = if self.measure.take == Take::Mean { 1 } else { 0 };
        let known = self.agents.iter().filter(|agent| agent.first.is_some() && agent.steps >= steps);
        // Who never reaches it does so later than anybody else.
        let values = known.map(|agent| of(agent).unwrap_or(f64::INFINITY));
        let result = self.measure.across().of(values);
        let seeks = matches!(self.measure.take, Take::FirstAbove | Take::FirstAtLeast);
        result.filter(|value| !(seeks && value.is_infinite()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value(text: &str) -> Option<f64> {
        let measure: OfOutput = toml::from_str(text).unwrap();
        measure.check(2).unwrap();
        let mut accumulator = OutputAccumulator::new(&measure);
        for (time, values) in [(0.0, [1.0, 4.0]), (0.5, [3.0, 0.0]), (1.0, [2.0, 2.0])] {
            accumulator.add(time, &values.map(Some));
        }
        accumulator.value()
    }

    /// The second of two leaves after half a second.
    #[test]
    fn who_has_left_does_not_count() {
        for (text, expected) in [
            ("of = 'x'\ntake = 'mean'\nacross = 'min'", 0.0),
            ("of = 'x'\ntake = 'mean'\nacross = 'max'", 2.5),
            ("of = 'x'\ntake = 'last'\nacross = 'min'", 0.0),
            ("of = 'x'\ntake = 'min'\nacross = 'max'", 1.0),
        ] {
            let measure: OfOutput = toml::from_str(text).unwrap();
            let mut accumulator = OutputAccumulator::new(&measure);
            for (time, values) in
                [(0.0, [Some(1.0), Some(4.0)]), (0.5, [Some(3.0), Some(0.0)]), (1.0, [Some(2.0), None])]
            {
                accumulator.add(time, &values);
            }
            assert_eq!(accumulator.value(), Some(expected), "{text}");
        }
    }

    /// It was 0, which is a number that nobody measured.
    #[test]
    fn a_mean_over_no_step_is_not_known() {
        let measure: OfOutput = toml::from_str("of = 'x'\ntake = 'mean'").unwrap();
        let mut accumulator = OutputAccumulator::new(&measure);
        accumulator.add(0.0, &[Some(3.0), Some(5.0)]);
        assert_eq!(accumulator.value(), None);
        accumulator.add(0.5, &[Some(2.0), None]);
        assert_eq!(accumulator.value(), Some(2.0));
    }

    #[test]
    fn numbers_of_two_agents() {
        for (text, expected) in [
            ("of = 'x'\ntake = 'max'", Some(4.0)),
            ("of = 'x'\ntake = 'min'", Some(0.0)),
            ("of = 'x'\ntake = 'max'\nacross = 'min'", Some(3.0)),
            ("of = 'x'\ntake = 'mean'", Some(1.75)),
            ("of = 'x'\ntake = 'last'\nacross = 'mean'", Some(2.0)),
            ("of = 'x'\ntake = 'change'\nacross = 'min'", Some(-2.0)),
            ("of = 'x'\ntake = 'reach'\nacross = 'max'", Some(4.0)),
            ("of = 'x'\ntake = 'first_above'\nlevel = 2.5\nacross = 'max'", Some(0.5)),
            ("of = 'x'\ntake = 'first_above'\nlevel = 2.5\nacross = 'min'", Some(0.0)),
            ("of = 'x'\ntake = 'first_above'\nlevel = 5\nacross = 'min'", None),
            ("of = 'x'\ntake = 'first_above'\nlevel = 3\nacross = 'min'", Some(0.0)),
            ("of = 'x'\ntake = 'first_at_least'\nlevel = 3\nacross = 'max'", Some(0.5)),
            ("of = 'agent[*].Y'\ntake = 'first_at_least'\nlevel = 4\nacross = 'min'", Some(0.0)),
            // One of the two never gets there.
            ("of = 'x'\ntake = 'first_above'\nlevel = 3\nacross = 'max'", None),
            ("of = 'x'\ntake = 'first_above'\nlevel = 3\nacross = 'mean'", None),
        ] {
            assert_eq!(value(text), expected, "{text}");
        }
    }

    #[test]
    fn what_is_missing_is_said() {
        let said = |text: &str, agents| toml::from_str::<OfOutput>(text).unwrap().check(agents).unwrap_err();
        assert!(said("of = 'x'\ntake = 'last'", 2).contains("across"));
        assert!(said("of = 'x'\ntake = 'first_above'", 1).contains("level"));
        assert!(said("of = 'x'\ntake = 'max'\nlevel = 1", 1).contains("level"));
        assert!(said("of = 'x'\ntake = 'first_at_least'", 1).contains("\"first_at_least\" needs a level"));
        assert!(said("of = 'mood'\ntake = 'max'", 1).contains("of = \"mood\": neither a quantity"));
        assert!(said("of = 'decision.Arrived'\ntake = 'last'\nagents = ['0']", 1).contains("agents"));
    }
}
