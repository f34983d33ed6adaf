//! What was recorded of a crowd.

use crate::columns::{Groups, Row};
use crate::error::RecordError;
use lemons_core::plane::{Motion, Pose, Twist, Vec2, vec2};
use lemons_core::trial::{Interactions, Trial};
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
    /// What the contacts do to each agent, in the order of the run's Ids; `None` if the source has no such columns.
    pub observed: Option<Vec<Observed>>,
    /// Whether each agent is there; `None` if the source has no such column, and all are.
    pub active: Option<Vec<bool>>,
    /// Legs of each agent, in the order of the run's Ids; `None` if the source has no such columns.
    pub legs: Option<Vec<OfLegs>>,
    /// Contacts of the whole crowd; `None` if the source has no such columns.
    pub totals: Option<Totals>,
    /// What people did to each straight piece of the walls, in the order of Geometry.xml, within the communication step
    /// that ends at the time; `None` if the source does not record it.
    pub walls: Option<Vec<OfWall>>,
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
    /// \[N\] the part of it by walls; `None` if the source does not record it.
    pub mean_wall_force: Option<f64>,
    /// \[N\] largest squeeze.
    pub peak_normal_force: f64,
    /// \[m\] deepest overlap of a contact.
    pub peak_overlap: f64,
}

/// Legs of an agent. These are outputs of Decision.
#[derive(Debug, Clone, Copy, PartialEq)]
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

/// What people did to a straight piece of a wall within a communication step. These are outputs of the FMU.
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

impl Frame {
    /// Returns whether an agent is there. One who is not has a row, too: it stands where it was last, and touches nothing.
    pub fn is_there(&self, place: usize) -> bool {
        self.active.as_ref().is_none_or(|active| active.get(place).copied().unwrap_or(true))
    }

    /// Returns those who are there, with their places.
    pub fn present(&self) -> impl Iterator<Item = (usize, &Motion)> + Clone {
        self.agents.iter().enumerate().filter(|(place, _)| self.is_there(*place))
    }

    /// Makes a frame of the values of an FMU at a time \[s\], in the order of [`Groups::variables`].
    ///
    /// # Errors
    /// A sentence with a number that cannot be.
    pub fn of_values(time: f64, agents: usize, groups: Groups, values: &[f64]) -> Result<Frame, String> {
        let mut rows = vec![Row::default(); agents];
        for ((agent, place, quantity), &value) in groups.of_fmu(agents).zip(values) {
            quantity
                .check(value, true)
                .map_err(|must| format!("{}: {value:?} is not {must}", quantity.variable))?;
            if let Some(row) = rows.get_mut(agent.unwrap_or(0)) {
                row[place] = value;
            }
        }
        Ok(Frame { place: format!("t = {time:?} s"), ..Frame::of_rows(time, &rows, groups) })
    }

    /// Makes a frame of the rows of all agents, with these groups of columns.
    pub fn of_rows(time: f64, rows: &[Row], groups: Groups) -> Frame {
        let motion = |&[x, y, vx, vy, orientation, angular_velocity, ..]: &Row| Motion {
            pose: Pose { position: vec2(x, y), orientation },
            twist: Twist { velocity: vec2(vx, vy), angular_velocity },
        };
        let observed = |row: &Row| Observed {
            agent_contacts: row[6] as u32,
            wall_contacts: row[7] as u32,
            contacting_agents: row[8] as u32,
            normal_force: row[9],
            of_step: groups.of_step.then_some(OfStep {
                mean_normal_force: row[10],
                mean_wall_force: groups.by_walls.then_some(row[13]),
                peak_normal_force: row[11],
                peak_overlap: row[12],
            }),
        };
        let legs = |row: &Row| OfLegs {
            feet: vec2(row[15], row[16]),
            steps: row[17] as u32,
            balanced: row[18] != 0.0,
            fallen: row[19] != 0.0,
        };
        let totals = |row: &Row| Totals { agent_contacts: row[20] as u32, wall_contacts: row[21] as u32 };
        Frame {
            time,
            agents: rows.iter().map(motion).collect(),
            observed: groups.contacts.then(|| rows.iter().map(observed).collect()),
            active: groups.active.then(|| rows.iter().map(|row| row[14] != 0.0).collect()),
            legs: groups.legs.then(|| rows.iter().map(legs).collect()),
            totals: rows.first().map(totals).filter(|_| groups.totals),
            ..Frame::default()
        }
    }

    /// Returns the row of an agent.
    pub fn row(&self, place: usize) -> Row {
        let Motion { pose: Pose { position, orientation }, twist } = self.agents[place];
        let seen = self.observed.as_ref().map(|all| all[place]).unwrap_or_default();
        let (step, totals) = (seen.of_step.unwrap_or_default(), self.totals.unwrap_or_default());
        let [x, y, vx, vy] = [position.x, position.y, twist.velocity.x, twist.velocity.y];
        let motion = [x, y, vx, vy, orientation, twist.angular_velocity];
        let counts = [seen.agent_contacts, seen.wall_contacts, seen.contacting_agents].map(f64::from);
        let by_walls = step.mean_wall_force.unwrap_or_default();
        let of_step = [step.mean_normal_force, step.peak_normal_force, step.peak_overlap, by_walls];
        let legs = self.legs.as_ref().map_or([0.0; 5], |legs| {
            let OfLegs { feet, steps, balanced, fallen } = legs[place];
            [feet.x, feet.y, steps.into(), balanced.into(), fallen.into()]
        });
        let there = f64::from(self.is_there(place));
        let totals = [totals.agent_contacts, totals.wall_contacts].map(f64::from);
        let last = [there].into_iter().chain(legs).chain(totals);
        let all = motion.into_iter().chain(counts).chain([seen.normal_force]).chain(of_step).chain(last);
        let mut row = Row::default();
        row.iter_mut().zip(all).for_each(|(cell, value)| *cell = value);
        row
    }

    /// Returns the frame with the agents of these places.
    pub(crate) fn sorted(self, order: &[usize]) -> Frame {
        Frame {
            agents: sorted(&self.agents, order),
            observed: self.observed.map(|all| sorted(&all, order)),
            active: self.active.map(|all| sorted(&all, order)),
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
