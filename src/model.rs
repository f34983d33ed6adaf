//! The crowd behind an FMU instance: a Trial's documents, and the world that is built from them.
//!
//! A parameter is an edit of the documents. When initialization ends, the engine's world is built from them.

mod fmi;
mod output;
mod packed;
mod running;
mod saved;
mod settings;

pub(crate) use output::output;
pub use saved::SavedCrowd;

use crate::engine::{AdvanceError, BodyId, Pair, World, Wrench, step_count, vec2};
use crate::quantities::{self, CrowdQuantity, field};
use crate::resources::Resources;
use crate::setup::Setup;
use lemons_core::plane::Motion;
use lemons_core::trial::{DriveTable, Trial};
use lemons_fmi::variables::Role;
use lemons_fmi::{Answer, Phase, refuse};
use packed::Packed;
use running::{agent_of_drive, give_threads};
use settings::Settings;
use std::collections::BTreeSet;
use std::sync::Arc;

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
    /// Whether tunable parameters were set since the last step: the world does not have them yet.
    tuned: bool,
    /// Made when initialization ends, or earlier if a computed output is read. While an importer looks ahead, it is there.
    world: Option<World>,
    /// While an importer looks ahead: the world at the beginning of the step.
    start: Option<World>,
    /// Warnings that were not yet returned.
    warnings: Vec<String>,
    /// The first pair of the last warning about coinciding centres.
    said_coincident: Option<Pair>,
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
            tuned: false,
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

    /// Opens and closes walls as the Trial and the importer say for a time \[s\], at which the simulation may begin.
    fn open_and_close(&mut self, time: f64, begins: bool) -> Answer<()> {
        let Some(world) = &mut self.world else { return Ok(()) };
        let (setup, settings) = (Setup::of(&self.trial), &self.settings);
        let operate = if begins { Setup::begin } else { Setup::open_and_close };
        Ok(operate(&setup, time, |door| settings.shuts(door), world)?)
    }

    /// Before an input of an agent is set: the packed drive no longer drives it, as if it had none.
    #[inline]
    fn take_over(&mut self, quantity: CrowdQuantity, element: usize) {
        if self.played.is_empty() || !matches!(quantity, CrowdQuantity::Fp | CrowdQuantity::Mp) {
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
            self.settings.elements.insert((CrowdQuantity::Active, agent), value);
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
            Setup::of(&self.trial).begin(0.0, |door| self.settings.shuts(door), &mut world)?;
            // A state with such forces could not be restored.
            if let Some(i) = world.exposures().iter().position(|exposure| !exposure.is_finite()) {
                let told = format!("agent {:?}: the forces on it are not finite", self.trial.agents[i].id);
                return refuse(told);
            }
            self.world = Some(world);
        }
        Ok(self.world.as_mut().expect("made above"))
    }

    /// Gives the world the tunable parameters that were set since the last step, if a step \[s\] can be made with them. Poses,
    /// motions and springs stay; forces, and what springs hold, follow from the new laws.
    fn retune(&mut self, step: f64) -> Answer<()> {
        let Some(running) = self.running().filter(|_| self.tuned) else { return Ok(()) };
        self.settings.choose_step(&mut self.trial, &self.packed.trial);
        let mut world = Setup::of(&self.trial).world()?;
        self.few_steps(step, world.mechanical_step)?;
        self.run_on(&mut world, &running, self.settings.threads)?;
        (self.world, self.tuned) = (Some(world), false);
        let advice = Setup::of(&self.trial).advice_as_edited();
        self.warnings.extend(advice.iter().map(|problem| format!("{problem:#}")));
        Ok(())
    }

    /// Takes those out of a new world whom the importer says not to be there at the start, and puts those in who are.
    fn dismiss(&self, world: &mut World) -> Answer<()> {
        let said =
            self.settings.elements.iter().filter(|((quantity, _), _)| *quantity == CrowdQuantity::Active);
        let said = said.map(|((_, agent), value)| (BodyId::from(*agent), *value != 0.0));
        let other: Vec<_> = said.filter(|(body, there)| world.is_present(*body) != *there).collect();
        if other.is_empty() {
            return Ok(());
        }
        other.into_iter().for_each(|(body, there)| world.set_present(body, there));
        let restored = world.restore(world.state().clone());
        Ok(restored.map_err(|crowded| Setup::of(&self.trial).too_crowded(crowded))?)
    }

    /// Checks that a communication step \[s\] has no more mechanical steps than allowed.
    fn few_steps(&self, step: f64, mechanical_step: f64) -> Answer<()> {
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
            self.warnings.extend(told.map(|told| told.text));
        }
        self.said_coincident = first;
    }

    /// Who comes for the first time, where the Trial says, moves as the Trial says.
    fn let_come(&mut self) {
        let Some(world) = &mut self.world else { return };
        for &i in &self.moved {
            let (body, Motion { pose, twist }) = (BodyId::from(i), self.trial.dynamics[i].motion());
            if world.is_present(body) && world.state().poses[i] == pose {
                world.set_twist(body, twist);
            }
        }
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
            let overlaps = Setup::of(&self.trial).overlaps_of(&then, &back, time);
            self.warnings.extend(overlaps.into_iter().map(|overlap| overlap.text));
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
    fn edit(&mut self, quantity: CrowdQuantity, element: usize, value: f64) {
        if let Some(field) = field(&mut self.trial, quantity, element) {
            *field = value;
            self.settings.elements.insert((quantity, element), value);
        }
    }

    /// Returns a number of this instance or of the documents, or one for which a world must be made first.
    #[cold]
    fn without_world(&mut self, quantity: CrowdQuantity, element: usize) -> Answer<f64> {
        if quantity == CrowdQuantity::TimeStepMechanical && self.world.is_none() {
            self.settings.choose_step(&mut self.trial, &self.packed.trial);
        }
        if let Some(field) = field(&mut self.trial, quantity, element) {
            return Ok(*field);
        }
        Ok(match quantity {
            CrowdQuantity::Threads => self.settings.threads.into(),
            CrowdQuantity::IntermediateSteps => self.settings.intermediate_steps.into(),
            CrowdQuantity::PlayDrive => self.settings.play_drive.into(),
            CrowdQuantity::MostMechanicalSteps => self.settings.most_steps,
            CrowdQuantity::DoorOpen => {
                self.settings.elements.get(&(quantity, element)).copied().unwrap_or(1.0)
            }
            CrowdQuantity::Active => {
                let usual = f64::from(!self.trial.dynamics[element].absent);
                self.settings.elements.get(&(quantity, element)).copied().unwrap_or(usual)
            }
            _ if quantity.row().role == Role::Calculated => {
                let mut value = [0.0];
                quantity.read(self.make_world()?, element, &mut value);
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
}
