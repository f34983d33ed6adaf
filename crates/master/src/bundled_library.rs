//! Shared libraries that were built with this program.

use crate::error::{ErrorPlace, MasterError, Result};
use crowd_mechanics::pack::{Binary, host_platform, library_file, platforms};
use std::path::{Path, PathBuf};
use std::sync::{PoisonError, RwLock};

/// The crowd's shared library that was built with this program.
///
/// # Errors
/// As [`binary_beside`].
pub fn own_binary() -> Result<Binary> {
    binary_beside("crowd_mechanics")
}

/// A shared library that was built with this program: beside it, or in `deps` or a directory with FMI's name of this
/// platform beside it.
///
/// # Errors
/// It is in no such place, or FMI has no name for this platform.
pub fn binary_beside(library: &str) -> Result<Binary> {
    Ok(binaries_beside(library, &[host()?.to_owned()])?.swap_remove(0))
}

/// The shared library for this machine, and those for other platforms that lie in directories with FMI's names (`win64`,
/// `aarch64-linux`, …) beside this program: all of them, or those of the platforms that are `wanted`.
///
/// # Errors
/// None is there for this machine or for a platform that is wanted.
pub fn binaries_beside(library: &str, wanted: &[String]) -> Result<Vec<Binary>> {
    binaries_in(&beside()?, library, wanted)
}

/// Returns FMI's name of the platform of this program.
pub(crate) fn host() -> Result<&'static str> {
    Ok(host_platform().ok_or("FMI has no name for this platform: give --binary PLATFORM=FILE")?)
}

fn binaries_in(beside: &Path, library: &str, wanted: &[String]) -> Result<Vec<Binary>> {
    let one = |platform: &str| {
        find(beside, library, platform).ok_or_else(|| {
            let name = library_file(library, platform).unwrap_or_else(|| library.to_owned());
            let beside = beside.display();
            MasterError::new(format!(
                "{name} is not beside this program ({beside}): give --binary {platform}=FILE"
            ))
        })
    };
    if wanted.is_empty() {
        let host = host()?;
        let others = platforms().filter(|platform| *platform != host);
        let others = others.filter_map(|platform| find(beside, library, platform));
        return Ok([one(host)?].into_iter().chain(others).collect());
    }
    wanted.iter().map(|platform| one(platform)).collect()
}

/// Where libraries are looked for instead of beside this program.
static PLACE: RwLock<Option<PathBuf>> = RwLock::new(None);

/// Looks for libraries in this directory from now on, as beside the program: for a program that is not of this
/// workspace.
pub fn look_in(directory: &Path) {
    *PLACE.write().unwrap_or_else(PoisonError::into_inner) = Some(directory.to_owned());
}

/// Where this program is.
fn beside() -> Result<PathBuf> {
    if let Some(place) = &*PLACE.read().unwrap_or_else(PoisonError::into_inner) {
        return Ok(place.clone());
    }
    let program = std::env::current_exe().place(|| "where is this program?".to_owned())?;
    Ok(program.parent().unwrap_or(Path::new(".")).to_owned())
}

/// The library for a platform; that of this machine may also lie where Cargo puts it.
fn find(beside: &Path, library: &str, platform: &str) -> Option<Binary> {
    let name = library_file(library, platform)?;
    let mut places = vec![beside.join(platform).join(&name)];
    if host_platform() == Some(platform) {
        places.extend([beside.join(&name), beside.join("deps").join(&name)]);
    }
    // Cargo may have left an older one in one of the places.
    let newest =
        places.into_iter().filter_map(|path| Some((path.metadata().ok()?.modified().ok()?, path))).max();
    newest.map(|(_, path)| Binary { platform: platform.to_owned(), path })
}

#[cfg(test)]
mod tests {
    use super::*;
    use tempfile::TempDir;

    #[test]
    fn libraries_of_other_platforms_are_found_in_directories_beside_the_program() {
        let (directory, own) = (TempDir::new().unwrap(), own_binary().unwrap());
        let (beside, host) = (directory.path(), host_platform().unwrap());
        let found = |wanted: &[&str]| {
            let wanted: Vec<String> = wanted.iter().map(|&platform| platform.to_owned()).collect();
            binaries_in(beside, "crowd_mechanics", &wanted)
                .map(|all| all.into_iter().map(|binary| binary.platform).collect::<Vec<_>>())
                .map_err(|error| error.whole())
        };
        let name = library_file("crowd_mechanics", host).unwrap();
        let message = found(&[]).unwrap_err();
        assert!(message.starts_with(&format!("{name} is not beside this program")), "{message}");
        // That of this machine may lie there, too.
        std::fs::create_dir(beside.join(host)).unwrap();
        std::fs::copy(&own.path, beside.join(host).join(&name)).unwrap();
        assert_eq!(found(&[]).unwrap(), [host]);
        let other = if host == "win64" { "linux64" } else { "win64" };
        assert!(found(&[other]).unwrap_err().contains("is not beside this program"));
        std::fs::create_dir(beside.join(other)).unwrap();
        let file = library_file("crowd_mechanics", other).unwrap();
        std::fs::write(beside.join(other).join(file), "").unwrap();
        assert_eq!(found(&[]).unwrap(), [host, other]);
        assert_eq!(found(&[other]).unwrap(), [other]);
        assert!(found(&["win65"]).unwrap_err().contains("crowd_mechanics is not beside this program"));
    }
}
