//! How a run is recorded.

use crate::compared::Poses;
use anyhow::{Context, Result};
use lemons_master::{CrowdRecord, Saved};

/// What is said of a run, and what it goes on from.
pub struct Recording<'a> {
    /// What the tables say of the run.
    pub about: Vec<(&'static str, String)>,
    /// The run that this one goes on from.
    pub before: Option<&'a Saved>,
    /// What is done with the poses.
    pub poses: Poses,
}

impl<'a> Recording<'a> {
    /// What the run before has recorded of a crowd.
    pub fn before_of(&self, component: &str) -> Result<Option<&'a CrowdRecord>> {
        let Some(saved) = self.before else { return Ok(None) };
        let record = saved.crowd.iter().find(|record| record.component == component);
        let missing = || format!("the saved run is damaged: it has no entry for the crowd {component:?}");
        record.map(Some).with_context(missing)
    }
}
