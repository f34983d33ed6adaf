//! What the library shows.

use crate::fmu::*;
use std::ffi::CStr;

/// FMI 2.0: 25 common functions and 9 of co-simulation. Loading them all is what [`Fmu::get`] does.
#[test]
fn all_34_functions_are_exported() {
    Fmu::get();
    assert_eq!(NAMES.len(), 34);
}

#[test]
fn it_says_which_fmi_it_is() {
    let c = &Fmu::get().c;
    let text = |text| unsafe { CStr::from_ptr(text) };
    assert_eq!(text(unsafe { (c.fmi2GetVersion)() }), c"2.0");
    assert_eq!(text(unsafe { (c.fmi2GetTypesPlatform)() }), c"default");
}
