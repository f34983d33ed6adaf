//! Verification of the programs.
//!
//! - `checks` (feature `checks`): the table of `lemons verify`
//! - `bench` (feature `checks`): the crowds of `lemons bench`
//! - `fuzz` (feature `fuzz`): what the fuzzers of `fuzz/` do with their bytes

#[cfg(feature = "checks")]
pub mod bench;
#[cfg(feature = "checks")]
pub mod checks;
#[cfg(all(feature = "fuzz", target_os = "linux", any(target_arch = "x86_64", target_arch = "aarch64")))]
pub mod fuzz;
