//! Why there is no run, and what is probably not meant.

use crate::error::Error;
use crate::file_type::Unexpected;
use lemons_core::trial::{DRIVE_FILE, Missed};
use lemons_decision::DECISION_FILE;
use std::fmt;
use std::path::PathBuf;

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
    /// A parameter of people has different values in two components that are connected by the names of these people.
    Differs {
        /// Of the first of these people.
        name: String,
        /// The components, with their values.
        values: [(String, f64); 2],
        /// Number of people for whom it differs.
        people: usize,
    },
    /// Rows of the drive are never applied.
    Missed(Missed),
    /// The Trial has a drive file, which is added to how its people walk.
    DriveOfWalkers {
        /// The file that says where, as the user knows it.
        plan: PathBuf,
    },
    /// A connection feeds Fp or Mp of people whom the drive in the FMU of this component would drive.
    DriveReplaced(String),
    /// A run that is saved ends, or one that goes on began, between two communication points.
    Between {
        /// \[s\]
        time: f64,
        /// \[s\] The communication step.
        step: f64,
    },
    /// Nothing moves a Trial's people: no drive, no `decision.toml`, no force and no speed at the start.
    Still,
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Warning::Ignored(text) => f.write_str(text),
            Warning::Overwritten { name, value, input } => {
                write!(f, "{name}={value}: overwritten by the connection that feeds {input}")
            }
            Warning::Differs { name, values: [(one, here), (other, there)], people } => write!(
                f,
                "{name} is {here:?} in {one}, but {there:?} in {other} (of {people} {}): set it in both",
                if *people == 1 { "person" } else { "people" }
            ),
            Warning::Missed(missed) => write!(f, "drive: {missed}"),
            Warning::DriveOfWalkers { plan } => {
                write!(
                    f,
                    "the forces of {DRIVE_FILE} are added to those with which people walk ({})",
                    plan.display()
                )
            }
            Warning::DriveReplaced(component) => write!(
                f,
                "{component}: the {DRIVE_FILE} in it does not act on people whose Fp or Mp is connected; of a Trial with \
                 {DECISION_FILE}, lemons run TRIAL adds it to the forces with which they walk"
            ),
            Warning::Between { time, step } => write!(
                f,
                "t = {time:?} s is between two communication points ({step:?} s apart): a run that goes on from there has \
                 one more, so its results are not those of a run without interruption"
            ),
            Warning::Still => write!(
                f,
                "nobody is driven: neither {DECISION_FILE} (where people walk) nor {DRIVE_FILE} is used, and \
                 AgentDynamics.xml has no force and no speed"
            ),
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
    /// Only people of a Trial walk by a file.
    #[error("a file like {DECISION_FILE} is for a Trial, and not for an FMU or an SSP")]
    PlanWithoutTrial,
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
    /// The component has no such variable, but another one has, or there is one that is spelt alike.
    #[error("{name}={value}: there is no such variable; did you mean {meant:?}?")]
    OfOther {
        /// Of the parameter.
        name: String,
        /// Its value.
        value: String,
        /// The name that is probably meant.
        meant: String,
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
    /// The saved run has no people who walk, but now they would.
    #[error("nobody walked by a file in the saved run, but now people would walk ({})", .0.display())]
    NowWalks(PathBuf),
    /// In the saved run people walked.
    #[error("people walked by a file like {DECISION_FILE} in the saved run, but now nobody would")]
    NoLongerWalks,
    /// An FMU, an SSP, the drive or the saved run.
    #[error(transparent)]
    Run(#[from] Error),
}
