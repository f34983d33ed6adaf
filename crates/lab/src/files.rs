//! Files to keep: a Trial as a zip, as an FMU; tables, pictures, bodies.

use crate::frame::{feet, frame, numbers};
use crate::loaded::LoadedTrial;
use crate::run::LabRun;
use crate::source::split;
use crate::{Refused, Reply, require};
use crowd_mechanics::engine::PairForce;
use crowd_mechanics::pack::{Binary, FmuFormat, Naming, Package, THIRD_PARTY};
use lemons_core::files::source::Memory;
use lemons_core::trial::{Agent, DRIVE_FILE};
use lemons_decision::DECISION_FILE;
use lemons_people::placing::{PlacingProgress, Stage, Watch};
use lemons_people::{MeshPart, crowd_csv, write_obj, write_stl, zip_trial};
use lemons_picture::{ColourMap, DrawnForce, Fill, PictureScene, Style, Values};
use lemons_results::columns::{ALL, Group};
use lemons_results::{Frame, FrameWriter, TableContent, TableWriter};
use lemons_sim::{Simulation, Stepper};
use serde::{Deserialize, Serialize};
use std::io::Cursor;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

/// Most people whose bodies are written: about 1 MB each.
const MOST_BODIES: usize = 200;
/// \[byte\] Largest table.
const LARGEST_TABLE: u64 = 500_000_000;

/// A file.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
#[serde(tag = "file", rename_all = "kebab-case", deny_unknown_fields)]
#[allow(missing_docs)] // as said
pub enum FileRequest {
    /// The Trial's directory in a zip.
    Trial {},
    /// An FMU of FMI 2 or 3. The bytes are its binaries, one after the other: of each, FMI's name of its platform and its
    /// length. One called [`THIRD_PARTY`] is their licences.
    Fmu { version: u8, binaries: Vec<(String, usize)> },
    /// A picture of a frame. The bytes are the frame, and a number for each agent: what its colour shows.
    Svg(PictureStyle),
    /// Everybody's measures, as CSV.
    Population {},
    /// Everybody's body in a frame (the bytes).
    Mesh { format: MeshFormat },
    /// The table of `lemons run`, computed again for so many communication steps.
    Trajectories { steps: u32 },
}

/// How a picture is drawn.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
#[serde(deny_unknown_fields)]
pub struct PictureStyle {
    /// The numbers at both ends of the colours.
    pub range: [f64; 2],
    /// Some numbers of the run are above.
    pub beyond: bool,
    /// Colours begin with a grey ([`ColourMap::FromGrey`]).
    pub from_grey: bool,
    /// The name of the quantity that colours show.
    pub label: String,
    /// Its unit.
    pub unit: String,
    /// \[s\]
    pub time: f64,
    /// True to draw who presses whom.
    pub forces: bool,
    /// \[m\] Height of the disks and walls that are drawn; without, all are.
    #[serde(default)]
    #[cfg_attr(feature = "typescript", ts(optional))]
    pub height: Option<f64>,
    /// True for a colour for each kind of people, and none for the numbers.
    #[serde(default)]
    pub by_kind: bool,
}

/// A format of surfaces.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
#[serde(rename_all = "kebab-case")]
pub enum MeshFormat {
    /// Wavefront OBJ
    Obj,
    /// Binary STL
    Stl,
}

/// The name of a file.
#[derive(Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub(crate) struct NamedFile {
    name: String,
}

/// Returns a file and its name.
///
/// # Errors
/// It cannot be made of this run, the bytes are not what is said, or `watch` stopped it.
pub fn file(wanted: &FileRequest, run: &LabRun, bytes: &[u8], watch: &mut Watch) -> Result<Reply, Refused> {
    let of = &run.loaded;
    let LoadedTrial { trial, drive, decision, people, .. } = of;
    let named =
        |end: &str, bytes: Vec<u8>| Reply::with(NamedFile { name: format!("{}{end}", trial.name) }, bytes);
    match wanted {
        FileRequest::Trial {} => {
            let others = [(DRIVE_FILE, &**drive), (DECISION_FILE, &**decision)];
            let others: Vec<_> = others.into_iter().filter(|(_, text)| !text.is_empty()).collect();
            let zip = zip_trial(trial, &others, Cursor::new(Vec::new()))?;
            named(".zip", zip.into_inner())
        }
        FileRequest::Fmu { version, binaries } => {
            let format = match version {
                2 => FmuFormat::Fmi2(Naming::default()),
                3 => FmuFormat::Fmi3,
                _ => return Err(Refused::from(format!("FMI {version}: the versions are 2 and 3"))),
            };
            named(".fmu", fmu(of, format, &split(binaries, bytes)?)?)
        }
        FileRequest::Population {} => {
            let people = people.as_ref().ok_or_else(|| {
                Refused::from("only the measures of people that the lab has drawn are known: make a crowd")
            })?;
            named("_people.csv", crowd_csv(people).into_bytes())
        }
        FileRequest::Mesh { format } => {
            let (parts, mut file) = (mesh(run, bytes)?, Vec::new());
            let end = match format {
                MeshFormat::Obj => write_obj(parts, &mut file).map(|()| ".obj"),
                MeshFormat::Stl => write_stl(&parts, &mut file).map(|()| ".stl"),
            };
            named(end?, file)
        }
        FileRequest::Svg(style) => named(".svg", svg(style, run, bytes)?.into_bytes()),
        FileRequest::Trajectories { steps } => named(".csv", table(of, *steps, watch)?),
    }
}

fn fmu(of: &LoadedTrial, format: FmuFormat, binaries: &[(&str, &[u8])]) -> Result<Vec<u8>, Refused> {
    let place = Path::new(&of.trial.name);
    let mut files = Memory::default();
    for (path, text) in of.trial.texts(place) {
        files.put(&path, text.into_bytes());
    }
    if !of.drive.is_empty() {
        files.put(&place.join(DRIVE_FILE), of.drive.clone().into_bytes());
    }
    let mut package = Package { trials: vec![place.to_owned()], format, ..Package::default() };
    for (platform, content) in binaries {
        if *platform == THIRD_PARTY {
            files.put(Path::new(THIRD_PARTY), content.to_vec());
            continue;
        }
        let path = PathBuf::from(format!("binary of {platform}"));
        files.put(&path, content.to_vec());
        package.binaries.push(Binary { platform: (*platform).to_owned(), path });
    }
    let mut fmu = Cursor::new(Vec::new());
    package.write_to(&files, Path::new("the FMU"), &mut fmu)?;
    Ok(fmu.into_inner())
}

/// Everybody's surface in a frame.
fn mesh(run: &LabRun, bytes: &[u8]) -> Result<Vec<MeshPart>, Refused> {
    let people = run.people();
    require(people <= MOST_BODIES, || {
        format!(
            "bodies of {people} people are too large for a page: at most {MOST_BODIES}; `lemons crowd` writes more"
        )
    })?;
    let (frame, bodies, mut parts) = (frame(bytes, people)?, run.bodies()?, Vec::new());
    for (place, at) in frame.present() {
        let agent = &run.loaded.trial.agents[place];
        let none = || Refused::from(format!("agent {}: no body fits its disks", agent.id));
        let figure = bodies[place].as_ref().ok_or_else(none)?;
        parts.extend(figure.surfaces(&agent.id, &at.pose));
    }
    Ok(parts)
}

/// A picture of a frame, and a number for each agent.
fn svg(wanted: &PictureStyle, run: &LabRun, bytes: &[u8]) -> Result<String, Refused> {
    let (trial, people) = (&run.loaded.trial, run.people());
    let short = || Refused::from("the picture needs a frame, and a number for each agent");
    let (shown, values) = bytes.split_at_checked(bytes.len().saturating_sub(8 * people)).ok_or_else(short)?;
    let frame = Frame { time: wanted.time, ..frame(shown, people)? };
    let poses = frame.agents.iter().map(|motion| motion.pose).collect();
    let mut scene = PictureScene::new(trial, poses).at_height(wanted.height);
    scene.feet = feet(shown);
    if wanted.forces {
        let force = |of: PairForce| DrawnForce { from: of.from, to: of.to, normal_force: of.normal_force };
        scene.forces = run.pair_forces(&frame)?.into_iter().map(force).collect();
    }
    let map = if wanted.from_grey { ColourMap::FromGrey } else { ColourMap::Viridis };
    let of = Values::of(numbers(values), &wanted.label, &wanted.unit);
    let fill =
        if wanted.by_kind { Fill::Kind } else { Fill::Values(Values { map, beyond: wanted.beyond, ..of }) };
    let [low, high] = wanted.range;
    let range = Some((low, high)).filter(|_| low < high);
    let style = Style { width: 800.0, fill, range, time: Some(wanted.time), ..Style::default() };
    Ok(lemons_picture::svg(&scene, &style))
}

/// The table of `lemons run`, computed again from the start.
fn table(of: &LoadedTrial, steps: u32, watch: &mut Watch) -> Result<Vec<u8>, Refused> {
    let mut run = LabRun::begin(of.clone())?;
    run.check_work()?;
    // A row has about 200 bytes.
    require(200 * run.people() as u64 * u64::from(steps) <= LARGEST_TABLE, || {
        "the table is too large for a page: `lemons run` writes it from the Trial".to_owned()
    })?;
    let legs = of.plan.as_ref().is_some_and(|plan| plan.balance.is_some());
    let groups = ALL.with(Group::Active, of.plan.is_some()).with(Group::Legs, legs);
    let chests = of.trial.agents.iter().any(Agent::has_chest);
    let groups = groups.with(Group::Chest, chests);
    let content = TableContent { columns: groups.columns(), about: Vec::new() };
    let (file, path) = (Cursor::new(Vec::new()), Path::new("the table"));
    let writer = TableWriter::create(file, path, lemons_results::TableFormat::Csv, &content)?;
    let ids = of.trial.agents.iter().map(|agent| agent.id.clone()).collect();
    let mut writer = FrameWriter::new(writer, ids, groups);
    writer.frame(&run.simulation.frame())?;
    let mut write = |run: &Stepper, _: &mut Simulation, frames: Vec<Frame>, _| {
        frames.iter().try_for_each(|frame| writer.frame(frame))?;
        let (iteration, limit) = (run.steps(), steps.into());
        // Without a stage of its own: the page knows it by the overlap.
        let progress =
            PlacingProgress { stage: Stage::Growing, iteration, limit, overlap: f64::NAN, density: 0.0 };
        require(watch(&progress).is_continue(), || "the table was stopped".to_owned())?;
        Ok::<_, Refused>(ControlFlow::Continue(()))
    };
    run.advance_with(&mut write, steps)?;
    Ok(writer.finish()?.into_inner())
}
