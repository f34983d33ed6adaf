//! What the fuzzers of `fuzz/` do with their bytes: each function takes any bytes and panics when the
//! program under test breaks a promise. The fuzzers are one-liners around them; `tests/replay.rs` runs
//! them on the inputs that the fuzzers kept.
//!
//! - [`fmi_calls`], [`decision_calls`]: sequences of FMI calls with any arguments
//! - [`states`]: damaged states with a good checksum
//! - [`trial_xml`]: any bytes as one file of a Trial
//! - [`fmu_archive`]: any bytes as an `.fmu`, or as its `modelDescription.xml`
//! - [`ssp_archive`]: any bytes as an `.ssp`, as its structure, or as an FMU's interface
//! - [`decision_toml`]: any text as wishes or as a plan

#![cfg(all(target_os = "linux", any(target_arch = "x86_64", target_arch = "aarch64")))]

mod calls;
mod files;
mod importer;
mod models;

pub use calls::{decision_calls, fmi_calls, states};
pub use files::{decision_toml, fmu_archive, ssp_archive, trial_xml};

/// A fuzz target.
pub type Target = fn(&[u8]);

/// The targets, by the names of their fuzzers and of the directories of their inputs.
pub const TARGETS: [(&str, Target); 7] = [
    ("fmi_calls", fmi_calls),
    ("decision_calls", decision_calls),
    ("states", states),
    ("trial_xml", trial_xml),
    ("fmu_archive", fmu_archive),
    ("ssp_archive", ssp_archive),
    ("decision_toml", decision_toml),
];

/// The FMUs silence panics in their host; here a panic is what is looked for, and is shown.
fn show_panics() {
    static ONCE: std::sync::Once = std::sync::Once::new();
    ONCE.call_once(|| {
        let hook = std::panic::take_hook();
        lemons_fmi2::silence_panics();
        std::panic::set_hook(hook);
    });
}
