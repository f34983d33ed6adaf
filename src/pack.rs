//! Packs a Trial, or several Trials with the same variables, and binaries into an `.fmu`.
//!
//! The same Trials and binaries give the same bytes, so that FMUs can be compared.

use crate::model::CrowdModel;
use crate::model_description::{LARGEST_DESCRIPTION, model_description, packed_description, terminals};
use crate::quantities::{scalars, shared};
use crate::resources::{TRIALS_FILE, can_be_packed};
use crate::setup;
use lemons_core::files::Staged;
use lemons_core::files::source::{FileSource, LocalFiles};
use lemons_core::trial::{DRIVE_FILE, DriveTable, FileNames, Problems, Trial};
use lemons_fmi::archive::{ArchiveError, FmuContent, FmuPicture, FmuWriter, read};
pub use lemons_fmi::archive::{
    Binary, COMPONENT, THIRD_PARTY, host_directory, host_platform, library_file, platforms,
};
use lemons_fmi::description::Packed;
use lemons_fmi::model::fingerprint;
pub use lemons_fmi::{FmuFormat, Naming};
use lemons_fmi::{Version, documentation};
use std::io::{Seek, Write};
use std::path::{Component, Path, PathBuf};
use thiserror::Error;

/// Why an FMU could not be written.
#[derive(Debug, Error)]
#[allow(missing_docs)] // the messages say it
pub enum PackError {
    #[error("nothing to pack: no Trial was given")]
    NoTrial,
    #[error("the Trial {path} has errors:\n{problems}")]
    Broken { path: PathBuf, problems: Problems },
    #[error(
        "the Trial {path:?} is called {name:?}, which cannot be a directory's name in an FMU: it must be on one line, \
         without control characters, '/', '\\' and ':', and not {TRIALS_FILE:?}; rename the directory"
    )]
    Name { path: PathBuf, name: String },
    #[error(
        "{agents} agents are too many for an FMU: its description has {} MB, and at most {} MB can be read; that of \
         FMI 3.0 is much smaller", size / 1_000_000, LARGEST_DESCRIPTION / 1_000_000
    )]
    TooLarge { agents: usize, size: u64 },
    #[error("two Trials have the name {name:?}: the parameter Trial could not distinguish them")]
    SameName { name: String },
    #[error(
        "Trial {other:?} does not fit into one FMU with {first:?}: {why}; the Trials of an FMI 2.0 FMU share its \
         variables (agent[0].Mass, …), so they need the same number of agents with the same Ids, and the same materials: \
         pack one FMU of each, or an FMI 3.0 FMU"
    )]
    OtherInterface { first: String, other: String, why: String },
    #[error(
        "{path}: Parameters.xml says {attribute}={value:?}, which is outside the Trial directory and would not be packed"
    )]
    Outside { path: PathBuf, attribute: &'static str, value: String },
    #[error("{path}: {error}")]
    Archive { path: PathBuf, error: ArchiveError },
    #[error("cannot write {path}: {error}")]
    Write { path: PathBuf, error: std::io::Error },
}

/// Draws a Trial as a PNG; `None` if it cannot be drawn.
pub type DrawTrial = fn(&Trial) -> Option<Vec<u8>>;

/// Further errors of a Trial, in files that the mechanics do not read.
pub type TrialCheck = fn(&Trial) -> Problems;

/// The content of an FMU.
#[derive(Debug, Clone, Default)]
pub struct Package {
    /// Trial directories; the first is the default.
    pub trials: Vec<PathBuf>,
    /// The binaries; at least one.
    pub binaries: Vec<Binary>,
    /// Draws `model.png` (in FMI 3.0 `documentation/model.png`), of the first Trial.
    pub picture: Option<DrawTrial>,
    /// Checks each Trial further. A Trial with errors is not packed.
    pub check: Option<TrialCheck>,
    /// Version of FMI.
    pub format: FmuFormat,
}

impl Package {
    /// Writes the FMU and returns the Trials' warnings. A failure leaves no half-written file.
    ///
    /// # Errors
    /// See [`PackError`]. The file at `output` is then unchanged.
    pub fn write(&self, output: &Path) -> Result<Vec<String>, PackError> {
        let write_error = |error| PackError::Write { path: output.to_owned(), error };
        let begin = || Staged::beside(output).map_err(write_error);
        let (warnings, file) = self.write_with(&LocalFiles, output, begin)?;
        file.persist().map_err(write_error)?;
        Ok(warnings)
    }

    /// Writes the FMU from Trials and binaries in these files. Messages call it `name`.
    ///
    /// # Errors
    /// See [`PackError`].
    pub fn write_to(
        &self,
        files: &dyn FileSource,
        name: &Path,
        output: impl Write + Seek,
    ) -> Result<Vec<String>, PackError> {
        Ok(self.write_with(files, name, || Ok(output))?.0)
    }

    /// Reads the Trials, begins the file, and writes it.
    fn write_with<W: Write + Seek>(
        &self,
        files: &dyn FileSource,
        name: &Path,
        begin: impl FnOnce() -> Result<W, PackError>,
    ) -> Result<(Vec<String>, W), PackError> {
        let (trials, warnings) = self.read_trials(files)?;
        let first = trials.first().ok_or(PackError::NoTrial)?;
        check_size(first, least_size(first, self.format))?;
        let archive_error = |error| PackError::Archive { path: name.to_owned(), error };
        let contents: Vec<Files> = trials
            .iter()
            .map(|trial| files_of(files, trial))
            .collect::<Result<_, _>>()
            .map_err(archive_error)?;
        let packed: Vec<Packed> =
            trials.iter().zip(&contents).map(|(trial, content)| packed(trial, content)).collect();
        let description = packed_description(first, self.format, &packed);
        check_size(first, description.len() as u64)?;
        let mut file = begin()?;
        self.fill(files, &trials, &contents, &description, &mut file).map_err(archive_error)?;
        Ok((warnings, file))
    }

    /// Writes the archive's content.
    fn fill(
        &self,
        files: &dyn FileSource,
        trials: &[Trial],
        contents: &[Files],
        description: &str,
        file: impl Write + Seek,
    ) -> Result<(), ArchiveError> {
        let version = self.format.version();
        let picture = self.picture.and_then(|draw| draw(&trials[0]));
        let content = FmuContent {
            version,
            description,
            documentation: &documentation(&trials[0], version, picture.is_some()),
            binaries: &self.binaries,
            terminals: terminals(&trials[0], version),
            icon: FmuPicture { svg: include_str!("icon.svg"), png: include_bytes!("icon.png") },
            diagram: FmuPicture { svg: include_str!("diagram.svg"), png: include_bytes!("diagram.png") },
            picture,
        };
        let mut archive = FmuWriter::begin::<CrowdModel>(file, files, &content)?;
        let names: String = trials.iter().map(|trial| format!("{}\n", trial.name)).collect();
        archive.add(&format!("resources/{TRIALS_FILE}"), names.as_bytes())?;
        for (trial, content) in trials.iter().zip(contents) {
            for (place, bytes) in content {
                archive.add(&format!("resources/{}/{place}", trial.name), bytes)?;
            }
        }
        archive.finish()
    }

    /// Reads the Trials and checks that they have the same interface.
    fn read_trials(&self, files: &dyn FileSource) -> Result<(Vec<Trial>, Vec<String>), PackError> {
        let mut trials: Vec<Trial> = Vec::new();
        let mut warnings = Vec::new();
        for path in &self.trials {
            let read = setup::read_from(files, path, &FileNames::default());
            let (trial, found) =
                read.map_err(|problems| PackError::Broken { path: path.clone(), problems })?;
            let further = self.check.map(|check| check(&trial)).unwrap_or_default();
            if further.has_errors() {
                return Err(PackError::Broken { path: path.clone(), problems: further });
            }
            warnings.extend(found.iter().map(ToString::to_string));
            if !can_be_packed(&trial.name) {
                return Err(PackError::Name { path: path.clone(), name: trial.name });
            }
            if trials.iter().any(|other| other.name == trial.name) {
                return Err(PackError::SameName { name: trial.name });
            }
            let directories = [
                ("Static", &trial.parameters.static_directory),
                ("Dynamic", &trial.parameters.dynamic_directory),
            ];
            for (attribute, value) in directories {
                let inside = Path::new(value.trim())
                    .components()
                    .all(|part| matches!(part, Component::CurDir | Component::Normal(_)));
                if !inside {
                    return Err(PackError::Outside { path: path.clone(), attribute, value: value.clone() });
                }
            }
            if let Some(first) = trials.first()
                && self.format != FmuFormat::Fmi3
                && let Some(why) = difference(first, &trial)
            {
                return Err(PackError::OtherInterface { first: first.name.clone(), other: trial.name, why });
            }
            trials.push(trial);
        }
        Ok((trials, warnings))
    }
}

fn check_size(trial: &Trial, size: u64) -> Result<(), PackError> {
    let agents = trial.agents.len();
    if size > LARGEST_DESCRIPTION { Err(PackError::TooLarge { agents, size }) } else { Ok(()) }
}

/// \[byte\] Lower bound of the size of the model description, accurate to some percent, extrapolated from a few agents:
/// making all of it takes much time and memory.
fn least_size(trial: &Trial, format: FmuFormat) -> u64 {
    const SAMPLE: usize = 50;
    let agents = trial.agents.len();
    if agents <= SAMPLE {
        return 0;
    }
    let mut few = trial.clone();
    few.agents.truncate(SAMPLE);
    few.dynamics.truncate(SAMPLE);
    let many = model_description(&few, format).len();
    few.agents.truncate(1);
    few.dynamics.truncate(1);
    let one = model_description(&few, format).len();
    (one + (many - one) / (SAMPLE - 1) * (agents - 1)) as u64
}

/// Why two Trials do not have the same variables and Ids; `None` if they do.
fn difference(first: &Trial, other: &Trial) -> Option<String> {
    let (a, b) = (first.agents.len(), other.agents.len());
    if a != b {
        return Some(format!("{b} agents instead of {a}"));
    }
    let agents = first.agents.iter().zip(&other.agents).enumerate();
    for (place, (a, b)) in agents {
        if a.id != b.id {
            return Some(format!("agent {place} has the Id {:?} instead of {:?}", b.id, a.id));
        }
    }
    if shared(first) == shared(other) {
        return None;
    }
    // Walls may differ.
    let of = |trial| {
        scalars(trial).into_iter().filter(|scalar| !scalar.name.starts_with("wall[")).collect::<Vec<_>>()
    };
    let (a, b) = (of(first), of(other));
    let names = a.iter().zip(&b).find(|(a, b)| a.name != b.name);
    Some(match names {
        Some((a, b)) => format!("it has the variable {} where the first has {}", b.name, a.name),
        None => format!("it has {} variables instead of {}", b.len(), a.len()),
    })
}

/// The files of a packed Trial: their names within it, and what is in them.
type Files = Vec<(String, Vec<u8>)>;

/// Returns what the description tells of a packed Trial. Its fingerprint depends on the names and the bytes of its
/// files, and not on its own name.
fn packed(trial: &Trial, files: &Files) -> Packed {
    let mut content = Vec::new();
    for part in files.iter().flat_map(|(name, bytes)| [name.as_bytes(), bytes]) {
        // With its length: where one part ends and the next begins counts.
        content.extend((part.len() as u64).to_le_bytes());
        content.extend(part);
    }
    Packed { name: trial.name.clone(), fingerprint: fingerprint(&content) }
}

/// Reads the files of a Trial, which are packed unchanged.
fn files_of(files: &dyn FileSource, trial: &Trial) -> Result<Files, ArchiveError> {
    let (fixed, moving) = (trial.parameters.static_path(), trial.parameters.dynamic_path());
    let needed = [
        PathBuf::from("Parameters.xml"),
        fixed.join("Materials.xml"),
        fixed.join("Geometry.xml"),
        fixed.join("Agents.xml"),
        moving.join("AgentDynamics.xml"),
    ];
    let if_there = [moving.join("AgentInteractions.xml"), PathBuf::from(DRIVE_FILE)];
    let if_there = if_there.into_iter().filter(|file| !files.lacks(&trial.directory.join(file)));
    let mut packed = Files::new();
    for file in needed.into_iter().chain(if_there) {
        let content = read(files, &trial.directory.join(&file))?;
        // Names in a zip file have forward slashes on every platform.
        let parts = file.components().filter_map(|part| match part {
            Component::Normal(name) => Some(name.to_string_lossy()),
            _ => None,
        });
        let place = parts.collect::<Vec<_>>().join("/");
        packed.push((place, content));
    }
    Ok(packed)
}

/// `documentation/index.html`
fn documentation(trial: &Trial, version: Version, picture: bool) -> String {
    let page = match version {
        Version::V2 => include_str!("documentation.html"),
        Version::V3 => include_str!("documentation_3.html"),
    };
    let crowd = CrowdModel::of_trial(trial.clone(), DriveTable::default());
    let file = if version == Version::V2 { "../model.png" } else { "model.png" };
    let shown = format!("<p><img src=\"{file}\" alt=\"where everybody is at the start\" width=\"640\"></p>");
    documentation::documentation(&crowd, version, page, trial.agents.len())
        .replace("{picture}", if picture { &shown } else { "" })
        .replace("{trial}", &lemons_core::xml::escaped(&trial.name))
        .replace("{time_step}", &format!("{:?}", trial.parameters.time_step))
        .replace("{time_step_mechanical}", &format!("{:?}", trial.parameters.time_step_mechanical))
}
