//! From settings to a run of an FMU or an SSP: it is loaded and becomes a system, the system is initialized, its drive and
//! its communication points are known; then it is stepped.

use crate::assemble::{Assembled, assemble};
use crate::calls::FmuInstance;
use crate::error::{ErrorPlace, MasterError, Result, require};
use crate::file_type::FileType;
use crate::fmu::{Fmu, agents_of_drive};
use crate::instance::ValueSelection;
use crate::notes;
use crate::saved::SavedRun;
use crate::settings::RunSettings;
use crate::system::{PLAY_DRIVE, System, SystemComponent, component_of};
use crate::trial_input::DecisionChoice;
use lemons_core::trial::{Agent, DriveChoice, DriveTable, Trial};
use lemons_decision::DECISION_FILE;
use lemons_sim::Clock;
use std::sync::Arc;

/// Name of the component of a run of one FMU.
const CROWD: &str = "crowd";

/// A run that is ready: initialized, and at its first communication point, or at that of the saved run.
///
/// ```no_run
/// use lemons_master::{MasterError, PreparedSystem, RunSettings};
///
/// let parameters = vec![("agent[*].Mass".to_owned(), "80".to_owned())];
/// let settings = RunSettings { parameters, until: Some(2.0), ..RunSettings::of("push.fmu") };
/// let mut run = PreparedSystem::of(&settings)?;
/// for warning in &run.warnings {
///     println!("{warning}");
/// }
/// for time in run.clock.points(0) {
///     run.step_to(time)?;
///     let crowd = &run.system.components[0].instance;
///     println!("{time} s: {} m", crowd.value::<f64>("agent[0].Position.x")?);
/// }
/// # Ok::<(), MasterError>(())
/// ```
pub struct PreparedSystem {
    /// One FMU as the component `crowd`; or those of the SSP.
    pub system: System,
    /// The Trials of the components, for those whose FMU contains Trials.
    pub trials: Vec<Option<Trial>>,
    /// The drive of the crowd.
    pub feed: DriveFeed,
    /// The communication points.
    pub clock: Clock,
    /// One communication point in so many is recorded, beginning with the first.
    pub every: u64,
    /// The run that this one goes on from.
    pub before: Option<SavedRun>,
    /// True if FMUs are coupled: those of an SSP.
    pub coupled: bool,
    /// Warnings: settings that are probably not meant.
    pub warnings: Vec<String>,
}

impl PreparedSystem {
    /// Steps to a communication point \[s\].
    ///
    /// # Errors
    /// A component refuses the step, or fails.
    pub fn step_to(&mut self, time: f64) -> Result<()> {
        // A system of several components has no drive.
        self.feed.apply(&self.system.components[0].instance, self.system.time)?;
        self.system.step_to(time)
    }

    /// Prepares a run.
    ///
    /// # Errors
    /// A setting is outside of its domain ([`RunSettings`]), the settings do not fit together or to the input, or the
    /// input, the drive or the saved run is wrong.
    pub fn of(settings: &RunSettings) -> Result<PreparedSystem> {
        let (before, states) = settings.saved()?.unzip();
        let coupled = settings.input.extension().is_some_and(|end| end.eq_ignore_ascii_case("ssp"));
        let parameters = match &before {
            Some(before) => before.chosen(coupled),
            None => settings.parameters.clone(),
        };
        let inputs = [FileType::FMU, FileType::SSP, FileType::ARCHIVE];
        FileType::expect(&settings.input, &inputs, "an FMU or an SSP")?;
        require(!matches!(settings.decision, DecisionChoice::File(_)), || {
            let why = "is for a Trial, and not for an FMU or an SSP";
            MasterError::Misused(format!("--decision: a file like {DECISION_FILE} {why}"))
        })?;
        let open = if coupled { open_ssp } else { open_fmu };
        let Assembled { mut system, start, stop, mut warnings } = open(settings, &parameters)?;
        if settings.tolerance.is_some() {
            system.free_mechanical_steps()?;
        }
        for (name, value) in &parameters {
            warnings.extend(set(&system, name, value, coupled)?);
        }
        if let Some(threads) = settings.threads {
            set(&system, "Threads", &threads.to_string(), coupled)?;
        }
        let own = settings.drive == DriveChoice::Own;
        if !own {
            system.stop_drives()?;
        }
        if settings.saves || before.is_some() {
            check_saves(&system)?;
        }
        let of_saved =
            || settings.resume.iter().map(|path| format!("saved run {}", path.display())).collect();
        if let Some(before) = &before {
            before.check(&system.records(), system.algorithm, &system.fingerprint).place(of_saved)?;
        }
        let start = before.as_ref().map_or(start.unwrap_or(0.0), |before| before.start);
        system.initialize(start, settings.tolerance)?;
        if let (Some(before), Some(states)) = (&before, &states) {
            system.restore(before.time, states).place(of_saved)?;
        }
        warnings.extend(system.differing()?);
        let trials = system.components.iter().map(SystemComponent::trial).collect::<Result<Vec<_>>>()?;

        // The crowd; nothing drives the components of an SSP.
        let main = trials.len() - 1;
        let (crowd, trial) = (&system.components[main], trials[main].as_ref());
        let plays = !coupled && own && crowd.fmu.kind(PLAY_DRIVE).is_some();
        let drive = match (coupled, plays) {
            (true, _) => DriveTable::default(),
            (false, true) if crowd.instance.value::<f64>(PLAY_DRIVE)? == 0.0 => DriveTable::default(),
            (false, _) => crowd.fmu.drive(trial, &settings.drive)?,
        };
        let agents = trial.map_or(&[][..], |trial| &trial.agents);
        let fed = if plays { &[][..] } else { agents };
        let feed = DriveFeed::new(&crowd.instance, fed, drive)?;
        let steps = system.components.iter().zip(&trials).filter_map(|(component, trial)| match trial {
            Some(trial) => Some(trial.parameters.time_step),
            None => component.fmu.description.step,
        });
        let step = steps.filter(|step: &f64| *step > 0.0 && step.is_finite()).reduce(f64::min);
        let (clock, every, of_points) = settings.points(before.as_ref(), start, [stop, step], &feed.drive)?;
        warnings.extend(of_points);
        let undriven = !coupled && before.is_none() && feed.drive.end().is_none();
        if undriven && trial.is_some() && is_still(&crowd.instance, agents.len())? {
            warnings.push(notes::still());
        }
        Ok(PreparedSystem { system, trials, feed, clock, every, before, coupled, warnings })
    }
}

/// Returns whether nobody has a speed or a propulsion at the start.
fn is_still(crowd: &FmuInstance, agents: usize) -> Result<bool> {
    let of_one = ["Fp.x", "Fp.y", "Mp", "Velocity.x", "Velocity.y", "Omega"];
    let all = crowd.select((0..agents).flat_map(|i| of_one.map(|name| format!("agent[{i}].{name}"))))?;
    Ok(crowd.values(&all)?.iter().all(|value: &f64| *value == 0.0))
}

fn open_fmu(settings: &RunSettings, parameters: &[(String, String)]) -> Result<Assembled> {
    let mut fmu = Fmu::open(&settings.input)?;
    let named: Vec<_> =
        parameters.iter().map(|(name, value)| (of_crowd(&fmu, name), value.as_str())).collect();
    fmu.configure(named.into_iter())?;
    let system = System::of_one(CROWD, Arc::new(fmu), settings.algorithm)?;
    Ok(Assembled { system, start: None, stop: None, warnings: Vec::new() })
}

fn open_ssp(settings: &RunSettings, parameters: &[(String, String)]) -> Result<Assembled> {
    require(
        !matches!(settings.drive, DriveChoice::File(_)),
        || "--drive: a drive is for a Trial or an FMU: in an SSP inputs are fed by connections",
    )?;
    if let Some(threads) = settings.threads {
        let why = "--threads: a number of threads is for a Trial or an FMU: in an SSP, set NAME.Threads";
        return Err(format!("{why}={threads}").into());
    }
    let mut assembled = assemble(&settings.input, settings.algorithm, parameters)?;
    let (system, own) = (&assembled.system, settings.drive == DriveChoice::Own);
    for (place, component) in system.components.iter().enumerate().filter(|_| own) {
        if component.fmu.loses_drive(|input| system.feeds(place, input))? {
            assembled.warnings.push(notes::drive_replaced(&component.name));
        }
    }
    Ok(assembled)
}

/// Sets a parameter or a start value; returns a warning if a connection feeds it.
fn set(system: &System, name: &str, value: &str, coupled: bool) -> Result<Option<String>> {
    let found = if coupled {
        component_of(&system.components, name)
    } else {
        Some((0, of_crowd(&system.components[0].fmu, name)))
    };
    let (place, variable) = found.ok_or_else(|| {
        let components: Vec<&str> = system.components.iter().map(|it| it.name.as_str()).collect();
        let components = components.join(", ");
        MasterError::new(format!(
            "--set {name}={value}: expected COMPONENT.NAME; components are {components}"
        ))
    })?;
    let SystemComponent { fmu, instance, .. } = &system.components[place];
    let variables = fmu.values_of(variable);
    let unknown = variables.iter().any(|name| fmu.kind(name).is_none());
    if unknown && let Some(meant) = fmu.meant(variable) {
        let prefix = name.strip_suffix(variable).unwrap_or_default();
        return Err(notes::no_such_variable(name, value, &format!("{prefix}{meant}")));
    }
    if fmu.is_structural(variable) {
        return Ok(None);
    }
    instance.set_text(&variables, value)?;
    let fed = variables.iter().find(|variable| system.feeds(place, variable));
    Ok(fed.map(|input| notes::overwritten(name, value, input)))
}

/// Returns the variable of the only FMU that a name means, which may have the prefix of a Trial's crowd.
fn of_crowd<'a>(fmu: &Fmu, name: &'a str) -> &'a str {
    let own = fmu.values_of(name).iter().all(|name| fmu.kind(name).is_some());
    let inside = name.strip_prefix(CROWD).and_then(|rest| rest.strip_prefix('.'));
    inside.filter(|_| !own).unwrap_or(name)
}

/// Checks that all components can be saved and restored.
fn check_saves(system: &System) -> Result<()> {
    for SystemComponent { name, fmu, .. } in &system.components {
        if let Some(flag) = fmu.cannot_save() {
            let why = format!("component {name:?} says {flag}=\"false\" (--state, --resume)");
            return Err(format!("the run cannot be saved: {why}").into());
        }
    }
    Ok(())
}

/// A drive, into an instance of a crowd.
pub struct DriveFeed {
    /// The drive: who is pushed when.
    pub drive: DriveTable,
    /// The agents that the drive names.
    ids: Vec<String>,
    /// Fp.x, Fp.y and Mp of each of them.
    inputs: ValueSelection,
}

impl DriveFeed {
    /// Makes the feed of the inputs of these agents of an instance.
    fn new(instance: &FmuInstance, agents: &[Agent], drive: DriveTable) -> Result<DriveFeed> {
        let driven = agents_of_drive(agents, &drive).map(|(agent, names)| (agent.id.clone(), names));
        let (ids, names): (Vec<String>, Vec<[String; 3]>) = driven.unzip();
        Ok(DriveFeed { inputs: instance.select(names.iter().flatten())?, ids, drive })
    }

    /// Sets the inputs of the instance to the values at a time \[s\]: forces \[N\] and torques \[N m\].
    ///
    /// # Errors
    /// The FMU refuses the call.
    fn apply(&self, instance: &FmuInstance, time: f64) -> Result<()> {
        if self.inputs.is_empty() {
            return Ok(());
        }
        let values: Vec<f64> = self.ids.iter().filter_map(|id| self.drive.at(id, time)).flatten().collect();
        instance.set(&self.inputs, &values)
    }
}
