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
use lemons_fmi::variables::{Dependencies, Domain, Known, Scalar, Size, Variable};
use lemons_fmi::{Answer, Model, Phase, Refusal, Step, StepError, damaged, refuse};
use lemons_results::measure::LIMIT;
use lemons_sim::{Documents, SimError};
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// A communication step takes no more steps of the Trial.
const MOST_STEPS: u64 = 100_000;

/// The saved state, without the location of the resources.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SavedSummary {
    /// Of what is in the slots.
    fingerprint: u128,
    /// \[m\]
    tolerance: Option<f64>,
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
    const STATE_VERSION: u32 = 2;
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

    /// Inputs count within steps, and at the start.
    fn dependencies(&self, _: SummaryQuantity, known: Known) -> Dependencies<SummaryQuantity> {
        let inputs = QUANTITIES.iter().map(|row| row.quantity).filter(|of| of.is_input());
        let present = inputs.filter(|of| known == Known::Starts && Model::has(self, *of));
        Dependencies::All(present.collect())
    }

    fn set_tolerance(&mut self, tolerance: Option<f64>) {
        self.tolerance = tolerance;
    }

    fn initialize(&mut self, start: f64) -> Answer<()> {
        Ok(self.begin(start)?)
    }

    fn advance(&mut self, step: Step) -> Result<(), StepError> {
        let steps = self.steps_of(step.length);
        if steps > MOST_STEPS {
            let told = format!(
                "a communication step of {:?} s takes {steps} steps of {:?} s (TimeStep), more than {MOST_STEPS}: nobody \
                 could cancel it",
                step.length,
                self.simulation.trial().parameters.time_step
            );
            return Err(StepError::Refused(Refusal::new(told)));
        }
        let from = self.simulation.time();
        self.step_to(step.to).map_err(|error| match error {
            // Of the first step within.
            SimError::Refused(refusal) if self.simulation.time() == from => StepError::Refused(refusal),
            error => StepError::Failed(error.into()),
        })
    }

    fn reset(&mut self) -> Answer<()> {
        self.simulation.reset()?;
        self.forget();
        Ok(())
    }

    fn save(&self) -> SavedSummary {
        SavedSummary {
            fingerprint: self.fingerprint,
            tolerance: self.tolerance,
            simulation: self.simulation.save(),
            values: self.values.clone(),
            seen: self.seen.clone(),
        }
    }

    fn restore(&mut self, saved: &SavedSummary) -> Answer<()> {
        let SavedSummary { fingerprint, tolerance, simulation, values, seen } = saved;
        if *fingerprint != self.fingerprint {
            return refuse(
                "the state belongs to another summary, with other exits, doors, panels, areas or limit",
            );
        }
        let in_domain = values.iter().zip(&QUANTITIES).all(|(value, row)| row.domain.check(*value).is_ok());
        let positive = tolerance.is_none_or(|tolerance| Domain::Positive.check(tolerance).is_ok());
        let people = self.simulation.ids().len();
        let fits = seen.as_ref().is_none_or(|Seen { start, departures, squeezes }| {
            start.is_finite() && departures.fits(people) && squeezes.fits(people, LIMIT.1)
        });
        let impossible = || damaged("it has other people or variables, or impossible values");
        if values.len() != QUANTITIES.len() || !in_domain || !positive || !fits {
            return impossible();
        }
        let before = self.simulation.save();
        self.simulation.restore(simulation)?;
        if seen.is_some() != self.simulation.world().is_some() {
            self.simulation.restore(&before)?;
            return impossible();
        }
        self.values.clone_from(values);
        self.seen.clone_from(seen);
        (self.tolerance, self.peeked) = (*tolerance, false);
        Ok(())
    }
}
