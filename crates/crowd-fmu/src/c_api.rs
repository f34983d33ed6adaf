//! `CrowdMechanics(files)`, the C entry point of the paper's scripts (section 4.5): see [`lemons_crowd::in_place`].

#![allow(unsafe_code)] // the C boundary
#![allow(non_snake_case)] // the paper's own name

use lemons_core::trial::FileNames;
use lemons_crowd::in_place::{CallError, advance_files};
use std::ffi::{CStr, OsString, c_char, c_int};
use std::panic::catch_unwind;
use std::path::PathBuf;

/// Why a call failed. No file has changed.
#[derive(Debug, thiserror::Error)]
enum Failure {
    #[error("{0} is NULL")]
    Null(&'static str),
    #[error(transparent)]
    Step(#[from] CallError),
}

/// Reads the files, advances one `TimeStep`, overwrites `AgentDynamics.xml` (without `<Dynamics>`), writes
/// `AgentInteractions.xml` when there are contacts and removes it when there are none.
///
/// `files`: the names of Parameters, Materials, Geometry, Agents and AgentDynamics. Returns 0, or, after
/// a message on standard error, 1; then no file has changed.
///
/// # Safety
/// `files` is NULL or points to five pointers, each of them NULL or pointing to a text that ends with a zero.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn CrowdMechanics(files: *const *const c_char) -> c_int {
    lemons_fmi::silence_panics();
    let result = catch_unwind(|| -> Result<(), Failure> {
        // SAFETY: as the caller promises.
        let [parameters, materials, geometry, agents, dynamics] = unsafe { paths(files) }?;
        let own_name = PathBuf::from(parameters.file_name().unwrap_or_default());
        let interactions = FileNames::default().interactions;
        let names = FileNames { parameters: own_name, materials, geometry, agents, dynamics, interactions };
        Ok(advance_files(&parameters, &names)?)
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
unsafe fn paths(files: *const *const c_char) -> Result<[PathBuf; 5], Failure> {
    const WHAT: [&str; 5] = [
        "files[0] (Parameters)",
        "files[1] (Materials)",
        "files[2] (Geometry)",
        "files[3] (Agents)",
        "files[4] (AgentDynamics)",
    ];
    if files.is_null() {
        return Err(Failure::Null("files"));
    }
    let mut paths: [PathBuf; 5] = Default::default();
    for (k, path) in paths.iter_mut().enumerate() {
        // SAFETY: five pointers, as the caller promises.
        let name = unsafe { *files.add(k) };
        if name.is_null() {
            return Err(Failure::Null(WHAT[k]));
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
