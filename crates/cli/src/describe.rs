//! `lemons describe`: the model description that a Trial's FMU would have, or its Decision FMU.

use crate::pack::Fmi;
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
    /// Describe the Decision FMU that `lemons decide` makes with these way-points, instead of the crowd's
    #[arg(long, value_name = "FILE.toml")]
    decision: Option<PathBuf>,
}

pub fn describe(arguments: &Arguments) -> Result<()> {
    let choice = arguments.decision.clone().map_or(DecisionChoice::None, DecisionChoice::File);
    let given = TrialInput::open(&arguments.trial)?;
    let (documents, ..) = given.documents(&DriveChoice::None, &choice)?;
    let format = arguments.fmi.format(Naming::Structured);
    let text = match &documents.plan {
        Some(plan) => description(plan, format),
        None => model_description(&documents.trial, format),
    };
    Ok(print::out().write_all(text.as_bytes())?)
}
