//! `lemons run`: an FMU, or FMUs coupled by an SSP, stepped like any FMI master would.

mod clock;
mod prepare;

use crate::error::Misused;
use crate::interrupt::{Interrupt, Interrupted};
use crate::recording::Recording;
use crate::results::{Extent, Format, Place, Tables};
use crate::saved::{CrowdRecord, Saved, wiring_of};
use crate::watch::Watch;
use anyhow::{Context, Result, bail};
use clap::ValueEnum;
use clock::{Clock, Kept};
use crowd_mechanics::files::Staged;
use indicatif::{ProgressBar, ProgressStyle};
use lemons_master::{Algorithm, Pushes, State, System};
use prepare::Prepared;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

#[derive(clap::Args)]
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
    /// A parameter, as in: --set TimeStepMechanical=1e-5; in an SSP after the component's name and a dot
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
    /// \[s\] where Ctrl-C stopped it.
    pub stopped: Option<f64>,
    /// Lines of the summary: what is coupled, what was seen, what was saved.
    coupling: Vec<String>,
    seen: Vec<String>,
    saved: Option<String>,
}

pub fn run(arguments: &Arguments) -> Result<()> {
    let ended = simulate(arguments, &Interrupt::watch()?)?;
    ended.tell();
    let Some(time) = ended.stopped else { return Ok(()) };
    let go_on = match &arguments.state {
        Some(path) => format!("go on with --resume {}", path.display()),
        None => "it is not saved (--state)".into(),
    };
    Err(Interrupted(format!("stopped at t = {time:?} s; {go_on}")).into())
}

/// Runs and records; warnings go to standard error.
pub fn simulate(arguments: &Arguments, interrupt: &Interrupt) -> Result<Ended> {
    let [trajectories, outputs] = places_of(arguments)?;
    let Prepared { mut system, trials, pushes, driven, mut clock, before, coupled } =
        Prepared::of(arguments)?;
    let first = system.time();
    // A run may be saved over the one that it goes on from.
    let resumed = arguments.resume.as_ref().filter(|resumed| arguments.state.as_ref() != Some(*resumed));
    let given = [Some(&arguments.input), arguments.drive.as_ref(), resumed];
    let mut inputs: Vec<PathBuf> = given.into_iter().flatten().cloned().collect();
    inputs.extend(trials.iter().flatten().flat_map(|_| files_of(&arguments.input)));
    let mut tables = Tables::beside(inputs.iter().map(PathBuf::as_path));
    let about = vec![
        ("lemons_version", env!("CARGO_PKG_VERSION").to_owned()),
        ("communication_step", format!("{:?}", clock.step)),
        ("every", clock.every.to_string()),
    ];
    let recording = Recording { tables: &mut tables, about, before: before.as_ref() };
    let mut watch = Watch::create(&system, trials, &trajectories, &outputs, recording)?;
    let staged = arguments.state.as_deref().map(|path| tables.stage(path)).transpose()?;
    let started = Instant::now();
    let mut kept = if staged.is_some() { Some(Kept::of(&mut system, &clock)?) } else { None };
    let done = advance(&mut system, &mut clock, &pushes, &mut watch, interrupt, before.is_none(), &mut kept);
    let wall = started.elapsed();
    // What was simulated before a failure is worth having.
    let records = watch.records(&system);
    let seen = watch.finish()?;
    let saved = match staged {
        Some(file) => save(arguments, &system, &clock, kept.as_ref(), (driven, records), file).map(Some),
        None => Ok(None),
    };
    // States are given back while their FMUs are there.
    drop(kept);
    let done = done.and_then(|()| system.terminate());
    for warning in system.warnings() {
        eprintln!("{warning}");
    }
    if let Err(error) = done {
        match saved {
            Ok(Some(line)) => eprintln!("{line}"),
            Ok(None) => {}
            Err(why) => eprintln!("warning: the run is not saved: {why:#}"),
        }
        let stopped = format!("stopped at t = {:?} s; the results until then are written", system.time());
        return Err(error.context(stopped));
    }
    let coupling = coupled.then(|| {
        let (components, connections) = (system.components().len(), system.connections());
        let algorithm = arguments.algorithm;
        [
            format!("components         {components:>10}     ({connections} connections, {algorithm})"),
            format!("communication step {:>10} s", clock.step),
        ]
    });
    Ok(Ended {
        simulated: system.time() - first,
        wall,
        stopped: (system.time() < clock.until).then(|| system.time()),
        coupling: coupling.into_iter().flatten().collect(),
        seen,
        saved: saved?,
    })
}

/// The files of a Trial directory and of the directories in it; none of a file.
fn files_of(directory: &Path) -> Vec<PathBuf> {
    let entries = |directory: &Path| -> Vec<PathBuf> {
        let read = std::fs::read_dir(directory).into_iter().flatten();
        read.filter_map(|entry| Some(entry.ok()?.path())).collect()
    };
    let own = entries(directory);
    let inner = own.iter().flat_map(|path| entries(path)).collect::<Vec<_>>();
    own.into_iter().chain(inner).filter(|path| path.is_file()).collect()
}

impl Ended {
    fn tell(&self) {
        let seconds = self.wall.as_secs_f64();
        self.coupling.iter().for_each(|line| println!("{line}"));
        if let Some(time) = self.stopped {
            println!("stopped by Ctrl-C  {time:>10.3} s");
        }
        println!("simulated time     {:>10.3} s", self.simulated);
        println!("wall time          {seconds:>10.3} s");
        println!("real-time factor   {:>10.2}", self.simulated / seconds);
        self.seen.iter().chain(&self.saved).for_each(|line| println!("{line}"));
    }
}

/// Writes the saved run; answers a line of the summary.
fn save(
    arguments: &Arguments,
    system: &System,
    clock: &Clock,
    kept: Option<&Kept>,
    (drive, (crowd, outputs)): (String, Records),
    file: Staged,
) -> Result<String> {
    let path = arguments.state.as_deref().unwrap_or(&arguments.input).display();
    let Some(kept) = kept else { bail!("{path}: the run failed between two states") };
    let states = kept.states.iter().map(State::bytes).collect::<Result<Vec<_>>>()?;
    let saved = Saved {
        format: Saved::FORMAT,
        lemons: env!("CARGO_PKG_VERSION").to_owned(),
        start: clock.start,
        step: clock.step,
        until: clock.until,
        index: kept.index,
        time: kept.time,
        every: clock.every,
        algorithm: arguments.algorithm.to_string(),
        wiring: wiring_of(system),
        drive,
        component: Saved::components(system, &states),
        crowd,
        outputs,
    };
    saved.write(&states, file).with_context(|| format!("cannot write {path}"))?;
    Ok(format!("saved run          {path}   (at t = {:.3} s)", kept.time))
}

/// What has been written of crowds and of the others.
type Records = (Vec<CrowdRecord>, Option<Extent>);

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
            (own, _) => Ok(Place { path: path.clone(), format: own.unwrap_or(common) }),
        }
    };
    Ok([place(output, "trajectories")?, place(outputs, "outputs")?])
}

/// Steps to the clock's end, or until Ctrl-C; the last step is shortened to end there.
fn advance(
    system: &mut System,
    clock: &mut Clock,
    pushes: &Pushes,
    watch: &mut Watch,
    interrupt: &Interrupt,
    from_start: bool,
    kept: &mut Option<Kept>,
) -> Result<()> {
    let style = ProgressStyle::with_template("{bar:40} {percent:>3}%  {msg}  {eta} left")?;
    let progress = ProgressBar::new(clock.steps.saturating_sub(clock.index)).with_style(style);
    if from_start {
        watch.look(system, true)?;
    }
    for k in clock.index..clock.steps {
        if interrupt.pressed() {
            break;
        }
        pushes.send(&system.components()[0].instance, system.time())?;
        system.step_to(clock.end(k))?;
        // Until rows and state are both of the new point, no run can go on from it.
        let before = kept.take();
        if system.time() == clock.point(k + 1) {
            clock.index = k + 1;
        }
        watch.look(system, (k + 1) % clock.every == 0)?;
        if let Some(mut now) = before {
            now.renew(system, clock)?;
            *kept = Some(now);
        }
        progress.set_message(format!("t = {:.2} s", system.time()));
        progress.inc(1);
    }
    progress.finish_and_clear();
    Ok(())
}
