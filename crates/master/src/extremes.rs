//! What a crowd went through: at worst, and since its last rows of a table.

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

/// Squeeze and overlap over the communication steps since the last rows of a table.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Since {
    /// \[s\] The length of these steps.
    duration: f64,
    /// Of each agent: mean squeeze \[N\], peak squeeze \[N\], deepest overlap \[m\].
    agents: Vec<[f64; 3]>,
}

impl Since {
    /// Whether there was no step.
    pub fn is_empty(&self) -> bool {
        self.agents.is_empty()
    }

    /// Adds a step of this length \[s\], or what is at the first point, with its mean, its peak and its deepest overlap.
    pub fn add(&mut self, length: f64, step: &[[f64; 3]]) {
        if self.agents.is_empty() {
            (self.duration, self.agents) = (length, step.to_vec());
            return;
        }
        let whole = self.duration + length;
        for ([mean, peak, overlap], step) in self.agents.iter_mut().zip(step) {
            *mean += (step[0] - *mean) * (length / whole);
            *peak = peak.max(step[1]);
            *overlap = overlap.max(step[2]);
        }
        self.duration = whole;
    }

    /// Of all these steps: for each agent the mean, the greatest peak and the deepest overlap.
    pub fn finish(self) -> Vec<[f64; 3]> {
        self.agents
    }

    /// For how many agents it has numbers.
    pub fn people(&self) -> usize {
        self.agents.len()
    }

    /// Whether its numbers are possible.
    pub(crate) fn is_sound(&self) -> bool {
        let all = self.agents.iter().flatten().chain([&self.duration]);
        all.into_iter().all(|number| *number >= 0.0 && number.is_finite())
    }
}
