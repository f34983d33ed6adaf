//! The resources of an FMU: packed Trial directories, and the URI that leads there.

use crate::trial::{Problems, Trial};
use percent_encoding::percent_decode_str;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Names the packed Trials in their order, one in each line; the first is the default.
pub const TRIALS_FILE: &str = "trials.txt";

/// Why resources cannot be used.
#[derive(Debug, Error)]
#[allow(missing_docs)] // the messages say it
pub enum ResourcesError {
    #[error("no resource location was given")]
    Missing,
    #[error("the resource location {0:?} is no file URI and no path")]
    Uri(String),
    #[error("the resource location {uri:?} leads to {path:?}, where there is no directory with a Trial")]
    NoTrial { uri: String, path: PathBuf },
    #[error("cannot read {path:?}: {error}")]
    Read { path: PathBuf, error: std::io::Error },
    #[error("{path:?} line {line}: {name:?} is no plain directory name")]
    Name { path: PathBuf, line: usize, name: String },
    #[error("the Trial {name:?} is broken:\n{problems}")]
    Broken { name: String, problems: Problems },
}

/// Where the packed Trials lie.
#[derive(Debug, Clone)]
pub struct Resources {
    directory: PathBuf,
    names: Vec<String>,
}

impl Resources {
    /// From a resource URI as importers give it: `file:///…`, `file:/…`, `file://localhost/…` or a bare
    /// path; percent-encoded or not; with or without a trailing slash or the last part, `resources`.
    ///
    /// # Errors
    /// No location, an URI of another kind, no directory there, no Trial in it.
    pub fn from_uri(uri: &str) -> Result<Resources, ResourcesError> {
        if uri.trim().is_empty() {
            return Err(ResourcesError::Missing);
        }
        let candidates = paths_of(uri)?;
        for path in &candidates {
            for directory in [path.clone(), path.join("resources")] {
                let names = names_in(&directory)?;
                if !names.is_empty() {
                    return Ok(Resources { directory, names });
                }
            }
        }
        Err(ResourcesError::NoTrial { uri: uri.to_owned(), path: candidates[0].clone() })
    }

    /// Names of the packed Trials, the default one first; at least one.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// The default Trial.
    pub fn first(&self) -> &str {
        &self.names[0]
    }

    /// Reads a packed Trial, with warnings.
    ///
    /// # Errors
    /// All that is wrong with it.
    pub fn load(&self, name: &str) -> Result<(Trial, Vec<String>), ResourcesError> {
        let (mut trial, warnings) = Trial::read(&self.directory.join(name))
            .map_err(|problems| ResourcesError::Broken { name: name.to_owned(), problems })?;
        name.clone_into(&mut trial.name);
        Ok((trial, warnings.iter().map(ToString::to_string).collect()))
    }
}

/// The paths that a URI may mean, most likely first.
fn paths_of(uri: &str) -> Result<Vec<PathBuf>, ResourcesError> {
    let uri = uri.trim();
    let scheme = uri.get(..5).filter(|scheme| scheme.eq_ignore_ascii_case("file:"));
    let path = match scheme {
        Some(_) => {
            let rest = &uri[5..];
            match rest.strip_prefix("//") {
                // file://host/path; an empty host is this machine.
                Some(host_and_path) => match host_and_path.find('/') {
                    Some(0) => host_and_path,
                    Some(slash) if host_and_path[..slash].eq_ignore_ascii_case("localhost") => {
                        &host_and_path[slash..]
                    }
                    _ => return Err(ResourcesError::Uri(uri.to_owned())),
                },
                None => rest,
            }
        }
        // A scheme of one letter is a drive.
        None if uri.find("://").is_some_and(|colon| colon > 1) => {
            return Err(ResourcesError::Uri(uri.to_owned()));
        }
        None => uri,
    };
    let path = if cfg!(windows) { path.strip_prefix('/').unwrap_or(path) } else { path };
    let decoded = percent_decode_str(path).decode_utf8_lossy().into_owned();
    // Some importers do not encode: there a percent sign is itself.
    let mut paths = vec![PathBuf::from(&decoded)];
    if decoded != path {
        paths.push(PathBuf::from(path));
    }
    Ok(paths)
}

/// The Trials in a directory: those that [`TRIALS_FILE`] names, else all, by name.
fn names_in(directory: &Path) -> Result<Vec<String>, ResourcesError> {
    let list = directory.join(TRIALS_FILE);
    match std::fs::read_to_string(&list) {
        Ok(text) => {
            let lines = text.lines().enumerate().filter(|(_, name)| !name.trim().is_empty());
            return lines
                .map(|(line, name)| {
                    if name.contains(['/', '\\']) || name == ".." || name == "." {
                        return Err(ResourcesError::Name {
                            path: list.clone(),
                            line: line + 1,
                            name: name.to_owned(),
                        });
                    }
                    Ok(name.to_owned())
                })
                .collect();
        }
        Err(error)
            if error.kind() == std::io::ErrorKind::NotFound
                || error.kind() == std::io::ErrorKind::NotADirectory => {}
        Err(error) => return Err(ResourcesError::Read { path: list, error }),
    }
    let Ok(entries) = std::fs::read_dir(directory) else { return Ok(Vec::new()) };
    let mut names: Vec<String> = entries
        .filter_map(Result::ok)
        .filter(|entry| entry.path().join("Parameters.xml").is_file())
        .filter_map(|entry| entry.file_name().into_string().ok())
        .collect();
    names.sort();
    Ok(names)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn first(uri: &str) -> String {
        paths_of(uri).unwrap()[0].to_str().unwrap().to_owned()
    }

    #[test]
    #[cfg(unix)]
    fn uris_are_read_liberally() {
        assert_eq!(first("file:///tmp/sp%20ace/resources"), "/tmp/sp ace/resources");
        assert_eq!(first("file:/tmp/x"), "/tmp/x");
        assert_eq!(first("file:////tmp/x"), "//tmp/x");
        assert_eq!(first("file://localhost/tmp/x"), "/tmp/x");
        assert_eq!(first("FILE:///tmp/x"), "/tmp/x");
        assert_eq!(first("/tmp/a b/ü"), "/tmp/a b/ü");
        assert_eq!(first("file:///tmp/%C3%BC"), "/tmp/ü");
        // A percent sign that was not encoded.
        assert_eq!(paths_of("file:///tmp/a%20b").unwrap()[1], Path::new("/tmp/a%20b"));
        assert!(paths_of("http://host/x").is_err());
        assert!(paths_of("file://elsewhere/x").is_err());
        assert!(matches!(Resources::from_uri(" "), Err(ResourcesError::Missing)));
    }
}
