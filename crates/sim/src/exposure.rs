//! Exposure of a crowd: at worst, and since the last rows of a table.

use lemons_results::Frame;
use lemons_results::columns::{Effect, Merge, QUANTITIES};
use serde::{Deserialize, Serialize};

/// The extremes of a run, over whole communication steps where frames have such numbers.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Extremes {
    /// \[m\]
    pub largest_overlap: f64,
    /// The greatest mean squeeze of an agent over a step; the squeeze at a point where frames have no mean.
    pub mean_squeeze: Greatest,
    /// The greatest peak squeeze of an agent within a step.
    pub peak_squeeze: Greatest,
}

/// The greatest squeeze, and whose.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Greatest {
    /// \[N\]
    pub force: f64,
    /// Its place among the agents.
    pub agent: usize,
    /// \[s\] The end of the step.
    pub time: f64,
}

impl Extremes {
    /// Sees the frame at the end of a communication step, or at the first point (`start`), where numbers of steps are
    /// those of an instant.
    pub fn see(&mut self, frame: &Frame, start: bool) {
        for agent in 0..frame.agents.len() {
            let effect = |effect| frame.effects.get(effect, agent);
            match (effect(Effect::MeanNormalForce), effect(Effect::NormalForce)) {
                (Some(_), _) if start => {}
                (Some(mean), _) => {
                    let [peak, overlap] = [Effect::PeakNormalForce, Effect::PeakOverlap].map(effect);
                    self.mean_squeeze.see(mean, agent, frame.time);
                    self.peak_squeeze.see(peak.unwrap_or_default(), agent, frame.time);
                    self.largest_overlap = self.largest_overlap.max(overlap.unwrap_or_default());
                }
                (None, now) => self.mean_squeeze.see(now.unwrap_or_default(), agent, frame.time),
            }
        }
    }

    /// Returns whether all numbers are possible.
    pub fn are_possible(&self) -> bool {
        let possible = |number: f64| number >= 0.0 && number.is_finite();
        let of = |most: &Greatest| possible(most.force) && most.time.is_finite();
        possible(self.largest_overlap) && [self.mean_squeeze, self.peak_squeeze].iter().all(of)
    }
}

impl Greatest {
    fn see(&mut self, force: f64, agent: usize, time: f64) {
        if force > self.force {
            *self = Greatest { force, agent, time };
        }
    }
}

/// Effects on each agent over the communication steps since the last rows of a table.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ExposureSum {
    /// \[s\] The length of these steps.
    duration: f64,
    /// For each agent the quantities of whole steps, in the order of the table.
    agents: Vec<[f64; Effect::OF_STEPS]>,
}

impl ExposureSum {
    /// Returns whether there was no step.
    pub fn is_empty(&self) -> bool {
        self.agents.is_empty()
    }

    /// Adds the step of this length \[s\] that ends at a frame. Frames without numbers of steps add nothing.
    pub fn add(&mut self, length: f64, frame: &Frame) {
        if !frame.effects.knows(Effect::MeanNormalForce) {
            return;
        }
        self.duration += length;
        let part = if self.agents.is_empty() { 1.0 } else { length / self.duration };
        self.agents.resize(frame.agents.len(), Default::default());
        for (agent, sums) in self.agents.iter_mut().enumerate() {
            for (sum, (effect, merge)) in sums.iter_mut().zip(of_steps()) {
                let step = frame.effects.get(effect, agent).unwrap_or_default();
                *sum = match merge {
                    Merge::Mean => *sum + (step - *sum) * part,
                    Merge::Max => sum.max(step),
                    Merge::Last => step,
                };
            }
        }
    }

    /// Gives a frame the numbers of all these steps, and begins again.
    pub fn finish(&mut self, frame: &mut Frame) {
        for (agent, sums) in std::mem::take(self).agents.into_iter().enumerate() {
            for (sum, (effect, _)) in sums.into_iter().zip(of_steps()) {
                frame.effects.get_mut(effect, agent).into_iter().for_each(|number| *number = sum);
            }
        }
    }

    /// Returns for how many agents it has numbers.
    pub fn agents(&self) -> usize {
        self.agents.len()
    }

    /// Returns whether all numbers are possible.
    pub fn is_possible(&self) -> bool {
        // Only compressions may be below 0.
        let signed = [Effect::ChestFront, Effect::ChestSide, Effect::ChestLeast];
        let of_agent = |numbers: &[f64; Effect::OF_STEPS]| {
            numbers.iter().zip(of_steps()).all(|(number, (effect, _))| {
                number.is_finite() && (*number >= 0.0 || signed.contains(&effect))
            })
        };
        self.duration >= 0.0 && self.duration.is_finite() && self.agents.iter().all(of_agent)
    }
}

/// Returns the effects of whole steps, and how those of several steps become one.
fn of_steps() -> impl Iterator<Item = (Effect, Merge)> {
    QUANTITIES.iter().filter_map(|quantity| quantity.effect).filter(|(_, merge)| *merge != Merge::Last)
}
