//! `lemons run`: an FMU, or FMUs coupled by an SSP, stepped like any FMI master would.

use crate::Misused;
use crate::crowd::trial_of;
use crate::drive::Drive;
use crate::interrupt::{Interrupt, Interrupted};
use crate::pack::write_fmu;
use crate::results::{Format, Place, Tables};
use crate::saved::{Saved, wiring_of};
use crate::watch::{Recording, Watch};
use anyhow::{Context, Result, bail};
use clap::ValueEnum;
use crowd_mechanics::model_description::DEFAULT_STOP_TIME;
use crowd_mechanics::pack::{DRIVE_FILE, Naming};
use crowd_mechanics::trial::Trial;
use indicatif::{ProgressBar, ProgressStyle};
use lemons_master::{Algorithm, Assembled, Fmu, State, System, assemble, own_binary};
use std::path::PathBuf;
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
    /// A parameter, as in: --set agent[0].Mass=80; in an SSP after the component's name and a dot
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

const FORMAT_HELP: &str = "csv or, for long runs, parquet: some times smaller, units in the columns' metadata. \
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

pub fn run(arguments: &Arguments) -> Result<()> {
    let interrupt = Interrupt::watch()?;
    let [trajectories, outputs] = places_of(arguments)?;
    check_resumed(arguments)?;
    let saved = arguments.resume.as_deref().map(Saved::read).transpose()?;
    let coupled = arguments.input.extension().is_some_and(|end| end.eq_ignore_ascii_case("ssp"));
    let (mut system, start, stop) = if coupled { open_ssp(arguments)? } else { open_fmu(arguments)? };
    for setting in &arguments.settings {
        set(&system, setting, coupled)?;
    }
    if let Some(threads) = arguments.threads {
        if coupled {
            bail!("--threads is for a Trial or an FMU: in an SSP, --set NAME.Threads={threads}");
        }
        set(&system, &format!("Threads={threads}"), coupled)?;
    }
    if arguments.state.is_some() || saved.is_some() {
        check_saves(&system)?;
    }
    let algorithm = arguments.algorithm.to_string();
    let start = saved.as_ref().map_or(start, |(saved, _)| saved.start);
    if let Some((saved, states)) = &saved {
        let path = arguments.resume.as_deref().unwrap_or(&arguments.input).display();
        saved.check_system(&system, &algorithm).with_context(|| format!("saved run {path}"))?;
        system.initialize(start)?;
        system.restore(saved.time, states).with_context(|| format!("saved run {path}"))?;
    }
    let before = saved.as_ref().map(|(saved, _)| saved);
    let until = arguments.until.or(before.map(|saved| saved.until)).or(stop).unwrap_or(DEFAULT_STOP_TIME);
    let first = before.map_or(start, |saved| saved.time);
    if until <= first {
        let at = if before.is_some() { "the saved run is at" } else { "it starts at" };
        bail!("nothing to simulate: {at} {first:?} s and stops at {until:?} s (--until)");
    }
    if before.is_none() {
        system.initialize(start)?;
    }
    let trials = system.components().iter().map(trial_of).collect::<Result<Vec<_>>>()?;
    let drive = if coupled { Drive::default() } else { drive_of(arguments, trials[0].as_ref())? };
    let driven = drive.fingerprint();
    let pushes = Pushes::new(&system, trials[0].as_ref(), drive)?;
    let step = match before {
        Some(saved) => saved.step,
        None => step_of(arguments, &system, &trials)?,
    };
    let every = arguments.every.map_or(before.map_or(1, |saved| saved.every), u64::from);
    if let Some(saved) = before {
        check_same(arguments, saved, &driven, every)?;
    }
    let mut clock = Clock::new(start, step, until, every);
    clock.index = before.map_or(0, |saved| saved.index);

    let inputs = std::iter::once(&arguments.input).chain(&arguments.drive).map(PathBuf::as_path);
    let mut tables = Tables::beside(inputs);
    let about = vec![
        ("lemons_version", env!("CARGO_PKG_VERSION").to_owned()),
        ("communication_step", format!("{step:?}")),
        ("every", every.to_string()),
    ];
    let recording = Recording { tables: &mut tables, about, before };
    let mut watch = Watch::create(&system, trials, &trajectories, &outputs, recording)?;
    let staged = match &arguments.state {
        Some(path) => Some((path, tables.stage(path)?)),
        None => None,
    };
    let started = Instant::now();
    let mut kept = if staged.is_some() { Some(Kept::of(&mut system, &clock)?) } else { None };
    let done = advance(&mut system, &mut clock, &pushes, &mut watch, &interrupt, before.is_none(), &mut kept);
    let wall = started.elapsed();
    // What was simulated before a failure is worth having.
    let (crowd, records) = watch.records(&system);
    let seen = watch.finish()?;
    let state = staged.map(|(path, file)| {
        let Some(kept) = &kept else { bail!("{}: the run failed between two states", path.display()) };
        let states = kept.states.iter().map(State::bytes).collect::<Result<Vec<_>>>()?;
        let saved = Saved {
            format: Saved::FORMAT,
            lemons: env!("CARGO_PKG_VERSION").to_owned(),
            start,
            step,
            until,
            index: kept.index,
            time: kept.time,
            every,
            algorithm,
            wiring: wiring_of(&system),
            drive: driven,
            component: Saved::components(&system, &states),
            crowd,
            outputs: records,
        };
        saved.write(&states, file).with_context(|| format!("cannot write {}", path.display()))?;
        Ok(format!("saved run          {}   (at t = {:.3} s)", path.display(), kept.time))
    });
    // States are given back while their FMUs are there.
    drop(kept);
    let done = match done {
        Ok(()) => system.terminate().and_then(|()| state.transpose()),
        Err(error) => {
            match state {
                Some(Ok(line)) => eprintln!("{line}"),
                Some(Err(why)) => eprintln!("warning: the run is not saved: {why:#}"),
                None => {}
            }
            Err(error)
        }
    };
    for warning in system.warnings() {
        eprintln!("{warning}");
    }
    let state = done.with_context(|| {
        format!("stopped at t = {:?} s; the results until then are written", system.time())
    })?;
    if coupled {
        let (components, connections) = (system.components().len(), system.connections());
        println!(
            "components         {components:>10}     ({connections} connections, {})",
            arguments.algorithm
        );
        println!("communication step {step:>10} s");
    }
    if system.time() < clock.until {
        println!("stopped by Ctrl-C  {:>10.3} s", system.time());
    }
    summary(system.time() - first, wall, &seen);
    if let Some(line) = &state {
        println!("{line}");
    }
    if system.time() < clock.until {
        let go_on = match &arguments.state {
            Some(path) => format!("go on with --resume {}", path.display()),
            None => "it is not saved (--state)".into(),
        };
        return Err(Interrupted(format!("stopped at t = {:?} s; {go_on}", system.time())).into());
    }
    Ok(())
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
            (own, _) => Ok(Place { path: path.clone(), format: own.unwrap_or(common) }),
        }
    };
    Ok([place(output, "trajectories")?, place(outputs, "outputs")?])
}

/// Whether the options go together with `--resume`.
fn check_resumed(arguments: &Arguments) -> Result<()> {
    if arguments.resume.is_none() {
        return Ok(());
    }
    let option = match (arguments.settings.first(), arguments.threads) {
        (Some(setting), _) => format!("--set {setting}"),
        (_, Some(threads)) => format!("--threads {threads}"),
        _ => return Ok(()),
    };
    bail!(Misused(format!("{option} with --resume: parameters are in the saved run, they stay as they are")))
}

/// Whether all components can be saved and restored.
fn check_saves(system: &System) -> Result<()> {
    for component in system.components() {
        if let Some(flag) = component.fmu.cannot_save() {
            let name = &component.name;
            bail!("the run cannot be saved: component {name:?} says {flag}=\"false\" (--state, --resume)");
        }
    }
    Ok(())
}

/// Whether the run goes on as the saved one went.
fn check_same(arguments: &Arguments, saved: &Saved, driven: &str, every: u64) -> Result<()> {
    if let Some(step) = arguments.step.filter(|step| *step != saved.step) {
        bail!("--step {step:?}: the saved run has a communication step of {:?} s", saved.step);
    }
    if every != saved.every {
        bail!("--every {every}: the saved run has --every {}", saved.every);
    }
    if driven != saved.drive {
        bail!("the saved run was driven otherwise: give it the same drive file, or --no-drive as then");
    }
    Ok(())
}

/// The communication points of a run: `start + k * step`, never added up, and `until`.
struct Clock {
    start: f64,
    step: f64,
    until: f64,
    every: u64,
    /// How many steps until the end.
    steps: u64,
    /// The last k.
    index: u64,
}

impl Clock {
    fn new(start: f64, step: f64, until: f64, every: u64) -> Clock {
        let steps = ((until - start) / step - 1e-9).ceil().max(1.0) as u64;
        let mut clock = Clock { start, step, until, every, steps, index: 0 };
        // As every longer run has it: multiples are rounded.
        if (clock.point(steps) - until).abs() <= 1e-9 * step {
            clock.until = clock.point(steps);
        }
        clock
    }

    fn point(&self, k: u64) -> f64 {
        self.start + k as f64 * self.step
    }

    /// Where the step after the k-th ends.
    fn end(&self, k: u64) -> f64 {
        if k + 1 >= self.steps { self.until } else { self.point(k + 1) }
    }
}

/// The newest communication point from which a run can go on.
struct Kept {
    states: Vec<State>,
    index: u64,
    time: f64,
}

impl Kept {
    fn of(system: &mut System, clock: &Clock) -> Result<Kept> {
        Ok(Kept { states: system.states()?, index: clock.index, time: system.time() })
    }

    fn renew(&mut self, system: &System, clock: &Clock) -> Result<()> {
        (self.index, self.time) = (clock.index, system.time());
        self.states.iter_mut().try_for_each(State::renew)
    }
}

/// The system, where it starts \[s\] and where it stops \[s\] if it says that.
type Opened = (System, f64, Option<f64>);

/// A Trial is packed first: it runs as everybody's FMU of it would.
fn open_fmu(arguments: &Arguments) -> Result<Opened> {
    let packed = tempfile::TempDir::with_prefix("lemons-").context("cannot make a temporary directory")?;
    let fmu = if arguments.input.is_dir() {
        let path = packed.path().join("crowd.fmu");
        write_fmu(std::slice::from_ref(&arguments.input), vec![own_binary()?], Naming::Structured, &path)?;
        Fmu::open(&path)?
    } else {
        Fmu::open(&arguments.input)?
    };
    Ok((System::of_one("crowd", fmu)?, 0.0, None))
}

fn open_ssp(arguments: &Arguments) -> Result<Opened> {
    if arguments.drive.is_some() {
        bail!("--drive is for a Trial or an FMU: in an SSP inputs are fed by connections");
    }
    let Assembled { system, start, stop, ignored } = assemble(&arguments.input, arguments.algorithm.into())?;
    for parameter in ignored {
        eprintln!("warning: {parameter}");
    }
    Ok((system, start.unwrap_or(0.0), stop))
}

/// `--set`
fn set(system: &System, setting: &str, coupled: bool) -> Result<()> {
    let (name, value) =
        setting.split_once('=').with_context(|| format!("--set {setting}: expected NAME=VALUE"))?;
    let (place, name) = if coupled {
        let names: Vec<&str> = system.components().iter().map(|c| c.name.as_str()).collect();
        system.find(name).with_context(|| {
            format!("--set {setting}: expected COMPONENT.NAME=VALUE; components are {}", names.join(", "))
        })?
    } else {
        (0, name)
    };
    let component = &system.components()[place];
    let unknown = || format!("the FMU has no variable {name:?}; see lemons info");
    let kind = component.fmu.kind(name).with_context(unknown)?;
    component.instance.set(kind, name, value)?;
    if system.feeds(place, name) {
        eprintln!("warning: --set {setting}: overwritten by the connection that feeds {name}");
    }
    Ok(())
}

fn drive_of(arguments: &Arguments, trial: Option<&Trial>) -> Result<Drive> {
    let own = trial.map(|trial| trial.directory.join(DRIVE_FILE)).filter(|own| own.is_file());
    let path = match (&arguments.drive, &own) {
        (Some(path), _) => path,
        (None, Some(own)) if !arguments.no_drive => own,
        _ => return Ok(Drive::default()),
    };
    let drive = Drive::read(path)?;
    let known = |id: &str| trial.is_some_and(|trial| trial.agents.iter().any(|agent| agent.id == id));
    if let Some(unknown) = drive.agents().find(|id| !known(id)) {
        bail!("drive file {}: there is no agent {unknown:?} in Agents.xml", path.display());
    }
    Ok(drive)
}

/// \[s\] `--step`, else the smallest that a component asks for.
fn step_of(arguments: &Arguments, system: &System, trials: &[Option<Trial>]) -> Result<f64> {
    if let Some(step) = arguments.step {
        return Ok(step);
    }
    let steps = system.components().iter().zip(trials).filter_map(|(component, trial)| match trial {
        Some(trial) => Some(trial.parameters.time_step),
        None => {
            let experiment = component.fmu.description.defaultExperiment.as_ref()?;
            experiment.stepSize.as_ref()?.trim().parse().ok()
        }
    });
    let smallest = steps.filter(|step: &f64| *step > 0.0 && step.is_finite()).reduce(f64::min);
    smallest.context("no FMU has a DefaultExperiment with a stepSize: give --step")
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
    let progress = ProgressBar::new(clock.steps - clock.index).with_style(style);
    if from_start {
        watch.look(system, true)?;
    }
    for k in clock.index..clock.steps {
        if interrupt.pressed() {
            break;
        }
        pushes.send(system)?;
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

/// The drive, into the first component.
struct Pushes {
    drive: Drive,
    /// Of the agents that the drive names.
    ids: Vec<String>,
    inputs: Vec<u32>,
}

impl Pushes {
    fn new(system: &System, trial: Option<&Trial>, drive: Drive) -> Result<Pushes> {
        let instance = &system.components()[0].instance;
        let agents = trial.iter().flat_map(|trial| trial.agents.iter().enumerate());
        let driven: Vec<_> = agents.filter(|(_, agent)| drive.at(&agent.id, 0.0).is_some()).collect();
        let names = driven
            .iter()
            .flat_map(|(i, _)| ["Fp.x", "Fp.y", "Mp"].map(move |name| format!("agent[{i}].{name}")));
        Ok(Pushes {
            inputs: names.map(|name| instance.reference(&name)).collect::<Result<_>>()?,
            ids: driven.iter().map(|(_, agent)| agent.id.clone()).collect(),
            drive,
        })
    }

    fn send(&self, system: &System) -> Result<()> {
        if self.inputs.is_empty() {
            return Ok(());
        }
        let pushes = self.ids.iter().filter_map(|id| self.drive.at(id, system.time()));
        let values: Vec<f64> = pushes.flatten().collect();
        system.components()[0].instance.set_real(&self.inputs, &values)
    }
}

fn summary(simulated: f64, wall: Duration, seen: &[String]) {
    let seconds = wall.as_secs_f64();
    println!("simulated time     {simulated:>10.3} s");
    println!("wall time          {seconds:>10.3} s");
    println!("real-time factor   {:>10.2}", simulated / seconds);
    for line in seen {
        println!("{line}");
    }
}
