//! The built library, driven through its C functions as an importer drives it: FMI 2.0 and 3.0.

#![cfg(all(target_os = "linux", any(target_arch = "x86_64", target_arch = "aarch64")))]
#![allow(unsafe_code)] // calls C functions of a loaded library

mod arrays;
mod dependencies;
mod derivatives;
mod drive;
mod fmu;
mod instances;
mod instantiate;
mod lifecycle;
mod processes;
mod squeeze;
mod states;
mod stepping;
mod tolerance;
mod trials;
mod values;
