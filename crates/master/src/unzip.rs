//! An `.fmu` -> its files in a directory.
//!
//! Not `fmi_rs::zip`, which unpacks without a bound and leaves out, without a word, what leads outside.

use anyhow::{Context, Result, anyhow, bail};
use crowd_mechanics::model_description::LARGEST_DESCRIPTION;
use lemons_ssp::{Allowance, STRUCTURE_FILE, leads_outside};
use std::fs::{File, create_dir_all};
use std::io::BufReader;
use std::path::Path;
use zip::ZipArchive;

/// What makes an archive an FMU.
pub(crate) const DESCRIPTION_FILE: &str = "modelDescription.xml";

/// Unpacks an FMU into a directory.
///
/// # Errors
/// No FMU, a broken one, one that leads outside of the directory, or one larger than the allowance.
pub(crate) fn unzip(path: &Path, directory: &Path, allowance: &mut Allowance) -> Result<()> {
    let mut zip = ZipArchive::new(BufReader::new(File::open(path)?))?;
    if zip.index_for_name(DESCRIPTION_FILE).is_none() {
        if zip.index_for_name(STRUCTURE_FILE).is_some() {
            bail!("this is an SSP archive: lemons run FILE.ssp");
        }
        bail!("there is no {DESCRIPTION_FILE} in it: no FMU");
    }
    for place in 0..zip.len() {
        let entry = zip.by_index(place).with_context(|| format!("entry {place}"))?;
        let name = entry.name()?.into_owned();
        let inside = entry.enclosed_name().filter(|_| !leads_outside(&name));
        let inside = inside.ok_or_else(|| anyhow!("the entry {name:?} leads outside of the archive"))?;
        let to = directory.join(inside);
        if entry.is_symlink() {
            bail!("the entry {name:?} is a link, which is not served");
        }
        let unwritable = || format!("the entry {name:?} cannot be unpacked");
        if entry.is_dir() {
            create_dir_all(&to).with_context(unwritable)?;
            continue;
        }
        create_dir_all(to.parent().unwrap_or(directory)).with_context(unwritable)?;
        let mut file = File::create(&to).with_context(unwritable)?;
        allowance.copy(&name, entry, &mut file)?;
        if name == DESCRIPTION_FILE && file.metadata()?.len() > LARGEST_DESCRIPTION {
            bail!("{name}: is refused: more than {} MB", LARGEST_DESCRIPTION / 1_000_000);
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write;
    use tempfile::TempDir;
    use zip::ZipWriter;
    use zip::write::SimpleFileOptions;

    const OPTIONS: fn() -> SimpleFileOptions = SimpleFileOptions::default;

    fn said(fill: impl FnOnce(&mut ZipWriter<File>), limit: u64) -> String {
        let directory = TempDir::new().unwrap();
        let path = directory.path().join("x.fmu");
        let mut zip = ZipWriter::new(File::create(&path).unwrap());
        fill(&mut zip);
        zip.finish().unwrap();
        let inside = directory.path().join("inside");
        std::fs::create_dir(&inside).unwrap();
        let done = unzip(&path, &inside, &mut Allowance::new(limit));
        assert_eq!(std::fs::read_dir(directory.path()).unwrap().count(), 2, "nothing beside the directory");
        match done {
            Ok(()) => std::fs::read_to_string(inside.join("resources/a")).unwrap(),
            Err(error) => format!("{error:#}"),
        }
    }

    fn add(zip: &mut ZipWriter<File>, name: &str, content: &[u8]) {
        zip.start_file(name, OPTIONS()).unwrap();
        zip.write_all(content).unwrap();
    }

    #[test]
    fn files_lie_where_the_archive_says() {
        let said = said(
            |zip| {
                add(zip, DESCRIPTION_FILE, b"");
                zip.add_directory("resources", OPTIONS()).unwrap();
                add(zip, "resources/a", b"text");
            },
            4,
        );
        assert_eq!(said, "text");
    }

    #[test]
    fn a_small_archive_of_a_lot_is_refused() {
        let zeros = vec![0; 1_000_001];
        // As large together as the second alone.
        for sizes in [[1, 1_000_000], [600_000, 400_001]] {
            let said = said(
                |zip| {
                    add(zip, DESCRIPTION_FILE, b"");
                    add(zip, "a", &zeros[..sizes[0]]);
                    add(zip, "resources/a", &zeros[..sizes[1]]);
                },
                1_000_000,
            );
            assert_eq!(said, "resources/a: is refused: more than 1 MB to unpack in all");
        }
    }

    #[test]
    fn what_leads_outside_is_refused_by_name() {
        for name in ["../a", "resources/../../a", "/a", "C:/a", "resources\\..\\..\\a"] {
            let said = said(
                |zip| {
                    add(zip, DESCRIPTION_FILE, b"");
                    add(zip, name, b"text");
                },
                100,
            );
            assert_eq!(said, format!("the entry {name:?} leads outside of the archive"));
        }
        let said = said(
            |zip| {
                add(zip, DESCRIPTION_FILE, b"");
                zip.add_symlink("resources", "/", OPTIONS()).unwrap();
            },
            100,
        );
        assert_eq!(said, "the entry \"resources\" is a link, which is not served");
    }

    #[test]
    fn what_is_no_fmu_is_called_what_it_is() {
        assert_eq!(said(|zip| add(zip, "x", b""), 100), "there is no modelDescription.xml in it: no FMU");
        assert_eq!(
            said(|zip| add(zip, STRUCTURE_FILE, b""), 100),
            "this is an SSP archive: lemons run FILE.ssp"
        );
    }
}
