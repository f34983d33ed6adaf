//! Files and directories that are written beside their place, then moved there.

use super::WriteError;
use super::guard;
use super::paths::{directory_of, led_to};
use super::temporary::Temporary;
use std::fs::{File, Metadata};
use std::io::{self, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

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
        Staged::made(place, Temporary::file)
    }

    /// As [`Staged::beside`], but the temporary file has this name. It must not exist: only one process at a time may
    /// write a file of this name.
    ///
    /// # Errors
    /// As [`Staged::beside`], or a file of this name exists.
    pub fn beside_as(place: &Path, name: &str) -> io::Result<Staged> {
        Staged::made(place, |directory| Temporary::named(directory.join(name)))
    }

    fn made(place: &Path, make: impl FnOnce(&Path) -> io::Result<(Temporary, File)>) -> io::Result<Staged> {
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
        let (temporary, file) = make(directory_of(&place))?;
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
        let path = self.temporary.as_ref().map_or(&*self.place, Temporary::path);
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
    /// The file cannot be moved there, or a part of it could not be written; the place is then unchanged. [`Changed`](crate::Changed):
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
        self.0.path()
    }

    /// Moves it into its place, which must not exist.
    ///
    /// # Errors
    /// The directory cannot be moved there. [`Changed`](crate::Changed): the place exists by now, and the directory is beside it.
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
    /// [`Changed`](crate::Changed), with the path of that file.
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
