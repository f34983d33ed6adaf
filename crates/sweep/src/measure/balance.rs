//! How people who have legs keep their balance.

use crate::measure::number_of;
use lemons_results::measure::{Across, BalanceOverTime};
use serde::Deserialize;

/// A measure of how people keep their balance.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BalanceMeasure {
    /// A number of [`Kept`](lemons_results::measure::Kept).
    pub balance: String,
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

impl BalanceMeasure {
    /// Returns the number of what was seen of the agents at these places; `None` if people have no legs.
    pub(crate) fn value(&self, agents: &[usize], seen: BalanceOverTime) -> Option<f64> {
        let kept = seen.finish()?;
        let values = agents.iter().filter_map(|agent| number_of(&self.balance, &kept[*agent]));
        self.across.unwrap_or(Across::Max).of(values)
    }
}
