//! Where the files of a Trial or of an FMU are read from: the disk, or memory (a page has no disk).

use crate::files::input;
use std::collections::BTreeMap;
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

/// Files, by their paths.
pub trait FileSource: std::fmt::Debug {
    /// Returns the content of a file of at most `largest` bytes.
    ///
    /// # Errors
    /// The file cannot be read, is not a regular file, or is larger.
    fn read(&self, path: &Path, largest: u64) -> io::Result<Vec<u8>>;

    /// Returns the UTF-8 text of a file; else as [`FileSource::read`].
    ///
    /// # Errors
    /// Those of [`FileSource::read`], or the file is not UTF-8 text.
    fn read_text(&self, path: &Path, largest: u64) -> io::Result<String> {
        input::text(self.read(path, largest)?)
    }

    /// Returns whether there is surely nothing at a path.
    fn lacks(&self, path: &Path) -> bool;
}

/// The files of this machine, read by [`input::read`].
#[derive(Debug, Clone, Copy)]
pub struct LocalFiles;

impl FileSource for LocalFiles {
    fn read(&self, path: &Path, largest: u64) -> io::Result<Vec<u8>> {
        input::read(path, largest)
    }

    fn lacks(&self, path: &Path) -> bool {
        let nothing = [ErrorKind::NotFound, ErrorKind::NotADirectory];
        matches!(path.symlink_metadata(), Err(error) if nothing.contains(&error.kind()))
    }
}

/// Files in memory.
#[derive(Debug, Clone, Default)]
pub struct Memory(BTreeMap<PathBuf, Vec<u8>>);

impl Memory {
    /// Adds a file, or replaces it. `./` in a path means nothing.
    pub fn put(&mut self, path: &Path, content: Vec<u8>) {
        self.0.insert(tidy(path), content);
    }

    /// Returns the paths of the files, ascending.
    pub fn paths(&self) -> impl Iterator<Item = &Path> {
        self.0.keys().map(PathBuf::as_path)
    }
}

impl FileSource for Memory {
    fn read(&self, path: &Path, largest: u64) -> io::Result<Vec<u8>> {
        let content = self.0.get(&tidy(path)).ok_or(ErrorKind::NotFound)?;
        if content.len() as u64 > largest { Err(input::too_large(largest)) } else { Ok(content.clone()) }
    }

    fn lacks(&self, path: &Path) -> bool {
        !self.0.contains_key(&tidy(path))
    }
}

/// Removes `.` in between.
fn tidy(path: &Path) -> PathBuf {
    path.components().filter(|part| *part != std::path::Component::CurDir).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn memory_is_read_as_the_disk_is() {
        let mut memory = Memory::default();
        memory.put(Path::new("./a/b.xml"), vec![7; 10]);
        let directory = tempfile::tempdir().unwrap();
        std::fs::create_dir(directory.path().join("a")).unwrap();
        std::fs::write(directory.path().join("a/b.xml"), [7; 10]).unwrap();
        for (source, root) in [(&memory as &dyn FileSource, Path::new("")), (&LocalFiles, directory.path())] {
            assert_eq!(source.read(&root.join("a/./b.xml"), 10).unwrap(), [7; 10]);
            let message = source.read(&root.join("a/b.xml"), 9).unwrap_err().to_string();
            assert_eq!(message, "it is larger than 0.000009 MB, the limit");
            assert_eq!(source.read(&root.join("a/c.xml"), 9).unwrap_err().kind(), ErrorKind::NotFound);
            assert!(source.lacks(&root.join("c")) && !source.lacks(&root.join("a/b.xml")));
        }
    }
}
