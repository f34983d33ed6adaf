//! Record of a crowd.

use crate::columns::Effect;
use crate::error::RecordError;
use lemons_core::plane::{Motion, Vec2};
use lemons_core::trial::{AgentDynamics, Interactions, Trial};
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
}

/// A crowd at one communication point: what the rows of one time hold in a table.
#[derive(Debug, Clone, Default)]
pub struct Frame {
    /// \[s\] time of the communication point.
    pub time: f64,
    /// Pose and velocity of each agent, in the order of the run's Ids.
    pub agents: Vec<Motion>,
    /// Effects of the contacts on each agent, in the order of the run's Ids.
    pub effects: Effects,
    /// Whether each agent is there; `None` if the source has no such column, and all are.
    pub active: Option<Vec<bool>>,
    /// Whether each agent has not come yet; empty if nobody comes later. Not recorded: see [`Frame::with_outside`].
    pub outside: Vec<bool>,
    /// Legs of each agent, in the order of the run's Ids; `None` if the source has no such columns.
    pub legs: Option<Vec<OfLegs>>,
    /// Contacts of the whole crowd; `None` if the source has no such columns.
    pub totals: Option<Totals>,
    /// Effects of people on each straight piece of the walls, in the order of Geometry.xml, within the communication step
    /// that ends at the time; `None` if the source does not record it.
    pub walls: Option<Vec<OfWall>>,
    /// The same of each panel of the walls that have some.
    pub panels: Option<Vec<OfWall>>,
    /// Contacts with their springs; `None` if the source does not record them.
    pub interactions: Option<Interactions>,
    /// Where the frame is in the source, for messages: a line, a row or a file.
    pub place: String,
}

/// Effects of the contacts on each agent, as far as the source records them.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Effects {
    /// A bit for each effect that is recorded.
    known: u32,
    agents: Vec<[f64; Effect::ALL.len()]>,
}

/// Legs of an agent. These are outputs of Decision.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct OfLegs {
    /// \[m\] middle of the feet.
    pub feet: Vec2,
    /// Number of steps to keep the balance.
    pub steps: u32,
    /// Whether the agent needs no step.
    pub balanced: bool,
    /// Whether the agent could not be saved from a fall, at some time.
    pub fallen: bool,
}

/// Effects of people on a straight piece of a wall, or on a panel of it, within a communication step. These are outputs of the FMU.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct OfWall {
    /// \[N\] time average of the sum of |F_n| over its contacts.
    pub mean_normal_force: f64,
    /// \[N\] largest sum.
    pub peak_normal_force: f64,
}

/// Contacts of a whole crowd at one time. These are outputs of the FMU.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Totals {
    /// Number of contacts between disks of the crowd, each pair once.
    pub agent_contacts: u32,
    /// Number of contacts between disks of the crowd and faces of walls.
    pub wall_contacts: u32,
}

impl Run {
    /// \[s\] Times of the first and of the last frame.
    pub fn times(&self) -> (f64, f64) {
        (self.frames[0].time, self.frames[self.frames.len() - 1].time)
    }
}

impl Effects {
    /// Returns whether an effect is recorded.
    pub fn knows(&self, effect: Effect) -> bool {
        self.known & 1 << effect as u32 != 0
    }

    /// Returns an effect on an agent; `None` if it is not recorded.
    pub fn get(&self, effect: Effect, agent: usize) -> Option<f64> {
        self.agents.get(agent).filter(|_| self.knows(effect)).map(|all| all[effect as usize])
    }

    /// Returns the place of an effect on an agent; `None` if it is not recorded.
    pub fn get_mut(&mut self, effect: Effect, agent: usize) -> Option<&mut f64> {
        let known = self.knows(effect);
        self.agents.get_mut(agent).filter(|_| known).map(|all| &mut all[effect as usize])
    }

    /// Records an effect on all agents.
    pub fn record(&mut self, effect: Effect, numbers: impl ExactSizeIterator<Item = f64>) {
        self.known |= 1 << effect as u32;
        self.agents.resize(numbers.len(), Default::default());
        self.agents.iter_mut().zip(numbers).for_each(|(all, number)| all[effect as usize] = number);
    }

    fn sorted(&self, order: &[usize]) -> Effects {
        let agents = if self.known == 0 { Vec::new() } else { sorted(&self.agents, order) };
        Effects { known: self.known, agents }
    }
}

impl Frame {
    /// Returns whether an agent is there. One who is not has a row, too: it stands where it was last, and touches nothing.
    pub fn is_there(&self, place: usize) -> bool {
        self.active.as_ref().is_none_or(|active| active.get(place).copied().unwrap_or(true))
    }

    /// Returns whether an agent has not come yet.
    pub fn is_outside(&self, place: usize) -> bool {
        self.outside.get(place).is_some_and(|outside| *outside)
    }

    /// Finds who of a Trial's agents has not come yet: who was not there at the start, and still is not, where it began.
    #[must_use]
    pub fn with_outside(mut self, trial: &Trial) -> Frame {
        if trial.dynamics.len() == self.agents.len() && trial.dynamics.iter().any(|own| own.absent) {
            let waits = |(place, own): (usize, &AgentDynamics)| {
                own.absent && !self.is_there(place) && self.agents[place].pose.position == own.position
            };
            self.outside = trial.dynamics.iter().enumerate().map(waits).collect();
        }
        self
    }

    /// Returns those who are there, with their places.
    pub fn present(&self) -> impl Iterator<Item = (usize, &Motion)> + Clone {
        self.agents.iter().enumerate().filter(|(place, _)| self.is_there(*place))
    }

    /// Returns the frame with the agents of these places.
    pub(crate) fn sorted(self, order: &[usize]) -> Frame {
        Frame {
            agents: sorted(&self.agents, order),
            effects: self.effects.sorted(order),
            active: self.active.map(|all| sorted(&all, order)),
            outside: if self.outside.is_empty() { Vec::new() } else { sorted(&self.outside, order) },
            legs: self.legs.map(|all| sorted(&all, order)),
            ..self
        }
    }
}

/// Returns the values at these places.
pub(crate) fn sorted<T: Clone>(values: &[T], order: &[usize]) -> Vec<T> {
    order.iter().map(|&place| values[place].clone()).collect()
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
