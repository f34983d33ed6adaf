//! A Trial, what is known of its people, and what drives them.

use crate::Refused;
use lemons_core::message::Message;
use lemons_core::trial::{DriveTable, Trial};
use lemons_decision::{DecisionConfig, Plan};
use lemons_people::{CrowdMember, CrowdStatistics};
use lemons_sim::Documents;
use serde::Serialize;

/// A Trial, what is known of its people, and what drives them.
#[derive(Debug, Clone)]
pub struct LoadedTrial {
    /// The Trial.
    pub trial: Trial,
    /// Everybody, if the lab has made them.
    pub people: Option<Vec<CrowdMember>>,
    /// The text of its drive.csv; empty if it has none.
    pub drive: String,
    /// The same, read.
    pub table: DriveTable,
    /// The text of its decision.toml; empty if it has none.
    pub decision: String,
    /// The same for the Trial's people.
    pub plan: Option<Plan>,
}

/// How a crowd was placed.
#[derive(Debug, Clone, Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub(crate) struct PlacedCrowd {
    pub density: f64,
    pub area: f64,
    pub iterations: u64,
    pub largest_overlap: f64,
    pub statistics: CrowdStatistics,
}

/// A Trial before edits.
#[derive(Debug, Clone)]
pub struct UneditedTrial {
    /// The Trial.
    pub loaded: LoadedTrial,
    /// Warnings.
    pub notes: Vec<Message>,
    /// The placing of a crowd.
    pub(crate) placing: Option<PlacedCrowd>,
}

impl LoadedTrial {
    /// A Trial that only its AgentDynamics.xml drives.
    pub fn alone(trial: Trial, people: Option<Vec<CrowdMember>>) -> LoadedTrial {
        let (drive, decision) = (String::new(), String::new());
        LoadedTrial { trial, people, drive, table: DriveTable::default(), decision, plan: None }
    }

    /// Returns what is simulated.
    pub fn documents(&self) -> Documents {
        let LoadedTrial { trial, table, plan, .. } = self.clone();
        Documents::new(trial, table, plan)
    }

    /// Takes settings of Decision.
    ///
    /// # Errors
    /// They do not fit to the Trial.
    pub fn decided(self, config: Option<DecisionConfig>) -> Result<LoadedTrial, Refused> {
        let plan = config.as_ref().map(|config| Plan::of(&self.trial, config)).transpose()?;
        let decision = config.as_ref().map(DecisionConfig::to_toml).transpose()?.unwrap_or_default();
        Ok(LoadedTrial { plan, decision, ..self })
    }

    /// Takes a drive.
    pub fn push(&mut self, table: DriveTable) {
        (self.drive, self.table) = (table.text_for(&self.trial), table);
    }
}
