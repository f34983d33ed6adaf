//! `lemons crowd`: people drawn, placed and written.

use super::crowd_files::{Bodies, light};
use super::placing::PlacingArguments;
use super::source::{CUSTOM_HELP, Mixed, SourceArguments};
use super::{line, within};
use crate::binary::CROWD;
use crate::error::{Misused, TrialHasErrors};
use crate::files::{self, WISHES_FILE};
use crate::given::Given;
use crate::interrupt::Interrupt;
use crate::output::Output;
use crate::pack::{FmuArguments, write_fmu};
use crate::tell;
use anyhow::{Context, Result, anyhow};
use clap::ValueEnum;
use crowd_mechanics::engine::{Pose, Rotation, Vec2, vec2};
use crowd_mechanics::files::Scratch;
use crowd_mechanics::pack::{Binary, DRIVE_FILE};
use crowd_mechanics::trial::{Geometry, Trial};
use lemons_crowd::{
    Agent, Body3d, CrowdStatistics, Overwrite, Person, Shape, TORSO_ALTITUDE, TRIAL_FILES, TrialSettings,
    crowd_csv, crowd_trial, light_xml, may_write, write_geojson, write_trial, write_trial_zip, write_wkt,
};
use lemons_picture::{Bicycle as Drawn, Colour, Fill, Pose as DrawnPose, Scene, Style, pdf, png, svg};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::time::Instant;

#[derive(clap::Args)]
#[command(after_help = CUSTOM_HELP)]
pub struct Arguments {
    /// How many
    #[arg(short, long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1_000_000), allow_negative_numbers = true)]
    number: Option<u32>,
    /// How many per m²: of the region; in the open, with --number, of the convex hull at least
    /// (default there: as densely as they go)
    #[arg(short, long, value_name = "PER_M2", value_parser = density, allow_negative_numbers = true)]
    density: Option<f64>,
    /// The same seed gives the same crowd on any machine
    #[arg(short, long, value_name = "N", default_value_t = 1)]
    seed: u64,
    #[command(flatten)]
    source: SourceArguments,
    #[command(flatten)]
    placing: PlacingArguments,
    #[command(flatten)]
    trial: TrialArguments,
    #[command(flatten)]
    others: OtherArguments,
}

#[derive(clap::Args)]
#[command(next_help_heading = "A Trial of it (pedestrians only)")]
struct TrialArguments {
    /// A Trial directory
    #[arg(short, long, value_name = "TRIAL")]
    output: Option<PathBuf>,
    /// The Trial directory as a zip
    #[arg(long, value_name = "FILE.zip")]
    zip: Option<PathBuf>,
    /// The Trial packed as an FMU
    #[arg(long, value_name = "FILE.fmu")]
    fmu: Option<PathBuf>,
    #[command(flatten)]
    packing: FmuArguments,
    /// Replace files that are there although they are of something else, or somebody changed them;
    /// also write a Trial into a directory with other things in it, which stay
    #[arg(long)]
    force: bool,
    /// What people are made of
    #[arg(long, value_enum, default_value_t = Wear::Naked)]
    material: Wear,
    /// Everybody pushes with the force that keeps up this speed alone, along --direction; in m/s
    #[arg(long, value_name = "SPEED", default_value = "0", value_parser = speed, allow_negative_numbers = true)]
    speed: f64,
    /// Communication step, in s; the mechanical step that divides it is proposed from the stiffest
    /// contact
    #[arg(long, value_name = "SECONDS", default_value = "0.01", value_parser = time_step, allow_negative_numbers = true)]
    time_step: f64,
}

/// The paper's materials of people.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Wear {
    #[value(name = "human_naked")]
    Naked,
    #[value(name = "human_clothes")]
    Clothes,
}

#[derive(clap::Args)]
#[command(next_help_heading = "Other files")]
struct OtherArguments {
    /// Everybody's measures, in m and kg
    #[arg(long, value_name = "FILE.csv")]
    population: Option<PathBuf>,
    /// The paper's light format for mixed crowds, in absolute coordinates
    #[arg(long, value_name = "FILE.xml")]
    light_xml: Option<PathBuf>,
    /// Cut everybody's three-dimensional body at these altitudes, in m: 1.2,0.9,0.5; or torso: where
    /// the shapes are those of the shortest, the mean and the tallest (the paper's comparison)
    #[arg(
        long,
        value_name = "ALTITUDES",
        value_delimiter = ',',
        value_parser = altitude,
        allow_negative_numbers = true
    )]
    sections: Vec<Altitude>,
    /// These sections as GeoJSON; coordinates in m
    #[arg(long, value_name = "FILE.geojson", requires = "sections")]
    sections_geojson: Option<PathBuf>,
    /// These sections as WKT, one MULTIPOLYGON Z for each altitude
    #[arg(long, value_name = "FILE.wkt", requires = "sections")]
    sections_wkt: Option<PathBuf>,
    /// Everybody's surface as Wavefront OBJ: about 1 MB each
    #[arg(long, value_name = "FILE.obj")]
    obj: Option<PathBuf>,
    /// The same as binary STL: about 1.6 MB each
    #[arg(long, value_name = "FILE.stl")]
    stl: Option<PathBuf>,
    /// The crowd from above as a picture
    #[arg(long, value_name = "FILE.svg")]
    svg: Option<PathBuf>,
    /// The same for print
    #[arg(long, value_name = "FILE.pdf")]
    pdf: Option<PathBuf>,
    /// The same, 1200 pixels wide
    #[arg(long, value_name = "FILE.png")]
    png: Option<PathBuf>,
}

fn density(text: &str) -> Result<f64, String> {
    within(text, 1e-6, 100.0, " (per m²)")
}

fn speed(text: &str) -> Result<f64, String> {
    within(text, 0.0, 20.0, " (m/s)")
}

fn time_step(text: &str) -> Result<f64, String> {
    within(text, 1e-6, 1.0, " (s)")
}

/// Of `--sections`.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Altitude {
    /// \[m\]
    At(f64),
    /// Of the torsos: the lowest, the mean, the highest.
    Torsos,
}

fn altitude(text: &str) -> Result<Altitude, String> {
    match text {
        "torso" => Ok(Altitude::Torsos),
        _ => within(text, 0.0, 3.0, " (m), or torso").map(Altitude::At),
    }
}

/// \[m\]
fn altitudes(wanted: &[Altitude], agents: &[Agent]) -> Vec<f64> {
    let statures: Vec<f64> = agents.iter().filter_map(pedestrian).map(|person| person.stature).collect();
    let mean = statures.iter().sum::<f64>() / statures.len() as f64;
    let (low, high) = statures.iter().fold((mean, mean), |(low, high), &s| (low.min(s), high.max(s)));
    let mut all = Vec::new();
    for altitude in wanted {
        match altitude {
            Altitude::At(altitude) => all.push(*altitude),
            // Nobody has a torso.
            Altitude::Torsos if statures.is_empty() => {}
            Altitude::Torsos => all.extend([low, mean, high].map(|stature| TORSO_ALTITUDE * stature)),
        }
    }
    all
}

pub fn crowd(mut arguments: Arguments) -> Result<()> {
    let (population, mixed) = arguments.source.population()?;
    if mixed == Mixed::Yes {
        arguments.refuse_bicycles()?;
        arguments.placing.default_to_fixed();
        if !arguments.placing.along_an_axis() {
            let message = "--pedestrians below 1: bicycles stand along the axes in the light XML: \
                           --orientation fixed with --direction 0, 90, 180 or 270";
            return Err(Misused(message.into()).into());
        }
    }
    let Arguments { placing, trial, others, seed, .. } = &arguments;
    let place = placing.place()?;
    let wanted = placing.wanted(&place, arguments.number, arguments.density)?;
    let settings = trial.settings(placing.direction());
    // Known before a long packing.
    let makeable = settings.check(&place.geometry);
    if trial.wanted() || others.has_pictures() {
        makeable.as_ref().map_err(|error| anyhow!("no Trial of {}: {error}", place.name))?;
    }
    if let Some(directory) = &trial.output {
        may_write(directory, trial.overwrite()).context(if trial.force {
            "-o"
        } else {
            "-o (unless --force)"
        })?;
        for file in [DRIVE_FILE, WISHES_FILE] {
            if directory.join(file).is_file() {
                note!(
                    "warning: {} of the Trial that was there stays, and is used",
                    directory.join(file).display()
                );
            }
        }
    }
    let binaries = trial.fmu.as_ref().map(|_| trial.packing.binaries(&CROWD)).transpose()?;
    let mut outputs = arguments.outputs()?;
    let interrupt = Interrupt::watch();

    let agents: Vec<Agent> = population.agents(*seed).take(wanted.number).collect();
    let shapes = agents.iter().map(shape).collect::<Result<Vec<Shape>>>()?;
    if !others.sections.is_empty() || others.obj.is_some() || others.stl.is_some() {
        for (k, person) in agents.iter().enumerate().filter_map(|(k, agent)| Some((k, pedestrian(agent)?))) {
            Body3d::possible(&person).with_context(|| format!("agent {k}"))?;
        }
    }
    let started = Instant::now();
    let packing = placing.run(&shapes, &place, wanted, *seed, &interrupt)?;
    let seconds = started.elapsed().as_secs_f64();
    let ground =
        if place.region.is_plane() { shapes.len() as f64 / packing.density } else { place.region.area() };
    // Of a bicycle the two rectangles, not the disks that keep others off them.
    let area = |(agent, shape): (&Agent, &Shape)| match agent {
        Agent::Pedestrian(_) => shape.moments().area,
        Agent::Bicycle(bicycle) => bicycle.area(),
    };
    let covered: f64 = agents.iter().zip(&shapes).map(area).sum();

    // Printed when all is written: who closes the pipe early has the files nevertheless.
    let mut out = Vec::new();
    writeln!(out, "{}", CrowdStatistics::of(&agents))?;
    writeln!(out, "\nseed               {seed:>10}")?;
    let of = if place.region.is_plane() { "convex hull of all" } else { &place.name };
    writeln!(out, "{}", line("ground", ground, &format!("m²   ({of})")))?;
    writeln!(out, "{}", line("placed in", seconds, &format!("s   ({})", placing.manner())))?;
    let share = format!("/m²   ({:.1} % of the ground is covered)", 100.0 * covered / ground);
    writeln!(out, "{}", line("density", packing.density, &share))?;
    writeln!(out, "{}", line("largest overlap", 1e3 * packing.largest_overlap, "mm"))?;

    if let Some(output) = &mut outputs.population {
        output.fill(|file| file.write_all(crowd_csv(&agents).as_bytes()))?;
    }
    if let Some(output) = &mut outputs.light_xml {
        let text = light_xml(&light(&agents, &shapes, &packing.poses))?;
        output.fill(|file| file.write_all(text.as_bytes()))?;
    }
    let bodies = Bodies { agents: &agents, poses: &packing.poses, interrupt: &interrupt };
    if !others.sections.is_empty() {
        let sections = bodies.sections(&altitudes(&others.sections, &agents))?;
        bodies.table(&mut out, &sections, covered, ground)?;
        if let Some(output) = &mut outputs.sections {
            output.fill(|file| write_geojson(&sections, file))?;
        }
        if let Some(output) = &mut outputs.sections_wkt {
            output.fill(|file| write_wkt(&sections, file))?;
        }
    }
    if let Some(output) = &mut outputs.obj {
        bodies.obj(output)?;
    }
    if let Some(output) = &mut outputs.stl {
        bodies.stl(output)?;
    }
    interrupt.check()?;
    if mixed == Mixed::No && makeable.is_ok() {
        let people: Vec<Person> = agents.iter().filter_map(pedestrian).collect();
        let made =
            crowd_trial(&arguments.name(), &people, &shapes, &packing.poses, place.geometry, &settings)?;
        let step = made.parameters.time_step_mechanical;
        let note = format!("s   (of a TimeStep of {} s)", made.parameters.time_step);
        writeln!(out, "mechanical step    {step:>10} {note}")?;
        outputs.draw(&Scene::at_start(&made), Fill::BodyArea)?;
        trial.write(&made, binaries, &interrupt, &mut out)?;
    } else if others.has_pictures() {
        outputs.draw_mixed(&agents, &shapes, &packing.poses, place.geometry, &settings)?;
    }
    if !trial.wanted() && outputs.is_empty() {
        writeln!(
            out,
            "nothing was written: give -o TRIAL, --fmu, --zip, or another file (lemons crowd --help)"
        )?;
    }
    outputs.persist(&mut out)?;
    Ok(tell::out().write_all(&out)?)
}

/// A unit vector; exact along the axes.
fn unit(degrees: f64) -> Vec2 {
    match degrees.rem_euclid(360.0) {
        0.0 => vec2(1.0, 0.0),
        90.0 => vec2(0.0, 1.0),
        180.0 => vec2(-1.0, 0.0),
        270.0 => vec2(0.0, -1.0),
        _ => vec2(1.0, 0.0).rotated(Rotation::by(degrees.to_radians())),
    }
}

fn shape(agent: &Agent) -> Result<Shape> {
    match agent {
        Agent::Pedestrian(person) => Ok(Shape::of(person)?),
        // Both rectangles are about the centre, so their disks are too.
        Agent::Bicycle(bicycle) => Ok(Shape { disks: bicycle.covering_disks() }),
    }
}

fn pedestrian(agent: &Agent) -> Option<Person> {
    match agent {
        Agent::Pedestrian(person) => Some(*person),
        Agent::Bicycle(_) => None,
    }
}

impl TrialArguments {
    fn overwrite(&self) -> Overwrite {
        if self.force { Overwrite::Anything } else { Overwrite::Trials }
    }

    /// Whether any form of it is.
    fn wanted(&self) -> bool {
        self.output.is_some() || self.zip.is_some() || self.fmu.is_some()
    }

    fn settings(&self, direction: f64) -> TrialSettings {
        TrialSettings {
            time_step: self.time_step,
            people: if self.material == Wear::Naked { "human_naked" } else { "human_clothes" }.into(),
            desired_velocity: unit(direction) * self.speed,
            ..TrialSettings::default()
        }
    }

    /// Checks the Trial as everybody would, and writes it where it was asked for.
    fn write(
        &self,
        trial: &Trial,
        binaries: Option<Vec<Binary>>,
        interrupt: &Interrupt,
        out: &mut impl Write,
    ) -> Result<()> {
        if !self.wanted() {
            return Ok(());
        }
        let scratch = Scratch::new().context("cannot make a temporary directory")?;
        let directory = scratch.path().join(&trial.name);
        write_trial(trial, &directory, Overwrite::Trials)?;
        match Trial::read(&directory) {
            Ok((_, warnings)) => warnings.iter().for_each(|warning| {
                // The file's name without the place where it lies for the moment.
                note!("{}", warning.to_string().replace(&format!("{}/", directory.display()), ""));
            }),
            Err(problems) => {
                note!("{problems}");
                return Err(TrialHasErrors.into());
            }
        }
        // From here on files appear.
        interrupt.check()?;
        if let (Some(file), Some(binaries)) = (&self.fmu, binaries) {
            // Its warnings are those printed already.
            write_fmu(&[Given::open(&directory)?], binaries, self.packing.naming(), file)?;
            say(out, "FMU", file)?;
        }
        if let Some(file) = &self.zip {
            write_trial_zip(trial, file)?;
            say(out, "zip", file)?;
        }
        if let Some(directory) = &self.output {
            write_trial(trial, directory, self.overwrite())?;
            say(out, "Trial", directory)?;
        }
        Ok(())
    }
}

fn say(out: &mut impl Write, what: &str, path: &Path) -> io::Result<()> {
    writeln!(out, "{what:<18} {}", path.display())
}

impl OtherArguments {
    fn has_pictures(&self) -> bool {
        [&self.svg, &self.pdf, &self.png].iter().any(|file| file.is_some())
    }
}

impl Arguments {
    fn refuse_bicycles(&self) -> Result<()> {
        let TrialArguments { output, zip, fmu, .. } = &self.trial;
        let asked = [("-o", output), ("--zip", zip), ("--fmu", fmu)];
        if let Some((option, _)) = asked.iter().find(|(_, path)| path.is_some()) {
            let message = format!(
                "{option}: the mechanics takes pedestrians only, and a part of this crowd rides bicycles \
                 (pedestrians below 1): --light-xml FILE.xml writes a mixed crowd"
            );
            return Err(Misused(message).into());
        }
        Ok(())
    }

    /// Of the Trial.
    fn name(&self) -> String {
        let TrialArguments { output, zip, fmu, .. } = &self.trial;
        let directory = output.as_ref().and_then(|path| path.file_name());
        let file = zip.as_ref().or(fmu.as_ref()).and_then(|path| path.file_stem());
        directory.or(file).map_or("Trial_crowd".into(), |name| name.to_string_lossy().into_owned())
    }

    /// Opens what is written beside the Trial.
    fn outputs(&self) -> Result<Outputs> {
        let OtherArguments { population, light_xml, sections_geojson, sections_wkt, .. } = &self.others;
        let OtherArguments { obj, stl, svg, pdf, png, .. } = &self.others;
        let TrialArguments { output, zip, fmu, .. } = &self.trial;
        let open = |path: &Option<PathBuf>| path.as_deref().map(Output::open).transpose();
        // Whether they can be written is better known before a long packing.
        for path in [zip, fmu].into_iter().flatten() {
            files::claim_and_try(path)?;
        }
        if let Some(directory) = output {
            files::claim_directory(directory)?;
            TRIAL_FILES.iter().try_for_each(|file| files::claim(&directory.join(file)))?;
        }
        Ok(Outputs {
            population: open(population)?,
            light_xml: open(light_xml)?,
            sections: open(sections_geojson)?,
            sections_wkt: open(sections_wkt)?,
            obj: open(obj)?,
            stl: open(stl)?,
            svg: open(svg)?,
            pdf: open(pdf)?,
            png: open(png)?,
        })
    }
}

/// \[px\]
const PICTURE_WIDTH: u32 = 1200;

/// Files that appear when all is done.
struct Outputs {
    population: Option<Output>,
    light_xml: Option<Output>,
    sections: Option<Output>,
    sections_wkt: Option<Output>,
    obj: Option<Output>,
    stl: Option<Output>,
    svg: Option<Output>,
    pdf: Option<Output>,
    png: Option<Output>,
}

impl Outputs {
    fn is_empty(&self) -> bool {
        let Outputs { population, light_xml, sections, sections_wkt, obj, stl, .. } = self;
        let others = [population, light_xml, sections, sections_wkt, obj, stl];
        others.iter().all(|file| file.is_none()) && !self.has_pictures()
    }

    fn has_pictures(&self) -> bool {
        [&self.svg, &self.pdf, &self.png].iter().any(|file| file.is_some())
    }

    /// Pedestrians as a Trial has them, bicycles beside them; all under their places in the crowd.
    fn draw_mixed(
        &mut self,
        agents: &[Agent],
        shapes: &[Shape],
        poses: &[Pose],
        geometry: Geometry,
        settings: &TrialSettings,
    ) -> Result<()> {
        let (mut people, mut bicycles) = ((Vec::new(), Vec::new(), Vec::new(), Vec::new()), Vec::new());
        for (place, ((agent, shape), pose)) in agents.iter().zip(shapes).zip(poses).enumerate() {
            match agent {
                Agent::Pedestrian(person) => {
                    people.extend([(*person, shape.clone(), *pose, place.to_string())]);
                }
                Agent::Bicycle(bicycle) => {
                    let [wheels, rider] = bicycle.rectangles();
                    let pose = DrawnPose { position: pose.position, theta: pose.orientation };
                    bicycles.push(Drawn { id: place.to_string(), pose, wheels, rider });
                }
            }
        }
        let (people, shapes, poses, ids) = people;
        let mut trial = crowd_trial("crowd", &people, &shapes, &poses, geometry, settings)?;
        trial.agents.iter_mut().zip(ids).for_each(|(agent, id)| agent.id = id);
        let fill = if people.is_empty() { Fill::Single(Colour::BODY) } else { Fill::BodyArea };
        let mut scene = Scene::at_start(&trial);
        scene.bicycles = bicycles;
        self.draw(&scene, fill)
    }

    fn draw(&mut self, scene: &Scene, fill: Fill) -> Result<()> {
        if !self.has_pictures() {
            return Ok(());
        }
        let text = svg(scene, &Style { width: PICTURE_WIDTH.into(), fill, ..Style::default() });
        if let Some(output) = &mut self.svg {
            output.fill(|file| file.write_all(text.as_bytes()))?;
        }
        if let Some(output) = &mut self.pdf {
            let picture = pdf(&text)?;
            output.fill(|file| file.write_all(&picture))?;
        }
        if let Some(output) = &mut self.png {
            let picture = png(&text, PICTURE_WIDTH)?;
            output.fill(|file| file.write_all(&picture))?;
        }
        Ok(())
    }

    fn persist(self, out: &mut impl Write) -> Result<()> {
        let all = [
            ("population", self.population),
            ("light XML", self.light_xml),
            ("sections", self.sections),
            ("sections", self.sections_wkt),
            ("bodies", self.obj),
            ("bodies", self.stl),
            ("picture", self.svg),
            ("picture", self.pdf),
            ("picture", self.png),
        ];
        for (what, output) in all {
            let Some(output) = output else { continue };
            say(out, what, output.path())?;
            output.persist()?;
        }
        Ok(())
    }
}
