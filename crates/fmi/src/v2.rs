//! FMI 2.0: a variable for each number.
//!
//! - [`table`]: the table of variables, its GUID
//! - [`lifecycle`]: which function is allowed in which state, as data
//! - [`slave`]: the variables of an instance, read and set
//! - [`description`]: table -> `modelDescription.xml`
//! - [`component`]: the bodies of the C functions
//! - [`export_fmi2!`](crate::export_fmi2): the 34 C functions for a model

pub mod component;
pub mod description;
mod export;
pub mod lifecycle;
pub mod slave;
pub mod table;

pub use component::CallbackFunctions;
pub use slave::Slave;
pub use table::guid;
