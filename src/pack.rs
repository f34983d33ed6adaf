//! A Trial, or several with one interface, and binaries -> an `.fmu`.
//!
//! The same Trials and binaries give the same bytes: a packaged FMU can serve as a regression artifact.

use crate::files::Staged;
use crate::model_description::{LARGEST_DESCRIPTION, MODEL_IDENTIFIER, model_description};
use crate::resources::{TRIALS_FILE, can_be_packed};
use crate::trial::{Problems, Trial};
use crate::variables::{guid, table};
use lemons_fmi2::archive::{Archive, ArchiveError, read};
pub use lemons_fmi2::archive::{Binary, host_platform};
pub use lemons_fmi2::description::Naming;
use std::io::{Seek, Write};
use std::path::{Component, Path, PathBuf};
use thiserror::Error;

/// A drive file in a Trial directory goes along, for masters that look for one.
pub const DRIVE_FILE: &str = "drive.csv";

/// Why nothing was packed.
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
        "{agents} agents are too many for an FMU: FMI 2.0 describes each variable of each of them, in {} MB, and at most \
         {} MB can be read", size / 1_000_000, LARGEST_DESCRIPTION / 1_000_000
    )]
    TooLarge { agents: usize, size: u64 },
    #[error("two Trials are called {name:?}: the parameter Trial could not tell them apart")]
    SameName { name: String },
    #[error(
        "Trial {other:?} does not fit into one FMU with {first:?}: {why}; the Trials of an FMU share its variables \
         (agent[0].Mass, …), so they need the same number of agents with the same Ids, and the same materials: pack one FMU of each"
    )]
    OtherInterface { first: String, other: String, why: String },
    #[error(
        "{path}: Parameters.xml says {attribute}={value:?}, which lies outside the Trial directory and would not be packed"
    )]
    Outside { path: PathBuf, attribute: &'static str, value: String },
    #[error("{path}: {error}")]
    Archive { path: PathBuf, error: ArchiveError },
    #[error("cannot write {path}: {error}")]
    Write { path: PathBuf, error: std::io::Error },
}

/// Draws a Trial as a PNG; `None` if it cannot be drawn.
pub type Draw = fn(&Trial) -> Option<Vec<u8>>;

/// What goes into an FMU.
#[derive(Debug, Clone, Default)]
pub struct Package {
    /// The first is the default.
    pub trials: Vec<PathBuf>,
    /// At least one.
    pub binaries: Vec<Binary>,
    /// Draws `model.png`, of the first Trial.
    pub picture: Option<Draw>,
    /// Of the variables.
    pub naming: Naming,
}

impl Package {
    /// Writes the FMU; answers the Trials' warnings. Nothing is left half-written.
    ///
    /// # Errors
    /// [`PackError`]; the file at `output` is as it was then.
    pub fn write(&self, output: &Path) -> Result<Vec<String>, PackError> {
        let (trials, warnings) = self.read_trials()?;
        if trials.is_empty() {
            return Err(PackError::NoTrial);
        }
        check_size(&trials[0], least_size(&trials[0], self.naming))?;
        let write_error = |error| PackError::Write { path: output.to_owned(), error };
        let description = model_description(&trials[0], self.naming);
        check_size(&trials[0], description.len() as u64)?;
        let mut file = Staged::beside(output).map_err(write_error)?;
        self.fill(&trials, &description, &mut file)
            .map_err(|error| PackError::Archive { path: output.to_owned(), error })?;
        file.persist().map_err(write_error)?;
        Ok(warnings)
    }

    /// Writes the archive's content.
    fn fill(&self, trials: &[Trial], description: &str, file: impl Write + Seek) -> Result<(), ArchiveError> {
        let documentation = documentation(&trials[0]);
        let mut archive =
            Archive::begin(file, MODEL_IDENTIFIER, description, &documentation, &self.binaries)?;
        if let Some(picture) = self.picture.and_then(|draw| draw(&trials[0])) {
            archive.add("model.png", &picture)?;
        }
        let names: String = trials.iter().map(|trial| format!("{}\n", trial.name)).collect();
        archive.add(&format!("resources/{TRIALS_FILE}"), names.as_bytes())?;
        for trial in trials {
            add_trial(&mut archive, trial)?;
        }
        archive.finish()
    }

    /// Reads the Trials and sees that they have one interface.
    fn read_trials(&self) -> Result<(Vec<Trial>, Vec<String>), PackError> {
        let mut trials: Vec<Trial> = Vec::new();
        let mut warnings = Vec::new();
        for path in &self.trials {
            let read = Trial::read(path);
            let (trial, found) =
                read.map_err(|problems| PackError::Broken { path: path.clone(), problems })?;
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

/// \[byte\] The model description has so many or some percent more, by that of a few agents: that of all takes long and
/// much memory.
fn least_size(trial: &Trial, naming: Naming) -> u64 {
    const SAMPLE: usize = 50;
    let agents = trial.agents.len();
    if agents <= SAMPLE {
        return 0;
    }
    let mut few = trial.clone();
    few.agents.truncate(SAMPLE);
    few.dynamics.truncate(SAMPLE);
    let many = model_description(&few, naming).len();
    few.agents.truncate(1);
    few.dynamics.truncate(1);
    let one = model_description(&few, naming).len();
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
    let (a, b) = (table(first), table(other));
    if guid(&a) == guid(&b) {
        return None;
    }
    let names = a.iter().zip(&b).find(|(a, b)| a.name != b.name);
    Some(match names {
        Some((a, b)) => format!("it has the variable {} where the first has {}", b.name, a.name),
        None => format!("it has {} variables instead of {}", b.len(), a.len()),
    })
}

/// The files of a Trial, unchanged.
fn add_trial<W: Write + Seek>(archive: &mut Archive<W>, trial: &Trial) -> Result<(), ArchiveError> {
    let (fixed, moving) = (trial.parameters.static_path(), trial.parameters.dynamic_path());
    let needed = [
        PathBuf::from("Parameters.xml"),
        fixed.join("Materials.xml"),
        fixed.join("Geometry.xml"),
        fixed.join("Agents.xml"),
        moving.join("AgentDynamics.xml"),
    ];
    let if_there = [moving.join("AgentInteractions.xml"), PathBuf::from(DRIVE_FILE)];
    let if_there = if_there.into_iter().filter(|file| trial.directory.join(file).symlink_metadata().is_ok());
    for file in needed.into_iter().chain(if_there) {
        let content = read(&trial.directory.join(&file))?;
        // Zip names have forward slashes on every platform.
        let parts = file.components().filter_map(|part| match part {
            Component::Normal(name) => Some(name.to_string_lossy()),
            _ => None,
        });
        let place = parts.collect::<Vec<_>>().join("/");
        archive.add(&format!("resources/{}/{place}", trial.name), &content)?;
    }
    Ok(())
}

/// `documentation/index.html`
fn documentation(trial: &Trial) -> String {
    let parameters = &trial.parameters;
    include_str!("documentation.html")
        .replace("{version}", env!("CARGO_PKG_VERSION"))
        .replace("{trial}", &quick_xml::escape::escape(&trial.name))
        .replace("{agents}", &trial.agents.len().to_string())
        .replace("{last}", &(trial.agents.len().saturating_sub(1)).to_string())
        .replace("{time_step}", &format!("{:?}", parameters.time_step))
        .replace("{time_step_mechanical}", &format!("{:?}", parameters.time_step_mechanical))
        .replace("{guid}", &guid(&table(trial)).braced().to_string())
}
