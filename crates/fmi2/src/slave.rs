//! One FMU instance without the C interface: lifecycle, variables, stepping and states.
//!
//! A call that is refused does not change the instance.

use crate::lifecycle::{Function, Phase, allowed};
use crate::model::{Model, StepError};
use crate::variables::{Domain, Kind, Role, Variable, guid};
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
        "the GUID {given:?} is not this FMU's {expected:?}: modelDescription.xml and resources do not belong together"
    )]
    Guid { given: String, expected: String },
    #[error("no variable of type {kind} has the value reference {reference}")]
    UnknownReference { kind: &'static str, reference: u32 },
    #[error("{name} = {value}: must be {must}")]
    Value { name: String, value: String, must: &'static str },
    #[error("{name} cannot be set {when}")]
    NotSettable { name: String, when: &'static str },
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
    model: S,
}

/// The part of a variable that every call needs, without what only messages need: calls read thousands of them.
#[derive(Clone, Copy)]
struct Row<Q> {
    quantity: Q,
    kind: BareKind,
    role: Role,
    domain: Domain,
}

/// A [`Kind`] without its unit.
#[derive(Clone, Copy, PartialEq, Eq)]
enum BareKind {
    Real,
    Integer,
    String,
}

impl BareKind {
    fn name(self) -> &'static str {
        match self {
            BareKind::Real => "Real",
            BareKind::Integer => "Integer",
            BareKind::String => "String",
        }
    }
}

impl<Q: Copy> Row<Q> {
    fn of(variable: &Variable<Q>) -> Row<Q> {
        let kind = match variable.kind {
            Kind::Real(_) => BareKind::Real,
            Kind::Integer => BareKind::Integer,
            Kind::String => BareKind::String,
        };
        Row { quantity: variable.quantity, kind, role: variable.role, domain: variable.domain }
    }
}

/// One FMU instance.
pub struct Slave<M: Model> {
    model: M,
    table: Vec<Variable<M::Quantity>>,
    /// The rows of `table`.
    rows: Vec<Row<M::Quantity>>,
    guid: Uuid,
    phase: Phase,
    time: f64,
    experiment: Option<Experiment>,
}

type Answer<M, T> = Result<T, SlaveError<<M as Model>::Error>>;

impl<M: Model> Slave<M> {
    /// Makes an instance of a model.
    ///
    /// # Errors
    /// The GUID is not that of the model.
    pub fn new(model: M, given_guid: &str) -> Answer<M, Slave<M>> {
        let table = model.table();
        let guid = guid(&table);
        let bare = |text: &str| text.trim_matches(['{', '}']).to_ascii_lowercase();
        if bare(given_guid) != guid.to_string() {
            let expected = guid.braced().to_string();
            return Err(SlaveError::Guid { given: given_guid.to_owned(), expected });
        }
        let rows = table.iter().map(Row::of).collect();
        Ok(Slave { model, table, rows, guid, phase: Phase::Instantiated, time: 0.0, experiment: None })
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
        if allowed(function).contains(&self.phase) {
            Ok(())
        } else {
            Err(SlaveError::NotAllowed { phase: self.phase })
        }
    }

    /// `fmi2SetupExperiment`: start time and, if given, stop time of the simulation \[s\].
    ///
    /// # Errors
    /// Wrong phase; times that are not finite or are in the wrong order.
    pub fn setup_experiment(&mut self, start: f64, stop: Option<f64>) -> Answer<M, ()> {
        self.check(Function::SetupExperiment)?;
        if !start.is_finite() {
            return Err(SlaveError::StartTime(start));
        }
        if let Some(stop) = stop.filter(|stop| !(stop.is_finite() && *stop >= start)) {
            return Err(SlaveError::StopTime { start, stop });
        }
        (self.experiment, self.time) = (Some(Experiment { start, stop }), start);
        Ok(())
    }

    /// `fmi2EnterInitializationMode`
    ///
    /// # Errors
    /// Wrong phase, or no start time.
    pub fn enter_initialization(&mut self) -> Answer<M, ()> {
        self.check(Function::EnterInitializationMode)?;
        self.experiment.ok_or(SlaveError::NoExperiment)?;
        self.phase = Phase::Initialization;
        Ok(())
    }

    /// `fmi2ExitInitializationMode`
    ///
    /// # Errors
    /// Wrong phase, or values that do not fit together.
    pub fn exit_initialization(&mut self) -> Answer<M, ()> {
        self.check(Function::ExitInitializationMode)?;
        self.model.initialize()?;
        self.phase = Phase::StepComplete;
        Ok(())
    }

    /// `fmi2Terminate`
    ///
    /// # Errors
    /// Wrong phase.
    pub fn terminate(&mut self) -> Answer<M, ()> {
        self.check(Function::Terminate)?;
        self.phase = Phase::Terminated;
        Ok(())
    }

    /// `fmi2Reset`: back to the state after instantiation.
    ///
    /// # Errors
    /// Wrong phase, or resources that can no longer be read.
    pub fn reset(&mut self) -> Answer<M, ()> {
        self.check(Function::Reset)?;
        self.model.reset()?;
        (self.phase, self.time, self.experiment) = (Phase::Instantiated, 0.0, None);
        Ok(())
    }

    #[inline]
    fn row(&self, reference: u32, kind: BareKind) -> Answer<M, Row<M::Quantity>> {
        match self.rows.get(reference as usize) {
            Some(row) if row.kind == kind => Ok(*row),
            _ => Err(SlaveError::UnknownReference { kind: kind.name(), reference }),
        }
    }

    /// For messages about a variable of the table.
    #[cold]
    fn name(&self, reference: u32) -> String {
        self.table[reference as usize].name.clone()
    }

    /// `fmi2GetReal`
    ///
    /// # Errors
    /// Wrong phase or unknown references; in initialization, values that do not fit together.
    pub fn get_real(&mut self, references: &[u32], values: &mut [f64]) -> Answer<M, ()> {
        self.check(Function::Get)?;
        for (&reference, value) in references.iter().zip(values) {
            let quantity = self.row(reference, BareKind::Real)?.quantity;
            *value = self.model.real(quantity)?;
        }
        Ok(())
    }

    /// `fmi2GetInteger`
    ///
    /// # Errors
    /// Those of [`Slave::get_real`].
    pub fn get_integer(&mut self, references: &[u32], values: &mut [i32]) -> Answer<M, ()> {
        self.check(Function::Get)?;
        for (&reference, value) in references.iter().zip(values) {
            let quantity = self.row(reference, BareKind::Integer)?.quantity;
            *value = self.model.integer(quantity)?;
        }
        Ok(())
    }

    /// `fmi2GetString`
    ///
    /// # Errors
    /// Wrong phase, unknown references.
    pub fn get_string(&self, references: &[u32]) -> Answer<M, Vec<&str>> {
        self.check(Function::Get)?;
        let texts = references.iter().map(|&reference| {
            let quantity = self.row(reference, BareKind::String)?.quantity;
            Ok(self.model.string(quantity))
        });
        texts.collect()
    }

    /// Refuses to set variables that cannot be set in this phase.
    #[inline]
    fn check_settable(&self, reference: u32, role: Role) -> Answer<M, ()> {
        if role == Role::Input {
            return Ok(());
        }
        let before = matches!(self.phase, Phase::Instantiated | Phase::Initialization);
        let when = match role {
            Role::Input => return Ok(()),
            Role::Parameter | Role::Exact if before => return Ok(()),
            Role::Parameter | Role::Exact => "after initialization",
            Role::Calculated => "at all: it is computed",
        };
        Err(SlaveError::NotSettable { name: self.name(reference), when })
    }

    #[inline]
    fn check_number(&self, reference: u32, kind: BareKind, value: f64) -> Answer<M, ()> {
        let row = self.row(reference, kind)?;
        self.check_settable(reference, row.role)?;
        row.domain.check(value).map_err(|must| SlaveError::Value {
            name: self.name(reference),
            value: if kind == BareKind::Integer { format!("{value:.0}") } else { format!("{value:?}") },
            must,
        })
    }

    /// `fmi2SetReal`
    ///
    /// # Errors
    /// Wrong phase, unknown references, or values outside their domain. Then none of them is set.
    pub fn set_real(&mut self, references: &[u32], values: &[f64]) -> Answer<M, ()> {
        self.check(Function::Set)?;
        for (&reference, &value) in references.iter().zip(values) {
            self.check_number(reference, BareKind::Real, value)?;
        }
        for (&reference, &value) in references.iter().zip(values) {
            let quantity = self.rows[reference as usize].quantity;
            self.model.set_real(reference, quantity, value, self.phase);
        }
        Ok(())
    }

    /// `fmi2SetInteger`
    ///
    /// # Errors
    /// Those of [`Slave::set_real`].
    pub fn set_integer(&mut self, references: &[u32], values: &[i32]) -> Answer<M, ()> {
        self.check(Function::Set)?;
        for (&reference, &value) in references.iter().zip(values) {
            self.check_number(reference, BareKind::Integer, value.into())?;
        }
        for (&reference, &value) in references.iter().zip(values) {
            self.model.set_integer(self.rows[reference as usize].quantity, value);
        }
        Ok(())
    }

    /// `fmi2SetString`
    ///
    /// # Errors
    /// Those of [`Slave::set_real`]; a text is not a value of its variable.
    pub fn set_string(&mut self, references: &[u32], values: &[&str]) -> Answer<M, ()> {
        self.check(Function::Set)?;
        let mut texts = Vec::with_capacity(references.len());
        for (&reference, &value) in references.iter().zip(values) {
            let row = self.row(reference, BareKind::String)?;
            self.check_settable(reference, row.role)?;
            texts.push((row.quantity, value));
        }
        Ok(self.model.set_strings(&texts)?)
    }

    /// `fmi2SetRealInputDerivatives`: over the next step the inputs vary linearly, at these rates per
    /// second, from their values at its start. A rate is used for one step.
    ///
    /// # Errors
    /// Wrong phase, unknown references, variables that are not inputs, orders other than 1, rates that are not finite,
    /// or a model that does not interpolate inputs. Then nothing is set.
    pub fn set_input_derivatives(
        &mut self,
        references: &[u32],
        orders: &[i32],
        values: &[f64],
    ) -> Answer<M, ()> {
        self.check(Function::SetRealInputDerivatives)?;
        if !M::INTERPOLATES_INPUTS {
            let why = "canInterpolateInputs is false: inputs are held over a step";
            return Err(SlaveError::Unsupported(why));
        }
        for ((&reference, &order), &value) in references.iter().zip(orders).zip(values) {
            let row = self.row(reference, BareKind::Real)?;
            if row.role != Role::Input {
                return Err(SlaveError::NoInput { name: self.name(reference) });
            }
            if order != 1 {
                return Err(SlaveError::Order { name: self.name(reference), order });
            }
            if !value.is_finite() {
                let name = format!("the derivative of {}", self.name(reference));
                return Err(SlaveError::Value { name, value: format!("{value:?}"), must: "finite" });
            }
        }
        for (&reference, &value) in references.iter().zip(values) {
            self.model.set_rate(self.rows[reference as usize].quantity, value);
        }
        Ok(())
    }

    /// `fmi2DoStep`: from the communication point `from` over `step`, both \[s\].
    ///
    /// # Errors
    /// Wrong phase, a communication point that is not the slave's time, or a step that is not positive, goes beyond the
    /// stop time, or is refused by the model. Then nothing has changed. If the model fails during the step, the slave is
    /// in the error state.
    pub fn do_step(&mut self, from: f64, step: f64) -> Answer<M, ()> {
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
        match self.model.advance(step, from + step) {
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

    /// `fmi2GetFMUstate`
    ///
    /// # Errors
    /// Wrong phase.
    pub fn snapshot(&self) -> Answer<M, Snapshot<M::Saved>> {
        self.check(Function::State)?;
        let (phase, time, experiment) = (self.phase, self.time, self.experiment);
        Ok(Snapshot { phase, time, experiment, model: self.model.save() })
    }

    /// `fmi2SetFMUstate`
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
        self.model.restore(&snapshot.model)?;
        (self.phase, self.time, self.experiment) = (snapshot.phase, snapshot.time, snapshot.experiment);
        Ok(())
    }

    /// `fmi2SerializeFMUstate`: a snapshot as bytes: magic number, version, GUID, length, content, checksum.
    ///
    /// # Errors
    /// The snapshot cannot be serialised.
    pub fn serialize(&self, snapshot: &Snapshot<M::Saved>) -> Answer<M, Vec<u8>> {
        let content =
            postcard::to_stdvec(snapshot).map_err(|_| SlaveError::Snapshot("it cannot be written"))?;
        let mut bytes = Vec::with_capacity(HEADER + content.len() + 4);
        bytes.extend_from_slice(MAGIC);
        bytes.extend_from_slice(&Self::version().to_le_bytes());
        bytes.extend_from_slice(self.guid.as_bytes());
        bytes.extend_from_slice(&(content.len() as u64).to_le_bytes());
        bytes.extend_from_slice(&content);
        let checksum = crc32fast::hash(&bytes);
        bytes.extend_from_slice(&checksum.to_le_bytes());
        Ok(bytes)
    }

    /// `fmi2DeSerializeFMUstate`
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
        if take(12, 16)? != self.guid.as_bytes() {
            return Err(SlaveError::OtherModel("it was saved by an FMU with another GUID"));
        }
        let length = take(28, 8)?.try_into().map(u64::from_le_bytes).unwrap_or(u64::MAX);
        // Importers may pass a buffer longer than the written state.
        let end = usize::try_from(length).ok().and_then(|length| HEADER.checked_add(length));
        let end = end.filter(|end| *end < bytes.len()).ok_or(SlaveError::Snapshot("it is cut off"))?;
        if take(end, 4)? != crc32fast::hash(&bytes[..end]).to_le_bytes() {
            return Err(SlaveError::Snapshot("its checksum is wrong"));
        }
        postcard::from_bytes(&bytes[HEADER..end])
            .map_err(|_| SlaveError::Snapshot("its content is malformed"))
    }

    /// The versions of this format and of the model, in one number.
    fn version() -> u32 {
        FORMAT << 16 | M::STATE_VERSION
    }
}

const MAGIC: &[u8; 8] = b"LEMONSst";
/// Increased whenever [`Snapshot`] changes.
const FORMAT: u32 = 2;
/// Magic, version, GUID, length.
const HEADER: usize = 8 + 4 + 16 + 8;
