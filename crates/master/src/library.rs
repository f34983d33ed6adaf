//! Whether a shared library can be loaded: it is for its platform, and whole.
//!
//! A loader maps the parts of a file that its headers speak of. Where the file ends before them, the program gets SIGBUS.

use object::elf::{EM_386, EM_AARCH64, EM_X86_64, FileHeader32, FileHeader64, SHT_GNU_VERNEED};
use object::read::elf::{FileHeader, ProgramHeader, SectionHeader};
use object::read::macho::{FatArch, MachOFatFile32, MachOFatFile64};
use object::{Architecture, BinaryFormat, Endianness, FileKind, Object, ObjectSegment, ReadCache, ReadRef};
use std::io;
use std::path::Path;

/// Why a file is not a shared library that can be loaded.
#[derive(Debug, thiserror::Error)]
pub enum LibraryError {
    /// It cannot be read.
    #[error("cannot be read")]
    Read(#[from] io::Error),
    /// It is something else, or for another platform.
    #[error("is not a shared library for {platform}")]
    Foreign {
        /// FMI's name.
        platform: String,
        /// If it is no library at all.
        source: Option<object::Error>,
    },
    /// It ends before its parts do.
    #[error("is cut off: {0}")]
    CutOff(String),
}

/// The file format and the processors of FMI's platforms.
const PLATFORMS: [(&str, BinaryFormat, &[Architecture]); 12] = {
    use Architecture::{Aarch64, I386, X86_64};
    use BinaryFormat::{Elf, MachO, Pe};
    [
        ("linux64", Elf, &[X86_64]),
        ("linux32", Elf, &[I386]),
        ("aarch64-linux", Elf, &[Aarch64]),
        ("x86_64-linux", Elf, &[X86_64]),
        ("x86-linux", Elf, &[I386]),
        ("win64", Pe, &[X86_64]),
        ("win32", Pe, &[I386]),
        ("x86_64-windows", Pe, &[X86_64]),
        ("x86-windows", Pe, &[I386]),
        // FMI 2.0 names no other platform for Macs.
        ("darwin64", MachO, &[X86_64, Aarch64]),
        ("aarch64-darwin", MachO, &[Aarch64]),
        ("x86_64-darwin", MachO, &[X86_64]),
    ]
};

/// How many libraries a Mac's file may hold; real ones have two or three.
const MOST_ARCHES: usize = 8;

/// A library; a Mac's file may hold several.
struct Part {
    format: BinaryFormat,
    processor: Architecture,
    /// What the file lacks.
    lacks: Option<String>,
}

/// Whether a file is a whole shared library for a platform of FMI; any platform that FMI does not know is fine.
///
/// # Errors
/// It is not; the text does not name the file.
pub fn check_library(path: &Path, platform: &str) -> Result<(), LibraryError> {
    let known = PLATFORMS.iter().find(|(name, ..)| *name == platform);
    let Some((_, format, processors)) = known else { return Ok(()) };
    let data = ReadCache::new(lemons_files::input::open(path)?);
    let foreign = |source| LibraryError::Foreign { platform: platform.to_owned(), source };
    let parts = parts(&data).map_err(|error| foreign(Some(error)))?;
    let fits = |part: &&Part| part.format == *format && processors.contains(&part.processor);
    match parts.iter().find(fits) {
        None => Err(foreign(None)),
        Some(Part { lacks: Some(what), .. }) => Err(LibraryError::CutOff(what.clone())),
        Some(_) => Ok(()),
    }
}

fn parts<'data>(data: impl ReadRef<'data>) -> object::Result<Vec<Part>> {
    match FileKind::parse(data)? {
        FileKind::MachOFat32 => {
            let file = MachOFatFile32::parse(data)?;
            file.arches().iter().take(MOST_ARCHES).map(|arch| part(arch.data(data)?)).collect()
        }
        FileKind::MachOFat64 => {
            let file = MachOFatFile64::parse(data)?;
            file.arches().iter().take(MOST_ARCHES).map(|arch| part(arch.data(data)?)).collect()
        }
        FileKind::Elf32 => Ok(vec![elf::<FileHeader32<Endianness>>(data)?]),
        FileKind::Elf64 => Ok(vec![elf::<FileHeader64<Endianness>>(data)?]),
        _ => Ok(vec![part(data)?]),
    }
}

fn part<'data>(data: impl ReadRef<'data>) -> object::Result<Part> {
    let file = object::File::parse(data)?;
    let ends = file.segments().enumerate().map(|(k, segment)| {
        let (begin, size) = segment.file_range();
        (format!("segment {k}"), begin.saturating_add(size))
    });
    Ok(Part { format: file.format(), processor: file.architecture(), lacks: lacks(data, ends) })
}

/// Not by `object::File`, which does not say what of a file is not there.
fn elf<'data, Header: FileHeader<Endian = Endianness>>(data: impl ReadRef<'data>) -> object::Result<Part> {
    let header = Header::parse(data)?;
    let endian = header.endian()?;
    let processor = match (header.e_machine(endian), header.is_class_64()) {
        (EM_X86_64, true) => Architecture::X86_64,
        (EM_386, false) => Architecture::I386,
        (EM_AARCH64, true) => Architecture::Aarch64,
        _ => Architecture::Unknown,
    };
    let table = |what: &str, begin: u64, count: u16, size: u16| {
        (what.to_owned(), begin.saturating_add(u64::from(count) * u64::from(size)))
    };
    let (programs, sections) = (header.e_phoff(endian).into(), header.e_shoff(endian).into());
    let tables = [
        table("the table of program headers", programs, header.e_phnum(endian), header.e_phentsize(endian)),
        table("the table of section headers", sections, header.e_shnum(endian), header.e_shentsize(endian)),
    ];
    let mut lacks = lacks(data, tables);
    if lacks.is_none() {
        let ends = header.program_headers(endian, data)?.iter().enumerate().map(|(k, program)| {
            let (begin, size): (u64, u64) =
                (program.p_offset(endian).into(), program.p_filesz(endian).into());
            (format!("segment {k}"), if size == 0 { 0 } else { begin.saturating_add(size) })
        });
        lacks = self::lacks(data, ends);
    }
    Ok(Part { format: BinaryFormat::Elf, processor, lacks })
}

/// \[byte\] The largest table of versions that is looked at; those of real libraries have some hundred bytes.
const LARGEST_VERSIONS: u64 = 10_000;

/// The glibc that a library needs (2.17: `[2, 17]`), by the versions of the functions that it uses; `None` if it needs
/// none, or is no library of Linux.
///
/// # Errors
/// It cannot be read, or its table of versions is broken.
pub fn glibc_needed(path: &Path) -> Result<Option<[u32; 2]>, GlibcError> {
    let data = ReadCache::new(lemons_files::input::open(path)?);
    match FileKind::parse(&data)? {
        FileKind::Elf32 => glibc_of::<FileHeader32<Endianness>>(&data),
        FileKind::Elf64 => glibc_of::<FileHeader64<Endianness>>(&data),
        _ => Ok(None),
    }
}

/// Why it is not known which glibc a library needs.
#[derive(Debug, thiserror::Error)]
pub enum GlibcError {
    /// It cannot be read.
    #[error("cannot be read")]
    Read(#[from] io::Error),
    /// It is broken.
    #[error("is broken: {0}")]
    Broken(#[from] object::Error),
    /// A table that no real library has.
    #[error("is broken: its table of versions has {0} bytes")]
    TooLarge(u64),
    /// A library has one table of versions.
    #[error("is broken: it has several tables of versions")]
    Several,
}

fn glibc_of<'data, Header: FileHeader<Endian = Endianness>>(
    data: impl ReadRef<'data>,
) -> Result<Option<[u32; 2]>, GlibcError> {
    let header = Header::parse(data)?;
    let endian = header.endian()?;
    let sections = header.sections(endian, data)?;
    let mut tables = sections.iter().filter(|section| section.sh_type(endian) == SHT_GNU_VERNEED);
    let Some(table) = tables.next() else { return Ok(None) };
    // Each of thousands of tables would be kept in memory.
    if tables.next().is_some() {
        return Err(GlibcError::Several);
    }
    let size = table.sh_size(endian).into();
    // Entries that lie within each other take a time that grows as the square of this.
    if size > LARGEST_VERSIONS {
        return Err(GlibcError::TooLarge(size));
    }
    let Some((needs, strings)) = table.gnu_verneed(endian, data)? else { return Ok(None) };
    let strings = sections.strings(endian, data, strings)?;
    let mut newest = None;
    for need in needs {
        for version in need?.1 {
            newest = newest.max(glibc_version(version?.name(endian, strings)?));
        }
    }
    Ok(newest)
}

/// The glibc in which a version of functions begins, such as `GLIBC_2.2.5`.
fn glibc_version(name: &[u8]) -> Option<[u32; 2]> {
    let name = std::str::from_utf8(name).ok()?.strip_prefix("GLIBC_")?;
    // The mark of relative relocations in short form.
    if name == "ABI_DT_RELR" {
        return Some([2, 36]);
    }
    let mut parts = name.split('.').map(|part| part.parse().ok());
    Some([parts.next()??, parts.next()??])
}

/// The first of a file's parts that ends behind the file.
fn lacks<'data>(data: impl ReadRef<'data>, ends: impl IntoIterator<Item = (String, u64)>) -> Option<String> {
    let length = data.len().unwrap_or(0);
    let mut ends = ends.into_iter();
    let (what, end) = ends.find(|(_, end)| *end > length)?;
    Some(format!("{what} ends at byte {end}, the file at byte {length}"))
}

#[cfg(test)]
mod tests {
    use super::super::own_binary;
    use super::*;
    use std::io::{Seek, SeekFrom, Write};
    use tempfile::TempDir;

    /// A loader that was given such a file got SIGBUS.
    #[test]
    fn a_cut_off_library_is_refused_at_every_length() {
        let binary = own_binary().unwrap();
        assert!(check_library(&binary.path, &binary.platform).is_ok());
        let whole = std::fs::read(&binary.path).unwrap();
        let directory = TempDir::new().unwrap();
        let path = directory.path().join("library");
        let lengths = [0, 1, 15, 16, 63, 64, 65, 500, 4096].into_iter();
        for length in lengths.chain((1..20).map(|k| whole.len() / 20 * k)).chain([whole.len() - 1]) {
            std::fs::write(&path, &whole[..length]).unwrap();
            let said = check_library(&path, &binary.platform).unwrap_err().to_string();
            let cut_off =
                said.starts_with("is cut off: ") && said.ends_with(&format!("the file at byte {length}"));
            let no_header = length <= 64 && said.starts_with("is not a shared library for ");
            assert!(cut_off || no_header, "{length}: {said}");
        }
    }

    #[test]
    fn versions_of_functions_name_a_glibc() {
        let of = |name: &str| glibc_version(name.as_bytes());
        assert_eq!(of("GLIBC_2.2.5"), Some([2, 2]));
        assert_eq!(of("GLIBC_2.34"), Some([2, 34]));
        assert_eq!(of("GLIBC_ABI_DT_RELR"), Some([2, 36]));
        for other in ["GLIBC_PRIVATE", "GLIBC_2", "GLIBC_2.x", "GLIBC_99999999999.1", "GCC_3.0", "", "GLIBC_"]
        {
            assert_eq!(of(other), None, "{other}");
        }
        assert!(Some([2, 4]) < Some([2, 17]) && None < Some([2, 2]));
    }

    /// As `objdump -T` counts them.
    #[test]
    fn the_glibc_of_our_own_library_is_that_of_its_functions() {
        let binary = own_binary().unwrap();
        if binary.platform != "linux64" {
            eprintln!("skipped: looks into a library of linux64");
            return;
        }
        let needed = glibc_needed(&binary.path).unwrap().unwrap();
        let tool = std::process::Command::new("objdump").arg("-T").arg(&binary.path).output();
        let Ok(tool) = tool else {
            eprintln!("skipped: there is no objdump");
            return;
        };
        let text = String::from_utf8(tool.stdout).unwrap();
        let words = text.split(|c: char| c.is_whitespace() || "()".contains(c));
        assert_eq!(words.filter_map(|word| glibc_version(word.as_bytes())).max(), Some(needed));
    }

    /// Whatever stands in the table: an answer or an error, and soon.
    #[test]
    fn a_broken_table_of_versions_is_an_error() {
        let binary = own_binary().unwrap();
        if binary.platform != "linux64" {
            eprintln!("skipped: looks into a library of linux64");
            return;
        }
        let whole = std::fs::read(&binary.path).unwrap();
        let word = |at: usize| u64::from_le_bytes(whole[at..at + 8].try_into().unwrap()) as usize;
        let count = usize::from(u16::from_le_bytes([whole[60], whole[61]]));
        let header = (0..count)
            .map(|k| word(40) + 64 * k)
            .find(|&at| whole[at + 4..at + 8] == SHT_GNU_VERNEED.0.to_le_bytes())
            .unwrap();
        let (table, size) = (word(header + 24), word(header + 32));
        let directory = TempDir::new().unwrap();
        let path = directory.path().join("library");
        std::fs::write(&path, &whole).unwrap();
        let mut file = std::fs::File::options().write(true).open(&path).unwrap();
        let mut write = move |at: usize, bytes: &[u8]| {
            file.seek(SeekFrom::Start(at as u64)).unwrap();
            file.write_all(bytes).unwrap();
        };
        let mut said = |at: usize, bytes: &[u8]| {
            write(at, bytes);
            let said = glibc_needed(&path).map_err(|error| error.to_string());
            write(at, &whole[at..at + bytes.len()]);
            said
        };
        for byte in table..table + size {
            for value in [0, 1, 0x7f, 0xff] {
                // No panic; most of them break it.
                let _ = said(byte, &[value]);
            }
        }
        // The first entry leads beyond the end.
        assert!(said(table + 12, &[0xff; 4]).unwrap_err().starts_with("is broken: "));
        let large = said(header + 32, &200_000_u64.to_le_bytes());
        assert_eq!(large.unwrap_err(), "is broken: its table of versions has 200000 bytes");
        // The next section says that it is one, too.
        let several = said(header + 64 + 4, &SHT_GNU_VERNEED.0.to_le_bytes());
        assert_eq!(several.unwrap_err(), "is broken: it has several tables of versions");
        // The names are those of a section that does not exist.
        assert!(said(header + 40, &[0xff; 4]).is_err());
        assert_eq!(said(0, &whole[..4]), Ok(glibc_needed(&binary.path).unwrap()), "as it was");
    }

    /// Without a table of sections, which stands at the end, the segments tell.
    #[test]
    fn a_segment_that_is_cut_off_is_named() {
        let binary = own_binary().unwrap();
        if binary.platform != "linux64" {
            eprintln!("skipped: looks into a library of linux64");
            return;
        }
        let mut bytes = std::fs::read(&binary.path).unwrap();
        bytes[40..48].fill(0);
        bytes[60..64].fill(0);
        let directory = TempDir::new().unwrap();
        let path = directory.path().join("library");
        std::fs::write(&path, &bytes).unwrap();
        check_library(&path, "linux64").unwrap();
        std::fs::write(&path, &bytes[..bytes.len() / 100]).unwrap();
        let said = check_library(&path, "linux64").unwrap_err().to_string();
        assert!(said.starts_with("is cut off: segment "), "{said}");
    }
}
