//! A zip -> a Trial; and the Trials that come with the lab.

use crate::Refused;
use crowd_mechanics::setup;
use lemons_files::input::Bounded;
use lemons_files::source::{Memory, Source};
use lemons_trial::{DRIVE_FILE, DriveTable, FileNames, Missed, Trial};
use std::io::{Cursor, Read as _};
use std::path::{Component, Path, PathBuf};
use zip::ZipArchive;

/// \[byte\] Largest upload.
pub const LARGEST_ZIP: usize = 50_000_000;
/// \[byte\] Largest content of an upload, unpacked.
pub const LARGEST_CONTENT: u64 = 500_000_000;
/// Most files in an upload.
pub const MOST_FILES: usize = 1000;
/// Most people in an upload.
pub const MOST_PEOPLE: usize = 20_000;

/// The Trials that come with the lab: name, and its files with their texts.
pub const EXAMPLES: [(&str, &[(&str, &str)]); 2] = [
    (
        "push",
        &[
            ("drive.csv", include_str!("../../../resources/Trial_push/drive.csv")),
            ("Parameters.xml", include_str!("../../../resources/Trial_push/Parameters.xml")),
            ("static/Materials.xml", include_str!("../../../resources/Trial_push/static/Materials.xml")),
            ("static/Geometry.xml", include_str!("../../../resources/Trial_push/static/Geometry.xml")),
            ("static/Agents.xml", include_str!("../../../resources/Trial_push/static/Agents.xml")),
            (
                "dynamic/AgentDynamics.xml",
                include_str!("../../../resources/Trial_push/dynamic/AgentDynamics.xml"),
            ),
        ],
    ),
    (
        "door",
        &[
            ("Parameters.xml", include_str!("../../../resources/Trial_door/Parameters.xml")),
            ("static/Materials.xml", include_str!("../../../resources/Trial_door/static/Materials.xml")),
            ("static/Geometry.xml", include_str!("../../../resources/Trial_door/static/Geometry.xml")),
            ("static/Agents.xml", include_str!("../../../resources/Trial_door/static/Agents.xml")),
            (
                "dynamic/AgentDynamics.xml",
                include_str!("../../../resources/Trial_door/dynamic/AgentDynamics.xml"),
            ),
        ],
    ),
];

/// A Trial, and the file that drives its people.
#[derive(Debug, Clone)]
pub struct Driven {
    /// The Trial.
    pub trial: Trial,
    /// Its drive.csv; empty if it has none.
    pub text: String,
    /// The same, read.
    pub drive: DriveTable,
}

/// What was read.
#[derive(Debug, Clone)]
pub struct Read {
    /// The Trial.
    pub driven: Driven,
    /// Warnings.
    pub notes: Vec<String>,
}

/// Returns one of [`EXAMPLES`].
///
/// # Errors
/// There is none with this name.
pub fn example(name: &str) -> Result<Read, Refused> {
    let known = EXAMPLES.iter().find(|example| example.0 == name);
    let (name, texts) = known.ok_or_else(|| Refused(format!("there is no example {name:?}")))?;
    let mut files = Memory::default();
    for (path, text) in *texts {
        files.put(&Path::new(name).join(path), text.as_bytes().to_vec());
    }
    read(&files, Path::new(name))
}

/// Reads the only Trial in a zip.
///
/// # Errors
/// It is no zip, it is too large, it holds no Trial or several, or the Trial has errors: all of them, with file, element,
/// attribute and value.
pub fn open(name: &str, bytes: &[u8]) -> Result<Read, Refused> {
    open_within(name, bytes, LARGEST_CONTENT)
}

/// As [`open`], of at most `largest` bytes, unpacked.
///
/// # Errors
/// Those of [`open`].
pub fn open_within(name: &str, bytes: &[u8], largest: u64) -> Result<Read, Refused> {
    let of_zip = |why: String| Refused(format!("{name}: {why}"));
    if bytes.len() > LARGEST_ZIP {
        return Err(of_zip(format!("it has more than {} MB", LARGEST_ZIP / 1_000_000)));
    }
    let mut archive = ZipArchive::new(Cursor::new(bytes)).map_err(|error| of_zip(error.to_string()))?;
    if archive.len() > MOST_FILES {
        return Err(of_zip(format!("it has more than {MOST_FILES} files")));
    }
    let mut files = Memory::default();
    let (mut left, mut unread) = (largest, Vec::new());
    for k in 0..archive.len() {
        let file = archive.by_index(k).map_err(|error| of_zip(error.to_string()))?;
        if !file.is_file() {
            continue;
        }
        let path = file.enclosed_name();
        let path = path.ok_or_else(|| of_zip(format!("the name {:?} leads out of it", file.name())))?;
        let is_xml = path.extension().is_some_and(|extension| extension == "xml");
        if !is_xml && path.file_name().is_none_or(|name| name != DRIVE_FILE) {
            unread.push(path);
            continue;
        }
        let mut content = Vec::new();
        Bounded::new(file, left)
            .read_to_end(&mut content)
            .map_err(|error| of_zip(format!("{}: {error}", path.display())))?;
        left -= content.len() as u64;
        files.put(&path, content);
    }
    let places: Vec<PathBuf> = files
        .paths()
        .filter(|path| path.file_name().is_some_and(|name| name == "Parameters.xml"))
        .map(|path| path.parent().unwrap_or(Path::new("")).to_owned())
        .collect();
    match places.as_slice() {
        [] => Err(of_zip("it has no Parameters.xml, so there is no Trial in it".into())),
        [place] => {
            let mut read = read(&files, place)?;
            let others = unread.iter().filter(|path| path.starts_with(place));
            let others: Vec<String> = others.map(|path| path.display().to_string()).collect();
            if !others.is_empty() {
                read.notes.push(format!("not used here, and not taken along: {}", others.join(", ")));
            }
            if !place.components().any(|part| matches!(part, Component::Normal(_))) {
                // Without a directory of its own, it is called as its zip.
                let stem = Path::new(name).file_stem().map(|stem| stem.to_string_lossy().into_owned());
                read.driven.trial.name = stem.unwrap_or_else(|| "Trial".into());
            }
            Ok(read)
        }
        several => {
            let names: Vec<String> = several.iter().map(|place| place.display().to_string()).collect();
            Err(of_zip(format!("there are several Trials in it: {}", names.join(", "))))
        }
    }
}

fn read(files: &Memory, place: &Path) -> Result<Read, Refused> {
    let (trial, warnings) = setup::read_from(files, place, &FileNames::default()).map_err(Refused::of)?;
    if trial.agents.len() > MOST_PEOPLE {
        let people = trial.agents.len();
        return Err(Refused(format!("{people} people are too many for a page: at most {MOST_PEOPLE}")));
    }
    let path = place.join(DRIVE_FILE);
    let (mut text, mut drive) = (String::new(), DriveTable::default());
    if !files.lacks(&path) {
        let bytes = files.read(&path, LARGEST_CONTENT).map_err(Refused::of)?;
        let checked = DriveTable::from_csv(&bytes[..])
            .and_then(|drive| drive.check_agents(Some(&trial)).map(|()| drive));
        drive = checked.map_err(|error| Refused::of(error.of_file(&path)))?;
        text = String::from_utf8(bytes).map_err(Refused::of)?;
    }
    let mut notes: Vec<String> = warnings.iter().map(ToString::to_string).collect();
    if let Some(missed) = drive.missed(0.0, trial.parameters.time_step) {
        let Missed { rows, of, shortest, .. } = missed;
        notes.push(format!(
            "{DRIVE_FILE}: {rows} of {of} rows lie between communication points and have no effect; a TimeStep of \
             {shortest} s would use all"
        ));
    }
    Ok(Read { driven: Driven { trial, text, drive }, notes })
}
