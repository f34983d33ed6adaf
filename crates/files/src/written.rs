//! Writes files completely or not at all, and removes temporary ones.

mod guard;

pub use guard::{Before, Changed, guard, placed};
use std::fs::{File, Metadata, TryLockError};
use std::io::{self, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard, Once, PoisonError};
use std::time::Duration;

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

/// Returns the target of symbolic links, which need not exist.
fn led_to(path: &Path) -> io::Result<PathBuf> {
    /// More links than any system follows.
    const MOST_LINKS: usize = 64;
    let mut path = path.to_owned();
    for _ in 0..MOST_LINKS {
        match std::fs::read_link(&path) {
            Ok(next) => path = directory_of(&path).join(next),
            Err(_) => return Ok(path),
        }
    }
    Err(io::Error::other("its symbolic links form a loop"))
}

/// Returns the unique path of a file, which need not exist: absolute and without links.
///
/// # Errors
/// Links form a loop, or a directory cannot be read.
pub fn only_path(path: &Path) -> io::Result<PathBuf> {
    if let Ok(there) = path.canonicalize() {
        return Ok(there);
    }
    let path = led_to(path)?;
    let name = path.file_name().ok_or(io::ErrorKind::InvalidFilename)?;
    let directory = directory_of(&path);
    // Parent directories may not exist yet.
    let directory = if directory.exists() { directory.canonicalize()? } else { only_path(directory)? };
    Ok(directory.join(name))
}

/// Returns names beside a place: `table_new.csv`, `table_new_2.csv`, …
pub fn names_beside(place: &Path) -> impl Iterator<Item = PathBuf> {
    let stem = place.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let end = place.extension().map_or(String::new(), |end| format!(".{}", end.to_string_lossy()));
    let number = |k: u32| if k == 1 { String::new() } else { format!("_{k}") };
    (1..10_000).map(move |k| place.with_file_name(format!("{stem}_new{}{end}", number(k))))
}

/// Set when writers stop waiting for the readers of pipes.
static WAITS_NO_LONGER: AtomicBool = AtomicBool::new(false);
static WAITED_IN_VAIN: AtomicBool = AtomicBool::new(false);

/// Stops waiting for readers of pipes: from now on, writing to a pipe without a reader fails.
pub fn wait_no_longer() {
    WAITS_NO_LONGER.store(true, Ordering::Relaxed);
}

/// Returns whether something failed because of [`wait_no_longer`].
pub fn waited_in_vain() -> bool {
    WAITED_IN_VAIN.load(Ordering::Relaxed)
}

static READER_LEFT: AtomicBool = AtomicBool::new(false);

/// Returns whether writing to a pipe by [`Staged::onto`] failed because its reader had closed it. (Callers may replace
/// the error itself by another one.)
pub fn reader_left() -> bool {
    READER_LEFT.load(Ordering::Relaxed)
}

/// Opens a file that is not a regular file.
fn open_device(place: &Path, there: &Metadata) -> io::Result<File> {
    #[cfg(unix)]
    if std::os::unix::fs::FileTypeExt::is_fifo(&there.file_type()) {
        let opened = crate::pipe::open_to_write(place, &WAITS_NO_LONGER)?;
        return opened.ok_or_else(|| {
            WAITED_IN_VAIN.store(true, Ordering::Relaxed);
            io::Error::other("nobody reads the pipe")
        });
    }
    #[cfg(not(unix))]
    let _ = there;
    File::options().write(true).open(place)
}

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
struct Temporary(PathBuf);

impl Temporary {
    /// `make` creates the file or directory; it must fail if the name exists.
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

    /// Moves it into its place if no other program changed a guarded file there; else keeps it beside the place.
    fn persist(self, place: &Path) -> io::Result<()> {
        if guard::is_changed(place)? {
            return Err(self.keep_beside(place));
        }
        let written = self.0.metadata()?;
        self.take(place, || guard::note(place, Some(written)))
    }

    fn take(mut self, place: &Path, note: impl FnOnce()) -> io::Result<()> {
        let mut all = begun();
        std::fs::rename(&self.0, place)?;
        note();
        forget(&mut all, &self.0);
        self.0.clear();
        Ok(())
    }

    /// Moves it to a free name beside the place, because another program changed something in the place.
    fn keep_beside(self, place: &Path) -> io::Error {
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
                        Err(error) => error,
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
            // If it cannot be removed now (no file handle is left), [`give_up`] tries again at the end.
            match remove(&self.0) {
                Err(error) if error.kind() != io::ErrorKind::NotFound => {}
                _ => forget(&mut all, &self.0),
            }
        }
    }
}

fn forget(all: &mut Vec<PathBuf>, path: &Path) {
    all.retain(|other| other != path);
    // A library that is unloaded must not leave allocated memory.
    if all.is_empty() {
        *all = Vec::new();
    }
}

fn directory_of(place: &Path) -> &Path {
    place.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// A file that is written beside its place. [`Staged::persist`] moves it there; otherwise it is removed.
#[derive(Debug)]
pub struct Staged {
    file: File,
    /// Beside the place, or in any writable directory if the content goes to a device or a pipe later. `None`: the
    /// place itself is written.
    temporary: Option<Temporary>,
    /// The device or pipe, if `file` contains its content for now.
    device: Option<File>,
    place: PathBuf,
    begun: bool,
    failed: bool,
}

impl Staged {
    /// Creates a new file for `place`. It is beside the target of a link (which need not exist) and gets the
    /// permissions of an existing file. A place that is not a regular file (a device, a pipe) is written directly,
    /// never replaced. It waits for the reader of a pipe until [`wait_no_longer`].
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
        if let Some(there) = there.as_ref().filter(|there| !there.is_file()) {
            return Ok(staged(open_device(place, there)?, None, place.to_owned()));
        }
        let place = if there.is_some() { place.canonicalize()? } else { led_to(place)? };
        let (temporary, file) = Temporary::file(directory_of(&place))?;
        let staged = staged(file, Some(temporary), place);
        if let Some(there) = there {
            staged.file.set_permissions(there.permissions())?;
        }
        Ok(staged)
    }

    /// Writes directly to an open file, such as standard output. See [`reader_left`].
    pub fn onto(file: File) -> Staged {
        Staged { file, temporary: None, device: None, place: PathBuf::new(), begun: false, failed: false }
    }

    /// Lets `write` write the content, for functions that need a path and not a file.
    ///
    /// # Errors
    /// Those of `write`, or there is no space for content that goes to a device or a pipe.
    pub fn fill<T>(&mut self, write: impl FnOnce(&Path) -> io::Result<T>) -> io::Result<T> {
        if self.temporary.is_none() {
            self.detour()?;
        }
        let path = self.temporary.as_ref().map_or(&*self.place, |temporary| &temporary.0);
        write(path).inspect_err(|_| self.failed = true)
    }

    fn note(&self, error: &io::Error) {
        if self.place.as_os_str().is_empty() && error.kind() == io::ErrorKind::BrokenPipe {
            READER_LEFT.store(true, Ordering::Relaxed);
        }
    }

    /// Content for a device or a pipe is written to a temporary file first, because that can seek.
    fn detour(&mut self) -> io::Result<()> {
        let (temporary, file) = Temporary::file(&std::env::temp_dir())?;
        self.device = Some(std::mem::replace(&mut self.file, file));
        self.temporary = Some(temporary);
        Ok(())
    }

    /// Makes the written content survive a power failure.
    ///
    /// # Errors
    /// The disk reports an error.
    pub fn sync(&self) -> io::Result<()> {
        self.file.sync_all()
    }

    /// Moves the file into its place.
    ///
    /// # Errors
    /// The file cannot be moved there, or a part of it could not be written; the place is then unchanged. [`Changed`]:
    /// the file is beside its place, under another name.
    pub fn persist(mut self) -> io::Result<()> {
        if self.failed {
            return Err(io::Error::other("a part of it could not be written"));
        }
        if let Some(mut device) = self.device.take() {
            self.file.rewind()?;
            let written = io::copy(&mut self.file, &mut device).and_then(|_| device.flush());
            return written.inspect_err(|error| self.note(error));
        }
        let Staged { file, temporary, place, .. } = self;
        // The modification time is final once the file is closed.
        drop(file);
        temporary.map_or(Ok(()), |temporary| temporary.persist(&place))
    }
}

impl Write for Staged {
    /// After an error the file is lost. Further writing is ignored, so that writers that finish when they are dropped
    /// report no second error.
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if self.failed {
            return Ok(bytes.len());
        }
        self.begun = true;
        let written = self.file.write(bytes);
        written.inspect_err(|error| {
            self.note(error);
            self.failed = error.kind() != io::ErrorKind::Interrupted;
        })
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

/// A directory that is written beside its place. [`StagedDirectory::persist`] moves it there; otherwise it is removed.
#[derive(Debug)]
pub struct StagedDirectory(Temporary);

impl StagedDirectory {
    /// Creates a new, empty directory beside `place`.
    ///
    /// # Errors
    /// The directory cannot be created.
    pub fn beside(place: &Path) -> io::Result<StagedDirectory> {
        // `Trial/.` and `Trial/` have the parent of `Trial`.
        let place = led_to(place)?;
        let parent = directory_of(&place);
        let name = |process, attempt| parent.join(format!(".lemons-{process}-{attempt}.d"));
        Ok(StagedDirectory(Temporary::new(name, |path| std::fs::create_dir(path))?.0))
    }

    /// Returns its present path.
    pub fn path(&self) -> &Path {
        &self.0.0
    }

    /// Moves it into its place, which must not exist.
    ///
    /// # Errors
    /// The directory cannot be moved there. [`Changed`]: the place exists by now, and the directory is beside it.
    pub fn persist(self, place: &Path) -> io::Result<()> {
        let place = led_to(place)?;
        if place.symlink_metadata().is_ok() {
            return Err(self.0.keep_beside(&place));
        }
        self.0.take(&place, || guard::note_directory(&place))
    }

    /// Checks guarded files that would be replaced in `place`. If another program changed one, the directory stays
    /// beside the place.
    ///
    /// # Errors
    /// [`Changed`], with the path of that file.
    pub fn unless_changed(self, place: &Path, files: &[PathBuf]) -> Result<StagedDirectory, WriteError> {
        for file in files {
            if guard::is_changed(file).map_err(WriteError::at(file))? {
                return Err(WriteError::at(file)(
                    self.0.keep_beside(&led_to(place).map_err(WriteError::at(file))?),
                ));
            }
        }
        Ok(self)
    }
}

/// A directory for this process only, in the system's temporary directory. It is removed when dropped. If the process
/// is killed, the next process that creates such a directory removes it.
#[derive(Debug)]
pub struct Scratch {
    content: PathBuf,
    /// Locked while the process lives; released before the directory is removed.
    _lock: File,
    _temporary: Temporary,
}

const SCRATCH: &str = "lemons-scratch-";
const SCRATCH_LOCK: &str = "lock";

impl Scratch {
    /// Creates a new, empty directory.
    ///
    /// # Errors
    /// The directory cannot be created.
    pub fn new() -> io::Result<Scratch> {
        static CLEARED: Once = Once::new();
        CLEARED.call_once(clear_scratch);
        let directory = std::env::temp_dir();
        let name = |process, attempt| directory.join(format!("{SCRATCH}{process}-{attempt}"));
        loop {
            let (temporary, ()) = Temporary::new(name, private_directory)?;
            let path = temporary.0.join(SCRATCH_LOCK);
            let made = File::options().write(true).create_new(true).open(&path).inspect(|lock| {
                // If files cannot be locked, no process removes the directories of others.
                let _ = lock.lock();
            });
            let content = temporary.0.join("files");
            // Another process may have removed the directory before it was locked.
            match made.and_then(|lock| std::fs::create_dir(&content).map(|()| lock)) {
                Ok(lock) => return Ok(Scratch { content, _lock: lock, _temporary: temporary }),
                Err(error) if error.kind() == io::ErrorKind::NotFound => {}
                Err(error) => return Err(error),
            }
        }
    }

    /// Returns its path.
    pub fn path(&self) -> &Path {
        &self.content
    }
}

/// An empty file in the system's temporary directory for what only this process needs, to be written and read. It has no
/// name any more, so that nothing is left of it when it is closed.
///
/// # Errors
/// It cannot be made.
pub fn unnamed() -> io::Result<File> {
    let directory = std::env::temp_dir();
    let mut options = File::options();
    options.read(true).write(true).create_new(true);
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
    let name = |process, attempt| directory.join(format!(".lemons-{process}-{attempt}"));
    // The name goes with what is dropped here.
    let (_temporary, file) = Temporary::new(name, |path| options.open(path))?;
    Ok(file)
}

fn private_directory(path: &Path) -> io::Result<()> {
    #[cfg_attr(not(unix), allow(unused_mut))]
    let mut builder = std::fs::DirBuilder::new();
    #[cfg(unix)]
    std::os::unix::fs::DirBuilderExt::mode(&mut builder, 0o700);
    builder.create(path)
}

/// Removes the directories of killed processes. Those that cannot be read or removed belong to other users.
fn clear_scratch() {
    for entry in std::fs::read_dir(std::env::temp_dir()).into_iter().flatten().flatten() {
        let path = entry.path();
        let ours = entry.file_name().to_string_lossy().starts_with(SCRATCH);
        if !ours || !entry.file_type().is_ok_and(|kind| kind.is_dir()) {
            continue;
        }
        let lock = path.join(SCRATCH_LOCK);
        // Opening a pipe with that name would block.
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
/// The file cannot be removed, or it was changed ([`Changed`]).
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

    #[test]
    fn what_has_no_name_is_written_and_read() {
        use std::io::Read;
        let mut file = unnamed().unwrap();
        file.write_all(b"some numbers").unwrap();
        file.rewind().unwrap();
        let mut text = String::new();
        file.read_to_string(&mut text).unwrap();
        assert_eq!(text, "some numbers");
        #[cfg(unix)]
        assert_eq!(std::os::unix::fs::MetadataExt::nlink(&file.metadata().unwrap()), 0);
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
    fn links_to_what_is_not_there_lead_on_and_circles_are_an_error() {
        use std::os::unix::fs::symlink;
        let directory = TempDir::new().unwrap();
        let at = |name: &str| directory.path().join(name);
        symlink("file", at("link")).unwrap();
        symlink(at("link"), at("second")).unwrap();
        assert_eq!(only_path(&at("second")).unwrap(), only_path(&at("file")).unwrap());
        write_atomically(&at("second"), "new").unwrap();
        assert_eq!(std::fs::read_to_string(at("file")).unwrap(), "new");
        assert!(["link", "second"].iter().all(|link| at(link).symlink_metadata().unwrap().is_symlink()));
        symlink("there", at("back")).unwrap();
        symlink("back", at("there")).unwrap();
        assert!(only_path(&at("back")).is_err());
        let error = write_atomically(&at("back"), "x").unwrap_err().to_string();
        assert!(error.starts_with(&format!("{}: cannot be written: ", at("back").display())), "{error}");
        assert!(at("back").symlink_metadata().unwrap().is_symlink());
    }

    /// Guards are the process's: each test has its own directory.
    #[test]
    fn what_was_changed_since_it_was_looked_at_stays() {
        let directory = TempDir::new().unwrap();
        let at = |name: &str| directory.path().join(name);
        let guarded = |name: &str| {
            let before = at(name).metadata().map_or(Before::Nothing, Before::File);
            guard(only_path(&at(name)).unwrap(), before);
        };
        let placed = |name: &str| {
            let name = only_path(&at(name)).unwrap();
            placed().iter().any(|(place, _)| *place == name)
        };
        let read = |name: &str| std::fs::read_to_string(at(name)).unwrap();
        std::fs::write(at("a.txt"), "old").unwrap();
        ["a.txt", "b.txt", "c.txt"].into_iter().for_each(guarded);
        // Of what this process itself puts there it goes on.
        for text in ["new", "newer"] {
            write_atomically(&at("a.txt"), text).unwrap();
        }
        assert!(placed("a.txt") && !placed("b.txt"));
        std::fs::write(at("a.txt"), "edited").unwrap();
        std::fs::write(at("b.txt"), "appeared").unwrap();
        for (name, there) in [("a.txt", "edited"), ("b.txt", "appeared")] {
            for kept in ["_new", "_new_2"] {
                let kept = name.replace('.', &format!("{kept}."));
                let error = write_atomically(&at(name), "mine").unwrap_err().to_string();
                assert!(error.contains("another program changed it") && error.contains(&kept), "{error}");
                assert_eq!((read(name).as_str(), read(&kept).as_str()), (there, "mine"));
            }
            assert!(remove_file(&at(name)).is_err() && at(name).exists());
        }
        assert!(!placed("b.txt"));
        // What went away took nothing with it.
        std::fs::remove_file(at("a.txt")).unwrap();
        write_atomically(&at("a.txt"), "again").unwrap();
        // A change of several is undone, and is nobody's then.
        let changes = [Change::Write(at("c.txt"), "new".into()), Change::Write(at("b.txt"), "new".into())];
        assert!(change_all(&changes).is_err());
        assert!(!at("c.txt").exists() && !placed("c.txt") && read("b.txt") == "appeared");
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
