//! The directory: its files, read and checked together, and written.

use crate::files::source::{Disk, Source};
use crate::files::{WriteError, write_atomically};
use crate::trial::agents::{self, Agent};
use crate::trial::dynamics::{self, AgentDynamics, DynamicsElement, dynamics_xml};
use crate::trial::geometry::{self, Geometry};
use crate::trial::interactions::{self, Interactions, interactions_xml};
use crate::trial::materials::{self, Materials};
use crate::trial::parameters::{self, Parameters};
use crate::trial::problem::Problems;
use crate::trial::schema::Schema;
use crate::trial::xml::{self, Element, checked};
use std::io::ErrorKind;
use std::path::{Component, Path, PathBuf};
use uuid::Uuid;

/// A Trial directory, read and checked.
#[derive(Debug, Clone, PartialEq)]
pub struct Trial {
    /// The directory's own name.
    pub name: String,
    /// Where it was read from.
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
        }
    }
}

impl FileNames {
    fn places(&self, directory: &Path, fixed: &Path, moving: &Path) -> Vec<PathBuf> {
        let fixed = [&self.materials, &self.geometry, &self.agents].map(|name| fixed.join(name));
        let moving = [&self.dynamics, Path::new(INTERACTIONS)].map(|name| moving.join(name));
        std::iter::once(directory.join(&self.parameters)).chain(fixed).chain(moving).collect()
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

/// The contacts' file in the Dynamic directory; there only if there are contacts.
pub const INTERACTIONS: &str = "AgentInteractions.xml";

impl Trial {
    /// Reads and checks a Trial directory: the Trial with the warnings, or all that is wrong with it. What may be a mistake
    /// in its mechanics is not looked at here (`crowd_mechanics::setup::read` does).
    ///
    /// # Errors
    /// Errors in its files, all of them.
    pub fn read(directory: &Path) -> Result<(Trial, Problems), Problems> {
        Trial::read_from(&Disk, directory, &FileNames::default())
    }

    /// The files of which [`Trial::read`] reads a directory, whether they are there or not.
    pub fn files_read(directory: &Path) -> Vec<PathBuf> {
        let names = FileNames::default();
        let first = directory.join(&names.parameters);
        // What is wrong with it those say who read the Trial.
        let parameters = xml::read_file(
            &Disk,
            &first,
            &parameters::PARAMETERS,
            &mut Problems::default(),
            parameters::read,
        );
        let Some(parameters) = parameters else { return vec![first] };
        let fixed = directory.join(parameters.static_path());
        let moving = directory.join(parameters.dynamic_path());
        names.places(directory, &fixed, &moving)
    }

    /// As [`Trial::read`], from these files, with these names.
    ///
    /// # Errors
    /// As [`Trial::read`].
    pub fn read_from(
        files: &dyn Source,
        directory: &Path,
        names: &FileNames,
    ) -> Result<(Trial, Problems), Problems> {
        checked(|problems| Trial::read_checked(files, directory, names, problems))
    }

    /// Where its files are, as messages name them.
    pub fn places(&self, names: &FileNames) -> FileNames {
        let fixed = self.directory.join(self.parameters.static_path());
        let moving = self.directory.join(self.parameters.dynamic_path());
        FileNames {
            parameters: tidy(&self.directory.join(&names.parameters)),
            materials: tidy(&fixed.join(&names.materials)),
            geometry: tidy(&fixed.join(&names.geometry)),
            agents: tidy(&fixed.join(&names.agents)),
            dynamics: tidy(&moving.join(&names.dynamics)),
        }
    }

    /// `None` only after an error. A file is checked against the others as far as those could be read.
    fn read_checked(
        files: &dyn Source,
        directory: &Path,
        names: &FileNames,
        problems: &mut Problems,
    ) -> Option<Trial> {
        let parameters = xml::read_file(
            files,
            &directory.join(&names.parameters),
            &parameters::PARAMETERS,
            problems,
            parameters::read,
        )?;
        // Without them, reported already, nobody knows where the other files are.
        let place = |named: &str| (!named.trim().is_empty()).then(|| tidy(&directory.join(named.trim())));
        let fixed = place(&parameters.static_directory);
        let moving = place(&parameters.dynamic_directory);

        let mut reader = Reader { files, problems };
        let materials = reader.read(&fixed, &names.materials, &materials::MATERIALS, materials::read);
        let material_ids = materials.as_ref().map(|read| &read.ids);
        let geometry = reader
            .read(&fixed, &names.geometry, &geometry::GEOMETRY, |root| geometry::read(root, material_ids));
        let agents =
            reader.read(&fixed, &names.agents, &agents::AGENTS, |root| agents::read(root, material_ids));
        if let (Some(materials), Some((agents, _))) = (&materials, &agents) {
            let geometry = geometry.as_ref().map(|(geometry, _)| geometry);
            materials::check_pairs(materials, geometry, agents, reader.problems);
        }
        let known = agents.as_ref().map(|(agents, ids)| (agents.as_slice(), ids));
        let dynamics =
            reader.read(&moving, &names.dynamics, &dynamics::AGENTS, |root| dynamics::read(root, known));
        let path = moving.as_ref().map(|moving| moving.join(INTERACTIONS));
        let interactions = match (path, known, &geometry) {
            (Some(path), Some(agents), Some((geometry, wall_ids))) if !files.lacks(&path) => {
                reader.read(&moving, Path::new(INTERACTIONS), &interactions::INTERACTIONS, |root| {
                    interactions::read(root, agents, (geometry, wall_ids))
                })?
            }
            _ => Interactions::default(),
        };
        Some(Trial {
            name: own_name(directory),
            directory: directory.to_owned(),
            parameters,
            materials: materials?.materials,
            geometry: geometry?.0,
            agents: agents?.0,
            dynamics: dynamics?,
            interactions,
        })
    }

    /// Reads an `AgentDynamics.xml` of this Trial's agents, in their order.
    ///
    /// # Errors
    /// All errors in its files.
    pub fn read_dynamics(&self, path: &Path) -> Result<Vec<AgentDynamics>, Problems> {
        let ids = self.agent_ids();
        read_alone(path, &dynamics::AGENTS, |root| dynamics::read(root, Some((&self.agents, &ids))))
    }

    /// Reads an `AgentInteractions.xml` of this Trial's agents and walls.
    ///
    /// # Errors
    /// All errors in its files.
    pub fn read_interactions(&self, path: &Path) -> Result<Interactions, Problems> {
        let agents = self.agent_ids();
        let walls = xml::Ids::of(self.geometry.walls.iter().map(|wall| wall.id.as_str()));
        let (agents, walls) = ((&self.agents[..], &agents), (&self.geometry, &walls));
        read_alone(path, &interactions::INTERACTIONS, |root| interactions::read(root, agents, walls))
    }

    fn agent_ids(&self) -> xml::Ids {
        xml::Ids::of(self.agents.iter().map(|agent| agent.id.as_str()))
    }

    /// The parameters of a copy in this directory, and its Static and Dynamic directories.
    fn places_in(&self, directory: &Path) -> (Parameters, PathBuf, PathBuf) {
        let mut parameters = self.parameters.clone();
        for (named, own) in [
            (&mut parameters.static_directory, "./static/"),
            (&mut parameters.dynamic_directory, "./dynamic/"),
        ] {
            if !is_inside(named) {
                *named = own.into();
            }
        }
        let fixed = tidy(&directory.join(parameters.static_directory.trim()));
        let moving = tidy(&directory.join(parameters.dynamic_directory.trim()));
        (parameters, fixed, moving)
    }

    /// Tells one Trial from another by its content: the name-based UUID (version 5) of its files' texts, as
    /// [`Trial::write`] writes them. Neither its name nor where it was read from counts.
    pub fn fingerprint(&self) -> u128 {
        let mut content = Vec::new();
        for text in [
            self.parameters.xml(),
            materials::xml(&self.materials),
            geometry::xml(&self.geometry),
            agents::xml(&self.agents),
            dynamics_xml(&self.agents, &self.dynamics, DynamicsElement::Written),
            interactions_xml(&self.agents, &self.geometry, &self.interactions),
        ] {
            // With its length: where one text ends and the next begins counts.
            content.extend((text.len() as u64).to_le_bytes());
            content.extend(text.into_bytes());
        }
        Uuid::new_v5(&Uuid::NAMESPACE_OID, &content).as_u128()
    }

    /// The files that [`Trial::write`] writes into a directory; the last one, the contacts, perhaps goes.
    pub fn files_written(&self, directory: &Path) -> Vec<PathBuf> {
        let (_, fixed, moving) = self.places_in(directory);
        FileNames::default().places(directory, &fixed, &moving)
    }

    /// Its files as [`Trial::write`] writes them into a directory: their paths and texts.
    pub fn texts(&self, directory: &Path) -> Vec<(PathBuf, String)> {
        let (parameters, fixed, moving) = self.places_in(directory);
        let names = FileNames::default();
        let dynamics = dynamics_xml(&self.agents, &self.dynamics, DynamicsElement::Written);
        let mut texts = vec![
            (directory.join(names.parameters), parameters.xml()),
            (fixed.join(names.materials), materials::xml(&self.materials)),
            (fixed.join(names.geometry), geometry::xml(&self.geometry)),
            (fixed.join(names.agents), agents::xml(&self.agents)),
            (moving.join(names.dynamics), dynamics),
        ];
        if self.interactions != Interactions::default() {
            let text = interactions_xml(&self.agents, &self.geometry, &self.interactions);
            texts.push((moving.join(INTERACTIONS), text));
        }
        texts
    }

    /// Writes a complete Trial directory, each file whole or not at all.
    ///
    /// Static and Dynamic directories that lie outside the Trial directory become `./static/` and `./dynamic/`
    /// in it: a copy neither overwrites the original's files nor depends on them.
    pub fn write(&self, directory: &Path) -> Result<(), WriteError> {
        let (_, fixed, moving) = self.places_in(directory);
        for path in [directory, &fixed, &moving] {
            crate::files::make_directories(path)
                .map_err(|error| WriteError { path: path.to_owned(), error })?;
        }
        for (path, text) in self.texts(directory) {
            write_atomically(&path, &text)?;
        }
        if self.interactions != Interactions::default() {
            return Ok(());
        }
        // A stale one would start the next run with springs that are no more.
        let path = moving.join(INTERACTIONS);
        match std::fs::remove_file(&path) {
            Err(error) if error.kind() != ErrorKind::NotFound => Err(WriteError { path, error }),
            _ => Ok(()),
        }
    }
}

/// Reads one file of a Trial.
fn read_alone<T>(
    path: &Path,
    schema: &'static Schema,
    read: impl FnOnce(Element<'_>) -> T,
) -> Result<T, Problems> {
    checked(|problems| xml::read_file(&Disk, path, schema, problems, read)).map(|(read, _)| read)
}

/// Reads files of a Trial; where one cannot be read, the problem is told and the others are read nevertheless.
struct Reader<'a> {
    files: &'a dyn Source,
    problems: &'a mut Problems,
}

impl Reader<'_> {
    /// `None` also if the directory is not known, which was told already.
    fn read<T>(
        &mut self,
        directory: &Option<PathBuf>,
        name: &Path,
        root: &'static Schema,
        then: impl FnOnce(Element<'_>) -> T,
    ) -> Option<T> {
        xml::read_file(self.files, &directory.as_ref()?.join(name), root, self.problems, then)
    }
}

/// Without `.` in between: `Trial/./static` is `Trial/static`.
fn tidy(path: &Path) -> PathBuf {
    path.components().collect()
}

/// Whether a directory of Parameters.xml lies in the Trial directory.
fn is_inside(named: &str) -> bool {
    let mut components = Path::new(named.trim()).components();
    components.all(|component| matches!(component, Component::Normal(_) | Component::CurDir))
}

/// The name of `.` or `..` is that of the directory meant.
fn own_name(directory: &Path) -> String {
    let name = |path: &Path| path.file_name().map(|name| name.to_string_lossy().into_owned());
    name(directory).or_else(|| name(&directory.canonicalize().ok()?)).unwrap_or_else(|| "Trial".into())
}

/// The names of the two files of a communication point \[s\] in an `OutputDirectory`: dynamics, interactions.
pub fn output_names(time: f64) -> [String; 2] {
    let time = output_time(time);
    [format!("AgentDynamics output t={time}.xml"), format!("AgentInteractions t={time}.xml")]
}

/// A time \[s\] as the paper's script writes it into file names, with as many decimals as it needs.
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
