//! Files from outside: the one place that opens them, and the limits of what is read.
//!
//! - [`input`]: regular files, and what a user names; how many bytes
//! - [`markup`]: how much an XML element may hold before a parser sees it

pub mod input;
pub mod markup;
