//! A zip or a folder -> a Trial; and the Trials that come with the lab.

use crate::base::{Basis, Driven};
use crate::{Refused, require};
use crowd_mechanics::setup;
use lemons_core::files::input::{self, Bounded};
use lemons_core::files::source::{Memory, Source};
use lemons_core::trial::{DRIVE_FILE, DriveTable, FileNames, Parameters};
use lemons_decision::DECISION_FILE;
use serde_json::Value;
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
pub fn example(name: &str) -> Result<Basis, Refused> {
    let known = EXAMPLES.iter().find(|example| example.0 == name);
    let (name, texts) = known.ok_or_else(|| Refused(format!("there is no example {name:?}")))?;
    let mut files = Memory::default();
    for (path, text) in *texts {
        files.put(&Path::new(name).join(path), text.as_bytes().to_vec());
    }
    read(&files, Path::new(name), Vec::new())
}

/// The content of an upload.
#[derive(Default)]
struct Found {
    files: Memory,
    /// Not read.
    others: Vec<PathBuf>,
}

impl Found {
    /// Returns whether the lab reads a file of this name.
    fn wants(&mut self, path: &Path) -> bool {
        let is_xml = path.extension().is_some_and(|extension| extension == "xml");
        let wanted =
            is_xml || path.file_name().is_some_and(|name| name == DRIVE_FILE || name == DECISION_FILE);
        if !wanted {
            self.others.push(path.to_owned());
        }
        wanted
    }

    /// The directories of files with this name.
    fn places(&self, name: &str) -> Vec<PathBuf> {
        let named = self.files.paths().filter(|path| path.file_name().is_some_and(|file| file == name));
        named.map(|path| path.parent().unwrap_or(Path::new("")).to_owned()).collect()
    }
}

/// Reads the only Trial in a zip, or in the files of a folder. Without a Parameters.xml, as the published platform gives
/// it, the default steps are taken. Unpacked, it may have `largest` bytes, as [`LARGEST_CONTENT`].
///
/// # Errors
/// It is too large, it holds no Trial or several, or the Trial has errors: all of them, with file, element, attribute and
/// value.
pub fn open(name: &str, files: &[(&str, &[u8])], largest: u64) -> Result<Basis, Refused> {
    let wrong = |why: String| Refused(format!("{name}: {why}"));
    let size: usize = files.iter().map(|(_, content)| content.len()).sum();
    require(size <= LARGEST_UPLOAD, || {
        format!("{name}: it has more than {} MB", LARGEST_UPLOAD / 1_000_000)
    })?;
    require(files.len() <= MOST_FILES, || format!("{name}: it has more than {MOST_FILES} files"))?;
    let mut found = Found::default();
    if let [(path, content)] = files
        && !path.ends_with(".xml")
    {
        unzip(content, largest, &mut found).map_err(wrong)?;
    } else {
        for (path, content) in files {
            let path = Path::new(path);
            let inside = path.components().all(|part| matches!(part, Component::Normal(_)));
            require(inside, || format!("{name}: the name {path:?} leads out of it"))?;
            if found.wants(path) {
                found.files.put(path, content.to_vec());
            }
        }
    }
    let mut notes = Vec::new();
    let filled_in = found.places("Parameters.xml").is_empty();
    let place = match found.places("Parameters.xml").as_slice() {
        [] => with_parameters(&mut found, &mut notes).map_err(wrong)?,
        [place] => place.clone(),
        several => {
            let names: Vec<String> = several.iter().map(|place| place.display().to_string()).collect();
            return Err(wrong(format!("there are several Trials in it: {}", names.join(", "))));
        }
    };
    let others = found.others.iter().filter(|path| path.starts_with(&place));
    let others: Vec<String> = others.map(|path| path.display().to_string()).collect();
    if !others.is_empty() {
        notes.push(format!("not used here, and not taken along: {}", others.join(", ")));
    }
    let mut read = read(&found.files, &place, notes)?;
    if filled_in || !place.components().any(|part| matches!(part, Component::Normal(_))) {
        // Without a directory of its own, it is called as its zip.
        let stem = Path::new(name).file_stem().map(|stem| stem.to_string_lossy().into_owned());
        read.driven.trial.name = stem.unwrap_or_else(|| "Trial".into());
    }
    Ok(read)
}

fn unzip(bytes: &[u8], largest: u64, found: &mut Found) -> Result<(), String> {
    let mut archive =
        ZipArchive::new(Cursor::new(bytes)).map_err(|error| format!("it is no zip: {error}"))?;
    if archive.len() > MOST_FILES {
        return Err(format!("it has more than {MOST_FILES} files"));
    }
    let mut left = largest;
    for k in 0..archive.len() {
        let file = archive.by_index(k).map_err(|error| error.to_string())?;
        let path = file.enclosed_name().ok_or("a name in it leads out of it")?;
        if !file.is_file() || !found.wants(&path) {
            continue;
        }
        let mut content = Vec::new();
        let read = Bounded::new(file, left.min(input::LARGEST_TRIAL_FILE)).read_to_end(&mut content);
        read.map_err(|error| format!("{}: {error}", path.display()))?;
        left -= content.len() as u64;
        found.files.put(&path, content);
    }
    Ok(())
}

/// \[s\] The communication step of a Trial that says none.
const TIME_STEP: f64 = 0.01;
/// \[s\] Its mechanical step: that of most crowds with the paper's materials.
const SHORT_STEP: f64 = 1e-4;

/// Adds the Parameters.xml of a Trial that has none, and returns its directory.
fn with_parameters(found: &mut Found, notes: &mut Vec<String>) -> Result<PathBuf, String> {
    let only = |name: &str| match found.places(name).as_slice() {
        [place] => Ok(place.clone()),
        [] => Err(format!("it has no Parameters.xml and no {name}, so there is no Trial in it")),
        _ => Err(format!("it has no Parameters.xml, and more than one {name}")),
    };
    let (fixed, moving) = (only("Agents.xml")?, only("AgentDynamics.xml")?);
    let common =
        fixed.ancestors().find(|above| moving.starts_with(above)).unwrap_or(Path::new("")).to_owned();
    let within = |path: &Path| {
        let parts = path.strip_prefix(&common).into_iter().flat_map(Path::components);
        let names: Vec<String> = parts.map(|part| part.as_os_str().to_string_lossy().into_owned()).collect();
        format!("./{}", names.join("/"))
    };
    let parameters = Parameters {
        static_directory: within(&fixed),
        dynamic_directory: within(&moving),
        time_step: TIME_STEP,
        time_step_mechanical: SHORT_STEP,
    };
    found.files.put(&common.join("Parameters.xml"), parameters.xml().into_bytes());
    notes.push(format!(
        "it has no Parameters.xml: the communication step is {TIME_STEP} s, the mechanical step {SHORT_STEP} s"
    ));
    Ok(common)
}

fn read(files: &Memory, place: &Path, mut notes: Vec<String>) -> Result<Basis, Refused> {
    let (trial, warnings) = setup::read_from(files, place, &FileNames::default())?;
    let people = trial.agents.len();
    require(people <= MOST_PEOPLE, || {
        format!("{people} people are too many for a page: at most {MOST_PEOPLE}")
    })?;
    let text = |name: &str| {
        let path = place.join(name);
        if files.lacks(&path) {
            return Ok(String::new());
        }
        let bytes = files.read(&path, LARGEST_CONTENT)?;
        String::from_utf8(bytes).map_err(|error| Refused(format!("{}: {error}", path.display())))
    };
    let mut driven =
        Driven { drive: text(DRIVE_FILE)?, wishes: text(DECISION_FILE)?, ..Driven::alone(trial, None) };
    if !driven.drive.is_empty() {
        let table = DriveTable::from_csv(driven.drive.as_bytes())
            .and_then(|table| table.check_agents(Some(&driven.trial)).map(|()| table));
        driven.table = table.map_err(|error| error.of_file(&place.join(DRIVE_FILE)))?;
    }
    notes.extend(warnings.iter().map(ToString::to_string));
    Ok(Basis { driven, notes, made: Value::Null })
}
