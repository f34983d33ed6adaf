//! How long trunks are pressed so hard that breathing tires.

use crate::measure::number_of;
use lemons_results::measure::{Across, BreathingOverTime};
use serde::Deserialize;

/// A measure of how trunks are pressed.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BreathingMeasure {
    /// A number of [`Breathing`](lemons_results::measure::Breathing).
    pub breathing: String,
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

impl BreathingMeasure {
    /// Returns the number of what was seen of the agents at these places; `None` if the load on chests is not found.
    pub(crate) fn value(&self, agents: &[usize], seen: BreathingOverTime) -> Option<f64> {
        let pressed = seen.finish().ok()?;
        let values = agents.iter().filter_map(|agent| number_of(&self.breathing, &pressed[*agent]));
        self.across.unwrap_or(Across::Max).of(values)
    }
}
