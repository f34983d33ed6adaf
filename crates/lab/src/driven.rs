//! A Trial, what is known of its people, and what drives them.

use crate::Refused;
use lemons_core::trial::{DriveTable, Trial};
use lemons_decision::Plan;
use lemons_people::Person;
use serde_json::Value;

/// A Trial, what is known of its people, and what drives them.
#[derive(Debug, Clone)]
pub struct Driven {
    /// The Trial.
    pub trial: Trial,
    /// Everybody's measures, if the lab has made them.
    pub people: Option<Vec<Person>>,
    /// The text of its drive.csv; empty if it has none.
    pub drive: String,
    /// The same, read.
    pub table: DriveTable,
    /// The text of its decision.toml; empty if it has none.
    pub wishes: String,
    /// The same for the Trial's people.
    pub plan: Option<Plan>,
}

impl Driven {
    /// A Trial that only its AgentDynamics.xml drives.
    pub fn alone(trial: Trial, people: Option<Vec<Person>>) -> Driven {
        let (drive, wishes) = (String::new(), String::new());
        Driven { trial, people, drive, table: DriveTable::default(), wishes, plan: None }
    }
}

/// A Trial before edits.
#[derive(Debug, Clone)]
pub struct Basis {
    /// The Trial.
    pub driven: Driven,
    /// Warnings.
    pub notes: Vec<String>,
    /// Of a crowd: how it was placed.
    pub made: Value,
}

/// The files that lie one after the other in the bytes.
///
/// # Errors
/// The bytes are fewer than is said.
pub fn parts<'a>(files: &'a [(String, usize)], bytes: &'a [u8]) -> Result<Vec<(&'a str, &'a [u8])>, Refused> {
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
