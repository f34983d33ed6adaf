//! An `.fmu`, or a zip of a Trial -> its files in a directory.

use crate::error::{ErrorPlace, Result, require};
use crate::ssp::{Allowance, STRUCTURE_FILE, ZipFile, open_zip, sound};
use crowd_mechanics::model_description::LARGEST_DESCRIPTION;
use lemons_core::files::make_directories;
use lemons_core::trial::{Problem, Problems};
use std::ffi::OsStr;
use std::fs::File;
use std::path::{Path, PathBuf};

/// The file that makes an archive an FMU.
pub(crate) const DESCRIPTION_FILE: &str = "modelDescription.xml";

/// Unpacks an FMU into a directory.
///
/// # Errors
/// No FMU, a broken one, one that leads outside of the directory, holds two files of one name, or is larger than the
/// allowance.
pub(crate) fn unzip(path: &Path, directory: &Path, allowance: &mut Allowance) -> Result<()> {
    let zip = open_zip(path)?;
    let [is_fmu, is_ssp] = [DESCRIPTION_FILE, STRUCTURE_FILE].map(|file| zip.index_for_name(file).is_some());
    require(is_fmu || !is_ssp, || "this is an SSP archive: lemons run FILE.ssp")?;
    require(is_fmu, || format!("it contains no {DESCRIPTION_FILE}, so it is not an FMU"))?;
    allowance.entries(zip.len())?;
    let mut zip = sound(zip)?;
    extract(&mut zip, directory, allowance, |_| true)?;
    let size = directory.join(DESCRIPTION_FILE).metadata()?.len();
    let most = LARGEST_DESCRIPTION / 1_000_000;
    let large = || format!("{DESCRIPTION_FILE}: is refused: more than {most} MB");
    Ok(require(size <= LARGEST_DESCRIPTION, large)?)
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
pub(crate) fn unzip_trial(path: &Path, directory: &Path) -> Result<Option<PathBuf>> {
    unzip_trial_within(path, directory, &mut Allowance::new(TRIAL))
}

fn unzip_trial_within(path: &Path, directory: &Path, allowance: &mut Allowance) -> Result<Option<PathBuf>> {
    let Ok(zip) = open_zip(path) else { return Ok(None) };
    if [DESCRIPTION_FILE, STRUCTURE_FILE].iter().any(|file| zip.index_for_name(file).is_some()) {
        return Ok(None);
    }
    let many = || format!("{} files are in it: no zip of a Trial", zip.len());
    require(zip.len() <= TRIAL_ENTRIES, many)?;
    let mut zip = sound(zip)?;
    let names = zip.file_names().map(|name| Ok(with_slashes(&name?)));
    let mut trials = names.collect::<Result<Vec<String>>>()?;
    trials.retain(|name| name.rsplit('/').next() == Some(PARAMETERS));
    trials.sort();
    if let [first, second, ..] = &trials[..] {
        let why =
            format!("several Trials are in it ({first:?}, {second:?}, …): unpack it and name one of them");
        return Err(why.into());
    }
    let none = || format!("it contains no {PARAMETERS}, so it is not a zip of a Trial");
    let parameters = trials.first().ok_or_else(none)?;
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
    zip: &mut ZipFile,
    directory: &Path,
    allowance: &mut Allowance,
    wanted: impl Fn(&str) -> bool,
) -> Result<()> {
    for place in 0..zip.len() {
        let entry = zip.by_index(place).place(|| format!("entry {place}"))?;
        let name = entry.name()?.into_owned();
        require(!entry.is_symlink(), || format!("the entry {name:?} is a link, which is not served"))?;
        let name = with_slashes(&name);
        if !wanted(&name) {
            continue;
        }
        let to = name.split('/').filter(|part| !matches!(*part, "" | "."));
        let to = to.fold(directory.to_owned(), |to, part| to.join(part));
        let unwritable = || format!("the entry {name:?} cannot be unpacked");
        if entry.is_dir() || name.ends_with('/') {
            make_directories(&to).place(unwritable)?;
            continue;
        }
        make_directories(to.parent().unwrap_or(directory)).place(unwritable)?;
        let mut file = File::create(&to).place(unwritable)?;
        allowance.copy(&name, entry, &mut file)?;
    }
    Ok(())
}

/// Returns problems of files in a directory with the names that they have where the user knows it.
pub(crate) fn renamed(problems: &Problems, directory: &Path, known: &Path) -> Problems {
    let mut renamed = Problems::default();
    for problem in problems.iter() {
        let inside = problem.file.strip_prefix(directory).map(|inside| known.join(inside));
        renamed.push(Problem { file: inside.unwrap_or_else(|_| problem.file.clone()), ..problem.clone() });
    }
    renamed
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write;
    use tempfile::TempDir;
    use zip::ZipWriter;
    use zip::write::SimpleFileOptions;

    const OPTIONS: fn() -> SimpleFileOptions = SimpleFileOptions::default;

    /// Returns what unpacking says of an archive as the zip of a Trial, or as an FMU: the content of a file, or the error.
    fn message(trial: bool, fill: impl Fn(&mut ZipWriter<File>)) -> String {
        let directory = TempDir::new().unwrap();
        let path = directory.path().join("box.zip");
        let mut zip = ZipWriter::new(File::create(&path).unwrap());
        fill(&mut zip);
        zip.finish().unwrap();
        let inside = directory.path().join("inside");
        std::fs::create_dir(&inside).unwrap();
        let allowance = &mut Allowance::new(1_000_000);
        let done = if trial {
            unzip_trial_within(&path, &inside, allowance)
        } else {
            unzip(&path, &inside, allowance).map(|()| Some(inside))
        };
        let beside = std::fs::read_dir(directory.path()).unwrap().count();
        assert_eq!(beside, 2, "nothing beside the directory");
        let text = |path: &Path| std::fs::read_to_string(path).unwrap_or_default();
        match done {
            Ok(None) => "no Trial".to_owned(),
            Ok(Some(fmu)) if !trial => text(&fmu.join("resources/a")),
            Ok(Some(trial)) => {
                let name = trial.file_name().unwrap().to_str().unwrap();
                format!("{name}: {}", text(&trial.join(PARAMETERS)))
            }
            Err(error) => error.whole(),
        }
    }

    fn add(zip: &mut ZipWriter<File>, name: &str, content: &[u8]) {
        zip.start_file(name, OPTIONS()).unwrap();
        zip.write_all(content).unwrap();
    }

    /// The same of files that hold a text.
    fn message_of(trial: bool, files: &[&str]) -> String {
        message(trial, |zip| files.iter().for_each(|file| add(zip, file, b"text")))
    }

    #[test]
    fn an_fmu_and_the_zip_of_a_trial_are_what_they_hold() {
        let fmu = |files: &[&str]| message_of(false, files);
        assert_eq!(fmu(&[DESCRIPTION_FILE, "resources/a"]), "text");
        assert_eq!(fmu(&["x"]), "it contains no modelDescription.xml, so it is not an FMU");
        assert_eq!(fmu(&[STRUCTURE_FILE]), "this is an SSP archive: lemons run FILE.ssp");
        let trial = |files: &[&str]| message_of(true, files);
        assert_eq!(trial(&["T/Parameters.xml", "T/static/Agents.xml", "__MACOSX/T/._Agents.xml"]), "T: text");
        assert_eq!(trial(&["a/T/Parameters.xml"]), "T: text");
        // Older archivers of Windows write backslashes.
        assert_eq!(trial(&["T\\Parameters.xml", "T\\static\\Agents.xml", ".\\T\\.\\drive.csv"]), "T: text");
        assert_eq!(trial(&["Parameters.xml", "static/Agents.xml"]), "box: text");
        // Its content may have the archive's name.
        assert_eq!(trial(&["Parameters.xml", "box/Agents.xml"]), "box: text");
        assert_eq!(trial(&["Parameters.xml", "box"]), "box: text");
        assert_eq!(trial(&["x", "y/z"]), "it contains no Parameters.xml, so it is not a zip of a Trial");
        let two = "several Trials are in it (\"T/Parameters.xml\", \"U/Parameters.xml\", …): unpack it and name one of them";
        assert_eq!(trial(&["T/Parameters.xml", "U/Parameters.xml"]), two);
        assert_eq!(trial(&["T/Parameters.xml", DESCRIPTION_FILE]), "no Trial");
    }

    /// Each of them beside what makes an archive an FMU, and a Trial.
    #[test]
    fn hostile_archives_are_refused() {
        for (trial, mark) in [(false, DESCRIPTION_FILE), (true, "T/Parameters.xml")] {
            let message = |fill: &dyn Fn(&mut ZipWriter<File>)| {
                message(trial, |zip| {
                    add(zip, mark, b"");
                    fill(zip);
                })
            };
            for name in ["../a", "T/../../a", "/a", "C:/a", "T\\..\\..\\a"] {
                let expected = format!("the entry {name:?} leads outside of the archive");
                assert_eq!(message(&|zip| add(zip, name, b"text")), expected);
            }
            let link = message(&|zip| zip.add_symlink("T/static", "/", OPTIONS()).unwrap());
            assert_eq!(link, "the entry \"T/static\" is a link, which is not served");
            // A small archive of a lot: as large together as the second alone.
            let zeros = vec![0; 1_000_001];
            for sizes in [[1, 1_000_000], [600_000, 400_001]] {
                let large = message(&|zip| {
                    add(zip, "T/a", &zeros[..sizes[0]]);
                    add(zip, "T/b", &zeros[..sizes[1]]);
                });
                assert_eq!(large, "T/b: is refused: more than 1 MB to unpack in all");
            }
        }
        let many = |count: usize, name: &str| {
            message(name != DESCRIPTION_FILE, |zip| {
                add(zip, name, b"");
                (0..count).for_each(|k| add(zip, &k.to_string(), b""));
            })
        };
        let expected = "it has too many entries: at most 20000 are unpacked in all";
        assert_eq!(many(Allowance::ENTRIES, DESCRIPTION_FILE), expected);
        assert_eq!(many(1000, "x"), "1001 files are in it: no zip of a Trial");
    }
}
