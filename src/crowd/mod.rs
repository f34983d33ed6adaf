//! The crowd behind an FMU instance: a Trial's documents, and the world that they become.
//!
//! A parameter is an edit of the documents; when initialization ends they become the engine's world.

mod saved;

pub use saved::Saved;

use crate::engine::{AdvanceError, Pair, ThreadsError, World, Wrench, step_count};
use crate::files::{Change, WriteError, change_all};
use crate::resources::{Resources, ResourcesError};
use crate::trial::{Drive, Trial, WorldError, dynamics_of, dynamics_xml, interactions_of, interactions_xml};
use crate::variables::{
    AgentQuantity, MOST_MECHANICAL_STEPS, Quantity, Role, Variable, guid, in_documents, in_documents_mut,
    table,
};
use lemons_fmi2::{Model, Phase, StepError};
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;
use thiserror::Error;

/// Why the crowd refuses something.
#[derive(Debug, Error)]
#[allow(missing_docs)] // the messages say it
pub enum CrowdError {
    #[error(transparent)]
    Resources(#[from] ResourcesError),
    #[error(transparent)]
    World(#[from] WorldError),
    #[error("Trial = {value:?}: must be one of the packed Trials: {names}")]
    NoSuchTrial { value: String, names: String },
    #[error("the state belongs to another model: Trial {0:?} has other variables than this FMU")]
    OtherVariables(String),
    #[error("the state belongs to another model: Trial {0:?} is not what it was when the state was saved")]
    OtherTrial(String),
    #[error("the state is damaged or not one of this FMU: {0}")]
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

/// A Real's value as it was set, by its place in the table.
type Settings = BTreeMap<u32, f64>;

/// A crowd, from its packed Trials to its motion.
pub struct Crowd {
    resources: Resources,
    table: Vec<Variable>,
    /// As packed: what a reset and another choice of Trial start from.
    packed: Arc<Trial>,
    /// Of `packed`.
    fingerprint: u128,
    /// With the settings of this instance.
    trial: Trial,
    settings: Settings,
    threads: i32,
    /// More mechanical steps in one communication step are refused.
    most_steps: f64,
    output_directory: String,
    /// Of the inputs over the next step, by agent; absent ones are held.
    rates: BTreeMap<usize, Wrench>,
    /// Made when initialization ends, or earlier when somebody asks for a computed output.
    world: Option<World>,
    /// Not yet told.
    warnings: Vec<String>,
    /// The first of the pairs of which it was said that they are in one place.
    said_coincident: Option<Pair>,
}

impl Model for Crowd {
    type Quantity = Quantity;
    type Saved = Saved;
    type Error = CrowdError;

    const INTERPOLATES_INPUTS: bool = true;
    const STATE_VERSION: u32 = 3;

    fn load(location: &str) -> Result<Crowd, CrowdError> {
        let resources = Resources::from_uri(location)?;
        let (packed, warnings) = resources.load(resources.first())?;
        Ok(Crowd {
            resources,
            table: table(&packed),
            trial: packed.clone(),
            fingerprint: packed.fingerprint().as_u128(),
            packed: Arc::new(packed),
            settings: Settings::new(),
            threads: 1,
            most_steps: MOST_MECHANICAL_STEPS,
            output_directory: String::new(),
            rates: BTreeMap::new(),
            world: None,
            warnings,
            said_coincident: None,
        })
    }

    fn table(&self) -> Vec<Variable> {
        self.table.clone()
    }

    fn take_warnings(&mut self) -> Vec<String> {
        std::mem::take(&mut self.warnings)
    }

    #[inline(always)]
    fn real(&mut self, quantity: Quantity) -> Result<f64, CrowdError> {
        match self.in_world(quantity) {
            Some(value) => Ok(value),
            None => self.without_world(quantity),
        }
    }

    #[inline(always)]
    fn integer(&mut self, quantity: Quantity) -> Result<i32, CrowdError> {
        match self.world.as_ref().and_then(|world| count(world, quantity)) {
            Some(count) => Ok(count),
            None => self.integer_without_world(quantity),
        }
    }

    fn string(&self, quantity: Quantity) -> &str {
        match quantity {
            Quantity::Trial => &self.packed.name,
            _ => &self.output_directory,
        }
    }

    #[inline]
    fn set_real(&mut self, reference: u32, quantity: Quantity, value: f64, phase: Phase) {
        if quantity == Quantity::MostMechanicalSteps {
            self.most_steps = value;
            return;
        }
        match self.world.as_mut().and_then(|world| drive_mut(world, quantity)) {
            Some(input) => *input = value,
            None => self.world = None,
        }
        if phase != Phase::StepComplete || self.world.is_none() {
            self.edit(reference, quantity, value);
        }
    }

    fn set_integer(&mut self, quantity: Quantity, value: i32) {
        if quantity == Quantity::Threads {
            self.threads = value;
            self.world = None;
        }
    }

    fn set_strings(&mut self, values: &[(Quantity, &str)]) -> Result<(), CrowdError> {
        let last =
            |wanted| values.iter().rev().find(|(quantity, _)| *quantity == wanted).map(|(_, value)| *value);
        for (_, value) in values.iter().filter(|(quantity, _)| *quantity == Quantity::Trial) {
            self.known_trial(value)?;
        }
        if let Some(name) = last(Quantity::Trial).filter(|name| *name != self.packed.name) {
            self.choose(name)?;
        }
        if let Some(directory) = last(Quantity::OutputDirectory) {
            directory.clone_into(&mut self.output_directory);
        }
        Ok(())
    }

    fn set_rate(&mut self, input: Quantity, rate: f64) {
        let Quantity::Agent(i, quantity) = input else { return };
        let rates = self.rates.entry(i as usize).or_default();
        match quantity {
            AgentQuantity::FpX => rates.force.x = rate,
            AgentQuantity::FpY => rates.force.y = rate,
            AgentQuantity::Mp => rates.torque = rate,
            _ => {}
        }
    }

    fn initialize(&mut self) -> Result<(), CrowdError> {
        self.make_world()?;
        make_directory(&self.output_directory)?;
        if self.settings.keys().any(|&reference| self.table[reference as usize].role != Role::Input) {
            self.warnings.extend(self.trial.advice_as_edited());
        }
        // What was read was warned of when it was, what was set just now.
        self.said_coincident = self.first_coincident();
        Ok(())
    }

    fn advance(&mut self, step: f64, to: f64) -> Result<(), StepError<CrowdError>> {
        self.make_world().map_err(StepError::Refused)?;
        self.few_steps(step).map_err(StepError::Refused)?;
        if let Err(error) = self.advance_world(step) {
            let told = CrowdError::Advance(self.trial.name_body(&error));
            // Anything else was refused before it began.
            let failed = matches!(error, AdvanceError::NotFinite { .. } | AdvanceError::Crowded(_));
            return Err(if failed { StepError::Failed(told) } else { StepError::Refused(told) });
        }
        self.warn_of_coincidence();
        // A rate counts for one step.
        self.rates.clear();
        self.write_output(to).map_err(|error| StepError::Failed(error.into()))
    }

    fn reset(&mut self) -> Result<(), CrowdError> {
        if self.packed.name != self.resources.first() {
            self.packed = Arc::new(self.resources.load(self.resources.first())?.0);
            self.fingerprint = self.packed.fingerprint().as_u128();
        }
        self.trial = (*self.packed).clone();
        self.settings.clear();
        self.threads = 1;
        self.most_steps = MOST_MECHANICAL_STEPS;
        self.output_directory.clear();
        self.rates.clear();
        self.world = None;
        self.said_coincident = None;
        Ok(())
    }

    fn save(&self) -> Saved {
        self.saved()
    }

    fn restore(&mut self, saved: &Saved) -> Result<(), CrowdError> {
        self.go_back(saved)
    }
}

impl Crowd {
    fn make_world(&mut self) -> Result<&mut World, CrowdError> {
        if self.world.is_none() {
            let mut world = self.trial.world()?;
            give_threads(&mut world, self.threads, None)?;
            self.world = Some(world);
        }
        Ok(self.world.as_mut().expect("made above"))
    }

    /// That a communication step \[s\] has no more mechanical steps than allowed.
    fn few_steps(&self, step: f64) -> Result<(), CrowdError> {
        let Some(mechanical_step) = self.world.as_ref().map(|world| world.mechanical_step) else {
            return Ok(());
        };
        // What has no number of steps is refused by the world.
        let steps = step_count(step, mechanical_step).unwrap_or(0);
        let most = self.most_steps;
        if steps as f64 > most {
            return Err(CrowdError::TooManySteps { step, steps, mechanical_step, most });
        }
        Ok(())
    }

    /// Says who stands in one place, as often as it is somebody else.
    fn warn_of_coincidence(&mut self) {
        let first = self.first_coincident();
        if first != self.said_coincident
            && let Some(world) = &self.world
        {
            let told = self.trial.name_coincident(world.scene(), &world.contacts().coincident);
            self.warnings.extend(told);
        }
        self.said_coincident = first;
    }

    fn first_coincident(&self) -> Option<Pair> {
        self.world.as_ref().and_then(|world| world.contacts().coincident.first().copied())
    }

    fn advance_world(&mut self, step: f64) -> Result<(), AdvanceError> {
        let Some(world) = &mut self.world else { return Ok(()) };
        world.drive_rate.fill(Wrench::default());
        for (&i, &rate) in &self.rates {
            world.drive_rate[i] = rate;
        }
        world.advance(step)
    }

    /// A setting of this instance, as an edit of the documents.
    #[cold]
    fn edit(&mut self, reference: u32, quantity: Quantity, value: f64) {
        if let Some(place) = in_documents_mut(&mut self.trial, quantity) {
            *place = value;
        }
        self.settings.insert(reference, value);
    }

    /// A Real that the running world holds.
    ///
    /// By threes, as one match of all would become an indirect jump, whose target processors guess badly: half of the
    /// time of a call that reads thousands.
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
    fn integer_without_world(&mut self, quantity: Quantity) -> Result<i32, CrowdError> {
        match quantity {
            Quantity::Threads => Ok(self.threads),
            quantity => Ok(count(self.make_world()?, quantity).unwrap_or(0)),
        }
    }

    /// A Real that the documents hold, or that needs a world made first; 0 for none of these.
    #[cold]
    fn without_world(&mut self, quantity: Quantity) -> Result<f64, CrowdError> {
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

    fn known_trial(&self, name: &str) -> Result<(), CrowdError> {
        if self.resources.names().iter().any(|known| known == name) {
            return Ok(());
        }
        let names = self.resources.names().join(", ");
        Err(CrowdError::NoSuchTrial { value: name.to_owned(), names })
    }

    /// Loads another packed Trial; what was set stays set.
    fn choose(&mut self, name: &str) -> Result<(), CrowdError> {
        let (packed, warnings) = self.resources.load(name)?;
        if guid(&table(&packed)) != guid(&self.table) {
            return Err(CrowdError::OtherVariables(name.to_owned()));
        }
        self.trial = edited(&packed, &self.settings, &self.table);
        self.fingerprint = packed.fingerprint().as_u128();
        self.packed = Arc::new(packed);
        self.warnings.extend(warnings);
        self.world = None;
        Ok(())
    }

    /// The XML of the paper's script, named as there, at a communication point \[s\].
    fn write_output(&self, time: f64) -> Result<(), WriteError> {
        let (Some(world), false) = (&self.world, self.output_directory.is_empty()) else { return Ok(()) };
        let directory = Path::new(&self.output_directory);
        let [dynamics_name, interactions_name] = output_names(time);
        let dynamics = dynamics_xml(&self.trial.agents, &dynamics_of(world), Drive::Omitted);
        let dynamics = Change::Write(directory.join(dynamics_name), dynamics);
        // One that an earlier run left behind must not be taken for this one's.
        let place = directory.join(interactions_name);
        let interactions = if world.contacts().contacts.is_empty() {
            Change::Remove(place)
        } else {
            Change::Write(place, interactions_xml(&self.trial, &interactions_of(world)))
        };
        change_all(&[dynamics, interactions])
    }
}

/// The input of a running world that a quantity is, if it is one.
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

/// The contacts that a quantity counts; `None` if it counts none.
#[inline(always)]
fn count(world: &World, quantity: Quantity) -> Option<i32> {
    let contacts = world.contacts();
    let count = match quantity {
        Quantity::Agent(i, quantity) => {
            let body = &contacts.bodies[i as usize];
            match quantity {
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

/// Gives a world so many threads: those of the world so far, if it has as many.
fn give_threads(world: &mut World, threads: i32, so_far: Option<&World>) -> Result<(), ThreadsError> {
    if let Some(so_far) = so_far {
        world.share_threads(so_far);
    }
    world.set_threads(usize::try_from(threads).unwrap_or(1))
}

/// Makes an OutputDirectory, if there is to be one.
fn make_directory(name: &str) -> Result<(), WriteError> {
    let directory = Path::new(name);
    if name.is_empty() {
        Ok(())
    } else {
        std::fs::create_dir_all(directory).map_err(WriteError::at(directory))
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

/// The names of the two files of a communication point \[s\] in an `OutputDirectory`: dynamics, interactions.
pub fn output_names(time: f64) -> [String; 2] {
    let time = output_time(time);
    [format!("AgentDynamics output t={time}.xml"), format!("AgentInteractions t={time}.xml")]
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
