//! From the arguments to a system at its first communication point.

use super::Arguments;
use super::progress::Progress;
use crate::crowd::trial_of;
use crate::error::Misused;
use crate::given::Given;
use crate::pack::write_fmu;
use anyhow::{Context, Result, bail};
use crowd_mechanics::files::Scratch;
use crowd_mechanics::model_description::DEFAULT_STOP_TIME;
use crowd_mechanics::pack::Naming;
use crowd_mechanics::trial::Trial;
use lemons_master::{Assembled, Clock, Drive, Fmu, Kind, Pushes, Saved, System, assemble, own_binary};

/// What is ready to run.
pub struct Prepared {
    pub system: System,
    /// That the components run, where they hold any.
    pub trials: Vec<Option<Trial>>,
    pub pushes: Pushes,
    /// Fingerprint of the drive.
    pub driven: String,
    pub progress: Progress,
    /// What this run goes on from.
    pub before: Option<Saved>,
    pub coupled: bool,
}

impl Prepared {
    pub fn of(arguments: &Arguments) -> Result<Prepared> {
        check_resumed(arguments)?;
        let runs = [Kind::Trial, Kind::Fmu, Kind::Ssp, Kind::Archive, Kind::Stream];
        Kind::expect(&arguments.input, &runs, "a Trial directory, an FMU or an SSP")?;
        if let Some(path) = &arguments.resume {
            Kind::expect(path, &[Kind::SavedRun], "a saved run (--state writes one)")?;
        }
        let saved = arguments.resume.as_deref().map(Saved::read).transpose()?;
        let coupled = arguments.input.extension().is_some_and(|end| end.eq_ignore_ascii_case("ssp"));
        let (mut system, start, stop) = if coupled { open_ssp(arguments)? } else { open_fmu(arguments)? };
        set_all(&system, arguments, coupled)?;
        if arguments.state.is_some() || saved.is_some() {
            check_saves(&system)?;
        }
        let start = saved.as_ref().map_or(start, |(saved, _)| saved.start);
        if let (Some((saved, _)), Some(path)) = (&saved, &arguments.resume) {
            let of_path = || format!("saved run {}", path.display());
            saved.check_system(&system, &arguments.algorithm.to_string()).with_context(of_path)?;
        }
        let before = saved.as_ref().map(|(saved, _)| saved);
        let until = arguments.until.or(before.map(|saved| saved.until)).or(stop).unwrap_or(DEFAULT_STOP_TIME);
        let first = before.map_or(start, |saved| saved.time);
        if until <= first {
            let at = if before.is_some() { "the saved run is at" } else { "it starts at" };
            bail!("nothing to simulate: {at} {first:?} s and stops at {until:?} s (--until)");
        }
        system.initialize(start)?;
        if let (Some((saved, states)), Some(path)) = (&saved, &arguments.resume) {
            system.restore(saved.time, states).with_context(|| format!("saved run {}", path.display()))?;
        }
        let trials = system.components().iter().map(trial_of).collect::<Result<Vec<_>>>()?;
        let drive = if coupled || arguments.no_drive {
            Drive::default()
        } else {
            Drive::of(trials[0].as_ref(), arguments.drive.as_deref())?
        };
        let driven = drive.fingerprint();
        let agents = trials[0].as_ref().map_or(&[][..], |trial| &trial.agents);
        let pushes = Pushes::new(&system.components()[0].instance, agents, drive)?;
        let step = match before {
            Some(saved) => saved.step,
            None => step_of(arguments, &system, &trials)?,
        };
        let every = arguments.every.map_or(before.map_or(1, |saved| saved.every), u64::from);
        if let Some(saved) = before {
            check_same(arguments, saved, &driven, every)?;
        }
        let clock = Clock::new(start, step, until).with_context(|| arguments.input.display().to_string())?;
        let progress = Progress { clock, every, index: before.map_or(0, |saved| saved.index) };
        let before = saved.map(|(saved, _)| saved);
        Ok(Prepared { system, trials, pushes, driven, progress, before, coupled })
    }
}

/// `--set` and `--threads`
fn set_all(system: &System, arguments: &Arguments, coupled: bool) -> Result<()> {
    for setting in &arguments.settings {
        set(system, setting, coupled)?;
    }
    match arguments.threads {
        Some(threads) if coupled => {
            bail!("--threads is for a Trial or an FMU: in an SSP, --set NAME.Threads={threads}")
        }
        Some(threads) => set(system, &format!("Threads={threads}"), coupled),
        None => Ok(()),
    }
}

/// The system, where it starts \[s\] and where it stops \[s\] if it says that.
type Opened = (System, f64, Option<f64>);

/// A Trial is packed first: it runs as everybody's FMU of it would.
fn open_fmu(arguments: &Arguments) -> Result<Opened> {
    let packed = Scratch::new().context("cannot make a temporary directory")?;
    let fmu = if let Some(trial) = Given::find(&arguments.input)? {
        let path = packed.path().join("crowd.fmu");
        write_fmu(&[trial], vec![own_binary()?], Naming::Structured, &path)?;
        Fmu::open(&path)?.of_trial(&arguments.input)
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
        note!("warning: {parameter}");
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
    let names = component.fmu.named(name);
    for name in &names {
        let unknown = || format!("the FMU has no variable {name:?}; see lemons info");
        let kind = component.fmu.kind(name).with_context(unknown)?;
        component.instance.set(kind, name, value)?;
    }
    if let Some(name) = names.iter().find(|name| system.feeds(place, name)) {
        note!("warning: --set {setting}: overwritten by the connection that feeds {name}");
    }
    Ok(())
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
