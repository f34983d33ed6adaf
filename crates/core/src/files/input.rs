//! Reads regular files, up to a limit. Opening anything else could wait for ever: a pipe that nobody writes to, a link to
//! an endless device.

use std::fs::{File, FileType, Metadata};
use std::io::{self, ErrorKind, Read};
use std::path::Path;

/// \[byte\] The largest file of a Trial: ten times that of 100 000 agents.
pub const LARGEST_TRIAL_FILE: u64 = 1_000_000_000;
/// \[byte\] The largest settings file: decision.toml, sweep.toml, a population.
pub const LARGEST_SETTINGS: u64 = 64_000_000;
/// \[byte\] The largest drive file, table of points or table of measured trajectories.
pub const LARGEST_DRIVE: u64 = 500_000_000;
/// \[byte\] The largest binary or FMU that is read completely into memory.
pub const LARGEST_BINARY: u64 = 4_000_000_000;

/// Opens a regular file without waiting, and refuses anything else.
///
/// # Errors
/// The file cannot be opened, or it is not a regular file.
pub fn open(path: &Path) -> io::Result<File> {
    let mut options = File::options();
    options.read(true);
    // Opening a pipe would wait for a writer. A terminal must not become the controlling terminal of the process.
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::custom_flags(&mut options, libc::O_NONBLOCK | libc::O_NOCTTY);
    // Opening a device can have side effects.
    check_regular(&path.metadata()?)?;
    let file = options.open(path)?;
    // Meanwhile another file may have this name.
    check_regular(&file.metadata()?)?;
    Ok(file)
}

/// Refuses anything but a regular file.
pub(crate) fn check_regular(there: &Metadata) -> io::Result<()> {
    if there.is_dir() {
        return Err(ErrorKind::IsADirectory.into());
    }
    if !there.is_file() {
        return Err(io::Error::other(format!("it is {}, not a regular file", what(there.file_type()))));
    }
    Ok(())
}

#[cfg(unix)]
fn what(kind: FileType) -> &'static str {
    use std::os::unix::fs::FileTypeExt;
    match kind {
        kind if kind.is_fifo() => "a pipe",
        kind if kind.is_socket() => "a socket",
        _ => "a device",
    }
}

#[cfg(not(unix))]
fn what(_: FileType) -> &'static str {
    "a pipe or a device"
}

/// Opens a regular file as [`open`] does, to read at most `largest` bytes.
///
/// # Errors
/// Those of [`open`], or the file is larger.
pub fn open_bounded(path: &Path, largest: u64) -> io::Result<Bounded<File>> {
    let file = open(path)?;
    if file.metadata()?.len() > largest {
        return Err(too_large(largest));
    }
    // The file may grow.
    Ok(Bounded::new(file, largest))
}

/// Returns the content of a regular file of at most `largest` bytes.
///
/// # Errors
/// The file cannot be read, is not a regular file, or is larger.
pub fn read(path: &Path, largest: u64) -> io::Result<Vec<u8>> {
    let mut file = open_bounded(path, largest)?;
    let mut bytes = Vec::new();
    let size = file.inner.get_ref().metadata()?.len();
    bytes.try_reserve_exact(usize::try_from(size).unwrap_or(usize::MAX))?;
    file.read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// Returns the UTF-8 text of a file; else as [`read`].
///
/// # Errors
/// Those of [`read`], or the file is not UTF-8 text.
pub fn read_text(path: &Path, largest: u64) -> io::Result<String> {
    text(read(path, largest)?)
}

/// Returns the text of a file.
pub(crate) fn text(bytes: Vec<u8>) -> io::Result<String> {
    String::from_utf8(bytes).map_err(|_| io::Error::new(ErrorKind::InvalidData, "it is not UTF-8 text"))
}

pub(crate) fn too_large(largest: u64) -> io::Error {
    let message = format!("it is larger than {} MB, the limit", largest as f64 / 1e6);
    io::Error::new(ErrorKind::FileTooLarge, message)
}

/// Reads up to a limit. If there are more bytes after that, it returns an error, not the end of the file.
#[derive(Debug)]
pub struct Bounded<R> {
    inner: io::Take<R>,
    largest: u64,
}

impl<R: Read> Bounded<R> {
    /// Limits reading from `inner` to `largest` bytes.
    pub fn new(inner: R, largest: u64) -> Bounded<R> {
        Bounded { inner: inner.take(largest.saturating_add(1)), largest }
    }
}

impl<R: Read> Read for Bounded<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let read = self.inner.read(buffer)?;
        // One byte more than may be read distinguishes a file that is too large from one that just fits.
        if self.inner.limit() == 0 { Err(too_large(self.largest)) } else { Ok(read) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_just_fits_is_read_and_a_byte_more_is_refused() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("a");
        std::fs::write(&path, [7; 10]).unwrap();
        assert_eq!(read(&path, 10).unwrap(), [7; 10]);
        let message = "it is larger than 0.000009 MB, the limit";
        assert_eq!(read(&path, 9).unwrap_err().to_string(), message);
        let mut growing = Bounded::new(&[7; 10][..], 9);
        assert_eq!(growing.read_to_end(&mut Vec::new()).unwrap_err().to_string(), message);
        assert_eq!(read(directory.path(), 9).unwrap_err().kind(), ErrorKind::IsADirectory);
        assert_eq!(read(&directory.path().join("b"), 9).unwrap_err().kind(), ErrorKind::NotFound);
    }

    #[cfg(unix)]
    #[test]
    fn pipes_and_devices_are_refused_without_waiting() {
        let directory = tempfile::tempdir().unwrap();
        let pipe = directory.path().join("pipe");
        assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
        let link = directory.path().join("link");
        std::os::unix::fs::symlink("/dev/zero", &link).unwrap();
        for (path, what) in [(pipe, "a pipe"), (link, "a device")] {
            let message = format!("it is {what}, not a regular file");
            assert_eq!(read(&path, 9).unwrap_err().to_string(), message);
            assert_eq!(crate::files::Staged::beside(&path).unwrap_err().to_string(), message);
        }
    }
}
