//! The shared library of the Decision FMU: the FMI 2.0 C functions of [`Decision`](lemons_decision::Decision).
//!
//! It is a separate crate, because a program that linked both this and the crowd's library would have each function
//! twice.

#![allow(unsafe_code)] // the C boundary
#![allow(non_snake_case)] // FMI's own names
#![allow(clippy::missing_safety_doc)] // FMI's contract: see `lemons_fmi::v2::component`

lemons_fmi::export_fmi2!(lemons_decision::Decision);
