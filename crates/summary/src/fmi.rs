//! The summary as the model of an FMU.

use crate::config::{SUMMARY_FILE, SummaryConfig};
use crate::quantities::{QUANTITIES, SummaryQuantity};
use crate::{Seen, Summary};
use crowd_mechanics::setup;
use lemons_core::files::input;
use lemons_core::files::source::LocalFiles;
use lemons_core::trial::DriveTable;
use lemons_decision::{DECISION_FILE, Plan};
use lemons_fmi::location::Location;
use lemons_fmi::variables::{Dependencies, Known, Scalar, Size, Variable};
use lemons_fmi::{Answer, Model, Phase, Refusal, Step, StepError, damaged, refuse};
use lemons_sim::Documents;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// The saved state, without the location of the resources.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SavedSummary {
    simulation: Vec<u8>,
    /// Inputs, too.
    pub(crate) values: Vec<f64>,
    seen: Option<Seen>,
}

impl Model for Summary {
    type Quantity = SummaryQuantity;
    type Saved = SavedSummary;

    const NAME: &'static str = "LEMONS summary";
    const IDENTIFIER: &'static str = "CrowdSummary";
    const DESCRIPTION: &'static str =
        "a dense crowd and where its people walk, in a few numbers: exits, areas, barriers";
    const STOP_TIME: f64 = 30.0;
    const STATE_VERSION: u32 = 1;
    const SIZES: &'static [Size] = &[];
    const VARIABLES: &'static [Variable<SummaryQuantity>] = &QUANTITIES;

    fn load(location: Location<'_>) -> Answer<Summary> {
        let candidates = location.directories()?;
        let Some(directory) = candidates.iter().find(|directory| directory.join(SUMMARY_FILE).exists())
        else {
            let (location, path) = (location.text(), &candidates[0]);
            return refuse(format!(
                "the resource location {location:?} is {path:?}, which has no {SUMMARY_FILE}"
            ));
        };
        let (trial, _) = setup::read(directory).map_err(|problems| Refusal::new(problems.to_string()))?;
        let drive =
            DriveTable::own(&LocalFiles, &trial).map_err(|problems| Refusal::new(problems.to_string()))?;
        let walks = directory.join(DECISION_FILE).exists();
        let plan = walks.then(|| Plan::beside(&trial, directory)).transpose().map_err(Refusal::new)?;
        let text = input::read_text(&directory.join(SUMMARY_FILE), input::LARGEST_SETTINGS)?;
        let config = SummaryConfig::from_toml(&text)?;
        Ok(Summary::new(Documents::new(trial, drive, plan), &config)?)
    }

    fn size(&self, _: usize) -> u64 {
        0
    }

    fn has(&self, SummaryQuantity { what, slot }: SummaryQuantity) -> bool {
        Summary::has(self, what, slot)
    }

    /// Says which exit, door, area or panel it is.
    fn about(&self, variable: &Variable<SummaryQuantity>) -> Cow<'static, str> {
        let SummaryQuantity { what, slot } = variable.quantity;
        match self.slots.names(what).and_then(|names| names.get(slot)) {
            Some(name) => format!("{name}: {}", variable.description).into(),
            None => variable.description.into(),
        }
    }

    fn scalars(&self) -> Vec<Scalar<SummaryQuantity>> {
        let of = QUANTITIES.iter().filter(|variable| Model::has(self, variable.quantity));
        let scalar = |variable: &'static Variable<SummaryQuantity>| Scalar {
            name: variable.name.to_owned(),
            description: self.about(variable).into_owned(),
            variable,
            element: 0,
        };
        of.map(scalar).collect()
    }

    fn step_size(&self) -> f64 {
        self.simulation.trial().parameters.time_step
    }

    fn take_warnings(&mut self) -> Vec<String> {
        self.simulation.take_warnings()
    }

    fn number(&mut self, quantity: SummaryQuantity, _: usize) -> Answer<f64> {
        // Before initialization ends, importers see the start.
        if self.seen.is_none() && !self.peeked && !quantity.is_input() {
            let inputs = self.values.clone();
            self.begin(0.0)?;
            self.simulation.reset()?;
            (self.seen, self.peeked) = (None, true);
            for (row, (value, input)) in QUANTITIES.iter().zip(self.values.iter_mut().zip(inputs)) {
                *value = if row.quantity.is_input() { input } else { *value };
            }
        }
        Ok(self.values[quantity.place()])
    }

    fn text(&self, _: SummaryQuantity, _: usize) -> &str {
        ""
    }

    fn set(&mut self, quantity: SummaryQuantity, _: usize, value: f64, _: Phase) {
        self.values[quantity.place()] = value;
    }

    /// Inputs count within steps.
    fn dependencies(&self, _: SummaryQuantity, _: Known) -> Dependencies<SummaryQuantity> {
        Dependencies::All(Vec::new())
    }

    fn set_tolerance(&mut self, tolerance: Option<f64>) {
        self.tolerance = tolerance;
    }

    fn initialize(&mut self, start: f64) -> Answer<()> {
        Ok(self.begin(start)?)
    }

    fn advance(&mut self, step: Step) -> Result<(), StepError> {
        self.step_to(step.to).map_err(|error| StepError::Failed(error.into()))
    }

    fn reset(&mut self) -> Answer<()> {
        self.simulation.reset()?;
        self.forget();
        Ok(())
    }

    fn save(&self) -> SavedSummary {
        let (values, seen) = (self.values.clone(), self.seen.clone());
        SavedSummary { simulation: self.simulation.save(), values, seen }
    }

    fn restore(&mut self, saved: &SavedSummary) -> Answer<()> {
        let SavedSummary { simulation, values, seen } = saved;
        let in_domain = values.iter().zip(&QUANTITIES).all(|(value, row)| row.domain.check(*value).is_ok());
        let people = self.simulation.ids().len();
        let fits = seen
            .as_ref()
            .is_none_or(|seen| seen.departures.times().len() == people && seen.start.is_finite());
        if values.len() != QUANTITIES.len() || !in_domain || !fits {
            return damaged("it has other people or variables, or impossible values");
        }
        self.simulation.restore(simulation)?;
        self.values.clone_from(values);
        self.seen.clone_from(seen);
        Ok(())
    }
}
