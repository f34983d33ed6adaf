//! `lemons run`: an FMU, or FMUs coupled by an SSP, stepped like any FMI master would.

mod accuracy;
mod fmus;
mod model;
mod outputs;
mod recorder;
mod trial;

use crate::connect::plain_names;
use crate::error::{Misused, and_then, full_message};
use crate::files::{self, Force};
use crate::interrupt::{Interrupt, Interrupted};
use crate::numbers::positive;
use crate::people::named;
use crate::print::{self, is_closed_pipe};
use crate::version::BUILD;
use accuracy::{Poses, run_for};
use anyhow::{Context, Error, Result, bail};
use clap::builder::{PossibleValuesParser, TypedValueParser};
use indicatif::ProgressBar;
use lemons_core::trial::DriveChoice;
use lemons_decision::Plan;
use lemons_master::{FileType, PlanChoice, Saved, Settings, TrialInput, writers};
use lemons_results::measure::{Leaving, WAITING, Wait};
use lemons_results::{Format, Frame, Run};
use lemons_sim::lint::late_legs;
use lemons_sim::{Algorithm, PointKind, Stepper, Until};
use model::{CrowdInfo, Prepared, RecordedModel};
use outputs::{OutputTable, Place};
pub use recorder::Target;
use recorder::{CrowdRecorder, Recorded};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::time::Instant;
pub use trial::not_set;

#[derive(clap::Args)]
pub struct Arguments {
    /// A Trial (a directory or a zip), an FMU, or an SSP of coupled FMUs
    #[arg(value_name = "TRIAL, FILE.fmu or FILE.ssp")]
    input: PathBuf,
    /// End of the simulation, in seconds; or the word left: when everybody has left by the exits of
    /// decision.toml, or when in 300 s nobody has left or got further than 5 m; at the latest after 3600 s.
    /// With --every, such a run goes on to the next row.
    /// Default: the stop time of the SSP, else 5
    #[arg(long, value_name = "SECONDS|left", value_parser = until)]
    until: Option<Until>,
    /// How coupled FMUs exchange values. jacobi: all FMUs use the values of the last communication
    /// point. gauss-seidel: the FMUs step one after the other, in the order of the SSP, and each uses the
    /// newest values
    #[arg(long, default_value = "jacobi", value_parser = PossibleValuesParser::new(["jacobi", "gauss-seidel"]).try_map(algorithm))]
    algorithm: Algorithm,
    #[command(flatten)]
    inputs: Inputs,
    /// Set a parameter or a start value, for example --set TimeStepMechanical=1e-5; for all agents:
    /// --set 'agent[*].Mass=80'; in an SSP, with the name of the component: --set crowd.Threads=2; for
    /// people who walk by decision.toml, --set 'decision.agent[3].DesiredSpeed=0.5'
    // The help shows it as it is.
    #[allow(rustdoc::broken_intra_doc_links)]
    #[arg(long = "set", value_name = "NAME=VALUE", value_parser = name_and_value)]
    settings: Vec<(String, String)>,
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
    /// Format of the tables: csv; or parquet, for long runs: smaller, with units in the metadata. Default: by the
    /// extension of -o, else csv
    #[arg(long, value_name = "FORMAT", hide_possible_values = true, value_parser = named(&[Format::Csv, Format::Parquet], Format::extension))]
    format: Option<Format>,
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

pub fn until(text: &str) -> Result<Until, String> {
    match text {
        "left" => Ok(Until::Left),
        text => seconds(text).map(Until::Time).map_err(|must| format!("{must}, or the word left")),
    }
}

/// What drives a run that is made now: by whom people are pushed, where they walk.
#[derive(clap::Args)]
pub struct Inputs {
    /// Communication step, in seconds. Default: the Trial's TimeStep; for several FMUs, the smallest
    /// of their default step sizes
    #[arg(long, value_name = "SECONDS", value_parser = seconds)]
    pub step: Option<f64>,
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
    /// Where people walk, instead of the Trial's decision.toml: see lemons decide --help. The run is that of
    /// the Trial's FMU coupled with that of lemons decide
    #[arg(long, value_name = "FILE.toml", conflicts_with = "no_plan")]
    plan: Option<PathBuf>,
    /// Ignore the Trial's decision.toml
    #[arg(long)]
    no_plan: bool,
}

impl Inputs {
    /// Returns whether one of its options was given.
    pub fn given(&self) -> bool {
        self.step.is_some() || self.drive.is_some() || self.no_drive || self.plan.is_some() || self.no_plan
    }

    /// Returns the settings of a run with these inputs.
    pub fn settings(&self, input: &Path) -> Settings {
        let drive = match &self.drive {
            Some(path) => DriveChoice::File(path.clone()),
            None if self.no_drive => DriveChoice::None,
            None => DriveChoice::Own,
        };
        let plan = match &self.plan {
            Some(path) => PlanChoice::File(path.clone()),
            None if self.no_plan => PlanChoice::None,
            None => PlanChoice::Own,
        };
        Settings { step: self.step, drive, plan, ..Settings::of(input) }
    }
}

/// A run, and what becomes of it.
pub struct Job {
    /// With a tolerance, the poses of all communication points are kept.
    pub settings: Settings,
    /// Where rows of crowds go.
    pub rows: Target,
    /// Where the outputs of what is not a crowd go, if they are recorded.
    pub outputs: Option<Place>,
    /// Where it is saved.
    pub state: Option<PathBuf>,
    /// When it ends, if not at the time of the settings.
    pub until: Option<Until>,
}

impl Arguments {
    fn job(&self) -> Result<Job> {
        let (rows, outputs) = places_of(self)?;
        let settings = Settings {
            threads: self.threads,
            until: self.until.map(Until::latest),
            every: self.every.map(u64::from),
            algorithm: self.algorithm,
            resume: self.resume.clone(),
            saves: self.state.is_some(),
            parameters: self.settings.clone(),
            ..self.inputs.settings(&self.input)
        };
        Ok(Job { settings, rows: Target::Table(rows), outputs, state: self.state.clone(), until: self.until })
    }
}

/// Name and value of `--set`.
pub fn name_and_value(text: &str) -> Result<(String, String), &'static str> {
    let (name, value) = text.split_once('=').ok_or("expected NAME=VALUE")?;
    Ok((name.to_owned(), value.to_owned()))
}

fn algorithm(name: String) -> serde_json::Result<Algorithm> {
    serde_json::from_value(name.into())
}

pub fn seconds(text: &str) -> Result<f64, String> {
    positive(text).map_err(|must| format!("{must} of seconds"))
}

fn length(text: &str) -> Result<f64, String> {
    positive(text).map_err(|must| format!("{must} of metres, for example 1e-4"))
}

/// The result of a run.
pub struct Ended {
    /// Of a run with a tolerance: the poses of each crowd, and the mechanical steps \[s\].
    poses: Vec<Poses>,
    mechanical_steps: Vec<(String, f64)>,
    /// \[s\] the communication step
    step: f64,
    /// Lines of the summary.
    summary: Vec<String>,
    /// \[s\] where Ctrl-C stopped it; not where it ended since all had come to rest.
    pub stopped: Option<f64>,
    /// The frames of a run that is shown, unless the FMU has no agents.
    pub recorded: Option<Run>,
    /// Whether all files are in their places.
    pub complete: Result<()>,
}

pub fn run(arguments: &Arguments) -> Result<()> {
    let (job, interrupt) = (arguments.job()?, Interrupt::watch());
    let ended = match arguments.accuracy {
        Some(accuracy) => run_for(accuracy, job, &interrupt)?,
        None => simulate(job, &interrupt)?,
    };
    let printed = ended.summary.iter().try_for_each(|line| say!("{line}"));
    // What was computed is told nevertheless.
    ended.complete?;
    let Some(time) = ended.stopped else { return Ok(printed?) };
    let go_on = match &arguments.state {
        Some(path) => format!("go on with --resume {}", path.display()),
        None => "it is not saved (--state)".into(),
    };
    Err(Interrupted(format!("stopped at t = {time:?} s; {go_on}")).into())
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

/// What tables say of a run.
pub struct About {
    lines: Vec<(&'static str, String)>,
    /// True if a saved run goes on: then no table is replaced, which may be one of the run before.
    goes_on: bool,
}

/// Runs and records; warnings go to standard error. Ctrl-C ends the run after the step under way.
pub fn simulate(job: Job, interrupt: &Interrupt) -> Result<Ended> {
    let Job { settings, rows, outputs, state, until } = job;
    let compared = settings.tolerance.is_some();
    let Prepared {
        mut model,
        crowds,
        output_columns,
        plans,
        coupling: mut summary,
        mechanical_steps,
        output_directories,
        clock,
        every,
        drive,
        components,
        wiring,
        before,
    } = prepare(&settings)?;
    model.take_warnings().iter().for_each(|warning| note!("{warning}"));
    let late = plans.iter().filter_map(|plan| late_legs(plan, clock.step, Path::new("")));
    late.for_each(|found| note!("{found}"));
    summary.push(format!("communication step {:>10} s", clock.step));
    if compared && mechanical_steps.is_empty() {
        bail!(
            "--accuracy: nothing here has a parameter TimeStepMechanical, so no mechanical step can be chosen"
        );
    }
    if before.is_none() {
        let named = output_directories.iter().filter(|name| !name.is_empty());
        named.map(Path::new).try_for_each(claim_series)?;
    }
    let (first, index) = before.as_ref().map_or((clock.start, 0), |before| (before.time, before.index));
    let lemons = writers(before.as_ref().map_or("", |before| &before.lemons), &BUILD.whole());
    let lines = vec![
        ("lemons_version", lemons.clone()),
        ("communication_step", format!("{:?}", clock.step)),
        ("every", every.to_string()),
    ];
    let about = About { lines, goes_on: before.is_some() };
    let outputs = outputs.filter(|_| !output_columns.is_empty());
    let mut outputs = outputs.map(|place| OutputTable::create(output_columns, &place, &about)).transpose()?;
    let mut recorders = Vec::with_capacity(crowds.len());
    // Files have plain names.
    let names = plain_names(crowds.iter().map(|crowd| crowd.component.as_str()));
    let several = crowds.len() > 1;
    for (crowd, name) in crowds.into_iter().zip(&names) {
        let to = if several { rows.named(name)? } else { rows.clone() };
        recorders.push(CrowdRecorder::create(crowd, to, &about, before.as_ref(), compared)?);
    }
    let stop = match until {
        Some(until) => {
            until.condition(drive.end(), || who_leaves(&plans, &recorders)).context("--until left")?
        }
        None => None,
    };
    let mut stepper = Stepper::new(clock, every, stop).from(index);
    if let Some(leaving) = stepper.leaving() {
        note_without_exit(leaving, recorders.iter().map(|crowd| crowd.crowd.ids.len()).sum());
    }
    let file = state.map(|path| Ok::<_, Error>((files::stage(&path)?, path))).transpose()?;
    let bar = progress_bar(&stepper)?;
    let started = Instant::now();
    let mut noted = started;
    let mut record = |run: &Stepper, model: &mut (dyn RecordedModel + 'static), frames: Vec<Frame>, kind| {
        let time = model.time();
        for (recorder, frame) in recorders.iter_mut().zip(frames) {
            recorder.see(frame, kind)?;
        }
        if matches!(kind, PointKind::Start | PointKind::Written)
            && let Some(outputs) = &mut outputs
        {
            outputs.row(time, &model.outputs()?)?;
        }
        bar.set_message(format!("t = {time:.2} s"));
        if run.steps() > 0 && bar.is_hidden() && print::is_due(&mut noted, Instant::now()) {
            note!("t = {time:.2} s");
        }
        bar.set_position(run.leaving().map_or(run.steps(), |leaving| leaving.counts().1 as u64));
        Ok::<_, Error>(if interrupt.pressed() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) })
    };
    let kind = if before.is_none() { PointKind::Start } else { PointKind::Resumed };
    let done = stepper.run(&mut *model, &mut record, kind);
    bar.finish_and_clear();
    let (wall, time) = (started.elapsed().as_secs_f64(), model.time());
    let over = stepper.is_over();
    if let Some(leaving) = stepper.leaving().filter(|_| over) {
        note_remaining(leaving, &recorders, time);
    }
    let saved = match (&done, file) {
        (Ok(()), Some((file, path))) => {
            let states = model.states()?;
            let crowd = recorders.iter().map(CrowdRecorder::record).collect();
            let saved = Saved {
                format: Saved::FORMAT,
                lemons,
                start: clock.start,
                step: clock.step,
                until: clock.until,
                index: stepper.index(),
                time,
                every,
                algorithm: settings.algorithm.to_string(),
                wiring,
                drive: drive.fingerprint(),
                component: components,
                crowd,
            };
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
    if let Some(leaving) = stepper.leaving()
        && let Some(Wait { agent, from, time }) = leaving.longest_wait()
    {
        let ids: Vec<&String> = recorders.iter().flat_map(|crowd| &crowd.crowd.ids).collect();
        summary.push(format!(
            "longest wait       {time:>10.3} s   (agent {}, within {WAITING} m from t = {from:.3} s on)",
            ids[agent]
        ));
    }
    let mut warnings = Vec::new();
    if let (Ok(()), [plan], [crowd]) = (&done, &plans[..], &recorders[..]) {
        let found = crowd.end.findings(plan, model.drive().as_deref(), !about.goes_on);
        warnings.extend(found.iter().map(ToString::to_string));
    }
    if !over {
        summary.push(format!("stopped by Ctrl-C  {time:>10.3} s"));
    }
    let simulated = time - first;
    summary.push(format!("simulated time     {simulated:>10.3} s"));
    summary.push(format!("wall time          {wall:>10.3} s"));
    summary.push(format!("real-time factor   {:>10.2}", simulated / wall));
    // What was simulated before a failure is worth having.
    let (mut recorded, mut poses, mut complete) = (None, Vec::new(), Ok(()));
    for recorder in recorders {
        summary.extend(several.then(|| format!("crowd              {}", recorder.crowd.component)));
        let (Recorded { lines, run, poses: own }, placed) = recorder.finish();
        summary.extend(lines);
        poses.extend(own);
        recorded = recorded.or(run);
        complete = and_then(complete, placed);
    }
    match outputs.map(OutputTable::finish).transpose() {
        Ok(line) => summary.extend(line),
        Err(error) => complete = and_then(complete, Err(error)),
    }
    let done = done.and_then(|()| model.terminate());
    model.take_warnings().iter().chain(&warnings).for_each(|warning| note!("{warning}"));
    if let Err(error) = done {
        return Err(stopped(error, time, complete));
    }
    match saved {
        Ok(line) => summary.extend(line),
        Err(error) => complete = and_then(complete, Err(error)),
    }
    let stopped = (!over).then_some(time);
    Ok(Ended { poses, mechanical_steps, step: clock.step, summary, stopped, recorded, complete })
}

/// A crowd writes XML files of its own into its OutputDirectory: those of an earlier run must not be among them.
fn claim_series(directory: &Path) -> Result<()> {
    files::claim_series(directory).context("OutputDirectory")?.iter().try_for_each(|path| {
        let cannot = || format!("OutputDirectory: cannot remove {}", path.display());
        std::fs::remove_file(path).with_context(cannot)
    })
}

fn progress_bar(run: &Stepper) -> Result<ProgressBar> {
    let (length, template) = match run.leaving() {
        // How long it takes is not known.
        Some(leaving) => (leaving.counts().0 as u64, "{bar:40} {msg}  {pos} of {len} have left"),
        None => (run.clock.steps.saturating_sub(run.index()), "{bar:40} {percent:>3}%  {msg}  {eta} left"),
    };
    print::bar(length, template)
}

/// Returns of everybody whether they are to leave.
fn who_leaves(plans: &[Plan], recorders: &[CrowdRecorder]) -> Vec<bool> {
    let mut plans = plans.iter().map(Plan::leaving);
    let who = recorders.iter().flat_map(|recorder| {
        let CrowdInfo { ids, groups, .. } = &recorder.crowd;
        // Only our own plans say who has an exit; of others, all might leave.
        let known = if groups.active { plans.next() } else { None };
        known.filter(|who| who.len() == ids.len()).unwrap_or_else(|| vec![groups.active; ids.len()])
    });
    who.collect()
}

fn note_without_exit(leaving: &Leaving, people: usize) {
    let stay = people - leaving.counts().0;
    if stay > 0 {
        note!("note: {stay} of {people} people have no exit: the run ends when the others have left");
    }
}

/// Says who has not left, and why the run ends nevertheless.
fn note_remaining(leaving: &Leaving, recorders: &[CrowdRecorder], time: f64) {
    let Some(why) = leaving.why_some_stay(time) else { return };
    let ids: Vec<&String> = recorders.iter().flat_map(|crowd| &crowd.crowd.ids).collect();
    let stay: Vec<&String> = leaving.stay().map(|agent| ids[agent]).collect();
    note!("warning: {why} (still there: {})", print::few(&stay, 5));
}

/// The error of a run that stopped at a time \[s\], after what became of its files was told.
fn stopped(error: Error, time: f64, placed: Result<()>) -> Error {
    let written = match placed {
        Ok(()) => "; the results until then are written",
        Err(_) if is_closed_pipe(&error) => "",
        Err(why) => {
            note!("lemons: {}", full_message(&why));
            ""
        }
    };
    error.context(format!("stopped at t = {time:?} s{written}"))
}

/// Returns where the trajectories and the outputs go, and as what.
fn places_of(arguments: &Arguments) -> Result<(Place, Option<Place>)> {
    let Arguments { output, outputs, format, .. } = arguments;
    let common = format.or(output.as_deref().and_then(Format::of)).unwrap_or(Format::Csv);
    let place = |path: &Path| match (Format::of(path), *format) {
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
        (own, _) => Ok(Place { path: path.to_owned(), format: own.unwrap_or(common) }),
    };
    let default = PathBuf::from(format!("trajectories.{}", common.extension()));
    let trajectories = place(output.as_deref().unwrap_or(&default))?;
    Ok((trajectories, outputs.as_deref().map(place).transpose()?))
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
