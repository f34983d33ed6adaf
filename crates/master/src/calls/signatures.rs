//! The types of FMI's C functions as an importer sees them: a status may be any number.

#![allow(non_camel_case_types, dead_code)] // FMI's names; not all of the functions are called

use lemons_fmi::v2::CallbackFunctions;
use std::ffi::{c_char, c_int, c_uint, c_void};

type Status = c_int;
type Logger3 = unsafe extern "C" fn(*mut c_void, c_int, *const c_char, *const c_char);
/// Always NULL here.
type IntermediateUpdate = unsafe extern "C" fn();

macro_rules! types {
    (
        $($name:ident($($argument:ident: $type:ty),*) $(-> $result:ty)?
            = $module:ident::$body:ident($($with:expr),*);)*
        [of an instance]
        $($call:ident($($given:ident: $of:ty),*) = $method:ident($($passed:expr),*);)*
    ) => {
        $(pub(super) type $name = unsafe extern "C" fn($($type),*) $(-> $result)?;)*
        $(pub(super) type $call = unsafe extern "C" fn(*mut c_void $(, $of)*) -> Status;)*
    };
}

lemons_fmi::fmi2_functions! { [types] }
lemons_fmi::fmi3_functions! { [types] }
