//! Files: the only crate that opens input files, with limits; output files are written completely or not at all.
//!
//! - [`input`]: regular files and files that the user names, up to a size
//! - [`pipe`]: writing to a named pipe, whose reader may never come
//! - [`words`]: suggestions for misspelt words

pub mod input;
#[cfg(unix)]
pub mod pipe;
pub mod words;
mod written;

pub use written::{
    Before, Change, Changed, Scratch, Staged, StagedDirectory, WriteError, change_all, give_up, guard,
    names_beside, only_path, placed, reader_left, remove_file, unnamed, wait_no_longer, waited_in_vain,
    write_atomically,
};
