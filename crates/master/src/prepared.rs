//! From settings to a run of an FMU or an SSP: it is loaded and becomes a system, the system is initialized, its drive and
//! its communication points are known; then it is stepped.

use crate::assemble::{Assembled, assemble};
use crate::decider::PlanChoice;
use crate::drive_feed::DriveFeed;
use crate::error::{Error, Place, Result};
use crate::file_type::FileType;
use crate::fmu::Fmu;
use crate::instance::Instance;
use crate::prepare_error::{PrepareError, Warning};
use crate::saved::Saved;
use crate::settings::Settings;
use crate::system::{Component, PLAY_DRIVE, System};
use lemons_core::trial::{DriveChoice, DriveTable, Trial};
use lemons_sim::{Clock, Model};
use std::path::Path;
use std::sync::Arc;

/// Name of the component of a run of one FMU.
const CROWD: &str = "crowd";

/// A run that is ready: initialized, and at its first communication point, or at that of the saved run. It is a
/// [`Model`] that [`lemons_sim::run()`] steps.
///
/// ```no_run
/// use lemons_master::{Error, PrepareError, Prepared, Settings};
/// use std::ops::ControlFlow;
///
/// let parameters = vec![("agent[*].Mass".to_owned(), "80".to_owned())];
/// let settings = Settings { parameters, until: Some(2.0), ..Settings::of("push.fmu") };
/// let mut run = Prepared::of(&settings)?;
/// for warning in &run.warnings {
///     println!("{warning}");
/// }
/// let clock = run.clock;
/// let _ = lemons_sim::run::<_, Error>(&mut run, &clock, 0, |run, point| {
///     let crowd = &run.system.components()[0].instance;
///     println!("{} s: {} m", point.time, crowd.value::<f64>("agent[0].Position.x")?);
///     Ok(ControlFlow::Continue(()))
/// })?;
/// # Ok::<(), PrepareError>(())
/// ```
pub struct Prepared {
    /// One FMU as the component `crowd`; or those of the SSP.
    pub system: System,
    /// What the components simulate, for those whose FMU contains Trials.
    pub trials: Vec<Option<Trial>>,
    /// What drives the crowd.
    pub feed: DriveFeed,
    /// The communication points.
    pub clock: Clock,
    /// One communication point in so many is recorded, beginning with the first.
    pub every: u64,
    /// The run that this one goes on from.
    pub before: Option<Saved>,
    /// Whether FMUs are coupled: those of an SSP.
    pub coupled: bool,
    /// What is probably not meant.
    pub warnings: Vec<Warning>,
}

impl Model for Prepared {
    type Error = Error;

    fn step_to(&mut self, time: f64) -> Result<()> {
        // A system of several components has no drive.
        self.feed.apply(&self.system.components()[0].instance, self.system.time())?;
        self.system.step_to(time)
    }
}

impl Prepared {
    /// Prepares a run.
    ///
    /// # Errors
    /// A setting is outside of its domain ([`Settings`]), the settings do not fit together or to the input, or the
    /// input, the drive or the saved run is wrong.
    pub fn of(settings: &Settings) -> Result<Prepared, PrepareError> {
        settings.check()?;
        let saved = settings.resume.as_deref().map(read_saved).transpose()?;
        let (before, states) = saved.unzip();
        let coupled = is_ssp(settings);
        let parameters = match &before {
            Some(before) => before.chosen(coupled),
            None => settings.parameters.clone(),
        };
        let Opened { mut system, start, stop, mut warnings } = open(settings, &parameters)?;
        set_parameters(&system, &parameters, settings.threads, coupled, &mut warnings)?;
        let own = settings.drive == DriveChoice::Own;
        if !own {
            system.stop_drives()?;
        }
        if settings.saves || before.is_some() {
            check_saves(&system)?;
        }
        let of_saved = || settings.resume.as_deref().map(named).unwrap_or_default();
        if let Some(before) = &before {
            before.check_system(&system).place(of_saved)?;
        }
        let start = before.as_ref().map_or(start, |before| before.start);
        let until = settings.until_of(before.as_ref(), start, stop)?;
        system.initialize(start, settings.tolerance)?;
        if let (Some(before), Some(states)) = (&before, &states) {
            system.restore(before.time, states).place(of_saved)?;
        }
        warnings.extend(system.differing()?);
        let trials = system.components().iter().map(Component::trial).collect::<Result<Vec<_>>>()?;

        // The crowd; nothing drives the components of an SSP.
        let main = trials.len() - 1;
        let (crowd, trial) = (&system.components()[main], trials[main].as_ref());
        let plays = !coupled && own && crowd.fmu.kind(PLAY_DRIVE).is_some();
        let drive = match (coupled, plays) {
            (true, _) => DriveTable::default(),
            (false, true) if !crowd.instance.value::<bool>(PLAY_DRIVE)? => DriveTable::default(),
            (false, _) => crowd.fmu.drive(trial, &settings.drive)?,
        };
        let agents = trial.map_or(&[][..], |trial| &trial.agents);
        let feed = DriveFeed::new(&crowd.instance, agents, drive, plays)?;
        if before.as_ref().is_some_and(|before| feed.drive.fingerprint() != before.drive) {
            return Err(PrepareError::OtherDrive);
        }
        let (step, every) = match &before {
            Some(before) => settings.same_points(before)?,
            None => (step_of(settings, &system, &trials)?, settings.every.unwrap_or(1)),
        };
        let clock = Clock::new(start, step, until).map_err(Error::from);
        let clock = clock.place(|| settings.input.display().to_string())?;
        warnings.extend(feed.drive.missed(start, step).map(Warning::Missed));
        warnings.extend(settings.between(before.as_ref(), &clock));
        let undriven = !coupled && before.is_none() && feed.drive.end().is_none();
        if undriven && trial.is_some() && is_still(&crowd.instance, agents.len())? {
            warnings.push(Warning::Still);
        }
        Ok(Prepared { system, trials, feed, clock, every, before, coupled, warnings })
    }
}

/// A system that is not initialized yet.
struct Opened {
    system: System,
    /// \[s\]
    start: f64,
    /// \[s\] if the input says when it stops.
    stop: Option<f64>,
    warnings: Vec<Warning>,
}

/// Whether nobody has a speed or a propulsion at the start.
fn is_still(crowd: &Instance, agents: usize) -> Result<bool> {
    let of_one = ["Fp.x", "Fp.y", "Mp", "Velocity.x", "Velocity.y", "Omega"];
    let all = crowd.select((0..agents).flat_map(|i| of_one.map(|name| format!("agent[{i}].{name}"))))?;
    Ok(crowd.values(&all)?.iter().all(|value: &f64| *value == 0.0))
}

/// Whether the input is an SSP.
fn is_ssp(settings: &Settings) -> bool {
    settings.input.extension().is_some_and(|end| end.eq_ignore_ascii_case("ssp"))
}

fn open(settings: &Settings, parameters: &[(String, String)]) -> Result<Opened, PrepareError> {
    let input = &settings.input;
    FileType::expect(input, &[FileType::Fmu, FileType::Ssp, FileType::Archive], "an FMU or an SSP")
        .map_err(Error::from)?;
    if matches!(settings.plan, PlanChoice::File(_)) {
        return Err(PrepareError::PlanWithoutTrial);
    }
    if is_ssp(settings) {
        if matches!(settings.drive, DriveChoice::File(_)) {
            return Err(PrepareError::DriveOfCoupled);
        }
        let Assembled { system, start, stop, ignored } = assemble(input, settings.algorithm, parameters)?;
        let mut warnings: Vec<Warning> = ignored.into_iter().map(Warning::Ignored).collect();
        if settings.drive == DriveChoice::Own {
            for (place, component) in system.components().iter().enumerate() {
                if component.fmu.loses_drive(|input| system.feeds(place, input))? {
                    warnings.push(Warning::DriveReplaced(component.name.clone()));
                }
            }
        }
        return Ok(Opened { system, start: start.unwrap_or(0.0), stop, warnings });
    }
    let mut fmu = Fmu::open(input)?;
    let named = parameters.iter().map(|(name, value)| (of_crowd(&fmu, name), value.as_str()));
    let named: Vec<(&str, &str)> = named.collect();
    fmu.configure(named.into_iter())?;
    let system = System::of_one(CROWD, Arc::new(fmu), settings.algorithm)?;
    Ok(Opened { system, start: 0.0, stop: None, warnings: Vec::new() })
}

/// Parameters, start values and the number of threads.
fn set_parameters(
    system: &System,
    parameters: &[(String, String)],
    threads: Option<i32>,
    coupled: bool,
    warnings: &mut Vec<Warning>,
) -> Result<(), PrepareError> {
    for (name, value) in parameters {
        warnings.extend(set(system, name, value, coupled)?);
    }
    match threads {
        Some(threads) if coupled => Err(PrepareError::ThreadsOfCoupled(threads)),
        Some(threads) => set(system, "Threads", &threads.to_string(), coupled).map(drop),
        None => Ok(()),
    }
}

fn set(system: &System, name: &str, value: &str, coupled: bool) -> Result<Option<Warning>, PrepareError> {
    let given = || (name.to_owned(), value.to_owned());
    let found =
        if coupled { system.find(name) } else { Some((0, of_crowd(&system.components()[0].fmu, name))) };
    let Some((place, variable)) = found else {
        let components = system.components().iter().map(|component| component.name.clone()).collect();
        let (name, value) = given();
        return Err(PrepareError::Component { name, value, components });
    };
    let component = &system.components()[place];
    let unknown = component.fmu.named(variable).iter().any(|name| component.fmu.kind(name).is_none());
    let meant = if unknown { component.fmu.meant(variable) } else { None };
    if let Some((prefix, meant)) = name.strip_suffix(variable).zip(meant) {
        let (name, value) = given();
        return Err(PrepareError::OfOther { name, value, meant: prefix.to_owned() + &meant });
    }
    if component.fmu.is_structural(variable) {
        return Ok(None);
    }
    let variables = component.fmu.named(variable);
    component.instance.set_text(&variables, value)?;
    let fed = variables.into_iter().find(|variable| system.feeds(place, variable));
    Ok(fed.map(|input| {
        let (name, value) = given();
        Warning::Overwritten { name, value, input }
    }))
}

/// The variable of the only FMU that a name means, which may have the prefix of a Trial's crowd.
fn of_crowd<'a>(fmu: &Fmu, name: &'a str) -> &'a str {
    let own = fmu.named(name).iter().all(|name| fmu.kind(name).is_some());
    let inside = name.strip_prefix(CROWD).and_then(|rest| rest.strip_prefix('.'));
    inside.filter(|_| !own).unwrap_or(name)
}

/// \[s\] The one that is wanted, else the smallest that a component asks for.
fn step_of(settings: &Settings, system: &System, trials: &[Option<Trial>]) -> Result<f64, PrepareError> {
    let steps = system.components().iter().zip(trials).filter_map(|(component, trial)| match trial {
        Some(trial) => Some(trial.parameters.time_step),
        None => component.fmu.description.step,
    });
    let smallest = steps.filter(|step: &f64| *step > 0.0 && step.is_finite()).reduce(f64::min);
    settings.step.or(smallest).ok_or(PrepareError::NoStep)
}

fn named(path: &Path) -> String {
    format!("saved run {}", path.display())
}

/// Reads the run that is to go on.
pub fn read_saved(path: &Path) -> Result<(Saved, Vec<Vec<u8>>), PrepareError> {
    FileType::expect(path, &[FileType::SavedRun], "a saved run").map_err(PrepareError::NotSaved)?;
    Ok(Saved::read(path)?)
}

/// That all components can be saved and restored.
fn check_saves(system: &System) -> Result<(), PrepareError> {
    for component in system.components() {
        if let Some(flag) = component.fmu.cannot_save() {
            return Err(PrepareError::CannotSave { component: component.name.clone(), flag });
        }
    }
    Ok(())
}
