//! Files written whole or not at all.

use std::fs::File;
use std::io::{self, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

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

/// A file being written beside its place; it takes the place by [`Staged::persist`], or vanishes.
///
/// Not the crate `tempfile`: its random names initialise a thread-local of this library, whose destructor
/// crashes the host's thread when it ends after the library was unloaded.
#[derive(Debug)]
pub struct Staged {
    file: File,
    /// Where it is written; empty once it is persisted, or if the place itself is written.
    temporary: PathBuf,
    place: PathBuf,
}

impl Staged {
    /// A new file for `place`: beside the file that a link leads to, with the permissions of one that is
    /// there already. What is no regular file (a device, a pipe) is written itself.
    ///
    /// # Errors
    /// The place or its directory cannot be written.
    pub fn beside(place: &Path) -> io::Result<Staged> {
        let there = match place.metadata() {
            Ok(there) => Some(there),
            Err(error) if error.kind() == io::ErrorKind::NotFound => None,
            Err(error) => return Err(error),
        };
        if there.as_ref().is_some_and(|there| !there.is_file()) {
            let file = File::options().write(true).open(place)?;
            return Ok(Staged { file, temporary: PathBuf::new(), place: place.to_owned() });
        }
        let place = if there.is_some() { place.canonicalize()? } else { place.to_owned() };
        let directory =
            place.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let process = std::process::id();
        for attempt in 0.. {
            let temporary = directory.join(format!(".lemons-{process}-{attempt}"));
            match File::options().write(true).create_new(true).open(&temporary) {
                Ok(file) => {
                    let staged = Staged { file, temporary, place };
                    if let Some(there) = there {
                        staged.file.set_permissions(there.permissions())?;
                    }
                    return Ok(staged);
                }
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists && attempt < u16::MAX => {}
                Err(error) => return Err(error),
            }
        }
        Err(io::ErrorKind::AlreadyExists.into())
    }

    /// Makes what was written survive a power failure.
    ///
    /// # Errors
    /// The disk refuses it.
    pub fn sync(&self) -> io::Result<()> {
        self.file.sync_all()
    }

    /// Takes its place.
    ///
    /// # Errors
    /// The place cannot be taken; it is as it was then.
    pub fn persist(mut self) -> io::Result<()> {
        if !self.temporary.as_os_str().is_empty() {
            std::fs::rename(&self.temporary, &self.place)?;
            self.temporary.clear();
        }
        Ok(())
    }
}

impl Drop for Staged {
    fn drop(&mut self) {
        if !self.temporary.as_os_str().is_empty() {
            // What cannot be removed stays behind under its hidden name.
            let _ = std::fs::remove_file(&self.temporary);
        }
    }
}

impl Write for Staged {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.file.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

impl Seek for Staged {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.file.seek(to)
    }
}

fn staged(path: &Path, bytes: &[u8]) -> io::Result<Staged> {
    let mut file = Staged::beside(path)?;
    file.write_all(bytes)?;
    Ok(file)
}

/// Writes a file through a temporary one beside it: a reader sees the old text or the new one, never half of it.
///
/// # Errors
/// The file is as it was then.
pub fn write_atomically(path: &Path, text: &str) -> Result<(), WriteError> {
    let written = staged(path, text.as_bytes()).and_then(Staged::persist);
    written.map_err(WriteError::at(path))
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
            Change::Write(path, text) => {
                (path, Some(staged(path, text.as_bytes()).map_err(WriteError::at(path))?))
            }
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
            Some(file) => file.persist(),
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
            Some(bytes) => staged(path, &bytes).and_then(Staged::persist),
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

    #[test]
    #[cfg(unix)]
    fn links_lead_on_and_permissions_stay() {
        use std::os::unix::fs::{PermissionsExt, symlink};
        let directory = TempDir::new().unwrap();
        let (file, link) = (directory.path().join("file"), directory.path().join("link"));
        std::fs::write(&file, "old").unwrap();
        std::fs::set_permissions(&file, std::fs::Permissions::from_mode(0o640)).unwrap();
        symlink(&file, &link).unwrap();
        write_atomically(&link, "new").unwrap();
        assert!(link.symlink_metadata().unwrap().is_symlink());
        assert_eq!(std::fs::read_to_string(&file).unwrap(), "new");
        assert_eq!(file.metadata().unwrap().permissions().mode() & 0o777, 0o640);
    }

    #[test]
    #[cfg(unix)]
    fn what_is_no_regular_file_is_written_not_replaced() {
        use std::os::unix::fs::FileTypeExt;
        let directory = TempDir::new().unwrap();
        let pipe = directory.path().join("pipe");
        assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
        let reader = std::thread::spawn({
            let pipe = pipe.clone();
            move || std::fs::read_to_string(pipe).unwrap()
        });
        write_atomically(&pipe, "through").unwrap();
        assert_eq!(reader.join().unwrap(), "through");
        assert!(pipe.metadata().unwrap().file_type().is_fifo());
        assert!(write_atomically(directory.path(), "x").is_err(), "a directory is no place for a file");
    }
}
