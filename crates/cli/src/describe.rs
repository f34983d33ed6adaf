//! `lemons describe`: the model description that a Trial's FMU would have, its Decision FMU, or its summary.

use crate::pack::{Fmi, Interface};
use crate::print;
use anyhow::Result;
use crowd_mechanics::model_description::model_description;
use crowd_mechanics::pack::Naming;
use lemons_core::trial::DriveChoice;
use lemons_decision::pack::description;
use lemons_master::{DecisionChoice, TrialInput};
use std::io::Write;
use std::path::PathBuf;

#[derive(clap::Args)]
pub struct Arguments {
    /// The Trial directory, or a zip of it
    #[arg(value_name = "TRIAL")]
    trial: PathBuf,
    #[command(flatten)]
    fmi: Fmi,
    #[command(flatten)]
    interface: Interface,
    /// Describe the Decision FMU that `lemons decide` makes with these way-points, instead of the crowd's; with
    /// --interface summary, that of these people
    #[arg(long, value_name = "FILE.toml")]
    decision: Option<PathBuf>,
}

pub fn describe(arguments: &Arguments) -> Result<()> {
    let summary = arguments.interface.summary()?;
    let own = if summary.is_some() { DecisionChoice::Own } else { DecisionChoice::None };
    let choice = arguments.decision.clone().map_or(own, DecisionChoice::File);
    let given = TrialInput::open(&arguments.trial)?;
    let (documents, ..) = given.documents(&DriveChoice::None, &choice)?;
    let format = arguments.fmi.format(Naming::Structured);
    summary.iter().flat_map(|config| config.notes(&documents)).for_each(|note| note!("note: {note}"));
    let text = match (&summary, &documents.plan) {
        (Some(config), _) => lemons_summary::pack::description(documents, config, format)?,
        (None, Some(plan)) => description(plan, format),
        (None, None) => model_description(&documents.trial, format),
    };
    Ok(print::out().write_all(text.as_bytes())?)
}
