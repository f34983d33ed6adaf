//! Files and directories that are written beside their place, then moved there: readers see the old content or the new
//! one, never a part.

use crate::files::input;
use crate::files::temporary::{MEANWHILE, Scratch, directory_of};
use std::fs::{File, TryLockError};
use std::io::{self, ErrorKind, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, SystemTime};

/// A file that could not be written.
#[derive(Debug, thiserror::Error)]
#[error("{}: cannot be written: {error}", path.display())]
pub struct WriteError {
    /// The file or directory.
    pub path: PathBuf,
    /// The reason.
    pub error: io::Error,
}

impl WriteError {
    /// Returns a function for `map_err` that adds the path.
    pub fn at(path: &Path) -> impl FnOnce(io::Error) -> WriteError + use<> {
        let path = path.to_owned();
        move |error| WriteError { path, error }
    }
}

/// Returns the path to which symbolic links lead; nothing need be there. It has no links if its directory exists.
///
/// # Errors
/// Links form a loop, or a directory cannot be read.
pub fn target_of(path: &Path) -> io::Result<PathBuf> {
    /// More links than any system follows.
    const MOST_LINKS: usize = 64;
    if let Ok(there) = path.canonicalize() {
        return Ok(there);
    }
    let mut path = path.to_owned();
    for _ in 0..MOST_LINKS {
        match std::fs::read_link(&path) {
            Ok(next) => path = directory_of(&path).join(next),
            Err(_) => {
                let name = path.file_name().ok_or(ErrorKind::InvalidFilename)?;
                let directory = directory_of(&path);
                return Ok(directory.canonicalize().unwrap_or_else(|_| directory.to_owned()).join(name));
            }
        }
    }
    Err(io::Error::other("its symbolic links form a loop"))
}

static READER_LEFT: AtomicBool = AtomicBool::new(false);

/// Returns whether writing to a pipe by [`Staged::onto`] failed because its reader had closed it. (Callers may replace
/// the error itself by another one.)
pub fn reader_left() -> bool {
    READER_LEFT.load(Ordering::Relaxed)
}

/// When a regular file was written, and its length: what tells whether somebody else has written it since.
pub type FileStamp = (SystemTime, u64);

/// Returns the mark of what is in a place; `None`: no regular file.
pub fn mark_of(place: &Path) -> Option<FileStamp> {
    let there = place.metadata().ok().filter(std::fs::Metadata::is_file)?;
    Some((there.modified().ok()?, there.len()))
}

/// Locks a directory until it is dropped, or until the process ends: of two who look at a place and then write it, one waits.
/// `None` where directories cannot be locked, or where somebody holds the lock for long, such as `flock` around a command.
fn locked(directory: &Path) -> Option<File> {
    const PAUSE: Duration = Duration::from_millis(5);
    const MOST_TRIES: u32 = 2000;
    let opened = File::open(directory).ok()?;
    for _ in 0..MOST_TRIES {
        match opened.try_lock() {
            Ok(()) => return Some(opened),
            Err(TryLockError::WouldBlock) => std::thread::sleep(PAUSE),
            Err(TryLockError::Error(_)) => return None,
        }
    }
    None
}

/// A file that is written beside its place. [`Staged::persist`] moves it there; otherwise it is removed.
#[derive(Debug)]
pub struct Staged {
    file: File,
    /// The file, its place and what may be replaced there; `None`: an open file is written directly.
    temporary: Option<(Scratch, PathBuf, Option<FileStamp>)>,
    failed: bool,
}

impl Staged {
    /// Creates a new file for `place`. It is beside the target of a link (which need not exist) and gets the
    /// permissions of an existing file.
    ///
    /// # Errors
    /// The directory cannot be written, or something other than a regular file is in the place.
    pub fn beside(place: &Path) -> io::Result<Staged> {
        let place = target_of(place)?;
        let there = match place.metadata() {
            Ok(there) => Some(there),
            Err(error) if error.kind() == ErrorKind::NotFound => None,
            Err(error) => return Err(error),
        };
        there.as_ref().map_or(Ok(()), input::check_regular)?;
        let (temporary, file) = Scratch::within(directory_of(&place), |path| {
            File::options().read(true).write(true).create_new(true).open(path)
        })?;
        let before = mark_of(&place);
        let staged = Staged { file, temporary: Some((temporary, place, before)), failed: false };
        if let Some(there) = there {
            staged.file.set_permissions(there.permissions())?;
        }
        Ok(staged)
    }

    /// Replaces only what had this mark earlier, when it was asked whether the place is free.
    #[must_use]
    pub fn instead_of(mut self, before: Option<FileStamp>) -> Staged {
        if let Some((_, _, own)) = &mut self.temporary {
            *own = before;
        }
        self
    }

    /// Writes directly to an open file, such as standard output. See [`reader_left`].
    pub fn onto(file: File) -> Staged {
        Staged { file, temporary: None, failed: false }
    }

    /// Lets `write` write the content, for functions that need a path and not a file.
    ///
    /// # Errors
    /// Those of `write`, or the file has no path.
    pub fn fill<T>(&mut self, write: impl FnOnce(&Path) -> io::Result<T>) -> io::Result<T> {
        let (temporary, ..) = self.temporary.as_ref().ok_or(ErrorKind::Unsupported)?;
        write(temporary.path()).inspect_err(|_| self.failed = true)
    }

    /// Makes the written content survive a power failure.
    ///
    /// # Errors
    /// The disk reports an error.
    pub fn sync(&self) -> io::Result<()> {
        self.file.sync_all()
    }

    /// Moves the file into its place. What somebody else has put there meanwhile stays: the file then gets a free name
    /// beside it.
    ///
    /// # Errors
    /// The file cannot be moved there, or a part of it could not be written; the place is then unchanged. Or it has
    /// another name, which the error says.
    pub fn persist(self) -> io::Result<()> {
        if self.failed {
            return Err(io::Error::other("a part of it could not be written"));
        }
        let Some((temporary, place)) = self.put()? else { return Ok(()) };
        let free = temporary.persist_beside(&place)?;
        let free = free.display();
        Err(io::Error::other(format!("{MEANWHILE}; this result is in {free}")))
    }

    /// Moves the file into its place, and returns it where somebody else has put a file there meanwhile.
    fn put(self) -> io::Result<Option<(Scratch, PathBuf)>> {
        // The modification time is final once the file is closed.
        drop(self.file);
        let Some((temporary, place, before)) = self.temporary else { return Ok(None) };
        let _alone = locked(directory_of(&place));
        match mark_of(&place) {
            Some(now) if Some(now) == before => temporary.persist(&place).map(|()| None),
            Some(_) => Ok(Some((temporary, place))),
            None => match temporary.persist_new(&place) {
                Err((temporary, error)) if error.kind() == ErrorKind::AlreadyExists => {
                    Ok(Some((temporary, place)))
                }
                done => done.map(|()| None).map_err(|(_, error)| error),
            },
        }
    }
}

impl Write for Staged {
    /// After an error the file is lost. Further writing is ignored, so that writers that finish when they are dropped
    /// report no second error.
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if self.failed {
            return Ok(bytes.len());
        }
        self.file.write(bytes).inspect_err(|error| {
            if self.temporary.is_none() && error.kind() == ErrorKind::BrokenPipe {
                READER_LEFT.store(true, Ordering::Relaxed);
            }
            self.failed = error.kind() != ErrorKind::Interrupted;
        })
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

/// A change of a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Change {
    /// Writes this text.
    Write(PathBuf, String),
    /// Removes the file, if it is there.
    Remove(PathBuf),
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
        let old = match input::read(path, input::LARGEST_BINARY) {
            Err(error) if error.kind() == ErrorKind::NotFound => None,
            old => Some(old.map_err(WriteError::at(path))?),
        };
        ready.push((path, new, old));
    }
    let mut done: Vec<(&Path, Option<Vec<u8>>)> = Vec::new();
    for (path, new, old) in ready {
        let put = match new {
            // Of several files, none gets another name.
            Some(file) => match file.put() {
                Ok(Some(_)) => Err(io::Error::other(MEANWHILE)),
                put => put.map(drop),
            },
            None if old.is_some() => std::fs::remove_file(path),
            None => Ok(()),
        };
        if let Err(error) = put {
            return Err(put_back(done).err().unwrap_or_else(|| WriteError::at(path)(error)));
        }
        done.push((path, old));
    }
    Ok(())
}

/// Undoes changes.
fn put_back(done: Vec<(&Path, Option<Vec<u8>>)>) -> Result<(), WriteError> {
    let mut all = Ok(());
    for (path, old) in done {
        let put = match old {
            Some(bytes) => staged(path, &bytes).and_then(Staged::persist),
            None => std::fs::remove_file(path),
        };
        all = all.and(put.map_err(WriteError::at(path)));
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::make_directories;
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
        make_directories(&at("c/inside")).unwrap();
        // The same file twice: the second removal fails after the other changes were made.
        std::fs::write(at("b"), "old b").unwrap();
        let twice = [Change::Remove(at("b")), Change::Remove(at("b"))];
        for last in
            [&[Change::Remove(at("c"))][..], &[write("c", "x")], &[write("no/such/directory", "x")], &twice]
        {
            let all = [&[write("a", "newer a"), write("d", "new d")], last].concat();
            assert!(change_all(&all).is_err());
            assert_eq!(std::fs::read_to_string(at("a")).unwrap(), "new a");
            assert_eq!(std::fs::read_to_string(at("b")).unwrap(), "old b");
            assert!(!at("d").exists());
        }
        let left = std::fs::read_dir(directory.path()).unwrap().count();
        assert_eq!(left, 3, "no temporary file is left");
    }

    /// Each of those who write one place at a time is told that it is not alone, but for the first.
    #[test]
    fn of_those_who_write_one_place_none_is_lost() {
        let directory = TempDir::new().unwrap();
        let at = |name: &str| directory.path().join(name);
        let read = |name: &str| std::fs::read_to_string(at(name)).unwrap();
        for there in [false, true] {
            let name = |end: &str| format!("{there}{end}");
            if there {
                std::fs::write(at("true.csv"), "replaced").unwrap();
            }
            let all =
                ["first", "second", "third"].map(|text| staged(&at(&name(".csv")), text.as_bytes()).unwrap());
            let told = all.map(|file| file.persist().err().map(|error| error.to_string()));
            let other = |end: &str| {
                let file = target_of(&at(&name(end))).unwrap();
                Some(format!(
                    "another program has written it meanwhile; this result is in {}",
                    file.display()
                ))
            };
            assert_eq!(told, [None, other("-2.csv"), other("-3.csv")]);
            let found = [".csv", "-2.csv", "-3.csv"].map(|end| read(&name(end)));
            assert_eq!(found, ["first", "second", "third"]);
        }
        // Nothing was there when somebody asked.
        let asked = staged(&at("asked"), b"new").unwrap().instead_of(None);
        std::fs::write(at("asked"), "of another").unwrap();
        assert!(asked.persist().is_err());
        assert_eq!((read("asked"), read("asked-2")), ("of another".to_owned(), "new".to_owned()));
        assert_eq!(std::fs::read_dir(directory.path()).unwrap().count(), 8, "no temporary file is left");
    }

    /// A reader of a place that another one, who holds the lock, is about to write sees what that one has written.
    #[test]
    #[cfg(unix)]
    fn looking_at_a_place_and_writing_it_are_one() {
        let directory = TempDir::new().unwrap();
        let at = directory.path().join("x");
        std::fs::write(&at, "old").unwrap();
        let file = staged(&at, b"new").unwrap();
        let lock = File::open(directory.path()).unwrap();
        lock.lock().unwrap();
        std::thread::scope(|scope| {
            let put = scope.spawn(|| file.persist());
            // Without a lock it would be there by now.
            std::thread::sleep(Duration::from_millis(100));
            assert_eq!(std::fs::read_to_string(&at).unwrap(), "old");
            std::fs::write(&at, "of another").unwrap();
            lock.unlock().unwrap();
            assert!(put.join().unwrap().unwrap_err().to_string().contains("x-2"));
        });
        assert_eq!(std::fs::read_to_string(&at).unwrap(), "of another");
    }

    #[test]
    #[cfg(unix)]
    fn links_lead_on_permissions_stay_and_loops_are_an_error() {
        use std::os::unix::fs::{PermissionsExt, symlink};
        let directory = TempDir::new().unwrap();
        let at = |name: &str| directory.path().join(name);
        let write = |name: &str, text: &str| change_all(&[Change::Write(at(name), text.into())]);
        symlink("file", at("link")).unwrap();
        symlink(at("link"), at("second")).unwrap();
        assert_eq!(target_of(&at("second")).unwrap(), target_of(&at("file")).unwrap());
        for text in ["new", "newer"] {
            write("second", text).unwrap();
            assert_eq!(std::fs::read_to_string(at("file")).unwrap(), text);
            assert!(["link", "second"].iter().all(|link| at(link).symlink_metadata().unwrap().is_symlink()));
            std::fs::set_permissions(at("file"), std::fs::Permissions::from_mode(0o640)).unwrap();
        }
        write("file", "newest").unwrap();
        assert_eq!(at("file").metadata().unwrap().permissions().mode() & 0o777, 0o640);
        symlink("there", at("back")).unwrap();
        symlink("back", at("there")).unwrap();
        let error = write("back", "x").unwrap_err().to_string();
        assert!(error.starts_with(&format!("{}: cannot be written: ", at("back").display())), "{error}");
        assert!(at("back").symlink_metadata().unwrap().is_symlink());
    }

    #[test]
    fn a_directory_appears_whole_and_replaces_nothing() {
        let directory = TempDir::new().unwrap();
        let place = directory.path().join("Trial");
        for (existing, works) in [(false, true), (true, false)] {
            let staged = Scratch::beside(&place).unwrap();
            std::fs::write(staged.path().join("a"), existing.to_string()).unwrap();
            assert_eq!(place.exists(), existing);
            let put = staged.persist(&place).map_err(|error| error.to_string());
            let refused = format!("{MEANWHILE}; nothing was written");
            assert_eq!(put, if works { Ok(()) } else { Err(refused) });
            assert_eq!(std::fs::read_to_string(place.join("a")).unwrap(), "false");
        }
        assert_eq!(std::fs::read_dir(directory.path()).unwrap().count(), 1);
    }
}
