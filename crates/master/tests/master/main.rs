//! Runs and couplings, beside loops written out here and another importer.
//!
//! One program for all of them: linking takes longer than compiling.

mod arrays;
#[path = "../../../../tests/coupling/controller.rs"]
mod controller;
mod coupling;
mod fmi_rs;
mod fmi_rs_sim;
mod reference;
mod settings;

use crowd_mechanics::pack::{FmuFormat, Package};
use std::path::{Path, PathBuf};

/// The FMU of the paper's push, in a directory.
fn packed(directory: &Path, format: FmuFormat) -> PathBuf {
    let trial = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../resources/Trial_push");
    let path = directory.join("crowd.fmu");
    let (trials, binaries) = (vec![trial], vec![lemons_master::own_binary().unwrap()]);
    Package { trials, binaries, format, ..Package::default() }.write(&path).unwrap();
    path
}
