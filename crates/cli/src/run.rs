//! `lemons run`: an FMU, or FMUs coupled by an SSP, stepped like any FMI master would.

mod halved;
mod pressing;
mod rest;
mod series;
mod underway;

use crate::compared::{Poses, Seen};
use crate::crowd_run::Point;
use crate::decide::Walk;
use crate::error::{Misused, and_then, said};
use crate::files::{self, Force};
use crate::interrupt::{Interrupt, Interrupted};
use crate::recording::Recording;
use crate::results::{Format, FormatName, Place};
use crate::tell::{Interim, nobody_listens};
use crate::version::BUILD;
use crate::watch::{Places, Recorded, Watch};
use crate::words::{refused, warned};
use anyhow::{Context, Error, Result, bail, ensure};
use clap::ValueEnum;
use halved::{Chosen, run_for, steps_of};
use indicatif::{ProgressBar, ProgressStyle};
use lemons_files::Staged;
use lemons_master::{
    Algorithm, CrowdRecord, Kept, Observer, PATIENCE, Prepared, Progress, Pushes, Reached, Saved, Settings,
    System, plan_in, writers,
};
use lemons_measure::{LATEST, Leaving, Over, REACH, STANDSTILL};
use lemons_record::Run;
use lemons_trial::DriveChoice;
use pressing::pressing;
pub use rest::REST;
use rest::{Rest, Still};
pub use series::writes as writes_in_series;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::{Duration, Instant};
use underway::{AtHand, Shared, Underway};

#[derive(clap::Args)]
pub struct Arguments {
    /// A Trial (a directory or a zip), an FMU, or an SSP of coupled FMUs
    #[arg(value_name = "TRIAL, FILE.fmu or FILE.ssp")]
    input: PathBuf,
    /// End of the simulation, in seconds; or the word left: when everybody has left by the exits of
    /// decision.toml, or when in 300 s nobody has left or got further than 5 m; at the latest after 3600 s.
    /// Default: the stop time of the SSP, else 5
    #[arg(long, value_name = "SECONDS|left", value_parser = until)]
    until: Option<Until>,
    /// Communication step, in seconds. Default: the Trial's TimeStep; for several FMUs, the smallest
    /// of their default step sizes
    #[arg(long, value_name = "SECONDS", value_parser = positive)]
    step: Option<f64>,
    /// How coupled FMUs exchange values. jacobi: all FMUs use the values of the last communication
    /// point. gauss-seidel: the FMUs step one after the other, in the order of the SSP, and each uses the
    /// newest values
    #[arg(long, value_name = "ALGORITHM", default_value = "jacobi")]
    algorithm: Order,
    /// Propulsion over time: a CSV file with columns t,agent,Fp.x,Fp.y,Mp. At each communication point,
    /// values are interpolated linearly between rows; they are held until the next point, so results
    /// depend on the communication step. Before the first and after the last row they are zero. Agents that are not
    /// in the file keep the values of AgentDynamics.xml. Default: the Trial's drive.csv if there is one, which
    /// its FMU plays by itself (also in an SSP). Where people walk by decision.toml, it is added to the forces
    /// with which they walk
    #[arg(long, value_name = "FILE.csv", conflicts_with = "no_drive")]
    drive: Option<PathBuf>,
    /// Ignore the Trial's drive.csv
    #[arg(long)]
    no_drive: bool,
    #[command(flatten)]
    walk: Walk,
    /// Set a parameter or a start value, for example --set TimeStepMechanical=1e-5; for all agents:
    /// --set 'agent[*].Mass=80'; in an SSP, with the name of the component: --set crowd.Threads=2; for
    /// people who walk by decision.toml, --set 'decision.agent[3].DesiredSpeed=0.5'
    // The help shows it as it is.
    #[allow(rustdoc::broken_intra_doc_links)]
    #[arg(long = "set", value_name = "NAME=VALUE")]
    settings: Vec<String>,
    /// Number of threads of the crowd. They pay off from a few thousand agents on. Results do not depend
    /// on the number. In an SSP, use --set NAME.Threads=N
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(i32).range(1..))]
    threads: Option<i32>,
    /// Choose the mechanical step for this accuracy, in metres, and run twice: with this step and with half
    /// of it. The results are those of the second run. The summary says by how much a point of a body
    /// differs at most between both, and whether the accuracy was met (docs/step.md)
    #[arg(long, value_name = "METRES", value_parser = length, conflicts_with = "resume")]
    accuracy: Option<f64>,
    /// File for the trajectories; - is standard output. Several crowds go to FILE_NAME.csv, with the name
    /// of each component. Default: trajectories.csv
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// File for the outputs of FMUs that are not a crowd. Default: with -o NAME.csv NAME_outputs.csv, else
    /// outputs.csv
    #[arg(long, value_name = "FILE")]
    outputs: Option<PathBuf>,
    #[arg(long, value_name = "FORMAT", hide_possible_values = true, help = FORMAT_HELP)]
    format: Option<FormatName>,
    /// Write only every N-th communication point, beginning with the first. Default: 1. Mean and peak
    /// squeeze in a row are of all steps since the row before
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    every: Option<u32>,
    /// Save the state of the run when it ends or is stopped by Ctrl-C; --resume continues it
    #[arg(long, value_name = "FILE.run")]
    state: Option<PathBuf>,
    /// Continue a saved run of the same Trial, FMU or SSP. What follows goes into tables of its own (-o), which
    /// lemons measure, plot, movie and export read together with those of the saved run
    #[arg(long, value_name = "FILE.run")]
    resume: Option<PathBuf>,
    #[command(flatten)]
    _force: Force,
}

/// `--until`
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Until {
    /// \[s\]
    Time(f64),
    /// When nobody is there any more.
    Left,
}

impl Until {
    /// \[s\]
    pub fn time(self) -> Option<f64> {
        match self {
            Until::Time(time) => Some(time),
            Until::Left => None,
        }
    }
}

pub fn until(text: &str) -> Result<Until, String> {
    match text {
        "left" => Ok(Until::Left),
        text => positive(text).map(Until::Time).map_err(|error| format!("{error}, or the word left")),
    }
}

/// When a run ends, besides at its time.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Ends {
    /// Not before.
    #[default]
    AtTime,
    /// When all have come to rest.
    Still,
    /// When nobody is there any more.
    Left,
}

/// A run, and what becomes of it.
pub struct Job {
    pub settings: Settings,
    /// Where its records go.
    pub places: Places,
    /// Where it is saved.
    pub state: Option<PathBuf>,
    /// When it ends.
    pub ends: Ends,
    /// What is done with the poses.
    pub poses: Poses,
}

impl Arguments {
    fn job(&self) -> Result<Job> {
        let places = places_of(self)?;
        let settings = Settings {
            parameters: name_and_value_of_all(&self.settings)?,
            threads: self.threads,
            step: self.step,
            until: self.until.map(|until| match until {
                Until::Time(time) => time,
                Until::Left => LATEST,
            }),
            every: self.every.map(u64::from),
            drive: drive_of(self.drive.as_deref(), self.no_drive),
            plan: self.walk.choice(),
            algorithm: self.algorithm.into(),
            resume: self.resume.clone(),
            saves: self.state.is_some(),
            ..Settings::of(&self.input)
        };
        let ends = if self.until == Some(Until::Left) { Ends::Left } else { Ends::AtTime };
        Ok(Job { settings, places, state: self.state.clone(), ends, poses: Poses::Ignore })
    }
}

/// `--drive` and `--no-drive`
pub fn drive_of(file: Option<&Path>, none: bool) -> DriveChoice {
    match file {
        Some(path) => DriveChoice::File(path.to_owned()),
        None if none => DriveChoice::None,
        None => DriveChoice::Own,
    }
}

/// Names and values of `--set`.
pub fn name_and_value_of_all(settings: &[String]) -> Result<Vec<(String, String)>> {
    let both = settings.iter().map(|setting| {
        let both = setting.split_once('=').map(|(name, value)| (name.to_owned(), value.to_owned()));
        both.ok_or_else(|| Misused(format!("--set {setting}: expected NAME=VALUE")).into())
    });
    both.collect()
}

const FORMAT_HELP: &str = "Format of the tables: csv; or parquet, for long runs: smaller, with units in the metadata. \
                           Default: by the extension of -o, else csv";

#[derive(Clone, Copy, ValueEnum)]
enum Order {
    Jacobi,
    GaussSeidel,
}

impl From<Order> for Algorithm {
    fn from(order: Order) -> Algorithm {
        match order {
            Order::Jacobi => Algorithm::Jacobi,
            Order::GaussSeidel => Algorithm::GaussSeidel,
        }
    }
}

fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value > 0.0 && value.is_finite() => Ok(value),
        _ => Err("must be a positive number of seconds".into()),
    }
}

fn length(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value > 0.0 && value.is_finite() => Ok(value),
        _ => Err("must be a positive number of metres, for example 1e-4".into()),
    }
}

/// What came of a run.
pub struct Ended {
    /// If poses are followed: those of each crowd, and the mechanical steps \[s\].
    poses: Vec<Seen>,
    chosen: Chosen,
    /// \[s\] the communication step
    step: f64,
    /// Lines of the summary: how two runs differ.
    compared: Vec<String>,
    /// \[s\] simulated now.
    simulated: f64,
    wall: Duration,
    /// \[s\] where Ctrl-C stopped it; not where it ended since all had come to rest.
    pub stopped: Option<f64>,
    /// Lines of the summary: what is coupled, what was seen, what was saved.
    coupling: Vec<String>,
    seen: Vec<String>,
    saved: Option<String>,
    /// Of a run that is shown, unless the FMU has no agents.
    pub recorded: Option<Run>,
    /// Why a file is not in its place.
    failed: Option<anyhow::Error>,
}

pub fn run(arguments: &Arguments) -> Result<()> {
    let (job, interrupt) = (arguments.job()?, Interrupt::watch());
    let mut ended = match arguments.accuracy {
        Some(accuracy) => run_for(accuracy, job, &interrupt)?,
        None => simulate(job, &interrupt)?,
    };
    let told = ended.tell();
    // What was computed is told nevertheless.
    ended.complete()?;
    let Some(time) = ended.stopped else { return told };
    let go_on = match &arguments.state {
        Some(path) if ended.saved.is_some() => format!("go on with --resume {}", path.display()),
        Some(_) => "it is not saved: no state can be taken in the middle of a step".into(),
        None => "it is not saved (--state)".into(),
    };
    Err(interrupted(format!("stopped at t = {time:?} s; {go_on}")))
}

fn interrupted(why: String) -> Error {
    Interrupted(why).into()
}

/// How often it is looked whether Ctrl-C was pressed.
const LOOK: Duration = Duration::from_millis(50);
/// After a step that took longer, Ctrl-C may find the next one under way: the state before it is put by.
const LONG: Duration = Duration::from_millis(100);

/// Runs and records; warnings go to standard error.
///
/// FMUs are called by a thread of their own. If Ctrl-C finds a step under way that does not end within [`PATIENCE`],
/// this one completes the files with what was recorded before; the step is given up with the program.
pub fn simulate(job: Job, interrupt: &Interrupt) -> Result<Ended> {
    let shared = Shared::default();
    let (done, ended) = channel();
    let thread = std::thread::Builder::new().name("run".into()).spawn({
        let (interrupt, shared) = (interrupt.clone(), shared.clone());
        // Nobody listens any more to a run that was given up.
        move || drop(done.send(step_and_record(job, &interrupt, &shared)))
    });
    let thread = thread.context("cannot start a thread")?;
    let mut pressed: Option<Instant> = None;
    loop {
        match ended.recv_timeout(LOOK) {
            Ok(ended) => return ended,
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => match thread.join() {
                Err(fault) => std::panic::resume_unwind(fault),
                Ok(()) => bail!("the run ended without a result"),
            },
        }
        if !interrupt.pressed() || pressed.get_or_insert_with(Instant::now).elapsed() < PATIENCE {
            continue;
        }
        if shared.give_up_before() {
            return Err(Interrupted::given_up().into());
        }
        if let Some(underway) = shared.take() {
            return underway.give_up();
        }
    }
}

fn step_and_record(job: Job, interrupt: &Interrupt, shared: &Shared) -> Result<Ended> {
    let Job { settings, places, state, ends, poses } = job;
    let prepared = Prepared::of(&settings).map_err(refused)?;
    let Prepared { mut system, trials, pushes, progress, before, coupled, warnings } = prepared;
    for warning in &warnings {
        note!("{}", warned(warning));
    }
    let first = system.time();
    let chosen = match &poses {
        Poses::Ignore => Chosen::new(),
        Poses::Keep | Poses::Compare(..) => steps_of(&system, coupled)?,
    };
    let left = series::claim(&system, &trials, &progress)?;
    let by = writers(before.as_ref().map_or("", |before| &before.lemons), &BUILD.whole());
    let about = vec![
        ("lemons_version", by.clone()),
        ("communication_step", format!("{:?}", progress.clock.step)),
        ("every", progress.every.to_string()),
    ];
    let recording = Recording { about, before: before.as_ref(), poses };
    let watch = Watch::create(&system, trials, places, recording)?;
    let rest = match ends {
        Ends::AtTime => None,
        Ends::Still => Some(Rest::Still(Still::after(pushes.end()))),
        Ends::Left => Some(Rest::Left(until_left(&system, &watch)?)),
    };
    let file = state.map(|path| Ok::<_, anyhow::Error>((files::stage(&path)?, path))).transpose()?;
    let coupling = described(&system, coupled, progress.clock.step);
    let kept = if file.is_some() { Some(Kept::of(&mut system, &progress)?) } else { None };
    series::remove(&left)?;
    let bar = match rest.as_ref().and_then(Rest::left) {
        // How long it takes is not known.
        Some((leave, _)) => {
            let style = ProgressStyle::with_template("{bar:40} {msg}  {pos} of {len} have left")?;
            ProgressBar::new(leave as u64).with_style(style)
        }
        None => {
            let style = ProgressStyle::with_template("{bar:40} {percent:>3}%  {msg}  {eta} left")?;
            ProgressBar::new(progress.clock.steps.saturating_sub(progress.index)).with_style(style)
        }
    };
    shared.put(Underway {
        first,
        time: first,
        started: Instant::now(),
        coupling,
        watch,
        file,
        at_hand: None,
        bar: bar.clone(),
        unzipped: system.components().iter().map(|c| c.fmu.directory().to_owned()).collect(),
    })?;
    let begun = Instant::now();
    let pushes = &pushes;
    let mut stepping = Stepping {
        pushes,
        by: &by,
        shared,
        interrupt,
        progress,
        kept,
        rest,
        bar,
        begun,
        interim: Interim::from(begun),
    };
    let done = stepping.advance(&mut system, before.is_none());
    // What was simulated before a failure is worth having.
    let Underway { started, coupling, watch, file, .. } = shared.take().context("the run was given up")?;
    let wall = started.elapsed();
    let records = watch.records(&system);
    if let Some(Rest::Left(leaving)) = &stepping.rest {
        stayed(leaving, &watch, &system, &stepping.progress);
    }
    let there = watch.standing().iter().flatten().count();
    let pressed = if done.is_ok() { pressing(&system, there)? } else { None };
    let Recorded { lines: seen, run: recorded, poses, placed } = watch.finish();
    let saved = file.map(|(file, path)| stepping.save(&system, file, &path, records)).transpose();
    // States are given back while their FMUs are there.
    drop(stepping.kept.take());
    let (clock, rest) = (stepping.progress.clock, &stepping.rest);
    let done = done.and_then(|()| Ok(system.terminate()?));
    for warning in system.warnings().into_iter().chain(pressed) {
        note!("{warning}");
    }
    if let Err(error) = done {
        return Err(stopped(error, system.time(), saved, placed));
    }
    let (saved, kept) = saved.map_or_else(|error| (None, Err(error)), |saved| (saved, Ok(())));
    Ok(Ended {
        poses,
        chosen,
        step: clock.step,
        compared: Vec::new(),
        simulated: system.time() - first,
        wall,
        stopped: (system.time() < clock.until
            && !rest.as_ref().is_some_and(|rest| rest.is_over(system.time())))
        .then(|| system.time()),
        coupling,
        seen,
        saved,
        recorded,
        failed: and_then(placed, kept).err(),
    })
}

/// The end of a run in which people leave: when nobody is there any more who has an exit.
fn until_left(system: &System, watch: &Watch) -> Result<Leaving> {
    let nobody =
        "--until left: nobody can leave: people do not walk, or have no exits (give a time in seconds)";
    ensure!(watch.may_leave(), nobody);
    // Only our own Decision FMUs say who has an exit; of others, all might leave.
    let known: Vec<Vec<bool>> = system
        .components()
        .iter()
        .filter_map(|component| plan_in(&component.fmu))
        .map(|plan| plan.leaving())
        .collect();
    let (people, counted) = (watch.people(), known.iter().map(Vec::len).sum::<usize>());
    let leave = known.iter().flatten().filter(|leaves| **leaves).count() + people.saturating_sub(counted);
    ensure!(leave > 0, nobody);
    if leave < people {
        note!(
            "note: {} of {people} people have no exit: the run ends when the others have left",
            people - leave
        );
    }
    let leaving = Leaving::of(leave);
    Ok(match &known[..] {
        [only] if only.len() == watch.ids().count() => leaving.among(only.clone()),
        _ => leaving,
    })
}

/// Ids of people who are told.
const TOLD: usize = 5;

/// Says who has not left, and why the run ends nevertheless.
fn stayed(leaving: &Leaving, watch: &Watch, system: &System, progress: &Progress) {
    let time = system.time();
    let why = match leaving.over() {
        Some(Over::Standstill) => {
            format!("in the last {STANDSTILL} s nobody has left or got further than {REACH} m")
        }
        None if time >= progress.clock.until => "this is the latest end".to_owned(),
        // Stopped, or failed.
        _ => return,
    };
    let (leave, left) = leaving.counts();
    let ids: Vec<&str> = watch.ids().collect();
    let mut stay: Vec<&str> = leaving.stay().take(TOLD).map(|agent| ids[agent]).collect();
    if leaving.stay().nth(TOLD).is_some() {
        stay.push("…");
    }
    note!(
        "warning: {} of {leave} people have not left: {why}; the run ends at t = {time:.3} s (still there: {})",
        leave - left,
        stay.join(", ")
    );
}

/// A system, for the lines at the end of a run. `step` \[s\] is the communication step.
fn described(system: &System, coupled: bool, step: f64) -> Vec<String> {
    let (components, connections) = (system.components().len(), system.connections());
    let algorithm = system.algorithm();
    let parts =
        format!("components         {components:>10}     ({algorithm} algorithm, {connections} connections)");
    coupled.then_some(parts).into_iter().chain([format!("communication step {step:>10} s")]).collect()
}

/// The error of a run that stopped at a time \[s\], after what became of its files was told.
fn stopped(error: Error, time: f64, saved: Result<Option<String>>, placed: Result<()>) -> Error {
    match saved {
        Ok(Some(line)) => note!("{line}"),
        Ok(None) => {}
        Err(why) => note!("warning: the run is not saved: {why:#}"),
    }
    let stopped = format!("stopped at t = {time:?} s");
    let quiet = nobody_listens(&error);
    error.context(match placed {
        Ok(()) => format!("{stopped}; the results until then are written"),
        Err(why) => {
            if !quiet {
                note!("lemons: {}", said(&why));
            }
            stopped
        }
    })
}

impl Ended {
    /// That all files are in their places.
    pub fn complete(&mut self) -> Result<()> {
        self.failed.take().map_or(Ok(()), Err)
    }

    fn tell(&self) -> Result<()> {
        let seconds = self.wall.as_secs_f64();
        self.coupling.iter().try_for_each(|line| say!("{line}"))?;
        if let Some(time) = self.stopped {
            say!("stopped by Ctrl-C  {time:>10.3} s")?;
        }
        say!("simulated time     {:>10.3} s", self.simulated)?;
        say!("wall time          {seconds:>10.3} s")?;
        say!("real-time factor   {:>10.2}", self.simulated / seconds)?;
        self.compared.iter().try_for_each(|line| say!("{line}"))?;
        Ok(self.seen.iter().chain(&self.saved).try_for_each(|line| say!("{line}"))?)
    }
}

/// Where the trajectories and the outputs go, and as what.
fn places_of(arguments: &Arguments) -> Result<Places> {
    let Arguments { output, outputs, format, .. } = arguments;
    let format = format.map(Format::from);
    let common = format.or(output.as_deref().and_then(Format::of)).unwrap_or(Format::Csv);
    let extension = common.extension();
    let place = |given: &Option<PathBuf>, default: PathBuf| {
        let Some(path) = given else { return Ok(Place { path: default, format: common }) };
        match (Format::of(path), format) {
            (Some(own), Some(wanted)) if own != wanted => bail!(Misused(format!(
                "{}: ends in .{}, but --format is {}",
                path.display(),
                own.extension(),
                wanted.extension()
            ))),
            (None, None) if path.extension().is_some() => bail!(Misused(format!(
                "{}: tables are .csv or .parquet: give such a name, or --format for one that ends otherwise",
                path.display()
            ))),
            (own, _) => Ok(Place { path: path.clone(), format: own.unwrap_or(common) }),
        }
    };
    let trajectories = place(output, format!("trajectories.{extension}").into())?;
    // Beside trajectories that were given a name: two runs with names of their own write to different files.
    let named = output.as_deref().filter(|path| *path != Path::new("-")).and_then(|path| {
        let stem = path.file_stem()?.to_str()?;
        Some(path.with_file_name(format!("{stem}_outputs.{extension}")))
    });
    let outputs = place(outputs, named.unwrap_or_else(|| format!("outputs.{extension}").into()))?;
    Ok(Places::Files { trajectories, outputs })
}

/// A run as it is stepped: what was looked at, and what it takes to go on with it.
struct Stepping<'a> {
    pushes: &'a Pushes,
    /// Builds of this program that wrote what is recorded.
    by: &'a str,
    shared: &'a Shared,
    interrupt: &'a Interrupt,
    progress: Progress,
    /// `None` if the run is not saved, or failed between two states.
    kept: Option<Kept>,
    rest: Option<Rest>,
    bar: ProgressBar,
    /// When the step under way began.
    begun: Instant,
    interim: Interim,
}

impl Observer<System> for Stepping<'_> {
    type Error = anyhow::Error;

    /// Until Ctrl-C, or until all have come to rest.
    fn goes_on(&mut self, system: &System) -> bool {
        self.begun = Instant::now();
        !self.interrupt.pressed() && !self.rest.as_ref().is_some_and(|rest| rest.is_over(system.time()))
    }

    fn look(&mut self, system: &mut System, reached: Reached) -> Result<()> {
        let long = self.begun.elapsed() >= LONG;
        // Until rows and state are both of the new point, no run can go on from it.
        let before = self.kept.take();
        if reached.regular {
            self.progress.index = reached.steps;
        }
        let written = reached.steps.is_multiple_of(self.progress.every);
        let (rest, point) = (&mut self.rest, if written { Point::Written } else { Point::Passed });
        self.shared.with(|underway| {
            underway.at_hand = None;
            underway.watch.look(system, point)?;
            underway.time = reached.time;
            if let Some(rest) = rest {
                rest.see(underway.time, &underway.watch);
            }
            Ok(())
        })?;
        if let Some(mut now) = before {
            now.renew(system, &self.progress)?;
            self.kept = Some(now);
        }
        if long {
            self.put_by(system)?;
        }
        self.bar.set_message(format!("t = {:.2} s", reached.time));
        if self.bar.is_hidden() && self.interim.is_due(Instant::now()) {
            note!("t = {:.2} s", reached.time);
        }
        match self.rest.as_ref().and_then(Rest::left) {
            Some((_, left)) => self.bar.set_position(left as u64),
            None => self.bar.inc(1),
        }
        Ok(())
    }
}

impl Stepping<'_> {
    /// Looks at the first point, unless the run goes on from there; steps to the end.
    fn advance(&mut self, system: &mut System, from_start: bool) -> Result<()> {
        if from_start {
            let rest = &mut self.rest;
            self.shared.with(|underway| {
                underway.watch.look(system, Point::Start)?;
                // Whether anybody rests is known after a step.
                if let Some(Rest::Left(leaving)) = rest {
                    leaving.see(system.time(), &underway.watch.standing());
                }
                Ok(())
            })?;
        }
        self.put_by(system)?;
        let (clock, first) = (self.progress.clock, self.progress.index);
        let _ = lemons_master::simulate(system, &clock, first, self.pushes, self)?;
        self.bar.finish_and_clear();
        Ok(())
    }

    /// Where a run that is given up in the next step can be gone on with.
    fn put_by(&self, system: &System) -> Result<()> {
        let Some(kept) = &self.kept else { return Ok(()) };
        let records = self.shared.with(|underway| Ok(underway.watch.records(system)))?;
        let at_hand = self.at_hand(system, kept, records)?;
        self.shared.with(|underway| {
            underway.at_hand = Some(at_hand);
            Ok(())
        })
    }

    /// Writes the state at the end of the run, and returns a line about it.
    fn save(&self, system: &System, file: Staged, path: &Path, records: Vec<CrowdRecord>) -> Result<String> {
        let kept = self.kept.as_ref().context("the run failed between two states");
        let at_hand = kept.and_then(|kept| self.at_hand(system, kept, records));
        at_hand.with_context(|| path.display().to_string())?.write(file, path)
    }

    fn at_hand(&self, system: &System, kept: &Kept, crowd: Vec<CrowdRecord>) -> Result<AtHand> {
        let (saved, states) = kept.saved(system, &self.progress, self.pushes, self.by)?;
        let saved = Saved { crowd, ..saved };
        Ok(AtHand { saved, states })
    }
}
