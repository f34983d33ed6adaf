//! One FMU instance without the C interface, of either version of FMI: lifecycle, variables,
//! stepping, states.
//!
//! A call that is refused does not change the instance.

mod saved;
mod values;

use crate::Version;
use crate::answer::{Answer, discard, refuse};
use crate::lifecycle::{Function, Phase, allowed};
use crate::model::{Model, Step, StepError, guid, instantiation_token};
use crate::variables::{BaseType, Domain, Role, Scalar, Variable};
pub use saved::Snapshot;
use serde::{Deserialize, Serialize};
use uuid::Uuid;

/// Start time and, if given, stop time of the simulation \[s\].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
struct Experiment {
    start: f64,
    stop: Option<f64>,
}

/// A variable that a value reference leads to, without what only messages need: calls read
/// thousands of them.
#[derive(Clone, Copy)]
struct Row<Q> {
    /// `None` for the time and the structural parameters of FMI 3.0.
    quantity: Option<Q>,
    /// FMI 2.0: the element.
    element: u32,
    of: BaseType,
    role: Role,
    domain: Domain,
}

impl<Q: Copy> Row<Q> {
    fn new(variable: &Variable<Q>, element: usize) -> Row<Q> {
        Row {
            quantity: Some(variable.quantity),
            element: element as u32,
            of: variable.kind.into(),
            role: variable.role,
            domain: variable.domain,
        }
    }
}

/// One FMU instance.
pub struct Slave<M: Model> {
    pub(crate) model: M,
    version: Version,
    token: Uuid,
    /// The variables by value reference. In FMI 2.0 each is an element; in FMI 3.0 the time, the
    /// structural parameters, and whole variables.
    rows: Vec<Row<M::Quantity>>,
    /// FMI 2.0: the variables, for messages.
    scalars: Vec<Scalar<M::Quantity>>,
    /// FMI 3.0: the structural parameters as they were set.
    sizes: Vec<u64>,
    phase: Phase,
    time: f64,
    experiment: Option<Experiment>,
}

impl<M: Model> Slave<M> {
    /// Makes an instance of a model.
    ///
    /// # Errors
    /// The token is not that of the model.
    pub fn new(model: M, version: Version, given: &str) -> Answer<Slave<M>> {
        let mut scalars = Vec::new();
        let (rows, token, word) = match version {
            Version::V2 => {
                scalars = model.scalars();
                let row = |scalar: &Scalar<M::Quantity>| Row::new(scalar.variable, scalar.element);
                (scalars.iter().map(row).collect(), guid(&scalars), "GUID")
            }
            Version::V3 => (rows_of_arrays::<M>(), instantiation_token::<M>(), "instantiationToken"),
        };
        let bare = |text: &str| text.trim_matches(['{', '}']).to_ascii_lowercase();
        if bare(given) != token.to_string() {
            return refuse(format!(
                "the {word} {given:?} is not this FMU's {:?}: modelDescription.xml and resources do not belong \
                 together",
                token.braced().to_string()
            ));
        }
        let sizes = sizes(&model, version);
        let (phase, time, experiment) = (Phase::Instantiated, 0.0, None);
        Ok(Slave { model, version, token, rows, scalars, sizes, phase, time, experiment })
    }

    /// Returns the current communication point \[s\].
    pub fn time(&self) -> f64 {
        self.time
    }

    /// Returns the warnings since the last call.
    pub fn take_warnings(&mut self) -> Vec<String> {
        self.model.take_warnings()
    }

    /// Checks that a function is allowed in the current phase.
    ///
    /// # Errors
    /// It is not allowed.
    pub fn check(&self, function: Function) -> Answer<()> {
        if allowed(function, self.version, self.phase) {
            Ok(())
        } else {
            refuse(format!("not allowed in the state {:?}", self.phase))
        }
    }

    /// Sets start time and, if given, stop time of the simulation \[s\], and tolerance:
    /// `fmi2SetupExperiment`, or the first part of `fmi3EnterInitializationMode`.
    ///
    /// # Errors
    /// Wrong phase; times that are not finite or are in the wrong order; a tolerance that is negative
    /// or not finite.
    pub fn setup_experiment(&mut self, start: f64, stop: Option<f64>, tolerance: Option<f64>) -> Answer<()> {
        self.check(Function::SetupExperiment)?;
        // OMSimulator defines one of 0 where its structure names none.
        let tolerance = tolerance.filter(|tolerance| *tolerance != 0.0);
        if let Some(tolerance) = tolerance.filter(|tolerance| !(*tolerance > 0.0 && tolerance.is_finite())) {
            return refuse(format!(
                "a tolerance of {tolerance:?}: must be positive and finite, or 0 or not defined for none"
            ));
        }
        if !start.is_finite() {
            return refuse(format!("start time {start:?}: must be finite"));
        }
        if let Some(stop) = stop.filter(|stop| !(stop.is_finite() && *stop >= start)) {
            return refuse(format!(
                "stop time {stop:?} s: must be finite and not before the start time {start:?} s"
            ));
        }
        (self.experiment, self.time) = (Some(Experiment { start, stop }), start);
        self.model.set_tolerance(tolerance);
        Ok(())
    }

    /// Enters Initialization Mode.
    ///
    /// # Errors
    /// Wrong phase, or no start time.
    pub fn enter_initialization(&mut self) -> Answer<()> {
        self.check(Function::EnterInitializationMode)?;
        if self.experiment.is_none() {
            return refuse("fmi2SetupExperiment has not been called");
        }
        self.phase = Phase::Initialization;
        Ok(())
    }

    /// Leaves Initialization Mode.
    ///
    /// # Errors
    /// Wrong phase; structural parameters that are not the sizes of what is loaded; values that do
    /// not fit together.
    pub fn exit_initialization(&mut self) -> Answer<()> {
        self.check(Function::ExitInitializationMode)?;
        (0..self.sizes.len()).try_for_each(|place| self.check_size(place))?;
        discard(self.version, self.model.initialize(self.time))?;
        self.phase = Phase::StepComplete;
        Ok(())
    }

    /// Calls a function that does nothing but lead to a phase.
    ///
    /// # Errors
    /// Wrong phase.
    pub fn change_phase(&mut self, function: Function, to: Phase) -> Answer<()> {
        self.check(function)?;
        self.phase = to;
        Ok(())
    }

    /// Goes back to the state after instantiation.
    ///
    /// # Errors
    /// Wrong phase, or resources that can no longer be read.
    pub fn reset(&mut self) -> Answer<()> {
        self.check(Function::Reset)?;
        self.model.reset()?;
        self.sizes = sizes(&self.model, self.version);
        (self.phase, self.time, self.experiment) = (Phase::Instantiated, 0.0, None);
        Ok(())
    }

    /// Refuses a structural parameter that is not the size of what is loaded.
    fn check_size(&self, place: usize) -> Answer<()> {
        let (declared, loaded) = (self.sizes[place], self.model.size(place));
        // Arrays of an optional size may be missing, or be of nothing.
        if declared == loaded || M::SIZES[place].optional && (declared == 0 || loaded == 0) {
            return Ok(());
        }
        let name = M::SIZES[place].name;
        refuse(format!(
            "{name} is {declared}, but what is loaded has {loaded}: choose what to load, or set {name} in \
             Configuration Mode"
        ))
    }

    /// Refuses a function of events, clocks and other kinds of FMUs.
    ///
    /// # Errors
    /// Always.
    pub fn not_offered<T>(&self) -> Answer<T> {
        self.check(Function::Unsupported)?;
        refuse("this FMU is for co-simulation without events and clocks")
    }

    /// Refuses directional derivatives.
    ///
    /// # Errors
    /// Always.
    pub fn no_directional_derivative<T>(&self) -> Answer<T> {
        self.check(Function::GetDirectionalDerivative)?;
        refuse(match self.version {
            Version::V2 => "providesDirectionalDerivative is false",
            Version::V3 => "providesDirectionalDerivatives and providesAdjointDerivatives are false",
        })
    }

    /// Returns how long \[s\] after the beginning of a communication step values are seen within it.
    ///
    /// # Errors
    /// Wrong phase, a communication point that is not the slave's time, or a step that is not
    /// positive, or goes beyond the stop time.
    pub(crate) fn points(&self, from: f64, step: f64, seen: bool) -> Answer<Vec<f64>> {
        self.check_step(from, step)?;
        Ok(if seen { self.model.points(step) } else { Vec::new() })
    }

    /// Begins the importer's callback within a step, if there are values to be seen: see [`Model::look_ahead`].
    pub(crate) fn look_ahead(&mut self, from: f64, so_far: f64, point: f64) -> bool {
        let seen = self.model.look_ahead(from, so_far, point).is_ok();
        if seen {
            (self.phase, self.time) = (Phase::Intermediate, from + point);
        }
        seen
    }

    /// Makes a communication step within which nobody looks. Returns the time \[s\] that was reached.
    ///
    /// # Errors
    /// It is not allowed, or the model refuses it, and nothing has changed; or it fails, and the
    /// slave is in the error state, in FMI 3.0 terminated.
    pub fn step(&mut self, from: f64, length: f64) -> Answer<f64> {
        self.check_step(from, length)?;
        self.do_step(Step::of(from, length), self.time)?;
        Ok(self.time)
    }

    /// Makes a communication step that was checked when the slave was at this time \[s\].
    ///
    /// # Errors
    /// The model refuses it, and nothing has changed; or it fails, and the slave is in the error state, in FMI 3.0
    /// terminated.
    pub(crate) fn do_step(&mut self, step: Step, time: f64) -> Answer<()> {
        (self.phase, self.time) = (Phase::StepComplete, time);
        match self.model.advance(step) {
            Ok(()) => {
                self.time = step.to;
                Ok(())
            }
            Err(StepError::Refused(error)) => discard(self.version, Err(error)),
            Err(StepError::Failed(error)) => {
                self.phase = if self.version == Version::V2 { Phase::Error } else { Phase::Terminated };
                Err(error)
            }
        }
    }

    /// Checks a communication step, before anything is changed.
    fn check_step(&self, from: f64, step: f64) -> Answer<()> {
        self.check(Function::DoStep)?;
        let step_size = || {
            refuse(format!(
                "a communication step of {step:?} s: must be positive and finite, and end at a finite time"
            ))
        };
        if !(step > 0.0 && step.is_finite()) {
            return step_size();
        }
        // Masters add up their own times. A difference of half a step is another communication
        // point.
        let tolerance = (1e-5 * from.abs().max(step)).min(0.5 * step);
        if (from - self.time).abs() > tolerance || from.is_nan() {
            return refuse(format!(
                "the communication point {from:?} s is not the slave's time {:?} s",
                self.time
            ));
        }
        if !(from + step).is_finite() {
            return step_size();
        }
        let stop = self.experiment.and_then(|experiment| experiment.stop);
        if let Some(stop) = stop.filter(|stop| from + step > stop + tolerance) {
            return refuse(format!(
                "a step from {from:?} s of {step:?} s goes beyond the stop time {stop:?} s"
            ));
        }
        Ok(())
    }
}

/// Returns the variables of FMI 3.0, by value reference.
fn rows_of_arrays<M: Model>() -> Vec<Row<M::Quantity>> {
    let other = |of, role| Row { quantity: None, element: 0, of, role, domain: Domain::Size };
    let sizes = M::SIZES.iter().map(|_| other(BaseType::Size, Role::Parameter));
    let arrays = M::VARIABLES.iter().map(|variable| Row::new(variable, 0));
    [other(BaseType::Real, Role::Calculated)].into_iter().chain(sizes).chain(arrays).collect()
}

/// Returns the structural parameters of FMI 3.0 for what is loaded.
fn sizes<M: Model>(model: &M, version: Version) -> Vec<u64> {
    let count = if version == Version::V3 { M::SIZES.len() } else { 0 };
    (0..count).map(|place| model.size(place)).collect()
}
