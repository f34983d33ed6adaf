//! `lemons run`: an FMU, or FMUs coupled by an SSP, stepped like any FMI master would.

use crate::crowd::trial_of;
use crate::drive::Drive;
use crate::pack::write_fmu;
use crate::results::Tables;
use crate::watch::Watch;
use anyhow::{Context, Result, bail};
use clap::ValueEnum;
use crowd_mechanics::model_description::DEFAULT_STOP_TIME;
use crowd_mechanics::pack::{DRIVE_FILE, Naming};
use crowd_mechanics::trial::Trial;
use indicatif::{ProgressBar, ProgressStyle};
use lemons_master::{Algorithm, Assembled, Fmu, System, assemble, own_binary};
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
    /// A parameter, as in: --set contact.human_naked.human_naked.KineticFriction=0.6; in an SSP after
    /// the component's name and a dot
    #[arg(long = "set", value_name = "NAME=VALUE")]
    settings: Vec<String>,
    /// Threads of the crowd's engine: worth it from some thousand agents; results do not depend on it.
    /// In an SSP: --set NAME.Threads=N
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(i32).range(1..))]
    threads: Option<i32>,
    /// Where the trajectories go; of several crowds to FILE_NAME.csv
    #[arg(short, long, default_value = "trajectories.csv", value_name = "FILE.csv")]
    output: PathBuf,
    /// Where the outputs of FMUs go that are no crowd
    #[arg(long, default_value = "outputs.csv", value_name = "FILE.csv")]
    outputs: PathBuf,
}

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
    let until = arguments.until.or(stop).unwrap_or(DEFAULT_STOP_TIME);
    if until <= start {
        bail!("nothing to simulate: it starts at {start:?} s and stops at {until:?} s (--until)");
    }
    system.initialize(start)?;
    let trials = system.components().iter().map(trial_of).collect::<Result<Vec<_>>>()?;
    let drive = if coupled { Drive::default() } else { drive_of(arguments, trials[0].as_ref())? };
    let pushes = Pushes::new(&system, trials[0].as_ref(), drive)?;
    let step = step_of(arguments, &system, &trials)?;

    let inputs = std::iter::once(&arguments.input).chain(&arguments.drive).map(PathBuf::as_path);
    let tables = Tables::beside(inputs);
    let mut watch = Watch::create(&system, trials, &arguments.output, &arguments.outputs, tables)?;
    let started = Instant::now();
    let done = advance(&mut system, start, until, step, &pushes, &mut watch);
    let wall = started.elapsed();
    // What was simulated before a failure is worth having.
    let seen = watch.finish()?;
    let done = done.and_then(|()| system.terminate());
    for warning in system.warnings() {
        eprintln!("{warning}");
    }
    done.with_context(|| {
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
    summary(system.time() - start, wall, &seen);
    Ok(())
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

/// Steps to `until`; the last step is shortened to end there.
fn advance(
    system: &mut System,
    start: f64,
    until: f64,
    step: f64,
    pushes: &Pushes,
    watch: &mut Watch,
) -> Result<()> {
    let steps = ((until - start) / step - 1e-9).ceil().max(1.0) as u64;
    let style = ProgressStyle::with_template("{bar:40} {percent:>3}%  {msg}  {eta} left")?;
    let progress = ProgressBar::new(steps).with_style(style);
    watch.look(system)?;
    for k in 0..steps {
        let end = if k + 1 == steps { until } else { start + (k + 1) as f64 * step };
        pushes.send(system)?;
        system.step_to(end)?;
        watch.look(system)?;
        progress.set_message(format!("t = {end:.2} s"));
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
