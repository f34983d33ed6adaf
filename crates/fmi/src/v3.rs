//! FMI 3.0: variables are arrays. Their sizes are structural parameters.
//!
//! - [`arrays`]: the table of variables, and what a model must offer for it
//! - [`lifecycle`]: which function is allowed in which state, as data
//! - [`slave`]: the variables of an instance, read and set
//! - [`description`]: table -> `modelDescription.xml`
//! - [`terminals`]: table -> `terminalsAndIcons.xml`
//! - [`documentation`]: table -> rows of HTML
//! - [`component`]: the bodies of the C functions
//! - [`export_fmi3!`](crate::export_fmi3): the C functions for a model

pub mod arrays;
pub mod component;
pub mod description;
pub mod documentation;
mod export;
pub mod lifecycle;
pub mod slave;
pub mod terminals;

pub use arrays::{Array, ArrayModel, Dimension, Known, Size, token};
pub use slave::Slave;
