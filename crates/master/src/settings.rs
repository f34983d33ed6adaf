//! Settings of a run.

use crate::error::{ErrorPlace, MasterError, Result, require};
use crate::saved::SavedRun;
use crate::trial_input::DecisionChoice;
use crowd_mechanics::model_description::DEFAULT_STOP_TIME;
use lemons_core::trial::{DriveChoice, DriveTable, PanelChoice};
use lemons_sim::{Algorithm, Clock, lint};
use std::path::{Path, PathBuf};

/// Settings of a run: all that somebody has to say of a run. See [`PreparedSystem::of`](crate::PreparedSystem::of).
#[derive(Debug, Clone, Default)]
pub struct RunSettings {
    /// A Trial (its directory, or a zip of it), an FMU, or an SSP (by its extension).
    pub input: PathBuf,
    /// Parameters and start values: names as in [`Fmu::values_of`](crate::Fmu::values_of), in an SSP `component.name`; and
    /// values as text. They are set in this order. Of people who walk, names without a component are the crowd's.
    pub parameters: Vec<(String, String)>,
    /// The number of threads of the crowd; not for an SSP, where it is a parameter of each component.
    pub threads: Option<i32>,
    /// The tolerance of the experiment, positive and finite; not for a saved run, which contains its mechanical step. Each FMU
    /// gets it, and makes of it what it can. A crowd takes it as the accuracy \[m\] for which its mechanical step is chosen.
    /// Default: that of an FMU's own DefaultExperiment, else none.
    pub tolerance: Option<f64>,
    /// \[s\] The communication step, finite and greater than 0. Default: the Trial's TimeStep; of several components, the smallest.
    pub step: Option<f64>,
    /// \[s\] The end of the run, finite and after its start. Default: that of the saved run, the stop time of the SSP, or 5 s.
    pub until: Option<f64>,
    /// One communication point in so many is recorded, beginning with the first: at least 1. Default: that of the saved
    /// run, or 1.
    pub every: Option<u64>,
    /// The drive: who is pushed when; in an SSP, connections feed the inputs instead.
    pub drive: DriveChoice,
    /// Where a Trial's people walk: then the input is coupled like an SSP of the components `decision` and `crowd`.
    pub decision: DecisionChoice,
    /// Further panels of a Trial's walls, for loads.
    pub panels: Option<PanelChoice>,
    /// How coupled components exchange values.
    pub algorithm: Algorithm,
    /// A saved run, which goes on. It contains the parameters and the number of threads.
    pub resume: Option<PathBuf>,
    /// True if the run is to be saved: then each FMU must be able to save its state.
    pub saves: bool,
}

impl RunSettings {
    /// Makes settings with the default of everything else.
    pub fn of(input: impl Into<PathBuf>) -> RunSettings {
        RunSettings { input: input.into(), ..RunSettings::default() }
    }

    /// Reads the saved run that goes on, with the states of its components.
    ///
    /// # Errors
    /// It is none, or something is set that it contains.
    pub fn saved(&self) -> Result<Option<(SavedRun, Vec<Vec<u8>>)>> {
        let Some(path) = &self.resume else { return Ok(None) };
        let contained = match (self.parameters.first(), self.threads) {
            (None, None) => return SavedRun::read(path).map(Some),
            (Some((name, value)), _) => format!("{name}={value}"),
            (None, Some(threads)) => format!("{threads} threads"),
        };
        let why = "the saved run contains its parameters, and they cannot be changed";
        Err(MasterError::Misused(format!("--resume: {contained}: {why}")))
    }

    /// Returns the communication points of a run, the number of them for one that is recorded, and warnings. It begins
    /// at `start`, or goes on; `stop` and `step` count if neither the settings nor the saved run say others. All in
    /// seconds.
    ///
    /// # Errors
    /// The end is not after the beginning, nothing says how long a step is, or the saved run went otherwise.
    pub fn points(
        &self,
        before: Option<&SavedRun>,
        start: f64,
        [stop, step]: [Option<f64>; 2],
        drive: &DriveTable,
    ) -> Result<(Clock, u64, Vec<String>)> {
        let until = self.until.or(before.map(|before| before.until)).or(stop).unwrap_or(DEFAULT_STOP_TIME);
        let (is, first) =
            before.map_or(("it starts at", start), |before| ("the saved run is at", before.time));
        require(until > first, || {
            format!("nothing to simulate: {is} {first:?} s and stops at {until:?} s (--until)")
        })?;
        let step = self.step.or(before.map(|before| before.step)).or(step);
        let step = step.ok_or("no FMU has a DefaultExperiment with a stepSize: give --step")?;
        let every = self.every.or(before.map(|before| before.every)).unwrap_or(1);
        if let Some(SavedRun { drive: known, step: saved, every: saved_every, .. }) = before {
            require(
                drive.fingerprint() == *known,
                || "the saved run had another drive: give the same drive file as before, or --no-drive as before",
            )?;
            require(step == *saved, || {
                format!("--step: a communication step of {step:?} s: the saved run has one of {saved:?} s")
            })?;
            require(every == *saved_every, || {
                format!("--every: one communication point in {every}: the saved run has one in {saved_every}")
            })?;
        }
        let clock = Clock::new(start, step, until).place(|| self.input.display().to_string())?;
        let missed = lint::missed(drive, start, step, Path::new("drive")).map(|found| found.to_string());
        let begun = before.map(|before| (before.time, before.index));
        let saved = self.saves.then_some((clock.until, clock.steps));
        let between = begun.into_iter().chain(saved).find(|(time, index)| *time != clock.point(*index));
        let between = between.map(|(time, _)| {
            format!(
                "warning: t = {time:?} s is between two communication points ({step:?} s apart): a run that goes on \
                 from there has one more, so its results are not those of a run without interruption (--until, --step)"
            )
        });
        Ok((clock, every, missed.into_iter().chain(between).collect()))
    }
}
