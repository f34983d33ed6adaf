//! `lemons run`: an FMU, or FMUs coupled by an SSP, stepped like any FMI master would.

mod accuracy;
mod fmus;
mod model;
mod outputs;
mod recorder;
mod trial;

use crate::connect::plain_names;
use crate::decide::Walk;
use crate::error::{Misused, and_then, full_message};
use crate::files::{self, Force};
use crate::interrupt::{Interrupt, Interrupted};
use crate::print::{ProgressNotes, is_closed_pipe};
use crate::results::{Format, FormatName, Place};
use accuracy::{Poses, run_for};
use anyhow::{Context, Error, Result, bail, ensure};
use clap::builder::{PossibleValuesParser, TypedValueParser};
use indicatif::{ProgressBar, ProgressStyle};
use lemons_core::trial::DriveChoice;
use lemons_decision::Plan;
use lemons_decision::target::nearest_exit;
use lemons_decision::walking_model::WalkingModel;
use lemons_master::{FileType, Saved, Settings, TrialInput};
use lemons_results::measure::{LATEST, Leaving, Over, REACH, STANDSTILL};
use lemons_results::{Frame, Run};
use lemons_sim::stop::{Still, StopCondition};
use lemons_sim::{Algorithm, Point};
use model::{Prepared, RunModel};
use outputs::OutputTable;
pub use recorder::Target as RowTarget;
use recorder::{CrowdRecorder, PointKind, Recorded, Target};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
pub use trial::not_set;

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
    #[arg(long, default_value = ALGORITHMS[0], value_parser = PossibleValuesParser::new(ALGORITHMS).map(algorithm))]
    algorithm: Algorithm,
    /// Propulsion over time: a CSV file with columns t,agent,Fp.x,Fp.y,Mp. At each communication point,
    /// values are interpolated linearly between rows; they are held until the next point, so results
    /// depend on the communication step. Before the first and after the last row they are zero. Agents that are not
    /// in the file keep the values of AgentDynamics.xml. Default: the Trial's drive.csv if there is one, which
    /// its FMU plays by itself (in an SSP, too, but not for people whose Fp or Mp is connected). Where people walk by decision.toml, it is added to the forces
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
    /// File for the outputs of what is not a crowd: of other FMUs, or where people want to go
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

/// When a run ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Until {
    /// \[s\]
    Time(f64),
    /// \[s\] At the first communication point that is not before, as pictures need it: the last step is a whole one.
    Point(f64),
    /// When all have come to rest, as movies need it, and at [`LATEST_REST`].
    Still,
    /// When nobody is there any more, and at [`LATEST`].
    Left,
}

/// \[s\] Crowds that push for ever never come to rest.
const LATEST_REST: f64 = 120.0;

impl Until {
    /// \[s\]
    pub fn time(self) -> Option<f64> {
        match self {
            Until::Time(time) | Until::Point(time) => Some(time),
            Until::Still | Until::Left => None,
        }
    }

    /// \[s\] Returns when it ends at the latest.
    pub fn latest(self) -> f64 {
        self.time().unwrap_or(if self == Until::Still { LATEST_REST } else { LATEST })
    }
}

pub fn until(text: &str) -> Result<Until, String> {
    match text {
        "left" => Ok(Until::Left),
        text => positive(text).map(Until::Time).map_err(|error| format!("{error}, or the word left")),
    }
}

/// A run, and what becomes of it.
pub struct Job {
    pub settings: Settings,
    /// Where rows of crowds go.
    pub rows: Target,
    /// Where the outputs of what is not a crowd go, if they are recorded.
    pub outputs: Option<Place>,
    /// Where it is saved.
    pub state: Option<PathBuf>,
    /// When it ends, unless at the time of the settings.
    pub until: Option<Until>,
    /// True if the poses of all communication points are kept.
    pub keeps_poses: bool,
}

impl Arguments {
    fn job(&self) -> Result<Job> {
        let (rows, outputs) = places_of(self)?;
        let settings = Settings {
            parameters: name_and_value_of_all(&self.settings)?,
            threads: self.threads,
            step: self.step,
            until: self.until.map(Until::latest),
            every: self.every.map(u64::from),
            drive: drive_of(self.drive.as_deref(), self.no_drive),
            plan: self.walk.choice(),
            algorithm: self.algorithm,
            resume: self.resume.clone(),
            saves: self.state.is_some(),
            ..Settings::of(&self.input)
        };
        let (state, until) = (self.state.clone(), self.until);
        Ok(Job { settings, rows, outputs, state, until, keeps_poses: false })
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

const ALGORITHMS: [&str; 2] = ["jacobi", "gauss-seidel"];

fn algorithm(name: String) -> Algorithm {
    if name == ALGORITHMS[0] { Algorithm::Jacobi } else { Algorithm::GaussSeidel }
}

fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value > 0.0 && value.is_finite() => Ok(value),
        _ => Err("must be a positive number of seconds".into()),
    }
}

fn length(text: &str) -> Result<f64, String> {
    positive(text).map_err(|_| "must be a positive number of metres, for example 1e-4".into())
}

/// The result of a run.
pub struct Ended {
    /// If poses are kept: those of each crowd, and the mechanical steps \[s\].
    poses: Vec<Poses>,
    mechanical_steps: Vec<(String, f64)>,
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
    /// The frames of a run that is shown, unless the FMU has no agents.
    pub recorded: Option<Run>,
    /// Why a file is not in its place.
    failed: Option<Error>,
}

pub fn run(arguments: &Arguments) -> Result<()> {
    let (job, interrupt) = (arguments.job()?, Interrupt::watch());
    let mut ended = match arguments.accuracy {
        Some(accuracy) => run_for(accuracy, job, &interrupt)?,
        None => simulate(job, &interrupt)?,
    };
    let printed = ended.print();
    // What was computed is told nevertheless.
    ended.complete()?;
    let Some(time) = ended.stopped else { return printed };
    let go_on = match &arguments.state {
        Some(path) => format!("go on with --resume {}", path.display()),
        None => "it is not saved (--state)".into(),
    };
    Err(interrupted(format!("stopped at t = {time:?} s; {go_on}")))
}

fn interrupted(why: String) -> Error {
    Interrupted(why).into()
}

/// Prepares a run of a Trial, an FMU or an SSP.
fn prepare(settings: &Settings) -> Result<Prepared> {
    let runs = [FileType::TRIAL, FileType::FMU, FileType::SSP, FileType::ARCHIVE];
    FileType::expect(&settings.input, &runs, "a Trial directory, an FMU or an SSP")?;
    match TrialInput::find(&settings.input)? {
        Some(given) => trial::prepare(&given, settings),
        None => fmus::prepare(settings),
    }
}

/// The texts that tables have of a run.
struct About {
    lines: Vec<(&'static str, String)>,
    /// True if a saved run goes on: then no table is replaced, which may be one of the run before.
    goes_on: bool,
}

impl About {
    fn of(record: &Saved, goes_on: bool) -> About {
        let lines = vec![
            ("lemons_version", record.lemons.clone()),
            ("communication_step", format!("{:?}", record.step)),
            ("every", record.every.to_string()),
        ];
        About { lines, goes_on }
    }
}

/// Runs and records; warnings go to standard error. Ctrl-C ends the run after the step under way.
pub fn simulate(job: Job, interrupt: &Interrupt) -> Result<Ended> {
    let Job { settings, rows, outputs, state, until, keeps_poses } = job;
    let Prepared {
        mut model,
        crowds,
        output_columns,
        plans,
        mut coupling,
        mechanical_steps,
        output_directories,
        clock,
        drive_end,
        record,
        before,
    } = prepare(&settings)?;
    model.take_warnings().iter().for_each(|warning| note!("{warning}"));
    coupling.push(format!("communication step {:>10} s", clock.step));
    if keeps_poses && mechanical_steps.is_empty() {
        bail!(
            "--accuracy: nothing here has a parameter TimeStepMechanical, so no mechanical step can be chosen"
        );
    }
    if before.is_none() {
        let named = output_directories.iter().filter(|name| !name.is_empty());
        named.map(Path::new).try_for_each(claim_series)?;
    }
    let Saved { index, every, .. } = record;
    let about = About::of(&record, before.is_some());
    let outputs = outputs.filter(|_| !output_columns.is_empty());
    let outputs = outputs.map(|place| OutputTable::create(output_columns, &place, &about)).transpose()?;
    let mut recorders = Vec::with_capacity(crowds.len());
    // Files have plain names.
    let names = plain_names(crowds.iter().map(|crowd| crowd.component.as_str()));
    let several = crowds.len() > 1;
    for (crowd, name) in crowds.into_iter().zip(&names) {
        let to = if several { rows.named(name)? } else { rows.clone() };
        recorders.push(CrowdRecorder::create(crowd, to, &about, before.as_ref(), keeps_poses)?);
    }
    let stop = match until {
        None | Some(Until::Time(_) | Until::Point(_)) => None,
        Some(Until::Still) => Some(StopCondition::Still(Still::after(drive_end))),
        Some(Until::Left) => {
            let plans: Vec<Vec<bool>> = plans.iter().map(|plan| plan.leaving()).collect();
            Some(StopCondition::Left(until_left(&plans, &recorders)?))
        }
    };
    let file = state.map(|path| Ok::<_, Error>((files::stage(&path)?, path))).transpose()?;
    let first = model.time();
    let bar = progress_bar(stop.as_ref(), clock.steps.saturating_sub(index))?;
    let started = Instant::now();
    let mut run = Recording {
        recorders,
        outputs,
        stop,
        every,
        index,
        bar,
        notes: ProgressNotes::from(started),
        interrupt,
    };
    let mut done = run.see(&mut *model, if before.is_none() { PointKind::Start } else { PointKind::Resumed });
    if done.is_ok() && !interrupt.pressed() {
        done = run.steps(&mut *model, clock.points(index));
    }
    run.bar.finish_and_clear();
    let (wall, time) = (started.elapsed(), model.time());
    let Recording { recorders, outputs, stop, index, .. } = run;
    if let Some(StopCondition::Left(leaving)) = &stop {
        note_remaining(leaving, &recorders, time, clock.until);
    }
    let saved = match (&done, file) {
        (Ok(()), Some((file, path))) => {
            let states = model.states()?;
            let crowd = recorders.iter().map(CrowdRecorder::record).collect();
            let saved = Saved { index, time, crowd, ..record };
            let shown = path.display();
            let written = saved.write(&states, file).with_context(|| format!("cannot write {shown}"));
            written.map(|()| Some(format!("saved run          {shown}   (at t = {time:.3} s)")))
        }
        (Err(_), Some((_, path))) => {
            note!("warning: {}: a run that fails is not saved", path.display());
            Ok(None)
        }
        _ => Ok(None),
    };
    let stuck = match (&done, &plans[..], &recorders[..]) {
        (Ok(()), [plan], [crowd]) if plan.walking_model == WalkingModel::Straight => {
            stuck_warning(&mut *model, plan, crowd)?
        }
        _ => None,
    };
    let queues = match (&done, &plans[..], &recorders[..]) {
        (Ok(()), [plan], [crowd]) if !about.goes_on => uneven_queues(plan, crowd),
        _ => None,
    };
    // What was simulated before a failure is worth having.
    let (mut seen, mut recorded, mut poses, mut failed) = (Vec::new(), None, Vec::new(), Ok(()));
    for recorder in recorders {
        seen.extend(several.then(|| format!("crowd              {}", recorder.crowd().component)));
        let (Recorded { lines, run, poses: own }, placed) = recorder.finish();
        seen.extend(lines);
        poses.extend(own);
        recorded = recorded.or(run);
        failed = and_then(failed, placed);
    }
    match outputs.map(OutputTable::finish).transpose() {
        Ok(line) => seen.extend(line),
        Err(error) => failed = and_then(failed, Err(error)),
    }
    let done = done.and_then(|()| model.terminate());
    model.take_warnings().into_iter().chain(stuck).chain(queues).for_each(|warning| note!("{warning}"));
    if let Err(error) = done {
        return Err(stopped(error, time, failed));
    }
    let (saved, kept) = saved.map_or_else(|error| (None, Err(error)), |saved| (saved, Ok(())));
    let over = time >= clock.until || stop.is_some_and(|stop| stop.is_over(time));
    Ok(Ended {
        poses,
        mechanical_steps,
        step: clock.step,
        compared: Vec::new(),
        simulated: time - first,
        wall,
        stopped: (!over).then_some(time),
        coupling,
        seen,
        saved,
        recorded,
        failed: and_then(failed, kept).err(),
    })
}

/// A crowd writes XML files of its own into its OutputDirectory: those of an earlier run must not be among them.
fn claim_series(directory: &Path) -> Result<()> {
    files::claim_series(directory).context("OutputDirectory")?.iter().try_for_each(|path| {
        let cannot = || format!("OutputDirectory: cannot remove {}", path.display());
        std::fs::remove_file(path).with_context(cannot)
    })
}

/// A run as it is stepped.
struct Recording<'a> {
    recorders: Vec<CrowdRecorder>,
    outputs: Option<OutputTable>,
    stop: Option<StopCondition>,
    every: u64,
    /// The last communication point of the clock that was reached.
    index: u64,
    bar: ProgressBar,
    notes: ProgressNotes,
    interrupt: &'a Interrupt,
}

impl Recording<'_> {
    fn see(&mut self, model: &mut dyn RunModel, kind: PointKind) -> Result<()> {
        let mut frames = Vec::with_capacity(self.recorders.len());
        for crowd in 0..self.recorders.len() {
            frames.push(model.frame(crowd)?);
        }
        match &mut self.stop {
            // Whether anybody rests is known after a step.
            Some(StopCondition::Still(_)) if matches!(kind, PointKind::Start | PointKind::Resumed) => {}
            Some(stop @ StopCondition::Still(_)) => stop.see(model.time(), &frames),
            Some(stop @ StopCondition::Left(_)) => {
                let leave =
                    frames.iter().zip(&self.recorders).filter(|(_, crowd)| crowd.crowd().groups.active);
                let leave: Vec<Frame> = leave.map(|(frame, _)| frame.clone()).collect();
                stop.see(model.time(), &leave);
            }
            None => {}
        }
        for (recorder, frame) in self.recorders.iter_mut().zip(frames) {
            recorder.see(frame, kind)?;
        }
        match &mut self.outputs {
            Some(outputs) if matches!(kind, PointKind::Start | PointKind::Written) => {
                outputs.row(model.time(), &model.outputs()?)
            }
            _ => Ok(()),
        }
    }

    /// Makes steps to these points, until it is over.
    fn steps(&mut self, model: &mut dyn RunModel, points: impl Iterator<Item = Point>) -> Result<()> {
        for point in points {
            model.step_to(point.time)?;
            if self.step(model, point)?.is_break() {
                break;
            }
        }
        Ok(())
    }

    /// After a step.
    fn step(&mut self, model: &mut dyn RunModel, point: Point) -> Result<ControlFlow<()>> {
        if point.regular {
            self.index = point.steps;
        }
        let written = point.steps.is_multiple_of(self.every);
        self.see(model, if written { PointKind::Written } else { PointKind::Passed })?;
        self.bar.set_message(format!("t = {:.2} s", point.time));
        if self.bar.is_hidden() && self.notes.is_due(Instant::now()) {
            note!("t = {:.2} s", point.time);
        }
        match self.stop.as_ref().and_then(StopCondition::left) {
            Some((_, left)) => self.bar.set_position(left as u64),
            None => self.bar.inc(1),
        }
        let over = self.stop.as_ref().is_some_and(|stop| stop.is_over(point.time));
        Ok(if over || self.interrupt.pressed() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) })
    }
}

fn progress_bar(stop: Option<&StopCondition>, steps: u64) -> Result<ProgressBar> {
    let (length, template) = match stop.and_then(StopCondition::left) {
        // How long it takes is not known.
        Some((leave, _)) => (leave as u64, "{bar:40} {msg}  {pos} of {len} have left"),
        None => (steps, "{bar:40} {percent:>3}%  {msg}  {eta} left"),
    };
    Ok(crate::print::bar(length).with_style(ProgressStyle::with_template(template)?))
}

/// The end of a run in which people leave: when nobody is there any more who has an exit.
fn until_left(plans: &[Vec<bool>], recorders: &[CrowdRecorder]) -> Result<Leaving> {
    let nobody =
        "--until left: nobody can leave: people do not walk, or have no exits (give a time in seconds)";
    let leaving = || recorders.iter().filter(|crowd| crowd.crowd().groups.active);
    ensure!(leaving().next().is_some(), nobody);
    // Only our own plans say who has an exit; of others, all might leave.
    let people: usize = leaving().map(|crowd| crowd.crowd().ids.len()).sum();
    let counted: usize = plans.iter().map(Vec::len).sum();
    let leave = plans.iter().flatten().filter(|leaves| **leaves).count() + people.saturating_sub(counted);
    ensure!(leave > 0, nobody);
    if leave < people {
        note!(
            "note: {} of {people} people have no exit: the run ends when the others have left",
            people - leave
        );
    }
    Ok(match plans {
        [only] if only.len() == people => Leaving::of(leave).among(only.clone()),
        _ => Leaving::of(leave),
    })
}

/// Ids of people who are told.
const MOST_IDS: usize = 5;

/// Says who has not left, and why the run ends nevertheless.
fn note_remaining(leaving: &Leaving, recorders: &[CrowdRecorder], time: f64, until: f64) {
    let why = match leaving.over() {
        Some(Over::Standstill) => {
            format!("in the last {STANDSTILL} s nobody has left or got further than {REACH} m")
        }
        None if time >= until => "this is the latest end".to_owned(),
        // Stopped, or failed.
        _ => return,
    };
    let (leave, left) = leaving.counts();
    let ids: Vec<&str> = recorders.iter().flat_map(|crowd| &crowd.crowd().ids).map(String::as_str).collect();
    let mut stay: Vec<&str> = leaving.stay().take(MOST_IDS).map(|agent| ids[agent]).collect();
    if leaving.stay().nth(MOST_IDS).is_some() {
        stay.push("…");
    }
    note!(
        "warning: {} of {leave} people have not left: {why}; the run ends at t = {time:.3} s (still there: {})",
        leave - left,
        stay.join(", ")
    );
}

/// Ratio and difference \[s\] of the times of the last departures by two exits: from these on, a note is printed.
const UNEVEN: (f64, f64) = (1.5, 10.0);

/// A note for the end of a run in which the last person left by one exit much later than by another, or nobody by that.
fn uneven_queues(plan: &Plan, crowd: &CrowdRecorder) -> Option<String> {
    // \[s\] With the names; 0 where nobody has left.
    let exits = plan.targets.iter().enumerate().filter(|(_, target)| !target.stay);
    let mut last: Vec<(usize, &str, f64)> = exits.map(|(k, exit)| (k, &exit.name[..], 0.0)).collect();
    for (time, at) in crowd.departures() {
        let exit = nearest_exit(&plan.targets, *at)?;
        let entry = last.iter_mut().find(|entry| entry.0 == exit)?;
        entry.2 = time.max(entry.2);
    }
    let order = |a: &&(usize, &str, f64), b: &&(usize, &str, f64)| a.2.total_cmp(&b.2);
    let (least, most) = (last.iter().min_by(order)?, last.iter().max_by(order)?);
    if most.2 <= UNEVEN.0 * least.2 || most.2 <= least.2 + UNEVEN.1 {
        return None;
    }
    let before = match least {
        (_, name, 0.0) => format!("nobody by {name:?}"),
        (_, name, time) => format!("by {name:?} at {time:.1} s"),
    };
    Some(format!(
        "note: exits are used unevenly: the last person left by {:?} at {:.1} s, {before} (exit_choice in decision.toml)",
        most.1, most.2
    ))
}

/// Part of the desired speed: who is slower and touched gets no further.
const STUCK: f64 = 0.1;

/// A warning for the end of a run with the model `straight` if more than half of the people who are there are pushed,
/// want to walk and get no further.
fn stuck_warning(model: &mut dyn RunModel, plan: &Plan, crowd: &CrowdRecorder) -> Result<Option<String>> {
    let (frame, people) = (crowd.last(), plan.agents.len());
    if frame.agents.len() != people {
        return Ok(None);
    }
    let names: Vec<String> =
        (0..people).flat_map(|i| ["x", "y"].map(|axis| format!("agent[{i}].Fp.{axis}"))).collect();
    let forces = model.values(0, &names)?;
    let squeeze = |i: usize| {
        let step = frame.observed.as_ref().and_then(|observed| observed[i].of_step);
        step.map_or(0.0, |step| step.mean_normal_force)
    };
    let stuck = |i: &usize| {
        let desired = plan.agents[*i].walker.desired_speed;
        let driven = forces[2 * i].hypot(forces[2 * i + 1]) > 0.0;
        driven && squeeze(*i) > 0.0 && frame.agents[*i].twist.velocity.norm() < STUCK * desired
    };
    let mut squeezed: Vec<f64> = (0..people).filter(stuck).map(squeeze).collect();
    squeezed.sort_by(f64::total_cmp);
    let (stuck, there) = (squeezed.len(), frame.present().count());
    Ok((2 * stuck > there && stuck > 1).then(|| {
        format!(
            "warning: at t = {:.3} s {stuck} of the {there} people who are there press on and get no further (median squeeze \
             {:.0} N): in the model \"straight\" people walk on, whoever is in the way (in decision.toml, model = \
             \"rotational\" makes them keep distances)",
            frame.time,
            squeezed[stuck / 2]
        )
    }))
}

/// The error of a run that stopped at a time \[s\], after what became of its files was told.
fn stopped(error: Error, time: f64, placed: Result<()>) -> Error {
    let stopped = format!("stopped at t = {time:?} s");
    let quiet = is_closed_pipe(&error);
    error.context(match placed {
        Ok(()) => format!("{stopped}; the results until then are written"),
        Err(why) => {
            if !quiet {
                note!("lemons: {}", full_message(&why));
            }
            stopped
        }
    })
}

impl Ended {
    /// Checks that all files are in their places.
    pub fn complete(&mut self) -> Result<()> {
        self.failed.take().map_or(Ok(()), Err)
    }

    fn print(&self) -> Result<()> {
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
fn places_of(arguments: &Arguments) -> Result<(Target, Option<Place>)> {
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
    let outputs = outputs.as_ref().map(|path| place(&Some(path.clone()), PathBuf::new())).transpose()?;
    Ok((Target::Table(trajectories), outputs))
}

impl Target {
    /// The same for one of several crowds: `dir/file.csv` -> `dir/file_name.csv`.
    fn named(&self, name: &str) -> Result<Target> {
        let Target::Table(Place { path, format }) = self else { return Ok(self.clone()) };
        if files::is_standard_output(path) {
            bail!("-o -: several crowds do not go to standard output together: -o FILE");
        }
        let stem = path.file_stem().unwrap_or_default().to_string_lossy();
        let end = path.extension().map(|end| format!(".{}", end.to_string_lossy())).unwrap_or_default();
        let path = path.with_file_name(format!("{stem}_{name}{end}"));
        Ok(Target::Table(Place { path, format: *format }))
    }
}
