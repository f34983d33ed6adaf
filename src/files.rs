//! Files written whole or not at all.

use std::io::{self, Write};
use std::path::{Path, PathBuf};
use tempfile::NamedTempFile;

/// A file that could not be written.
#[derive(Debug, thiserror::Error)]
#[error("{}: cannot be written: {error}", path.display())]
pub struct WriteError {
    /// The file or directory.
    pub path: PathBuf,
    /// Why.
    pub error: io::Error,
}

impl WriteError {
    /// For `map_err`.
    pub fn at(path: &Path) -> impl FnOnce(io::Error) -> WriteError + use<> {
        let path = path.to_owned();
        move |error| WriteError { path, error }
    }
}

/// A temporary file in the directory of `path`, as open to others as the umask says; to be persisted there.
///
/// # Errors
/// The directory cannot be written.
pub fn temporary_beside(path: &Path) -> io::Result<NamedTempFile> {
    let directory = path.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut builder = tempfile::Builder::new();
    builder.prefix(".lemons-");
    // A temporary file is its owner's alone by default.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    builder.tempfile_in(directory)
}

fn staged(path: &Path, text: &str) -> io::Result<NamedTempFile> {
    let mut file = temporary_beside(path)?;
    file.write_all(text.as_bytes())?;
    Ok(file)
}

/// Writes a file through a temporary one beside it: a reader sees the old text or the new one, never half of it.
///
/// # Errors
/// The file is as it was then.
pub fn write_atomically(path: &Path, text: &str) -> Result<(), WriteError> {
    let written = staged(path, text).and_then(|file| file.persist(path).map_err(|failed| failed.error));
    written.map(drop).map_err(WriteError::at(path))
}

/// What becomes of a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Change {
    /// It holds this text.
    Write(PathBuf, String),
    /// It is not there.
    Remove(PathBuf),
}

/// Makes all changes or none: everything is written beside its place first, and what was already put into
/// place is put back when a later change fails.
///
/// # Errors
/// Every file is byte for byte as it was then (or the message says which could not be put back).
pub fn change_all(changes: &[Change]) -> Result<(), WriteError> {
    let mut ready = Vec::with_capacity(changes.len());
    for change in changes {
        let (path, new) = match change {
            Change::Write(path, text) => (path, Some(staged(path, text).map_err(WriteError::at(path))?)),
            Change::Remove(path) => (path, None),
        };
        let old = match std::fs::read(path) {
            Ok(bytes) => Some(bytes),
            Err(error) if error.kind() == io::ErrorKind::NotFound => None,
            Err(error) => return Err(WriteError::at(path)(error)),
        };
        ready.push((path, new, old));
    }
    let mut done: Vec<(&Path, Option<Vec<u8>>)> = Vec::new();
    for (path, new, old) in ready {
        let put = match new {
            Some(file) => file.persist(path).map(drop).map_err(|failed| failed.error),
            None if old.is_some() => std::fs::remove_file(path),
            None => Ok(()),
        };
        if let Err(error) = put {
            return Err(put_back(done).unwrap_or_else(|| WriteError::at(path)(error)));
        }
        done.push((path, old));
    }
    Ok(())
}

/// Undoes changes; answers a file that could not be put back.
fn put_back(done: Vec<(&Path, Option<Vec<u8>>)>) -> Option<WriteError> {
    let mut failed = None;
    for (path, old) in done.into_iter().rev() {
        let put = match old {
            Some(bytes) => temporary_beside(path)
                .and_then(|mut file| file.write_all(&bytes).map(|()| file))
                .and_then(|file| file.persist(path).map(drop).map_err(|failed| failed.error)),
            None => std::fs::remove_file(path),
        };
        if let Err(error) = put {
            failed = Some(WriteError { path: path.to_owned(), error });
        }
    }
    failed
}

#[cfg(test)]
mod tests {
    use super::*;
    use tempfile::TempDir;

    #[test]
    fn all_changes_or_none() {
        let directory = TempDir::new().unwrap();
        let at = |name: &str| directory.path().join(name);
        std::fs::write(at("a"), "old a").unwrap();
        std::fs::write(at("b"), "old b").unwrap();
        let write = |name: &str, text: &str| Change::Write(at(name), text.into());
        change_all(&[write("a", "new a"), Change::Remove(at("b")), Change::Remove(at("none"))]).unwrap();
        assert_eq!(std::fs::read_to_string(at("a")).unwrap(), "new a");
        assert!(!at("b").exists());
        // A directory in the way makes the last change fail after the others were made.
        std::fs::create_dir_all(at("c/inside")).unwrap();
        for last in [Change::Remove(at("c")), write("c", "x"), write("no/such/directory", "x")] {
            assert!(change_all(&[write("a", "newer a"), write("d", "new d"), last]).is_err());
            assert_eq!(std::fs::read_to_string(at("a")).unwrap(), "new a");
            assert!(!at("d").exists());
        }
        let left = std::fs::read_dir(directory.path()).unwrap().count();
        assert_eq!(left, 2, "no temporary file is left");
    }
}
