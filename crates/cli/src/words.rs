//! What a library says of a run, in the words of the command: with the options that mean it.

use crate::error::{Misused, TrialHasErrors};
use anyhow::{Result, anyhow};
use lemons_core::trial::Missed;
use lemons_core::trial::{Problems, Trial};
use lemons_master::{Error, Given, PrepareError, Warning};
use std::path::Path;

const FIXED: &str = "the saved run contains its parameters, and they cannot be changed";

/// Why a run cannot be prepared. Errors of a Trial are printed.
pub fn refused(error: PrepareError) -> anyhow::Error {
    use PrepareError as E;
    match error {
        E::Parameter { name, value } => {
            Misused(format!("--set {name}={value} with --resume: {FIXED}")).into()
        }
        E::Threads(threads) => Misused(format!("--threads {threads} with --resume: {FIXED}")).into(),
        E::Tolerance(tolerance) => Misused(format!("--accuracy {tolerance:?} with --resume: {FIXED}")).into(),
        E::ThreadsOfCoupled(threads) => {
            anyhow!("--threads is for a Trial or an FMU: in an SSP, --set NAME.Threads={threads}")
        }
        E::DriveOfCoupled => {
            anyhow!("--drive is for a Trial or an FMU: in an SSP inputs are fed by connections")
        }
        E::OfOther { name, value, meant } => {
            anyhow!("--set {name}={value}: there is no such variable; did you mean --set {meant}={value}?")
        }
        E::NowWalks(_) => anyhow!("{error}: give --no-plan to go on as before"),
        E::NoLongerWalks => anyhow!("{error}: go on without --no-plan, and with the file as it was (--plan)"),
        E::PlanWithoutTrial => Misused(format!("--plan: {error}")).into(),
        E::NotSaved(_) => anyhow!("{error} (--state writes one)"),
        E::Component { name, value, components } => anyhow!(
            "--set {name}={value}: expected COMPONENT.NAME=VALUE; components are {}",
            components.join(", ")
        ),
        E::CannotSave { .. } => anyhow!("{error} (--state, --resume)"),
        E::Nothing { .. } => anyhow!("{error} (--until)"),
        E::NoStep => anyhow!("{error}: give --step"),
        E::OtherStep { step, saved } => {
            anyhow!("--step {step:?}: the saved run has a communication step of {saved:?} s")
        }
        E::OtherEvery { every, saved } => anyhow!("--every {every}: the saved run has --every {saved}"),
        E::Every => anyhow!("{error} (--every)"),
        E::OtherDrive => {
            anyhow!("{error}: give the same drive file as before, or --no-drive as before")
        }
        E::Run(error) => trial_told(error.into()),
    }
}

/// Prints the errors of a Trial; any other error is returned as it is.
pub fn trial_told(error: anyhow::Error) -> anyhow::Error {
    match error.downcast() {
        Ok(Error::Broken { path, problems }) => broken(&path, &problems),
        Ok(error) => error.into(),
        Err(error) => error,
    }
}

/// A Trial with its warnings. Errors are printed.
pub fn read_or_say(given: &Given) -> Result<(Trial, Problems)> {
    given.read().map_err(|problems| broken(given.path(), &problems))
}

/// Prints the errors of a Trial.
pub fn broken(path: &Path, problems: &Problems) -> anyhow::Error {
    note!("{problems}");
    note!("lemons: {} has errors", path.display());
    TrialHasErrors.into()
}

/// What is probably not meant.
pub fn warned(warning: &Warning) -> String {
    match warning {
        Warning::Ignored(_) | Warning::Differs { .. } => format!("warning: {warning}"),
        Warning::Overwritten { .. } => format!("warning: --set {warning}"),
        Warning::DriveOfWalkers { .. } => format!("note: {warning} (--no-drive: only these)"),
        Warning::DriveReplaced(_) => format!("note: {warning}"),
        Warning::Between { .. } => format!("warning: {warning} (--until, --step)"),
        Warning::Still => format!("note: {warning} (lemons decide --help, --drive)"),
        Warning::Missed(rows) => format!("warning: drive: {}", missed(rows, "TimeStep, --step")),
    }
}

/// Rows of a drive that are not applied, and what sets the communication step that applies them.
pub fn missed(missed: &Missed, by: &str) -> String {
    if missed.shortest.is_finite() { format!("{missed} ({by})") } else { missed.to_string() }
}
