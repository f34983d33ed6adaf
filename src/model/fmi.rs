//! The crowd as the model of an FMU.

use super::packed::Packed;
use super::running::{agent_of_drive, input, part_of_drive};
use super::saved::SavedCrowd;
use super::{CrowdModel, output};
use crate::engine::{BodyId, Vec2, step_count};
use crate::quantities::{self, CrowdQuantity, QUANTITIES, SIZES, ids_of_pair, place_of_contact};
use crate::resources::Resources;
use crate::setup::Setup;
use lemons_fmi::location::Location;
use lemons_fmi::variables::{Dependencies, Known, Role, Scalar, Size, Variable};
use lemons_fmi::{Answer, Model, Phase, Refusal, Step, StepError, refuse};

impl Model for CrowdModel {
    type Quantity = CrowdQuantity;
    type Saved = SavedCrowd;

    const NAME: &'static str = "LEMONS crowd mechanics";
    const IDENTIFIER: &'static str = "CrowdMechanics";
    const DESCRIPTION: &'static str =
        "contact mechanics of a dense crowd: rigid bodies of disks, damped springs, Coulomb friction, walls";
    const STOP_TIME: f64 = 5.0;
    const INTERPOLATES_INPUTS: bool = true;
    const KNOWS_DERIVATIVES: bool = true;
    const SHOWS_INTERMEDIATE_VALUES: bool = true;
    const STATE_VERSION: u32 = 16;
    const SIZES: &'static [Size] = &SIZES;
    const VARIABLES: &'static [Variable<CrowdQuantity>] = &QUANTITIES;

    fn load(location: Location<'_>) -> Answer<CrowdModel> {
        let resources = Resources::at(location)?;
        let (packed, warnings) = Packed::load(&resources, resources.first())?;
        let any_size = !matches!(location, Location::Uri(_));
        Ok(CrowdModel { any_size, warnings, ..CrowdModel::of_packed(resources, packed) })
    }

    fn size(&self, place: usize) -> u64 {
        quantities::sizes(&self.trial)[place]
    }

    fn scalars(&self) -> Vec<Scalar<CrowdQuantity>> {
        quantities::scalars(&self.packed.trial)
    }

    fn step_size(&self) -> f64 {
        self.trial.parameters.time_step
    }

    fn take_warnings(&mut self) -> Vec<String> {
        std::mem::take(&mut self.warnings)
    }

    #[inline(always)]
    fn number(&mut self, quantity: CrowdQuantity, element: usize) -> Answer<f64> {
        let mut value = [0.0];
        match &self.world {
            Some(world) if quantity.read(world, element, &mut value) => Ok(value[0]),
            _ => self.without_world(quantity, element),
        }
    }

    fn numbers(&mut self, quantity: CrowdQuantity, values: &mut [f64]) -> Answer<()> {
        if self.world.as_ref().is_some_and(|world| quantity.read(world, 0, values)) {
            return Ok(());
        }
        for (element, value) in values.iter_mut().enumerate() {
            *value = self.number(quantity, element)?;
        }
        Ok(())
    }

    fn text(&self, quantity: CrowdQuantity, element: usize) -> &str {
        match quantity {
            CrowdQuantity::Trial => &self.packed.trial.name,
            CrowdQuantity::AgentId => &self.trial.agents[element].id,
            CrowdQuantity::MaterialId => &self.trial.materials.intrinsic[element].id,
            _ => &self.settings.output_directory,
        }
    }

    /// Checks matrices of pairs of materials.
    fn check(&self, quantity: CrowdQuantity, values: &[f64]) -> Answer<()> {
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
    fn set(&mut self, quantity: CrowdQuantity, element: usize, value: f64, phase: Phase) {
        match quantity {
            CrowdQuantity::MostMechanicalSteps => {
                self.settings.most_steps = value;
                if self.settings.tolerance.is_some() {
                    self.world = None;
                }
            }
            CrowdQuantity::Threads => {
                self.settings.threads = value as i32;
                self.world = None;
            }
            CrowdQuantity::IntermediateSteps => self.settings.intermediate_steps = value as i32,
            CrowdQuantity::PlayDrive => self.settings.play_drive = value != 0.0,
            CrowdQuantity::Active => self.set_present(element, value, phase),
            CrowdQuantity::DoorOpen => {
                self.settings.elements.insert((quantity, element), value);
                if phase != Phase::StepComplete {
                    self.world = None;
                }
            }
            _ if quantity.row().role == Role::Tunable && phase == Phase::StepComplete => {
                self.edit(quantity, element, value);
                self.tuned = true;
            }
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

    fn set_texts(&mut self, values: &[(CrowdQuantity, &str)]) -> Answer<()> {
        let last =
            |wanted| values.iter().rev().find(|(quantity, _)| *quantity == wanted).map(|(_, value)| *value);
        for (_, value) in values.iter().filter(|(quantity, _)| *quantity == CrowdQuantity::Trial) {
            self.known_trial(value)?;
        }
        if let Some(name) = last(CrowdQuantity::Trial).filter(|name| *name != self.packed.trial.name) {
            self.choose(name)?;
        }
        if let Some(directory) = last(CrowdQuantity::OutputDirectory) {
            directory.clone_into(&mut self.settings.output_directory);
        }
        Ok(())
    }

    fn derivative(&self, quantity: CrowdQuantity, element: usize) -> Option<f64> {
        let world = self.world.as_ref()?;
        let i = if quantity.row().is_vector() { element / 2 } else { element };
        let motion = |body: BodyId| match world.is_present(body) {
            true => (world.state().twists[body.index()], world.acceleration(body)),
            false => Default::default(),
        };
        let of = |vector: Vec2| if element.is_multiple_of(2) { vector.x } else { vector.y };
        match quantity {
            CrowdQuantity::Position => Some(of(motion(BodyId::from(i)).0.velocity)),
            CrowdQuantity::Theta => Some(motion(BodyId::from(i)).0.angular_velocity),
            CrowdQuantity::Velocity => Some(of(motion(BodyId::from(i)).1.force)),
            CrowdQuantity::Omega => Some(motion(BodyId::from(i)).1.torque),
            // Forces and overlaps are held until the next point: polynomials of order 0 (FMI 2.0.5, section 4.2.1).
            _ => (quantity.row().role == Role::Calculated).then_some(0.0),
        }
    }

    fn set_rate(&mut self, quantity: CrowdQuantity, element: usize, rate: f64) {
        self.take_over(quantity, element);
        if matches!(quantity, CrowdQuantity::Fp | CrowdQuantity::Mp) {
            let rates = self.settings.rates.entry(agent_of_drive(quantity, element)).or_default();
            *part_of_drive(rates, quantity, element) = rate;
        }
    }

    /// Present inputs act from the next step on.
    fn dependencies(&self, computed: CrowdQuantity, known: Known) -> Dependencies<CrowdQuantity> {
        let on = match known {
            Known::Inputs => &[][..],
            Known::Starts => computed.row().initially_on,
        };
        // Trials without doors have no such input.
        let doors = self.trial.geometry.doors().next().is_some();
        Dependencies::All(on.iter().copied().filter(|on| doors || *on != CrowdQuantity::DoorOpen).collect())
    }

    fn set_tolerance(&mut self, tolerance: Option<f64>) {
        self.settings.tolerance = tolerance;
        self.world = None;
    }

    fn initialize(&mut self, start: f64) -> Answer<()> {
        self.make_world()?;
        self.warnings.extend(self.settings.warning_of_step(&self.trial));
        output::make_directory(&self.settings.output_directory)?;
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
        self.open_and_close(start, true)
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
            self.retune(point)?;
            self.start.clone_from(&self.world);
            self.play(from);
            self.open_and_close(from, false)?;
            self.let_come();
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
        self.retune(length).map_err(StepError::Refused)?;
        let mechanical_step = self.world.as_ref().map_or(f64::INFINITY, |world| world.mechanical_step);
        self.few_steps(length, mechanical_step).map_err(StepError::Refused)?;
        // The importer's time, which may differ from ours by rounding.
        self.play(from);
        self.open_and_close(from, false).map_err(StepError::Failed)?;
        self.let_come();
        self.warn_of_returns(from);
        // Steps that are refused were refused before they changed anything.
        if let Err(error) = self.advance_world(length) {
            return Err(StepError::Failed(Refusal::new(Setup::of(&self.trial).name_body(&error))));
        }
        if let Some(world) = &mut self.world {
            Setup::of(&self.trial)
                .carry_over_links(world)
                .map_err(|error| StepError::Failed(error.into()))?;
        }
        self.warn_of_coincidence();
        // A rate is used for one step.
        self.settings.rates.clear();
        self.play(to);
        let Some(world) = &self.world else { return Ok(()) };
        output::write(&self.trial, world, &self.settings.output_directory, to).map_err(StepError::Failed)
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

    fn save(&self) -> SavedCrowd {
        self.saved()
    }

    fn restore(&mut self, saved: &SavedCrowd) -> Answer<()> {
        self.go_back(saved)
    }
}
