//! From settings to a run: a Trial is packed into an FMU, the FMU is loaded and becomes a system, the system is
//! initialized, its drive and its communication points are known; then it is stepped.

use crate::assemble::{Assembled, assemble};
use crate::clock::Clock;
use crate::error::{Error, Place, Result};
use crate::fmu::Fmu;
use crate::given::{Given, pack};
use crate::kind::{Kind, Unexpected};
use crate::own::own_binary;
use crate::progress::Progress;
use crate::pushes::Pushes;
use crate::saved::Saved;
use crate::settings::Settings;
use crate::simulate::{Observer, simulate};
use crate::system::{Component, System};
use crowd_mechanics::model_description::DEFAULT_STOP_TIME;
use crowd_mechanics::pack::{Binary, Format};
use lemons_files::Scratch;
use lemons_trial::Trial;
use lemons_trial::{DriveChoice, Missed};
use std::fmt;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

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
    /// One FMU as the component `crowd`, or those of the SSP.
    pub system: System,
    /// What the components simulate, for those whose FMU contains Trials.
    pub trials: Vec<Option<Trial>>,
    /// What drives the crowd.
    pub pushes: Pushes,
    /// The communication points, and how many of them have been reached.
    pub progress: Progress,
    /// The run that this one goes on from.
    pub before: Option<Saved>,
    /// Whether the input is an SSP.
    pub coupled: bool,
    /// What is probably not meant.
    pub warnings: Vec<Warning>,
}

/// What is probably not meant.
#[derive(Debug, Clone, PartialEq)]
pub enum Warning {
    /// A parameter value of an SSP for which no component has a variable: file, line and name.
    Ignored(String),
    /// A connection of the SSP feeds what is set.
    Overwritten {
        /// Of the parameter, as it was given.
        name: String,
        /// Its value.
        value: String,
        /// The input that is fed.
        input: String,
    },
    /// Rows of the drive are never applied.
    Missed(Missed),
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Warning::Ignored(text) => f.write_str(text),
            Warning::Overwritten { name, value, input } => {
                write!(f, "{name}={value}: overwritten by the connection that feeds {input}")
            }
            Warning::Missed(missed) => write!(f, "drive: {missed}"),
        }
    }
}

/// Why there is no such run.
#[derive(Debug, thiserror::Error)]
pub enum PrepareError {
    /// The saved run contains the parameters.
    #[error("{name}={value}: the saved run contains its parameters, and they cannot be changed")]
    Parameter {
        /// Of the first one.
        name: String,
        /// Its value.
        value: String,
    },
    /// The saved run contains the number of threads.
    #[error("{0} threads: the saved run contains its parameters, and they cannot be changed")]
    Threads(i32),
    /// The saved run contains the tolerance, or what was chosen by it.
    #[error("a tolerance of {0:?}: the saved run contains its mechanical step, which cannot be changed")]
    Tolerance(f64),
    /// In an SSP the number of threads is a parameter of each component.
    #[error("a number of threads is for a Trial or an FMU: in an SSP, set NAME.Threads={0}")]
    ThreadsOfCoupled(i32),
    /// In an SSP there is no drive.
    #[error("a drive is for a Trial or an FMU: in an SSP inputs are fed by connections")]
    DriveOfCoupled,
    /// What goes on is not a saved run.
    #[error(transparent)]
    NotSaved(Unexpected),
    /// A parameter names no component of the SSP.
    #[error("{name}={value}: expected COMPONENT.NAME; components are {}", components.join(", "))]
    Component {
        /// Of the parameter.
        name: String,
        /// Its value.
        value: String,
        /// Names of all of them.
        components: Vec<String>,
    },
    /// An FMU cannot save its state.
    #[error("the run cannot be saved: component {component:?} says {flag}=\"false\"")]
    CannotSave {
        /// Its name.
        component: String,
        /// The flag of its model description.
        flag: &'static str,
    },
    /// The end is not after the beginning.
    #[error(
        "nothing to simulate: {} {first:?} s and stops at {until:?} s",
        if *resumed { "the saved run is at" } else { "it starts at" }
    )]
    Nothing {
        /// \[s\]
        first: f64,
        /// \[s\]
        until: f64,
        /// Whether a saved run is to go on.
        resumed: bool,
    },
    /// Nothing says how long a communication step is.
    #[error("no FMU has a DefaultExperiment with a stepSize")]
    NoStep,
    /// The saved run has another communication step.
    #[error("a communication step of {step:?} s: the saved run has a communication step of {saved:?} s")]
    OtherStep {
        /// \[s\]
        step: f64,
        /// \[s\]
        saved: f64,
    },
    /// The saved run has recorded other communication points.
    #[error("one communication point in {every}: the saved run has one in {saved}")]
    OtherEvery {
        /// What is wanted.
        every: u64,
        /// What is recorded.
        saved: u64,
    },
    /// No communication point would be recorded.
    #[error("one communication point in 0 cannot be recorded: the number must be at least 1")]
    Every,
    /// The saved run had another drive.
    #[error("the saved run had another drive")]
    OtherDrive,
    /// An FMU, an SSP, the drive or the saved run.
    #[error(transparent)]
    Run(#[from] Error),
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
            Some(before) => before.chosen(is_coupled(settings)),
            None => settings.parameters.clone(),
        };
        let Opened { mut system, start, stop, coupled, mut warnings } = open(settings, &parameters)?;
        set_parameters(&system, &parameters, settings.threads, coupled, &mut warnings)?;
        if settings.saves || before.is_some() {
            check_saves(&system)?;
        }
        let of_saved = || settings.resume.as_deref().map(named).unwrap_or_default();
        if let Some(before) = &before {
            before.check_system(&system).place(of_saved)?;
        }
        let start = before.as_ref().map_or(start, |before| before.start);
        let until = settings.until.or(before.as_ref().map(|before| before.until)).or(stop);
        let until = until.unwrap_or(DEFAULT_STOP_TIME);
        let first = before.as_ref().map_or(start, |before| before.time);
        if until <= first {
            return Err(PrepareError::Nothing { first, until, resumed: before.is_some() });
        }

        system.initialize(start, settings.tolerance)?;
        if let (Some(before), Some(states)) = (&before, &states) {
            system.restore(before.time, states).place(of_saved)?;
        }
        let trials = system.components().iter().map(Component::trial).collect::<Result<Vec<_>>>()?;

        let none = DriveChoice::None;
        let first = &system.components()[0];
        let drive = first.fmu.drive(trials[0].as_ref(), if coupled { &none } else { &settings.drive })?;
        let agents = trials[0].as_ref().map_or(&[][..], |trial| &trial.agents);
        let pushes = Pushes::new(&first.instance, agents, drive)?;
        let (step, every) = match &before {
            Some(before) => same(settings, before, &pushes)?,
            None => (step_of(settings, &system, &trials)?, settings.every.unwrap_or(1)),
        };
        let clock = Clock::new(start, step, until).place(|| settings.input.display().to_string())?;
        warnings.extend(pushes.missed(start, step).map(Warning::Missed));
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
    coupled: bool,
    warnings: Vec<Warning>,
}

/// Whether the input is an SSP.
fn is_coupled(settings: &Settings) -> bool {
    settings.input.extension().is_some_and(|end| end.eq_ignore_ascii_case("ssp"))
}

fn open(settings: &Settings, parameters: &[(String, String)]) -> Result<Opened, PrepareError> {
    let input = &settings.input;
    let runs = [Kind::Trial, Kind::Fmu, Kind::Ssp, Kind::Archive, Kind::Stream];
    Kind::expect(input, &runs, "a Trial directory, an FMU or an SSP").map_err(Error::from)?;
    if !is_coupled(settings) {
        let mut fmu = Runnable::of(input, settings.binary.as_ref())?.open()?;
        fmu.configure(parameters.iter().map(|(name, value)| (name.as_str(), value.as_str())))?;
        let system = System::of_one("crowd", fmu, settings.algorithm)?;
        return Ok(Opened { system, start: 0.0, stop: None, coupled: false, warnings: Vec::new() });
    }
    if matches!(settings.drive, DriveChoice::File(_)) {
        return Err(PrepareError::DriveOfCoupled);
    }
    let Assembled { system, start, stop, ignored } = assemble(input, settings.algorithm, parameters)?;
    let warnings = ignored.into_iter().map(Warning::Ignored).collect();
    Ok(Opened { system, start: start.unwrap_or(0.0), stop, coupled: true, warnings })
}

/// The file of an FMU that is to run: one that was given, or that of a Trial. A Trial is packed first, into a temporary
/// file: it runs as everybody's FMU of it would.
pub struct Runnable {
    path: PathBuf,
    /// The Trial as it was given, and the directory in which its FMU is.
    packed: Option<(PathBuf, Scratch)>,
}

impl Runnable {
    /// Packs a Trial, with this library of the crowd, by default [`own_binary`]; anything else may be an FMU.
    ///
    /// # Errors
    /// As [`pack`](crate::pack).
    pub fn of(input: &Path, binary: Option<&Binary>) -> Result<Runnable> {
        let Some(trial) = Given::find(input)? else {
            return Ok(Runnable { path: input.to_owned(), packed: None });
        };
        let scratch = Scratch::new().map_err(Error::io("cannot make a temporary directory"))?;
        let path = scratch.path().join("crowd.fmu");
        let binary = binary.cloned().map_or_else(own_binary, Ok)?;
        pack(&[trial], vec![binary], Format::default(), None, false, &path)?;
        Ok(Runnable { path, packed: Some((input.to_owned(), scratch)) })
    }

    /// The file, which exists as long as this does.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Unzips it. In messages, the files of a packed Trial have the names that the user knows.
    ///
    /// # Errors
    /// There is no FMU.
    pub fn open(&self) -> Result<Fmu> {
        let fmu = Fmu::open(&self.path)?;
        Ok(match &self.packed {
            Some((trial, _)) => fmu.of_trial(trial),
            None => fmu,
        })
    }
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
    let (place, variable) = match (coupled, system.find(name)) {
        (false, _) => (0, name),
        (true, Some(found)) => found,
        (true, None) => {
            let components = system.components().iter().map(|component| component.name.clone()).collect();
            let (name, value) = given();
            return Err(PrepareError::Component { name, value, components });
        }
    };
    let component = &system.components()[place];
    if component.fmu.is_structural(variable) {
        return Ok(None);
    }
    let variables = component.fmu.named(variable);
    component.instance.set(&variables, value)?;
    let fed = variables.into_iter().find(|variable| system.feeds(place, variable));
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
