//! An FMI 2.0 master on `fmi-rs`: knows of an FMU what its model description says, couples several by SSP.

mod assemble;
mod clock;
mod drive;
mod extremes;
mod fmu;
mod kind;
mod library;
mod saved;
mod state;
mod system;
mod unzip;

pub use assemble::{Assembled, assemble};
pub use clock::Clock;
pub use drive::{Drive, Push, Pushes};
pub use extremes::{Extremes, Greatest};
pub use fmu::{Fmu, Instance, named};
pub use kind::Kind;
pub use library::check_library;
pub use saved::{ComponentRecord, CrowdRecord, Extent, Saved, wiring_of};
pub use state::{LARGEST_STATE, State};
pub use system::{Algorithm, Component, System};
pub use unzip::unzip_trial;

use anyhow::{Context, Result, bail};
use crowd_mechanics::pack::{Binary, host_platform};
use std::path::Path;
use std::time::Duration;

/// Of a user who wants to stop: steps under way that take longer are given up.
pub const PATIENCE: Duration = Duration::from_millis(500);

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
/// It is in neither place, or FMI has no name for this platform.
pub fn binary_beside(library: &str) -> Result<Binary> {
    let Some(platform) = host_platform() else {
        bail!("FMI 2.0 has no name for this platform: give --binary PLATFORM=FILE");
    };
    let name = format!("{}{library}{}", std::env::consts::DLL_PREFIX, std::env::consts::DLL_SUFFIX);
    let program = std::env::current_exe().context("where is this program?")?;
    let beside = program.parent().unwrap_or(Path::new("."));
    let places = [beside.join(&name), beside.join("deps").join(&name)];
    // Cargo may have left an older one in one of the places.
    let newest = places.iter().filter_map(|path| Some((path.metadata().ok()?.modified().ok()?, path))).max();
    match newest {
        Some((_, path)) => Ok(Binary { platform: platform.to_owned(), path: path.clone() }),
        None => {
            bail!("{name} is not beside this program ({}): give --binary {platform}=FILE", beside.display())
        }
    }
}
