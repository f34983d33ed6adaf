//! Temporary files and directories: removed unless they are put into place, also when the process ends early.
//!
//! The crate `tempfile` is not used: its random names initialise a thread-local of this library, whose destructor
//! crashes the host's thread if it ends after the library was unloaded.

use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// Why something is not put into its place.
pub(super) const MEANWHILE: &str = "another program has written it meanwhile";

/// Temporary files and directories that are not in place yet. The code that ends the process removes them.
static BEGUN: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

fn begun() -> MutexGuard<'static, Vec<PathBuf>> {
    BEGUN.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Removes every temporary file and directory. After that nothing can be created or put into place any more. Call it
/// when the process ends; other threads may still be running.
pub fn give_up() {
    /// Threads that run on may add a few more files to a directory.
    const MOST_TRIES: u32 = 100;
    let all = begun();
    for path in all.iter() {
        for _ in 0..MOST_TRIES {
            let _ = remove(path);
            if path.symlink_metadata().is_err() {
                break;
            }
            std::thread::sleep(Duration::from_millis(1));
        }
    }
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

fn remove(path: &Path) -> io::Result<()> {
    if !path.symlink_metadata()?.is_dir() {
        return std::fs::remove_file(path);
    }
    // An empty one is removed without a file handle.
    if std::fs::remove_dir(path).is_ok() {
        return Ok(());
    }
    // One directory at a time is open, other than in `remove_dir_all`: perhaps no more file handles are available.
    let entries: io::Result<Vec<PathBuf>> = std::fs::read_dir(path)?.map(|entry| Ok(entry?.path())).collect();
    entries?.iter().try_for_each(|path| remove(path))?;
    std::fs::remove_dir(path)
}

/// A temporary file or directory. It is removed when dropped, unless it was put into its place.
#[derive(Debug)]
pub struct Scratch(PathBuf);

impl Scratch {
    /// Creates a new, empty directory for this process only, in the system's temporary directory.
    ///
    /// # Errors
    /// The directory cannot be created.
    pub fn new() -> io::Result<Scratch> {
        #[cfg_attr(not(unix), allow(unused_mut))]
        let mut builder = std::fs::DirBuilder::new();
        #[cfg(unix)]
        std::os::unix::fs::DirBuilderExt::mode(&mut builder, 0o700);
        Ok(Scratch::within(&std::env::temp_dir(), |path| builder.create(path))?.0)
    }

    /// Creates a new, empty directory beside a place.
    ///
    /// # Errors
    /// The directory cannot be created.
    pub fn beside(place: &Path) -> io::Result<Scratch> {
        Ok(Scratch::within(directory_of(place), |path| std::fs::create_dir(path))?.0)
    }

    /// Creates a file or directory with a free name. `make` must fail if the name exists.
    pub(crate) fn within<T>(
        directory: &Path,
        make: impl Fn(&Path) -> io::Result<T>,
    ) -> io::Result<(Scratch, T)> {
        let process = std::process::id();
        for attempt in 0..=u16::MAX {
            let path = directory.join(format!(".lemons-{process}-{attempt}"));
            let mut all = begun();
            match make(&path) {
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
                made => {
                    let made = made?;
                    all.push(path.clone());
                    return Ok((Scratch(path), made));
                }
            }
        }
        Err(io::ErrorKind::AlreadyExists.into())
    }

    /// Returns its present path.
    pub fn path(&self) -> &Path {
        &self.0
    }

    /// Moves it to a place, where it replaces a file or an empty directory.
    ///
    /// # Errors
    /// It cannot be moved there.
    pub(crate) fn persist(mut self, place: &Path) -> io::Result<()> {
        let mut all = begun();
        std::fs::rename(&self.0, place).map_err(|error| match error.kind() {
            io::ErrorKind::DirectoryNotEmpty => io::Error::other(format!("{MEANWHILE}; nothing was written")),
            _ => error,
        })?;
        forget(&mut all, &self.0);
        self.0.clear();
        Ok(())
    }

    /// Moves a file to a place where nothing is.
    ///
    /// # Errors
    /// Something is there, or it cannot be moved; then the file is given back.
    pub(crate) fn persist_new(mut self, place: &Path) -> Result<(), (Scratch, io::Error)> {
        let mut all = begun();
        // Other than a renamed file, a link replaces nothing. Not every file system has links.
        let moved = match std::fs::hard_link(&self.0, place) {
            Ok(()) => remove(&self.0),
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => Err(error),
            Err(_) => std::fs::rename(&self.0, place),
        };
        if moved.is_ok() {
            forget(&mut all, &self.0);
            self.0.clear();
        }
        drop(all);
        moved.map_err(|error| (self, error))
    }

    /// Moves a file to the first of the names `x-2.csv`, `x-3.csv`, … beside `x.csv` that is free, and returns it.
    ///
    /// # Errors
    /// It cannot be moved.
    pub(crate) fn persist_beside(mut self, place: &Path) -> io::Result<PathBuf> {
        let stem = place.file_stem().unwrap_or_default();
        for n in 2..=u16::MAX {
            let mut name = stem.to_owned();
            name.push(format!("-{n}"));
            if let Some(end) = place.extension() {
                name.push(".");
                name.push(end);
            }
            let free = place.with_file_name(name);
            match self.persist_new(&free) {
                Err((own, error)) if error.kind() == io::ErrorKind::AlreadyExists => self = own,
                done => return done.map(|()| free).map_err(|(_, error)| error),
            }
        }
        Err(io::ErrorKind::AlreadyExists.into())
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        if !self.0.as_os_str().is_empty() {
            let mut all = begun();
            // If it cannot be removed now (no file handle is left), [`give_up`] tries again at the end.
            if remove(&self.0).is_ok() || self.0.symlink_metadata().is_err() {
                forget(&mut all, &self.0);
            }
        }
    }
}

/// Returns the directory in which a place is.
pub(crate) fn directory_of(place: &Path) -> &Path {
    place.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

fn forget(all: &mut Vec<PathBuf>, path: &Path) {
    all.retain(|other| other != path);
    // A library that is unloaded must not leave allocated memory.
    if all.is_empty() {
        *all = Vec::new();
    }
}
