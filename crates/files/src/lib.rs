//! Files: the only crate that opens input files, with limits; output files are written completely or not at all.
//!
//! The latter holds if the process is ended or killed, not if the power fails: only what is synced ([`Staged::sync`]) is
//! on the disk before it replaces another file.
//!
//! - [`input`]: regular files and files that the user names, up to a size
//! - [`pipe`]: writing to a named pipe, whose reader may never come
//! - [`source`]: files of the disk or of memory
//! - [`words`]: suggestions for misspelt words

pub mod input;
#[cfg(unix)]
pub mod pipe;
pub mod source;
pub mod words;
mod written;

pub use written::{
    Before, Change, Changed, Scratch, Staged, StagedDirectory, WriteError, change_all, give_up, guard,
    make_directories, names_beside, only_path, placed, reader_left, remove_file, unnamed, wait_no_longer,
    waited_in_vain, write_atomically,
};
