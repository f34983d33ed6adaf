//! The directory: its files, read and checked together, and written.

use crate::files::source::{FileSource, LocalFiles};
use crate::files::{Change, Scratch, WriteError, change_all, make_directories, target_of};
use crate::trial::agents::{self, Agent};
use crate::trial::dynamics::{self, AgentDynamics, DynamicsElement, dynamics_xml};
use crate::trial::geometry::{self, Geometry, Wall};
use crate::trial::interactions::{self, Interactions, interactions_xml};
use crate::trial::materials::{self, Materials};
use crate::trial::parameters::{self, Parameters};
use crate::trial::problem::Problems;
use crate::trial::schema::Schema;
use crate::trial::xml::{Checked, Element, Reading, ids_of, read_alone};
use std::path::{Component, Path, PathBuf};
use uuid::Uuid;

/// A Trial directory, read and checked.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Trial {
    /// The directory's own name.
    pub name: String,
    /// Directory that it was read from.
    pub directory: PathBuf,
    /// `Parameters.xml`
    pub parameters: Parameters,
    /// `Materials.xml`
    pub materials: Materials,
    /// `Geometry.xml`
    pub geometry: Geometry,
    /// `Agents.xml`, in file order.
    pub agents: Vec<Agent>,
    /// `AgentDynamics.xml`, in the order of `agents` (whatever the order in the file).
    pub dynamics: Vec<AgentDynamics>,
    /// `AgentInteractions.xml`; empty when there is no such file.
    pub interactions: Interactions,
}

/// The contacts' file in the Dynamic directory.
pub const INTERACTIONS: &str = "AgentInteractions.xml";

/// Names of the Trial's files; of [`Trial::places`], their paths.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FileNames {
    /// Relative to the Trial directory.
    pub parameters: PathBuf,
    /// Relative to the Static directory.
    pub materials: PathBuf,
    /// Relative to the Static directory.
    pub geometry: PathBuf,
    /// Relative to the Static directory.
    pub agents: PathBuf,
    /// Relative to the Dynamic directory.
    pub dynamics: PathBuf,
    /// Relative to the Dynamic directory. The file is there only if there are contacts.
    pub interactions: PathBuf,
}

/// The paper's.
impl Default for FileNames {
    fn default() -> FileNames {
        FileNames {
            parameters: "Parameters.xml".into(),
            materials: "Materials.xml".into(),
            geometry: "Geometry.xml".into(),
            agents: "Agents.xml".into(),
            dynamics: "AgentDynamics.xml".into(),
            interactions: INTERACTIONS.into(),
        }
    }
}

impl FileNames {
    /// Returns the paths of the files of a Trial in a directory.
    fn within(&self, directory: &Path, parameters: &Parameters) -> FileNames {
        let fixed = directory.join(parameters.static_path());
        let moving = directory.join(parameters.dynamic_path());
        // Without `.` in between: `Trial/./static` is `Trial/static`.
        let tidy = |path: PathBuf| path.components().collect::<PathBuf>();
        FileNames {
            parameters: tidy(directory.join(&self.parameters)),
            materials: tidy(fixed.join(&self.materials)),
            geometry: tidy(fixed.join(&self.geometry)),
            agents: tidy(fixed.join(&self.agents)),
            dynamics: tidy(moving.join(&self.dynamics)),
            interactions: tidy(moving.join(&self.interactions)),
        }
    }

    /// Returns the path of the first file that has such an attribute, and the name of its element.
    pub fn with_attribute(&self, attribute: &str) -> Option<(PathBuf, &'static str)> {
        self.clone().all().into_iter().zip(SCHEMAS).find_map(|(path, root)| {
            let with = root.below().into_iter().find(|schema| schema.value(attribute).is_some())?;
            Some((path, with.name))
        })
    }

    /// Returns them in the order of [`SCHEMAS`].
    fn all(self) -> Vec<PathBuf> {
        let FileNames { parameters, materials, geometry, agents, dynamics, interactions } = self;
        vec![parameters, materials, geometry, agents, dynamics, interactions]
    }
}

/// The roots of the files, in the order of docs/reference/trial.md.
pub(crate) const SCHEMAS: [&Schema; 6] = [
    &parameters::PARAMETERS,
    &materials::MATERIALS,
    &geometry::GEOMETRY,
    &agents::AGENTS,
    &dynamics::AGENTS,
    &interactions::INTERACTIONS,
];

impl Trial {
    /// Reads and checks a Trial directory: the Trial with the warnings, or all that is wrong with it. What may be a mistake
    /// in its mechanics is not looked at here (`crowd_mechanics::setup::read` does).
    ///
    /// # Errors
    /// Errors in its files, all of them.
    pub fn read(directory: &Path) -> Checked<Trial> {
        Trial::read_from(&LocalFiles, directory, &FileNames::default())
    }

    /// Makes a Trial of people, each with the state at the start, and of walls, without materials. It cannot be simulated
    /// by the mechanics; people can decide in it.
    pub fn of(
        people: impl IntoIterator<Item = (Agent, AgentDynamics)>,
        walls: Vec<Wall>,
        time_step: f64,
    ) -> Trial {
        let (agents, dynamics) = people.into_iter().unzip();
        let parameters = Parameters { time_step, ..Parameters::default() };
        Trial {
            parameters,
            geometry: Geometry { walls, ..Geometry::default() },
            agents,
            dynamics,
            ..Trial::default()
        }
    }

    /// Returns the files of which [`Trial::read`] reads a directory, whether they are there or not.
    pub fn files_read(directory: &Path) -> Vec<PathBuf> {
        let names = FileNames::default();
        let first = directory.join(&names.parameters);
        // What is wrong with it those say who read the Trial.
        let read = read_alone(&LocalFiles, &first, &parameters::PARAMETERS, parameters::read);
        read.map_or(vec![first], |(parameters, _)| names.within(directory, &parameters).all())
    }

    /// Reads a Trial as [`Trial::read`] does, from these files, with these names.
    ///
    /// # Errors
    /// As [`Trial::read`].
    pub fn read_from(files: &dyn FileSource, directory: &Path, names: &FileNames) -> Checked<Trial> {
        Reading::of(files, |reading| Trial::read_all(reading, directory, names))
    }

    /// Returns where its files are, as messages name them.
    pub fn places(&self, names: &FileNames) -> FileNames {
        names.within(&self.directory, &self.parameters)
    }

    /// Returns `None` only after an error. A file is checked against the others as far as those could be read.
    fn read_all(reading: &Reading<'_>, directory: &Path, names: &FileNames) -> Option<Trial> {
        let first = directory.join(&names.parameters);
        let parameters = reading.file(&first, &parameters::PARAMETERS, parameters::read)?;
        let at = names.within(directory, &parameters);
        // Without a directory, reported already, nobody knows where its files are.
        if parameters.static_directory.trim().is_empty() {
            return None;
        }
        let materials = reading.file(&at.materials, &materials::MATERIALS, materials::read);
        let material_ids = materials
            .as_ref()
            .map(|read| ids_of(read.materials.intrinsic.iter().map(|material| &material.id)));
        let ids = material_ids.as_ref();
        let geometry = reading.file(&at.geometry, &geometry::GEOMETRY, |root| geometry::read(root, ids));
        let agents = reading.file(&at.agents, &agents::AGENTS, |root| agents::read(root, ids));
        if let (Some(materials), Some(agents)) = (&materials, &agents) {
            materials::check_pairs(materials, geometry.as_ref(), agents, reading);
        }
        if parameters.dynamic_directory.trim().is_empty() {
            return None;
        }
        let read_dynamics = |root: Element<'_>| dynamics::read(root, agents.as_deref());
        let dynamics = reading.file(&at.dynamics, &dynamics::AGENTS, read_dynamics);
        let interactions = match (&agents, &geometry) {
            (Some(agents), Some(geometry)) if !reading.files.lacks(&at.interactions) => {
                let read = |root: Element<'_>| interactions::read(root, agents, geometry);
                reading.file(&at.interactions, &interactions::INTERACTIONS, read)?
            }
            _ => Interactions::default(),
        };
        Some(Trial {
            name: own_name(directory),
            directory: directory.to_owned(),
            parameters,
            materials: materials?.materials,
            geometry: geometry?,
            agents: agents?,
            dynamics: dynamics?,
            interactions,
        })
    }

    /// Reads an `AgentDynamics.xml` of this Trial's agents, in their order.
    ///
    /// # Errors
    /// All errors in its files.
    pub fn read_dynamics(&self, path: &Path) -> Result<Vec<AgentDynamics>, Problems> {
        let read = |root: Element<'_>| dynamics::read(root, Some(&self.agents));
        read_alone(&LocalFiles, path, &dynamics::AGENTS, read).map(|(dynamics, _)| dynamics)
    }

    /// Reads an `AgentInteractions.xml` of this Trial's agents and walls.
    ///
    /// # Errors
    /// All errors in its files.
    pub fn read_interactions(&self, path: &Path) -> Result<Interactions, Problems> {
        let read = |root: Element<'_>| interactions::read(root, &self.agents, &self.geometry);
        read_alone(&LocalFiles, path, &interactions::INTERACTIONS, read).map(|(contacts, _)| contacts)
    }

    /// Returns the parameters of a copy: its Static and Dynamic directories are inside of its directory.
    fn parameters_of_copy(&self) -> Parameters {
        let mut parameters = self.parameters.clone();
        for (named, own) in [
            (&mut parameters.static_directory, "./static/"),
            (&mut parameters.dynamic_directory, "./dynamic/"),
        ] {
            if !is_inside(named) {
                *named = own.into();
            }
        }
        parameters
    }

    /// Tells one Trial from another by its content: the name-based UUID (version 5) of its files' texts, as
    /// [`Trial::write`] writes them. Neither its name nor where it was read from counts.
    pub fn fingerprint(&self) -> u128 {
        let mut content = Vec::new();
        for text in self.all_texts(&self.parameters) {
            // With its length: where one text ends and the next begins counts.
            content.extend((text.len() as u64).to_le_bytes());
            content.extend(text.into_bytes());
        }
        Uuid::new_v5(&Uuid::NAMESPACE_OID, &content).as_u128()
    }

    /// Returns the files that [`Trial::write`] writes into a directory; the last one, the contacts, perhaps goes.
    pub fn files_written(&self, directory: &Path) -> Vec<PathBuf> {
        FileNames::default().within(directory, &self.parameters_of_copy()).all()
    }

    /// Returns its files as [`Trial::write`] writes them into a directory: their paths and texts.
    pub fn texts(&self, directory: &Path) -> Vec<(PathBuf, String)> {
        let texts = self.all_texts(&self.parameters_of_copy()).into_iter();
        let count = if self.interactions == Interactions::default() { 5 } else { 6 };
        self.files_written(directory).into_iter().zip(texts).take(count).collect()
    }

    /// The texts of all files, in the order of [`SCHEMAS`].
    fn all_texts(&self, parameters: &Parameters) -> [String; 6] {
        [
            parameters.xml(),
            materials::xml(&self.materials),
            geometry::xml(&self.geometry),
            agents::xml(&self.agents),
            dynamics_xml(&self.agents, &self.dynamics, DynamicsElement::Written),
            interactions_xml(&self.agents, &self.geometry, &self.interactions),
        ]
    }

    /// Writes a complete Trial directory, all files or none, and removes outdated contacts. Other files in it stay.
    ///
    /// Static and Dynamic directories that lie outside the Trial directory become `./static/` and `./dynamic/`
    /// in it: a copy neither overwrites the original's files nor depends on them. A new directory appears whole.
    ///
    /// # Errors
    /// A file cannot be written; existing ones are then unchanged.
    pub fn write(&self, directory: &Path) -> Result<(), WriteError> {
        self.write_with(&[], directory)
    }

    /// Writes it as [`Trial::write`] does, with names and texts of other files.
    ///
    /// # Errors
    /// As [`Trial::write`].
    pub fn write_with(&self, others: &[(&str, &str)], directory: &Path) -> Result<(), WriteError> {
        if directory.exists() {
            return self.write_in(others, directory);
        }
        let at = || WriteError::at(directory);
        directory.parent().map_or(Ok(()), make_directories).map_err(at())?;
        let place = target_of(directory).map_err(at())?;
        let stage = Scratch::beside(&place).map_err(at())?;
        self.write_in(others, stage.path())?;
        stage.persist(&place).map_err(at())
    }

    /// Replaces the files in a directory, all or none.
    fn write_in(&self, others: &[(&str, &str)], directory: &Path) -> Result<(), WriteError> {
        let mut texts = self.texts(directory);
        // Stale contacts would start the next run with springs that are no more.
        let stale = self.files_written(directory).split_off(texts.len());
        texts.extend(others.iter().map(|(name, text)| (directory.join(name), (*text).to_owned())));
        for parent in texts.iter().filter_map(|(path, _)| path.parent()) {
            make_directories(parent).map_err(WriteError::at(parent))?;
        }
        let changes = texts.into_iter().map(|(path, text)| Change::Write(path, text));
        change_all(&changes.chain(stale.into_iter().map(Change::Remove)).collect::<Vec<_>>())
    }
}

/// Returns whether a directory of Parameters.xml lies in the Trial directory.
fn is_inside(named: &str) -> bool {
    let mut components = Path::new(named.trim()).components();
    components.all(|component| matches!(component, Component::Normal(_) | Component::CurDir))
}

/// Returns the name; that of `.` or `..` is that of the directory meant.
fn own_name(directory: &Path) -> String {
    let name = |path: &Path| path.file_name().map(|name| name.to_string_lossy().into_owned());
    name(directory).or_else(|| name(&directory.canonicalize().ok()?)).unwrap_or_else(|| "Trial".into())
}

/// Returns the names of the two files of a communication point \[s\] in an `OutputDirectory`: dynamics, interactions.
pub fn output_names(time: f64) -> [String; 2] {
    let time = output_time(time);
    [format!("AgentDynamics output t={time}.xml"), format!("AgentInteractions t={time}.xml")]
}

/// Writes a time \[s\] as the paper's script writes it into file names, with as many decimals as it needs.
fn output_time(time: f64) -> String {
    let rounded = (time * 1e9).round() / 1e9;
    if (rounded * 10.0).fract() == 0.0 { format!("{rounded:.1}") } else { format!("{rounded}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn output_times_are_the_scripts_where_those_are_exact() {
        assert_eq!(output_time(0.1 + 0.2), "0.3");
        assert_eq!(output_time(1.0), "1.0");
        assert_eq!(output_time(0.05), "0.05");
        assert_eq!(output_time(2.65), "2.65");
    }
}
