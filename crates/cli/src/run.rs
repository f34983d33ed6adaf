//! `lemons run`: an FMU, or FMUs coupled by an SSP, stepped like any FMI master would.

mod prepare;
mod progress;
mod rest;
mod underway;

use crate::error::Misused;
use crate::files::{self, Force};
use crate::interrupt::{Interrupt, Interrupted};
use crate::recording::Recording;
use crate::results::{Format, Place};
use crate::watch::{Records, Watch};
use anyhow::{Context, Result, bail};
use clap::ValueEnum;
use indicatif::{ProgressBar, ProgressStyle};
use lemons_master::{Algorithm, Clock, PATIENCE, Pushes, Saved, State, System, wiring_of};
use prepare::Prepared;
use progress::{Kept, Progress};
pub use rest::REST;
use rest::Rest;
use std::path::PathBuf;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::{Duration, Instant};
use underway::{AtHand, Shared, Underway};

#[derive(clap::Args, Clone)]
pub struct Arguments {
    /// A Trial directory, an FMU, or FMUs coupled by an SSP
    #[arg(value_name = "TRIAL, FILE.fmu or FILE.ssp")]
    input: PathBuf,
    /// When to stop, in seconds; default: what the SSP says, else 5
    #[arg(long, value_name = "SECONDS", value_parser = positive)]
    until: Option<f64>,
    /// Communication step, in seconds; default: the Trial's TimeStep, of several FMUs the smallest
    /// stepSize
    #[arg(long, value_name = "SECONDS", value_parser = positive)]
    step: Option<f64>,
    /// How coupled FMUs exchange values: all from the last communication point, or one after the
    /// other in the order of the SSP, each from the newest
    #[arg(long, value_name = "ALGORITHM", default_value = "jacobi")]
    algorithm: Order,
    /// Propulsion over time: CSV with t,agent,Fp.x,Fp.y,Mp, linearly interpolated, zero outside;
    /// agents it does not name keep AgentDynamics.xml's. Default: the Trial's drive.csv, if any; none
    /// in an SSP
    #[arg(long, value_name = "FILE.csv", conflicts_with = "no_drive")]
    drive: Option<PathBuf>,
    /// Ignore the Trial's drive.csv
    #[arg(long)]
    no_drive: bool,
    /// A parameter, as in: --set TimeStepMechanical=1e-5, of all agents: --set 'agent[*].Mass=80'; in
    /// an SSP after the component's name and a dot
    // The help shows it as it is.
    #[allow(rustdoc::broken_intra_doc_links)]
    #[arg(long = "set", value_name = "NAME=VALUE")]
    settings: Vec<String>,
    /// Threads of the crowd's engine: worth it from some thousand agents; results do not depend on it.
    /// In an SSP: --set NAME.Threads=N
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(i32).range(1..))]
    threads: Option<i32>,
    /// Where the trajectories go; of several crowds to FILE_NAME.csv. Default: trajectories.csv
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Where the outputs of FMUs go that are no crowd. Default: outputs.csv
    #[arg(long, value_name = "FILE")]
    outputs: Option<PathBuf>,
    #[arg(long, value_name = "FORMAT", hide_possible_values = true, help = FORMAT_HELP)]
    format: Option<Format>,
    /// Write each N-th communication point, the first one included. Default: 1
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    every: Option<u32>,
    /// Save the run there when it ends, also by Ctrl-C, to go on with --resume
    #[arg(long, value_name = "FILE.run")]
    state: Option<PathBuf>,
    /// Go on from a saved run of the same TRIAL or file, in the results that it has written (-o)
    #[arg(long, value_name = "FILE.run")]
    resume: Option<PathBuf>,
    #[command(flatten)]
    _force: Force,
    /// For pictures: the run ends when all have come to rest.
    #[arg(skip)]
    pub until_still: bool,
}

const FORMAT_HELP: &str = "csv or, for long runs, parquet: some times smaller, units in the file's metadata. \
                           Default: what the extension of -o says, else csv";

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

impl std::fmt::Display for Order {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Order::Jacobi => "Jacobi",
            Order::GaussSeidel => "Gauss-Seidel",
        })
    }
}

fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value > 0.0 && value.is_finite() => Ok(value),
        _ => Err("must be a positive number of seconds".into()),
    }
}

/// What came of a run.
pub struct Ended {
    /// \[s\] simulated now.
    simulated: f64,
    wall: Duration,
    /// \[s\] where Ctrl-C stopped it; not where it ended since all had come to rest.
    pub stopped: Option<f64>,
    /// Lines of the summary: what is coupled, what was seen, what was saved.
    coupling: Vec<String>,
    seen: Vec<String>,
    saved: Option<String>,
}

pub fn run(arguments: &Arguments) -> Result<()> {
    let ended = simulate(arguments, &Interrupt::watch())?;
    let told = ended.tell();
    let Some(time) = ended.stopped else { return told };
    let go_on = match &arguments.state {
        Some(path) if ended.saved.is_some() => format!("go on with --resume {}", path.display()),
        Some(_) => "it is not saved: no state can be taken in the middle of a step".into(),
        None => "it is not saved (--state)".into(),
    };
    Err(Interrupted(format!("stopped at t = {time:?} s; {go_on}")).into())
}

/// How often it is looked whether Ctrl-C was pressed.
const LOOK: Duration = Duration::from_millis(50);
/// After a step that took longer, Ctrl-C may find the next one under way: the state before it is put by.
const LONG: Duration = Duration::from_millis(100);

/// Runs and records; warnings go to standard error.
///
/// FMUs are called by a thread of their own. If Ctrl-C finds a step under way that does not end within [`PATIENCE`],
/// this one completes the files with what was recorded before; the step is given up with the program.
pub fn simulate(arguments: &Arguments, interrupt: &Interrupt) -> Result<Ended> {
    let shared = Shared::default();
    let (done, ended) = channel();
    let thread = std::thread::Builder::new().name("run".into()).spawn({
        let (arguments, interrupt, shared) = (arguments.clone(), interrupt.clone(), shared.clone());
        // Nobody listens any more to a run that was given up.
        move || drop(done.send(step_and_record(&arguments, &interrupt, &shared)))
    });
    let thread = thread.context("cannot start a thread")?;
    let mut pressed: Option<Instant> = None;
    loop {
        match ended.recv_timeout(LOOK) {
            Ok(ended) => return ended,
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => match thread.join() {
                Err(fault) => std::panic::resume_unwind(fault),
                Ok(()) => bail!("the run ended without an answer"),
            },
        }
        if interrupt.pressed()
            && pressed.get_or_insert_with(Instant::now).elapsed() >= PATIENCE
            && let Some(underway) = shared.take()
        {
            return underway.give_up();
        }
    }
}

fn step_and_record(arguments: &Arguments, interrupt: &Interrupt, shared: &Shared) -> Result<Ended> {
    let [trajectories, outputs] = places_of(arguments)?;
    let Prepared { mut system, trials, pushes, driven, mut progress, before, coupled } =
        Prepared::of(arguments)?;
    let first = system.time();
    let about = vec![
        ("lemons_version", env!("CARGO_PKG_VERSION").to_owned()),
        ("communication_step", format!("{:?}", progress.clock.step)),
        ("every", progress.every.to_string()),
    ];
    let recording = Recording { about, before: before.as_ref() };
    let watch = Watch::create(&system, trials, &trajectories, &outputs, recording)?;
    let state = arguments.state.clone();
    let file = state.map(|path| Ok::<_, anyhow::Error>((files::stage(&path)?, path))).transpose()?;
    let coupling = coupled.then(|| {
        let (components, connections) = (system.components().len(), system.connections());
        let algorithm = arguments.algorithm;
        [
            format!("components         {components:>10}     ({connections} connections, {algorithm})"),
            format!("communication step {:>10} s", progress.clock.step),
        ]
    });
    let mut kept = if file.is_some() { Some(Kept::of(&mut system, &progress)?) } else { None };
    let style = ProgressStyle::with_template("{bar:40} {percent:>3}%  {msg}  {eta} left")?;
    shared.put(Underway {
        first,
        time: first,
        started: Instant::now(),
        coupling: coupling.into_iter().flatten().collect(),
        watch,
        file,
        at_hand: None,
        bar: ProgressBar::new(progress.clock.steps.saturating_sub(progress.index)).with_style(style),
        unzipped: system.components().iter().map(|c| c.fmu.directory().to_owned()).collect(),
    });
    let mut stepping = Stepping { arguments, system: &mut system, pushes: &pushes, driven: &driven, shared };
    let mut rest = arguments.until_still.then(|| Rest::after(pushes.end()));
    let done = stepping.advance(&mut progress, interrupt, before.is_none(), &mut kept, &mut rest);
    // What was simulated before a failure is worth having.
    let Underway { started, coupling, watch, file, .. } = shared.take().context("the run was given up")?;
    let wall = started.elapsed();
    let records = watch.records(stepping.system);
    let seen = watch.finish()?;
    let saved = match file {
        Some((file, path)) => {
            let kept = kept.as_ref().context("the run failed between two states");
            let at_hand = kept.and_then(|kept| stepping.at_hand(&progress, kept, records));
            let at_hand = at_hand.with_context(|| path.display().to_string());
            at_hand.and_then(|at_hand| at_hand.write(file, &path)).map(Some)
        }
        None => Ok(None),
    };
    // States are given back while their FMUs are there.
    drop(kept);
    let done = done.and_then(|()| system.terminate());
    for warning in system.warnings() {
        note!("{warning}");
    }
    if let Err(error) = done {
        match saved {
            Ok(Some(line)) => note!("{line}"),
            Ok(None) => {}
            Err(why) => note!("warning: the run is not saved: {why:#}"),
        }
        let stopped = format!("stopped at t = {:?} s; the results until then are written", system.time());
        return Err(error.context(stopped));
    }
    Ok(Ended {
        simulated: system.time() - first,
        wall,
        stopped: (system.time() < progress.clock.until
            && !rest.is_some_and(|rest| rest.is_over(system.time())))
        .then(|| system.time()),
        coupling,
        seen,
        saved: saved?,
    })
}

impl Ended {
    fn tell(&self) -> Result<()> {
        let seconds = self.wall.as_secs_f64();
        self.coupling.iter().try_for_each(|line| say!("{line}"))?;
        if let Some(time) = self.stopped {
            say!("stopped by Ctrl-C  {time:>10.3} s")?;
        }
        say!("simulated time     {:>10.3} s", self.simulated)?;
        say!("wall time          {seconds:>10.3} s")?;
        say!("real-time factor   {:>10.2}", self.simulated / seconds)?;
        Ok(self.seen.iter().chain(&self.saved).try_for_each(|line| say!("{line}"))?)
    }
}

/// Where the trajectories and the outputs go, and as what.
fn places_of(arguments: &Arguments) -> Result<[Place; 2]> {
    let Arguments { output, outputs, format, .. } = arguments;
    let common = format.or(output.as_deref().and_then(Format::of)).unwrap_or(Format::Csv);
    let place = |given: &Option<PathBuf>, name: &str| {
        let Some(path) = given else {
            let path = PathBuf::from(format!("{name}.{}", common.extension()));
            return Ok(Place { path, format: common });
        };
        match (Format::of(path), format) {
            (Some(own), Some(wanted)) if own != *wanted => bail!(Misused(format!(
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
    Ok([place(output, "trajectories")?, place(outputs, "outputs")?])
}

/// A system that is stepped.
struct Stepping<'a> {
    arguments: &'a Arguments,
    system: &'a mut System,
    pushes: &'a Pushes,
    /// Fingerprint of the drive.
    driven: &'a str,
    shared: &'a Shared,
}

impl Stepping<'_> {
    /// To the clock's end, or until Ctrl-C, or until all have come to rest; the last step is shortened to end there.
    fn advance(
        &mut self,
        progress: &mut Progress,
        interrupt: &Interrupt,
        from_start: bool,
        kept: &mut Option<Kept>,
        rest: &mut Option<Rest>,
    ) -> Result<()> {
        let shared = self.shared;
        let bar = shared.with(|underway| {
            if from_start {
                underway.watch.look(self.system, true)?;
            }
            Ok(underway.bar.clone())
        })?;
        self.put_by(progress, kept.as_ref())?;
        let clock = progress.clock;
        for k in progress.index..clock.steps {
            if interrupt.pressed() || rest.as_ref().is_some_and(|rest| rest.is_over(self.system.time())) {
                break;
            }
            self.pushes.send(&self.system.components()[0].instance, self.system.time())?;
            let begun = Instant::now();
            self.system.step_to(clock.end(k))?;
            let long = begun.elapsed() >= LONG;
            // Until rows and state are both of the new point, no run can go on from it.
            let before = kept.take();
            if self.system.time() == clock.point(k + 1) {
                progress.index = k + 1;
            }
            shared.with(|underway| {
                underway.at_hand = None;
                underway.watch.look(self.system, (k + 1) % progress.every == 0)?;
                underway.time = self.system.time();
                if let Some(rest) = rest {
                    rest.see(underway.time, underway.watch.moves());
                }
                Ok(())
            })?;
            if let Some(mut now) = before {
                now.renew(self.system, progress)?;
                *kept = Some(now);
            }
            if long {
                self.put_by(progress, kept.as_ref())?;
            }
            bar.set_message(format!("t = {:.2} s", self.system.time()));
            bar.inc(1);
        }
        bar.finish_and_clear();
        Ok(())
    }

    /// Where a run that is given up in the next step can be gone on with.
    fn put_by(&self, progress: &Progress, kept: Option<&Kept>) -> Result<()> {
        let Some(kept) = kept else { return Ok(()) };
        let records = self.shared.with(|underway| Ok(underway.watch.records(self.system)))?;
        let at_hand = self.at_hand(progress, kept, records)?;
        self.shared.with(|underway| {
            underway.at_hand = Some(at_hand);
            Ok(())
        })
    }

    fn at_hand(&self, progress: &Progress, kept: &Kept, (crowd, outputs): Records) -> Result<AtHand> {
        let states = kept.states.iter().map(State::bytes).collect::<Result<Vec<_>>>()?;
        let Clock { start, step, until, .. } = progress.clock;
        let saved = Saved {
            format: Saved::FORMAT,
            lemons: env!("CARGO_PKG_VERSION").to_owned(),
            start,
            step,
            until,
            index: kept.index,
            time: kept.time,
            every: progress.every,
            algorithm: self.arguments.algorithm.to_string(),
            wiring: wiring_of(self.system),
            drive: self.driven.to_owned(),
            component: Saved::components(self.system, &states),
            crowd,
            outputs,
        };
        Ok(AtHand { saved, states })
    }
}
