//! What was recorded of a crowd.

use crate::error::ExportError;
use crowd_mechanics::engine::Vec2;
use crowd_mechanics::trial::{AgentDynamics, Interactions, Trial};
use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;

/// The motion of a crowd at communication points.
#[derive(Debug, Clone)]
pub struct Run {
    /// Where it was read from.
    pub source: PathBuf,
    /// Of the agents, as in `Agents.xml`.
    pub ids: Vec<String>,
    /// At least one, by time.
    pub frames: Vec<Frame>,
}

/// A crowd at one time.
#[derive(Debug, Clone)]
pub struct Frame {
    /// \[s\]
    pub time: f64,
    /// In the order of the run's Ids; their Fp and Mp mean nothing: runs do not record them.
    pub agents: Vec<AgentDynamics>,
    /// In the order of the run's Ids; `None` where the source does not say.
    pub observed: Option<Vec<Observed>>,
    /// `None` where the source does not record contacts.
    pub interactions: Option<Interactions>,
    /// For messages: a line or a file of the source.
    pub place: String,
}

/// What the contacts do to an agent: the FMU's outputs.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Observed {
    /// Disk–disk contacts.
    pub agent_contacts: u32,
    /// Disk–face contacts.
    pub wall_contacts: u32,
    /// Different agents that touch this one.
    pub contacting_agents: u32,
    /// \[N\] squeeze: sum of |F_n| over its contacts.
    pub normal_force: f64,
}

/// Agents as tools want them that know only numbers.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Names {
    /// In the order of the run's Ids.
    pub numbers: Vec<i64>,
    /// Whether they are the Ids themselves; else they are the places among the agents, from 0.
    pub are_ids: bool,
}

/// \[s\] Names of files hold nine decimals.
const ROUNDING: f64 = 2e-9;

impl Run {
    /// \[s\] of the first and of the last frame.
    pub fn times(&self) -> (f64, f64) {
        (self.frames[0].time, self.frames[self.frames.len() - 1].time)
    }

    /// Each `n`-th frame, the first one included.
    #[must_use]
    pub fn every(self, n: usize) -> Run {
        Run { frames: self.frames.into_iter().step_by(n.max(1)).collect(), ..self }
    }

    /// Frames per second.
    ///
    /// # Errors
    /// There is one frame only, or they do not follow each other at equal times.
    pub fn frame_rate(&self) -> Result<f64, ExportError> {
        let [first, second, ..] = &self.frames[..] else {
            let message = format!("has one frame only, at t = {:?} s: no frame rate", self.frames[0].time);
            return Err(ExportError::wrong(&self.source, message));
        };
        let step = second.time - first.time;
        for pair in self.frames.windows(2) {
            let gap = pair[1].time - pair[0].time;
            if (gap - step).abs() > 1e-6 * step + ROUNDING {
                let message = format!(
                    "{}: column t: t = {:?} s comes {gap:.6} s after the frame before, the others {step:.6} s: the format \
                     needs a constant frame rate (a run's last step is shortened if --until is no multiple of \
                     --step; --every N may leave it out)",
                    pair[1].place, pair[1].time
                );
                return Err(ExportError::wrong(&self.source, message));
            }
        }
        // Sums of steps are rounded; the step that was meant has few decimals, or its rate has none.
        let mean = (self.frames[self.frames.len() - 1].time - first.time) / (self.frames.len() - 1) as f64;
        let (rate, decimal) = (mean.recip().round(), (mean * 1e9).round() / 1e9);
        let near = |value: f64, within: f64| (value - mean).abs() < within * mean;
        Ok(if near(rate.recip(), 1e-6) {
            rate
        } else if near(decimal, 1e-10) {
            decimal.recip()
        } else {
            mean.recip()
        })
    }

    /// In the order of a Trial's agents.
    ///
    /// # Errors
    /// These are not the agents of the Trial.
    pub fn of_trial(self, trial: &Trial) -> Result<Run, ExportError> {
        let places: BTreeMap<&str, usize> =
            self.ids.iter().enumerate().map(|(place, id)| (id.as_str(), place)).collect();
        let known: BTreeSet<&str> = trial.agents.iter().map(|agent| agent.id.as_str()).collect();
        if let Some(stranger) = self.ids.iter().find(|id| !known.contains(id.as_str())) {
            let message = format!("column id: there is no agent {stranger:?} in the Trial {:?}", trial.name);
            return Err(ExportError::wrong(&self.source, message));
        }
        let order = trial.agents.iter().map(|agent| {
            places.get(agent.id.as_str()).copied().ok_or_else(|| {
                let message = format!("has no agent {:?} of the Trial {:?}", agent.id, trial.name);
                ExportError::wrong(&self.source, message)
            })
        });
        let order = order.collect::<Result<Vec<_>, _>>()?;
        if order.iter().copied().eq(0..order.len()) {
            return Ok(self);
        }
        let sorted = |frame: Frame| Frame {
            agents: order.iter().map(|&place| frame.agents[place].clone()).collect(),
            observed: frame.observed.map(|all| order.iter().map(|&place| all[place]).collect()),
            ..frame
        };
        Ok(Run {
            ids: order.iter().map(|&place| self.ids[place].clone()).collect(),
            frames: self.frames.into_iter().map(sorted).collect(),
            source: self.source,
        })
    }

    /// The Ids, if all are different whole numbers, else places.
    pub fn names(&self) -> Names {
        let numbers: Option<Vec<i64>> = self.ids.iter().map(|id| id.parse().ok()).collect();
        let numbers = numbers.filter(|numbers| {
            let different: BTreeSet<_> = numbers.iter().collect();
            different.len() == numbers.len() && numbers.iter().all(|&number| number >= 0)
        });
        let are_ids = numbers.is_some();
        Names { numbers: numbers.unwrap_or_else(|| (0..self.ids.len() as i64).collect()), are_ids }
    }

    /// \[m\] where anybody ever was.
    pub(crate) fn positions(&self) -> impl Iterator<Item = Vec2> + Clone {
        self.frames.iter().flat_map(|frame| frame.agents.iter().map(|agent| agent.position))
    }
}
