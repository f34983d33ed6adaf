//! The type of a file that was taken for something else.

use crate::error::{MasterError, Result};
use crate::ssp::{STRUCTURE_FILE, open_zip};
use crate::unzip::DESCRIPTION_FILE;
use lemons_core::files::input;
use std::io::{ErrorKind, Read};
use std::path::Path;

/// A kind of file, in words.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FileType(&'static str);

/// Bytes that are looked at.
const BEGIN: u64 = 4096;

#[allow(missing_docs)] // the texts say it
impl FileType {
    const MISSING: FileType = FileType("there is no such file or directory");
    const UNREADABLE: FileType = FileType("cannot be read");
    pub const TRIAL: FileType = FileType("is a Trial directory");
    pub const DIRECTORY: FileType = FileType("is a directory without Parameters.xml");
    /// Not looked into.
    pub const STREAM: FileType = FileType("is a pipe or a device");
    pub const FMU: FileType = FileType("is an FMU");
    pub const SSP: FileType = FileType("is an SSP");
    pub const SAVED_RUN: FileType = FileType("is a saved run");
    pub const ARCHIVE: FileType = FileType("is a zip archive");
    pub const PARQUET: FileType = FileType("is a table in Parquet");
    /// `JuPedSim`'s trajectories are such.
    pub const SQLITE: FileType = FileType("is an SQLite database");
    const HDF5: FileType = FileType("is an HDF5 file");
    pub const LIBRARY: FileType = FileType("is a program or a library");
    pub const COMPONENT: FileType = FileType("is a WebAssembly component");
    pub const TEXT: FileType = FileType("is a text file");
    pub const BINARY: FileType = FileType("is a binary file");
    /// Kinds that may be an archive: what is wrong with it is told by what is in it.
    pub(crate) const ARCHIVES: [FileType; 5] =
        [FileType::FMU, FileType::SSP, FileType::SAVED_RUN, FileType::ARCHIVE, FileType::STREAM];

    /// Finds the kind by the name, at the first bytes, and at the names in an archive.
    fn of(path: &Path) -> FileType {
        let there = match path.metadata() {
            Ok(there) => there,
            Err(error) if error.kind() == ErrorKind::NotFound => return FileType::MISSING,
            Err(_) => return FileType::UNREADABLE,
        };
        if there.is_dir() {
            return if path.join("Parameters.xml").is_file() { FileType::TRIAL } else { FileType::DIRECTORY };
        }
        if !there.is_file() {
            return FileType::STREAM;
        }
        let mut begin = Vec::new();
        match input::open(path).and_then(|file| file.take(BEGIN).read_to_end(&mut begin)) {
            Ok(0) => FileType("is an empty file"),
            Ok(_) => FileType::of_content(path, &begin),
            Err(_) => FileType::UNREADABLE,
        }
    }

    fn of_content(path: &Path, begin: &[u8]) -> FileType {
        const LIBRARIES: [&[u8]; 5] =
            [b"\x7fELF", b"MZ", b"\xcf\xfa\xed\xfe", b"\xce\xfa\xed\xfe", b"\xca\xfe\xba\xbe"];
        if begin.starts_with(b"PK") {
            let Ok(archive) = open_zip(path) else { return FileType("is a damaged zip archive") };
            let marks = [
                (DESCRIPTION_FILE, FileType::FMU),
                (STRUCTURE_FILE, FileType::SSP),
                ("run.toml", FileType::SAVED_RUN),
            ];
            let found = marks.iter().find(|(name, _)| archive.index_for_name(name).is_some());
            return found.map_or(FileType::ARCHIVE, |(_, kind)| *kind);
        }
        // The end may cut off a character.
        let text = std::str::from_utf8(begin).map_or_else(|error| error.error_len().is_none(), |_| true);
        match text && !begin.contains(&0) {
            _ if begin.starts_with(b"PAR1") => FileType::PARQUET,
            _ if begin.starts_with(b"SQLite format 3\0") => FileType::SQLITE,
            _ if begin.starts_with(b"\x89HDF\r\n\x1a\n") => FileType::HDF5,
            _ if begin.starts_with(b"\0asm\x0d\0\x01\0") => FileType::COMPONENT,
            _ if LIBRARIES.iter().any(|magic| begin.starts_with(magic)) => FileType::LIBRARY,
            true => FileType::TEXT,
            false => FileType::BINARY,
        }
    }

    /// Checks that a path leads to one of these kinds, or to what is found to be wrong when it is read.
    ///
    /// # Errors
    /// It does not; the text says what is there, and what is `wanted`.
    pub fn expect(path: &Path, kinds: &[FileType], wanted: &str) -> Result<()> {
        let kind = FileType::of(path);
        if kinds.contains(&kind) || kind == FileType::UNREADABLE {
            return Ok(());
        }
        let wanted = if kind == FileType::MISSING { String::new() } else { format!(", not {wanted}") };
        let hint = match kind {
            FileType::SAVED_RUN => "; lemons run --resume continues it",
            FileType::HDF5 => "; lemons_fmu reads those of the data archive in Python",
            _ => "",
        };
        Err(MasterError::new(format!("{}: {}{wanted}{hint}", path.display(), kind.0)))
    }
}
