//! Where a Trial comes from, what is known of its people, and what drives them.

use crate::edit::{self, Edit};
use crate::{Refused, Shown, crowd, upload};
use lemons_core::trial::{DriveTable, Trial};
use lemons_decision::{DecisionConfig, Plan};
use lemons_people::Agent;
use lemons_people::placing::Watch;
use lemons_scenario::Scenario;
use lemons_sim::Documents;
use serde::Deserialize;

/// Where a Trial comes from.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
#[serde(tag = "kind", rename_all = "kebab-case")]
#[allow(missing_docs)] // as said
pub enum Base {
    /// It comes with the lab: one of [`upload::EXAMPLES`].
    Example { name: String },
    /// It is made.
    Crowd(#[cfg_attr(feature = "typescript", ts(type = "Partial<Scenario>"))] Box<Scenario>),
    /// It is the user's: the name of the zip or the folder, path and length of each file (one zip, or those of a folder).
    Upload { name: String, files: Vec<(String, usize)> },
}

/// A Trial, what is known of its people, and what drives them.
#[derive(Debug, Clone)]
pub struct Driven {
    /// The Trial.
    pub trial: Trial,
    /// Everybody, if the lab has made them.
    pub people: Option<Vec<Agent>>,
    /// The text of its drive.csv; empty if it has none.
    pub drive: String,
    /// The same, read.
    pub table: DriveTable,
    /// The text of its decision.toml; empty if it has none.
    pub wishes: String,
    /// The same for the Trial's people.
    pub plan: Option<Plan>,
}

/// A Trial before edits.
#[derive(Debug, Clone)]
pub struct Basis {
    /// The Trial.
    pub driven: Driven,
    /// Warnings.
    pub notes: Vec<String>,
    /// The placing of a crowd.
    pub(crate) made: Option<crowd::PlacedCrowd>,
}

impl Driven {
    /// A Trial that only its AgentDynamics.xml drives.
    pub fn alone(trial: Trial, people: Option<Vec<Agent>>) -> Driven {
        let (drive, wishes) = (String::new(), String::new());
        Driven { trial, people, drive, table: DriveTable::default(), wishes, plan: None }
    }

    /// Returns what is simulated.
    pub fn documents(&self) -> Documents {
        let Driven { trial, table, plan, .. } = self.clone();
        Documents { trial, drive: table, plan }
    }

    /// Takes settings of Decision.
    ///
    /// # Errors
    /// They do not fit to the Trial.
    pub fn decided(self, config: Option<DecisionConfig>) -> Result<Driven, Refused> {
        let plan = config.as_ref().map(|config| Plan::of(&self.trial, config)).transpose()?;
        let wishes = config.as_ref().map(DecisionConfig::to_toml).transpose()?.unwrap_or_default();
        Ok(Driven { plan, wishes, ..self })
    }

    /// Takes a drive.
    pub fn push(&mut self, table: DriveTable) {
        (self.drive, self.table) = (table.text_for(&self.trial), table);
    }
}

/// Makes the Trial of a scene before edits, or reads it.
///
/// # Errors
/// It is impossible or has errors, or `watch` stopped the placing.
pub fn basis(shown: &Shown, bytes: &[u8], watch: &mut Watch) -> Result<Basis, Refused> {
    match &shown.base {
        Base::Example { name } => upload::example(name),
        Base::Crowd(scenario) => crowd::crowd(scenario, &split(&shown.tables, bytes)?, watch),
        Base::Upload { name, files } => {
            let files = split(files, bytes)?;
            match upload::scenario(name, &files)? {
                Some((path, files)) => crowd::of_file(&path, &files, watch),
                None => upload::open(name, &files, upload::LARGEST_CONTENT),
            }
        }
    }
}

impl Base {
    /// Lines \[m\] beyond the doors of a crowd's room, or of walls that were changed, for the people who are there.
    pub fn beyond_doors(&self, edits: &[Edit], trial: &Trial) -> Vec<[[f64; 2]; 2]> {
        let room = match self {
            Base::Crowd(scenario) => scenario.room.as_ref(),
            _ => edit::room_of(edits),
        };
        room.map_or_else(Vec::new, |room| room.exits(trial.dynamics.iter().map(|here| here.position)))
    }
}

/// Returns the files that lie one after the other in the bytes, by their names and lengths.
///
/// # Errors
/// The bytes are fewer than is said.
pub fn split<'a>(files: &'a [(String, usize)], bytes: &'a [u8]) -> Result<Vec<(&'a str, &'a [u8])>, Refused> {
    let mut rest = bytes;
    let part = |(name, length): &'a (String, usize)| {
        let (part, others) = rest
            .split_at_checked(*length)
            .ok_or_else(|| Refused(format!("{name}: its content is missing: open it again")))?;
        rest = others;
        Ok((&**name, part))
    };
    files.iter().map(part).collect()
}
