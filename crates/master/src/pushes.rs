//! A drive on its way into the inputs of an instance.

use crate::error::Result;
use crate::instance::Instance;
use crate::selection::Selection;
use lemons_ssp::Address;
use lemons_trial::Agent;
use lemons_trial::{DriveTable, Missed};

/// A drive, into an instance of a crowd.
pub struct Pushes {
    drive: DriveTable,
    fingerprint: String,
    /// Of the agents that the drive names.
    ids: Vec<String>,
    inputs: Inputs,
}

/// The inputs of a crowd that a drive has values for: Fp.x, Fp.y and Mp of each driven agent.
pub struct Inputs {
    pub(crate) addresses: Vec<Address>,
    pub(crate) selection: Selection,
}

impl Pushes {
    /// To the inputs of these agents of an instance; to none of them if it `plays` this drive itself.
    ///
    /// # Errors
    /// The instance has not the inputs of an agent that the drive names.
    pub fn new(instance: &Instance, agents: &[Agent], drive: DriveTable, plays: bool) -> Result<Pushes> {
        let agents = agents.iter().enumerate();
        let driven = |id: &str| !plays && drive.rows(id).is_some();
        let driven: Vec<_> = agents.filter(|(_, agent)| driven(&agent.id)).collect();
        let names = driven
            .iter()
            .flat_map(|(i, _)| ["Fp.x", "Fp.y", "Mp"].map(move |name| format!("agent[{i}].{name}")));
        let addresses = names.map(|name| instance.address(&name)).collect::<Result<Vec<_>>>()?;
        Ok(Pushes {
            inputs: Inputs { selection: instance.select_at(&addresses)?, addresses },
            ids: driven.iter().map(|(_, agent)| agent.id.clone()).collect(),
            fingerprint: drive.fingerprint(),
            drive,
        })
    }

    /// As [`DriveTable::missed`].
    pub fn missed(&self, start: f64, step: f64) -> Option<Missed> {
        self.drive.missed(start, step)
    }

    /// As [`DriveTable::fingerprint`].
    pub fn fingerprint(&self) -> &str {
        &self.fingerprint
    }

    /// \[s\] When the last of them ends; `None` if there is none.
    pub fn end(&self) -> Option<f64> {
        self.drive.end()
    }

    /// The inputs that the drive has values for.
    pub fn inputs(&self) -> &Inputs {
        &self.inputs
    }

    /// The values of the inputs at a time \[s\]: forces \[N\] and torques \[N m\].
    pub fn at(&self, time: f64) -> Vec<f64> {
        self.ids.iter().filter_map(|id| self.drive.at(id, time)).flatten().collect()
    }
}
