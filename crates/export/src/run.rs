//! What was recorded of a crowd.

use crate::error::ExportError;
use crowd_mechanics::trial::{AgentDynamics, Interactions, Trial};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

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
    /// \[N\] squeeze at the time: sum of |F_n| over its contacts.
    pub normal_force: f64,
    /// What they did during the communication step that ends at the time, if that was recorded.
    pub of_step: Option<OfStep>,
}

/// What the contacts did to an agent during a communication step: the FMU's outputs.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct OfStep {
    /// \[N\] time average of the squeeze.
    pub mean_normal_force: f64,
    /// \[N\] its largest value.
    pub peak_normal_force: f64,
    /// \[m\] the deepest overlap of a contact.
    pub peak_overlap: f64,
}

/// Agents as tools want them that know only numbers.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Names {
    /// In the order of the run's Ids.
    pub numbers: Vec<i64>,
    /// Whether they are the Ids themselves; else they are the places among the agents, from 0.
    pub are_ids: bool,
}

impl Run {
    /// \[s\] of the first and of the last frame.
    pub fn times(&self) -> (f64, f64) {
        (self.frames[0].time, self.frames[self.frames.len() - 1].time)
    }

    /// In the order of a Trial's agents.
    ///
    /// # Errors
    /// These are not the agents of the Trial.
    pub fn of_trial(self, trial: &Trial) -> Result<Run, ExportError> {
        let order = order_of(&self.ids, trial, &self.source)?;
        if order.iter().copied().eq(0..order.len()) {
            return Ok(self);
        }
        Ok(Run {
            ids: order.iter().map(|&place| self.ids[place].clone()).collect(),
            frames: self.frames.into_iter().map(|frame| frame.sorted(&order)).collect(),
            source: self.source,
        })
    }
}

impl Frame {
    /// With the agents of these places.
    pub(crate) fn sorted(self, order: &[usize]) -> Frame {
        Frame {
            agents: order.iter().map(|&place| self.agents[place].clone()).collect(),
            observed: self.observed.map(|all| order.iter().map(|&place| all[place]).collect()),
            ..self
        }
    }
}

/// The places of a Trial's agents among these.
///
/// # Errors
/// These are not the agents of the Trial.
pub(crate) fn order_of(ids: &[String], trial: &Trial, source: &Path) -> Result<Vec<usize>, ExportError> {
    let places: BTreeMap<&str, usize> =
        ids.iter().enumerate().map(|(place, id)| (id.as_str(), place)).collect();
    let known: BTreeSet<&str> = trial.agents.iter().map(|agent| agent.id.as_str()).collect();
    if let Some(stranger) = ids.iter().find(|id| !known.contains(id.as_str())) {
        let message = format!("column id: there is no agent {stranger:?} in the Trial {:?}", trial.name);
        return Err(ExportError::wrong(source, message));
    }
    let order = trial.agents.iter().map(|agent| {
        places.get(agent.id.as_str()).copied().ok_or_else(|| {
            let message = format!("has no agent {:?} of the Trial {:?}", agent.id, trial.name);
            ExportError::wrong(source, message)
        })
    });
    order.collect()
}

/// The Ids, if all are different whole numbers, else places.
pub(crate) fn names_of(ids: &[String]) -> Names {
    let numbers: Option<Vec<i64>> = ids.iter().map(|id| id.parse().ok()).collect();
    let numbers = numbers.filter(|numbers| {
        let different: BTreeSet<_> = numbers.iter().collect();
        different.len() == numbers.len() && numbers.iter().all(|&number| number >= 0)
    });
    let are_ids = numbers.is_some();
    Names { numbers: numbers.unwrap_or_else(|| (0..ids.len() as i64).collect()), are_ids }
}
