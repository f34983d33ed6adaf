//! Values that importers have set, and the mechanical step that follows from them.

use crate::engine::Wrench;
use crate::quantities::{CrowdQuantity, MOST_MECHANICAL_STEPS, field};
use crate::setup::{FINEST_ACCURACY, Setup};
use lemons_core::trial::Trial;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Values that importers have set, other than those of inputs at communication points. States hold them in this order.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Settings {
    /// Elements of quantities: of the documents, who is there at the start, and which doors are open.
    pub elements: BTreeMap<(CrowdQuantity, usize), f64>,
    pub play_drive: bool,
    pub threads: i32,
    /// A communication step with more mechanical steps is refused.
    pub most_steps: f64,
    /// Mechanical steps between intermediate updates; 0 for none.
    pub intermediate_steps: i32,
    pub output_directory: String,
    /// Rates of the inputs over the next step, by agent; missing ones are constant.
    pub rates: BTreeMap<usize, Wrench>,
    /// \[m\] of the importer's experiment: may shorten the mechanical step.
    pub tolerance: Option<f64>,
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
    pub fn choose_step(&self, trial: &mut Trial, packed: &Trial) {
        let Some(tolerance) = self.tolerance else { return };
        let set = self.elements.get(&(CrowdQuantity::TimeStepMechanical, 0));
        let longest = set.copied().unwrap_or(packed.parameters.time_step_mechanical);
        let needed = match by_tolerance(trial, tolerance, self.most_steps) {
            Ok(step) => step,
            Err(None) => longest,
            // Also if a longer step was set for the tolerance to choose.
            Err(Some(_)) => packed.parameters.time_step_mechanical,
        };
        trial.parameters.time_step_mechanical = longest.min(needed);
    }

    /// Returns whether a door is shut, whatever its times are.
    pub fn shuts(&self, door: usize) -> bool {
        self.elements.get(&(CrowdQuantity::DoorOpen, door)) == Some(&0.0)
    }

    /// Returns a packed Trial with these settings; `None` if it does not have what was set.
    pub fn applied_to(&self, packed: &Trial) -> Option<Trial> {
        let mut trial = packed.clone();
        for (&(quantity, element), &value) in &self.elements {
            match quantity {
                CrowdQuantity::Active => {
                    trial.agents.get(element)?;
                }
                // Another Trial may have fewer doors.
                CrowdQuantity::DoorOpen => {}
                _ => *field(&mut trial, quantity, element)? = value,
            }
        }
        Some(trial)
    }

    /// Says why the tolerance is not kept to.
    pub fn warning_of_step(&self, trial: &Trial) -> Option<String> {
        let tolerance = self.tolerance?;
        let step = trial.parameters.time_step_mechanical;
        match by_tolerance(trial, tolerance, self.most_steps) {
            Err(None) => None,
            Err(Some(why)) => Some(format!(
                "for the tolerance {tolerance:e} there is no mechanical step: {why}; TimeStepMechanical stays {step:?} s"
            )),
            Ok(_) if tolerance < FINEST_ACCURACY => Some(format!(
                "the tolerance {tolerance:e} is taken as {FINEST_ACCURACY:e}: poses are not known to be more accurate \
                 than {FINEST_ACCURACY:e} m at any mechanical step"
            )),
            Ok(_) => {
                let error = Setup::of(trial).steps()?.error(step);
                (error > tolerance * (1.0 + 1e-9)).then(|| {
                    format!(
                        "the tolerance {tolerance:e} needs more than MostMechanicalSteps = {} mechanical steps in a \
                         TimeStep of {:?} s: TimeStepMechanical is {step:?} s, which is accurate to about {error:.1e} m",
                        self.most_steps, trial.parameters.time_step
                    )
                })
            }
        }
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
