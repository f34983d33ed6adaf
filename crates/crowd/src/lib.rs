//! People and crowds from anthropometric data: the other half of the paper (sections 2.1, 3.3, 4.4, 4.5; App. A.2, D).
//!
//! A [`Person`] is drawn from statistics; five disks are fitted to it, its [`Shape`]; crowds of shapes are [placed](placing)
//! without overlap and written as a Trial. SI units; angles in radians, counter-clockwise positive.

mod person;
pub mod placing;
mod shape;

pub use person::{Person, Sex};
pub use shape::{Disk, Shape};
