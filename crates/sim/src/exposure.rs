//! Exposure of a crowd: at worst, and since the last rows of a table.

use lemons_results::{Frame, OfStep};
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
        for (agent, observed) in frame.observed.iter().flatten().enumerate() {
            match observed.of_step {
                None => self.mean_squeeze.see(observed.normal_force, agent, frame.time),
                Some(_) if start => {}
                Some(step) => {
                    self.mean_squeeze.see(step.mean_normal_force, agent, frame.time);
                    self.peak_squeeze.see(step.peak_normal_force, agent, frame.time);
                    self.largest_overlap = self.largest_overlap.max(step.peak_overlap);
                }
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

/// Squeeze and overlap of each agent over the communication steps since the last rows of a table.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ExposureSum {
    /// \[s\] The length of these steps.
    duration: f64,
    /// For each agent: mean squeeze \[N\], peak squeeze \[N\], deepest overlap \[m\], mean squeeze by walls \[N\].
    agents: Vec<[f64; 4]>,
}

impl ExposureSum {
    /// Returns whether there was no step.
    pub fn is_empty(&self) -> bool {
        self.agents.is_empty()
    }

    /// Adds the step of this length \[s\] that ends at a frame. Frames without numbers of steps add nothing.
    pub fn add(&mut self, length: f64, frame: &Frame) {
        let steps = frame.observed.iter().flatten().filter_map(|observed| observed.of_step);
        let steps = steps.map(|step| {
            let by_walls = step.mean_wall_force.unwrap_or_default();
            [step.mean_normal_force, step.peak_normal_force, step.peak_overlap, by_walls]
        });
        if self.agents.is_empty() {
            (self.duration, self.agents) = (length, steps.collect());
            return;
        }
        let whole = self.duration + length;
        for ([mean, peak, overlap, by_walls], step) in self.agents.iter_mut().zip(steps) {
            *mean += (step[0] - *mean) * (length / whole);
            *by_walls += (step[3] - *by_walls) * (length / whole);
            *peak = peak.max(step[1]);
            *overlap = overlap.max(step[2]);
        }
        self.duration = whole;
    }

    /// Gives a frame the numbers of all these steps, and begins again.
    pub fn finish(&mut self, frame: &mut Frame) {
        let sum = std::mem::take(self);
        let all = frame.observed.iter_mut().flatten().zip(sum.agents);
        for (observed, [mean_normal_force, peak_normal_force, peak_overlap, by_walls]) in all {
            let known = observed.of_step.is_some_and(|step| step.mean_wall_force.is_some());
            let mean_wall_force = known.then_some(by_walls);
            observed.of_step =
                Some(OfStep { mean_normal_force, mean_wall_force, peak_normal_force, peak_overlap });
        }
    }

    /// Returns for how many agents it has numbers.
    pub fn agents(&self) -> usize {
        self.agents.len()
    }

    /// Returns whether all numbers are possible.
    pub fn is_possible(&self) -> bool {
        let mut all = self.agents.iter().flatten().chain([&self.duration]);
        all.all(|number| *number >= 0.0 && number.is_finite())
    }
}
