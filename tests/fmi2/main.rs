//! The built library, driven through its FMI 2.0 C functions as an importer drives it.

#![cfg(all(target_os = "linux", any(target_arch = "x86_64", target_arch = "aarch64")))]
#![allow(unsafe_code)] // calls C functions of a loaded library

mod derivatives;
mod drive;
mod exports;
mod exposure;
mod fmu;
mod instances;
mod instantiate;
mod lifecycle;
mod logging;
mod memory;
mod nulls;
mod queries;
mod states;
mod stepping;
mod threads;
mod tolerance;
mod trials;
mod unloading;
mod uris;
mod values;
