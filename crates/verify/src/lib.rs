//! Verification of the programs.
//!
//! - `checks` (feature `checks`): the table of `lemons verify`
//! - `bench` (feature `bench`): crowds on which the engine is measured
//! - `fuzz` (feature `fuzz`): what the fuzzers of `fuzz/` do with their bytes

#[cfg(feature = "bench")]
pub mod bench;
#[cfg(feature = "checks")]
pub mod checks;
#[cfg(all(feature = "fuzz", target_os = "linux", any(target_arch = "x86_64", target_arch = "aarch64")))]
pub mod fuzz;
