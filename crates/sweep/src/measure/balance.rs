//! How people who have legs keep their balance.

use crate::measure::Across;
use lemons_results::measure::{Balance, Kept};
use serde::Deserialize;

/// A measure of how people keep their balance.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OfBalance {
    /// What of it.
    pub balance: What,
    /// Ids of agents in Agents.xml; empty: all agents.
    #[serde(default)]
    pub agents: Vec<String>,
    /// The function over several agents.
    pub across: Option<Across>,
    /// \[s\] From this time on.
    pub from: Option<f64>,
    /// \[s\] Up to this time.
    pub until: Option<f64>,
}

/// How somebody kept the balance.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum What {
    /// \[s\] For how long they needed a step.
    TimeUnbalanced,
    /// The number of their steps.
    Steps,
    /// 1 for who fell, 0 for others.
    Falls,
    /// \[m\] The largest distance of the centre of mass from the feet.
    Lean,
}

impl OfBalance {
    /// Returns the number of what was seen of the agents at these places; `None` if people have no legs.
    pub(crate) fn value(&self, agents: &[usize], seen: Balance) -> Option<f64> {
        let of = |one: &Kept| match self.balance {
            What::TimeUnbalanced => one.time_unbalanced,
            What::Steps => one.steps.into(),
            What::Falls => one.fallen.into(),
            What::Lean => one.lean,
        };
        let kept = seen.finish()?;
        self.across.unwrap_or(Across::Max).of(agents.iter().map(|agent| of(&kept[*agent])))
    }
}
