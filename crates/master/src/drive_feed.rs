//! A drive on its way into the inputs of an instance.

use crate::error::Result;
use crate::instance::Instance;
use crate::selection::Selection;
use lemons_core::trial::{Agent, DriveTable};

/// A drive, into an instance of a crowd.
pub struct DriveFeed {
    /// Who is pushed when.
    pub drive: DriveTable,
    /// Of the agents that the drive names.
    ids: Vec<String>,
    /// Fp.x, Fp.y and Mp of each of them.
    inputs: Selection,
}

impl DriveFeed {
    /// To the inputs of these agents of an instance; to none of them if it `plays` this drive itself.
    ///
    /// # Errors
    /// The instance has not the inputs of an agent that the drive names.
    pub fn new(instance: &Instance, agents: &[Agent], drive: DriveTable, plays: bool) -> Result<DriveFeed> {
        let agents = agents.iter().enumerate();
        let driven = |id: &str| !plays && drive.rows(id).is_some();
        let driven: Vec<_> = agents.filter(|(_, agent)| driven(&agent.id)).collect();
        let names = driven
            .iter()
            .flat_map(|(i, _)| ["Fp.x", "Fp.y", "Mp"].map(move |name| format!("agent[{i}].{name}")));
        Ok(DriveFeed {
            inputs: instance.select(names)?,
            ids: driven.iter().map(|(_, agent)| agent.id.clone()).collect(),
            drive,
        })
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
