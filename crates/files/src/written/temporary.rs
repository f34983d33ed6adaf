//! Temporary files and directories: removed unless they are put into place, also when the process ends early.

use super::guard::{self, Changed};
use super::paths::names_beside;
use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// Temporary files and directories that are not in place yet. The code that ends the process removes them.
static BEGUN: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

fn begun() -> MutexGuard<'static, Vec<PathBuf>> {
    BEGUN.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Removes every temporary file and directory. After that nothing can be created or put into place any more. Call it
/// when the process ends; other threads may still be running.
pub fn give_up() {
    let all = begun();
    all.iter().for_each(|path| remove_under_way(path));
    std::mem::forget(all);
}

/// Creates a directory and those that lead to it, unless they exist. Like all here it waits for ever after [`give_up`]:
/// `std::fs::create_dir_all` would make a temporary directory again that was just removed.
///
/// # Errors
/// It cannot be created.
pub fn make_directories(path: &Path) -> io::Result<()> {
    let _none_is_removed_meanwhile = begun();
    std::fs::create_dir_all(path)
}

/// Removes a directory or file to which other threads may still write. If it cannot be removed, it stays under its
/// hidden name.
fn remove_under_way(path: &Path) {
    /// After the directory is renamed, a thread creates at most one more file in it.
    const MOST_TRIES: u32 = 100;
    let mut path = path.to_owned();
    // Threads do not know its new name, so they add nothing while it is removed.
    let mut renamed = path.clone().into_os_string();
    renamed.push("-removed");
    if path.is_dir() && std::fs::rename(&path, &renamed).is_ok() {
        path = renamed.into();
    }
    for _ in 0..MOST_TRIES {
        let _ = remove(&path);
        if path.symlink_metadata().is_err() {
            return;
        }
        std::thread::sleep(Duration::from_millis(1));
    }
}

fn remove(path: &Path) -> io::Result<()> {
    if !path.symlink_metadata()?.is_dir() {
        return std::fs::remove_file(path);
    }
    // Keep only one file handle open; perhaps no more are available.
    let entries = std::fs::read_dir(path)?.map(|entry| Ok(entry?.path()));
    let entries = entries.collect::<io::Result<Vec<_>>>()?;
    entries.iter().try_for_each(|path| remove(path))?;
    std::fs::remove_dir(path)
}

/// A temporary file or directory. It is removed when dropped, unless it was put into its place.
///
/// The crate `tempfile` is not used: its random names initialise a thread-local of this library, whose destructor
/// crashes the host's thread if it ends after the library was unloaded.
#[derive(Debug)]
pub(super) struct Temporary(PathBuf);

impl Temporary {
    /// `make` creates the file or directory; it must fail if the name exists.
    pub(super) fn new<T>(
        name: impl Fn(u32, u16) -> PathBuf,
        make: impl Fn(&Path) -> io::Result<T>,
    ) -> io::Result<(Temporary, T)> {
        let process = std::process::id();
        for attempt in 0..=u16::MAX {
            let path = name(process, attempt);
            let mut all = begun();
            match make(&path) {
                Ok(made) => {
                    all.push(path.clone());
                    return Ok((Temporary(path), made));
                }
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
                Err(error) => return Err(error),
            }
        }
        Err(io::ErrorKind::AlreadyExists.into())
    }

    /// Creates a file in a directory.
    pub(super) fn file(directory: &Path) -> io::Result<(Temporary, File)> {
        Temporary::new(|process, attempt| directory.join(format!(".lemons-{process}-{attempt}")), new_file)
    }

    /// Creates a file of this name, which must not exist.
    pub(super) fn named(path: PathBuf) -> io::Result<(Temporary, File)> {
        let mut all = begun();
        let file = new_file(&path)?;
        all.push(path.clone());
        Ok((Temporary(path), file))
    }

    /// Returns its present path.
    pub(super) fn path(&self) -> &Path {
        &self.0
    }

    /// Moves it into its place if no other program changed a guarded file there; else keeps it beside the place.
    pub(super) fn persist(self, place: &Path) -> io::Result<()> {
        if guard::is_changed(place)? {
            return Err(self.keep_beside(place));
        }
        let written = self.0.metadata()?;
        self.take(place, || guard::note(place, Some(written)))
    }

    /// Moves it to a place, whatever is there, and calls `note` before another thread can create or remove anything.
    pub(super) fn take(mut self, place: &Path, note: impl FnOnce()) -> io::Result<()> {
        let mut all = begun();
        std::fs::rename(&self.0, place)?;
        note();
        forget(&mut all, &self.0);
        self.0.clear();
        Ok(())
    }

    /// Moves it to a free name beside the place, because another program changed something in the place.
    pub(super) fn keep_beside(self, place: &Path) -> io::Error {
        let directory = self.0.is_dir();
        for name in names_beside(place) {
            // No other process can take the name meanwhile: a directory cannot replace a directory that is not empty.
            let free = match directory {
                true if name.symlink_metadata().is_ok() => Err(io::ErrorKind::AlreadyExists.into()),
                true => Ok(()),
                false => File::options().write(true).create_new(true).open(&name).map(drop),
            };
            match free {
                Ok(()) => {
                    return match self.take(&name, || ()) {
                        Ok(()) => io::Error::other(Changed { kept: Some(name) }),
                        Err(error) => {
                            // Only the name was taken.
                            if !directory {
                                let _ = std::fs::remove_file(&name);
                            }
                            error
                        }
                    };
                }
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
                Err(error) => return error,
            }
        }
        io::Error::other(Changed { kept: None })
    }
}

impl Drop for Temporary {
    fn drop(&mut self) {
        if !self.0.as_os_str().is_empty() {
            let mut all = begun();
            // If it cannot be removed now (no file handle is left), [`give_up`](crate::give_up) tries again at the end.
            match remove(&self.0) {
                Err(_) if self.0.symlink_metadata().is_ok() => {}
                _ => forget(&mut all, &self.0),
            }
        }
    }
}

fn new_file(path: &Path) -> io::Result<File> {
    File::options().read(true).write(true).create_new(true).open(path)
}

fn forget(all: &mut Vec<PathBuf>, path: &Path) {
    all.retain(|other| other != path);
    // A library that is unloaded must not leave allocated memory.
    if all.is_empty() {
        *all = Vec::new();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicBool, Ordering};
    use tempfile::TempDir;

    #[test]
    fn a_name_that_was_taken_in_vain_is_free_again() {
        let directory = TempDir::new().unwrap();
        let (temporary, _) = Temporary::file(directory.path()).unwrap();
        // The move fails.
        std::fs::remove_file(temporary.path()).unwrap();
        let error = temporary.keep_beside(&directory.path().join("table.csv"));
        assert_eq!(error.kind(), io::ErrorKind::NotFound);
        assert_eq!(std::fs::read_dir(directory.path()).unwrap().count(), 0);
    }

    #[test]
    fn a_directory_is_removed_while_it_is_written() {
        let directory = TempDir::new().unwrap();
        let ends = AtomicBool::new(false);
        for round in 0..20 {
            let place = directory.path().join(format!("begun-{round}"));
            std::fs::create_dir(&place).unwrap();
            ends.store(false, Ordering::Relaxed);
            std::thread::scope(|scope| {
                scope.spawn(|| {
                    for k in 0.. {
                        let inside = place.join(format!("inside-{}", k % 7));
                        let _ = std::fs::create_dir(&inside);
                        let _ = File::create(inside.join(format!("{k}")));
                        if ends.load(Ordering::Relaxed) {
                            break;
                        }
                    }
                });
                while std::fs::read_dir(&place).unwrap().count() < 7 {}
                remove_under_way(&place);
                ends.store(true, Ordering::Relaxed);
            });
            let left = std::fs::read_dir(directory.path()).unwrap().count();
            assert_eq!(left, 0, "round {round}");
        }
    }
}
