//! An `.fmu`, or a zip of a Trial -> its files in a directory.

use crowd_mechanics::model_description::LARGEST_DESCRIPTION;
use lemons_files::{input, make_directories};
use lemons_ssp::{Allowance, STRUCTURE_FILE, distinct, leads_outside};
use std::ffi::OsStr;
use std::fs::File;
use std::io;
use std::io::BufReader;
use std::path::{Path, PathBuf};
use zip::ZipArchive;
use zip::result::ZipError;

/// What makes an archive an FMU.
pub(crate) const DESCRIPTION_FILE: &str = "modelDescription.xml";

/// Why an FMU or the zip of a Trial cannot be unpacked.
#[derive(Debug, thiserror::Error)]
pub enum UnzipError {
    /// It cannot be read, or its files cannot be written.
    #[error(transparent)]
    Io(#[from] io::Error),
    /// The archive is damaged.
    #[error(transparent)]
    Zip(#[from] ZipError),
    /// Two entries have one name, or it unpacks to too much.
    #[error(transparent)]
    Archive(#[from] lemons_ssp::Error),
    /// An SSP, and no FMU.
    #[error("this is an SSP archive")]
    Ssp,
    /// It contains no `modelDescription.xml`.
    #[error("it contains no {DESCRIPTION_FILE}, so it is not an FMU")]
    NotAnFmu,
    /// The model description is too large.
    #[error("{DESCRIPTION_FILE}: is refused: more than {} MB", LARGEST_DESCRIPTION / 1_000_000)]
    Description,
    /// It contains no `Parameters.xml`.
    #[error("it contains no {PARAMETERS}, so it is not a zip of a Trial")]
    NotATrial,
    /// More entries than a Trial has.
    #[error("{0} files are in it: no zip of a Trial")]
    Entries(usize),
    /// Which of them is meant?
    #[error("several Trials are in it ({first:?}, {second:?}, …): unpack it and name one of them")]
    Trials {
        /// Its `Parameters.xml`.
        first: String,
        /// Its `Parameters.xml`.
        second: String,
    },
    /// An entry cannot be read.
    #[error("entry {place}")]
    Entry {
        /// In the archive, from 0.
        place: usize,
        /// Why not.
        source: ZipError,
    },
    /// An entry would be written elsewhere.
    #[error("the entry {0:?} leads outside of the archive")]
    Outside(String),
    /// An entry is a symbolic link.
    #[error("the entry {0:?} is a link, which is not served")]
    Link(String),
    /// An entry cannot be written.
    #[error("the entry {name:?} cannot be unpacked")]
    Write {
        /// Of the entry.
        name: String,
        /// Why not.
        source: io::Error,
    },
}

type Result<T> = std::result::Result<T, UnzipError>;

/// Unpacks an FMU into a directory.
///
/// # Errors
/// No FMU, a broken one, one that leads outside of the directory, holds two files of one name, or is larger than the
/// allowance.
pub(crate) fn unzip(path: &Path, directory: &Path, allowance: &mut Allowance) -> Result<()> {
    let zip = ZipArchive::new(BufReader::new(input::open(path)?))?;
    if zip.index_for_name(DESCRIPTION_FILE).is_none() {
        if zip.index_for_name(STRUCTURE_FILE).is_some() {
            return Err(UnzipError::Ssp);
        }
        return Err(UnzipError::NotAnFmu);
    }
    allowance.entries(zip.len())?;
    let mut zip = distinct(zip)?;
    extract(&mut zip, directory, allowance, |_| true)?;
    let size = directory.join(DESCRIPTION_FILE).metadata()?.len();
    if size > LARGEST_DESCRIPTION {
        return Err(UnzipError::Description);
    }
    Ok(())
}

/// The file that makes a directory a Trial.
const PARAMETERS: &str = "Parameters.xml";

/// \[byte\] What a zip of a Trial may unpack to: ten times a Trial of 50 000 agents.
const TRIAL: u64 = 1_000_000_000;

/// Entries of a zip of a Trial: it has seven files.
const TRIAL_ENTRIES: usize = 1000;

/// Unpacks the zip of a Trial into a directory, and returns where the Trial is; `None` if the file is not such a zip: no
/// zip, an FMU, an SSP.
///
/// # Errors
/// None or several Trials in it, or it is broken, leads outside of the directory, holds two files of one name or is too
/// large.
pub fn unzip_trial(path: &Path, directory: &Path) -> Result<Option<PathBuf>> {
    unzip_trial_within(path, directory, &mut Allowance::new(TRIAL))
}

fn unzip_trial_within(path: &Path, directory: &Path, allowance: &mut Allowance) -> Result<Option<PathBuf>> {
    // Opening a FIFO would block.
    if !path.is_file() {
        return Ok(None);
    }
    let Ok(zip) = ZipArchive::new(BufReader::new(input::open(path)?)) else { return Ok(None) };
    if [DESCRIPTION_FILE, STRUCTURE_FILE].iter().any(|file| zip.index_for_name(file).is_some()) {
        return Ok(None);
    }
    if zip.len() > TRIAL_ENTRIES {
        return Err(UnzipError::Entries(zip.len()));
    }
    let mut zip = distinct(zip)?;
    let names = zip.file_names().map(|name| Ok(with_slashes(&name?)));
    let mut trials = names.collect::<Result<Vec<String>>>()?;
    trials.retain(|name| name.rsplit('/').next() == Some(PARAMETERS));
    trials.sort();
    let parameters = match &trials[..] {
        [] => return Err(UnzipError::NotATrial),
        [one] => one,
        [first, second, ..] => {
            return Err(UnzipError::Trials { first: first.clone(), second: second.clone() });
        }
    };
    // What an archiver adds beside the Trial is no part of it.
    let root = parameters.strip_suffix(PARAMETERS).unwrap_or_default().to_owned();
    // Without a directory of its own it has the archive's name.
    let name = path.file_stem().unwrap_or(OsStr::new("Trial"));
    let to = if root.is_empty() { directory.join(name) } else { directory.to_owned() };
    extract(&mut zip, &to, allowance, |name| name.starts_with(&root))?;
    Ok(Some(to.join(root)))
}

/// The name of an entry as the format wants it: older archivers of Windows write backslashes.
fn with_slashes(name: &str) -> String {
    name.replace('\\', "/")
}

/// Unpacks the files that are wanted, by their names [`with_slashes`]; looks at all of them.
fn extract(
    zip: &mut ZipArchive<BufReader<File>>,
    directory: &Path,
    allowance: &mut Allowance,
    wanted: impl Fn(&str) -> bool,
) -> Result<()> {
    for place in 0..zip.len() {
        let entry = zip.by_index(place).map_err(|source| UnzipError::Entry { place, source })?;
        let name = entry.name()?.into_owned();
        if entry.enclosed_name().is_none() || leads_outside(&name) {
            return Err(UnzipError::Outside(name));
        }
        if entry.is_symlink() {
            return Err(UnzipError::Link(name));
        }
        let name = with_slashes(&name);
        if !wanted(&name) {
            continue;
        }
        let to = name.split('/').filter(|part| !matches!(*part, "" | "."));
        let to = to.fold(directory.to_owned(), |to, part| to.join(part));
        let unwritable = |source| UnzipError::Write { name: name.clone(), source };
        if entry.is_dir() || name.ends_with('/') {
            make_directories(&to).map_err(unwritable)?;
            continue;
        }
        make_directories(to.parent().unwrap_or(directory)).map_err(unwritable)?;
        let mut file = File::create(&to).map_err(unwritable)?;
        allowance.copy(&name, entry, &mut file)?;
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
            Err(error) => error.to_string(),
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

    /// What unpacking the zip of a Trial says, or the Trial's directory and its file.
    fn said_of_trial(fill: impl FnOnce(&mut ZipWriter<File>)) -> String {
        let directory = TempDir::new().unwrap();
        let path = directory.path().join("box.zip");
        let mut zip = ZipWriter::new(File::create(&path).unwrap());
        fill(&mut zip);
        zip.finish().unwrap();
        let inside = directory.path().join("inside");
        std::fs::create_dir(&inside).unwrap();
        let found = unzip_trial_within(&path, &inside, &mut Allowance::new(1_000_000));
        assert_eq!(std::fs::read_dir(directory.path()).unwrap().count(), 2, "nothing beside the directory");
        match found {
            Ok(None) => "no Trial".to_owned(),
            Ok(Some(trial)) => {
                let name = trial.file_name().unwrap().to_str().unwrap();
                format!("{name}: {}", std::fs::read_to_string(trial.join(PARAMETERS)).unwrap())
            }
            Err(error) => error.to_string(),
        }
    }

    #[test]
    fn a_zip_of_a_trial_holds_one() {
        let of = |files: &[&str]| said_of_trial(|zip| files.iter().for_each(|file| add(zip, file, b"text")));
        assert_eq!(of(&["T/Parameters.xml", "T/static/Agents.xml", "__MACOSX/T/._Agents.xml"]), "T: text");
        assert_eq!(of(&["a/T/Parameters.xml"]), "T: text");
        assert_eq!(of(&["Parameters.xml", "static/Agents.xml"]), "box: text");
        // Its content may have the archive's name.
        assert_eq!(of(&["Parameters.xml", "box/Agents.xml"]), "box: text");
        assert_eq!(of(&["Parameters.xml", "box"]), "box: text");
        assert_eq!(of(&["x", "y/z"]), "it contains no Parameters.xml, so it is not a zip of a Trial");
        let two = "several Trials are in it (\"T/Parameters.xml\", \"U/Parameters.xml\", …): unpack it and name one of them";
        assert_eq!(of(&["T/Parameters.xml", "U/Parameters.xml"]), two);
        assert_eq!(of(&["T/Parameters.xml", DESCRIPTION_FILE]), "no Trial");
    }

    /// It was recognised, but then it was looked for in another place.
    #[test]
    fn a_zip_with_backslashes_is_the_same_trial() {
        let directory = TempDir::new().unwrap();
        let (path, inside) = (directory.path().join("x.zip"), directory.path().join("inside"));
        let mut zip = ZipWriter::new(File::create(&path).unwrap());
        zip.add_directory("T\\dynamic\\", OPTIONS()).unwrap();
        for name in ["T\\Parameters.xml", "T\\static\\Agents.xml", ".\\T\\.\\drive.csv"] {
            add(&mut zip, name, b"text");
        }
        zip.finish().unwrap();
        std::fs::create_dir(&inside).unwrap();
        let trial = unzip_trial(&path, &inside).unwrap().unwrap();
        assert_eq!(trial, inside.join("T"));
        assert!(trial.join("dynamic").is_dir());
        for file in ["Parameters.xml", "static/Agents.xml"] {
            assert_eq!(std::fs::read_to_string(trial.join(file)).unwrap(), "text");
        }
    }

    #[test]
    fn an_archive_of_too_many_entries_is_refused() {
        let many = said(
            |zip| {
                add(zip, DESCRIPTION_FILE, b"");
                (0..Allowance::ENTRIES).for_each(|k| add(zip, &k.to_string(), b""));
            },
            100,
        );
        assert_eq!(many, "it has too many entries: at most 20000 are unpacked in all");
    }

    #[test]
    fn hostile_zips_of_trials_are_refused() {
        for name in ["../a", "T/../../a", "/a", "C:/a", "T\\..\\..\\a", "../Parameters.xml"] {
            let said = said_of_trial(|zip| {
                if name != "../Parameters.xml" {
                    add(zip, "T/Parameters.xml", b"");
                }
                add(zip, name, b"text");
            });
            assert_eq!(said, format!("the entry {name:?} leads outside of the archive"));
        }
        let said = said_of_trial(|zip| {
            add(zip, "T/Parameters.xml", b"");
            zip.add_symlink("T/static", "/", OPTIONS()).unwrap();
        });
        assert_eq!(said, "the entry \"T/static\" is a link, which is not served");
        let said = said_of_trial(|zip| (0..1001).for_each(|k| add(zip, &k.to_string(), b"")));
        assert_eq!(said, "1001 files are in it: no zip of a Trial");
        // A small archive of a lot.
        let zeros = vec![0; 1 << 20];
        let said = said_of_trial(|zip| {
            add(zip, "T/Parameters.xml", b"");
            zip.start_file("T/static/Agents.xml", OPTIONS()).unwrap();
            zip.write_all(&zeros).unwrap();
        });
        assert_eq!(said, "T/static/Agents.xml: is refused: more than 1 MB to unpack in all");
    }

    #[test]
    fn two_files_of_one_name_are_refused() {
        let said = [
            said(
                |zip| [DESCRIPTION_FILE, "ModelDescription.xml"].iter().for_each(|name| add(zip, name, b"")),
                9,
            ),
            said_of_trial(|zip| {
                ["T/Parameters.xml", "T\\parameters.xml"].iter().for_each(|name| add(zip, name, b""));
            }),
        ];
        let expected = [
            "the entries \"modelDescription.xml\" and \"ModelDescription.xml\" have one name",
            "the entries \"T/Parameters.xml\" and \"T\\\\parameters.xml\" have one name",
        ];
        assert_eq!(said, expected);
    }

    #[test]
    fn what_is_no_fmu_is_called_what_it_is() {
        assert_eq!(
            said(|zip| add(zip, "x", b""), 100),
            "it contains no modelDescription.xml, so it is not an FMU"
        );
        assert_eq!(said(|zip| add(zip, STRUCTURE_FILE, b""), 100), "this is an SSP archive");
    }
}
