//! Where an FMU finds its resources: as an URI in FMI 2.0, as a path in FMI 3.0.

use super::c_text;
use crate::error::{ErrorPlace, MasterError, Result};
use percent_encoding::{AsciiSet, NON_ALPHANUMERIC, percent_encode};
use std::ffi::CString;
use std::path::{MAIN_SEPARATOR, Path, PathBuf};

fn absolute(directory: &Path) -> Result<PathBuf> {
    std::path::absolute(directory).place(|| directory.display().to_string())
}

/// Characters that stand for themselves in the path of an URI.
const ENCODED: &AsciiSet = &NON_ALPHANUMERIC.remove(b'-').remove(b'.').remove(b'_').remove(b'~').remove(b'/');

/// `file:///…/`, as FMI 2.0 wants it.
pub(super) fn file_uri(directory: &Path) -> Result<CString> {
    let path = absolute(directory)?;
    let uri = uri_of(path.as_os_str().as_encoded_bytes(), cfg!(windows));
    c_text(&uri, || uri.clone())
}

/// Returns the URI of an absolute path.
fn uri_of(path: &[u8], windows: bool) -> String {
    let encoded = |path: &[u8]| {
        let text = percent_encode(path, ENCODED).to_string();
        text.trim_end_matches('/').to_owned()
    };
    if !windows {
        return format!("file://{}/", encoded(path));
    }
    // What tells Windows to take a path as it is stands before a drive, or before the name of a machine.
    let share = path
        .strip_prefix(br"\\?\UNC\")
        .or_else(|| path.strip_prefix(br"\\").filter(|rest| !rest.starts_with(b"?")));
    let plain = share.or_else(|| path.strip_prefix(br"\\?\")).unwrap_or(path);
    let slashes: Vec<u8> = plain.iter().map(|&byte| if byte == b'\\' { b'/' } else { byte }).collect();
    // The colon of the drive stands for itself.
    let encoded = encoded(&slashes).replacen("%3A", ":", 1);
    if share.is_some() { format!("file://{encoded}/") } else { format!("file:///{encoded}/") }
}

/// The directory, with a separator at its end, as FMI 3.0 wants it.
pub(super) fn path_text(directory: &Path) -> Result<CString> {
    let path = absolute(directory)?;
    let text = path.to_str().ok_or_else(|| MasterError::new(format!("{}: is not UTF-8", path.display())))?;
    let text = format!("{}{MAIN_SEPARATOR}", text.trim_end_matches(MAIN_SEPARATOR));
    c_text(&text, || text.clone())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[cfg(unix)]
    fn the_resources_are_named_by_an_uri() {
        let uri = |path: &str| file_uri(Path::new(path)).unwrap().into_string().unwrap();
        assert_eq!(uri("/tmp/a_b-c.d~/resources"), "file:///tmp/a_b-c.d~/resources/");
        assert_eq!(uri("/tmp/a b%20#?/ü/"), "file:///tmp/a%20b%2520%23%3F/%C3%BC/");
        let here = std::env::current_dir().unwrap();
        assert_eq!(uri("x"), uri(here.join("x").to_str().unwrap()));
        // As the other side reads it.
        let read = lemons_fmi::location::directories(&uri("/tmp/a b%20#?/ü")).unwrap();
        assert_eq!(read[0], Path::new("/tmp/a b%20#?/ü/"));
    }

    #[test]
    fn a_path_of_windows_is_named_by_an_uri() {
        let uri = |path: &str| uri_of(path.as_bytes(), true);
        assert_eq!(uri(r"C:\Users\Jürgen\a b%\x"), "file:///C:/Users/J%C3%BCrgen/a%20b%25/x/");
        assert_eq!(uri(r"\\?\C:\Users\x\"), "file:///C:/Users/x/");
        assert_eq!(uri(r"\\server\share\x"), "file://server/share/x/");
        assert_eq!(uri(r"\\?\UNC\server\share\x"), "file://server/share/x/");
    }
}
