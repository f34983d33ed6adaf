//! `CrowdMechanics(files)`, the C entry point of the paper's scripts (section 4.5).
//!
//! Each call reads the XML files, advances one `TimeStep` and writes `AgentDynamics.xml` and
//! `AgentInteractions.xml` back. Nothing is kept between calls: changed files are read again, and another call may name
//! another directory. Numbers are written such that the same double is read back.

#![allow(unsafe_code)] // the C boundary
#![allow(non_snake_case)] // the paper's own name

use crate::model::output;
use crate::setup::{self, Setup, WorldError};
use lemons_core::files::source::LocalFiles;
use lemons_core::files::{WriteError, change_all};
use lemons_core::trial::{FileNames, Problems};
use std::ffi::{CStr, OsString, c_char, c_int};
use std::panic::catch_unwind;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Why a call failed. No file has changed.
#[derive(Debug, Error)]
#[allow(missing_docs)] // the messages say it
pub enum CallError {
    #[error("{0} is NULL")]
    Null(&'static str),
    #[error("{0}")]
    Trial(Problems),
    #[error(transparent)]
    World(#[from] WorldError),
    #[error("{0}")]
    Advance(String),
    #[error(transparent)]
    Write(#[from] WriteError),
}

/// Advances the Trial that these files make by one `TimeStep`.
///
/// `parameters` is a path; the others are names in the directories that it gives, which are relative to
/// the directory of `parameters`.
///
/// # Errors
/// Something cannot be read, computed or written. Then no file has changed.
pub fn advance_files(parameters: &Path, names: &FileNames) -> Result<(), CallError> {
    let directory = parameters.parent().unwrap_or(Path::new(""));
    let (trial, _) = setup::read_from(&LocalFiles, directory, names).map_err(CallError::Trial)?;
    let mut world = Setup::of(&trial).world()?;
    world
        .advance(trial.parameters.time_step)
        .map_err(|error| CallError::Advance(Setup::of(&trial).name_body(&error)))?;
    Setup::of(&trial).carry_over_links(&mut world)?;
    let FileNames { dynamics, interactions, .. } = trial.places(names);
    Ok(change_all(&output(&trial, &world, dynamics, interactions))?)
}

/// Reads the files, advances one `TimeStep`, overwrites `AgentDynamics.xml` (without `<Dynamics>`), writes
/// `AgentInteractions.xml` when there are contacts and removes it when there are none.
///
/// `files`: the names of Parameters, Materials, Geometry, Agents and AgentDynamics. Returns 0, or, after
/// a message on standard error, 1; then no file has changed.
///
/// # Safety
/// `files` is NULL or points to five pointers, each of them NULL or pointing to a text that ends with a zero.
// See lib.rs: unit tests link it twice.
#[cfg_attr(not(test), unsafe(no_mangle))]
pub unsafe extern "C" fn CrowdMechanics(files: *const *const c_char) -> c_int {
    lemons_fmi::silence_panics();
    let result = catch_unwind(|| {
        // SAFETY: as the caller promises.
        let [parameters, materials, geometry, agents, dynamics] = unsafe { paths(files) }?;
        let own_name = PathBuf::from(parameters.file_name().unwrap_or_default());
        let interactions = FileNames::default().interactions;
        let names = FileNames { parameters: own_name, materials, geometry, agents, dynamics, interactions };
        advance_files(&parameters, &names)
    });
    let message = match result {
        Ok(Ok(())) => return 0,
        Ok(Err(error)) => error.to_string(),
        Err(_) => "an internal error of the library".to_owned(),
    };
    // The paper's interface has no other way to report the reason. If writing fails, there is nothing left to do.
    let _ =
        std::io::Write::write_all(&mut std::io::stderr(), format!("CrowdMechanics: {message}\n").as_bytes());
    1
}

/// The five file names.
///
/// # Safety
/// As [`CrowdMechanics`].
unsafe fn paths(files: *const *const c_char) -> Result<[PathBuf; 5], CallError> {
    const WHAT: [&str; 5] = [
        "files[0] (Parameters)",
        "files[1] (Materials)",
        "files[2] (Geometry)",
        "files[3] (Agents)",
        "files[4] (AgentDynamics)",
    ];
    if files.is_null() {
        return Err(CallError::Null("files"));
    }
    let mut paths: [PathBuf; 5] = Default::default();
    for (k, path) in paths.iter_mut().enumerate() {
        // SAFETY: five pointers, as the caller promises.
        let name = unsafe { *files.add(k) };
        if name.is_null() {
            return Err(CallError::Null(WHAT[k]));
        }
        // SAFETY: a text that ends in a zero, as the caller promises.
        *path = os_string(unsafe { CStr::from_ptr(name) }).into();
    }
    Ok(paths)
}

#[cfg(unix)]
fn os_string(name: &CStr) -> OsString {
    std::os::unix::ffi::OsStringExt::from_vec(name.to_bytes().to_vec())
}

#[cfg(not(unix))]
fn os_string(name: &CStr) -> OsString {
    name.to_string_lossy().into_owned().into()
}
