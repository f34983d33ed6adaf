//! From settings to a run: a Trial is packed into an FMU, the FMU is loaded and becomes a system, the system is
//! initialized, its drive and its communication points are known; then it is stepped.

use crate::assemble::{Assembled, assemble};
use crate::clock::Clock;
use crate::decider::PlanChoice;
use crate::error::{Error, Place, Result};
use crate::instance::Instance;
use crate::kind::Kind;
use crate::model::Model;
use crate::progress::Progress;
use crate::pushes::Pushes;
use crate::refusal::{PrepareError, Warning};
use crate::saved::Saved;
use crate::settings::Settings;
use crate::simulate::{Observer, simulate};
use crate::system::{Component, PLAY_DRIVE, System};
use crowd_mechanics::model_description::DEFAULT_STOP_TIME;
use lemons_trial::{DriveChoice, DriveTable, Trial};
use std::ops::ControlFlow;
use std::path::Path;

/// A run that is ready: initialized, and at its first communication point, or at that of the saved run.
///
/// ```no_run
/// use lemons_master::{Error, Observer, PrepareError, Prepared, Reached, Settings, System};
///
/// struct Print;
///
/// impl Observer<System> for Print {
///     type Error = Error;
///
///     fn look(&mut self, system: &mut System, reached: Reached) -> Result<(), Error> {
///         let crowd = &system.components()[0].instance;
///         println!("{} s: {} m", reached.time, crowd.real("agent[0].Position.x")?);
///         Ok(())
///     }
/// }
///
/// let parameters = vec![("agent[*].Mass".to_owned(), "80".to_owned())];
/// let settings = Settings { parameters, until: Some(2.0), ..Settings::of("resources/Trial_push") };
/// let mut run = Prepared::of(&settings)?;
/// for warning in &run.warnings {
///     println!("{warning}");
/// }
/// let _ = run.simulate(&mut Print)?;
/// # Ok::<(), PrepareError>(())
/// ```
pub struct Prepared {
    /// One FMU as the component `crowd`, with `decision` before it if people walk; or those of the SSP.
    pub system: System,
    /// What the components simulate, for those whose FMU contains Trials.
    pub trials: Vec<Option<Trial>>,
    /// What drives the crowd.
    pub pushes: Pushes,
    /// The communication points, and how many of them have been reached.
    pub progress: Progress,
    /// The run that this one goes on from.
    pub before: Option<Saved>,
    /// Whether FMUs are coupled: those of an SSP, or of people who walk.
    pub coupled: bool,
    /// What is probably not meant.
    pub warnings: Vec<Warning>,
}

impl Prepared {
    /// Prepares a run.
    ///
    /// # Errors
    /// A setting is outside of its domain ([`Settings`]), the settings do not fit together or to the input, or the
    /// input, the drive or the saved run is wrong.
    pub fn of(settings: &Settings) -> Result<Prepared, PrepareError> {
        check_resumed(settings)?;
        if settings.every == Some(0) {
            return Err(PrepareError::Every);
        }
        let saved = settings.resume.as_deref().map(read_saved).transpose()?;
        let (before, states) = saved.unzip();
        let parameters = match &before {
            Some(before) => before.chosen(is_ssp(settings)),
            None => settings.parameters.clone(),
        };
        let Opened { mut system, start, stop, model, mut warnings } = open(settings, &parameters)?;
        let coupled = is_ssp(settings) || system.components().len() > 1;
        set_parameters(&system, &parameters, settings.threads, model.as_ref(), &mut warnings)?;
        let own =
            settings.drive == DriveChoice::Own && model.as_ref().is_none_or(|model| model.plan().is_none());
        if !own {
            system.stop_drives()?;
        }
        if settings.saves || before.is_some() {
            check_saves(&system)?;
        }
        let of_saved = || settings.resume.as_deref().map(named).unwrap_or_default();
        if let Some(before) = &before {
            check_walk(before, model.as_ref())?;
            before.check_system(&system).place(of_saved)?;
        }
        let start = before.as_ref().map_or(start, |before| before.start);
        let until = settings.until.or(before.as_ref().map(|before| before.until)).or(stop);
        let until = until.unwrap_or(DEFAULT_STOP_TIME);
        let first = before.as_ref().map_or(start, |before| before.time);
        if until <= first {
            return Err(PrepareError::Nothing { first, until, resumed: before.is_some() });
        }

        let plays = model.as_ref().filter(|model| model.plays(&settings.drive));
        if let Err(error) = system.initialize(start, settings.tolerance) {
            // If its drive is why, the errors in that file say more.
            if let (Some(model), Ok(Some(trial))) = (plays, system.components()[0].trial()) {
                model.drive(Some(&trial), &settings.drive)?;
            }
            return Err(error.into());
        }
        if let (Some(before), Some(states)) = (&before, &states) {
            system.restore(before.time, states).place(of_saved)?;
        }
        warnings.extend(system.differing()?);
        let trials = system.components().iter().map(Component::trial).collect::<Result<Vec<_>>>()?;

        // The crowd; nothing drives the components of an SSP.
        let main = trials.len() - 1;
        let (crowd, trial) = (&system.components()[main].instance, trials[main].as_ref());
        let drive = match &model {
            Some(_) if plays.is_some() && !is_true(crowd, PLAY_DRIVE)? => DriveTable::default(),
            Some(model) => model.drive(trial, &settings.drive)?,
            None => DriveTable::default(),
        };
        let agents = trial.map_or(&[][..], |trial| &trial.agents);
        let pushes = Pushes::new(crowd, agents, drive, plays.is_some())?;
        let (step, every) = match &before {
            Some(before) => same(settings, before, &pushes)?,
            None => (step_of(settings, &system, &trials)?, settings.every.unwrap_or(1)),
        };
        let clock = Clock::new(start, step, until).place(|| settings.input.display().to_string())?;
        warnings.extend(pushes.missed(start, step).map(Warning::Missed));
        let begun = before.as_ref().map(|before| (before.time, before.index));
        let saved = settings.saves.then_some((clock.until, clock.steps));
        let between = begun.into_iter().chain(saved).find(|(time, index)| *time != clock.point(*index));
        warnings.extend(between.map(|(time, _)| Warning::Between { time, step }));
        let undriven = !coupled && before.is_none() && pushes.end().is_none();
        if undriven && trial.is_some() && is_still(crowd, agents.len())? {
            warnings.push(Warning::Still);
        }
        let progress = Progress { clock, every, index: before.as_ref().map_or(0, |before| before.index) };
        Ok(Prepared { system, trials, pushes, progress, before, coupled, warnings })
    }

    /// Steps to the end, or until the observer ends the run: then `Break`. See [`simulate()`].
    ///
    /// # Errors
    /// An FMU's refusal or failure, or the observer's.
    pub fn simulate<O: Observer<System>>(&mut self, observer: &mut O) -> Result<ControlFlow<()>, O::Error> {
        simulate(&mut self.system, &self.progress.clock, self.progress.index, &self.pushes, observer)
    }
}

/// A system that is not initialized yet.
struct Opened {
    system: System,
    /// \[s\]
    start: f64,
    /// \[s\] if the input says when it stops.
    stop: Option<f64>,
    /// What names of parameters mean; none in an SSP.
    model: Option<Model>,
    warnings: Vec<Warning>,
}

/// Whether nobody has a speed or a propulsion at the start.
fn is_still(crowd: &Instance, agents: usize) -> Result<bool> {
    let of_one = ["Fp.x", "Fp.y", "Mp", "Velocity.x", "Velocity.y", "Omega"];
    let all = crowd.select((0..agents).flat_map(|i| of_one.map(|name| format!("agent[{i}].{name}"))))?;
    let mut values = vec![0.0; all.len()];
    crowd.get_real(&all, &mut values)?;
    Ok(values.iter().all(|value| *value == 0.0))
}

/// The value of a Boolean.
fn is_true(instance: &Instance, name: &str) -> Result<bool> {
    let mut value = [0];
    instance.get_boolean(&instance.select([name])?, &mut value)?;
    Ok(value != [0])
}

/// Whether the input is an SSP.
fn is_ssp(settings: &Settings) -> bool {
    settings.input.extension().is_some_and(|end| end.eq_ignore_ascii_case("ssp"))
}

fn open(settings: &Settings, parameters: &[(String, String)]) -> Result<Opened, PrepareError> {
    let input = &settings.input;
    let runs = [Kind::Trial, Kind::Fmu, Kind::Ssp, Kind::Archive, Kind::Stream];
    Kind::expect(input, &runs, "a Trial directory, an FMU or an SSP").map_err(Error::from)?;
    if !is_ssp(settings) {
        let mut model = Model::of(input, &settings.plan, settings.binary.as_ref())?;
        model.configure(parameters.iter().map(|(name, value)| (name.as_str(), value.as_str())))?;
        let system = model.system(settings.algorithm)?;
        let warnings = model.warning(&settings.drive).into_iter().collect();
        return Ok(Opened { system, start: 0.0, stop: None, model: Some(model), warnings });
    }
    if matches!(settings.plan, PlanChoice::File(_)) {
        return Err(PrepareError::PlanWithoutTrial);
    }
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
    Ok(Opened { system, start: start.unwrap_or(0.0), stop, model: None, warnings })
}

/// Parameters, start values and the number of threads.
fn set_parameters(
    system: &System,
    parameters: &[(String, String)],
    threads: Option<i32>,
    model: Option<&Model>,
    warnings: &mut Vec<Warning>,
) -> Result<(), PrepareError> {
    for (name, value) in parameters {
        warnings.extend(set(system, name, value, model)?);
    }
    match threads {
        Some(threads) if model.is_none() => Err(PrepareError::ThreadsOfCoupled(threads)),
        Some(threads) => set(system, "Threads", &threads.to_string(), model).map(drop),
        None => Ok(()),
    }
}

fn set(
    system: &System,
    name: &str,
    value: &str,
    model: Option<&Model>,
) -> Result<Option<Warning>, PrepareError> {
    let given = || (name.to_owned(), value.to_owned());
    let in_ssp = || system.find(name).map(|(place, variable)| (vec![place], variable));
    let Some((places, variable)) = model.map(|model| model.set_by(name)).or_else(in_ssp) else {
        let components = system.components().iter().map(|component| component.name.clone()).collect();
        let (name, value) = given();
        return Err(PrepareError::Component { name, value, components });
    };
    // The one that is meant first.
    let component = &system.components()[places[0]];
    let misspelt = || {
        let unknown = component.fmu.named(variable).iter().any(|name| component.fmu.kind(name).is_none());
        let meant = if unknown { component.fmu.meant(variable)? } else { return None };
        Some(name.strip_suffix(variable)?.to_owned() + &meant)
    };
    if let Some(meant) = model.map_or_else(misspelt, |model| model.meant(name)) {
        let (name, value) = given();
        return Err(PrepareError::OfOther { name, value, meant });
    }
    let mut fed = None;
    for place in places {
        let component = &system.components()[place];
        if component.fmu.is_structural(variable) {
            continue;
        }
        let variables = component.fmu.named(variable);
        component.instance.set(&variables, value)?;
        fed = fed.or(variables.into_iter().find(|variable| system.feeds(place, variable)));
    }
    Ok(fed.map(|input| {
        let (name, value) = given();
        Warning::Overwritten { name, value, input }
    }))
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

fn read_saved(path: &Path) -> Result<(Saved, Vec<Vec<u8>>), PrepareError> {
    Kind::expect(path, &[Kind::SavedRun], "a saved run").map_err(PrepareError::NotSaved)?;
    Ok(Saved::read(path)?)
}

/// That people walk if and only if they did: of the Trial's own file, an option may ignore it.
fn check_walk(before: &Saved, model: Option<&Model>) -> Result<(), PrepareError> {
    let Some(model) = model else { return Ok(()) };
    match (before.component.len(), model.plan()) {
        (1, Some(plan)) => Err(PrepareError::NowWalks(plan.to_owned())),
        (2.., None) => Err(PrepareError::NoLongerWalks),
        _ => Ok(()),
    }
}

/// That nothing is set that a saved run contains.
fn check_resumed(settings: &Settings) -> Result<(), PrepareError> {
    if let (Some(_), Some(tolerance)) = (&settings.resume, settings.tolerance) {
        return Err(PrepareError::Tolerance(tolerance));
    }
    match (&settings.resume, settings.parameters.first(), settings.threads) {
        (None, ..) | (Some(_), None, None) => Ok(()),
        (Some(_), Some((name, value)), _) => {
            Err(PrepareError::Parameter { name: name.clone(), value: value.clone() })
        }
        (Some(_), None, Some(threads)) => Err(PrepareError::Threads(threads)),
    }
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

/// Communication step \[s\] and recorded points of a saved run, which goes on as it went before.
fn same(settings: &Settings, before: &Saved, pushes: &Pushes) -> Result<(f64, u64), PrepareError> {
    if let Some(step) = settings.step.filter(|step| *step != before.step) {
        return Err(PrepareError::OtherStep { step, saved: before.step });
    }
    if let Some(every) = settings.every.filter(|every| *every != before.every) {
        return Err(PrepareError::OtherEvery { every, saved: before.every });
    }
    if pushes.fingerprint() != before.drive {
        return Err(PrepareError::OtherDrive);
    }
    Ok((before.step, before.every))
}
