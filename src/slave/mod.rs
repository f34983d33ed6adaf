//! One FMU instance, whatever the C interface: lifecycle, variables, stepping, snapshot.
//!
//! The instance holds a Trial's documents; a parameter is an edit of them, and when initialization
//! ends they become the engine's world. Every refused call leaves everything as it was.

mod lifecycle;
mod snapshot;

pub use lifecycle::{Function, Phase, allowed};
pub use snapshot::Snapshot;

use crate::engine::{AdvanceError, World};
use crate::files::{Change, WriteError, change_all};
use crate::resources::{Resources, ResourcesError};
use crate::trial::{Drive, Trial, WorldError, dynamics_of, dynamics_xml, interactions_of, interactions_xml};
use crate::variables::{
    AgentQuantity, Kind, Quantity, Role, Variable, guid, in_documents, in_documents_mut, table,
};
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;
use thiserror::Error;
use uuid::Uuid;

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
        if self.settings.keys().any(|&reference| self.table[reference as usize].role != Role::Input) {
            self.warnings.extend(self.trial.advice_as_edited());
        }
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
            Role::Calculated => "at all: it is computed",
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
        if let Some(stop) = self.stop_time.filter(|stop| from + step > stop + tolerance) {
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
        let dynamics = Change::Write(directory.join(format!("AgentDynamics output t={time}.xml")), dynamics);
        // One that an earlier run left behind must not be taken for this one's.
        let place = directory.join(format!("AgentInteractions t={time}.xml"));
        let interactions = if world.contacts().contacts.is_empty() {
            Change::Remove(place)
        } else {
            Change::Write(place, interactions_xml(&self.trial, &interactions_of(world)))
        };
        change_all(&[dynamics, interactions])
    }
}

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
