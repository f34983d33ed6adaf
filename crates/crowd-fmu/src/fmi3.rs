//! The FMI 3.0 C functions of the crowd, nothing else.

#![allow(unsafe_code)] // the C boundary
#![allow(non_snake_case)] // FMI's own names
#![allow(clippy::missing_safety_doc)] // FMI's contract: see `lemons_fmi::calls`
#![allow(clippy::too_many_arguments)] // FMI's signatures

lemons_fmi::export_fmi3!(lemons_crowd::model::CrowdModel);
