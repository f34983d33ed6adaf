//! Targets of the fuzzers of `fuzz/`: each function takes any bytes and panics when the
//! program under test breaks a promise. The fuzzers are one-liners around them; `tests/replay.rs` runs
//! them on the inputs that the fuzzers kept.
//!
//! - `calls`: sequences of FMI calls with any arguments, damaged states among them, on FMUs of both versions
//! - `trial_xml`: any bytes as one file of a Trial
//! - `fmu_archive`: any bytes as an `.fmu`, or as its `modelDescription.xml`
//! - `ssp_archive`: any bytes as an `.ssp`, as its structure, or as an FMU's interface
//! - `decision_toml`: any text as `decision.toml`
//! - `drive_csv`: any bytes as a drive file
//! - `table_csv`: any bytes as the table of a run
//! - `trajectories`: any bytes as trajectories of others
//! - `sweep_toml`: any text as a `sweep.toml`, any bytes as the table of points that it names
//! - `run_file`: any bytes as a saved run, or as its `run.toml`

mod calls;
mod files;
mod inputs;
mod models;

use calls::calls;
use files::{decision_toml, fmu_archive, ssp_archive, trial_xml};
use inputs::{drive_csv, run_file, sweep_toml, table_csv, trajectories};

/// A fuzz target.
pub type FuzzTarget = fn(&[u8]);

/// The targets, by the names of their fuzzers and of the directories of their inputs.
pub const TARGETS: [(&str, FuzzTarget); 10] = [
    ("calls", calls),
    ("trial_xml", trial_xml),
    ("fmu_archive", fmu_archive),
    ("ssp_archive", ssp_archive),
    ("decision_toml", decision_toml),
    ("drive_csv", drive_csv),
    ("table_csv", table_csv),
    ("trajectories", trajectories),
    ("sweep_toml", sweep_toml),
    ("run_file", run_file),
];

/// The FMUs silence panics in their host; here a panic is what is looked for, and is shown.
fn show_panics() {
    static ONCE: std::sync::Once = std::sync::Once::new();
    ONCE.call_once(|| {
        let hook = std::panic::take_hook();
        lemons_fmi::silence_panics();
        std::panic::set_hook(hook);
    });
}

/// Runs a target.
///
/// # Panics
/// There is no such target, or the program under test breaks a promise.
pub fn run(target: &str, data: &[u8]) {
    let (_, run) = TARGETS.iter().find(|(name, _)| *name == target).expect("a target");
    run(data);
}
