//! Where a Trial comes from.

use crate::edit::{self, Edit};
use crate::loaded::UneditedTrial;
use crate::{Refused, crowd, upload};
use lemons_core::trial::Trial;
use lemons_people::placing::Watch;
use lemons_scenario::Scenario;
use serde::Deserialize;

/// Where a Trial comes from.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS), ts(rename = "Base"))]
#[serde(tag = "kind", rename_all = "kebab-case")]
#[allow(missing_docs)] // as said
pub enum TrialSource {
    /// It comes with the lab: one of [`upload::EXAMPLES`].
    Example { name: String },
    /// It is made.
    Crowd(#[cfg_attr(feature = "typescript", ts(type = "Partial<Scenario>"))] Box<Scenario>),
    /// It is the user's: the name of the zip or the folder, path and length of each file (one zip, or those of a folder).
    Upload { name: String, files: Vec<(String, usize)> },
}

impl TrialSource {
    /// Makes the Trial before edits, or reads it; `tables` are those of a crowd, with their lengths.
    ///
    /// # Errors
    /// It is impossible or has errors, or `watch` stopped the placing.
    pub fn unedited(
        &self,
        tables: &[(String, usize)],
        bytes: &[u8],
        watch: &mut Watch,
    ) -> Result<UneditedTrial, Refused> {
        match self {
            TrialSource::Example { name } => upload::example(name),
            TrialSource::Crowd(scenario) => crowd::crowd(scenario, &split(tables, bytes)?, watch),
            TrialSource::Upload { name, files } => {
                let files = split(files, bytes)?;
                match upload::scenario(name, &files)? {
                    Some((path, files)) => crowd::of_file(&path, &files, watch),
                    None => upload::open(name, &files, upload::LARGEST_CONTENT),
                }
            }
        }
    }

    /// Returns the scenario of a crowd that is made.
    pub fn crowd(&self) -> Option<&Scenario> {
        match self {
            TrialSource::Crowd(scenario) => Some(scenario),
            _ => None,
        }
    }

    /// Lines \[m\] beyond the doors of a crowd's room, or of walls that were changed, for the people who are there.
    pub fn beyond_doors(&self, edits: &[Edit], trial: &Trial) -> Vec<[[f64; 2]; 2]> {
        let room = self.crowd().map_or_else(|| edit::room_of(edits), |scenario| scenario.room.as_ref());
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
            .ok_or_else(|| Refused::from(format!("{name}: its content is missing: open it again")))?;
        rest = others;
        Ok((&**name, part))
    };
    files.iter().map(part).collect()
}
