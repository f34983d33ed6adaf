//! What a file is that was taken for something else.

use crate::ssp::STRUCTURE_FILE;
use crate::unzip::DESCRIPTION_FILE;
use lemons_core::files::input;
use std::fmt;
use std::io::{BufReader, ErrorKind, Read};
use std::path::{Path, PathBuf};
use zip::ZipArchive;

/// What lies at a path.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(missing_docs)] // the texts say it
pub enum Kind {
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

impl Kind {
    /// What may be an archive: what is wrong with it is told by what is in it.
    pub(crate) const ARCHIVES: [Kind; 5] =
        [Kind::Fmu, Kind::Ssp, Kind::SavedRun, Kind::Archive, Kind::Stream];

    /// Looks at the name, at the first bytes, and at the names in an archive.
    pub fn of(path: &Path) -> Kind {
        let there = match path.metadata() {
            Ok(there) => there,
            Err(error) if error.kind() == ErrorKind::NotFound => return Kind::Missing,
            Err(_) => return Kind::Unreadable,
        };
        if there.is_dir() {
            return if path.join("Parameters.xml").is_file() { Kind::Trial } else { Kind::Directory };
        }
        if !there.is_file() {
            return Kind::Stream;
        }
        let mut begin = Vec::new();
        match input::open(path).and_then(|file| file.take(BEGIN).read_to_end(&mut begin)) {
            Ok(0) => Kind::Empty,
            Ok(_) => Kind::of_content(path, &begin),
            Err(_) => Kind::Unreadable,
        }
    }

    fn of_content(path: &Path, begin: &[u8]) -> Kind {
        const LIBRARIES: [&[u8]; 5] =
            [b"\x7fELF", b"MZ", b"\xcf\xfa\xed\xfe", b"\xce\xfa\xed\xfe", b"\xca\xfe\xba\xbe"];
        if begin.starts_with(b"PK") {
            return Kind::of_archive(path);
        }
        if begin.starts_with(b"PAR1") {
            return Kind::Parquet;
        }
        if LIBRARIES.iter().any(|magic| begin.starts_with(magic)) {
            return Kind::Library;
        }
        let text = match std::str::from_utf8(begin) {
            Ok(_) => true,
            // A character that the end cuts off.
            Err(error) => error.error_len().is_none(),
        };
        if text && !begin.contains(&0) { Kind::Text } else { Kind::Binary }
    }

    fn of_archive(path: &Path) -> Kind {
        let archive = input::open(path).ok().and_then(|file| ZipArchive::new(BufReader::new(file)).ok());
        let Some(archive) = archive else { return Kind::BrokenArchive };
        let marks =
            [(DESCRIPTION_FILE, Kind::Fmu), (STRUCTURE_FILE, Kind::Ssp), ("run.toml", Kind::SavedRun)];
        let found = marks.iter().find(|(name, _)| archive.index_for_name(name).is_some());
        found.map_or(Kind::Archive, |(_, kind)| *kind)
    }

    /// That a path leads to one of these kinds, or to what is found to be wrong when it is read.
    ///
    /// # Errors
    /// It does not; the text says what would be right.
    pub fn expect(path: &Path, kinds: &[Kind], wanted: &'static str) -> Result<(), Unexpected> {
        let kind = Kind::of(path);
        if kinds.contains(&kind) || kind == Kind::Unreadable {
            return Ok(());
        }
        Err(Unexpected { path: path.to_owned(), kind, wanted })
    }
}

/// A path leads to something else than what is wanted.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{}: {kind}{}", path.display(), if *kind == Kind::Missing { String::new() } else { format!(", not {wanted}") })]
pub struct Unexpected {
    /// As it was given.
    pub path: PathBuf,
    /// What is there.
    pub kind: Kind,
    /// What is wanted.
    pub wanted: &'static str,
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Kind::Missing => "there is no such file or directory",
            Kind::Unreadable => "cannot be read",
            Kind::Trial => "is a Trial directory",
            Kind::Directory => "is a directory without Parameters.xml",
            Kind::Stream => "is a pipe or a device",
            Kind::Empty => "is an empty file",
            Kind::Fmu => "is an FMU",
            Kind::Ssp => "is an SSP",
            Kind::SavedRun => "is a saved run",
            Kind::Archive => "is a zip archive",
            Kind::BrokenArchive => "is a damaged zip archive",
            Kind::Parquet => "is a table in Parquet",
            Kind::Library => "is a program or a library",
            Kind::Text => "is a text file",
            Kind::Binary => "is a binary file",
        })
    }
}
