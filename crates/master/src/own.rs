//! Shared libraries that were built with this program.

use crate::error::{Error, Place, Result};
use crate::library::check_library;
use crowd_mechanics::pack::{Binary, host_platform};
use std::path::Path;

/// The crowd's shared library that was built with this program.
///
/// # Errors
/// As [`binary_beside`].
pub fn own_binary() -> Result<Binary> {
    binary_beside("crowd_mechanics")
}

/// A shared library that was built with this program: beside it, or in `deps` beside it.
///
/// # Errors
/// It is in neither place, it is cut off or not a library, or FMI has no name for this platform.
pub fn binary_beside(library: &str) -> Result<Binary> {
    let platform = host_platform().ok_or(Error::NoPlatform)?;
    let name = format!("{}{library}{}", std::env::consts::DLL_PREFIX, std::env::consts::DLL_SUFFIX);
    let program = std::env::current_exe().map_err(Error::io("where is this program?"))?;
    let beside = program.parent().unwrap_or(Path::new("."));
    let places = [beside.join(&name), beside.join("deps").join(&name)];
    // Cargo may have left an older one in one of the places.
    let newest = places.iter().filter_map(|path| Some((path.metadata().ok()?.modified().ok()?, path))).max();
    match newest {
        Some((_, path)) => {
            check_library(path, platform).place(|| path.display().to_string())?;
            Ok(Binary { platform: platform.to_owned(), path: path.clone() })
        }
        None => Err(Error::NoLibrary { name, beside: beside.to_owned(), platform }),
    }
}
