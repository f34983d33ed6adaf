//! The *Trial* directory: the XML files of the paper's section 3.1 and App. C, as typed documents.
//!
//! A [`Trial`] holds what the files say, in their own words and order, checked. It becomes an
//! engine world by [`Trial::world`]; a parameter of the FMU is an edit of this document.

mod advice;
mod agents;
mod dynamics;
mod geometry;
mod interactions;
mod materials;
mod parameters;
mod plausible;
mod problem;
mod world;
mod xml;

pub use dynamics::{Drive, dynamics_xml};
pub use interactions::interactions_xml;
pub use materials::stiffness;
pub use problem::{Problem, Problems, Severity};
pub use world::{WorldError, dynamics_of, interactions_of};

use crate::engine::Vec2;
use crate::files::{WriteError, write_atomically};
use advice::Files;
use std::io::ErrorKind;
use std::path::{Component, Path, PathBuf};

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

/// `Parameters.xml`.
#[derive(Debug, Clone, PartialEq)]
pub struct Parameters {
    /// `Directories/Static`, as written; relative to the Trial directory.
    pub static_directory: String,
    /// `Directories/Dynamic`, as written; relative to the Trial directory.
    pub dynamic_directory: String,
    /// \[s\] `Times/TimeStep`: duration of one decisional loop, the communication step.
    pub time_step: f64,
    /// \[s\] `Times/TimeStepMechanical`: step of the integrator, at most `time_step`.
    pub time_step_mechanical: f64,
}

impl Parameters {
    /// The Static directory, relative to the Trial directory.
    pub fn static_path(&self) -> &Path {
        Path::new(self.static_directory.trim())
    }

    /// The Dynamic directory, relative to the Trial directory.
    pub fn dynamic_path(&self) -> &Path {
        Path::new(self.dynamic_directory.trim())
    }
}

/// `Materials.xml`.
#[derive(Debug, Clone, PartialEq)]
pub struct Materials {
    /// `<Intrinsic>`
    pub intrinsic: Vec<Material>,
    /// `<Binary>`
    pub binary: Vec<Contact>,
}

/// `<Material>`.
#[derive(Debug, Clone, PartialEq)]
pub struct Material {
    /// Unique among the materials.
    pub id: String,
    /// \[N/m\] 2D Young modulus.
    pub young_modulus: f64,
    /// \[N/m\] 2D shear modulus.
    pub shear_modulus: f64,
}

/// `<Contact>`: what two materials do to each other; the order of the two does not matter.
#[derive(Debug, Clone, PartialEq)]
pub struct Contact {
    /// First material.
    pub id1: String,
    /// Second material, perhaps the same.
    pub id2: String,
    /// \[kg/s\] damping along the normal.
    pub gamma_normal: f64,
    /// \[kg/s\] damping along the tangent.
    pub gamma_tangential: f64,
    /// \[1\] Coulomb's coefficient.
    pub kinetic_friction: f64,
}

/// `Geometry.xml`.
#[derive(Debug, Clone, PartialEq)]
pub struct Geometry {
    /// \[m\] `<Dimensions Lx Ly>`: the size of the drawn area; the mechanics does not use it.
    pub dimensions: Option<Vec2>,
    /// In file order.
    pub walls: Vec<Wall>,
}

impl Geometry {
    /// Reads and checks a file of its own, whose materials nobody knows: its walls with the warnings, or all that is
    /// wrong with it.
    ///
    /// # Errors
    /// Errors in the file.
    pub fn read(path: &Path) -> Result<(Geometry, Problems), Problems> {
        let mut problems = Problems::default();
        let read = xml::read_file(path, "Geometry", &mut problems, |root, problems| {
            geometry::read(root, None, problems).0
        });
        match read {
            Some(geometry) if !problems.has_errors() => Ok((geometry, problems)),
            _ => Err(problems),
        }
    }
}

/// `<Wall>`: a polyline without thickness, solid from both sides.
#[derive(Debug, Clone, PartialEq)]
pub struct Wall {
    /// Unique among the walls.
    pub id: String,
    /// Id of its material.
    pub material_id: String,
    /// \[m\] at least two; closed when the first stands again at the end.
    pub corners: Vec<Vec2>,
}

/// `<Agent>` of `Agents.xml`.
#[derive(Debug, Clone, PartialEq)]
pub struct Agent {
    /// `Type`, as written ("pedestrian").
    pub kind: Option<String>,
    /// Unique among the agents.
    pub id: String,
    /// \[kg\]
    pub mass: f64,
    /// \[m\] stature; the mechanics does not use it.
    pub height: Option<f64>,
    /// \[kg.m2\] about the centre of mass.
    pub moment_of_inertia: f64,
    /// \[1/s\] relaxation rate 1/t_transl, ≥ 0.
    pub floor_damping: f64,
    /// \[1/s\] relaxation rate 1/t_rot, ≥ 0.
    pub angular_damping: f64,
    /// At least one; from the left shoulder to the right one.
    pub shapes: Vec<Shape>,
}

/// `<Shape>`: a disk.
#[derive(Debug, Clone, PartialEq)]
pub struct Shape {
    /// \[m\]
    pub radius: f64,
    /// Id of its material.
    pub material_id: String,
    /// \[m\] offset from the centre of mass, at the orientation that the shapes themselves show.
    pub position: Vec2,
}

/// `<Agent>` of `AgentDynamics.xml`.
#[derive(Debug, Clone, PartialEq)]
pub struct AgentDynamics {
    /// \[m\] centre of mass.
    pub position: Vec2,
    /// \[m/s\]
    pub velocity: Vec2,
    /// \[rad\] direction of the gaze.
    pub theta: f64,
    /// \[rad/s\]
    pub omega: f64,
    /// \[N\] propulsion force; zero where the file has no `<Dynamics>`.
    pub fp: Vec2,
    /// \[N.m\] propulsion torque.
    pub mp: f64,
}

/// `AgentInteractions.xml`: the contacts at one instant, each pair once.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Interactions {
    /// Between two agents.
    pub agents: Vec<AgentInteraction>,
    /// Between an agent and a wall.
    pub walls: Vec<WallInteraction>,
}

/// `<Interaction>`: one contact of two agents. Agents and shapes are 0-based places in `Agents.xml`.
#[derive(Debug, Clone, PartialEq)]
pub struct AgentInteraction {
    /// Place of the agent that receives the force; the lower of the two.
    pub parent: usize,
    /// Place of the other agent.
    pub child: usize,
    /// Place of the parent's disk among its shapes.
    pub parent_shape: usize,
    /// Place of the child's disk among its shapes.
    pub child_shape: usize,
    /// Forces on the parent and its spring.
    pub force: ContactForce,
}

/// `<Wall>` of `AgentInteractions.xml`: one contact of an agent with a wall.
#[derive(Debug, Clone, PartialEq)]
pub struct WallInteraction {
    /// Place of the agent, which receives the force.
    pub agent: usize,
    /// `ShapeId`: place of the disk among the agent's shapes.
    pub shape: usize,
    /// Place of the wall in `Geometry.xml` (the file holds its Id).
    pub wall: usize,
    /// `CornerId`: place, among the wall's corners, of the corner where the touched face begins.
    pub corner: usize,
    /// Forces on the agent and its spring.
    pub force: ContactForce,
}

/// What a contact does to the agent that receives the force.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactForce {
    /// \[m\] `TangentialRelativeDisplacement`: elongation of the tangential spring.
    pub elongation: Vec2,
    /// \[N\] `Fn`
    pub normal: Vec2,
    /// \[N\] `Ft`
    pub tangential: Vec2,
}

/// Names of the Trial's files.
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

/// The contacts' file in the Dynamic directory; there only if there are contacts.
pub const INTERACTIONS: &str = "AgentInteractions.xml";

impl Trial {
    /// Reads and checks a Trial directory: the Trial with the warnings, or all that is wrong with it.
    pub fn read(directory: &Path) -> Result<(Trial, Problems), Problems> {
        Trial::read_named(directory, &FileNames::default())
    }

    /// The files of which [`Trial::read`] reads a directory, whether they are there or not.
    pub fn files_read(directory: &Path) -> Vec<PathBuf> {
        let names = FileNames::default();
        let first = directory.join(&names.parameters);
        // What is wrong with it those say who read the Trial.
        let parameters = xml::read_file(&first, "Parameters", &mut Problems::default(), parameters::read);
        let Some(parameters) = parameters else { return vec![first] };
        let fixed = directory.join(parameters.static_path());
        let moving = directory.join(parameters.dynamic_path());
        names.places(directory, &fixed, &moving)
    }

    /// As [`Trial::read`], with other file names.
    pub fn read_named(directory: &Path, names: &FileNames) -> Result<(Trial, Problems), Problems> {
        let mut problems = Problems::default();
        match Trial::read_checked(directory, names, &mut problems) {
            Some(trial) if !problems.has_errors() => {
                let parameters = tidy(&directory.join(&names.parameters));
                let fixed = directory.join(trial.parameters.static_path());
                let (agents, geometry) = (fixed.join(&names.agents), fixed.join(&names.geometry));
                let dynamics = directory.join(trial.parameters.dynamic_path()).join(&names.dynamics);
                for problem in trial.advice(&Files {
                    parameters: &parameters,
                    agents: &tidy(&agents),
                    geometry: &tidy(&geometry),
                    dynamics: &tidy(&dynamics),
                }) {
                    problems.push(problem);
                }
                if problems.has_errors() { Err(problems) } else { Ok((trial, problems)) }
            }
            _ => Err(problems),
        }
    }

    /// `None` only after an error. A file is checked against the others as far as those could be read.
    fn read_checked(directory: &Path, names: &FileNames, problems: &mut Problems) -> Option<Trial> {
        let parameters =
            xml::read_file(&directory.join(&names.parameters), "Parameters", problems, parameters::read)?;
        // Without them, reported already, nobody knows where the other files are.
        let place = |named: &str| (!named.trim().is_empty()).then(|| tidy(&directory.join(named.trim())));
        let fixed = place(&parameters.static_directory);
        let moving = place(&parameters.dynamic_directory);

        let materials = fixed.as_ref().and_then(|fixed| {
            xml::read_file(&fixed.join(&names.materials), "Materials", problems, materials::read)
        });
        let material_ids = materials.as_ref().map(|read| &read.ids);
        let geometry = fixed.as_ref().and_then(|fixed| {
            xml::read_file(&fixed.join(&names.geometry), "Geometry", problems, |root, problems| {
                geometry::read(root, material_ids, problems)
            })
        });
        let agents = fixed.as_ref().and_then(|fixed| {
            xml::read_file(&fixed.join(&names.agents), "Agents", problems, |root, problems| {
                agents::read(root, material_ids, problems)
            })
        });
        if let (Some(materials), Some((agents, _))) = (&materials, &agents) {
            materials::check_pairs(
                materials,
                geometry.as_ref().map(|(geometry, _)| geometry),
                agents,
                problems,
            );
        }
        let dynamics = moving.as_ref().and_then(|moving| {
            xml::read_file(&moving.join(&names.dynamics), "Agents", problems, |root, problems| {
                dynamics::read(root, agents.as_ref().map(|(agents, ids)| (agents.as_slice(), ids)), problems)
            })
        });
        let interactions = match (moving.map(|moving| moving.join(INTERACTIONS)), &agents, &geometry) {
            (Some(path), Some((agents, agent_ids)), Some((geometry, wall_ids)))
                if !matches!(path.try_exists(), Ok(false)) =>
            {
                xml::read_file(&path, "Interactions", problems, |root, problems| {
                    interactions::read(root, (agents, agent_ids), (geometry, wall_ids), problems)
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
    /// All that is wrong with it.
    pub fn read_dynamics(&self, path: &Path) -> Result<Vec<AgentDynamics>, Problems> {
        let ids = self.agent_ids();
        checked(|problems| {
            xml::read_file(path, "Agents", problems, |root, problems| {
                dynamics::read(root, Some((&self.agents, &ids)), problems)
            })
        })
    }

    /// Reads an `AgentInteractions.xml` of this Trial's agents and walls.
    ///
    /// # Errors
    /// All that is wrong with it.
    pub fn read_interactions(&self, path: &Path) -> Result<Interactions, Problems> {
        let agents = self.agent_ids();
        let walls = xml::Ids::of(self.geometry.walls.iter().map(|wall| wall.id.as_str()));
        checked(|problems| {
            xml::read_file(path, "Interactions", problems, |root, problems| {
                interactions::read(root, (&self.agents, &agents), (&self.geometry, &walls), problems)
            })
        })
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

    /// The files that [`Trial::write`] writes into a directory; the last one, the contacts, perhaps goes.
    pub fn files_written(&self, directory: &Path) -> Vec<PathBuf> {
        let (_, fixed, moving) = self.places_in(directory);
        FileNames::default().places(directory, &fixed, &moving)
    }

    /// Writes a complete Trial directory, each file whole or not at all.
    ///
    /// Static and Dynamic directories that lie outside the Trial directory become `./static/` and `./dynamic/`
    /// in it: a copy neither overwrites the original's files nor depends on them.
    pub fn write(&self, directory: &Path) -> Result<(), WriteError> {
        let (parameters, fixed, moving) = self.places_in(directory);
        for path in [directory, &fixed, &moving] {
            std::fs::create_dir_all(path).map_err(|error| WriteError { path: path.to_owned(), error })?;
        }
        let names = FileNames::default();
        write_atomically(&directory.join(names.parameters), &parameters::xml(&parameters))?;
        write_atomically(&fixed.join(names.materials), &materials::xml(&self.materials))?;
        write_atomically(&fixed.join(names.geometry), &geometry::xml(&self.geometry))?;
        write_atomically(&fixed.join(names.agents), &agents::xml(&self.agents))?;
        write_atomically(
            &moving.join(names.dynamics),
            &dynamics_xml(&self.agents, &self.dynamics, Drive::Written),
        )?;
        let path = moving.join(INTERACTIONS);
        if self.interactions != Interactions::default() {
            return write_atomically(&path, &interactions_xml(self, &self.interactions));
        }
        // A stale one would start the next run with springs that are no more.
        match std::fs::remove_file(&path) {
            Err(error) if error.kind() != ErrorKind::NotFound => Err(WriteError { path, error }),
            _ => Ok(()),
        }
    }
}

fn checked<T>(read: impl FnOnce(&mut Problems) -> Option<T>) -> Result<T, Problems> {
    let mut problems = Problems::default();
    match read(&mut problems) {
        Some(read) if !problems.has_errors() => Ok(read),
        _ => Err(problems),
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
