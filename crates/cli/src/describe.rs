//! `lemons describe`: the model description that a Trial's FMU would have, or its Decision FMU.

use crate::messages::read_or_report;
use crate::pack::Fmi;
use crate::print;
use anyhow::{Context, Result};
use crowd_mechanics::model_description::model_description;
use crowd_mechanics::pack::Naming;
use lemons_decision::pack::description;
use lemons_master::{TrialInput, plan_of};
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
    plan: Option<PathBuf>,
}

pub fn describe(arguments: &Arguments) -> Result<()> {
    let (trial, _) = read_or_report(&TrialInput::open(&arguments.trial)?)?;
    let format = arguments.fmi.format(Naming::Structured);
    let text = match &arguments.plan {
        Some(plan) => {
            let plan = plan_of(&trial, plan).with_context(|| plan.display().to_string())?;
            description(&plan, format)
        }
        None => model_description(&trial, format),
    };
    Ok(print::out().write_all(text.as_bytes())?)
}
