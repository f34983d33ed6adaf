//! A zip or a folder -> a Trial; and the Trials that come with the lab.

use crate::loaded::{LoadedTrial, UneditedTrial};
use crate::reply::{NO_PARAMETERS, NOT_TAKEN, TOO_MANY_PEOPLE};
use crate::{Refused, require};
use crowd_mechanics::setup;
use lemons_core::files::input::{self, Bounded};
use lemons_core::files::source::{FileSource, Memory};
use lemons_core::message::{Message, message};
use lemons_core::trial::{DRIVE_FILE, DriveTable, FileNames, Parameters, Problem};
use lemons_decision::DECISION_FILE;
use std::io::{Cursor, Read as _};
use std::path::{Component, Path, PathBuf};
use zip::ZipArchive;

/// \[byte\] Largest upload.
pub const LARGEST_UPLOAD: usize = 50_000_000;
/// \[byte\] Largest content of an upload, unpacked.
pub const LARGEST_CONTENT: u64 = 150_000_000;
/// Most files in an upload.
pub const MOST_FILES: usize = 1000;
/// Most people in an upload.
pub const MOST_PEOPLE: usize = 20_000;

/// The Trials that come with the lab: name, and its files with their texts.
pub const EXAMPLES: [(&str, &[(&str, &str)]); 1] = [(
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
)];

/// Returns one of [`EXAMPLES`].
///
/// # Errors
/// There is none with this name.
pub fn example(name: &str) -> Result<UneditedTrial, Refused> {
    let known = EXAMPLES.iter().find(|example| example.0 == name);
    let (name, texts) = known.ok_or_else(|| Refused::from(format!("there is no example {name:?}")))?;
    let mut files = Memory::default();
    for (path, text) in *texts {
        files.put(&Path::new(name).join(path), text.as_bytes().to_vec());
    }
    read(&files, Path::new(name), Vec::new())
}

/// Extension of scenarios.
const SCENARIO: &str = "toml";
/// Name of a scenario beside other such files.
const NAMED: &str = "scenario.toml";

/// Returns the path of the only scenario of an upload, and all its files; `None` if it is a Trial, or there is none.
///
/// # Errors
/// It is too large, or a name leads out of it.
pub fn scenario(name: &str, files: &[(&str, &[u8])]) -> Result<Option<(PathBuf, Memory)>, Refused> {
    let is_scenario = |path: &Path| {
        path.extension().is_some_and(|extension| extension == SCENARIO) && !path.ends_with(DECISION_FILE)
    };
    let is_trial =
        |(path, _): &(&str, _)| ["Agents.xml", "Parameters.xml"].iter().any(|file| path.ends_with(file));
    if files.iter().any(is_trial) {
        return Ok(None);
    }
    let found = files.iter().map(|(path, _)| Path::new(path)).filter(|path| is_scenario(path));
    let found: Vec<&Path> = found.collect();
    let path = match found[..] {
        [] => return Ok(None),
        [path] => path,
        ref several => *several.iter().find(|path| path.ends_with(NAMED)).ok_or_else(|| {
            Refused::from(format!("{name}: there are several .toml: call the scenario {NAMED}"))
        })?,
    };
    check(files).map_err(|why| Refused::from(format!("{name}: {why}")))?;
    let mut memory = Memory::default();
    files.iter().for_each(|(path, file)| memory.put(Path::new(path), file.to_vec()));
    Ok(Some((path.to_owned(), memory)))
}

/// Checks size, number and names of files.
fn check(files: &[(&str, &[u8])]) -> Result<(), String> {
    if files.iter().map(|(_, file)| file.len()).sum::<usize>() > LARGEST_UPLOAD {
        return Err(format!("it has more than {} MB", LARGEST_UPLOAD / 1_000_000));
    }
    few(files.len())?;
    let within = |path: &&str| Path::new(path).components().all(|part| matches!(part, Component::Normal(_)));
    match files.iter().map(|(path, _)| path).find(|path| !within(path)) {
        Some(path) => Err(format!("the name {path:?} leads out of it")),
        None => Ok(()),
    }
}

/// The files of an upload that the lab reads, and the paths of the others.
#[derive(Default)]
struct Content {
    files: Memory,
    others: Vec<PathBuf>,
}

impl Content {
    /// Takes a file, if the lab reads such.
    fn take(&mut self, path: &Path, read: impl FnOnce() -> Result<Vec<u8>, String>) -> Result<(), String> {
        let xml = path.extension().is_some_and(|extension| extension == "xml");
        if xml || path.ends_with(DRIVE_FILE) || path.ends_with(DECISION_FILE) {
            self.files.put(path, read()?);
        } else {
            self.others.push(path.to_owned());
        }
        Ok(())
    }

    /// Returns the directory of the file with this name, if there is one.
    ///
    /// # Errors
    /// There are several.
    fn place(&self, name: &str) -> Result<Option<PathBuf>, String> {
        let named = self.files.paths().filter(|path| path.ends_with(name));
        match named.filter_map(Path::parent).collect::<Vec<_>>()[..] {
            [] => Ok(None),
            [place] => Ok(Some(place.to_owned())),
            ref several => Err(format!("there are several Trials in it: {}", listed(several))),
        }
    }
}

fn listed(paths: &[impl AsRef<Path>]) -> String {
    paths.iter().map(|path| path.as_ref().display().to_string()).collect::<Vec<_>>().join(", ")
}

/// Reads the only Trial in a zip, or in the files of a folder. Without a Parameters.xml, as the published platform gives
/// it, the default steps are taken. Unpacked, it may have `largest` bytes, as [`LARGEST_CONTENT`].
///
/// # Errors
/// It is too large, it holds no Trial or several, or the Trial has errors: all of them, with file, element, attribute and
/// value.
pub fn open(name: &str, files: &[(&str, &[u8])], largest: u64) -> Result<UneditedTrial, Refused> {
    let wrong = |why: String| Refused::from(format!("{name}: {why}"));
    let mut content = content(files, largest).map_err(wrong)?;
    let (mut notes, parameters) = (Vec::new(), content.place("Parameters.xml").map_err(wrong)?);
    // Without a directory of its own, it is called as its zip.
    let nameless = parameters.as_ref().is_none_or(|place| place.as_os_str().is_empty());
    let place = match parameters {
        Some(place) => place,
        None => with_parameters(&mut content, &mut notes).map_err(wrong)?,
    };
    let others: Vec<_> = content.others.iter().filter(|path| path.starts_with(&place)).collect();
    if !others.is_empty() {
        notes.push(message!(NOT_TAKEN, files = listed(&others)));
    }
    let mut read = read(&content.files, &place, notes)?;
    if nameless {
        let stem = Path::new(name).file_stem().map(|stem| stem.to_string_lossy().into_owned());
        read.loaded.trial.name = stem.unwrap_or_else(|| "Trial".into());
    }
    Ok(read)
}

/// Returns the files in a zip, or those of a folder.
fn content(files: &[(&str, &[u8])], largest: u64) -> Result<Content, String> {
    check(files)?;
    if let [(path, zip)] = files
        && !path.ends_with(".xml")
    {
        return unzip(zip, largest);
    }
    let mut content = Content::default();
    for (path, file) in files {
        content.take(Path::new(path), || Ok(file.to_vec()))?;
    }
    Ok(content)
}

fn few(files: usize) -> Result<(), String> {
    if files > MOST_FILES { Err(format!("it has more than {MOST_FILES} files")) } else { Ok(()) }
}

fn unzip(zip: &[u8], largest: u64) -> Result<Content, String> {
    let mut archive = ZipArchive::new(Cursor::new(zip)).map_err(|error| format!("it is no zip: {error}"))?;
    few(archive.len())?;
    let (mut content, mut left) = (Content::default(), largest);
    for k in 0..archive.len() {
        let file = archive.by_index(k).map_err(|error| error.to_string())?;
        let path = file.enclosed_name().ok_or("a name in it leads out of it")?;
        if file.is_file() {
            content.take(&path, || {
                let mut bytes = Vec::new();
                let read = Bounded::new(file, left.min(input::LARGEST_TRIAL_FILE)).read_to_end(&mut bytes);
                left -= read.map_err(|error| format!("{}: {error}", path.display()))? as u64;
                Ok(bytes)
            })?;
        }
    }
    Ok(content)
}

/// \[s\] The communication step of a Trial that says none.
const TIME_STEP: f64 = 0.01;
/// \[s\] Its mechanical step: that of most crowds with the paper's materials.
const SHORT_STEP: f64 = 1e-4;

/// Adds the Parameters.xml of a Trial that has none, and returns its directory.
fn with_parameters(content: &mut Content, notes: &mut Vec<Message>) -> Result<PathBuf, String> {
    let only = |name: &str| {
        let none = || format!("it has no Parameters.xml and no {name}, so there is no Trial in it");
        content.place(name)?.ok_or_else(none)
    };
    let (fixed, moving) = (only("Agents.xml")?, only("AgentDynamics.xml")?);
    let common =
        fixed.ancestors().find(|above| moving.starts_with(above)).unwrap_or(Path::new("")).to_owned();
    let within = |path: &Path| {
        let path = path.strip_prefix(&common).unwrap_or(path);
        Path::new(".").join(path).display().to_string()
    };
    let parameters = Parameters {
        static_directory: within(&fixed),
        dynamic_directory: within(&moving),
        time_step: TIME_STEP,
        time_step_mechanical: SHORT_STEP,
    };
    content.files.put(&common.join("Parameters.xml"), parameters.xml().into_bytes());
    notes.push(message!(NO_PARAMETERS, step = TIME_STEP, mechanical = SHORT_STEP));
    Ok(common)
}

fn read(files: &Memory, place: &Path, mut notes: Vec<Message>) -> Result<UneditedTrial, Refused> {
    let (trial, warnings) = setup::read_from(files, place, &FileNames::default())?;
    let people = trial.agents.len();
    require(people <= MOST_PEOPLE, || message!(TOO_MANY_PEOPLE, people, most = MOST_PEOPLE))?;
    let text = |name: &str| {
        let path = place.join(name);
        if files.lacks(&path) {
            return Ok(String::new());
        }
        let bytes = files.read(&path, LARGEST_CONTENT)?;
        String::from_utf8(bytes).map_err(|error| Refused::from(format!("{}: {error}", path.display())))
    };
    let mut loaded = LoadedTrial {
        drive: text(DRIVE_FILE)?,
        decision: text(DECISION_FILE)?,
        ..LoadedTrial::alone(trial, None)
    };
    if !loaded.drive.is_empty() {
        let table = DriveTable::from_csv(loaded.drive.as_bytes())
            .and_then(|table| table.check_agents(Some(&loaded.trial)).map(|()| table));
        loaded.table = table.map_err(|error| error.of_file(&place.join(DRIVE_FILE)))?;
    }
    notes.extend(warnings.iter().map(Problem::told));
    Ok(UneditedTrial { loaded, notes, placing: None })
}
