//! `lemons crowd`: people drawn, placed and written.

use super::bodies;
use super::leave::LeaveArguments;
use super::outputs::{Outputs, of_crowd, say};
use super::placing::{PlacingArguments, manner, placed, say_drawn};
use super::regions::{REGION_HELP, described};
use super::room::{explained, marks};
use super::source::{CUSTOM_HELP, SourceArguments};
use super::{line, ranged, read};
use crate::binary::CROWD;
use crate::error::{Misused, TrialHasErrors, and_then};
use crate::files;
use crate::interrupt::{Interrupt, Interrupted};
use crate::pack::{Fmi, FmuArguments, write_fmu};
use crate::print;
use crate::values::within;
use anyhow::{Context, Result, anyhow, bail};
use clap::Args as _;
use crowd_mechanics::pack::Binary;
use crowd_mechanics::setup;
use lemons_core::files::Scratch;
use lemons_core::files::source::{LocalFiles, Memory};
use lemons_core::plane::Pose;
use lemons_core::trial::{DRIVE_FILE, FileNames, Parameters, Trial};
use lemons_decision::{DECISION_FILE, DecisionConfig};
use lemons_master::TrialInput;
use lemons_people::{
    Body3d, CrowdMember, CrowdStatistics, SKINS, TORSO_ALTITUDE, TRIAL_FILES, crowd_csv, light_xml,
    may_write, write_trial, write_trial_zip,
};
use lemons_scenario::{
    Crowd, LevelsForm, MOST_PEOPLE, OrientationName, Ready, Scenario, ScenarioError, with_names,
};
use lemons_sim::lint::of_plan;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::Instant;

#[derive(clap::Args)]
#[command(after_help = format!("{REGION_HELP}\n\n{CUSTOM_HELP}"))]
pub struct Arguments {
    /// Number of people
    #[arg(short, long, alias = "people", value_name = "N", value_parser = clap::value_parser!(u32).range(1..=i64::from(MOST_PEOPLE)))]
    number: Option<u32>,
    /// People per m² of the region. In the open, with --number: the least density within the convex
    /// hull of the crowd (default there: as dense as possible)
    #[arg(short, long, value_name = "PER_M2", value_parser = ranged("density", " (per m²)"))]
    density: Option<f64>,
    /// Seed of the random numbers. The same seed gives the same crowd on every machine. Default: 1
    #[arg(short, long, value_name = "N")]
    seed: Option<u64>,
    #[command(flatten)]
    scenario: ScenarioArguments,
    #[command(flatten)]
    source: SourceArguments,
    #[command(flatten)]
    placing: PlacingArguments,
    #[command(flatten)]
    trial: TrialArguments,
    #[command(flatten)]
    leaving: LeaveArguments,
    #[command(flatten)]
    others: OtherArguments,
}

#[derive(clap::Args)]
struct ScenarioArguments {
    /// A scenario, as --save-scenario writes it (docs/reference/scenario.md). Other options change it
    #[arg(long, value_name = "FILE.toml")]
    scenario: Option<PathBuf>,
    /// Write what the options say as a scenario, which makes the same crowd
    #[arg(long, value_name = "FILE.toml")]
    save_scenario: Option<PathBuf>,
}

#[derive(clap::Args)]
#[command(next_help_heading = "Trial and FMU")]
struct TrialArguments {
    /// Write the crowd as a Trial directory. The files of a Trial that is there are replaced with --force
    /// only; results made from it no longer fit then
    #[arg(short, long, value_name = "TRIAL")]
    output: Option<PathBuf>,
    /// Write the Trial as a zip
    #[arg(long, value_name = "FILE.zip")]
    zip: Option<PathBuf>,
    /// Write the Trial packed as an FMU
    #[arg(long, value_name = "FILE.fmu")]
    fmu: Option<PathBuf>,
    #[command(flatten)]
    fmi: Fmi,
    #[command(flatten)]
    packing: FmuArguments,
    /// Replace existing files; also write the Trial into a directory that contains other files,
    /// which are kept
    #[arg(long)]
    force: bool,
    /// Material of the people. human_soft has a softer chest: lower and longer peaks, longer steps. Default:
    /// human_naked
    #[arg(long, value_parser = SKINS)]
    material: Option<String>,
    /// Everybody pushes along --direction, with the force that keeps a lone person at this speed, in
    /// m/s. Default: 0. With --leave: everybody's desired speed. Default: 1.34
    #[arg(long, value_name = "SPEED", value_parser = ranged("speed", " (m/s)"))]
    speed: Option<f64>,
    /// Communication step (TimeStep), in s. The mechanical step is chosen from the stiffest contact and
    /// divides it. Default: 0.01
    #[arg(long, value_name = "SECONDS", value_parser = ranged("time_step", " (s)"))]
    time_step: Option<f64>,
    /// Give people disks at several heights instead of a plan: a number of levels from 2 to 10, of equal height
    /// from 0.5 m to 1.7 m, or at least two heights in m, as in 1.0,1.3,1.5. With 1 people are as in the plan,
    /// and the load on their chests is an output, as with others. Default: the plan
    #[arg(long, value_name = "N|HEIGHTS", value_parser = levels)]
    levels: Option<LevelsForm>,
    /// Divide the walls into panels, none longer than this, in m: for each, outputs say how hard people press
    /// on it (lemons measure --walls). Default: no panels
    #[arg(long, value_name = "METRES", value_parser = ranged("panel_length", " (m)"))]
    panel_length: Option<f64>,
}

#[derive(clap::Args)]
#[command(next_help_heading = "Other files")]
struct OtherArguments {
    /// Write a table of everybody's measures, in m and kg
    #[arg(long, value_name = "FILE.csv")]
    population: Option<PathBuf>,
    /// Write the paper's light XML format, in absolute coordinates; bicycles are rectangles in it
    #[arg(long, value_name = "FILE.xml")]
    light_xml: Option<PathBuf>,
    /// Compute sections of everybody's three-dimensional body at these altitudes, in m, for example
    /// 1.2,0.9,0.5. The word torso stands for three: the altitude of the torso, where breadth and depth are
    /// measured, of the shortest, the mean and the tallest person, as in the paper
    #[arg(long, value_name = "ALTITUDES", value_delimiter = ',', value_parser = altitude)]
    sections: Vec<Altitude>,
    /// Write these sections as GeoJSON, in m
    #[arg(long, value_name = "FILE.geojson", requires = "sections")]
    sections_geojson: Option<PathBuf>,
    /// Write these sections as well-known text (WKT), one MULTIPOLYGON Z for each altitude
    #[arg(long, value_name = "FILE.wkt", requires = "sections")]
    sections_wkt: Option<PathBuf>,
    /// Write everybody's body surface as Wavefront OBJ, about 1 MB for each person
    #[arg(long, value_name = "FILE.obj")]
    obj: Option<PathBuf>,
    /// Write everybody's body surface as binary STL, about 1.6 MB for each person
    #[arg(long, value_name = "FILE.stl")]
    stl: Option<PathBuf>,
    /// Draw the crowd from above as SVG
    #[arg(long, value_name = "FILE.svg")]
    svg: Option<PathBuf>,
    /// Draw the crowd from above as PDF
    #[arg(long, value_name = "FILE.pdf")]
    pdf: Option<PathBuf>,
    /// Draw the crowd from above as PNG, 1200 pixels wide
    #[arg(long, value_name = "FILE.png")]
    png: Option<PathBuf>,
}

/// A value of `--sections`: an altitude \[m\], or the word torso.
type Altitude = Option<f64>;

fn altitude(text: &str) -> Result<Altitude, String> {
    match text {
        "torso" => Ok(None),
        _ => within(0.0, 3.0, " (m), or torso")(text).map(Some),
    }
}

/// A number, or heights \[m\].
fn levels(text: &str) -> Result<LevelsForm, String> {
    let heights = || text.split(',').map(|at| at.trim().parse()).collect::<Result<_, _>>().ok();
    let form = text.parse().ok().map(LevelsForm::Number).or_else(|| heights().map(LevelsForm::Heights));
    let form = form.ok_or("must be a number of levels, as in 3, or their heights in m, as in 1.0,1.3,1.5")?;
    form.slabs().map(|_| form).map_err(|error| error.to_string())
}

/// \[m\] For the word torso those of the lowest, the mean and the highest one; none where nobody has a torso.
fn altitudes(wanted: &[Altitude], agents: &[CrowdMember]) -> Vec<f64> {
    let statures: Vec<f64> =
        agents.iter().flat_map(CrowdMember::people).map(|(person, _)| person.stature).collect();
    let mean = statures.iter().sum::<f64>() / statures.len() as f64;
    let (low, high) = statures.iter().fold((mean, mean), |(low, high), &s| (low.min(s), high.max(s)));
    let torsos = [low, mean, high].map(|stature| TORSO_ALTITUDE * stature);
    let torsos = if statures.is_empty() { &[][..] } else { &torsos };
    wanted.iter().flat_map(|at| at.as_ref().map_or(torsos, std::slice::from_ref)).copied().collect()
}

/// Returns the option of a key of a scenario, if there is one.
fn option_of(key: &str) -> Option<String> {
    let name = match key {
        "people" | "people.file" => "custom",
        "drawing.unit" => return Some("--unit or --scale".into()),
        key => key.strip_prefix("drawing.").unwrap_or(key),
    };
    let command = Arguments::augment_args(clap::Command::new(""));
    let long = name.replace('_', "-");
    let is_it = |option: &&clap::Arg| *option.get_id() == *name || option.get_long() == Some(&long);
    Some(format!("--{}", command.get_arguments().find(is_it)?.get_long()?))
}

/// Names of a scenario's keys: those of options, or, where they are as a file says, those in it.
struct Words<'a> {
    now: &'a Scenario,
    /// The file, and what it says.
    file: Option<(&'a Path, &'a Scenario)>,
}

impl Words<'_> {
    fn is_option(&self, key: &str) -> bool {
        self.file.is_none_or(|(_, file)| self.now.differs(file, key))
    }

    /// A text about a scenario, in which keys are between backticks.
    fn note(&self, text: &str) -> String {
        with_names(text, |key| option_of(key).filter(|_| self.is_option(key)))
    }

    /// The same. What is of the file, as its first key says, begins with the file's name.
    fn text(&self, text: &str) -> String {
        let file = self.file.filter(|_| !self.of_option(text));
        file.map_or(String::new(), |(file, _)| format!("{}: ", file.display())) + &self.note(text)
    }

    fn of_option(&self, text: &str) -> bool {
        self.is_option(text.split('`').nth(1).unwrap_or_default())
    }

    /// Returns whether an option says how many people there are, or where.
    fn asks_how_many(&self) -> bool {
        ["number", "density", "box"].iter().any(|key| self.is_option(key))
    }

    fn error(&self, error: ScenarioError) -> anyhow::Error {
        match error {
            ScenarioError::Misused(what) if self.of_option(&what) => Misused(self.text(&what)).into(),
            ScenarioError::NoRoom { .. } if self.asks_how_many() => anyhow!(self.note(&error.to_string())),
            ScenarioError::People { of, error } if of.contains("`packing`") && self.asks_how_many() => {
                explained(error).context(self.note(&of))
            }
            ScenarioError::Stopped => Interrupted::given_up().into(),
            ScenarioError::Files(problems) => {
                note!("{problems}");
                TrialHasErrors.into()
            }
            ScenarioError::People { of, error } => explained(error).context(self.text(&of)),
            ScenarioError::Toml(what) => anyhow!(what),
            error => anyhow!(self.text(&error.to_string())),
        }
    }
}

/// Names of the files that a scenario has beside those of all Trials.
fn beside(scenario: &Scenario) -> Vec<&'static str> {
    let decides = scenario.leave || scenario.decision != DecisionConfig::default();
    let all = [(DECISION_FILE, decides), (DRIVE_FILE, !scenario.pushes.is_empty())];
    all.into_iter().filter(|(_, is_there)| *is_there).map(|(name, _)| name).collect()
}

/// A scenario as it is in a file: paths are relative to its directory, or absolute.
fn saved(mut scenario: Scenario, file: &Path) -> Result<Scenario> {
    let directory = std::path::absolute(file)?.parent().map(Path::to_owned).unwrap_or_default();
    let mut done = Ok(());
    scenario.each_path(|path| match std::path::absolute(&*path) {
        Ok(whole) => *path = whole.strip_prefix(&directory).map(Path::to_owned).unwrap_or(whole),
        Err(error) => done = Err(error),
    });
    done?;
    Ok(scenario)
}

pub fn crowd(arguments: Arguments) -> Result<()> {
    let (file, mut scenario) = arguments.scenario()?;
    let words =
        Words { now: &scenario.clone(), file: arguments.scenario.scenario.as_deref().zip(file.as_ref()) };
    let told = |error| words.error(error);
    scenario.check().map_err(told)?;
    let population = scenario.population(&LocalFiles).map_err(told)?;
    if arguments.others.light_xml.is_some() && population.has_bicycles() {
        let orientation = *scenario.orientation.get_or_insert(OrientationName::Fixed);
        if orientation != OrientationName::Fixed || scenario.direction.unwrap_or(0.0) % 90.0 != 0.0 {
            bail!(Misused(
                "--light-xml: bicycles stand along the axes in this file: --orientation fixed with --direction 0, 90, \
                 180 or 270"
                    .into()
            ));
        }
    }
    let Arguments { trial, others, .. } = &arguments;
    if arguments.leaving.is_wanted()
        && trial.output.is_none()
        && trial.zip.is_none()
        && arguments.scenario.save_scenario.is_none()
    {
        bail!(Misused(
            "--leave and --balance write decision.toml into a Trial: give -o TRIAL or --zip FILE.zip".into()
        ));
    }
    let drawn = scenario.drawn(&LocalFiles).map_err(told)?;
    if let (Some(read), Some(path)) = (&drawn, &scenario.geometry) {
        say_drawn(read, path);
    }
    let place = scenario.place(&LocalFiles, drawn).map_err(told)?;
    place.notes.iter().for_each(|message| note!("{}", words.note(message)));
    let ready = scenario.ready(&population, place, MOST_PEOPLE).map_err(told)?;
    let Ready { place, numbers, agents, .. } = &ready;
    if let Some(directory) = &trial.output {
        may_write(directory, trial.force).context("-o")?;
    }
    let binaries = trial.fmu.as_ref().map(|_| trial.packing.binaries(&CROWD)).transpose()?;
    let mut outputs = arguments.outputs(&beside(&scenario))?;
    // Known before a long packing.
    let makeable = scenario.settings().check(&place.geometry);
    if trial.wanted() || outputs.have_any(&["--svg", "--pdf", "--png"]) {
        makeable.as_ref().map_err(|error| anyhow!("cannot make a Trial of {}: {error}", place.name))?;
    }
    // Of a Trial that is refused nothing more is told.
    let beside = beside(&scenario);
    for message in trial.output.iter().flat_map(|directory| files::staying(directory, &beside)) {
        note!("{message}");
    }
    let save = arguments.scenario.save_scenario.as_ref();
    let saved = save.map(|file| saved(scenario.clone(), file)?.to_toml().map_err(told)).transpose()?;
    let interrupt = Interrupt::watch();

    others.check_bodies(agents)?;
    let started = Instant::now();
    let placed = placed(&ready, &interrupt)?.map_err(told)?;
    let seconds = started.elapsed().as_secs_f64();
    let Crowd { packing, densities, shapes } = &placed;
    let ground = place.area_of(packing);
    let covered: f64 = shapes.iter().map(|shape| shape.moments().area).sum();

    // Printed when all is written: who closes the pipe early has the files nevertheless.
    let mut out = Vec::new();
    writeln!(out, "{}", CrowdStatistics::of(agents))?;
    writeln!(out, "\nseed               {:>10}", scenario.seed())?;
    let of = if place.is_plane() { "convex hull of all" } else { &place.name };
    writeln!(out, "{}", line("ground", ground, &format!("m²   ({of})")))?;
    if place.has_regions {
        for (k, (ground, density)) in place.grounds.iter().zip(densities).enumerate() {
            let people = format!("m²   {} people, {density:.3} /m²", numbers[k]);
            writeln!(out, "{}", line(&format!("  region {k}"), ground.free.region.area(), &people))?;
            let message = described(&ground.free);
            if !message.is_empty() {
                writeln!(out, "{:29} {message}", "")?;
            }
        }
    }
    writeln!(out, "{}", line("placed in", seconds, &format!("s   ({})", manner(&scenario))))?;
    let share = format!("/m²   ({:.1} % of the ground is covered)", 100.0 * covered / ground);
    writeln!(out, "{}", line("density", packing.density, &share))?;
    writeln!(out, "{}", line("largest overlap", 1e3 * packing.largest_overlap, "mm"))?;

    let crowd: Vec<(CrowdMember, Pose)> = agents.iter().cloned().zip(packing.poses.iter().copied()).collect();
    outputs
        .fill("--save-scenario", |file| file.write_all(saved.as_deref().unwrap_or_default().as_bytes()))?;
    outputs.fill("--population", |file| file.write_all(crowd_csv(agents).as_bytes()))?;
    if let Some(output) = outputs.of("--light-xml") {
        let text = light_xml(&crowd)?;
        output.fill(|file| file.write_all(text.as_bytes()))?;
    }
    let at = (!others.sections.is_empty()).then(|| altitudes(&others.sections, agents));
    bodies::write(&crowd, at.as_deref(), [covered, ground], &mut outputs, &interrupt, &mut out)?;
    let mut done = Ok(());
    if makeable.is_ok() {
        let made = ready.into_documents(&arguments.name(), placed).map_err(told)?;
        let (mut scene, style) = of_crowd(&made.trial);
        scene.marks = made.place.drawn.as_ref().map_or(Vec::new(), |drawn| marks(&drawn.plan));
        outputs.draw(&scene, &style)?;
        let Parameters { time_step, time_step_mechanical: step, .. } = &made.trial.parameters;
        writeln!(out, "mechanical step    {step:>10} s   (of a TimeStep of {time_step} s)")?;
        // Those of the place were told.
        let notes = made.notes.iter().skip(made.place.notes.len());
        notes.for_each(|message| note!("{}", words.note(message)));
        if let Some((_, plan)) = &made.decision {
            let found = of_plan(plan, &made.trial, Path::new(""));
            found.iter().for_each(|found| note!("{found}"));
        }
        let beside = made.beside().map_err(told)?;
        let beside: Vec<(&str, &str)> = beside.iter().map(|(name, text)| (*name, &**text)).collect();
        done = trial.write(&made.trial, &beside, binaries, &interrupt, &mut out)?;
    }
    if !trial.wanted() && outputs.is_empty() {
        writeln!(
            out,
            "nothing was written: give -o TRIAL, --fmu, --zip, or another file (lemons crowd --help)"
        )?;
    }
    done = and_then(done, outputs.persist(|| interrupt.check(), &mut out));
    let told = print::out().write_all(&out);
    done.and(Ok(told?))
}

impl TrialArguments {
    /// Returns whether any form of the Trial is wanted.
    fn wanted(&self) -> bool {
        self.output.is_some() || self.zip.is_some() || self.fmu.is_some()
    }

    /// Checks the Trial as everybody would, and writes it where it was asked for, with files `beside` its own: everywhere,
    /// also when one place cannot be taken, which is the error within.
    ///
    /// # Errors
    /// Nothing more is to be written.
    fn write(
        &self,
        trial: &Trial,
        beside: &[(&str, &str)],
        binaries: Option<Vec<Binary>>,
        interrupt: &Interrupt,
        out: &mut impl Write,
    ) -> Result<Result<()>> {
        if !self.wanted() {
            return Ok(Ok(()));
        }
        let mut files = Memory::default();
        for (path, text) in trial.texts(Path::new("")) {
            files.put(&path, text.into_bytes());
        }
        read(setup::read_from(&files, Path::new(""), &FileNames::default()))?;
        // Before the first of them is written: one may lie in the directory of another.
        let still = |path: &Option<PathBuf>| path.as_deref().map_or(Ok(()), files::check_still);
        let (free_zip, free_directory) = (still(&self.zip), still(&self.output));
        // From here on files appear.
        let mut done = Ok(());
        let mut wrote = |what: &str, path: &Path, written: Result<()>| {
            let told = written.and_then(|()| Ok(say(out, what, path)?));
            done = and_then(std::mem::replace(&mut done, Ok(())), told);
        };
        interrupt.check()?;
        if let (Some(file), Some(binaries)) = (&self.fmu, binaries) {
            let scratch = Scratch::new().context("cannot make a temporary directory")?;
            let directory = scratch.path().join(&trial.name);
            let drive: Vec<_> = beside.iter().copied().filter(|(name, _)| *name == DRIVE_FILE).collect();
            write_trial(trial, &drive, &directory, false)?;
            let (trials, format) = ([TrialInput::open(&directory)?], self.fmi.format(self.packing.naming()));
            // Its warnings are those printed already.
            let written = write_fmu(&trials, binaries, format, file, None);
            wrote("FMU", file, written.map(drop));
            for (name, _) in beside.iter().filter(|(name, _)| *name == DECISION_FILE) {
                note!(
                    "note: {name} is not in {}: lemons decide makes the FMU that moves its people, of the Trial",
                    file.display()
                );
            }
        }
        interrupt.check()?;
        if let Some(file) = &self.zip {
            wrote("zip", file, free_zip.and_then(|()| Ok(write_trial_zip(trial, beside, file)?)));
        }
        interrupt.check()?;
        if let Some(directory) = &self.output {
            let written =
                free_directory.and_then(|()| Ok(write_trial(trial, beside, directory, self.force)?));
            wrote("Trial", directory, written);
        }
        Ok(done)
    }
}

impl OtherArguments {
    /// Checks that the bodies that are wanted can be made.
    fn check_bodies(&self, agents: &[CrowdMember]) -> Result<()> {
        let wanted = !self.sections.is_empty() || self.obj.is_some() || self.stl.is_some();
        for (k, agent) in agents.iter().enumerate().filter(|_| wanted) {
            for person in agent.everybody() {
                Body3d::similar_possible(&person).with_context(|| format!("agent {k}"))?;
            }
        }
        Ok(())
    }
}

impl Arguments {
    /// The scenario of the file, if there is one; and with what the options say.
    fn scenario(&self) -> Result<(Option<Scenario>, Scenario)> {
        let file = self.scenario.scenario.as_deref();
        let file = file.map(|file| Scenario::read(&LocalFiles, file)).transpose()?;
        let mut scenario = file.clone().unwrap_or_default();
        scenario.each_path(|path| files::reads(path, "--scenario"));
        if self.number.is_some() || self.density.is_some() {
            (scenario.number, scenario.density) = (self.number, self.density);
        }
        scenario.seed = self.seed.or(scenario.seed);
        self.source.fill(&mut scenario)?;
        self.placing.fill(&mut scenario);
        self.leaving.fill(&mut scenario)?;
        let TrialArguments { material, speed, time_step, panel_length, levels, .. } = &self.trial;
        scenario.material = material.clone().or(scenario.material);
        scenario.speed = speed.or(scenario.speed);
        scenario.time_step = time_step.or(scenario.time_step);
        scenario.levels = levels.clone().or(scenario.levels);
        scenario.panel_length = panel_length.or(scenario.panel_length);
        Ok((file, scenario))
    }

    /// The name of the Trial.
    fn name(&self) -> String {
        let TrialArguments { output, zip, fmu, .. } = &self.trial;
        let directory = output.as_ref().and_then(|path| path.file_name());
        let file = zip.as_ref().or(fmu.as_ref()).and_then(|path| path.file_stem());
        directory.or(file).map_or("Trial_crowd".into(), |name| name.to_string_lossy().into_owned())
    }

    /// Opens what is written beside the Trial.
    fn outputs(&self, beside: &[&str]) -> Result<Outputs> {
        let (trial, others) = (&self.trial, &self.others);
        // Whether they can be written is better known before a long packing.
        for path in [&trial.zip, &trial.fmu].into_iter().flatten() {
            files::claim_and_try(path)?;
        }
        if let Some(directory) = &trial.output {
            files::claim_directory(directory)?;
            TRIAL_FILES.iter().chain(beside).try_for_each(|file| files::claim(&directory.join(file)))?;
        }
        Outputs::open(&[
            ("--population", "population", &others.population),
            ("--light-xml", "light XML", &others.light_xml),
            ("--sections-geojson", "sections", &others.sections_geojson),
            ("--sections-wkt", "sections", &others.sections_wkt),
            ("--obj", "bodies", &others.obj),
            ("--stl", "bodies", &others.stl),
            ("--svg", "picture", &others.svg),
            ("--pdf", "picture", &others.pdf),
            ("--png", "picture", &others.png),
            ("--save-scenario", "scenario", &self.scenario.save_scenario),
        ])
    }
}
