//! The crowd behind an FMU instance: a Trial's documents, and the world that is built from them.
//!
//! A parameter is an edit of the documents. When initialization ends, the engine's world is built from them.

mod saved;

pub use saved::Saved;

use crate::engine::{AdvanceError, BodyId, Pair, Vec2, World, Wrench, step_count, vec2};
use crate::quantities::{
    self, MOST_MECHANICAL_STEPS, QUANTITIES, Quantity, SIZES, field, ids_of_pair, place_of_contact,
};
use crate::resources::{Resources, ResourcesError};
use crate::setup::{FINEST_ACCURACY, Setup, dynamics_of, interactions_of};
use lemons_core::files::{Change, WriteError, change_all};
use lemons_core::trial::{DriveTable, DynamicsElement, Trial, dynamics_xml, interactions_xml, output_names};
use lemons_fmi::location::Location;
use lemons_fmi::variables::{Dependencies, Known, Role, Scalar, Size, Variable};
use lemons_fmi::{Answer, Model, Phase, Refusal, Step, StepError, refuse};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};

/// Values that importers have set, other than those of inputs at communication points. States hold them in this order.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Settings {
    /// Elements of quantities: of the documents, and who is there at the start.
    elements: BTreeMap<(Quantity, usize), f64>,
    play_drive: bool,
    threads: i32,
    /// A communication step with more mechanical steps is refused.
    most_steps: f64,
    /// Mechanical steps between intermediate updates; 0 for none.
    intermediate_steps: i32,
    output_directory: String,
    /// Rates of the inputs over the next step, by agent; missing ones are constant.
    rates: BTreeMap<usize, Wrench>,
    /// \[m\] of the importer's experiment: may shorten the mechanical step.
    tolerance: Option<f64>,
}

impl Default for Settings {
    fn default() -> Settings {
        Settings {
            elements: BTreeMap::new(),
            play_drive: true,
            threads: 1,
            most_steps: MOST_MECHANICAL_STEPS,
            intermediate_steps: 0,
            output_directory: String::new(),
            rates: BTreeMap::new(),
            tolerance: None,
        }
    }
}

impl Settings {
    /// Gives a Trial the mechanical step that is used: its own or the one that was set, or a shorter one that the
    /// tolerance needs.
    fn choose_step(&self, trial: &mut Trial, packed: &Trial) {
        let Some(tolerance) = self.tolerance else { return };
        let set = self.elements.get(&(Quantity::TimeStepMechanical, 0));
        let longest = set.copied().unwrap_or(packed.parameters.time_step_mechanical);
        let needed = match by_tolerance(trial, tolerance, self.most_steps) {
            Ok(step) => step,
            Err(None) => longest,
            // Also if a longer step was set for the tolerance to choose.
            Err(Some(_)) => packed.parameters.time_step_mechanical,
        };
        trial.parameters.time_step_mechanical = longest.min(needed);
    }

    /// Returns a packed Trial with these settings; `None` if it does not have what was set.
    fn applied_to(&self, packed: &Trial) -> Option<Trial> {
        let mut trial = packed.clone();
        for (&(quantity, element), &value) in &self.elements {
            if quantity == Quantity::Active {
                trial.agents.get(element)?;
            } else {
                *field(&mut trial, quantity, element)? = value;
            }
        }
        Some(trial)
    }
}

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
        Ok((Arc::new(Packed::of(trial)), warnings))
    }

    fn of(trial: Trial) -> Packed {
        Packed { fingerprint: trial.fingerprint(), trial, drive: OnceLock::new() }
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
    /// Places of the agents whom the packed drive drives; nobody before initialization has ended.
    played: BTreeSet<usize>,
    /// Places of the agents whom the packed drive does not drive, whatever their values are.
    undriven: BTreeSet<usize>,
    /// Places of the agents who have left or come back since the last step.
    moved: BTreeSet<usize>,
    /// Made when initialization ends, or earlier if a computed output is read. While an importer looks ahead, it is there.
    world: Option<World>,
    /// While an importer looks ahead: the world at the beginning of the step.
    start: Option<World>,
    /// Warnings that were not yet returned.
    warnings: Vec<String>,
    /// The first pair of the last warning about coinciding centres.
    said_coincident: Option<Pair>,
}

impl Model for CrowdModel {
    type Quantity = Quantity;
    type Saved = Saved;

    const NAME: &'static str = "LEMONS crowd mechanics";
    const IDENTIFIER: &'static str = "CrowdMechanics";
    const DESCRIPTION: &'static str =
        "contact mechanics of a dense crowd: rigid bodies of disks, damped springs, Coulomb friction, walls";
    const STOP_TIME: f64 = 5.0;
    const INTERPOLATES_INPUTS: bool = true;
    const KNOWS_DERIVATIVES: bool = true;
    const SHOWS_INTERMEDIATE_VALUES: bool = true;
    const STATE_VERSION: u32 = 12;
    const SIZES: &'static [Size] = &SIZES;
    const VARIABLES: &'static [Variable<Quantity>] = &QUANTITIES;

    fn load(location: Location<'_>) -> Answer<CrowdModel> {
        let resources = Resources::at(location)?;
        let (packed, warnings) = Packed::load(&resources, resources.first())?;
        let any_size = !matches!(location, Location::Uri(_));
        Ok(CrowdModel { any_size, warnings, ..CrowdModel::of_packed(resources, packed) })
    }

    fn size(&self, place: usize) -> u64 {
        quantities::sizes(&self.trial)[place]
    }

    fn scalars(&self) -> Vec<Scalar<Quantity>> {
        quantities::scalars(&self.packed.trial)
    }

    fn step_size(&self) -> f64 {
        self.trial.parameters.time_step
    }

    fn take_warnings(&mut self) -> Vec<String> {
        std::mem::take(&mut self.warnings)
    }

    #[inline(always)]
    fn number(&mut self, quantity: Quantity, element: usize) -> Answer<f64> {
        let mut value = [0.0];
        match &self.world {
            Some(world) if read(world, quantity, element, &mut value) => Ok(value[0]),
            _ => self.without_world(quantity, element),
        }
    }

    fn numbers(&mut self, quantity: Quantity, values: &mut [f64]) -> Answer<()> {
        if self.world.as_ref().is_some_and(|world| read(world, quantity, 0, values)) {
            return Ok(());
        }
        for (element, value) in values.iter_mut().enumerate() {
            *value = self.number(quantity, element)?;
        }
        Ok(())
    }

    fn text(&self, quantity: Quantity, element: usize) -> &str {
        match quantity {
            Quantity::Trial => &self.packed.trial.name,
            Quantity::AgentId => &self.trial.agents[element].id,
            Quantity::MaterialId => &self.trial.materials.intrinsic[element].id,
            _ => &self.settings.output_directory,
        }
    }

    /// Checks matrices of pairs of materials.
    fn check(&self, quantity: Quantity, values: &[f64]) -> Answer<()> {
        if !quantity.is_of_pairs() {
            return Ok(());
        }
        let (materials, n) = (&self.trial.materials, self.trial.materials.intrinsic.len());
        for (k, &value) in values.iter().enumerate() {
            let Some([one, other]) = ids_of_pair(materials, k) else { continue };
            if value != values[(k % n) * n + k / n] {
                return refuse(format!(
                    "materials {one:?} and {other:?} have two different values: the matrix must be symmetric"
                ));
            }
            if value != 0.0 && place_of_contact(materials, k).is_none() {
                return refuse(format!(
                    "materials {one:?} and {other:?} have no <Contact> in Materials.xml: their value must be 0"
                ));
            }
        }
        Ok(())
    }

    #[inline]
    fn set(&mut self, quantity: Quantity, element: usize, value: f64, phase: Phase) {
        match quantity {
            Quantity::MostMechanicalSteps => {
                self.settings.most_steps = value;
                if self.settings.tolerance.is_some() {
                    self.world = None;
                }
            }
            Quantity::Threads => {
                self.settings.threads = value as i32;
                self.world = None;
            }
            Quantity::IntermediateSteps => self.settings.intermediate_steps = value as i32,
            Quantity::PlayDrive => self.settings.play_drive = value != 0.0,
            Quantity::Active => self.set_present(element, value, phase),
            _ => {
                self.take_over(quantity, element);
                match self.world.as_mut().and_then(|world| input(world, quantity, element)) {
                    Some(input) => *input = value,
                    None => self.world = None,
                }
                if phase != Phase::StepComplete || self.world.is_none() {
                    self.edit(quantity, element, value);
                }
            }
        }
    }

    fn set_texts(&mut self, values: &[(Quantity, &str)]) -> Answer<()> {
        let last =
            |wanted| values.iter().rev().find(|(quantity, _)| *quantity == wanted).map(|(_, value)| *value);
        for (_, value) in values.iter().filter(|(quantity, _)| *quantity == Quantity::Trial) {
            self.known_trial(value)?;
        }
        if let Some(name) = last(Quantity::Trial).filter(|name| *name != self.packed.trial.name) {
            self.choose(name)?;
        }
        if let Some(directory) = last(Quantity::OutputDirectory) {
            directory.clone_into(&mut self.settings.output_directory);
        }
        Ok(())
    }

    fn derivative(&self, quantity: Quantity, element: usize) -> Option<f64> {
        let world = self.world.as_ref()?;
        let i = if quantity.row().is_vector() { element / 2 } else { element };
        let motion = |body: BodyId| match world.is_present(body) {
            true => (world.state().twists[body.index()], world.acceleration(body)),
            false => Default::default(),
        };
        let of = |vector: Vec2| if element.is_multiple_of(2) { vector.x } else { vector.y };
        match quantity {
            Quantity::Position => Some(of(motion(BodyId::from(i)).0.velocity)),
            Quantity::Theta => Some(motion(BodyId::from(i)).0.angular_velocity),
            Quantity::Velocity => Some(of(motion(BodyId::from(i)).1.force)),
            Quantity::Omega => Some(motion(BodyId::from(i)).1.torque),
            // Forces and overlaps are held until the next point: polynomials of order 0 (FMI 2.0.5, section 4.2.1).
            _ => (quantity.row().role == Role::Calculated).then_some(0.0),
        }
    }

    fn set_rate(&mut self, quantity: Quantity, element: usize, rate: f64) {
        self.take_over(quantity, element);
        if matches!(quantity, Quantity::Fp | Quantity::Mp) {
            let rates = self.settings.rates.entry(agent_of_drive(quantity, element)).or_default();
            *part_of_drive(rates, quantity, element) = rate;
        }
    }

    /// Present inputs act from the next step on.
    fn dependencies(&self, computed: Quantity, known: Known) -> Dependencies<Quantity> {
        Dependencies::All(match known {
            Known::Inputs => Vec::new(),
            Known::Starts => computed.row().initially_on.to_vec(),
        })
    }

    fn set_tolerance(&mut self, tolerance: Option<f64>) {
        self.settings.tolerance = tolerance;
        self.world = None;
    }

    fn initialize(&mut self, start: f64) -> Answer<()> {
        self.make_world()?;
        self.warnings.extend(self.warning_of_step());
        make_directory(&self.settings.output_directory)?;
        let inputs_only =
            self.settings.elements.keys().all(|(quantity, _)| quantity.row().role == Role::Input);
        if self.settings.tolerance.is_some() || !inputs_only {
            let advice = Setup::of(&self.trial).advice_as_edited();
            self.warnings.extend(advice.iter().map(|problem| format!("{problem:#}")));
        }
        // Warnings about these centres were given when they were read or set.
        self.said_coincident = self.first_coincident();
        self.played = self.whom_it_plays()?;
        self.play(start);
        self.open_and_close(start)
    }

    fn points(&self, step: f64) -> Vec<f64> {
        let every = u64::try_from(self.settings.intermediate_steps).unwrap_or(0);
        let mechanical_step = self.world.as_ref().map(|world| world.mechanical_step);
        let steps = mechanical_step.and_then(|longest| step_count(step, longest).ok()).unwrap_or(1);
        // A step that is refused is not looked into.
        if every == 0 || steps as f64 > self.settings.most_steps {
            return Vec::new();
        }
        let dt = step / steps as f64;
        (every..steps).step_by(every as usize).map(|seen| dt * seen as f64).collect()
    }

    fn look_ahead(&mut self, from: f64, so_far: f64, point: f64) -> Answer<()> {
        if so_far == 0.0 {
            self.start.clone_from(&self.world);
            self.play(from);
            self.open_and_close(from)?;
        }
        let Some(world) = &mut self.world else { return refuse("not initialized") };
        Ok(world.advance_on(point - so_far, so_far)?)
    }

    fn advance(&mut self, step: Step) -> Result<(), StepError> {
        let Step { from, length, to } = step;
        if let Some(start) = self.start.take() {
            self.world = Some(start);
        }
        self.make_world().map_err(StepError::Refused)?;
        self.few_steps(length).map_err(StepError::Refused)?;
        // The importer's time, which may differ from ours by rounding.
        self.play(from);
        self.open_and_close(from).map_err(StepError::Failed)?;
        self.warn_of_returns(from);
        // Steps that are refused were refused before they changed anything.
        if let Err(error) = self.advance_world(length) {
            return Err(StepError::Failed(Refusal::new(Setup::of(&self.trial).name_body(&error))));
        }
        self.warn_of_coincidence();
        // A rate is used for one step.
        self.settings.rates.clear();
        self.play(to);
        self.write_output(to).map_err(StepError::Failed)
    }

    fn reset(&mut self) -> Answer<()> {
        if self.packed.trial.name != self.resources.first() {
            self.packed = Packed::load(&self.resources, self.resources.first())?.0;
        }
        let (resources, packed) = (self.resources.clone(), self.packed.clone());
        let warnings = std::mem::take(&mut self.warnings);
        *self = CrowdModel { any_size: self.any_size, warnings, ..CrowdModel::of_packed(resources, packed) };
        Ok(())
    }

    fn save(&self) -> Saved {
        self.saved()
    }

    fn restore(&mut self, saved: &Saved) -> Answer<()> {
        self.go_back(saved)
    }
}

impl CrowdModel {
    /// Makes the model of one Trial and its drive, without an FMU.
    pub fn of_trial(trial: Trial, drive: DriveTable) -> CrowdModel {
        let packed = Packed::of(trial.clone());
        CrowdModel::of_packed(Resources::of_one(trial, drive), Arc::new(packed))
    }

    fn of_packed(resources: Resources, packed: Arc<Packed>) -> CrowdModel {
        CrowdModel {
            resources,
            any_size: false,
            trial: packed.trial.clone(),
            packed,
            settings: Settings::default(),
            played: BTreeSet::new(),
            undriven: BTreeSet::new(),
            moved: BTreeSet::new(),
            world: None,
            start: None,
            warnings: Vec::new(),
            said_coincident: None,
        }
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

    /// The agents whom the packed drive drives: those in it of whom the importer has not set Fp or Mp to another value than
    /// the Trial's.
    fn whom_it_plays(&self) -> Answer<BTreeSet<usize>> {
        if !self.settings.play_drive {
            return Ok(BTreeSet::new());
        }
        let (agents, drive) = (self.packed.trial.agents.iter(), &self.packed.drive(&self.resources)?.table);
        let driven = agents.enumerate().filter(|(_, agent)| drive.rows(&agent.id).is_some());
        let mut played: BTreeSet<usize> = driven.map(|(i, _)| i).collect();
        let drives = |i: usize| (self.trial.dynamics[i].fp, self.trial.dynamics[i].mp);
        let packed = |i: usize| (self.packed.trial.dynamics[i].fp, self.packed.trial.dynamics[i].mp);
        played.retain(|&i| drives(i) == packed(i));
        played.retain(|i| !self.settings.rates.contains_key(i) && !self.undriven.contains(i));
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

    /// Opens and closes walls as the Trial says for a time \[s\].
    fn open_and_close(&mut self, time: f64) -> Answer<()> {
        let Some(world) = &mut self.world else { return Ok(()) };
        Ok(Setup::of(&self.trial).open_and_close(time, world)?)
    }

    /// Before an input of an agent is set: the packed drive no longer drives it, as if it had none.
    #[inline]
    fn take_over(&mut self, quantity: Quantity, element: usize) {
        if self.played.is_empty() || !matches!(quantity, Quantity::Fp | Quantity::Mp) {
            return;
        }
        let i = agent_of_drive(quantity, element);
        if self.played.remove(&i)
            && let Some(world) = &mut self.world
        {
            let own = &self.trial.dynamics[i];
            world.drive[i] = Wrench { force: own.fp, torque: own.mp };
        }
    }

    /// Sets whether an agent is there.
    fn set_present(&mut self, agent: usize, value: f64, phase: Phase) {
        let Some(world) = self.world.as_mut().filter(|_| phase == Phase::StepComplete) else {
            self.world = None;
            self.settings.elements.insert((Quantity::Active, agent), value);
            return;
        };
        let body = BodyId::from(agent);
        if world.is_present(body) != (value != 0.0) && !self.moved.remove(&agent) {
            self.moved.insert(agent);
        }
        world.set_present(body, value != 0.0);
    }

    fn make_world(&mut self) -> Answer<&mut World> {
        if self.world.is_none() {
            self.settings.choose_step(&mut self.trial, &self.packed.trial);
            let mut world = Setup::of(&self.trial).world()?;
            give_threads(&mut world, self.settings.threads, None)?;
            self.dismiss(&mut world)?;
            // A state with such forces could not be restored.
            if let Some(i) = world.exposures().iter().position(|exposure| !exposure.is_finite()) {
                let told = format!("agent {:?}: the forces on it are not finite", self.trial.agents[i].id);
                return refuse(told);
            }
            self.world = Some(world);
        }
        Ok(self.world.as_mut().expect("made above"))
    }

    /// Takes those out of a new world who are not there at the start.
    fn dismiss(&self, world: &mut World) -> Answer<()> {
        let absent = self
            .settings
            .elements
            .iter()
            .filter(|((quantity, _), value)| *quantity == Quantity::Active && **value == 0.0);
        let absent: Vec<BodyId> = absent.map(|((_, agent), _)| BodyId::from(*agent)).collect();
        if absent.is_empty() {
            return Ok(());
        }
        absent.into_iter().for_each(|body| world.set_present(body, false));
        let restored = world.restore(world.state().clone());
        Ok(restored.map_err(|crowded| Setup::of(&self.trial).too_crowded(crowded))?)
    }

    /// Says why the tolerance is not kept to.
    fn warning_of_step(&self) -> Option<String> {
        let tolerance = self.settings.tolerance?;
        let step = self.trial.parameters.time_step_mechanical;
        match by_tolerance(&self.trial, tolerance, self.settings.most_steps) {
            Err(None) => None,
            Err(Some(why)) => Some(format!(
                "for the tolerance {tolerance:e} there is no mechanical step: {why}; TimeStepMechanical stays {step:?} s"
            )),
            Ok(_) if tolerance < FINEST_ACCURACY => Some(format!(
                "the tolerance {tolerance:e} is taken as {FINEST_ACCURACY:e}: poses are not known to be more accurate \
                 than {FINEST_ACCURACY:e} m at any mechanical step"
            )),
            Ok(_) => {
                let error = Setup::of(&self.trial).steps()?.error(step);
                (error > tolerance * (1.0 + 1e-9)).then(|| {
                    format!(
                        "the tolerance {tolerance:e} needs more than MostMechanicalSteps = {} mechanical steps in a \
                         TimeStep of {:?} s: TimeStepMechanical is {step:?} s, which is accurate to about {error:.1e} m",
                        self.settings.most_steps, self.trial.parameters.time_step
                    )
                })
            }
        }
    }

    /// Checks that a communication step \[s\] has no more mechanical steps than allowed.
    fn few_steps(&self, step: f64) -> Answer<()> {
        let Some(mechanical_step) = self.world.as_ref().map(|world| world.mechanical_step) else {
            return Ok(());
        };
        let steps = step_count(step, mechanical_step).or_else(|error| refuse(error.to_string()))?;
        let most = self.settings.most_steps;
        if steps as f64 > most {
            return refuse(format!(
                "a communication step of {step:?} s takes {steps} mechanical steps of {mechanical_step:?} s, more than \
                 MostMechanicalSteps = {most}: take shorter communication steps, or set that parameter"
            ));
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

    fn advance_world(&mut self, length: f64) -> Result<(), AdvanceError> {
        let Some(world) = &mut self.world else { return Ok(()) };
        world.drive_rate.fill(Wrench::default());
        for (&i, &rate) in &self.settings.rates {
            world.drive_rate[i] = rate;
        }
        world.advance(length)
    }

    /// Applies a setting of this instance to the documents. A pair of materials that never touches has no law.
    #[cold]
    fn edit(&mut self, quantity: Quantity, element: usize, value: f64) {
        if let Some(field) = field(&mut self.trial, quantity, element) {
            *field = value;
            self.settings.elements.insert((quantity, element), value);
        }
    }

    /// Returns a number of this instance or of the documents, or one for which a world must be made first.
    #[cold]
    fn without_world(&mut self, quantity: Quantity, element: usize) -> Answer<f64> {
        if quantity == Quantity::TimeStepMechanical && self.world.is_none() {
            self.settings.choose_step(&mut self.trial, &self.packed.trial);
        }
        if let Some(field) = field(&mut self.trial, quantity, element) {
            return Ok(*field);
        }
        Ok(match quantity {
            Quantity::Threads => self.settings.threads.into(),
            Quantity::IntermediateSteps => self.settings.intermediate_steps.into(),
            Quantity::PlayDrive => self.settings.play_drive.into(),
            Quantity::MostMechanicalSteps => self.settings.most_steps,
            Quantity::Active => self.settings.elements.get(&(quantity, element)).copied().unwrap_or(1.0),
            _ if quantity.row().role == Role::Calculated => {
                let mut value = [0.0];
                read(self.make_world()?, quantity, element, &mut value);
                value[0]
            }
            _ => 0.0,
        })
    }

    fn known_trial(&self, name: &str) -> Answer<()> {
        if self.resources.names().iter().any(|known| known == name) {
            return Ok(());
        }
        let names = self.resources.names().join(", ");
        refuse(format!("Trial = {name:?}: must be one of the packed Trials: {names}"))
    }

    /// Loads another packed Trial; settings are kept.
    fn choose(&mut self, name: &str) -> Answer<()> {
        let (packed, warnings) = Packed::load(&self.resources, name)?;
        if !self.any_size && quantities::shared(&packed.trial) != quantities::shared(&self.packed.trial) {
            return refuse(format!(
                "the state belongs to another model: Trial {name:?} has other variables than this FMU"
            ));
        }
        // A pair has another element where there are other materials.
        let same = packed.trial.materials.intrinsic.len() == self.trial.materials.intrinsic.len();
        let fits = same || !self.settings.elements.keys().any(|(quantity, _)| quantity.is_of_pairs());
        let edited = self.settings.applied_to(&packed.trial).filter(|_| fits);
        let Some(edited) = edited else {
            return refuse(format!(
                "Trial = {name:?}: values were set of agents or materials that it does not have: choose the Trial \
                 before its values"
            ));
        };
        self.trial = edited;
        self.packed = packed;
        self.warnings.extend(warnings);
        self.world = None;
        Ok(())
    }

    /// Writes the XML files of the paper's script, with its file names, at a communication point \[s\].
    fn write_output(&self, time: f64) -> Answer<()> {
        let (Some(world), false) = (&self.world, self.settings.output_directory.is_empty()) else {
            return Ok(());
        };
        let directory = Path::new(&self.settings.output_directory);
        let [dynamics_name, interactions_name] = output_names(time);
        let (dynamics, interactions) = (directory.join(dynamics_name), directory.join(interactions_name));
        let changes = output(&self.trial, world, dynamics, interactions);
        changes.iter().try_for_each(check_no_link).and_then(|()| change_all(&changes)).or_else(no_output)
    }
}

/// Returns the files of the paper's script for a moment of a world. Of no contacts there is none: that of an earlier
/// run must not be mistaken for one of this run.
pub(crate) fn output(trial: &Trial, world: &World, dynamics: PathBuf, interactions: PathBuf) -> [Change; 2] {
    let motion = dynamics_xml(&trial.agents, &dynamics_of(world), DynamicsElement::Omitted);
    let contacts = match &world.contacts().contacts[..] {
        [] => Change::Remove(interactions),
        _ => {
            let told = interactions_xml(&trial.agents, &trial.geometry, &interactions_of(world));
            Change::Write(interactions, told)
        }
    };
    [contacts, Change::Write(dynamics, motion)]
}

/// Checks that a change does not go through a link, to a file somewhere else.
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

/// Returns the agent of an element of Fp or Mp.
fn agent_of_drive(quantity: Quantity, element: usize) -> usize {
    if quantity == Quantity::Fp { element / 2 } else { element }
}

/// Returns the part of a drive that an element of Fp or Mp is.
fn part_of_drive(drive: &mut Wrench, quantity: Quantity, element: usize) -> &mut f64 {
    match quantity {
        Quantity::Fp if element.is_multiple_of(2) => &mut drive.force.x,
        Quantity::Fp => &mut drive.force.y,
        _ => &mut drive.torque,
    }
}

/// Returns the input of a running world behind an element, if it is one.
#[inline]
fn input(world: &mut World, quantity: Quantity, element: usize) -> Option<&mut f64> {
    let is_drive = matches!(quantity, Quantity::Fp | Quantity::Mp);
    is_drive.then(|| part_of_drive(&mut world.drive[agent_of_drive(quantity, element)], quantity, element))
}

/// Reads elements of a quantity from a running world, from an element on. Returns whether the world
/// has it.
#[inline(always)]
fn read(world: &World, quantity: Quantity, first: usize, values: &mut [f64]) -> bool {
    fn each(first: usize, values: &mut [f64], number: impl Fn(usize) -> f64) {
        values.iter_mut().enumerate().for_each(|(k, value)| *value = number(first + k));
    }
    fn axes(first: usize, values: &mut [f64], vector: impl Fn(usize) -> Vec2) {
        each(first, values, |k| {
            let [x, y] = vector(k / 2).into();
            if k.is_multiple_of(2) { x } else { y }
        });
    }
    let (state, report, exposures) = (world.state(), world.contacts(), world.exposures());
    let faces = world.face_exposures();
    match quantity {
        Quantity::Fp => axes(first, values, |i| world.drive[i].force),
        Quantity::Mp => each(first, values, |i| world.drive[i].torque),
        Quantity::Position => axes(first, values, |i| state.poses[i].position),
        Quantity::Theta => each(first, values, |i| state.poses[i].orientation),
        Quantity::Velocity => axes(first, values, |i| state.twists[i].velocity),
        Quantity::Omega => each(first, values, |i| state.twists[i].angular_velocity),
        Quantity::NormalForce => each(first, values, |i| report.bodies[i].squeeze),
        Quantity::MeanNormalForce => each(first, values, |i| exposures[i].mean_force),
        Quantity::MeanPeopleForce => each(first, values, |i| exposures[i].mean_people_force()),
        Quantity::MeanWallForce => each(first, values, |i| exposures[i].mean_wall_force),
        Quantity::PeakNormalForce => each(first, values, |i| exposures[i].peak_force),
        Quantity::PeakOverlap => each(first, values, |i| exposures[i].peak_overlap),
        // A Trial that was chosen later may have fewer walls, or none.
        Quantity::WallMeanNormalForce => {
            each(first, values, |k| faces.get(k).map_or(0.0, |of| of.mean_force));
        }
        Quantity::WallPeakNormalForce => {
            each(first, values, |k| faces.get(k).map_or(0.0, |of| of.peak_force));
        }
        Quantity::Active => each(first, values, |i| world.is_present(BodyId::from(i)).into()),
        Quantity::AgentContacts => each(first, values, |i| report.bodies[i].agent_contacts.into()),
        Quantity::WallContacts => each(first, values, |i| report.bodies[i].wall_contacts.into()),
        Quantity::ContactingAgents => {
            each(first, values, |i| report.bodies[i].touching_bodies.into());
        }
        Quantity::TotalAgentContacts => values.fill(report.agent_contacts.into()),
        Quantity::TotalWallContacts => values.fill(report.wall_contacts.into()),
        Quantity::CoincidentContacts => values.fill(report.coincident.len() as f64),
        Quantity::LargestOverlap => values.fill(world.largest_overlap()),
        _ => return false,
    }
    true
}

/// Gives a world a number of threads: those of the previous world, if it has as many.
fn give_threads(world: &mut World, threads: i32, so_far: Option<&World>) -> Answer<()> {
    if let Some(so_far) = so_far {
        world.share_threads(so_far);
    }
    let given = world.set_threads(usize::try_from(threads).unwrap_or(1));
    given.or_else(|error| refuse(format!("Threads: {error}")))
}

/// Creates the OutputDirectory, if one is set.
fn make_directory(name: &str) -> Answer<()> {
    let directory = Path::new(name);
    if name.is_empty() {
        return Ok(());
    }
    std::fs::create_dir_all(directory).map_err(WriteError::at(directory)).or_else(no_output)
}

fn no_output(error: WriteError) -> Answer<()> {
    refuse(format!("OutputDirectory: {error}"))
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
