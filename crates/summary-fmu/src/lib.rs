//! The shared library of the summary FMU: the C functions of FMI 2.0 and FMI 3.0 of
//! [`Summary`](lemons_summary::Summary).
//!
//! It is a separate crate, because a program that linked two of these libraries would have each function
//! twice.

#![allow(unsafe_code)] // the C boundary
#![allow(non_snake_case)] // FMI's own names
#![allow(clippy::missing_safety_doc)] // FMI's contract: see `component` of `lemons_fmi::v2` and `v3`
#![allow(clippy::too_many_arguments)] // FMI's signatures

mod fmi2 {
    lemons_fmi::export_fmi2!(lemons_summary::Summary);
}

mod fmi3 {
    lemons_fmi::export_fmi3!(lemons_summary::Summary);
}
