//! The `.ssp`: a zip of `SystemStructure.ssd` and what it names; how much may be unpacked.

use crate::error::{ErrorPlace, Result, require};
use crate::ssp::document::{STRUCTURE_FILE, SystemStructure};
use crate::ssp::read::read;
use lemons_core::files::{Staged, input};
use percent_encoding::percent_decode_str;
use std::collections::HashMap;
use std::fs::File;
use std::io::{self, BufReader, BufWriter, Read, Seek, Write};
use std::path::Path;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipArchive, ZipWriter};

/// A zip on a disk.
pub(crate) type ZipFile = ZipArchive<BufReader<File>>;

/// Opens a zip; [`sound`] looks at its entries.
pub(crate) fn open_zip(path: &Path) -> Result<ZipFile> {
    Ok(ZipArchive::new(BufReader::new(input::open(path)?))?)
}

/// How much archives may still unpack to: a small one can hold a lot of zeros, and the sizes that it declares
/// need not be true.
#[derive(Debug)]
pub struct Allowance {
    left: u64,
    limit: u64,
    entries: usize,
}

impl Allowance {
    /// \[byte\] Of the structure and the parameter files of an archive, which are held in memory: twice
    /// what two FMUs of 10 000 agents take.
    pub const STRUCTURE: u64 = 64_000_000;
    /// \[byte\] Of all FMUs of a run, which are unpacked on disk.
    pub const FMUS: u64 = 4_000_000_000;

    /// Number of the entries of all archives: each becomes a file or a directory. An FMU that contains Python has some
    /// thousands.
    pub const ENTRIES: usize = 20_000;

    /// So many bytes, and [`Allowance::ENTRIES`].
    pub fn new(limit: u64) -> Allowance {
        Allowance { left: limit, limit, entries: Allowance::ENTRIES }
    }

    /// Takes the entries of an archive.
    ///
    /// # Errors
    /// There are more than are left.
    pub fn entries(&mut self, count: usize) -> Result<()> {
        let most = Allowance::ENTRIES;
        let many = || format!("it has too many entries: at most {most} are unpacked in all");
        self.entries = self.entries.checked_sub(count).ok_or_else(many)?;
        Ok(())
    }

    /// Copies an entry until nothing is left of the allowance.
    ///
    /// # Errors
    /// The entry is broken, its copy cannot be written, or it is too large.
    pub fn copy(&mut self, name: &str, entry: impl Read, to: &mut impl Write) -> Result<()> {
        // One byte more tells too large from just fitting.
        let mut entry = entry.take(self.left.saturating_add(1));
        let copied = io::copy(&mut entry, to).place(|| name.to_owned())?;
        let most = self.limit as f64 / 1e6;
        let large = || format!("{name}: is refused: more than {most} MB to unpack in all");
        self.left = self.left.checked_sub(copied).ok_or_else(large)?;
        Ok(())
    }
}

/// An archive that is being read.
pub struct ArchiveReader {
    zip: ZipFile,
}

impl ArchiveReader {
    /// Opens an archive whose entries all lie inside of it.
    ///
    /// # Errors
    /// No archive there, or one with too many entries, with an entry that leads outside, or with two of one name.
    pub fn open(path: &Path) -> Result<ArchiveReader> {
        let zip = open_zip(path)?;
        Allowance::new(0).entries(zip.len())?;
        Ok(ArchiveReader { zip: sound(zip)? })
    }

    /// Reads the default structure, with the parameter files that it names.
    ///
    /// # Errors
    /// There is none, it is broken, or it holds what is not served.
    pub fn structure(&mut self) -> Result<SystemStructure> {
        let mut allowance = Allowance::new(Allowance::STRUCTURE);
        let mut load = |source: &str| {
            let mut bytes = Vec::new();
            self.copy(source, &mut bytes, &mut allowance)?;
            Ok(bytes)
        };
        let bytes = load(STRUCTURE_FILE)?;
        read(&bytes, &mut load)
    }

    /// Copies out a file that the structure names by a relative URI.
    ///
    /// # Errors
    /// There is no such file, it is broken, or larger than the allowance.
    pub fn copy(&mut self, source: &str, to: &mut impl Write, allowance: &mut Allowance) -> Result<()> {
        let decoded = percent_decode_str(source).decode_utf8_lossy();
        // Some tools do not encode: there a percent sign is itself.
        let names = [decoded.as_ref(), source].map(|name| name.trim_start_matches("./").to_owned());
        let outside = names.iter().any(|name| leads_outside(name));
        require(!outside, || "leads outside of the archive")?;
        let name = names.iter().find(|name| self.zip.index_for_name(name).is_some());
        let name = name.ok_or_else(|| format!("there is no {} in the archive", names[0]))?;
        let entry = self.zip.by_name(name)?;
        require(entry.is_file(), || format!("{name} is not a file"))?;
        allowance.copy(name, entry, to)
    }
}

/// Returns whether the name of an entry leads outside: absolute, with a drive, or with a step upwards.
fn leads_outside(name: &str) -> bool {
    let drive = name.as_bytes().get(1) == Some(&b':');
    drive || name.starts_with(['/', '\\']) || name.split(['/', '\\']).any(|part| part == "..")
}

/// Checks that the entries of an archive all lie inside of it, and have different names on every system: `A` and `./a` are one name.
/// Programs read, of two entries with one name, one or the other.
///
/// # Errors
/// An entry leads outside, or two have one name; the text says which.
pub fn sound<R: Read + Seek>(zip: ZipArchive<R>) -> Result<ZipArchive<R>> {
    let mut seen = HashMap::new();
    for name in zip.file_names() {
        let name = name?.into_owned();
        require(!leads_outside(&name), || format!("the entry {name:?} leads outside of the archive"))?;
        if let Some(other) = seen.insert(plain(&name), name.clone()) {
            return Err(format!("the entries {other:?} and {name:?} have one name").into());
        }
    }
    // The reader keeps the last entry of a name only.
    require(!zip.has_duplicate_names(), || "two entries have the same name")?;
    Ok(zip)
}

/// Returns a name as a system without upper and lower case understands it.
fn plain(name: &str) -> String {
    let parts = name.split(['/', '\\']).filter(|part| !matches!(*part, "" | "."));
    parts.map(str::to_lowercase).collect::<Vec<_>>().join("/")
}

/// Returns the options of an entry that has the same bytes whenever it is written.
pub(crate) fn entry(method: CompressionMethod) -> SimpleFileOptions {
    let options = SimpleFileOptions::default().compression_method(method);
    options.last_modified_time(DateTime::default()).unix_permissions(0o644)
}

/// Writes an archive of a structure and files, each under its name in the archive. The same content gives the
/// same bytes.
///
/// # Errors
/// A file cannot be read, or the archive not written; the file at `path` is as it was then.
pub fn write_archive(path: &Path, structure: &str, files: &[(String, &Path)]) -> Result<()> {
    let cannot = || format!("cannot write {}", path.display());
    let mut zip = ZipWriter::new(BufWriter::new(Staged::beside(path).place(cannot)?));
    zip.start_file(STRUCTURE_FILE, entry(CompressionMethod::Deflated)).place(cannot)?;
    zip.write_all(structure.as_bytes()).place(cannot)?;
    for (name, file) in files {
        let bytes =
            input::read(file, input::LARGEST_BINARY).place(|| format!("cannot read {}", file.display()))?;
        // FMUs are compressed already.
        let large = u32::try_from(bytes.len()).is_err();
        let options = entry(CompressionMethod::Stored).large_file(large);
        zip.start_file(name.as_str(), options).place(cannot)?;
        zip.write_all(&bytes).place(cannot)?;
    }
    let file = zip.finish().place(cannot)?.into_inner().map_err(|error| error.into_error());
    file.place(cannot)?.persist().place(cannot)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Cursor;

    fn message(names: &[&str], change: impl Fn(Vec<u8>) -> Vec<u8>) -> String {
        let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
        for name in names {
            zip.start_file(*name, SimpleFileOptions::default()).unwrap();
        }
        let bytes = change(zip.finish().unwrap().into_inner());
        let done = sound(ZipArchive::new(Cursor::new(bytes)).unwrap());
        done.map_or_else(|error| error.to_string(), |zip| zip.len().to_string())
    }

    /// The last of two entries with one name was taken, without a word.
    #[test]
    fn two_entries_of_one_name_are_refused_by_name() {
        // The writer refuses to write it: it is made of another name.
        let twice = message(&["x", "model.xml", "nodel.xml", "y"], |mut bytes| {
            while let Some(at) = bytes.windows(5).position(|text| text == b"nodel") {
                bytes[at] = b'm';
            }
            bytes
        });
        assert_eq!(twice, "two entries have the same name");
        for (one, other) in [
            ("modelDescription.xml", "ModelDescription.XML"),
            ("modelDescription.xml", "./modelDescription.xml"),
            ("resources/a", "resources\\a"),
            ("resources/a", "resources//.\\A"),
            ("T", "T/"),
            ("\u{c4}", "\u{e4}"),
        ] {
            let refused = format!("the entries {one:?} and {other:?} have one name");
            assert_eq!(message(&[one, other], |bytes| bytes), refused);
        }
        assert_eq!(message(&["a", "a/b", "b", "a.b", "..."], |bytes| bytes), "5");
    }
}
