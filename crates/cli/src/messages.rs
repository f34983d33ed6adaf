//! What a library says of a run, in the words of the command: with the options that mean it.

use crate::error::{Misused, TrialHasErrors};
use anyhow::{Result, anyhow};
use lemons_core::trial::Missed;
use lemons_core::trial::{Problems, Trial};
use lemons_master::{Error, PrepareError, TrialInput, Warning};
use std::path::Path;

/// Why a run cannot be prepared, with the option that means it. Errors of a Trial are printed.
pub fn not_prepared(error: PrepareError) -> anyhow::Error {
    use PrepareError as E;
    let (before, after) = match error {
        E::Run(error) => return report_problems(error.into()),
        E::OfOther { name, value, meant } => {
            return anyhow!(
                "--set {name}={value}: there is no such variable; did you mean --set {meant}={value}?"
            );
        }
        E::Parameter { .. } | E::Threads(_) | E::Tolerance(_) => ("--resume: ", ""),
        E::PlanWithoutTrial => ("--plan: ", ""),
        E::ThreadsOfCoupled(_) => ("--threads: ", ""),
        E::DriveOfCoupled => ("--drive: ", ""),
        E::Component { .. } => ("--set ", ""),
        E::OtherStep { .. } => ("--step: ", ""),
        E::OtherEvery { .. } => ("--every: ", ""),
        E::NowWalks(_) => ("", ": give --no-plan to go on as before"),
        E::NoLongerWalks => ("", ": go on without --no-plan, and with the file as it was (--plan)"),
        E::NotSaved(_) => ("", " (--state writes one)"),
        E::CannotSave { .. } => ("", " (--state, --resume)"),
        E::Nothing { .. } => ("", " (--until)"),
        E::NoStep => ("", ": give --step"),
        E::Every => ("", " (--every)"),
        E::OtherDrive => ("", ": give the same drive file as before, or --no-drive as before"),
    };
    let is_misuse =
        matches!(error, E::Parameter { .. } | E::Threads(_) | E::Tolerance(_) | E::PlanWithoutTrial);
    let text = format!("{before}{error}{after}");
    if is_misuse { Misused(text).into() } else { anyhow!(text) }
}

/// Prints the errors of a Trial; any other error is returned as it is.
pub fn report_problems(error: anyhow::Error) -> anyhow::Error {
    match error.downcast() {
        Ok(Error::Broken { path, problems }) => report_broken(&path, &problems),
        Ok(error) => error.into(),
        Err(error) => error,
    }
}

/// A Trial with its warnings. Errors are printed.
pub fn read_or_report(given: &TrialInput) -> Result<(Trial, Problems)> {
    given.read().map_err(|problems| report_broken(given.path(), &problems))
}

/// Prints the errors of a Trial.
pub fn report_broken(path: &Path, problems: &Problems) -> anyhow::Error {
    note!("{problems}");
    note!("lemons: {} has errors", path.display());
    TrialHasErrors.into()
}

/// Returns the text of a warning: what is probably not meant.
pub fn warning_text(warning: &Warning) -> String {
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
