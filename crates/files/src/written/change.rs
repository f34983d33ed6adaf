//! Changes of files: whole, and all or none.

use super::WriteError;
use super::guard::{self, Changed};
use super::staged::Staged;
use crate::input;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

fn staged(path: &Path, bytes: &[u8]) -> io::Result<Staged> {
    let mut file = Staged::beside(path)?;
    file.write_all(bytes)?;
    Ok(file)
}

/// Writes a file by way of a temporary one beside it: readers see the old text or the new one, never a part.
///
/// # Errors
/// The file cannot be written; it is then unchanged.
pub fn write_atomically(path: &Path, text: &str) -> Result<(), WriteError> {
    let written = staged(path, text.as_bytes()).and_then(Staged::persist);
    written.map_err(WriteError::at(path))
}

/// A change of a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Change {
    /// Writes this text.
    Write(PathBuf, String),
    /// Removes the file.
    Remove(PathBuf),
}

/// Removes a file if no other program changed a guarded file there.
///
/// # Errors
/// The file cannot be removed, or it was changed ([`Changed`](crate::Changed)).
pub fn remove_file(path: &Path) -> io::Result<()> {
    if guard::is_changed(path)? {
        return Err(io::Error::other(Changed { kept: None }));
    }
    std::fs::remove_file(path)
}

/// Makes all changes or none. New files are first written beside their places. If a later change fails, earlier ones
/// are undone.
///
/// # Errors
/// A change failed. Every file is then byte for byte as before, or the message names one that could not be restored.
pub fn change_all(changes: &[Change]) -> Result<(), WriteError> {
    let mut ready = Vec::with_capacity(changes.len());
    for change in changes {
        let (path, new) = match change {
            Change::Write(path, text) => {
                (path, Some(staged(path, text.as_bytes()).map_err(WriteError::at(path))?))
            }
            Change::Remove(path) => (path, None),
        };
        let old = old_content(path, new.is_some()).map_err(WriteError::at(path))?;
        ready.push((path, new, old));
    }
    let mut done: Vec<(&Path, Option<Vec<u8>>)> = Vec::new();
    for (path, new, old) in ready {
        let put = match new {
            Some(file) => file.persist(),
            None if old.is_some() => remove_file(path),
            None => Ok(()),
        };
        if let Err(error) = put {
            return Err(put_back(done).unwrap_or_else(|| WriteError::at(path)(error)));
        }
        done.push((path, old));
    }
    Ok(())
}

/// Returns the content of a file that a change would replace, if there is one. A pipe or a device is written, not
/// replaced: reading it could wait for ever.
fn old_content(path: &Path, is_written: bool) -> io::Result<Option<Vec<u8>>> {
    match path.metadata() {
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
        Ok(there) if is_written && !there.is_file() && !there.is_dir() => Ok(None),
        _ => input::read(path, input::LARGEST_BINARY).map(Some),
    }
}

/// Undoes changes. Returns a file that could not be restored.
fn put_back(done: Vec<(&Path, Option<Vec<u8>>)>) -> Option<WriteError> {
    let mut failed = None;
    for (path, old) in done.into_iter().rev() {
        let put = match old {
            Some(bytes) => staged(path, &bytes).and_then(Staged::persist),
            None => std::fs::remove_file(path),
        };
        match put {
            Ok(()) => guard::note(path, None),
            Err(error) => failed = Some(WriteError { path: path.to_owned(), error }),
        }
    }
    failed
}
