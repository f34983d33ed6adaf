//! The directories that a resource location may mean.

use lemons_core::files::source::FileSource;
use percent_encoding::percent_decode_str;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Why a resource location cannot be used.
#[derive(Debug, Error)]
#[allow(missing_docs)] // the messages say it
pub enum LocationError {
    #[error("no resource location was given")]
    Missing,
    #[error("the resource location {0:?} is neither a file URI nor a path")]
    Uri(String),
}

/// A resource location, exactly as the importer gives it.
#[derive(Debug, Clone, Copy)]
pub enum Location<'a> {
    /// FMI 2.0: a URI.
    Uri(&'a str),
    /// FMI 3.0: a path.
    Path(&'a str),
    /// FMI 3.0 as a WebAssembly component, which has no disk: files, by paths relative to `resources`.
    Files(&'static (dyn FileSource + Sync)),
}

impl<'a> Location<'a> {
    /// Returns the text.
    pub fn text(self) -> &'a str {
        match self {
            Location::Uri(text) | Location::Path(text) => text,
            Location::Files(_) => "resources",
        }
    }

    /// Returns the directories that it may mean, most likely first; at least one. A path is taken as it is before it is
    /// read as a URI: some importers give a URI here, too.
    ///
    /// # Errors
    /// There is no location, or it is a URI but not that of a file.
    pub fn directories(self) -> Result<Vec<PathBuf>, LocationError> {
        let path = match self {
            Location::Path(text) if !text.is_empty() => Path::new(text),
            _ => return directories(self.text()),
        };
        let plain = [path.to_owned(), path.join("resources")];
        Ok(plain.into_iter().chain(directories(self.text()).unwrap_or_default()).collect())
    }
}

/// Returns the directories that a resource location may mean, most likely first; at least one. Importers give
/// `file:///…`, `file:/…`, `file://localhost/…` or a plain path; percent-encoded or not; with or without a trailing
/// slash or the last part, `resources`.
///
/// # Errors
/// There is no location, or it is not a file URI.
pub fn directories(location: &str) -> Result<Vec<PathBuf>, LocationError> {
    let paths = texts(location, cfg!(windows))?.into_iter().map(PathBuf::from);
    Ok(paths.flat_map(|path| [path.clone(), path.join("resources")]).collect())
}

/// Returns the paths, as texts of an operating system.
fn texts(location: &str, windows: bool) -> Result<Vec<String>, LocationError> {
    let uri = location.trim();
    if uri.is_empty() {
        return Err(LocationError::Missing);
    }
    let refused = || LocationError::Uri(uri.to_owned());
    // Of Windows: the share of a machine.
    let mut share = None;
    let path = match uri.get(..5).filter(|scheme| scheme.eq_ignore_ascii_case("file:")) {
        Some(_) => {
            let rest = &uri[5..];
            match rest.strip_prefix("//") {
                // file://host/path; an empty host is this machine.
                Some(host_and_path) => {
                    let slash = host_and_path.find('/').unwrap_or(host_and_path.len());
                    let (host, path) = host_and_path.split_at(slash);
                    match host {
                        "" if !path.is_empty() => path,
                        // Two slashes instead of three: some importers write it.
                        drive if windows && has_drive(drive) => host_and_path,
                        _ if path.is_empty() => return Err(refused()),
                        host if host.eq_ignore_ascii_case("localhost") => path,
                        host if windows => {
                            share = Some(host);
                            path
                        }
                        _ => return Err(refused()),
                    }
                }
                None => rest,
            }
        }
        // A scheme of one letter is a Windows drive.
        None if uri.find("://").is_some_and(|colon| colon > 1) => return Err(refused()),
        None => uri,
    };
    // /C:/path; a share stands behind more than one slash.
    let path = match path.strip_prefix('/') {
        Some(drive) if windows && has_drive(drive) => drive,
        _ => path,
    };
    let path = share.map_or_else(|| path.to_owned(), |host| format!("//{host}{path}"));
    let decoded = percent_decode_str(&path).decode_utf8_lossy().into_owned();
    // Some importers do not encode: a percent sign is then literal.
    let literal = (decoded != path).then_some(path);
    Ok([decoded].into_iter().chain(literal).collect())
}

/// Returns whether a path of Windows begins with a drive, whose colon may be encoded.
fn has_drive(path: &str) -> bool {
    let mut letters = path.chars();
    let rest =
        |path: &str| path.starts_with(':') || path.get(..3).is_some_and(|c| c.eq_ignore_ascii_case("%3a"));
    letters.next().is_some_and(|letter| letter.is_ascii_alphabetic()) && rest(letters.as_str())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn uris_are_read_liberally() {
        const UNIX: [(&str, &str); 8] = [
            ("file:///tmp/sp%20ace/resources", "/tmp/sp ace/resources"),
            ("file:/tmp/x", "/tmp/x"),
            ("file:////tmp/x", "//tmp/x"),
            ("file://localhost/tmp/x", "/tmp/x"),
            ("FILE:///tmp/x", "/tmp/x"),
            ("/tmp/a b/ü", "/tmp/a b/ü"),
            ("file:///tmp/%C3%BC", "/tmp/ü"),
            ("file:///C:/x", "/C:/x"),
        ];
        const WINDOWS: [(&str, &str); 17] = [
            ("file:///C:/Users/J%C3%BCrgen/a%20b/resources", "C:/Users/Jürgen/a b/resources"),
            ("file:///C:/Users/Jürgen/resources/", "C:/Users/Jürgen/resources/"),
            ("file:///c%3A/x", "c:/x"),
            ("file:/C:/x", "C:/x"),
            ("file://C:/x", "C:/x"),
            ("file:///C:\\Users\\x", "C:\\Users\\x"),
            ("file://C:\\Users\\x", "C:\\Users\\x"),
            ("file:C:\\x", "C:\\x"),
            ("FILE://LocalHost/C:/x", "C:/x"),
            ("C:\\Users\\Jürgen\\resources", "C:\\Users\\Jürgen\\resources"),
            ("C:/x", "C:/x"),
            ("/C:/x", "C:/x"),
            ("\\\\server\\share\\x", "\\\\server\\share\\x"),
            ("\\\\?\\C:\\x", "\\\\?\\C:\\x"),
            ("file://server/share/a%20b", "//server/share/a b"),
            ("file:////server/share/x", "//server/share/x"),
            ("/x", "/x"),
        ];
        let cases = UNIX.map(|case| (case, false)).into_iter().chain(WINDOWS.map(|case| (case, true)));
        for ((uri, path), windows) in cases {
            assert_eq!(texts(uri, windows).unwrap()[0], path, "{uri}");
        }
        // A percent sign that was not encoded.
        assert_eq!(texts("file:///C:/100%25", true).unwrap(), ["C:/100%", "C:/100%25"]);
        for uri in ["http://host/x", "file://", "file://server", " "] {
            assert!(texts(uri, true).is_err() && texts(uri, false).is_err(), "{uri}");
        }
        // Elsewhere a machine's name is not a part of a path.
        assert!(texts("file://server/share/x", false).is_err());
    }
}
