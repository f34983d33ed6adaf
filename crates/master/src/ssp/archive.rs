//! The `.ssp`: a zip of `SystemStructure.ssd` and what it names.

use crate::ssp::allowance::Allowance;
use crate::ssp::document::{STRUCTURE_FILE, SystemStructure};
use crate::ssp::error::{Error, Result};
use crate::ssp::read::read;
use lemons_core::files::Staged;
use lemons_core::files::input;
use percent_encoding::percent_decode_str;
use std::collections::{HashMap, HashSet};
use std::fs::File;
use std::io::{BufReader, BufWriter, Read, Seek, SeekFrom, Write};
use std::path::Path;
use zip::result::ZipError;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipArchive, ZipWriter};

/// An archive that is being read.
pub struct Archive {
    zip: ZipArchive<BufReader<File>>,
}

impl Archive {
    /// Opens an archive whose entries all lie inside of it.
    ///
    /// # Errors
    /// No archive there, or one with too many entries, with an entry that leads outside, or with two of one name.
    pub fn open(path: &Path) -> Result<Archive> {
        let zip = ZipArchive::new(BufReader::new(input::open(path)?))?;
        Allowance::new(0).entries(zip.len())?;
        let zip = distinct(zip)?;
        for name in zip.file_names() {
            let name = name?;
            if leads_outside(&name) {
                return Err(Error::EntryOutside(name.into_owned()));
            }
        }
        Ok(Archive { zip })
    }

    /// The default structure, with the parameter files that it names.
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
        if names.iter().any(|name| leads_outside(name)) {
            return Err(Error::SourceOutside);
        }
        let name = names.iter().find(|name| self.zip.index_for_name(name).is_some());
        let name = name.ok_or_else(|| Error::Missing(names[0].clone()))?;
        let entry = self.zip.by_name(name)?;
        if !entry.is_file() {
            return Err(Error::NotAFile(name.clone()));
        }
        allowance.copy(name, entry, to)
    }
}

/// Of the name of an entry of an archive: absolute, with a drive, or with a step upwards.
pub fn leads_outside(name: &str) -> bool {
    let drive = name.as_bytes().get(1) == Some(&b':');
    drive || name.starts_with(['/', '\\']) || name.split(['/', '\\']).any(|part| part == "..")
}

/// An archive whose entries have different names, on every system: `A` and `./a` are one name. Of two entries with one
/// name, programs read one or the other.
///
/// # Errors
/// Two entries have one name; the text says which.
pub fn distinct<R: Read + Seek>(zip: ZipArchive<R>) -> Result<ZipArchive<R>> {
    let mut seen = HashMap::new();
    for name in zip.file_names() {
        let name = name?.into_owned();
        let plain = plain(&name);
        if let Some(other) = seen.insert(plain, name.clone()) {
            return Err(Error::OneName(other, name));
        }
    }
    // The reader keeps the last entry of a name only.
    if zip.has_duplicate_names() {
        let begin = zip.central_directory_start();
        let name = name_twice(zip.into_inner(), begin).map_err(Error::Entries)?;
        return Err(Error::NameTwice(name));
    }
    Ok(zip)
}

/// A name as a system without upper and lower case understands it.
fn plain(name: &str) -> String {
    let parts = name.split(['/', '\\']).filter(|part| !matches!(*part, "" | "."));
    parts.map(str::to_lowercase).collect::<Vec<_>>().join("/")
}

/// The first name that comes again in the list of the entries, which begins at a byte of the file.
fn name_twice(mut file: impl Read + Seek, begin: u64) -> std::io::Result<String> {
    let mut seen = HashSet::new();
    file.seek(SeekFrom::Start(begin))?;
    loop {
        // Its fixed part ends with the lengths of the name and of two more parts, then 14 bytes.
        let mut header = [0; 46];
        file.read_exact(&mut header)?;
        let length = |at: usize| u16::from_le_bytes([header[at], header[at + 1]]);
        let mut name = vec![0; length(28).into()];
        file.read_exact(&mut name)?;
        file.seek_relative(i64::from(length(30)) + i64::from(length(32)))?;
        if let Some(name) = seen.replace(name) {
            return Ok(String::from_utf8_lossy(&name).into_owned());
        }
    }
}

/// Writes an archive of a structure and files, each under its name in the archive. The same content gives the
/// same bytes.
///
/// # Errors
/// A file cannot be read, or the archive not written; the file at `path` is as it was then.
pub fn write_archive(path: &Path, structure: &SystemStructure, files: &[(String, &Path)]) -> Result<()> {
    let cannot = |source| Error::Write { path: path.to_owned(), source };
    let zip_cannot = |error: ZipError| cannot(error.into());
    let mut zip = ZipWriter::new(BufWriter::new(Staged::beside(path).map_err(cannot)?));
    let options =
        SimpleFileOptions::default().last_modified_time(DateTime::default()).unix_permissions(0o644);
    zip.start_file(STRUCTURE_FILE, options.compression_method(CompressionMethod::Deflated))
        .map_err(zip_cannot)?;
    zip.write_all(structure.to_xml().as_bytes()).map_err(cannot)?;
    for (name, file) in files {
        let unreadable = |source| Error::Read { path: file.to_path_buf(), source };
        let bytes = input::read(file, input::LARGEST_BINARY).map_err(unreadable)?;
        // FMUs are compressed already.
        let large = u32::try_from(bytes.len()).is_err();
        let options = options.compression_method(CompressionMethod::Stored).large_file(large);
        zip.start_file(name.as_str(), options).map_err(zip_cannot)?;
        zip.write_all(&bytes).map_err(cannot)?;
    }
    let file = zip.finish().map_err(zip_cannot)?.into_inner().map_err(|error| error.into_error());
    file.map_err(cannot)?.persist().map_err(cannot)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Cursor;

    fn said(names: &[&str], change: impl Fn(Vec<u8>) -> Vec<u8>) -> String {
        let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
        for name in names {
            zip.start_file(*name, SimpleFileOptions::default()).unwrap();
            zip.write_all(b"text").unwrap();
        }
        let bytes = change(zip.finish().unwrap().into_inner());
        let done = distinct(ZipArchive::new(Cursor::new(bytes)).unwrap());
        done.map_or_else(|error| error.to_string(), |zip| zip.len().to_string())
    }

    /// Of two entries with one name the last was taken, without a word.
    #[test]
    fn two_entries_of_one_name_are_refused_by_name() {
        let twice = |name: &'static str| {
            let other = name.replace('m', "n");
            said(&["x", name, &other, "y"], |bytes| {
                // The writer refuses to write it: it is made of another name.
                let (from, to) = (other.as_bytes(), name.as_bytes());
                let mut bytes = bytes;
                while let Some(at) = bytes.windows(from.len()).position(|text| text == from) {
                    bytes[at..at + to.len()].copy_from_slice(to);
                }
                bytes
            })
        };
        for name in ["modelDescription.xml", "SystemStructure.ssd-m", "T/Parameters.xml"] {
            assert_eq!(twice(name), format!("two entries have the name {name:?}"));
        }
        for (one, other) in [
            ("modelDescription.xml", "ModelDescription.XML"),
            ("modelDescription.xml", "./modelDescription.xml"),
            ("resources/a", "resources\\a"),
            ("resources/a", "resources//.\\A"),
            ("T", "T/"),
            ("\u{c4}", "\u{e4}"),
        ] {
            let refused = format!("the entries {one:?} and {other:?} have one name");
            assert_eq!(said(&[one, other], |bytes| bytes), refused);
        }
        assert_eq!(said(&["a", "a/b", "b", "a.b", "..."], |bytes| bytes), "5");
    }
}
