//! Files: the only crate that opens input files, with limits; output files are written completely or not at all.
//!
//! The latter holds if the process is ended or killed, not if the power fails: only what is synced ([`Staged::sync`]) is
//! on the disk before it replaces another file.
//!
//! - [`input`]: regular files, up to a size
//! - [`source`]: files of the disk or of memory
//! - [`words`]: suggestions for misspelt words
//! - `temporary`: files and directories that are removed unless they are put into place
//! - `written`: files that are written beside their place, then moved there

pub mod input;
pub mod source;
mod temporary;
pub mod words;
mod written;

pub use temporary::{Scratch, give_up, make_directories};
pub use written::{Change, FileStamp, Staged, WriteError, change_all, mark_of, reader_left, target_of};
