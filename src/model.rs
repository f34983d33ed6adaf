//! The crowd behind an FMU instance: a Trial's documents, and the world that is built from them.
//!
//! A parameter is an edit of the documents. When initialization ends, the engine's world is built from them.

mod arrays;
mod saved;

pub use saved::Saved;

use crate::engine::{AdvanceError, BodyId, Pair, ThreadsError, World, Wrench, step_count, vec2};
use crate::resources::{Resources, ResourcesError};
use crate::setup::{FINEST_ACCURACY, Setup, WorldError, dynamics_of, interactions_of};
use crate::variables::{
    AgentQuantity, MOST_MECHANICAL_STEPS, Quantity, Variable, domain, guid, in_documents, in_documents_mut,
    is_input, table,
};
use lemons_core::files::{Change, WriteError, change_all};
use lemons_core::trial::{
    DriveTable, DynamicsElement, Problem, Trial, dynamics_xml, interactions_xml, output_names,
};
use lemons_fmi::location::Location;
use lemons_fmi::{Model, Phase, StepError};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::sync::{Arc, OnceLock};
use thiserror::Error;

/// Why the crowd refuses a call.
#[derive(Debug, Error)]
#[allow(missing_docs)] // the messages say it
pub enum ModelError {
    #[error(transparent)]
    Resources(#[from] ResourcesError),
    #[error(transparent)]
    World(#[from] WorldError),
    #[error("Trial = {value:?}: must be one of the packed Trials: {names}")]
    NoSuchTrial { value: String, names: String },
    #[error(
        "Trial = {0:?}: values were set of agents or materials that it does not have: choose the Trial before its values"
    )]
    OtherSizes(String),
    #[error("materials {0:?} and {1:?} have two different values: the matrix must be symmetric")]
    Asymmetric(String, String),
    #[error("materials {0:?} and {1:?} have no <Contact> in Materials.xml: their value must be 0")]
    NoContact(String, String),
    #[error("the state belongs to another model: Trial {0:?} has other variables than this FMU")]
    OtherVariables(String),
    #[error("the state belongs to another model: Trial {0:?} has changed since the state was saved")]
    OtherTrial(String),
    #[error("the state is damaged or is not a state of this FMU: {0}")]
    Saved(&'static str),
    #[error("Threads: {0}")]
    Threads(#[from] ThreadsError),
    #[error("{0}")]
    Advance(String),
    #[error(
        "a communication step of {step:?} s takes {steps} mechanical steps of {mechanical_step:?} s, more than \
        MostMechanicalSteps = {most}: take shorter communication steps, or set that parameter"
    )]
    TooManySteps { step: f64, steps: u64, mechanical_step: f64, most: f64 },
    #[error("OutputDirectory: {0}")]
    Output(#[from] WriteError),
}

/// The values of Reals of the documents that were set.
type Settings = BTreeMap<Quantity, f64>;

/// A Trial as it was packed.
struct Packed {
    trial: Trial,
    /// Tells the Trial from others.
    fingerprint: u128,
    /// Its drive, once it was played.
    drive: OnceLock<Drive>,
}

/// The `drive.csv` of a Trial; empty without one.
struct Drive {
    table: DriveTable,
    /// See [`DriveTable::fingerprint`].
    fingerprint: String,
}

impl Packed {
    /// Reads a packed Trial; also returns warnings.
    fn load(resources: &Resources, name: &str) -> Result<(Arc<Packed>, Vec<String>), ResourcesError> {
        let (trial, warnings) = resources.load(name)?;
        let fingerprint = trial.fingerprint();
        Ok((Arc::new(Packed { trial, fingerprint, drive: OnceLock::new() }), warnings))
    }

    /// Reads the drive, unless that was done before.
    fn drive(&self, resources: &Resources) -> Result<&Drive, ResourcesError> {
        if let Some(drive) = self.drive.get() {
            return Ok(drive);
        }
        let table = resources.drive(&self.trial)?;
        let fingerprint = table.fingerprint();
        Ok(self.drive.get_or_init(|| Drive { table, fingerprint }))
    }
}

/// The crowd of one FMU instance: its packed Trials, parameters and motion.
pub struct CrowdModel {
    resources: Resources,
    /// FMI 3.0: the packed Trials may have different numbers of agents and materials.
    any_size: bool,
    /// The Trial as packed: the start for a reset or the choice of another Trial.
    packed: Arc<Packed>,
    /// The Trial with the settings of this instance.
    trial: Trial,
    settings: Settings,
    play_drive: bool,
    /// Places of the agents whom the packed drive drives; nobody before initialization has ended.
    played: BTreeSet<usize>,
    /// Places of the agents whom the packed drive does not drive, whatever their values are.
    undriven: BTreeSet<usize>,
    /// Places of the agents who have left or come back since the last step.
    moved: BTreeSet<usize>,
    threads: i32,
    /// A communication step with more mechanical steps is refused.
    most_steps: f64,
    /// Mechanical steps between intermediate updates; 0 for none.
    intermediate_steps: i32,
    output_directory: String,
    /// Rates of the inputs over the next step, by agent; missing ones are constant.
    rates: BTreeMap<usize, Wrench>,
    /// \[m\] of the importer's experiment: chooses the mechanical step, unless that was set.
    tolerance: Option<f64>,
    /// Made when initialization ends, or earlier if a computed output is read.
    world: Option<World>,
    /// Warnings that were not yet returned.
    warnings: Vec<String>,
    /// The first pair of the last warning about coinciding centres.
    said_coincident: Option<Pair>,
}

impl Model for CrowdModel {
    type Quantity = Quantity;
    type Saved = Saved;
    type Error = ModelError;

    const INTERPOLATES_INPUTS: bool = true;
    const STATE_VERSION: u32 = 8;

    fn load(location: Location<'_>) -> Result<CrowdModel, ModelError> {
        CrowdModel::from_resources(Resources::at(location)?, matches!(location, Location::Path(_)))
    }

    fn table(&self) -> Vec<Variable> {
        table(&self.packed.trial)
    }

    fn take_warnings(&mut self) -> Vec<String> {
        std::mem::take(&mut self.warnings)
    }

    #[inline(always)]
    fn real(&mut self, quantity: Quantity) -> Result<f64, ModelError> {
        match self.in_world(quantity) {
            Some(value) => Ok(value),
            None => self.without_world(quantity),
        }
    }

    #[inline(always)]
    fn integer(&mut self, quantity: Quantity) -> Result<i32, ModelError> {
        match self.world.as_ref().and_then(|world| count(world, quantity)) {
            Some(count) => Ok(count),
            None => self.integer_without_world(quantity),
        }
    }

    fn string(&self, quantity: Quantity) -> &str {
        match quantity {
            Quantity::Trial => &self.packed.trial.name,
            _ => &self.output_directory,
        }
    }

    #[inline]
    fn set_real(&mut self, quantity: Quantity, value: f64, phase: Phase) {
        if quantity == Quantity::MostMechanicalSteps {
            self.most_steps = value;
            if self.chooses_step() {
                self.world = None;
            }
            return;
        }
        self.take_over(quantity);
        match self.world.as_mut().and_then(|world| drive_mut(world, quantity)) {
            Some(input) => *input = value,
            None => self.world = None,
        }
        if phase != Phase::StepComplete || self.world.is_none() {
            self.edit(quantity, value);
        }
    }

    fn set_integer(&mut self, quantity: Quantity, value: i32, phase: Phase) {
        match quantity {
            Quantity::Agent(i, AgentQuantity::Active) => match &mut self.world {
                Some(world) if phase == Phase::StepComplete => {
                    let changes = world.is_present(BodyId::from(i as usize)) != (value != 0);
                    if changes && !self.moved.remove(&(i as usize)) {
                        self.moved.insert(i as usize);
                    }
                    world.set_present(BodyId::from(i as usize), value != 0);
                }
                _ => {
                    self.world = None;
                    self.edit(quantity, value.into());
                }
            },
            Quantity::Threads => {
                self.threads = value;
                self.world = None;
            }
            Quantity::IntermediateSteps => self.intermediate_steps = value,
            Quantity::PlayDrive => self.play_drive = value != 0,
            _ => {}
        }
    }

    fn set_strings(&mut self, values: &[(Quantity, &str)]) -> Result<(), ModelError> {
        let last =
            |wanted| values.iter().rev().find(|(quantity, _)| *quantity == wanted).map(|(_, value)| *value);
        for (_, value) in values.iter().filter(|(quantity, _)| *quantity == Quantity::Trial) {
            self.known_trial(value)?;
        }
        if let Some(name) = last(Quantity::Trial).filter(|name| *name != self.packed.trial.name) {
            self.choose(name)?;
        }
        if let Some(directory) = last(Quantity::OutputDirectory) {
            directory.clone_into(&mut self.output_directory);
        }
        Ok(())
    }

    fn derivative(&self, quantity: Quantity) -> Option<f64> {
        let (world, Quantity::Agent(i, quantity)) = (self.world.as_ref()?, quantity) else { return None };
        let body = BodyId::from(i as usize);
        let (twist, acceleration) = if world.is_present(body) {
            (world.state().twists[body.index()], world.acceleration(body))
        } else {
            Default::default()
        };
        match quantity {
            AgentQuantity::PositionX => Some(twist.velocity.x),
            AgentQuantity::PositionY => Some(twist.velocity.y),
            AgentQuantity::Theta => Some(twist.angular_velocity),
            AgentQuantity::VelocityX => Some(acceleration.force.x),
            AgentQuantity::VelocityY => Some(acceleration.force.y),
            AgentQuantity::Omega => Some(acceleration.torque),
            _ => None,
        }
    }

    fn set_rate(&mut self, input: Quantity, rate: f64) {
        self.take_over(input);
        let Quantity::Agent(i, quantity) = input else { return };
        let rates = self.rates.entry(i as usize).or_default();
        match quantity {
            AgentQuantity::FpX => rates.force.x = rate,
            AgentQuantity::FpY => rates.force.y = rate,
            AgentQuantity::Mp => rates.torque = rate,
            _ => {}
        }
    }

    fn set_tolerance(&mut self, tolerance: Option<f64>) {
        if self.chooses_step() {
            self.trial.parameters.time_step_mechanical = self.packed.trial.parameters.time_step_mechanical;
        }
        self.tolerance = tolerance;
        self.world = None;
    }

    fn initialize(&mut self, start: f64) -> Result<(), ModelError> {
        self.make_world()?;
        if self.chooses_step() {
            self.warnings.extend(self.warning_of_step());
        }
        make_directory(&self.output_directory)?;
        if self.chooses_step() || self.settings.keys().any(|&quantity| !is_input(quantity)) {
            let advice = Setup::of(&self.trial).advice_as_edited();
            self.warnings.extend(advice.iter().map(Problem::without_severity));
        }
        // Warnings about these centres were given when they were read or set.
        self.said_coincident = self.first_coincident();
        self.played = self.whom_it_plays()?;
        self.play(start);
        Ok(())
    }

    fn advance(&mut self, from: f64, step: f64) -> Result<(), StepError<ModelError>> {
        self.advance_by(from, step, 0.0, Some(from + step))
    }

    fn reset(&mut self) -> Result<(), ModelError> {
        if self.packed.trial.name != self.resources.first() {
            self.packed = Packed::load(&self.resources, self.resources.first())?.0;
        }
        self.trial = self.packed.trial.clone();
        self.settings.clear();
        self.play_drive = true;
        self.played.clear();
        self.undriven.clear();
        self.moved.clear();
        self.threads = 1;
        self.most_steps = MOST_MECHANICAL_STEPS;
        self.intermediate_steps = 0;
        self.output_directory.clear();
        self.rates.clear();
        self.tolerance = None;
        self.world = None;
        self.said_coincident = None;
        Ok(())
    }

    fn save(&self) -> Saved {
        self.saved()
    }

    fn restore(&mut self, saved: &Saved) -> Result<(), ModelError> {
        self.go_back(saved)
    }
}

impl CrowdModel {
    /// Makes the model of one Trial and its drive, without an FMU.
    ///
    /// # Errors
    /// None of a Trial that was read.
    pub fn of_trial(trial: Trial, drive: DriveTable) -> Result<CrowdModel, ModelError> {
        CrowdModel::from_resources(Resources::of_one(trial, drive), false)
    }

    fn from_resources(resources: Resources, any_size: bool) -> Result<CrowdModel, ModelError> {
        let (packed, warnings) = Packed::load(&resources, resources.first())?;
        Ok(CrowdModel {
            resources,
            any_size,
            trial: packed.trial.clone(),
            packed,
            settings: Settings::new(),
            play_drive: true,
            played: BTreeSet::new(),
            undriven: BTreeSet::new(),
            moved: BTreeSet::new(),
            threads: 1,
            most_steps: MOST_MECHANICAL_STEPS,
            intermediate_steps: 0,
            output_directory: String::new(),
            rates: BTreeMap::new(),
            tolerance: None,
            world: None,
            warnings,
            said_coincident: None,
        })
    }

    /// Keeps the packed drive from an agent, before initialization ends. An importer says so by another Fp or Mp; who
    /// knows that it was set says it here.
    pub fn keep_drive_from(&mut self, agent: usize) {
        self.undriven.insert(agent);
    }

    /// Returns the running world; `None` before it is made.
    pub fn world(&self) -> Option<&World> {
        self.world.as_ref()
    }

    /// Returns the Trial with the settings of this instance.
    pub fn trial(&self) -> &Trial {
        &self.trial
    }

    /// Advances by a part of a communication step that begins at `from`, of which `so_far` are over, to the
    /// communication point if that is its end; all in \[s\].
    fn advance_by(
        &mut self,
        from: f64,
        part: f64,
        so_far: f64,
        to: Option<f64>,
    ) -> Result<(), StepError<ModelError>> {
        self.make_world().map_err(StepError::Refused)?;
        self.few_steps(part).map_err(StepError::Refused)?;
        let world = self.world.as_ref().filter(|_| !self.played.is_empty());
        let drive = world.map(|world| world.drive.clone());
        if so_far == 0.0 {
            // The importer's time, which may differ from ours by rounding.
            self.play(from);
            self.warn_of_returns(from);
        }
        if let Err(error) = self.advance_world(part, so_far) {
            let told = ModelError::Advance(Setup::of(&self.trial).name_body(&error));
            // All other errors are found before the step begins.
            let failed = matches!(error, AdvanceError::NotFinite { .. } | AdvanceError::Crowded(_));
            if failed {
                return Err(StepError::Failed(told));
            }
            // A refused step changes nothing, the drive that is played neither.
            if let (Some(world), Some(drive)) = (&mut self.world, drive) {
                world.drive = drive;
            }
            return Err(StepError::Refused(told));
        }
        self.warn_of_coincidence();
        // A rate is used for one step.
        self.rates.clear();
        let Some(to) = to else { return Ok(()) };
        self.play(to);
        self.write_output(to).map_err(|error| StepError::Failed(error.into()))
    }

    /// The agents whom the packed drive drives: those in it of whom the importer has not set Fp or Mp to another value than
    /// the Trial's.
    fn whom_it_plays(&self) -> Result<BTreeSet<usize>, ModelError> {
        if !self.play_drive {
            return Ok(BTreeSet::new());
        }
        let (agents, drive) = (self.packed.trial.agents.iter(), &self.packed.drive(&self.resources)?.table);
        let driven = agents.enumerate().filter(|(_, agent)| drive.rows(&agent.id).is_some());
        let mut played: BTreeSet<usize> = driven.map(|(i, _)| i).collect();
        for (&quantity, &value) in &self.settings {
            if let Quantity::Agent(i, AgentQuantity::FpX | AgentQuantity::FpY | AgentQuantity::Mp) = quantity
                && in_documents(&self.packed.trial, quantity) != Some(value)
            {
                played.remove(&(i as usize));
            }
        }
        played.retain(|i| !self.rates.contains_key(i) && !self.undriven.contains(i));
        Ok(played)
    }

    /// Drives those whom the packed drive drives as it says at a time \[s\].
    fn play(&mut self, time: f64) {
        let (Some(world), Some(drive)) = (&mut self.world, self.packed.drive.get()) else { return };
        for &i in &self.played {
            if let Some([x, y, torque]) = drive.table.at(&self.trial.agents[i].id, time) {
                world.drive[i] = Wrench { force: vec2(x, y), torque };
            }
        }
    }

    /// Before an input of an agent is set: the packed drive no longer drives it, as if it had none.
    #[inline]
    fn take_over(&mut self, input: Quantity) {
        use AgentQuantity::{FpX, FpY, Mp};
        if let Quantity::Agent(i, FpX | FpY | Mp) = input
            && !self.played.is_empty()
            && self.played.remove(&(i as usize))
            && let Some(world) = &mut self.world
        {
            let own = &self.trial.dynamics[i as usize];
            world.drive[i as usize] = Wrench { force: own.fp, torque: own.mp };
        }
    }

    fn make_world(&mut self) -> Result<&mut World, ModelError> {
        if self.world.is_none() {
            self.choose_step();
            let mut world = Setup::of(&self.trial).world()?;
            give_threads(&mut world, self.threads, None)?;
            self.dismiss(&mut world)?;
            // A state with such forces could not be restored.
            if let Some(i) = world.exposures().iter().position(|exposure| !exposure.is_finite()) {
                let told = format!("agent {:?}: the forces on it are not finite", self.trial.agents[i].id);
                return Err(ModelError::Advance(told));
            }
            self.world = Some(world);
        }
        Ok(self.world.as_mut().expect("made above"))
    }

    /// Takes those out of a new world who are not there at the start.
    fn dismiss(&self, world: &mut World) -> Result<(), ModelError> {
        let absent = self.settings.iter().filter_map(|(quantity, value)| match quantity {
            Quantity::Agent(i, AgentQuantity::Active) if *value == 0.0 => Some(BodyId::from(*i as usize)),
            _ => None,
        });
        let absent: Vec<BodyId> = absent.collect();
        if absent.is_empty() {
            return Ok(());
        }
        absent.into_iter().for_each(|body| world.set_present(body, false));
        let restored = world.restore(world.state().clone());
        Ok(restored.map_err(|crowded| Setup::of(&self.trial).too_crowded(crowded))?)
    }

    /// Whether the importer's tolerance chooses the mechanical step.
    fn chooses_step(&self) -> bool {
        self.tolerance.is_some() && !self.settings.contains_key(&Quantity::TimeStepMechanical)
    }

    /// Gives the documents the mechanical step that is used.
    fn choose_step(&mut self) {
        if let Some(tolerance) = self.tolerance.filter(|_| self.chooses_step()) {
            self.trial.parameters.time_step_mechanical = self.packed.trial.parameters.time_step_mechanical;
            if let Ok(step) = by_tolerance(&self.trial, tolerance, self.most_steps) {
                self.trial.parameters.time_step_mechanical = step;
            }
        }
    }

    /// Says why the tolerance is not kept to.
    fn warning_of_step(&self) -> Option<String> {
        let tolerance = self.tolerance?;
        let step = self.trial.parameters.time_step_mechanical;
        match by_tolerance(&self.trial, tolerance, self.most_steps) {
            Err(None) => None,
            Err(Some(why)) => Some(format!(
                "the tolerance {tolerance:e} chooses no mechanical step: {why}; TimeStepMechanical stays {step:?} s"
            )),
            Ok(_) if tolerance < FINEST_ACCURACY => Some(format!(
                "the tolerance {tolerance:e} is taken as {FINEST_ACCURACY:e}: poses are not known to be more accurate \
                 than {FINEST_ACCURACY:e} m at any mechanical step"
            )),
            Ok(step) => {
                let error = Setup::of(&self.trial).steps()?.error(step);
                (error > tolerance * (1.0 + 1e-9)).then(|| {
                    format!(
                        "the tolerance {tolerance:e} needs more than MostMechanicalSteps = {} mechanical steps in a \
                         TimeStep of {:?} s: TimeStepMechanical is {step:?} s, which is accurate to about {error:.1e} m",
                        self.most_steps, self.trial.parameters.time_step
                    )
                })
            }
        }
    }

    /// Checks that a communication step \[s\] has no more mechanical steps than allowed.
    fn few_steps(&self, step: f64) -> Result<(), ModelError> {
        let Some(mechanical_step) = self.world.as_ref().map(|world| world.mechanical_step) else {
            return Ok(());
        };
        // If the number of steps is not defined, the world reports the error.
        let steps = step_count(step, mechanical_step).unwrap_or(0);
        let most = self.most_steps;
        if steps as f64 > most {
            return Err(ModelError::TooManySteps { step, steps, mechanical_step, most });
        }
        Ok(())
    }

    /// Warns of coinciding centres whenever the first such pair changes.
    fn warn_of_coincidence(&mut self) {
        let first = self.first_coincident();
        if first != self.said_coincident
            && let Some(world) = &self.world
        {
            let told = Setup::of(&self.trial).name_coincident(world.scene(), &world.contacts().coincident);
            self.warnings.extend(told);
        }
        self.said_coincident = first;
    }

    /// Warns of those who come back at a time \[s\] where others or walls are.
    fn warn_of_returns(&mut self, time: f64) {
        let mut back = std::mem::take(&mut self.moved);
        let Some(world) = &self.world else { return };
        back.retain(|&i| world.is_present(BodyId::from(i)));
        if back.is_empty() {
            return;
        }
        let mut then = world.clone();
        // If they are too many at one place, the step says so.
        if then.restore(world.state().clone()).is_ok() {
            self.warnings.extend(Setup::of(&self.trial).overlaps_of(&then, &back, time));
        }
    }

    fn first_coincident(&self) -> Option<Pair> {
        self.world.as_ref().and_then(|world| world.contacts().coincident.first().copied())
    }

    fn advance_world(&mut self, part: f64, so_far: f64) -> Result<(), AdvanceError> {
        let Some(world) = &mut self.world else { return Ok(()) };
        world.drive_rate.fill(Wrench::default());
        for (&i, &rate) in &self.rates {
            world.drive_rate[i] = rate;
        }
        world.advance_on(part, so_far)
    }

    /// Applies a setting of this instance to the documents.
    #[cold]
    fn edit(&mut self, quantity: Quantity, value: f64) {
        if let Some(place) = in_documents_mut(&mut self.trial, quantity) {
            *place = value;
        }
        self.settings.insert(quantity, value);
    }

    /// Returns a Real that the running world contains.
    ///
    /// In groups of three: one match of all would become an indirect jump, which processors predict badly. It takes
    /// half of the time of a call that reads thousands of values.
    #[inline(always)]
    fn in_world(&self, quantity: Quantity) -> Option<f64> {
        use AgentQuantity::*;
        let (world, Quantity::Agent(i, quantity)) = (self.world.as_ref()?, quantity) else { return None };
        let i = i as usize;
        if quantity == NormalForce {
            return Some(world.contacts().bodies[i].squeeze);
        }
        let (first, second, third) = match quantity {
            MeanNormalForce | PeakNormalForce | PeakOverlap => {
                let exposure = &world.exposures()[i];
                (exposure.mean_force, exposure.peak_force, exposure.peak_overlap)
            }
            FpX | FpY | Mp => (world.drive[i].force.x, world.drive[i].force.y, world.drive[i].torque),
            PositionX | PositionY | Theta => {
                let pose = &world.state().poses[i];
                (pose.position.x, pose.position.y, pose.orientation)
            }
            VelocityX | VelocityY | Omega => {
                let twist = &world.state().twists[i];
                (twist.velocity.x, twist.velocity.y, twist.angular_velocity)
            }
            _ => return None,
        };
        Some(match quantity {
            FpX | PositionX | VelocityX | MeanNormalForce => first,
            FpY | PositionY | VelocityY | PeakNormalForce => second,
            _ => third,
        })
    }

    #[cold]
    fn integer_without_world(&mut self, quantity: Quantity) -> Result<i32, ModelError> {
        match quantity {
            Quantity::Threads => Ok(self.threads),
            Quantity::IntermediateSteps => Ok(self.intermediate_steps),
            Quantity::PlayDrive => Ok(self.play_drive.into()),
            quantity => Ok(count(self.make_world()?, quantity).unwrap_or(0)),
        }
    }

    /// Returns a Real of the documents, or one for which a world must be made first; 0 otherwise.
    #[cold]
    fn without_world(&mut self, quantity: Quantity) -> Result<f64, ModelError> {
        if quantity == Quantity::TimeStepMechanical && self.world.is_none() {
            self.choose_step();
        }
        if let Some(value) = in_documents(&self.trial, quantity) {
            return Ok(value);
        }
        if quantity == Quantity::MostMechanicalSteps {
            return Ok(self.most_steps);
        }
        let world = self.make_world()?;
        if quantity == Quantity::LargestOverlap {
            return Ok(world.largest_overlap());
        }
        Ok(self.in_world(quantity).unwrap_or(0.0))
    }

    fn known_trial(&self, name: &str) -> Result<(), ModelError> {
        if self.resources.names().iter().any(|known| known == name) {
            return Ok(());
        }
        let names = self.resources.names().join(", ");
        Err(ModelError::NoSuchTrial { value: name.to_owned(), names })
    }

    /// Loads another packed Trial; settings are kept.
    fn choose(&mut self, name: &str) -> Result<(), ModelError> {
        let (packed, warnings) = Packed::load(&self.resources, name)?;
        if self.any_size {
            if !self.settings.keys().all(|&quantity| domain(&packed.trial, quantity).is_some()) {
                return Err(ModelError::OtherSizes(name.to_owned()));
            }
        } else if guid(&table(&packed.trial)) != guid(&table(&self.packed.trial)) {
            return Err(ModelError::OtherVariables(name.to_owned()));
        }
        self.trial = edited(&packed.trial, &self.settings);
        self.packed = packed;
        self.warnings.extend(warnings);
        self.world = None;
        Ok(())
    }

    /// Writes the XML files of the paper's script, with its file names, at a communication point \[s\].
    fn write_output(&self, time: f64) -> Result<(), WriteError> {
        let (Some(world), false) = (&self.world, self.output_directory.is_empty()) else { return Ok(()) };
        let directory = Path::new(&self.output_directory);
        let [dynamics_name, interactions_name] = output_names(time);
        let dynamics = dynamics_xml(&self.trial.agents, &dynamics_of(world), DynamicsElement::Omitted);
        let dynamics = Change::Write(directory.join(dynamics_name), dynamics);
        // A file of an earlier run must not be mistaken for one of this run.
        let place = directory.join(interactions_name);
        let interactions = if world.contacts().contacts.is_empty() {
            Change::Remove(place)
        } else {
            Change::Write(
                place,
                interactions_xml(&self.trial.agents, &self.trial.geometry, &interactions_of(world)),
            )
        };
        let changes = [dynamics, interactions];
        changes.iter().try_for_each(check_no_link)?;
        change_all(&changes)
    }
}

/// That a change does not go through a link, to a file somewhere else.
fn check_no_link(change: &Change) -> Result<(), WriteError> {
    let (Change::Write(path, _) | Change::Remove(path)) = change;
    match path.symlink_metadata() {
        Ok(there) if !there.is_file() => {
            let what = if there.is_symlink() { "a link" } else { "not a regular file" };
            let error = std::io::Error::other(format!("there is {what}, which is not replaced; remove it"));
            Err(WriteError { path: path.clone(), error })
        }
        _ => Ok(()),
    }
}

/// Returns the input of a running world behind a quantity, if it is one.
#[inline]
fn drive_mut(world: &mut World, quantity: Quantity) -> Option<&mut f64> {
    let Quantity::Agent(i, quantity) = quantity else { return None };
    let drive = &mut world.drive[i as usize];
    match quantity {
        AgentQuantity::FpX => Some(&mut drive.force.x),
        AgentQuantity::FpY => Some(&mut drive.force.y),
        AgentQuantity::Mp => Some(&mut drive.torque),
        _ => None,
    }
}

/// Returns the number of contacts behind a quantity; `None` if it is another quantity.
#[inline(always)]
fn count(world: &World, quantity: Quantity) -> Option<i32> {
    let contacts = world.contacts();
    let count = match quantity {
        Quantity::Agent(i, quantity) => {
            let body = &contacts.bodies[i as usize];
            match quantity {
                AgentQuantity::Active => world.is_present(BodyId::from(i as usize)).into(),
                AgentQuantity::AgentContacts => body.agent_contacts,
                AgentQuantity::WallContacts => body.wall_contacts,
                AgentQuantity::ContactingAgents => body.touching_bodies,
                _ => return None,
            }
        }
        Quantity::AgentContacts => contacts.agent_contacts,
        Quantity::WallContacts => contacts.wall_contacts,
        Quantity::CoincidentContacts => u32::try_from(contacts.coincident.len()).unwrap_or(u32::MAX),
        _ => return None,
    };
    Some(i32::try_from(count).unwrap_or(i32::MAX))
}

/// Gives a world a number of threads: those of the previous world, if it has as many.
fn give_threads(world: &mut World, threads: i32, so_far: Option<&World>) -> Result<(), ThreadsError> {
    if let Some(so_far) = so_far {
        world.share_threads(so_far);
    }
    world.set_threads(usize::try_from(threads).unwrap_or(1))
}

/// Creates the OutputDirectory, if one is set.
fn make_directory(name: &str) -> Result<(), WriteError> {
    let directory = Path::new(name);
    if name.is_empty() {
        Ok(())
    } else {
        std::fs::create_dir_all(directory).map_err(WriteError::at(directory))
    }
}

/// \[s\] The mechanical step for a tolerance \[m\]: see docs/step.md. A TimeStep takes no more than `most` of them.
///
/// # Errors
/// Why there is none; nothing if nothing can touch, since any step is exact then.
fn by_tolerance(trial: &Trial, tolerance: f64, most: f64) -> Result<f64, Option<&'static str>> {
    let steps = Setup::of(trial).steps().ok_or(None)?;
    let step = steps.accurate_to(tolerance.max(FINEST_ACCURACY));
    let step = step.ok_or(Some("no step resolves the contacts of this scene"))?;
    let shortest = trial.parameters.time_step / most;
    if shortest > steps.longest() {
        return Err(Some("MostMechanicalSteps allows no stable step"));
    }
    Ok(step.max(shortest))
}

/// A packed Trial with an instance's settings.
fn edited(packed: &Trial, settings: &Settings) -> Trial {
    let mut trial = packed.clone();
    for (&quantity, &value) in settings {
        if let Some(place) = in_documents_mut(&mut trial, quantity) {
            *place = value;
        }
    }
    trial
}
