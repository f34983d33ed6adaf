//! Makes a Trial of a crowd: all its files, ready to be checked, packed and run.
//!
//! Materials, damping and floor are the paper's (App. C, and its table of parameters). The offsets of a shape are
//! relative to the centroid of its area: the centre of mass of a body of uniform density. The moment of inertia is about
//! this point. Numbers are written so that they are read back as the same doubles.

use crate::error::{Result, require};
use crate::kinds::BodyDisk;
use crate::levels::{Slabs, chest_height};
use crate::materials::{SKINS, materials, paper_materials};
use crate::shape::Shape;
use crowd_mechanics::setup::Setup;
use lemons_core::files::{Staged, WriteError};
use lemons_core::plane::{Motion, Pose, Ring, Vec2, rotation, vec2};
use lemons_core::trial::{Agent, AgentDynamics, Geometry, Interactions, Materials, Parameters, Trial, Wall};
use std::collections::HashSet;
use std::io::{self, Seek, Write};
use std::path::{Path, PathBuf};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipWriter};

/// \[1/s\] Inverse times of translational and rotational friction on the floor: the paper's App. C.
pub(crate) const FLOOR_DAMPING: f64 = 4.5;

/// The settings of a Trial besides its people and their poses.
#[derive(Debug, Clone, PartialEq)]
pub struct TrialSettings {
    /// \[s\] communication step, positive. The mechanical step is the longest that divides it and does not exceed
    /// [`proposed_step`](crowd_mechanics::setup::Setup::proposed_step).
    pub time_step: f64,
    /// Id of the material of all disks: one of [`SKINS`].
    pub people: String,
    /// \[m/s\] Velocity that each agent would reach alone: the propulsion force is m v / t_transl (the paper's eq. 4).
    /// Zero: no propulsion.
    pub desired_velocity: Vec2,
    /// People in levels, whose load on the chest is an output; without it they are as in the plan.
    pub slabs: Option<Slabs>,
}

impl Default for TrialSettings {
    /// The paper's App. C: people without clothes, at rest, without propulsion; 10 ms between two decisions.
    fn default() -> TrialSettings {
        TrialSettings {
            time_step: 0.01,
            people: "human_naked".into(),
            desired_velocity: Vec2::zeros(),
            slabs: None,
        }
    }
}

/// Returns closed walls \[m\] of one material: the outline of a region, then its holes. Its dimensions are those of the
/// first wall; the drawn area begins at the origin, as in the paper's files. Without rings: the open plane.
pub fn walls(rings: &[Ring], material: &str) -> Geometry {
    let wall = |(id, ring): (usize, &Ring)| Wall::new(id.to_string(), material, ring.closed().to_vec());
    let dimensions = rings.first().map(|ring| ring.bounds().size());
    Geometry { dimensions, walls: rings.iter().enumerate().map(wall).collect(), ..Geometry::default() }
}

/// The unit vector in a direction, in degrees counter-clockwise from the x axis; exact along the axes.
pub fn heading(degrees: f64) -> Vec2 {
    match degrees.rem_euclid(360.0) {
        0.0 => vec2(1.0, 0.0),
        90.0 => vec2(0.0, 1.0),
        180.0 => vec2(-1.0, 0.0),
        270.0 => vec2(0.0, -1.0),
        _ => rotation(degrees.to_radians()) * vec2(1.0, 0.0),
    }
}

/// Makes the Trial of a crowd at its poses, at rest. An Id is the place in the crowd, from 0.
///
/// # Errors
/// A person has no shape, or a material is unknown.
pub fn crowd_trial(
    name: &str,
    crowd: &[(crate::CrowdMember, Pose)],
    geometry: Geometry,
    settings: &TrialSettings,
) -> Result<Trial> {
    settings.check(&geometry)?;
    let (mut agents, mut dynamics) = (Vec::new(), Vec::new());
    for (id, (agent, pose)) in crowd.iter().enumerate() {
        let body = body(agent, id, settings)?;
        let at_rest = AgentDynamics::of(&Motion { pose: *pose, ..Motion::default() });
        let fp = settings.desired_velocity * (body.mass * FLOOR_DAMPING);
        agents.push(body);
        dynamics.push(AgentDynamics { fp, ..at_rest });
    }
    let mut trial = Trial {
        name: name.into(),
        directory: PathBuf::new(),
        parameters: Parameters {
            static_directory: "./static/".into(),
            dynamic_directory: "./dynamic/".into(),
            time_step: settings.time_step,
            time_step_mechanical: settings.time_step,
        },
        materials: settings.materials(&geometry, &agents),
        geometry,
        agents,
        dynamics,
        interactions: Interactions::default(),
    };
    choose_mechanical_step(&mut trial);
    Ok(trial)
}

/// The body of an agent in `Agents.xml`.
fn body(agent: &crate::CrowdMember, id: usize, settings: &TrialSettings) -> Result<Agent> {
    let (kind, stature, mass, inertia) = match agent {
        crate::CrowdMember::Pedestrian(person) => {
            let inertia = Shape::of(person)?.inertia(person.mass);
            (None, person.stature, person.mass, inertia)
        }
        crate::CrowdMember::Member(member) => {
            let (person, _) = member.people[0];
            (Some(&member.kind), person.stature, member.mass, member.inertia)
        }
    };
    let disks = settings.slabs.as_ref().map_or_else(|| agent.disks(), |slabs| slabs.disks(agent))?;
    let chest_height = settings.slabs.as_ref().and_then(|_| chest_height(agent, &disks));
    let shape = |BodyDisk { disk, material, heights }: BodyDisk| lemons_core::trial::ShapeElement {
        radius: disk.radius,
        material_id: material.unwrap_or_else(|| settings.people.clone()),
        position: disk.centre,
        heights,
    };
    Ok(Agent {
        agent_type: Some("pedestrian".into()),
        kind: kind.map(|kind| kind.name.clone()),
        id: id.to_string(),
        mass,
        height: Some(stature),
        moment_of_inertia: inertia,
        floor_damping: FLOOR_DAMPING,
        floor_damping_across: kind.and_then(|kind| kind.floor_damping_across),
        angular_damping: FLOOR_DAMPING,
        chest_height,
        shapes: disks.into_iter().map(shape).collect(),
    })
}

/// \[s\] Returns the longest mechanical step that divides a Trial's communication step and does not exceed
/// [`proposed_step`](Setup::proposed_step).
pub fn mechanical_step_for(trial: &Trial) -> f64 {
    let (step, proposed) = (trial.parameters.time_step, Setup::of(trial).proposed_step());
    // The tolerance is for a quotient that is an integer except for rounding.
    step / (step / proposed.unwrap_or(step) - 1e-9).ceil().max(1.0)
}

/// Gives a Trial [this mechanical step](mechanical_step_for).
pub fn choose_mechanical_step(trial: &mut Trial) {
    trial.parameters.time_step_mechanical = mechanical_step_for(trial);
}

impl TrialSettings {
    /// Returns the paper's materials, and the others that somebody or a wall has.
    fn materials(&self, geometry: &Geometry, agents: &[Agent]) -> Materials {
        let of_walls = geometry.walls.iter().map(|wall| &wall.material_id);
        let of_disks = agents.iter().flat_map(|agent| &agent.shapes).map(|disk| &disk.material_id);
        let used: HashSet<&String> = of_walls.chain(of_disks).chain([&self.people]).collect();
        let paper = paper_materials().intrinsic;
        let has = |id: &String| used.contains(id) || paper.iter().any(|material| material.id == *id);
        let Materials { mut intrinsic, mut binary, load_length } = materials();
        intrinsic.retain(|material| has(&material.id));
        binary.retain(|contact| has(&contact.id1) && has(&contact.id2));
        let load_length = self.slabs.as_ref().and_then(Slabs::load_length).unwrap_or(load_length);
        Materials { load_length, intrinsic, binary }
    }

    /// Checks that people and walls are of known materials; each of these has contacts with all others.
    ///
    /// # Errors
    /// A material is unknown.
    pub fn check(&self, geometry: &Geometry) -> Result<()> {
        let materials = materials().intrinsic;
        let known: Vec<&str> = materials.iter().map(|material| &*material.id).collect();
        let check = |what: &str, id: &str, known: &[&str]| {
            Ok(require(known.contains(&id), || {
                format!("{what}: there is no material {id:?}; materials are {}", known.join(", "))
            })?)
        };
        check("people", &self.people, &SKINS)?;
        let wall = |wall: &Wall| check(&format!("wall {}", wall.id), &wall.material_id, &known);
        geometry.walls.iter().try_for_each(wall)
    }
}

/// Checks that a Trial may be written to a path; by `force` also into a directory with other files, which stay.
/// [`write_trial`] checks it too.
///
/// # Errors
/// There is a file, or a directory that is neither empty nor a Trial.
pub fn may_write(directory: &Path, force: bool) -> Result<()> {
    let at = WriteError::at(directory);
    match directory.metadata() {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(()),
        Err(error) => return Err(at(error).into()),
        Ok(there) => {
            require(there.is_dir(), || format!("{}: is not a directory", directory.display()))?;
        }
    }
    if force || directory.join("Parameters.xml").is_file() {
        return Ok(());
    }
    let is_empty = std::fs::read_dir(directory).map_err(at)?.next().is_none();
    Ok(require(is_empty, || {
        format!("{}: is a directory that is not a Trial; use --force to write into it", directory.display())
    })?)
}

/// Writes a Trial directory as [`Trial::write_with`] does, with names and texts of other files.
///
/// # Errors
/// The existing files may not be or cannot be overwritten; they are then unchanged.
pub fn write_trial(trial: &Trial, others: &[(&str, &str)], directory: &Path, force: bool) -> Result<()> {
    may_write(directory, force)?;
    Ok(trial.write_with(others, directory)?)
}

/// The files of a Trial that [`crowd_trial`] makes, and the one that [`write_trial`] removes.
pub const TRIAL_FILES: [&str; 6] = [
    "Parameters.xml",
    "static/Materials.xml",
    "static/Geometry.xml",
    "static/Agents.xml",
    "dynamic/AgentDynamics.xml",
    "dynamic/AgentInteractions.xml",
];

/// Writes a Trial as a zip archive that contains its directory. The same Trial gives the same bytes. `others` are further
/// files of the directory, with their names.
///
/// # Errors
/// The file cannot be written; an existing one is then unchanged.
pub fn write_trial_zip(trial: &Trial, others: &[(&str, &str)], file: &Path) -> Result<()> {
    let staged = Staged::beside(file).map_err(WriteError::at(file))?;
    let staged = zip_trial(trial, others, staged).map_err(WriteError::at(file))?;
    Ok(staged.persist().map_err(WriteError::at(file))?)
}

/// Writes the archive of [`write_trial_zip`] to `output`, and returns it.
///
/// # Errors
/// It cannot be written.
pub fn zip_trial<W: Write + Seek>(trial: &Trial, others: &[(&str, &str)], output: W) -> io::Result<W> {
    let mut archive = ZipWriter::new(output);
    // A fixed date, so that the same Trial gives the same bytes.
    let options = SimpleFileOptions::default()
        .compression_method(CompressionMethod::Deflated)
        .last_modified_time(DateTime::default())
        .unix_permissions(0o644);
    let directory = Path::new(&trial.name);
    let others = others.iter().map(|(name, text)| (directory.join(name), (*text).to_owned()));
    for (path, text) in trial.texts(directory).into_iter().chain(others) {
        archive.start_file_from_path(path, options)?;
        archive.write_all(text.as_bytes())?;
    }
    Ok(archive.finish()?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::person::{Person, Sex};
    use lemons_core::plane::Bounds;
    use lemons_core::trial::INTERACTIONS;
    use tempfile::TempDir;

    fn two(settings: &TrialSettings) -> Result<Trial> {
        let placed = |breadth, x, y, orientation| {
            let person = Person { sex: Sex::Female, breadth, depth: 0.25, stature: 1.7, mass: 63.3 };
            (crate::CrowdMember::Pedestrian(person), Pose { position: vec2(x, y), orientation })
        };
        let square = Ring::around(Bounds { low: Vec2::zeros(), high: vec2(2.0, 2.0) });
        let crowd = [placed(0.45, 0.5, 0.5, 0.1), placed(0.5, 1.5, 1.4, -2.0)];
        crowd_trial("two", &crowd, walls(&[square], "concrete"), settings)
    }

    #[test]
    fn a_trial_reads_back_to_the_same_doubles() {
        let directory = TempDir::new().unwrap();
        let settings = TrialSettings { desired_velocity: vec2(0.3, -0.1), ..TrialSettings::default() };
        let path = directory.path().join("two");
        let written = two(&settings).unwrap();
        write_trial(&written, &[], &path, false).unwrap();
        let (mut read, warnings) = crowd_mechanics::setup::read(&path).unwrap();
        assert!(warnings.is_empty(), "{warnings}");
        read.directory = PathBuf::new();
        assert_eq!(read, written);
        // m v / t_transl: alone, everybody reaches the desired velocity.
        assert_eq!(read.dynamics[0].fp, vec2(0.3, -0.1) * (63.3 * 4.5));
        // Again over itself, beside a file that stays; a stale contact goes.
        std::fs::write(path.join("drive.csv"), "mine").unwrap();
        std::fs::write(path.join("dynamic").join(INTERACTIONS), "stale").unwrap();
        write_trial(&written, &[], &path, false).unwrap();
        assert_eq!(std::fs::read_to_string(path.join("drive.csv")).unwrap(), "mine");
        assert!(!path.join("dynamic").join(INTERACTIONS).exists());
        assert_eq!(std::fs::read_dir(directory.path()).unwrap().count(), 1, "no temporary directory is left");
    }

    #[test]
    fn a_zip_holds_the_same_files_and_always_the_same_bytes() {
        let directory = TempDir::new().unwrap();
        let trial = two(&TrialSettings::default()).unwrap();
        let (a, b) = (directory.path().join("a.zip"), directory.path().join("b.zip"));
        write_trial_zip(&trial, &[], &a).unwrap();
        write_trial_zip(&trial, &[], &b).unwrap();
        assert!(std::fs::read(&a).unwrap() == std::fs::read(&b).unwrap());
        zip::ZipArchive::new(std::fs::File::open(&a).unwrap()).unwrap().extract(directory.path()).unwrap();
        let (mut read, _) = crowd_mechanics::setup::read(&directory.path().join("two")).unwrap();
        read.directory = PathBuf::new();
        assert_eq!(read, trial);
    }

    #[test]
    fn the_mechanical_step_divides_the_communication_step() {
        let default = TrialSettings::default();
        let step = two(&default).unwrap().parameters.time_step_mechanical;
        // k_n = 4.99e6 N/m with concrete; 1/m* = 1/63.3 kg + (0.25 m)²/I, I = 63.3 kg (0.13 m)² or so: 12 ms/71.
        assert_eq!(step, 1e-4);
        let odd = TrialSettings { time_step: 0.033, ..default.clone() };
        let step = two(&odd).unwrap().parameters.time_step_mechanical;
        let count = 0.033 / step;
        assert!((count - count.round()).abs() < 1e-9 && step <= 1e-4 && step > 0.95e-4, "{step}");
        let short = TrialSettings { time_step: 5e-5, ..default };
        assert_eq!(two(&short).unwrap().parameters.time_step_mechanical, 5e-5);
    }

    #[test]
    fn a_wheelchair_is_of_metal_and_says_its_kind() {
        let mix = crate::Kinds::built_in().unwrap().mix(&[("wheelchair".to_owned(), 1.0)].into()).unwrap();
        let source = crate::PopulationSource::ansur().unwrap();
        let population = crate::Population::new(source, 0.5).unwrap();
        let agents: Vec<crate::CrowdMember> = population.mixed(mix).agents(1).take(2).collect();
        let member = agents[0].member().unwrap().clone();
        let pose = |x| Pose { position: vec2(x, 1.0), orientation: 0.0 };
        let crowd = [(agents[0].clone(), pose(1.0)), (agents[1].clone(), pose(3.0))];
        let trial = crowd_trial("two", &crowd, walls(&[], "concrete"), &TrialSettings::default()).unwrap();
        let directory = TempDir::new().unwrap();
        let path = directory.path().join("two");
        write_trial(&trial, &[], &path, false).unwrap();
        let (read, warnings) = crowd_mechanics::setup::read(&path).unwrap();
        assert!(warnings.is_empty(), "{warnings}");
        let agent = &read.agents[0];
        assert_eq!((agent.kind.as_deref(), agent.mass), (Some("wheelchair"), member.mass));
        assert_eq!(agent.moment_of_inertia, member.inertia);
        assert!(agent.shapes.iter().all(|disk| disk.material_id == "frame"));
        // The chair is no part of the person in it.
        let fitting = crate::person_fitting(agent);
        assert!((0.4..0.6).contains(&fitting.breadth) && fitting.depth < 0.3, "{fitting:?}");
        let ids: Vec<&str> = read.materials.intrinsic.iter().map(|material| &*material.id).collect();
        assert_eq!(ids, ["concrete", "human_clothes", "human_naked", "frame"]);
        // Each pair of these, once.
        assert_eq!(read.materials.binary.len(), 4 * 5 / 2);
    }

    #[test]
    fn the_softer_chest_is_there_on_request() {
        let people = SKINS[2].to_owned();
        let soft = two(&TrialSettings { people, ..TrialSettings::default() }).unwrap();
        let Materials { mut intrinsic, mut binary, load_length } = materials();
        let is_part = |id: &String| crate::PART_MATERIALS.contains(&&**id);
        intrinsic.retain(|material| !is_part(&material.id));
        binary.retain(|contact| !is_part(&contact.id1) && !is_part(&contact.id2));
        assert_eq!(soft.materials, Materials { load_length, intrinsic, binary });
        assert_eq!(soft.parameters.time_step_mechanical, 5e-4);
        assert_eq!(two(&TrialSettings::default()).unwrap().materials, paper_materials());
    }

    #[test]
    fn mistakes_are_named() {
        let people = "jelly".to_owned();
        let message = two(&TrialSettings { people, ..TrialSettings::default() }).unwrap_err().to_string();
        let known =
            "people: there is no material \"jelly\"; materials are human_naked, human_clothes, human_soft";
        assert_eq!(message, known);
    }
}
