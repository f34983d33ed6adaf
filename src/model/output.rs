//! The XML files in an `OutputDirectory`.

use crate::engine::World;
use crate::setup::{dynamics_of, interactions_of};
use lemons_core::files::{Change, WriteError, change_all};
use lemons_core::trial::{DynamicsElement, Trial, dynamics_xml, interactions_xml, output_names};
use lemons_fmi::{Answer, refuse};
use std::path::{Path, PathBuf};

/// Writes the XML files of the paper's script, with its file names, at a communication point \[s\], if an
/// `OutputDirectory` is set.
pub(super) fn write(trial: &Trial, world: &World, directory: &str, time: f64) -> Answer<()> {
    if directory.is_empty() {
        return Ok(());
    }
    let directory = Path::new(directory);
    let [dynamics_name, interactions_name] = output_names(time);
    let (dynamics, interactions) = (directory.join(dynamics_name), directory.join(interactions_name));
    let changes = output(trial, world, dynamics, interactions);
    changes.iter().try_for_each(check_no_link).and_then(|()| change_all(&changes)).or_else(no_output)
}

/// Returns the files of the paper's script for a moment of a world. Of no contacts there is none: that of an earlier
/// run must not be mistaken for one of this run.
pub(crate) fn output(trial: &Trial, world: &World, dynamics: PathBuf, interactions: PathBuf) -> [Change; 2] {
    let motion = dynamics_xml(&trial.agents, &dynamics_of(world), DynamicsElement::Omitted);
    let contacts = match &world.contacts().contacts[..] {
        [] => Change::Remove(interactions),
        _ => {
            let told = interactions_xml(&trial.agents, &trial.geometry, &interactions_of(world));
            Change::Write(interactions, told)
        }
    };
    [contacts, Change::Write(dynamics, motion)]
}

/// Checks that a change does not go through a link, to a file somewhere else.
fn check_no_link(change: &Change) -> Result<(), WriteError> {
    let (Change::Write(path, _) | Change::Remove(path)) = change;
    match path.symlink_metadata() {
        Ok(there) if !there.is_file() => {
            let what = if there.is_symlink() { "a link" } else { "not a regular file" };
            let error = std::io::Error::other(format!("there is {what}, which is not replaced; remove it"));
            Err(WriteError { path: path.clone(), error })
        }
        _ => Ok(()),
    }
}

/// Creates the OutputDirectory, if one is set.
pub(super) fn make_directory(name: &str) -> Answer<()> {
    let directory = Path::new(name);
    if name.is_empty() {
        return Ok(());
    }
    std::fs::create_dir_all(directory).map_err(WriteError::at(directory)).or_else(no_output)
}

fn no_output(error: WriteError) -> Answer<()> {
    refuse(format!("OutputDirectory: {error}"))
}
