//! The built library, driven through its FMI 3.0 C functions as an importer drives it.

#![cfg(all(target_os = "linux", any(target_arch = "x86_64", target_arch = "aarch64")))]
#![allow(unsafe_code)] // calls C functions of a loaded library

mod drive;
mod fmu;
mod intermediate;
mod lifecycle;
mod sizes;
mod states;
mod values;
