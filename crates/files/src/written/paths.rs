//! Paths: where links lead, and free names.

use std::io;
use std::path::{Path, PathBuf};

/// Returns the target of symbolic links, which need not exist.
pub(super) fn led_to(path: &Path) -> io::Result<PathBuf> {
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

pub(super) fn directory_of(place: &Path) -> &Path {
    place.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."))
}
