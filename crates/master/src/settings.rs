//! What is run, and how.

use crate::decider::PlanChoice;
use crate::prepare_error::{PrepareError, Warning};
use crate::saved::Saved;
use crowd_mechanics::model_description::DEFAULT_STOP_TIME;
use lemons_core::trial::DriveChoice;
use lemons_sim::{Algorithm, Clock};
use std::path::PathBuf;

/// What is run, and how: all that somebody has to say of a run. See [`Prepared::of`](crate::Prepared::of).
#[derive(Debug, Clone)]
pub struct Settings {
    /// A Trial (its directory, or a zip of it), an FMU, or an SSP (by its extension).
    pub input: PathBuf,
    /// Parameters and start values: names as in [`Fmu::named`](crate::Fmu::named), in an SSP `component.name`; and
    /// values as text. They are set in this order. Of people who walk, names without a component are the crowd's.
    pub parameters: Vec<(String, String)>,
    /// The number of threads of the crowd; not for an SSP, where it is a parameter of each component.
    pub threads: Option<i32>,
    /// The tolerance of the experiment, positive and finite: each FMU gets it, and makes of it what it can. A crowd takes it
    /// as the accuracy \[m\] for which it chooses its mechanical step. Default: that of an FMU's own DefaultExperiment,
    /// else none.
    pub tolerance: Option<f64>,
    /// \[s\] The communication step, finite and greater than 0. Default: the Trial's TimeStep; of several components, the smallest.
    pub step: Option<f64>,
    /// \[s\] The end of the run, finite and after its start. Default: that of the saved run, the stop time of the SSP, or 5 s.
    pub until: Option<f64>,
    /// One communication point in so many is recorded, beginning with the first: at least 1. Default: that of the saved
    /// run, or 1.
    pub every: Option<u64>,
    /// Who is pushed when; in an SSP, connections feed the inputs instead.
    pub drive: DriveChoice,
    /// Where a Trial's people walk: then the input is coupled like an SSP of the components `decision` and `crowd`.
    pub plan: PlanChoice,
    /// How coupled components exchange values.
    pub algorithm: Algorithm,
    /// A saved run, which goes on. It contains the parameters and the number of threads.
    pub resume: Option<PathBuf>,
    /// Whether the run is to be saved: then each FMU must be able to save its state.
    pub saves: bool,
}

impl Settings {
    /// With the default of everything else.
    pub fn of(input: impl Into<PathBuf>) -> Settings {
        Settings {
            input: input.into(),
            parameters: Vec::new(),
            threads: None,
            tolerance: None,
            step: None,
            until: None,
            every: None,
            drive: DriveChoice::Own,
            plan: PlanChoice::Own,
            algorithm: Algorithm::default(),
            resume: None,
            saves: false,
        }
    }
    /// Checks that nothing is set that a saved run contains, and that points are recorded.
    ///
    /// # Errors
    /// The first setting that cannot be.
    pub fn check(&self) -> Result<(), PrepareError> {
        match (&self.resume, self.tolerance, self.parameters.first(), self.threads) {
            _ if self.every == Some(0) => Err(PrepareError::Every),
            (None, ..) | (Some(_), None, None, None) => Ok(()),
            (Some(_), Some(tolerance), ..) => Err(PrepareError::Tolerance(tolerance)),
            (Some(_), None, Some((name, value)), _) => {
                Err(PrepareError::Parameter { name: name.clone(), value: value.clone() })
            }
            (Some(_), None, None, Some(threads)) => Err(PrepareError::Threads(threads)),
        }
    }

    /// Returns the end \[s\] of a run that begins at a time \[s\], or goes on.
    ///
    /// # Errors
    /// It is not after the beginning.
    pub fn until_of(
        &self,
        before: Option<&Saved>,
        start: f64,
        stop: Option<f64>,
    ) -> Result<f64, PrepareError> {
        let until = self.until.or(before.map(|before| before.until)).or(stop).unwrap_or(DEFAULT_STOP_TIME);
        let first = before.map_or(start, |before| before.time);
        if until <= first {
            return Err(PrepareError::Nothing { first, until, resumed: before.is_some() });
        }
        Ok(until)
    }

    /// Returns communication step \[s\] and recorded points of a saved run, which goes on as it went before.
    ///
    /// # Errors
    /// Others are set.
    pub fn same_points(&self, before: &Saved) -> Result<(f64, u64), PrepareError> {
        if let Some(step) = self.step.filter(|step| *step != before.step) {
            return Err(PrepareError::OtherStep { step, saved: before.step });
        }
        if let Some(every) = self.every.filter(|every| *every != before.every) {
            return Err(PrepareError::OtherEvery { every, saved: before.every });
        }
        Ok((before.step, before.every))
    }

    /// Returns a warning of a run that goes on from, or is saved, between two communication points.
    pub fn between(&self, before: Option<&Saved>, clock: &Clock) -> Option<Warning> {
        let begun = before.map(|before| (before.time, before.index));
        let saved = self.saves.then_some((clock.until, clock.steps));
        let between = begun.into_iter().chain(saved).find(|(time, index)| *time != clock.point(*index));
        between.map(|(time, _)| Warning::Between { time, step: clock.step })
    }
}
