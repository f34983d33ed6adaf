//! One FMU instance without the C interface: lifecycle, stepping and states, for every version of FMI. How its variables
//! are read and set is in [`v2`](crate::v2) and [`v3`](crate::v3).
//!
//! A call that is refused does not change the instance.

use crate::lifecycle::{Function, Phase};
use crate::model::{Model, StepError};
use crate::variables::{Domain, Kind, Role};
use serde::{Deserialize, Serialize};
use thiserror::Error;
use uuid::Uuid;

/// Why a call was refused or failed; `E` is the error type of the model.
#[derive(Debug, Error)]
#[allow(missing_docs)] // the messages say it
pub enum SlaveError<E> {
    #[error("not allowed in the state {phase:?}")]
    NotAllowed { phase: Phase },
    #[error(
        "the {word} {given:?} is not this FMU's {expected:?}: modelDescription.xml and resources do not belong together"
    )]
    Token { word: &'static str, given: String, expected: String },
    #[error("no variable of type {kind} has the value reference {reference}")]
    UnknownReference { kind: &'static str, reference: u32 },
    #[error("{name} = {value}: must be {must}")]
    Value { name: String, value: String, must: &'static str },
    #[error("{name} cannot be set {when}")]
    NotSettable { name: String, when: &'static str },
    #[error("{given} values for variables of {wanted} elements together")]
    ValueCount { given: usize, wanted: u64 },
    #[error(
        "{name} is {declared}, but what is loaded has {loaded}: choose what to load, or set {name} in Configuration Mode"
    )]
    Size { name: &'static str, declared: u64, loaded: u64 },
    #[error("{name} = {value}: must be at least 1 and at most {most}")]
    SizeValue { name: &'static str, value: u64, most: u64 },
    #[error("{name}: its derivative is not known, only those of continuous motion are")]
    NoDerivative { name: String },
    #[error("the derivative of order {order} of {name}: only order 1 is known")]
    OutputOrder { name: String, order: i32 },
    #[error("{name} is not an input, so its derivative cannot be set")]
    NoInput { name: String },
    #[error("the derivative of order {order} of {name}: inputs are interpolated with order 1")]
    Order { name: String, order: i32 },
    #[error("fmi2SetupExperiment has not been called")]
    NoExperiment,
    #[error("start time {0:?}: must be finite")]
    StartTime(f64),
    #[error("stop time {stop:?} s: must be finite and not before the start time {start:?} s")]
    StopTime { start: f64, stop: f64 },
    #[error("a tolerance of {0:?}: must be positive and finite, or not defined")]
    Tolerance(f64),
    #[error("a communication step of {0:?} s: must be positive and finite, and end at a finite time")]
    StepSize(f64),
    #[error("the communication point {given:?} s is not the slave's time {expected:?} s")]
    CommunicationPoint { given: f64, expected: f64 },
    #[error("a step from {from:?} s of {step:?} s goes beyond the stop time {stop:?} s")]
    BeyondStopTime { from: f64, step: f64, stop: f64 },
    #[error("the state is damaged or is not a state of this FMU: {0}")]
    Snapshot(&'static str),
    #[error("the state belongs to another model: {0}")]
    OtherModel(&'static str),
    #[error("{0}")]
    Unsupported(&'static str),
    #[error(transparent)]
    Model(#[from] E),
}

/// Start time and, if given, stop time of the simulation \[s\].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
struct Experiment {
    start: f64,
    stop: Option<f64>,
}

/// The complete state of an instance without the location of its resources: FMI's "FMU state".
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Snapshot<S> {
    phase: Phase,
    time: f64,
    experiment: Option<Experiment>,
    /// FMI 3.0: the structural parameters.
    sizes: Vec<u64>,
    model: S,
}

/// What differs between the versions of FMI.
pub trait Interface<M: Model>: Sized {
    /// The standard's word for the token: GUID or instantiationToken.
    const TOKEN: &'static str;

    /// Whether bytes may follow those of a state: importers of FMI 2.0 pass buffers that are longer.
    const LONGER_STATES: bool;

    /// The interface of a model.
    fn of(model: &M) -> Self;

    /// Identifies the interface: it depends on names, types, value references and causalities only.
    fn token(&self) -> Uuid;

    /// Returns the states in which the standard allows a function.
    fn allowed(function: Function) -> &'static [Phase];

    /// Returns the values of the structural parameters, if there are any.
    fn sizes(&self) -> &[u64] {
        &[]
    }

    /// Sets all structural parameters. Returns whether they can have these values.
    fn set_sizes(&mut self, sizes: &[u64]) -> bool {
        sizes.is_empty()
    }
}

/// One FMU instance.
pub struct Slave<M: Model, I: Interface<M>> {
    pub(crate) model: M,
    pub(crate) interface: I,
    token: Uuid,
    pub(crate) phase: Phase,
    time: f64,
    experiment: Option<Experiment>,
}

/// The result of a call.
pub(crate) type Answer<M, T> = Result<T, SlaveError<<M as Model>::Error>>;

impl<M: Model, I: Interface<M>> Slave<M, I> {
    /// Makes an instance of a model.
    ///
    /// # Errors
    /// The token is not that of the model.
    pub fn new(model: M, given: &str) -> Answer<M, Slave<M, I>> {
        let interface = I::of(&model);
        let token = interface.token();
        let bare = |text: &str| text.trim_matches(['{', '}']).to_ascii_lowercase();
        if bare(given) != token.to_string() {
            let expected = token.braced().to_string();
            return Err(SlaveError::Token { word: I::TOKEN, given: given.to_owned(), expected });
        }
        Ok(Slave { model, interface, token, phase: Phase::Instantiated, time: 0.0, experiment: None })
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
    pub fn check(&self, function: Function) -> Answer<M, ()> {
        if I::allowed(function).contains(&self.phase) {
            Ok(())
        } else {
            Err(SlaveError::NotAllowed { phase: self.phase })
        }
    }

    /// `fmi2SetupExperiment`: start time and, if given, stop time of the simulation \[s\], and tolerance.
    ///
    /// # Errors
    /// Wrong phase; times that are not finite or are in the wrong order; a tolerance that is not positive and finite.
    pub fn setup_experiment(
        &mut self,
        start: f64,
        stop: Option<f64>,
        tolerance: Option<f64>,
    ) -> Answer<M, ()> {
        self.check(Function::SetupExperiment)?;
        self.set_experiment(start, stop, tolerance)
    }

    /// Sets start time and, if given, stop time \[s\] and tolerance.
    pub(crate) fn set_experiment(
        &mut self,
        start: f64,
        stop: Option<f64>,
        tolerance: Option<f64>,
    ) -> Answer<M, ()> {
        if let Some(tolerance) = tolerance.filter(|tolerance| !(*tolerance > 0.0 && tolerance.is_finite())) {
            return Err(SlaveError::Tolerance(tolerance));
        }
        if !start.is_finite() {
            return Err(SlaveError::StartTime(start));
        }
        if let Some(stop) = stop.filter(|stop| !(stop.is_finite() && *stop >= start)) {
            return Err(SlaveError::StopTime { start, stop });
        }
        (self.experiment, self.time) = (Some(Experiment { start, stop }), start);
        self.model.set_tolerance(tolerance);
        Ok(())
    }

    /// Enters Initialization Mode.
    ///
    /// # Errors
    /// Wrong phase, or no start time.
    pub fn enter_initialization(&mut self) -> Answer<M, ()> {
        self.check(Function::EnterInitializationMode)?;
        self.experiment.ok_or(SlaveError::NoExperiment)?;
        self.phase = Phase::Initialization;
        Ok(())
    }

    /// Leaves Initialization Mode.
    ///
    /// # Errors
    /// Wrong phase, or values that do not fit together.
    pub fn exit_initialization(&mut self) -> Answer<M, ()> {
        self.check(Function::ExitInitializationMode)?;
        self.model.initialize(self.time)?;
        self.phase = Phase::StepComplete;
        Ok(())
    }

    /// Ends the simulation.
    ///
    /// # Errors
    /// Wrong phase.
    pub fn terminate(&mut self) -> Answer<M, ()> {
        self.check(Function::Terminate)?;
        self.phase = Phase::Terminated;
        Ok(())
    }

    /// Goes back to the state after instantiation.
    ///
    /// # Errors
    /// Wrong phase, or resources that can no longer be read.
    pub fn reset(&mut self) -> Answer<M, ()> {
        self.check(Function::Reset)?;
        self.model.reset()?;
        self.interface = I::of(&self.model);
        (self.phase, self.time, self.experiment) = (Phase::Instantiated, 0.0, None);
        Ok(())
    }

    /// A communication step: from the communication point `from` over `step`, both \[s\].
    ///
    /// # Errors
    /// Wrong phase, a communication point that is not the slave's time, or a step that is not positive, goes beyond the
    /// stop time, or is refused by the model. Then nothing has changed. If the model fails during the step, the slave is
    /// in the error state.
    pub fn do_step(&mut self, from: f64, step: f64) -> Answer<M, ()> {
        self.check_step(from, step)?;
        match self.model.advance(from, step) {
            Ok(()) => {
                self.time = from + step;
                Ok(())
            }
            Err(StepError::Refused(error)) => Err(error.into()),
            Err(StepError::Failed(error)) => {
                self.phase = Phase::Error;
                Err(error.into())
            }
        }
    }

    /// Checks a communication step, before anything is changed.
    pub(crate) fn check_step(&self, from: f64, step: f64) -> Answer<M, ()> {
        self.check(Function::DoStep)?;
        if !(step > 0.0 && step.is_finite()) {
            return Err(SlaveError::StepSize(step));
        }
        // Masters add up their own times. A difference of half a step is another communication point.
        let tolerance = (1e-5 * from.abs().max(step)).min(0.5 * step);
        if (from - self.time).abs() > tolerance || from.is_nan() {
            return Err(SlaveError::CommunicationPoint { given: from, expected: self.time });
        }
        if !(from + step).is_finite() {
            return Err(SlaveError::StepSize(step));
        }
        let stop = self.experiment.and_then(|experiment| experiment.stop);
        if let Some(stop) = stop.filter(|stop| from + step > stop + tolerance) {
            return Err(SlaveError::BeyondStopTime { from, step, stop });
        }
        Ok(())
    }

    /// Takes the time at the end of a step \[s\].
    pub(crate) fn set_time(&mut self, time: f64) {
        self.time = time;
    }

    /// Saves the state.
    ///
    /// # Errors
    /// Wrong phase.
    pub fn snapshot(&self) -> Answer<M, Snapshot<M::Saved>> {
        self.check(Function::State)?;
        let (phase, time, experiment) = (self.phase, self.time, self.experiment);
        let sizes = self.interface.sizes().to_vec();
        Ok(Snapshot { phase, time, experiment, sizes, model: self.model.save() })
    }

    /// Restores a state.
    ///
    /// # Errors
    /// Wrong phase, a snapshot of another model, or one with impossible times. Then nothing has changed.
    pub fn restore(&mut self, snapshot: &Snapshot<M::Saved>) -> Answer<M, ()> {
        self.check(Function::State)?;
        let possible = snapshot.experiment.is_none_or(|Experiment { start, stop }| {
            start.is_finite() && stop.is_none_or(|stop| stop.is_finite() && stop >= start)
        });
        if !(possible && snapshot.time.is_finite()) {
            return Err(SlaveError::Snapshot("a time that is not possible"));
        }
        if !I::allowed(Function::State).contains(&snapshot.phase) {
            return Err(SlaveError::Snapshot("a phase that is not possible"));
        }
        let before = self.interface.sizes().to_vec();
        if !self.interface.set_sizes(&snapshot.sizes) {
            return Err(SlaveError::Snapshot("sizes that are not possible"));
        }
        if let Err(error) = self.model.restore(&snapshot.model) {
            self.interface.set_sizes(&before);
            return Err(error.into());
        }
        (self.phase, self.time, self.experiment) = (snapshot.phase, snapshot.time, snapshot.experiment);
        Ok(())
    }

    /// Returns a snapshot as bytes: magic number, version, token, length, content, checksum.
    ///
    /// # Errors
    /// The snapshot cannot be serialised.
    pub fn serialize(&self, snapshot: &Snapshot<M::Saved>) -> Answer<M, Vec<u8>> {
        let content =
            postcard::to_stdvec(snapshot).map_err(|_| SlaveError::Snapshot("it cannot be written"))?;
        let mut bytes = Vec::with_capacity(HEADER + content.len() + 4);
        bytes.extend_from_slice(MAGIC);
        bytes.extend_from_slice(&Self::version().to_le_bytes());
        bytes.extend_from_slice(self.token.as_bytes());
        bytes.extend_from_slice(&(content.len() as u64).to_le_bytes());
        bytes.extend_from_slice(&content);
        let checksum = crc32fast::hash(&bytes);
        bytes.extend_from_slice(&checksum.to_le_bytes());
        Ok(bytes)
    }

    /// Reads a snapshot from bytes.
    ///
    /// # Errors
    /// The bytes are damaged, or belong to another version or another model.
    pub fn deserialize(&self, bytes: &[u8]) -> Answer<M, Snapshot<M::Saved>> {
        self.check(Function::State)?;
        let take = |from: usize, length: usize| {
            bytes.get(from..from + length).ok_or(SlaveError::Snapshot("it is cut off"))
        };
        if take(0, 8)? != MAGIC {
            return Err(SlaveError::Snapshot("it does not begin like a state"));
        }
        if take(8, 4)? != Self::version().to_le_bytes() {
            return Err(SlaveError::Snapshot("another version of the format"));
        }
        if take(12, 16)? != self.token.as_bytes() {
            return Err(SlaveError::OtherModel("it was saved by an FMU with another GUID"));
        }
        let length = take(28, 8)?.try_into().map(u64::from_le_bytes).unwrap_or(u64::MAX);
        let end = usize::try_from(length).ok().and_then(|length| HEADER.checked_add(length));
        let end = end.filter(|end| *end < bytes.len()).ok_or(SlaveError::Snapshot("it is cut off"))?;
        if take(end, 4)? != crc32fast::hash(&bytes[..end]).to_le_bytes() {
            return Err(SlaveError::Snapshot("its checksum is wrong"));
        }
        if bytes.len() > end + 4 && !I::LONGER_STATES {
            return Err(SlaveError::Snapshot("bytes follow it"));
        }
        match postcard::take_from_bytes(&bytes[HEADER..end]) {
            Ok((snapshot, [])) => Ok(snapshot),
            _ => Err(SlaveError::Snapshot("its content is malformed")),
        }
    }

    /// The versions of this format and of the model, in one number.
    fn version() -> u32 {
        FORMAT << 16 | M::STATE_VERSION
    }
}

/// The part of a variable that every call needs, without what only messages need: calls read thousands of them.
#[derive(Clone, Copy)]
pub(crate) struct Row<Q> {
    pub quantity: Q,
    pub kind: BareKind,
    pub role: Role,
    pub domain: Domain,
}

/// A [`Kind`] without its unit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum BareKind {
    Real,
    Integer,
    Boolean,
    String,
}

impl From<Kind> for BareKind {
    fn from(kind: Kind) -> BareKind {
        match kind {
            Kind::Real(_) => BareKind::Real,
            Kind::Integer => BareKind::Integer,
            Kind::Boolean => BareKind::Boolean,
            Kind::String => BareKind::String,
        }
    }
}

/// Why a variable of a role cannot be set in a phase, as the end of "… cannot be set …"; `None` if it can.
#[inline]
pub(crate) fn not_settable(role: Role, phase: Phase) -> Option<&'static str> {
    let before = matches!(phase, Phase::Instantiated | Phase::Initialization);
    match role {
        Role::Input => None,
        Role::Parameter | Role::Exact if before => None,
        Role::Parameter | Role::Exact => Some("after initialization"),
        Role::Calculated | Role::CalculatedParameter => Some("at all: it is computed"),
    }
}

const MAGIC: &[u8; 8] = b"LEMONSst";
/// Increased whenever [`Snapshot`] changes.
const FORMAT: u32 = 3;
/// Magic, version, token, length.
const HEADER: usize = 8 + 4 + 16 + 8;
