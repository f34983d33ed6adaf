//! Makes a Trial of a crowd: all its files, ready to be checked, packed and run.
//!
//! Materials, damping and floor are the paper's (App. C, and its table of parameters), unless [`TrialSettings`] gives
//! others. The offsets of a shape are relative to the centroid of its area: the centre of mass of a body of uniform
//! density. The moment of inertia is about this point. Numbers are written so that they are read back as the same
//! doubles.

use crate::person::Person;
use crate::shape::Shape;
use crowd_mechanics::setup::Setup;
use lemons_core::files::{Change, Staged, StagedDirectory, WriteError, change_all};
use lemons_core::plane::{Pose, Ring, Rotation, Vec2, vec2};
use lemons_core::trial::{
    Agent, AgentDynamics, Contact, Geometry, INTERACTIONS, Interactions, Material, Materials, Parameters,
    Trial, Wall,
};
use std::io::{self, Seek, Write};
use std::path::{Component, Path, PathBuf};
use thiserror::Error;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipWriter};

/// Everything in a Trial except its people and their poses.
#[derive(Debug, Clone, PartialEq)]
pub struct TrialSettings {
    /// \[s\] communication step.
    pub time_step: f64,
    /// \[s\] step of the integrator. `None`: the longest that divides `time_step` and does not exceed
    /// [`proposed_step`](crowd_mechanics::setup::Setup::proposed_step).
    pub time_step_mechanical: Option<f64>,
    /// Materials of people, walls and other things, and their contacts.
    pub materials: Materials,
    /// Id of the material of all disks.
    pub people: String,
    /// \[1/s\] inverse time of translational friction on the floor.
    pub floor_damping: f64,
    /// \[1/s\] inverse time of rotational friction on the floor.
    pub angular_damping: f64,
    /// \[m/s\] Velocity that each agent would reach alone: the propulsion force is m v / t_transl (the paper's eq. 4).
    /// Zero: no propulsion.
    pub desired_velocity: Vec2,
}

impl Default for TrialSettings {
    /// The paper's App. C: people without clothes, at rest, without propulsion; 10 ms between two decisions.
    fn default() -> TrialSettings {
        TrialSettings {
            time_step: 0.01,
            time_step_mechanical: None,
            materials: paper_materials(),
            people: "human_naked".into(),
            floor_damping: 4.5,
            angular_damping: 4.5,
            desired_velocity: Vec2::ZERO,
        }
    }
}

/// Returns `Materials.xml` of the paper's App. C: concrete, people with clothes and without.
pub fn paper_materials() -> Materials {
    let material =
        |id: &str, young_modulus, shear_modulus| Material { id: id.into(), young_modulus, shear_modulus };
    let contact = |id1: &str, id2: &str, gamma, kinetic_friction| Contact {
        id1: id1.into(),
        id2: id2.into(),
        gamma_normal: gamma,
        gamma_tangential: gamma,
        kinetic_friction,
    };
    Materials {
        intrinsic: vec![
            material("concrete", 1.7e9, 7.1e8),
            material("human_clothes", 3.1e6, 9e5),
            material("human_naked", 4e6, 1379310.3),
        ],
        binary: vec![
            contact("concrete", "concrete", 1300.0, 0.5),
            contact("concrete", "human_clothes", 1300.0, 0.5),
            contact("concrete", "human_naked", 1230.0, 0.5),
            contact("human_clothes", "human_clothes", 1300.0, 0.5),
            contact("human_clothes", "human_naked", 1300.0, 0.5),
            contact("human_naked", "human_naked", 700.0, 0.4),
        ],
    }
}

/// Returns closed walls \[m\] of one material: the outline of a region, then its holes. Its dimensions are those of the
/// first wall; the drawn area begins at the origin, as in the paper's files. Without rings: the open plane.
pub fn walls(rings: &[Ring], material: &str) -> Geometry {
    let wall = |(id, ring): (usize, &Ring)| Wall {
        id: id.to_string(),
        material_id: material.into(),
        corners: ring.closed().to_vec(),
    };
    let dimensions = rings.first().map(|ring| ring.bounds().size());
    Geometry { dimensions, walls: rings.iter().enumerate().map(wall).collect() }
}

/// The unit vector in a direction, in degrees counter-clockwise from the x axis; exact along the axes.
pub fn heading(degrees: f64) -> Vec2 {
    match degrees.rem_euclid(360.0) {
        0.0 => vec2(1.0, 0.0),
        90.0 => vec2(0.0, 1.0),
        180.0 => vec2(-1.0, 0.0),
        270.0 => vec2(0.0, -1.0),
        _ => vec2(1.0, 0.0).rotated(Rotation::by(degrees.to_radians())),
    }
}

/// Why a Trial cannot be made.
#[derive(Debug, Error)]
#[allow(missing_docs)] // the messages say it
pub enum TrialError {
    #[error("the crowd is empty: a Trial needs at least one person")]
    Empty,
    #[error("{people} people, {shapes} shapes, {poses} poses: the numbers must be equal")]
    Counts { people: usize, shapes: usize, poses: usize },
    #[error("{name} = {value:?}: must be {must}")]
    Setting { name: &'static str, value: f64, must: &'static str },
    #[error("{what}: there is no material {id:?}; materials are {}", known.join(", "))]
    Material { what: String, id: String, known: Vec<String> },
    #[error("the materials {first:?} and {second:?} have no <Contact>")]
    NoContact { first: String, second: String },
    #[error("{}: is a directory that is not a Trial; use --force to write into it", path.display())]
    NotATrial { path: PathBuf },
    #[error("{}: is not a directory", path.display())]
    NoDirectory { path: PathBuf },
    #[error(transparent)]
    Write(#[from] WriteError),
}

/// Makes the Trial of people, their shapes and their poses, at rest. Ids are numbers from 0 in their order.
///
/// # Errors
/// There are no people, the lists have different lengths, a setting is out of range, or a material is unknown.
pub fn crowd_trial(
    name: &str,
    people: &[Person],
    shapes: &[Shape],
    poses: &[Pose],
    geometry: Geometry,
    settings: &TrialSettings,
) -> Result<Trial, TrialError> {
    if people.len() != shapes.len() || people.len() != poses.len() {
        let (people, shapes, poses) = (people.len(), shapes.len(), poses.len());
        return Err(TrialError::Counts { people, shapes, poses });
    }
    if people.is_empty() {
        return Err(TrialError::Empty);
    }
    settings.check(&geometry)?;
    let agent = |(id, (person, shape)): (usize, (&Person, &Shape))| Agent {
        kind: Some("pedestrian".into()),
        id: id.to_string(),
        mass: person.mass,
        height: Some(person.stature),
        moment_of_inertia: shape.inertia(person.mass),
        floor_damping: settings.floor_damping,
        angular_damping: settings.angular_damping,
        shapes: shape
            .disks
            .iter()
            .map(|disk| lemons_core::trial::Shape {
                radius: disk.radius,
                material_id: settings.people.clone(),
                position: disk.centre,
            })
            .collect(),
    };
    let moving = |(person, pose): (&Person, &Pose)| AgentDynamics {
        position: pose.position,
        velocity: Vec2::ZERO,
        theta: pose.orientation,
        omega: 0.0,
        fp: settings.desired_velocity * (person.mass * settings.floor_damping),
        mp: 0.0,
    };
    let mut trial = Trial {
        name: name.into(),
        directory: PathBuf::new(),
        parameters: Parameters {
            static_directory: "./static/".into(),
            dynamic_directory: "./dynamic/".into(),
            time_step: settings.time_step,
            time_step_mechanical: settings.time_step,
        },
        materials: settings.materials.clone(),
        geometry,
        agents: people.iter().zip(shapes).enumerate().map(agent).collect(),
        dynamics: people.iter().zip(poses).map(moving).collect(),
        interactions: Interactions::default(),
    };
    trial.parameters.time_step_mechanical = match settings.time_step_mechanical {
        Some(step) => step,
        None => part_of(settings.time_step, Setup::of(&trial).proposed_step().unwrap_or(settings.time_step)),
    };
    Ok(trial)
}

/// The longest step that divides `whole` and does not exceed `most`.
fn part_of(whole: f64, most: f64) -> f64 {
    // The tolerance is for a quotient that is an integer except for rounding.
    whole / (whole / most - 1e-9).ceil().max(1.0)
}

impl TrialSettings {
    /// Checks that a Trial with these walls can be made.
    ///
    /// # Errors
    /// A setting is out of range, a material is unknown, or the material of the people has no contact with another one.
    pub fn check(&self, geometry: &Geometry) -> Result<(), TrialError> {
        let number = |name, value: f64, right: bool, must| {
            if right && value.is_finite() { Ok(()) } else { Err(TrialError::Setting { name, value, must }) }
        };
        number("TimeStep", self.time_step, self.time_step > 0.0, "positive")?;
        if let Some(step) = self.time_step_mechanical {
            let right = step > 0.0 && step <= self.time_step;
            number("TimeStepMechanical", step, right, "positive and at most TimeStep")?;
        }
        number("FloorDamping", self.floor_damping, self.floor_damping >= 0.0, "0 or positive")?;
        number("AngularDamping", self.angular_damping, self.angular_damping >= 0.0, "0 or positive")?;
        for (name, value) in [
            ("desired velocity, x", self.desired_velocity.x),
            ("desired velocity, y", self.desired_velocity.y),
        ] {
            number(name, value, true, "finite")?;
        }
        let Materials { intrinsic, binary } = &self.materials;
        let known = |what: String, id: &str| {
            if intrinsic.iter().any(|material| material.id == id) {
                return Ok(());
            }
            let known = intrinsic.iter().map(|material| material.id.clone()).collect();
            Err(TrialError::Material { what, id: id.into(), known })
        };
        let touches = |id: &str| {
            let pair = [&*self.people, id];
            let found = binary.iter().any(|c| pair == [&*c.id1, &*c.id2] || pair == [&*c.id2, &*c.id1]);
            let none = || TrialError::NoContact { first: self.people.clone(), second: id.into() };
            if found { Ok(()) } else { Err(none()) }
        };
        known("people".into(), &self.people)?;
        touches(&self.people)?;
        for wall in &geometry.walls {
            known(format!("wall {}", wall.id), &wall.material_id)?;
            touches(&wall.material_id)?;
        }
        Ok(())
    }
}

/// What may be overwritten.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Overwrite {
    /// The files of a Trial.
    Trials,
    /// Any directory: a Trial may be written into one with other files, which stay.
    Anything,
}

/// Checks that a Trial may be written to a path. [`write_trial`] checks it too.
///
/// # Errors
/// There is a file, or a directory that is neither empty nor a Trial.
pub fn may_write(directory: &Path, overwrite: Overwrite) -> Result<(), TrialError> {
    let cannot = WriteError::at(directory);
    match directory.metadata() {
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(()),
        Err(error) => Err(cannot(error).into()),
        Ok(there) if !there.is_dir() => Err(TrialError::NoDirectory { path: directory.to_owned() }),
        Ok(_) if overwrite == Overwrite::Anything || directory.join("Parameters.xml").is_file() => Ok(()),
        Ok(_) => match std::fs::read_dir(directory).map(|mut entries| entries.next().is_none()) {
            Ok(true) => Ok(()),
            Ok(false) => Err(TrialError::NotATrial { path: directory.to_owned() }),
            Err(error) => Err(cannot(error).into()),
        },
    }
}

/// Writes a Trial directory completely or not at all. In an existing directory the files of the Trial are replaced, all
/// or none, and an outdated AgentInteractions.xml is removed; other files stay.
///
/// # Errors
/// The existing files may not be or cannot be overwritten; they are then unchanged.
pub fn write_trial(trial: &Trial, directory: &Path, overwrite: Overwrite) -> Result<(), TrialError> {
    write_trial_with(trial, &[], directory, overwrite)
}

/// As [`write_trial`], with further files of the Trial's directory: their names and texts.
///
/// # Errors
/// As [`write_trial`].
pub fn write_trial_with(
    trial: &Trial,
    others: &[(&str, &str)],
    directory: &Path,
    overwrite: Overwrite,
) -> Result<(), TrialError> {
    may_write(directory, overwrite)?;
    let texts = |directory: &Path| {
        let others = others.iter().map(|(name, text)| (directory.join(name), (*text).to_owned()));
        trial.texts(directory).into_iter().chain(others).collect::<Vec<_>>()
    };
    let write_in = |directory: &Path, stale: Option<PathBuf>| {
        let texts = texts(directory);
        for parent in texts.iter().filter_map(|(path, _)| path.parent()) {
            lemons_core::files::make_directories(parent).map_err(WriteError::at(parent))?;
        }
        let stale = stale.filter(|stale| texts.iter().all(|(path, _)| path != stale));
        let writes = texts.into_iter().map(|(path, text)| Change::Write(path, text));
        change_all(&writes.chain(stale.map(Change::Remove)).collect::<Vec<_>>())
    };
    if directory.exists() {
        return Ok(write_in(directory, Some(directory.join("dynamic").join(INTERACTIONS)))?);
    }
    let stage = StagedDirectory::beside(directory).map_err(WriteError::at(directory))?;
    write_in(stage.path(), None)?;
    Ok(stage.persist().map_err(WriteError::at(directory))?)
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
pub fn write_trial_zip(trial: &Trial, others: &[(&str, &str)], file: &Path) -> Result<(), TrialError> {
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
    for (path, text) in trial.texts(Path::new("")) {
        // Names in a zip file have forward slashes on every platform, and no "./".
        let parts = path.components().filter_map(|part| match part {
            Component::Normal(name) => Some(name.to_string_lossy()),
            _ => None,
        });
        archive.start_file(format!("{}/{}", trial.name, parts.collect::<Vec<_>>().join("/")), options)?;
        archive.write_all(text.as_bytes())?;
    }
    for (name, text) in others {
        archive.start_file(format!("{}/{name}", trial.name), options)?;
        archive.write_all(text.as_bytes())?;
    }
    Ok(archive.finish()?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::person::Sex;
    use lemons_core::plane::Bounds;
    use tempfile::TempDir;

    fn person(breadth: f64) -> Person {
        Person { sex: Sex::Female, breadth, depth: 0.25, stature: 1.7, mass: 63.3 }
    }

    fn at(x: f64, y: f64, orientation: f64) -> Pose {
        Pose { position: vec2(x, y), orientation }
    }

    fn square(side: f64) -> Geometry {
        walls(&[Ring::around(Bounds { low: Vec2::ZERO, high: vec2(side, side) })], "concrete")
    }

    fn two(settings: &TrialSettings) -> Result<Trial, TrialError> {
        let people = [person(0.45), person(0.5)];
        let shapes = people.map(|person| Shape::of(&person).unwrap());
        crowd_trial("two", &people, &shapes, &[at(0.5, 0.5, 0.1), at(1.5, 1.4, -2.0)], square(2.0), settings)
    }

    #[test]
    fn the_papers_materials_are_those_of_its_example() {
        let (trial, _) = crowd_mechanics::setup::read(&lemons_verify::testing::trial_push()).unwrap();
        assert_eq!(paper_materials(), trial.materials);
    }

    #[test]
    fn a_trial_reads_back_to_the_same_doubles() {
        let directory = TempDir::new().unwrap();
        let settings = TrialSettings { desired_velocity: vec2(0.3, -0.1), ..TrialSettings::default() };
        let path = directory.path().join("two");
        let written = two(&settings).unwrap();
        write_trial(&written, &path, Overwrite::Trials).unwrap();
        let (mut read, warnings) = crowd_mechanics::setup::read(&path).unwrap();
        assert!(warnings.is_empty(), "{warnings}");
        read.directory = PathBuf::new();
        assert_eq!(read, written);
        // m v / t_transl: alone, everybody reaches the desired velocity.
        assert_eq!(read.dynamics[0].fp, vec2(0.3, -0.1) * (63.3 * 4.5));
        // Again over itself, beside a file that stays; a stale contact goes.
        std::fs::write(path.join("drive.csv"), "mine").unwrap();
        std::fs::write(path.join("dynamic").join(INTERACTIONS), "stale").unwrap();
        write_trial(&written, &path, Overwrite::Trials).unwrap();
        assert_eq!(std::fs::read_to_string(path.join("drive.csv")).unwrap(), "mine");
        assert!(!path.join("dynamic").join(INTERACTIONS).exists());
        assert_eq!(std::fs::read_dir(directory.path()).unwrap().count(), 1, "no temporary directory is left");
    }

    #[test]
    fn nothing_is_written_over_what_is_no_trial() {
        let directory = TempDir::new().unwrap();
        let trial = two(&TrialSettings::default()).unwrap();
        std::fs::write(directory.path().join("letter"), "mine").unwrap();
        let refused = write_trial(&trial, directory.path(), Overwrite::Trials).unwrap_err();
        assert!(refused.to_string().contains("is a directory that is not a Trial"), "{refused}");
        assert_eq!(std::fs::read_dir(directory.path()).unwrap().count(), 1);
        write_trial(&trial, directory.path(), Overwrite::Anything).unwrap();
        assert!(crowd_mechanics::setup::read(directory.path()).is_ok());
        assert_eq!(std::fs::read_to_string(directory.path().join("letter")).unwrap(), "mine");
        let file = directory.path().join("letter");
        assert!(matches!(
            write_trial(&trial, &file, Overwrite::Anything),
            Err(TrialError::NoDirectory { .. })
        ));
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
    fn mistakes_are_named() {
        let with = |change: fn(&mut TrialSettings)| {
            let mut settings = TrialSettings::default();
            change(&mut settings);
            two(&settings).unwrap_err().to_string()
        };
        assert_eq!(with(|s| s.time_step = 0.0), "TimeStep = 0.0: must be positive");
        assert_eq!(
            with(|s| s.time_step_mechanical = Some(1.0)),
            "TimeStepMechanical = 1.0: must be positive and at most TimeStep"
        );
        assert_eq!(with(|s| s.floor_damping = f64::NAN), "FloorDamping = NaN: must be 0 or positive");
        let said = with(|s| s.people = "jelly".into());
        assert!(
            said.starts_with("people: there is no material \"jelly\"; materials are concrete, "),
            "{said}"
        );
        let said = with(|s| s.materials.binary.truncate(2));
        assert_eq!(said, "the materials \"human_naked\" and \"human_naked\" have no <Contact>");
        let nobody = crowd_trial("x", &[], &[], &[], square(1.0), &TrialSettings::default());
        assert!(matches!(nobody, Err(TrialError::Empty)));
        let lost = crowd_trial("x", &[person(0.5)], &[], &[], square(1.0), &TrialSettings::default());
        assert_eq!(lost.unwrap_err().to_string(), "1 people, 0 shapes, 0 poses: the numbers must be equal");
    }
}
