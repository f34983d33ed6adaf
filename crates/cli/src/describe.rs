//! `lemons describe`: the model description that a Trial's FMU would have.

use crate::error::TrialHasErrors;
use crate::pack::TRIAL;
use crate::tell;
use anyhow::Result;
use crowd_mechanics::model_description::model_description;
use crowd_mechanics::pack::Naming;
use crowd_mechanics::trial::Trial;
use lemons_master::Kind;
use std::io::Write;
use std::path::PathBuf;

#[derive(clap::Args)]
pub struct Arguments {
    /// The Trial directory
    #[arg(value_name = "TRIAL")]
    trial: PathBuf,
}

pub fn describe(arguments: &Arguments) -> Result<()> {
    Kind::expect(&arguments.trial, &[Kind::Trial], TRIAL)?;
    match Trial::read(&arguments.trial) {
        Ok((trial, _)) => {
            let text = model_description(&trial, Naming::Structured);
            Ok(tell::out().write_all(text.as_bytes())?)
        }
        Err(problems) => {
            note!("{problems}");
            Err(TrialHasErrors.into())
        }
    }
}
