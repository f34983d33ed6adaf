//! What was recorded of a crowd.

use crate::error::RecordError;
use lemons_plane::Motion;
use lemons_trial::{Interactions, Trial};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// Frames of a run, in memory.
#[derive(Debug, Clone)]
pub struct Run {
    /// The file or directory that the frames were read from.
    pub source: PathBuf,
    /// Ids of the agents, as in `Agents.xml`.
    pub ids: Vec<String>,
    /// At least one frame, in the order of time.
    pub frames: Vec<Frame>,
    /// Which communication points the frames are, if the source says it.
    pub points: Option<Points>,
}

/// Which communication points a record has: Parquet has it in its metadata.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Points {
    /// One communication point in so many is recorded.
    pub every: u64,
    /// \[s\] The communication step of the run.
    pub step: f64,
}

impl Points {
    pub(crate) const KEYS: [&str; 2] = ["every", "communication_step"];

    /// Keys and values of the metadata.
    pub fn about(&self) -> [(&'static str, String); 2] {
        let [every, step] = Points::KEYS;
        [(every, self.every.to_string()), (step, format!("{:?}", self.step))]
    }

    /// Whether communication points are missing, if the longest time between two frames is this one \[s\].
    pub fn are_missing(&self, longest: f64) -> bool {
        self.every > 1 || longest > self.step * (1.0 + 1e-6) + 2e-9
    }
}

/// A crowd at one communication point: what the rows of one time hold in a table.
#[derive(Debug, Clone, Default)]
pub struct Frame {
    /// \[s\] time of the communication point.
    pub time: f64,
    /// Pose and velocity of each agent, in the order of the run's Ids.
    pub agents: Vec<Motion>,
    /// What the contacts do to each agent, in the order of the run's Ids; `None` if the source has no such columns.
    pub observed: Option<Vec<Observed>>,
    /// Whether each agent is there; `None` if the source has no such column, and all are.
    pub active: Option<Vec<bool>>,
    /// Contacts of the whole crowd; `None` if the source has no such columns.
    pub totals: Option<Totals>,
    /// Contacts with their springs; `None` if the source does not record them.
    pub interactions: Option<Interactions>,
    /// Where the frame is in the source, for messages: a line, a row or a file.
    pub place: String,
}

/// What the contacts do to an agent. These are outputs of the FMU.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Observed {
    /// Number of contacts with disks of other agents.
    pub agent_contacts: u32,
    /// Number of contacts with faces of walls.
    pub wall_contacts: u32,
    /// Number of other agents that touch this one.
    pub contacting_agents: u32,
    /// \[N\] squeeze at the time: sum of |F_n| over the agent's contacts.
    pub normal_force: f64,
    /// What the contacts did within the communication step that ends at the time, if that was recorded.
    pub of_step: Option<OfStep>,
}

/// What the contacts did to an agent within a communication step. These are outputs of the FMU.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct OfStep {
    /// \[N\] time average of the squeeze.
    pub mean_normal_force: f64,
    /// \[N\] largest squeeze.
    pub peak_normal_force: f64,
    /// \[m\] deepest overlap of a contact.
    pub peak_overlap: f64,
}

/// Contacts of a whole crowd at one time. These are outputs of the FMU.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Totals {
    /// Number of contacts between disks of the crowd, each pair once.
    pub agent_contacts: u32,
    /// Number of contacts between disks of the crowd and faces of walls.
    pub wall_contacts: u32,
}

/// Numbers of agents, for tools that know no other names.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Names {
    /// In the order of the run's Ids.
    pub numbers: Vec<i64>,
    /// Whether the numbers are the Ids. Otherwise they are the places among the agents, from 0.
    pub are_ids: bool,
}

impl Run {
    /// \[s\] Times of the first and of the last frame.
    pub fn times(&self) -> (f64, f64) {
        (self.frames[0].time, self.frames[self.frames.len() - 1].time)
    }

    /// Puts the agents in the order of a Trial.
    ///
    /// # Errors
    /// The agents are not those of the Trial.
    pub fn of_trial(self, trial: &Trial) -> Result<Run, RecordError> {
        let order = order_of(&self.ids, trial, &self.source)?;
        if order.iter().copied().eq(0..order.len()) {
            return Ok(self);
        }
        Ok(Run {
            ids: order.iter().map(|&place| self.ids[place].clone()).collect(),
            frames: self.frames.into_iter().map(|frame| frame.sorted(&order)).collect(),
            source: self.source,
            points: self.points,
        })
    }
}

impl Frame {
    /// Whether an agent is there. One who is not has a row, too: it stands where it was last, and touches nothing.
    pub fn is_there(&self, place: usize) -> bool {
        self.active.as_ref().is_none_or(|active| active.get(place).copied().unwrap_or(true))
    }

    /// Those who are there, with their places.
    pub fn present(&self) -> impl Iterator<Item = (usize, &Motion)> + Clone {
        self.agents.iter().enumerate().filter(|(place, _)| self.is_there(*place))
    }

    /// With the agents of these places.
    pub(crate) fn sorted(self, order: &[usize]) -> Frame {
        Frame {
            agents: order.iter().map(|&place| self.agents[place]).collect(),
            observed: self.observed.map(|all| order.iter().map(|&place| all[place]).collect()),
            active: self.active.map(|all| order.iter().map(|&place| all[place]).collect()),
            ..self
        }
    }
}

/// The places of a Trial's agents among these.
///
/// # Errors
/// These are not the agents of the Trial.
pub(crate) fn order_of(ids: &[String], trial: &Trial, source: &Path) -> Result<Vec<usize>, RecordError> {
    let places: BTreeMap<&str, usize> =
        ids.iter().enumerate().map(|(place, id)| (id.as_str(), place)).collect();
    let known: BTreeSet<&str> = trial.agents.iter().map(|agent| agent.id.as_str()).collect();
    if let Some(stranger) = ids.iter().find(|id| !known.contains(id.as_str())) {
        let message = format!("column id: there is no agent {stranger:?} in the Trial {:?}", trial.name);
        return Err(RecordError::wrong(source, message));
    }
    let order = trial.agents.iter().map(|agent| {
        places.get(agent.id.as_str()).copied().ok_or_else(|| {
            let message = format!("has no agent {:?} of the Trial {:?}", agent.id, trial.name);
            RecordError::wrong(source, message)
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
