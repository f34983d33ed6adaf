//! Measures: numbers computed from the outputs of a run at the communication points.

use lemons_record::columns;
use serde::{Deserialize, Serialize};

/// An output of each agent.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Of {
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

impl Of {
    /// Names of the Real outputs it is computed from, and of the Integer ones.
    pub(crate) fn outputs(self) -> (&'static [&'static str], &'static [&'static str]) {
        match self {
            Of::X => (&[columns::X.variable], &[]),
            Of::Y => (&[columns::Y.variable], &[]),
            Of::Theta => (&[columns::THETA.variable], &[]),
            Of::Speed => (&[columns::VX.variable, columns::VY.variable], &[]),
            Of::Omega => (&[columns::OMEGA.variable], &[]),
            Of::Squeeze => (&[columns::SQUEEZE.variable], &[]),
            Of::MeanSqueeze => (&[columns::MEAN_SQUEEZE.variable], &[]),
            Of::PeakSqueeze => (&[columns::PEAK_SQUEEZE.variable], &[]),
            Of::PeakOverlap => (&[columns::PEAK_OVERLAP.variable], &[]),
            Of::AgentContacts => (&[], &[columns::AGENT_CONTACTS.variable]),
            Of::WallContacts => (&[], &[columns::WALL_CONTACTS.variable]),
            Of::ContactingAgents => (&[], &[columns::CONTACTING_AGENTS.variable]),
        }
    }
}

/// How the values of an output over time become one number.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
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
}

/// How the numbers of several agents become one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Across {
    /// The largest.
    Max,
    /// The smallest.
    Min,
    /// Their mean.
    Mean,
}

/// A measure.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Measure {
    /// The output.
    pub of: Of,
    /// The function of its values over time.
    pub take: Take,
    /// The level for [`Take::FirstAbove`].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub level: Option<f64>,
    /// Ids of agents in Agents.xml; empty: all agents.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub agents: Vec<String>,
    /// The function over several agents. If it is missing, it is that of `take` for `max`, `min` and `mean`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub across: Option<Across>,
}

impl Measure {
    /// Checks that the measure is complete, for a number of agents.
    ///
    /// # Errors
    /// A sentence that names what is missing.
    pub fn check(&self, agents: usize) -> Result<(), String> {
        match (self.take, self.level) {
            (Take::FirstAbove, None) => return Err("take = \"first_above\" needs a level".into()),
            (Take::FirstAbove, Some(level)) if !level.is_finite() => return Err("level is not finite".into()),
            (Take::FirstAbove, Some(_)) | (_, None) => {}
            (_, Some(_)) => return Err("level needs take = \"first_above\"".into()),
        }
        let single = matches!(self.take, Take::Max | Take::Min | Take::Mean);
        if agents > 1 && !single && self.across.is_none() {
            return Err(format!("has {agents} agents: it needs across = \"max\", \"min\" or \"mean\""));
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
pub(crate) struct Watched<'a> {
    measure: &'a Measure,
    agents: Vec<Course>,
}

/// The values of one agent so far.
struct Course {
    first: f64,
    last: f64,
    least: f64,
    greatest: f64,
    sum: f64,
    steps: u32,
    above: Option<f64>,
}

impl<'a> Watched<'a> {
    pub fn new(measure: &'a Measure) -> Watched<'a> {
        Watched { measure, agents: Vec::new() }
    }

    /// Adds the values of all its agents at a time \[s\].
    pub fn look(&mut self, time: f64, values: impl Iterator<Item = f64>) {
        let level = self.measure.level.unwrap_or(f64::INFINITY);
        if self.agents.is_empty() {
            let begin = |value: f64| Course {
                first: value,
                last: value,
                least: value,
                greatest: value,
                sum: 0.0,
                steps: 0,
                above: (value > level).then_some(time),
            };
            self.agents = values.map(begin).collect();
            return;
        }
        for (course, value) in self.agents.iter_mut().zip(values) {
            course.last = value;
            course.least = course.least.min(value);
            course.greatest = course.greatest.max(value);
            course.sum += value;
            course.steps += 1;
            if course.above.is_none() && value > level {
                course.above = Some(time);
            }
        }
    }

    /// Returns the result; `None` if there is none because no agent reached the level.
    pub fn value(&self) -> Option<f64> {
        let of = |course: &Course| match self.measure.take {
            Take::Max => Some(course.greatest),
            Take::Min => Some(course.least),
            Take::Mean => Some(course.sum / f64::from(course.steps.max(1))),
            Take::Last => Some(course.last),
            Take::Change => Some(course.last - course.first),
            Take::Reach => Some((course.greatest - course.first).max(course.first - course.least)),
            Take::FirstAbove => course.above,
        };
        let values: Vec<f64> = self.agents.iter().filter_map(of).collect();
        let count = values.len() as f64;
        match self.measure.across() {
            Across::Max => values.into_iter().reduce(f64::max),
            Across::Min => values.into_iter().reduce(f64::min),
            Across::Mean => values.into_iter().reduce(|a, b| a + b).map(|sum| sum / count),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value(text: &str) -> Option<f64> {
        let measure: Measure = toml::from_str(text).unwrap();
        measure.check(2).unwrap();
        let mut watched = Watched::new(&measure);
        for (time, values) in [(0.0, [1.0, 4.0]), (0.5, [3.0, 0.0]), (1.0, [2.0, 2.0])] {
            watched.look(time, values.into_iter());
        }
        watched.value()
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
        ] {
            assert_eq!(value(text), expected, "{text}");
        }
    }

    #[test]
    fn what_is_missing_is_said() {
        let said = |text: &str, agents| toml::from_str::<Measure>(text).unwrap().check(agents).unwrap_err();
        assert!(said("of = 'x'\ntake = 'last'", 2).contains("across"));
        assert!(said("of = 'x'\ntake = 'first_above'", 1).contains("level"));
        assert!(said("of = 'x'\ntake = 'max'\nlevel = 1", 1).contains("level"));
        assert!(toml::from_str::<Measure>("of = 'mood'\ntake = 'max'").is_err());
    }
}
