//! Writing to a named pipe.

use std::fs::File;
use std::io;
use std::os::fd::OwnedFd;
use std::os::unix::fs::OpenOptionsExt;
use std::os::unix::net::UnixStream;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// Time between two checks for a reader.
const LOOK: Duration = Duration::from_millis(10);

/// Opens a named pipe as soon as a reader has opened it. Returns `None` if there is no reader when `stop` is set.
///
/// # Errors
/// The pipe cannot be opened.
pub fn open_to_write(path: &Path, stop: &AtomicBool) -> io::Result<Option<File>> {
    loop {
        // A normal open would block and could not check `stop`.
        match File::options().write(true).custom_flags(libc::O_NONBLOCK).open(path) {
            Ok(pipe) => return waiting(pipe).map(Some),
            Err(error) if error.raw_os_error() == Some(libc::ENXIO) => {}
            Err(error) => return Err(error),
        }
        if stop.load(Ordering::Relaxed) {
            return Ok(None);
        }
        std::thread::sleep(LOOK);
    }
}

/// The same pipe, but writing blocks until the reader is ready.
fn waiting(pipe: File) -> io::Result<File> {
    // The standard library has this call for sockets only, the system for every file descriptor.
    let same = UnixStream::from(OwnedFd::from(pipe));
    same.set_nonblocking(false)?;
    Ok(File::from(OwnedFd::from(same)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::{Read, Write};

    fn pipe(directory: &Path) -> std::path::PathBuf {
        let path = directory.join("pipe");
        assert!(std::process::Command::new("mkfifo").arg(&path).status().unwrap().success());
        path
    }

    #[test]
    fn nobody_reads_and_the_wait_can_be_ended() {
        let directory = tempfile::TempDir::new().unwrap();
        let path = pipe(directory.path());
        assert!(open_to_write(&path, &AtomicBool::new(true)).unwrap().is_none());
        let stop = AtomicBool::new(false);
        std::thread::scope(|scope| {
            let waits = scope.spawn(|| open_to_write(&path, &stop).unwrap().is_none());
            stop.store(true, Ordering::Relaxed);
            assert!(waits.join().unwrap());
        });
    }

    /// Without waiting, what does not go into the pipe at once is an error.
    #[test]
    fn more_than_a_pipe_holds_goes_through() {
        let directory = tempfile::TempDir::new().unwrap();
        let path = pipe(directory.path());
        let reader = std::thread::spawn({
            let path = path.clone();
            move || {
                let (mut pipe, mut bytes) = (File::open(path).unwrap(), Vec::new());
                std::thread::sleep(10 * LOOK);
                pipe.read_to_end(&mut bytes).unwrap();
                bytes
            }
        });
        let mut opened = open_to_write(&path, &AtomicBool::new(false)).unwrap().unwrap();
        let sent = vec![7; 3_000_000];
        opened.write_all(&sent).unwrap();
        drop(opened);
        assert!(reader.join().unwrap() == sent);
    }
}
