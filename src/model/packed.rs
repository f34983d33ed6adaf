//! A packed Trial and its drive.

use crate::resources::{Resources, ResourcesError};
use lemons_core::trial::{DriveTable, Trial};
use std::sync::{Arc, OnceLock};

/// A Trial as it was packed.
pub(super) struct Packed {
    pub trial: Trial,
    /// Tells the Trial from others.
    pub fingerprint: u128,
    /// Its drive, once it was played.
    pub drive: OnceLock<Drive>,
}

/// The `drive.csv` of a Trial; empty without one.
pub(super) struct Drive {
    pub table: DriveTable,
    /// See [`DriveTable::fingerprint`].
    pub fingerprint: String,
}

impl Packed {
    /// Reads a packed Trial; also returns warnings.
    pub fn load(resources: &Resources, name: &str) -> Result<(Arc<Packed>, Vec<String>), ResourcesError> {
        let (trial, warnings) = resources.load(name)?;
        Ok((Arc::new(Packed::of(trial)), warnings))
    }

    pub fn of(trial: Trial) -> Packed {
        Packed { fingerprint: trial.fingerprint(), trial, drive: OnceLock::new() }
    }

    /// Reads the drive, unless that was done before.
    pub fn drive(&self, resources: &Resources) -> Result<&Drive, ResourcesError> {
        if let Some(drive) = self.drive.get() {
            return Ok(drive);
        }
        let table = resources.drive(&self.trial)?;
        let fingerprint = table.fingerprint();
        Ok(self.drive.get_or_init(|| Drive { table, fingerprint }))
    }
}
