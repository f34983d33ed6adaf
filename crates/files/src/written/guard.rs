//! Guarded places: this process replaces them only if no other program has changed them. And a list of what it wrote
//! there.
//!
//! Nothing is guarded by default: the library of an FMU never guards a file.

use super::paths::only_path;
use std::collections::BTreeMap;
use std::fs::Metadata;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// The content of a place when the process decided to write there.
#[derive(Debug, Clone)]
pub enum Before {
    /// Unknown: the place may be replaced in any case.
    Anything,
    /// There was no file.
    Nothing,
    /// This file.
    File(Metadata),
}

struct Guard {
    before: Before,
    put: Option<Put>,
}

struct Put {
    there: Metadata,
    /// Number in the order of writing.
    order: usize,
}

/// Another program changed a file after this process decided to replace it.
#[derive(Debug, thiserror::Error)]
#[error("another program changed it while this command ran, so it was not replaced{}", .kept.as_deref().map(said).unwrap_or_default())]
pub struct Changed {
    /// Path of the new content.
    pub kept: Option<PathBuf>,
}

fn said(kept: &Path) -> String {
    let here = std::env::current_dir().and_then(|here| here.canonicalize()).ok();
    let short = here.as_deref().and_then(|here| kept.strip_prefix(here).ok());
    format!("; the new content is in {}", short.unwrap_or(kept).display())
}

static GUARDED: Mutex<BTreeMap<PathBuf, Guard>> = Mutex::new(BTreeMap::new());
static PUT: AtomicUsize = AtomicUsize::new(0);

fn guarded() -> MutexGuard<'static, BTreeMap<PathBuf, Guard>> {
    GUARDED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// From now on, this process replaces a file (given by its [`only_path`]) only if it is unchanged.
pub fn guard(place: PathBuf, before: Before) {
    guarded().insert(place, Guard { before, put: None });
}

/// Returns the guarded places that were written and the metadata of their files, in the order of writing.
pub fn placed() -> Vec<(PathBuf, Metadata)> {
    let guarded = guarded();
    let mut all: Vec<_> =
        guarded.iter().filter_map(|(place, guard)| Some((place, guard.put.as_ref()?))).collect();
    all.sort_by_key(|(_, put)| put.order);
    all.into_iter().map(|(place, put)| (place.clone(), put.there.clone())).collect()
}

impl Guard {
    fn note(&mut self, put: Option<Metadata>, there: impl FnOnce() -> Before) {
        if !matches!(self.before, Before::Anything) {
            self.before = put.clone().map_or_else(there, Before::File);
        }
        self.put = put.map(|there| Put { there, order: PUT.fetch_add(1, Ordering::Relaxed) });
    }
}

/// Returns the path under which a place is guarded.
fn name_of(place: &Path) -> io::Result<Option<PathBuf>> {
    if guarded().is_empty() {
        return Ok(None);
    }
    let name = only_path(place)?;
    Ok(guarded().contains_key(&name).then_some(name))
}

/// Returns whether another program changed a guarded file. A change between this check and the replacement is not
/// detected.
pub(super) fn is_changed(place: &Path) -> io::Result<bool> {
    let Some(name) = name_of(place)? else { return Ok(false) };
    let there = match name.symlink_metadata() {
        Ok(there) => there,
        // The file is gone: replacing it loses nothing.
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(false),
        Err(error) => return Err(error),
    };
    Ok(match guarded().get(&name).map(|guard| &guard.before) {
        None | Some(Before::Anything) => false,
        Some(Before::Nothing) => true,
        Some(Before::File(before)) => !same(before, &there),
    })
}

fn same(one: &Metadata, other: &Metadata) -> bool {
    #[cfg(unix)]
    {
        use std::os::unix::fs::MetadataExt;
        if (one.dev(), one.ino()) != (other.dev(), other.ino()) {
            return false;
        }
    }
    let seen = |file: &Metadata| (file.file_type(), file.len(), file.modified().ok());
    seen(one) == seen(other)
}

/// Remembers what this process wrote to a place; `None`: the previous content was restored, or the file was removed.
pub(super) fn note(place: &Path, put: Option<Metadata>) {
    // The file was just written, so its path can be resolved.
    let Ok(Some(name)) = name_of(place) else { return };
    if let Some(guard) = guarded().get_mut(&name) {
        guard.note(put, || name.symlink_metadata().map_or(Before::Nothing, Before::File));
    }
}

/// Calls [`note`] for all files of a directory that was put into its place.
pub(super) fn note_directory(place: &Path) {
    let Ok(directory) = place.canonicalize() else { return };
    for (file, guard) in guarded().iter_mut().filter(|(file, _)| file.starts_with(&directory)) {
        guard.note(file.symlink_metadata().ok(), || Before::Nothing);
    }
}
