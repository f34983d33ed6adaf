//! Files written whole or not at all, and what is removed when they are not.

use std::fs::{File, TryLockError};
use std::io::{self, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, Once, PoisonError};

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

/// What has been begun and has no place yet: whoever ends the process removes it.
static BEGUN: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

fn begun() -> MutexGuard<'static, Vec<PathBuf>> {
    BEGUN.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Removes every temporary file and directory. Nothing more can be begun or put into place after that: for a process
/// that ends now, whatever its other threads do.
pub fn give_up() {
    let all = begun();
    for path in all.iter() {
        // What cannot be removed stays behind under its hidden name.
        let _ = remove(path);
    }
    std::mem::forget(all);
}

fn remove(path: &Path) -> io::Result<()> {
    if !path.symlink_metadata()?.is_dir() {
        return std::fs::remove_file(path);
    }
    // With one file handle at a time: perhaps no more are left.
    let entries = std::fs::read_dir(path)?.map(|entry| Ok(entry?.path()));
    let entries = entries.collect::<io::Result<Vec<_>>>()?;
    entries.iter().try_for_each(|path| remove(path))?;
    std::fs::remove_dir(path)
}

/// A file or directory under a name of its own, removed when dropped unless it was put into its place.
///
/// Not the crate `tempfile`: its random names initialise a thread-local of this library, whose destructor
/// crashes the host's thread when it ends after the library was unloaded.
#[derive(Debug)]
struct Temporary(PathBuf);

impl Temporary {
    /// Made by `make`, which fails where there is something.
    fn new<T>(
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

    fn file(directory: &Path) -> io::Result<(Temporary, File)> {
        let make = |path: &Path| File::options().read(true).write(true).create_new(true).open(path);
        Temporary::new(|process, attempt| directory.join(format!(".lemons-{process}-{attempt}")), make)
    }

    fn persist(mut self, place: &Path) -> io::Result<()> {
        let mut all = begun();
        std::fs::rename(&self.0, place)?;
        forget(&mut all, &self.0);
        self.0.clear();
        Ok(())
    }
}

impl Drop for Temporary {
    fn drop(&mut self) {
        if !self.0.as_os_str().is_empty() {
            let mut all = begun();
            // What cannot be removed now (no file handle is left) may be at the end: [`give_up`].
            match remove(&self.0) {
                Err(error) if error.kind() != io::ErrorKind::NotFound => {}
                _ => forget(&mut all, &self.0),
            }
        }
    }
}

fn forget(all: &mut Vec<PathBuf>, path: &Path) {
    all.retain(|other| other != path);
    // A library that is unloaded leaves nothing allocated.
    if all.is_empty() {
        *all = Vec::new();
    }
}

fn directory_of(place: &Path) -> &Path {
    place.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// A file being written beside its place; it takes the place by [`Staged::persist`], or vanishes.
#[derive(Debug)]
pub struct Staged {
    file: File,
    /// Beside the place, or wherever there is room for what goes into a device or a pipe later; `None`: the place
    /// itself is written.
    temporary: Option<Temporary>,
    /// The device or pipe, of which `file` holds the content for the moment.
    device: Option<File>,
    place: PathBuf,
    begun: bool,
    failed: bool,
}

impl Staged {
    /// A new file for `place`: beside the file that a link leads to, with the permissions of one that is
    /// there already. What is no regular file (a device, a pipe) is written itself, never replaced.
    ///
    /// # Errors
    /// The place or its directory cannot be written.
    pub fn beside(place: &Path) -> io::Result<Staged> {
        let there = match place.metadata() {
            Ok(there) => Some(there),
            Err(error) if error.kind() == io::ErrorKind::NotFound => None,
            Err(error) => return Err(error),
        };
        let staged = |file, temporary, place| Staged {
            file,
            temporary,
            device: None,
            place,
            begun: false,
            failed: false,
        };
        if there.as_ref().is_some_and(|there| !there.is_file()) {
            let file = File::options().write(true).open(place)?;
            return Ok(staged(file, None, place.to_owned()));
        }
        let place = if there.is_some() { place.canonicalize()? } else { place.to_owned() };
        let (temporary, file) = Temporary::file(directory_of(&place))?;
        let staged = staged(file, Some(temporary), place);
        if let Some(there) = there {
            staged.file.set_permissions(there.permissions())?;
        }
        Ok(staged)
    }

    /// Has it written by what wants a path and not a file.
    ///
    /// # Errors
    /// Those of `write`, or there is no room for what goes into a device or a pipe.
    pub fn fill<T>(&mut self, write: impl FnOnce(&Path) -> io::Result<T>) -> io::Result<T> {
        if self.temporary.is_none() {
            self.detour()?;
        }
        let path = self.temporary.as_ref().map_or(&*self.place, |temporary| &temporary.0);
        write(path).inspect_err(|_| self.failed = true)
    }

    /// What goes into a device or a pipe is written elsewhere first: there one can seek.
    fn detour(&mut self) -> io::Result<()> {
        let (temporary, file) = Temporary::file(&std::env::temp_dir())?;
        self.device = Some(std::mem::replace(&mut self.file, file));
        self.temporary = Some(temporary);
        Ok(())
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
    /// The place cannot be taken, or something could not be written; it is as it was then.
    pub fn persist(mut self) -> io::Result<()> {
        if self.failed {
            return Err(io::Error::other("a part of it could not be written"));
        }
        if let Some(mut device) = self.device.take() {
            self.file.rewind()?;
            io::copy(&mut self.file, &mut device)?;
            return device.flush();
        }
        self.temporary.take().map_or(Ok(()), |temporary| temporary.persist(&self.place))
    }
}

impl Write for Staged {
    /// After a failure the file is lost: what follows goes nowhere, so that writers which end their work when they
    /// are dropped do not complain as well.
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if self.failed {
            return Ok(bytes.len());
        }
        self.begun = true;
        self.file.write(bytes).inspect_err(|error| self.failed = error.kind() != io::ErrorKind::Interrupted)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

impl Seek for Staged {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        if self.temporary.is_none() && !self.begun {
            self.detour()?;
        }
        self.file.seek(to)
    }
}

/// A directory being written beside its place; it takes the place by [`StagedDirectory::persist`], or vanishes.
#[derive(Debug)]
pub struct StagedDirectory(Temporary);

impl StagedDirectory {
    /// A new, empty directory beside `place`.
    ///
    /// # Errors
    /// It cannot be made.
    pub fn beside(place: &Path) -> io::Result<StagedDirectory> {
        // `Trial/.` and `Trial/` have the parent of `Trial`.
        let parent = directory_of(place);
        let name = |process, attempt| parent.join(format!(".lemons-{process}-{attempt}.d"));
        Ok(StagedDirectory(Temporary::new(name, |path| std::fs::create_dir(path))?.0))
    }

    /// Where it is for the moment.
    pub fn path(&self) -> &Path {
        &self.0.0
    }

    /// Takes its place, where nothing is.
    ///
    /// # Errors
    /// The place cannot be taken.
    pub fn persist(self, place: &Path) -> io::Result<()> {
        self.0.persist(place)
    }
}

/// A directory for what only this process needs, in the system's temporary directory; removed when dropped, or, where
/// the process was killed, by the next one that makes such a directory.
#[derive(Debug)]
pub struct Scratch {
    content: PathBuf,
    /// Locked while the process lives; given back before the directory is removed.
    _lock: File,
    _temporary: Temporary,
}

const SCRATCH: &str = "lemons-scratch-";
const SCRATCH_LOCK: &str = "lock";

impl Scratch {
    /// A new, empty directory.
    ///
    /// # Errors
    /// It cannot be made.
    pub fn new() -> io::Result<Scratch> {
        static CLEARED: Once = Once::new();
        CLEARED.call_once(clear_scratch);
        let directory = std::env::temp_dir();
        let name = |process, attempt| directory.join(format!("{SCRATCH}{process}-{attempt}"));
        loop {
            let (temporary, ()) = Temporary::new(name, private_directory)?;
            let path = temporary.0.join(SCRATCH_LOCK);
            let made = File::options().write(true).create_new(true).open(&path).inspect(|lock| {
                // Where files cannot be locked, nobody clears.
                let _ = lock.lock();
            });
            let content = temporary.0.join("files");
            // Another process may have taken it for left behind before it was locked.
            match made.and_then(|lock| std::fs::create_dir(&content).map(|()| lock)) {
                Ok(lock) => return Ok(Scratch { content, _lock: lock, _temporary: temporary }),
                Err(error) if error.kind() == io::ErrorKind::NotFound => {}
                Err(error) => return Err(error),
            }
        }
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.content
    }
}

fn private_directory(path: &Path) -> io::Result<()> {
    let mut builder = std::fs::DirBuilder::new();
    #[cfg(unix)]
    std::os::unix::fs::DirBuilderExt::mode(&mut builder, 0o700);
    builder.create(path)
}

/// Removes what processes left behind that were killed. What cannot be looked at or removed is not ours.
fn clear_scratch() {
    for entry in std::fs::read_dir(std::env::temp_dir()).into_iter().flatten().flatten() {
        let path = entry.path();
        let ours = entry.file_name().to_string_lossy().starts_with(SCRATCH);
        if !ours || !entry.file_type().is_ok_and(|kind| kind.is_dir()) {
            continue;
        }
        let lock = path.join(SCRATCH_LOCK);
        // Somebody else's pipe of that name would keep whoever opens it waiting.
        if !lock.symlink_metadata().is_ok_and(|there| there.is_file()) {
            continue;
        }
        let Ok(lock) = File::options().write(true).open(lock) else { continue };
        match lock.try_lock() {
            Ok(()) => drop(std::fs::remove_dir_all(&path)),
            Err(TryLockError::WouldBlock | TryLockError::Error(_)) => {}
        }
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
