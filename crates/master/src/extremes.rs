//! What a crowd went through at worst.

use serde::{Deserialize, Serialize};

/// The extremes of a run, over whole communication steps where the FMU has such outputs.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Extremes {
    /// \[m\]
    pub largest_overlap: f64,
    /// The greatest `MeanNormalForce` of an agent; `NormalForce` where the FMU has no mean.
    pub mean_squeeze: Greatest,
    /// The greatest `PeakNormalForce` of an agent.
    pub peak_squeeze: Greatest,
}

/// The greatest squeeze, and whose.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Greatest {
    /// \[N\]
    pub force: f64,
    /// Among the agents.
    pub agent: usize,
    /// \[s\] at the end of the step.
    pub time: f64,
}

impl Greatest {
    /// The forces \[N\] on all agents at a time \[s\].
    pub fn see(&mut self, forces: impl IntoIterator<Item = f64>, time: f64) {
        for (agent, force) in forces.into_iter().enumerate() {
            if force > self.force {
                *self = Greatest { force, agent, time };
            }
        }
    }
}
