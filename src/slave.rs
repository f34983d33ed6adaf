//! One FMU instance, whatever the C interface: lifecycle, variables, stepping, snapshot.
//!
//! The instance holds a Trial's documents; a parameter is an edit of them, and when initialization
//! ends they become the engine's world. Every refused call leaves everything as it was.

use crate::engine::{AdvanceError, State, World, Wrench};
use crate::files::{WriteError, write_atomically};
use crate::resources::{Resources, ResourcesError};
use crate::trial::{Drive, Trial, WorldError, dynamics_of, dynamics_xml, interactions_of, interactions_xml};
use crate::variables::{
    AgentQuantity, Kind, Quantity, Role, Variable, guid, in_documents, in_documents_mut, table,
};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;
use thiserror::Error;
use uuid::Uuid;

/// The slave's states (FMI 2.0, section 4.2.4). A slave that steps synchronously knows no others.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Phase {
    /// After `fmi2Instantiate` or `fmi2Reset`.
    Instantiated,
    /// Between `fmi2EnterInitializationMode` and `fmi2ExitInitializationMode`.
    Initialization,
    /// Ready for the next step.
    StepComplete,
    /// After `fmi2Terminate`.
    Terminated,
    /// After a step that failed.
    Error,
}

/// The functions whose use depends on the phase.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(missing_docs)] // FMI's own names
pub enum Function {
    SetDebugLogging,
    SetupExperiment,
    EnterInitializationMode,
    ExitInitializationMode,
    Terminate,
    Reset,
    Get,
    Set,
    State,
    GetDirectionalDerivative,
    SetRealInputDerivatives,
    GetRealOutputDerivatives,
    DoStep,
    CancelStep,
    GetStatus,
}

/// Where FMI 2.0 (section 4.2.4) allows a function.
pub fn allowed(function: Function) -> &'static [Phase] {
    use Phase::*;
    match function {
        Function::SetDebugLogging | Function::Reset | Function::State => {
            &[Instantiated, Initialization, StepComplete, Terminated, Error]
        }
        Function::SetupExperiment | Function::EnterInitializationMode => &[Instantiated],
        Function::ExitInitializationMode => &[Initialization],
        Function::Terminate | Function::DoStep => &[StepComplete],
        Function::Get | Function::GetDirectionalDerivative => {
            &[Initialization, StepComplete, Terminated, Error]
        }
        Function::Set | Function::SetRealInputDerivatives => &[Instantiated, Initialization, StepComplete],
        Function::GetRealOutputDerivatives => &[StepComplete, Terminated, Error],
        // A synchronous slave is never in the middle of a step.
        Function::CancelStep => &[],
        Function::GetStatus => &[StepComplete, Terminated],
    }
}

/// Why a call was refused or failed.
#[derive(Debug, Error)]
#[allow(missing_docs)] // the messages say it
pub enum SlaveError {
    #[error("not allowed in the state {phase:?}")]
    NotAllowed { phase: Phase },
    #[error(
        "the GUID {given:?} is not this FMU's {expected:?}: modelDescription.xml and resources do not belong together"
    )]
    Guid { given: String, expected: String },
    #[error(transparent)]
    Resources(#[from] ResourcesError),
    #[error("no variable of type {kind} has the value reference {reference}")]
    UnknownReference { kind: &'static str, reference: u32 },
    #[error("{name} = {value}: must be {must}")]
    Value { name: String, value: String, must: String },
    #[error("{name} cannot be set {when}")]
    NotSettable { name: String, when: &'static str },
    #[error("{0}")]
    World(#[from] WorldError),
    #[error("start time {0:?}: must be finite")]
    StartTime(f64),
    #[error("stop time {stop:?} s: must be finite and not before the start time {start:?} s")]
    StopTime { start: f64, stop: f64 },
    #[error("the communication point {given:?} s is not the slave's time {expected:?} s")]
    CommunicationPoint { given: f64, expected: f64 },
    #[error("a step from {from:?} s of {step:?} s goes beyond the stop time {stop:?} s")]
    BeyondStopTime { from: f64, step: f64, stop: f64 },
    #[error("{0}")]
    Advance(String),
    #[error("OutputDirectory: {0}")]
    Output(#[from] WriteError),
    #[error("the state is damaged or not one of this FMU: {0}")]
    Snapshot(&'static str),
    #[error("the state belongs to another model: {0}")]
    OtherModel(String),
    #[error("{0}")]
    Unsupported(&'static str),
}

/// A variable's value as it was set, by its place in the table.
type Settings = BTreeMap<u32, f64>;

/// All that an instance is, apart from where its resources lie: FMI's "FMU state".
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Snapshot {
    trial: String,
    fingerprint: u128,
    settings: Settings,
    threads: i32,
    output_directory: String,
    phase: Phase,
    time: f64,
    start_time: f64,
    stop_time: Option<f64>,
    running: Option<Running>,
}

/// What a running world's future depends on.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Running {
    drive: Vec<Wrench>,
    state: State,
}

/// One FMU instance.
pub struct Slave {
    resources: Resources,
    table: Arc<[Variable]>,
    guid: Uuid,
    /// As packed: what `fmi2Reset` and another choice of Trial start from.
    packed: Arc<Trial>,
    /// Of `packed`.
    fingerprint: u128,
    /// With the settings of this instance.
    trial: Trial,
    settings: Settings,
    threads: i32,
    output_directory: String,
    phase: Phase,
    time: f64,
    start_time: f64,
    stop_time: Option<f64>,
    /// Made when initialization ends, or earlier when somebody asks for a computed output.
    world: Option<World>,
    /// Not yet told.
    warnings: Vec<String>,
}

impl Slave {
    /// A new instance on the packed resources.
    ///
    /// # Errors
    /// Resources that are missing or broken, or a GUID that is not theirs.
    pub fn new(resources: Resources, given_guid: &str) -> Result<Slave, SlaveError> {
        let (packed, warnings) = resources.load(resources.first())?;
        let table: Arc<[Variable]> = table(&packed).into();
        let guid = guid(&table);
        let bare = |text: &str| text.trim_matches(['{', '}']).to_ascii_lowercase();
        if bare(given_guid) != guid.to_string() {
            let expected = guid.braced().to_string();
            return Err(SlaveError::Guid { given: given_guid.to_owned(), expected });
        }
        Ok(Slave {
            resources,
            table,
            guid,
            trial: packed.clone(),
            fingerprint: packed.fingerprint().as_u128(),
            packed: Arc::new(packed),
            settings: Settings::new(),
            threads: 1,
            output_directory: String::new(),
            phase: Phase::Instantiated,
            time: 0.0,
            start_time: 0.0,
            stop_time: None,
            world: None,
            warnings,
        })
    }

    /// The present phase.
    pub fn phase(&self) -> Phase {
        self.phase
    }

    /// \[s\] the present communication point.
    pub fn time(&self) -> f64 {
        self.time
    }

    /// Warnings since they were last taken.
    pub fn take_warnings(&mut self) -> Vec<String> {
        std::mem::take(&mut self.warnings)
    }

    /// Whether the phase allows a function.
    ///
    /// # Errors
    /// It does not.
    pub fn check(&self, function: Function) -> Result<(), SlaveError> {
        if allowed(function).contains(&self.phase) {
            Ok(())
        } else {
            Err(SlaveError::NotAllowed { phase: self.phase })
        }
    }

    /// `fmi2SetupExperiment`: when the simulation begins and, perhaps, ends \[s\].
    ///
    /// # Errors
    /// Wrong phase, times that are not finite or in the wrong order.
    pub fn setup_experiment(&mut self, start: f64, stop: Option<f64>) -> Result<(), SlaveError> {
        self.check(Function::SetupExperiment)?;
        if !start.is_finite() {
            return Err(SlaveError::StartTime(start));
        }
        if let Some(stop) = stop.filter(|stop| !(stop.is_finite() && *stop >= start)) {
            return Err(SlaveError::StopTime { start, stop });
        }
        (self.start_time, self.stop_time, self.time) = (start, stop, start);
        Ok(())
    }

    /// `fmi2EnterInitializationMode`
    ///
    /// # Errors
    /// Wrong phase.
    pub fn enter_initialization(&mut self) -> Result<(), SlaveError> {
        self.check(Function::EnterInitializationMode)?;
        self.phase = Phase::Initialization;
        Ok(())
    }

    /// `fmi2ExitInitializationMode`: the documents become a world.
    ///
    /// # Errors
    /// Wrong phase, parameters that together make no world, an output directory that cannot be made.
    pub fn exit_initialization(&mut self) -> Result<(), SlaveError> {
        self.check(Function::ExitInitializationMode)?;
        self.make_world()?;
        if !self.output_directory.is_empty() {
            let directory = Path::new(&self.output_directory);
            std::fs::create_dir_all(directory).map_err(WriteError::at(directory))?;
        }
        self.phase = Phase::StepComplete;
        Ok(())
    }

    /// `fmi2Terminate`
    ///
    /// # Errors
    /// Wrong phase.
    pub fn terminate(&mut self) -> Result<(), SlaveError> {
        self.check(Function::Terminate)?;
        self.phase = Phase::Terminated;
        Ok(())
    }

    /// `fmi2Reset`: back to the state after instantiation.
    ///
    /// # Errors
    /// Wrong phase, or resources that have become unreadable.
    pub fn reset(&mut self) -> Result<(), SlaveError> {
        self.check(Function::Reset)?;
        if self.packed.name != self.resources.first() {
            self.packed = Arc::new(self.resources.load(self.resources.first())?.0);
            self.fingerprint = self.packed.fingerprint().as_u128();
        }
        self.trial = (*self.packed).clone();
        self.settings.clear();
        self.threads = 1;
        self.output_directory.clear();
        self.phase = Phase::Instantiated;
        (self.time, self.start_time, self.stop_time) = (0.0, 0.0, None);
        self.world = None;
        Ok(())
    }

    fn make_world(&mut self) -> Result<&mut World, SlaveError> {
        if self.world.is_none() {
            self.world = Some(self.trial.world()?);
        }
        Ok(self.world.as_mut().expect("made above"))
    }

    fn variable(
        &self,
        reference: u32,
        matches: fn(Kind) -> bool,
        kind: &'static str,
    ) -> Result<&Variable, SlaveError> {
        self.table
            .get(reference as usize)
            .filter(|variable| matches(variable.kind))
            .ok_or(SlaveError::UnknownReference { kind, reference })
    }

    fn real(&self, reference: u32) -> Result<&Variable, SlaveError> {
        self.variable(reference, |kind| matches!(kind, Kind::Real(_)), "Real")
    }

    fn integer(&self, reference: u32) -> Result<&Variable, SlaveError> {
        self.variable(reference, |kind| kind == Kind::Integer, "Integer")
    }

    fn string(&self, reference: u32) -> Result<&Variable, SlaveError> {
        self.variable(reference, |kind| kind == Kind::String, "String")
    }

    /// `fmi2GetReal`
    ///
    /// # Errors
    /// Wrong phase, unknown references; in initialization, parameters that make no world.
    pub fn get_real(&mut self, references: &[u32], values: &mut [f64]) -> Result<(), SlaveError> {
        self.check(Function::Get)?;
        for (&reference, value) in references.iter().zip(values) {
            let quantity = self.real(reference)?.quantity;
            *value = match in_documents(&self.trial, quantity) {
                Some(document) => self.in_world(quantity).unwrap_or(document),
                None => self.computed(quantity)?,
            };
        }
        Ok(())
    }

    /// A number that the running world holds.
    fn in_world(&self, quantity: Quantity) -> Option<f64> {
        let (world, Quantity::Agent(i, quantity)) = (self.world.as_ref()?, quantity) else { return None };
        let (pose, twist) = (&world.state().poses[i], &world.state().twists[i]);
        let drive = &world.drive[i];
        match quantity {
            AgentQuantity::FpX => Some(drive.force.x),
            AgentQuantity::FpY => Some(drive.force.y),
            AgentQuantity::Mp => Some(drive.torque),
            AgentQuantity::PositionX => Some(pose.position.x),
            AgentQuantity::PositionY => Some(pose.position.y),
            AgentQuantity::Theta => Some(pose.orientation),
            AgentQuantity::VelocityX => Some(twist.velocity.x),
            AgentQuantity::VelocityY => Some(twist.velocity.y),
            AgentQuantity::Omega => Some(twist.angular_velocity),
            _ => None,
        }
    }

    /// A number that the world's contacts give.
    fn computed(&mut self, quantity: Quantity) -> Result<f64, SlaveError> {
        let contacts = self.make_world()?.contacts();
        Ok(match quantity {
            Quantity::AgentContacts => f64::from(contacts.agent_contacts),
            Quantity::WallContacts => f64::from(contacts.wall_contacts),
            Quantity::Agent(i, AgentQuantity::AgentContacts) => f64::from(contacts.bodies[i].agent_contacts),
            Quantity::Agent(i, AgentQuantity::WallContacts) => f64::from(contacts.bodies[i].wall_contacts),
            Quantity::Agent(i, AgentQuantity::ContactingAgents) => {
                f64::from(contacts.bodies[i].touching_bodies)
            }
            Quantity::Agent(i, AgentQuantity::NormalForce) => contacts.bodies[i].squeeze,
            _ => return Err(SlaveError::Unsupported("this quantity is not a number")),
        })
    }

    /// `fmi2GetInteger`
    ///
    /// # Errors
    /// As [`Slave::get_real`].
    pub fn get_integer(&mut self, references: &[u32], values: &mut [i32]) -> Result<(), SlaveError> {
        self.check(Function::Get)?;
        for (&reference, value) in references.iter().zip(values) {
            let quantity = self.integer(reference)?.quantity;
            *value = match quantity {
                Quantity::Threads => self.threads,
                quantity => self.computed(quantity)? as i32,
            };
        }
        Ok(())
    }

    /// `fmi2GetString`
    ///
    /// # Errors
    /// Wrong phase, unknown references.
    pub fn get_string(&self, references: &[u32]) -> Result<Vec<&str>, SlaveError> {
        self.check(Function::Get)?;
        let value = |&reference: &u32| {
            Ok(match self.string(reference)?.quantity {
                Quantity::Trial => self.packed.name.as_str(),
                _ => self.output_directory.as_str(),
            })
        };
        references.iter().map(value).collect()
    }

    /// Whether a variable can be set in the present phase.
    fn check_settable(&self, variable: &Variable) -> Result<(), SlaveError> {
        let before = matches!(self.phase, Phase::Instantiated | Phase::Initialization);
        let when = match variable.role {
            Role::Input => return Ok(()),
            Role::Parameter | Role::Exact if before => return Ok(()),
            Role::Parameter | Role::Exact => "after initialization",
            Role::Calculated => "ever: it is computed",
        };
        Err(SlaveError::NotSettable { name: variable.name.clone(), when })
    }

    fn refused(variable: &Variable, value: impl std::fmt::Debug, must: impl Into<String>) -> SlaveError {
        SlaveError::Value { name: variable.name.clone(), value: format!("{value:?}"), must: must.into() }
    }

    /// `fmi2SetReal`
    ///
    /// # Errors
    /// Wrong phase, unknown references, values out of their domain; then none of them is set.
    pub fn set_real(&mut self, references: &[u32], values: &[f64]) -> Result<(), SlaveError> {
        self.check(Function::Set)?;
        for (&reference, &value) in references.iter().zip(values) {
            let variable = self.real(reference)?;
            self.check_settable(variable)?;
            variable.domain.check(value).map_err(|must| Self::refused(variable, value, must))?;
        }
        for (&reference, &value) in references.iter().zip(values) {
            let quantity = self.table[reference as usize].quantity;
            match (&mut self.world, quantity) {
                (Some(world), Quantity::Agent(i, AgentQuantity::FpX)) => world.drive[i].force.x = value,
                (Some(world), Quantity::Agent(i, AgentQuantity::FpY)) => world.drive[i].force.y = value,
                (Some(world), Quantity::Agent(i, AgentQuantity::Mp)) => world.drive[i].torque = value,
                (world, _) => *world = None,
            }
            if self.phase != Phase::StepComplete {
                if let Some(place) = in_documents_mut(&mut self.trial, quantity) {
                    *place = value;
                }
                self.settings.insert(reference, value);
            }
        }
        Ok(())
    }

    /// `fmi2SetInteger`
    ///
    /// # Errors
    /// As [`Slave::set_real`].
    pub fn set_integer(&mut self, references: &[u32], values: &[i32]) -> Result<(), SlaveError> {
        self.check(Function::Set)?;
        for (&reference, &value) in references.iter().zip(values) {
            let variable = self.integer(reference)?;
            self.check_settable(variable)?;
            variable.domain.check(value.into()).map_err(|must| Self::refused(variable, value, must))?;
        }
        if let Some(&threads) = values.last() {
            self.threads = threads;
        }
        Ok(())
    }

    /// `fmi2SetString`
    ///
    /// # Errors
    /// As [`Slave::set_real`]; a Trial that is not packed or has another interface.
    pub fn set_string(&mut self, references: &[u32], values: &[&str]) -> Result<(), SlaveError> {
        self.check(Function::Set)?;
        let mut chosen = None;
        let mut output_directory = None;
        for (&reference, &value) in references.iter().zip(values) {
            let variable = self.string(reference)?;
            self.check_settable(variable)?;
            if variable.quantity != Quantity::Trial {
                output_directory = Some(value);
            } else if !self.resources.names().iter().any(|name| name == value) {
                let names = self.resources.names().join(", ");
                return Err(Self::refused(variable, value, format!("one of the packed Trials: {names}")));
            } else {
                chosen = Some(value);
            }
        }
        if let Some(name) = chosen.filter(|name| *name != self.packed.name) {
            self.choose(name)?;
        }
        if let Some(directory) = output_directory {
            self.output_directory = directory.to_owned();
        }
        Ok(())
    }

    /// Loads another packed Trial; what was set stays set.
    fn choose(&mut self, name: &str) -> Result<(), SlaveError> {
        let (packed, warnings) = self.resources.load(name)?;
        if guid(&table(&packed)) != self.guid {
            return Err(SlaveError::OtherModel(format!("Trial {name:?} has other variables than this FMU")));
        }
        self.trial = edited(&packed, &self.settings, &self.table);
        self.fingerprint = packed.fingerprint().as_u128();
        self.packed = Arc::new(packed);
        self.warnings.extend(warnings);
        self.world = None;
        Ok(())
    }

    /// `fmi2DoStep`: from the communication point `from` over `step`, both \[s\].
    ///
    /// # Errors
    /// Wrong phase, a communication point that is not the slave's time, a step that is not positive or
    /// passes the stop time: nothing has changed. A motion that is no longer finite, or output that
    /// cannot be written: the slave is in the error state.
    pub fn do_step(&mut self, from: f64, step: f64) -> Result<(), SlaveError> {
        self.check(Function::DoStep)?;
        if !(step > 0.0 && step.is_finite()) {
            return Err(SlaveError::Advance(AdvanceError::Duration(step).to_string()));
        }
        // Masters add up their own times; half a step off is another communication point.
        let tolerance = (1e-5 * from.abs().max(step)).min(0.5 * step);
        if (from - self.time).abs() > tolerance || from.is_nan() {
            return Err(SlaveError::CommunicationPoint { given: from, expected: self.time });
        }
        if let Some(stop) = self.stop_time.filter(|stop| from + step > stop + 1e-5 * step) {
            return Err(SlaveError::BeyondStopTime { from, step, stop });
        }
        let world = self.make_world()?;
        if let Err(error) = world.advance(step) {
            // Anything else was refused before it began.
            if matches!(error, AdvanceError::NotFinite { .. }) {
                self.phase = Phase::Error;
            }
            return Err(SlaveError::Advance(self.trial.name_body(&error)));
        }
        self.time = from + step;
        if let Err(error) = self.write_output() {
            self.phase = Phase::Error;
            return Err(error.into());
        }
        Ok(())
    }

    /// The XML of the paper's script, named as there, at the present communication point.
    fn write_output(&self) -> Result<(), WriteError> {
        let (Some(world), false) = (&self.world, self.output_directory.is_empty()) else { return Ok(()) };
        let directory = Path::new(&self.output_directory);
        let time = output_time(self.time);
        let dynamics = dynamics_xml(&self.trial.agents, &dynamics_of(world), Drive::Omitted);
        write_atomically(&directory.join(format!("AgentDynamics output t={time}.xml")), &dynamics)?;
        if !world.contacts().contacts.is_empty() {
            let interactions = interactions_xml(&self.trial, &interactions_of(world));
            write_atomically(&directory.join(format!("AgentInteractions t={time}.xml")), &interactions)?;
        }
        Ok(())
    }

    /// `fmi2GetFMUstate`
    ///
    /// # Errors
    /// Wrong phase.
    pub fn snapshot(&self) -> Result<Snapshot, SlaveError> {
        self.check(Function::State)?;
        Ok(Snapshot {
            trial: self.packed.name.clone(),
            fingerprint: self.fingerprint,
            settings: self.settings.clone(),
            threads: self.threads,
            output_directory: self.output_directory.clone(),
            phase: self.phase,
            time: self.time,
            start_time: self.start_time,
            stop_time: self.stop_time,
            running: self
                .world
                .as_ref()
                .map(|world| Running { drive: world.drive.clone(), state: world.state().clone() }),
        })
    }

    /// `fmi2SetFMUstate`
    ///
    /// # Errors
    /// Wrong phase, a snapshot of another model; then nothing has changed.
    pub fn restore(&mut self, snapshot: &Snapshot) -> Result<(), SlaveError> {
        self.check(Function::State)?;
        let (packed, fingerprint) = if snapshot.trial == self.packed.name {
            (self.packed.clone(), self.fingerprint)
        } else {
            let packed = self.resources.load(&snapshot.trial)?.0;
            let fingerprint = packed.fingerprint().as_u128();
            (Arc::new(packed), fingerprint)
        };
        if fingerprint != snapshot.fingerprint || guid(&table(&packed)) != self.guid {
            let message = format!("Trial {:?} is not what it was when the state was saved", snapshot.trial);
            return Err(SlaveError::OtherModel(message));
        }
        let known = |reference: &u32| (*reference as usize) < self.table.len();
        if !snapshot.settings.keys().all(known) {
            return Err(SlaveError::Snapshot("a setting of an unknown variable"));
        }
        let trial = edited(&packed, &snapshot.settings, &self.table);
        let world = match &snapshot.running {
            None => None,
            Some(running) => {
                let mut world = trial.world()?;
                check_running(&world, running)?;
                world.restore(running.state.clone());
                world.drive.clone_from(&running.drive);
                Some(world)
            }
        };
        (self.packed, self.fingerprint, self.trial, self.world) = (packed, fingerprint, trial, world);
        self.settings.clone_from(&snapshot.settings);
        self.threads = snapshot.threads;
        self.output_directory.clone_from(&snapshot.output_directory);
        self.phase = snapshot.phase;
        (self.time, self.start_time, self.stop_time) =
            (snapshot.time, snapshot.start_time, snapshot.stop_time);
        Ok(())
    }

    /// `fmi2SerializeFMUstate`: a snapshot as bytes of a format of its own.
    ///
    /// # Errors
    /// A snapshot that cannot be written.
    pub fn serialize(&self, snapshot: &Snapshot) -> Result<Vec<u8>, SlaveError> {
        let payload =
            postcard::to_stdvec(snapshot).map_err(|_| SlaveError::Snapshot("it cannot be written"))?;
        let mut bytes = Vec::with_capacity(HEADER + payload.len() + 4);
        bytes.extend_from_slice(MAGIC);
        bytes.extend_from_slice(&VERSION.to_le_bytes());
        bytes.extend_from_slice(self.guid.as_bytes());
        bytes.extend_from_slice(&(payload.len() as u64).to_le_bytes());
        bytes.extend_from_slice(&payload);
        let checksum = crc32fast::hash(&bytes);
        bytes.extend_from_slice(&checksum.to_le_bytes());
        Ok(bytes)
    }

    /// `fmi2DeSerializeFMUstate`
    ///
    /// # Errors
    /// Bytes that are damaged, of another version or of another model.
    pub fn deserialize(&self, bytes: &[u8]) -> Result<Snapshot, SlaveError> {
        self.check(Function::State)?;
        let take = |from: usize, length: usize| {
            bytes.get(from..from + length).ok_or(SlaveError::Snapshot("it is cut off"))
        };
        if take(0, 8)? != MAGIC {
            return Err(SlaveError::Snapshot("it does not begin like one"));
        }
        if take(8, 4)? != VERSION.to_le_bytes() {
            return Err(SlaveError::Snapshot("another version of the format"));
        }
        if take(12, 16)? != self.guid.as_bytes() {
            return Err(SlaveError::OtherModel("it was saved by an FMU with another GUID".into()));
        }
        let length = take(28, 8)?.try_into().map(u64::from_le_bytes).unwrap_or(u64::MAX);
        // Importers may hand over a buffer longer than what was written.
        let end = usize::try_from(length).ok().and_then(|length| HEADER.checked_add(length));
        let end = end.filter(|end| *end < bytes.len()).ok_or(SlaveError::Snapshot("it is cut off"))?;
        if take(end, 4)? != crc32fast::hash(&bytes[..end]).to_le_bytes() {
            return Err(SlaveError::Snapshot("its checksum is wrong"));
        }
        postcard::from_bytes(&bytes[HEADER..end])
            .map_err(|_| SlaveError::Snapshot("its content is malformed"))
    }
}

const MAGIC: &[u8; 8] = b"LEMONSst";
/// Raised whenever [`Snapshot`] changes.
const VERSION: u32 = 1;
/// Magic, version, GUID, length.
const HEADER: usize = 8 + 4 + 16 + 8;

/// A packed Trial with an instance's settings.
fn edited(packed: &Trial, settings: &Settings, table: &[Variable]) -> Trial {
    let mut trial = packed.clone();
    for (&reference, &value) in settings {
        if let Some(place) = in_documents_mut(&mut trial, table[reference as usize].quantity) {
            *place = value;
        }
    }
    trial
}

/// A snapshot from outside must fit the scene before the engine indexes with it.
fn check_running(world: &World, running: &Running) -> Result<(), SlaveError> {
    let (scene, state) = (world.scene(), &running.state);
    let bodies = scene.bodies.len();
    let (disks, faces) = (scene.disks.len(), scene.faces.len());
    let fits = state.poses.len() == bodies
        && state.twists.len() == bodies
        && running.drive.len() == bodies
        && state.disk_springs.iter().all(|s| s.first.index() < disks && s.second.index() < disks)
        && state.face_springs.iter().all(|s| s.disk.index() < disks && s.face.index() < faces);
    if fits { Ok(()) } else { Err(SlaveError::Snapshot("it does not fit the scene")) }
}

/// A time \[s\] as the paper's script writes it into file names, with as many decimals as it needs.
fn output_time(time: f64) -> String {
    let rounded = (time * 1e9).round() / 1e9;
    if (rounded * 10.0).fract() == 0.0 { format!("{rounded:.1}") } else { format!("{rounded}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn output_times_are_the_scripts_where_those_are_exact() {
        assert_eq!(output_time(0.1 + 0.2), "0.3");
        assert_eq!(output_time(1.0), "1.0");
        assert_eq!(output_time(0.05), "0.05");
        assert_eq!(output_time(2.65), "2.65");
    }
}
