//! What a file is that was taken for something else.

use crate::error::{Error, Result};
use crate::ssp::STRUCTURE_FILE;
use crate::unzip::DESCRIPTION_FILE;
use lemons_core::files::input;
use std::fmt;
use std::io::{BufReader, ErrorKind, Read};
use std::path::Path;
use zip::ZipArchive;

/// What lies at a path.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(missing_docs)] // the texts say it
pub enum FileType {
    Missing,
    Unreadable,
    Trial,
    Directory,
    /// A pipe, a device: not looked into.
    Stream,
    Empty,
    Fmu,
    Ssp,
    SavedRun,
    Archive,
    BrokenArchive,
    Parquet,
    Library,
    Text,
    Binary,
}

/// Bytes that are looked at.
const BEGIN: u64 = 4096;

impl FileType {
    /// What may be an archive: what is wrong with it is told by what is in it.
    pub(crate) const ARCHIVES: [FileType; 5] =
        [FileType::Fmu, FileType::Ssp, FileType::SavedRun, FileType::Archive, FileType::Stream];

    /// Looks at the name, at the first bytes, and at the names in an archive.
    pub fn of(path: &Path) -> FileType {
        let there = match path.metadata() {
            Ok(there) => there,
            Err(error) if error.kind() == ErrorKind::NotFound => return FileType::Missing,
            Err(_) => return FileType::Unreadable,
        };
        if there.is_dir() {
            return if path.join("Parameters.xml").is_file() { FileType::Trial } else { FileType::Directory };
        }
        if !there.is_file() {
            return FileType::Stream;
        }
        let mut begin = Vec::new();
        match input::open(path).and_then(|file| file.take(BEGIN).read_to_end(&mut begin)) {
            Ok(0) => FileType::Empty,
            Ok(_) => FileType::of_content(path, &begin),
            Err(_) => FileType::Unreadable,
        }
    }

    fn of_content(path: &Path, begin: &[u8]) -> FileType {
        const LIBRARIES: [&[u8]; 5] =
            [b"\x7fELF", b"MZ", b"\xcf\xfa\xed\xfe", b"\xce\xfa\xed\xfe", b"\xca\xfe\xba\xbe"];
        if begin.starts_with(b"PK") {
            return FileType::of_archive(path);
        }
        if begin.starts_with(b"PAR1") {
            return FileType::Parquet;
        }
        if LIBRARIES.iter().any(|magic| begin.starts_with(magic)) {
            return FileType::Library;
        }
        let text = match std::str::from_utf8(begin) {
            Ok(_) => true,
            // A character that the end cuts off.
            Err(error) => error.error_len().is_none(),
        };
        if text && !begin.contains(&0) { FileType::Text } else { FileType::Binary }
    }

    fn of_archive(path: &Path) -> FileType {
        let archive = input::open(path).ok().and_then(|file| ZipArchive::new(BufReader::new(file)).ok());
        let Some(archive) = archive else { return FileType::BrokenArchive };
        let marks = [
            (DESCRIPTION_FILE, FileType::Fmu),
            (STRUCTURE_FILE, FileType::Ssp),
            ("run.toml", FileType::SavedRun),
        ];
        let found = marks.iter().find(|(name, _)| archive.index_for_name(name).is_some());
        found.map_or(FileType::Archive, |(_, kind)| *kind)
    }

    /// Checks that a path leads to one of these kinds, or to what is found to be wrong when it is read.
    ///
    /// # Errors
    /// It does not; the text says what is there, and what is `wanted`.
    pub fn expect(path: &Path, kinds: &[FileType], wanted: &str) -> Result<()> {
        let kind = FileType::of(path);
        if kinds.contains(&kind) || kind == FileType::Unreadable {
            return Ok(());
        }
        let wanted = if kind == FileType::Missing { String::new() } else { format!(", not {wanted}") };
        let hint = if kind == FileType::SavedRun { "; lemons run --resume continues it" } else { "" };
        Err(Error::new(format!("{}: {kind}{wanted}{hint}", path.display())))
    }
}

impl fmt::Display for FileType {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            FileType::Missing => "there is no such file or directory",
            FileType::Unreadable => "cannot be read",
            FileType::Trial => "is a Trial directory",
            FileType::Directory => "is a directory without Parameters.xml",
            FileType::Stream => "is a pipe or a device",
            FileType::Empty => "is an empty file",
            FileType::Fmu => "is an FMU",
            FileType::Ssp => "is an SSP",
            FileType::SavedRun => "is a saved run",
            FileType::Archive => "is a zip archive",
            FileType::BrokenArchive => "is a damaged zip archive",
            FileType::Parquet => "is a table in Parquet",
            FileType::Library => "is a program or a library",
            FileType::Text => "is a text file",
            FileType::Binary => "is a binary file",
        })
    }
}
