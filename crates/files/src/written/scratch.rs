//! Directories and files that only this process needs.

use super::temporary::Temporary;
use std::fs::{File, TryLockError};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Once;

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
            let path = temporary.path().join(SCRATCH_LOCK);
            let made = File::options().write(true).create_new(true).open(&path).inspect(|lock| {
                // If files cannot be locked, no process removes the directories of others.
                let _ = lock.lock();
            });
            let content = temporary.path().join("files");
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

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::{Read, Seek, Write};

    #[test]
    fn what_has_no_name_is_written_and_read() {
        let mut file = unnamed().unwrap();
        file.write_all(b"some numbers").unwrap();
        file.rewind().unwrap();
        let mut text = String::new();
        file.read_to_string(&mut text).unwrap();
        assert_eq!(text, "some numbers");
        #[cfg(unix)]
        assert_eq!(std::os::unix::fs::MetadataExt::nlink(&file.metadata().unwrap()), 0);
    }
}
