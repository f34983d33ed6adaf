//! The Trial directory, read, checked and written.

mod good;
mod limits;
mod mistakes;
mod read;
mod written;
