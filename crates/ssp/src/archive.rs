//! The `.ssp`: a zip of `SystemStructure.ssd` and what it names.

use crate::allowance::Allowance;
use crate::document::{STRUCTURE_FILE, SystemStructure};
use crate::read::read;
use anyhow::{Context, Result, bail};
use crowd_mechanics::files::Staged;
use percent_encoding::percent_decode_str;
use std::fs::File;
use std::io::{BufReader, BufWriter, Read, Write};
use std::path::Path;
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
    /// No archive there, or one with an entry that leads outside.
    pub fn open(path: &Path) -> Result<Archive> {
        let zip = ZipArchive::new(BufReader::new(File::open(path)?))?;
        for name in zip.file_names() {
            let name = name?;
            if leads_outside(&name) {
                bail!("the entry {name:?} leads outside of the archive");
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
            bail!("leads outside of the archive");
        }
        let name = names.iter().find(|name| self.zip.index_for_name(name).is_some());
        let name = name.with_context(|| format!("there is no {} in the archive", names[0]))?;
        let entry = self.zip.by_name(name)?;
        if !entry.is_file() {
            bail!("{name} is no file");
        }
        allowance.copy(name, entry, to)
    }
}

/// Of the name of an entry of an archive: absolute, with a drive, or with a step upwards.
pub fn leads_outside(name: &str) -> bool {
    let drive = name.as_bytes().get(1) == Some(&b':');
    drive || name.starts_with(['/', '\\']) || name.split(['/', '\\']).any(|part| part == "..")
}

/// Writes an archive of a structure and files, each under its name in the archive. The same content gives the
/// same bytes.
///
/// # Errors
/// A file cannot be read, or the archive not written; the file at `path` is as it was then.
pub fn write_archive(path: &Path, structure: &SystemStructure, files: &[(String, &Path)]) -> Result<()> {
    let cannot = || format!("cannot write {}", path.display());
    let mut zip = ZipWriter::new(BufWriter::new(Staged::beside(path).with_context(cannot)?));
    let options =
        SimpleFileOptions::default().last_modified_time(DateTime::default()).unix_permissions(0o644);
    zip.start_file(STRUCTURE_FILE, options.compression_method(CompressionMethod::Deflated))
        .with_context(cannot)?;
    zip.write_all(structure.to_xml().as_bytes()).with_context(cannot)?;
    for (name, file) in files {
        let unreadable = || format!("cannot read {}", file.display());
        let mut bytes = Vec::new();
        File::open(file).and_then(|mut file| file.read_to_end(&mut bytes)).with_context(unreadable)?;
        // FMUs are compressed already.
        let large = u32::try_from(bytes.len()).is_err();
        let options = options.compression_method(CompressionMethod::Stored).large_file(large);
        zip.start_file(name.as_str(), options).with_context(cannot)?;
        zip.write_all(&bytes).with_context(cannot)?;
    }
    let file = zip.finish().with_context(cannot)?.into_inner().map_err(|error| error.into_error());
    file.with_context(cannot)?.persist().with_context(cannot)
}
