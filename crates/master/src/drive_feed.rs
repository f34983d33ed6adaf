//! A drive on its way into the inputs of an instance.

use crate::calls::Instance;
use crate::error::Result;
use crate::selection::Selection;
use lemons_core::trial::{Agent, DriveTable};

/// Returns the agents that a drive names, with the names of their inputs.
pub(crate) fn driven<'a>(
    agents: &'a [Agent],
    drive: &'a DriveTable,
) -> impl Iterator<Item = (&'a Agent, [String; 3])> {
    let driven = agents.iter().enumerate().filter(|(_, agent)| drive.rows(&agent.id).is_some());
    driven.map(|(i, agent)| (agent, ["Fp.x", "Fp.y", "Mp"].map(|name| format!("agent[{i}].{name}"))))
}

/// A drive, into an instance of a crowd.
pub struct DriveFeed {
    /// The drive: who is pushed when.
    pub drive: DriveTable,
    /// The agents that the drive names.
    ids: Vec<String>,
    /// Fp.x, Fp.y and Mp of each of them.
    inputs: Selection,
}

impl DriveFeed {
    /// Makes the feed of the inputs of these agents of an instance; to none of them if it `plays` this drive itself.
    ///
    /// # Errors
    /// The instance has not the inputs of an agent that the drive names.
    pub fn new(instance: &Instance, agents: &[Agent], drive: DriveTable, plays: bool) -> Result<DriveFeed> {
        let driven: Vec<_> = if plays {
            Vec::new()
        } else {
            driven(agents, &drive).map(|(agent, names)| (agent.id.clone(), names)).collect()
        };
        let (ids, names): (Vec<String>, Vec<[String; 3]>) = driven.into_iter().unzip();
        Ok(DriveFeed { inputs: instance.select(names.iter().flatten())?, ids, drive })
    }

    /// Sets the inputs of the instance to the values at a time \[s\]: forces \[N\] and torques \[N m\].
    ///
    /// # Errors
    /// The FMU refuses the call.
    pub(crate) fn apply(&self, instance: &Instance, time: f64) -> Result<()> {
        if self.inputs.is_empty() {
            return Ok(());
        }
        let values: Vec<f64> = self.ids.iter().filter_map(|id| self.drive.at(id, time)).flatten().collect();
        instance.set(&self.inputs, &values)
    }
}
