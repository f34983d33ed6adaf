//! The files of the directory `resources`: those that were built in, or else those that the importer has.

use lemons_core::files::source::FileSource;
use std::io::{Error, ErrorKind, Result};
use std::path::Path;

// `BUILT_IN`: paths and contents.
include!(concat!(env!("OUT_DIR"), "/built_in.rs"));

/// The files.
pub const FILES: &(dyn FileSource + Sync) = &Files;

#[derive(Debug)]
struct Files;

impl FileSource for Files {
    fn read(&self, path: &Path, largest: u64) -> Result<Vec<u8>> {
        let content = read(&text(path))?;
        if content.len() as u64 > largest {
            let message = format!("it is larger than {} MB, the limit", largest as f64 / 1e6);
            return Err(Error::new(ErrorKind::FileTooLarge, message));
        }
        Ok(content)
    }

    fn lacks(&self, path: &Path) -> bool {
        read(&text(path)).is_err()
    }
}

/// A path with forward slashes, without `.` in between.
fn text(path: &Path) -> String {
    let parts = path.components().filter_map(|part| match part {
        std::path::Component::CurDir => None,
        other => other.as_os_str().to_str(),
    });
    parts.collect::<Vec<_>>().join("/")
}

#[cfg(built_in)]
fn read(path: &str) -> Result<Vec<u8>> {
    let found = BUILT_IN.iter().find(|(name, _)| *name == path);
    Ok(found.ok_or(ErrorKind::NotFound)?.1.to_vec())
}

/// The importer does not say whether a file is missing or cannot be read.
#[cfg(not(built_in))]
fn read(path: &str) -> Result<Vec<u8>> {
    crate::fmi::fmi3::resource_dir_callbacks::read_file(path)
        .map_err(|message| Error::new(ErrorKind::NotFound, message))
}
