//! The resources of an FMU: packed Trial directories, and the URI of their location.

use crate::setup;
use lemons_core::files::input;
use lemons_core::files::source::{FileSource, LocalFiles};
use lemons_core::trial::{DriveTable, FileNames, Problems, Trial};
use lemons_fmi::location::{Location, LocationError};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use thiserror::Error;

/// File with the names of the packed Trials in order, one per line; the first is the default.
pub const TRIALS_FILE: &str = "trials.txt";

/// Returns whether a Trial with this name can be packed and chosen: the name must be a plain directory name on every
/// platform, on one line, and different from [`TRIALS_FILE`].
pub fn can_be_packed(name: &str) -> bool {
    !name.trim().is_empty()
        && name != "."
        && name != ".."
        && !name.contains(|c: char| c.is_control() || ['/', '\\', ':'].contains(&c))
        && !name.eq_ignore_ascii_case(TRIALS_FILE)
}

/// Why resources cannot be used.
#[derive(Debug, Error)]
#[allow(missing_docs)] // the messages say it
pub enum ResourcesError {
    #[error(transparent)]
    Location(#[from] LocationError),
    #[error("the resource location {uri:?} is {path:?}, which contains no directory with a Trial")]
    NoTrial { uri: String, path: PathBuf },
    #[error("cannot read {path:?}: {error}")]
    Read { path: PathBuf, error: std::io::Error },
    #[error("{path:?} line {line}: {name:?} is not a plain directory name")]
    Name { path: PathBuf, line: usize, name: String },
    #[error("the Trial {name:?} is broken:\n{problems}")]
    Broken { name: String, problems: Problems },
}

/// The Trials of a model, by name.
#[derive(Debug, Clone)]
pub struct Resources {
    place: Place,
    names: Vec<String>,
}

/// Where Trials are.
#[derive(Debug, Clone)]
enum Place {
    /// Packed in this directory of an FMU.
    Directory(&'static (dyn FileSource + Sync), PathBuf),
    /// One, in memory, with its drive.
    Memory(Arc<(Trial, DriveTable)>),
}

impl Resources {
    /// Opens the resources at a location as importers give it: `file:///…`, `file:/…`, `file://localhost/…` or a plain path;
    /// percent-encoded or not; with or without a trailing slash or the last part, `resources`.
    ///
    /// # Errors
    /// There is no location, it is not a file URI, there is no directory at this place, or it contains no Trial.
    pub fn at(location: Location<'_>) -> Result<Resources, ResourcesError> {
        let (files, candidates): (&'static (dyn FileSource + Sync), _) = match location {
            Location::Files(files) => (files, vec![PathBuf::new()]),
            _ => (&LocalFiles, location.directories()?),
        };
        for directory in &candidates {
            let names = names_in(files, directory)?;
            if !names.is_empty() {
                return Ok(Resources { place: Place::Directory(files, directory.clone()), names });
            }
        }
        Err(ResourcesError::NoTrial { uri: location.text().to_owned(), path: candidates[0].clone() })
    }

    /// Holds a Trial that is in memory already, with its drive.
    pub fn of_one(trial: Trial, drive: DriveTable) -> Resources {
        let names = vec![trial.name.clone()];
        Resources { place: Place::Memory(Arc::new((trial, drive))), names }
    }

    /// Returns the names of the packed Trials, the default one first; at least one.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// Returns the name of the default Trial.
    pub fn first(&self) -> &str {
        &self.names[0]
    }

    /// Reads a packed Trial; also returns warnings.
    ///
    /// # Errors
    /// All errors in its files.
    pub fn load(&self, name: &str) -> Result<(Trial, Vec<String>), ResourcesError> {
        let (files, directory) = match &self.place {
            Place::Memory(own) => return Ok((own.0.clone(), Vec::new())),
            Place::Directory(files, directory) => (*files, directory),
        };
        let (mut trial, warnings) = setup::read_from(files, &directory.join(name), &FileNames::default())
            .map_err(|problems| ResourcesError::Broken { name: name.to_owned(), problems })?;
        name.clone_into(&mut trial.name);
        Ok((trial, warnings.iter().map(|problem| format!("{problem:#}")).collect()))
    }

    /// Reads the drive of a packed Trial; empty if it has none.
    ///
    /// # Errors
    /// All errors in its file.
    pub fn drive(&self, trial: &Trial) -> Result<DriveTable, ResourcesError> {
        let files = match &self.place {
            Place::Memory(own) => return Ok(own.1.clone()),
            Place::Directory(files, _) => *files,
        };
        let broken = |problems| ResourcesError::Broken { name: trial.name.clone(), problems };
        DriveTable::own(files, trial).map_err(broken)
    }
}

/// Returns the names of the Trials in a directory: those in [`TRIALS_FILE`], or else all, sorted by name.
fn names_in(files: &dyn FileSource, directory: &Path) -> Result<Vec<String>, ResourcesError> {
    let list = directory.join(TRIALS_FILE);
    match files.read_text(&list, input::LARGEST_SETTINGS) {
        Ok(text) => {
            let lines = text.lines().zip(1..).filter(|(name, _)| !name.trim().is_empty());
            let name = |(name, line): (&str, usize)| match can_be_packed(name) {
                true => Ok(name.to_owned()),
                false => Err(ResourcesError::Name { path: list.clone(), line, name: name.to_owned() }),
            };
            return lines.map(name).collect();
        }
        Err(error) if matches!(error.kind(), ErrorKind::NotFound | ErrorKind::NotADirectory) => {}
        Err(error) => return Err(ResourcesError::Read { path: list, error }),
    }
    let Ok(entries) = std::fs::read_dir(directory) else { return Ok(Vec::new()) };
    let mut names: Vec<String> = entries
        .filter_map(Result::ok)
        .filter(|entry| entry.path().join("Parameters.xml").exists())
        .filter_map(|entry| entry.file_name().into_string().ok())
        .collect();
    names.sort();
    Ok(names)
}
