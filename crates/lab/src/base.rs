//! Where a Trial comes from.

use crate::driven::{Basis, parts};
use crate::{Refused, crowd, upload};
use lemons_core::trial::Trial;
use lemons_people::placing::Watch;
use serde::Deserialize;

/// Where a Trial comes from.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum Base {
    /// It comes with the lab.
    Example {
        /// One of [`upload::EXAMPLES`].
        name: String,
    },
    /// It is made.
    Crowd(Box<crowd::Wanted>),
    /// It is the user's.
    Upload {
        /// The name of the zip or the folder.
        name: String,
        /// Path and length of each file: one zip, or those of a folder.
        files: Vec<(String, usize)>,
    },
}

/// Makes it, or reads it.
///
/// # Errors
/// It is impossible or has errors, or `watch` stopped the placing.
pub fn basis(base: &Base, bytes: &[u8], watch: &mut Watch) -> Result<Basis, Refused> {
    match base {
        Base::Example { name } => upload::example(name),
        Base::Crowd(wanted) => crowd::crowd(wanted, bytes, watch),
        Base::Upload { name, files } => upload::open(name, &parts(files, bytes)?, upload::LARGEST_CONTENT),
    }
}

impl Base {
    /// Lines \[m\] beyond the doors of a crowd's room, for the people who are there.
    pub fn beyond_doors(&self, trial: &Trial) -> Vec<[[f64; 2]; 2]> {
        let Base::Crowd(wanted) = self else { return Vec::new() };
        wanted.room.exits(trial.dynamics.iter().map(|here| here.position))
    }
}
