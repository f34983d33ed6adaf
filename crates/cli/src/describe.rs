//! `lemons describe`: the model description that a Trial's FMU would have.

use crate::tell;
use crate::words::read_or_say;
use anyhow::Result;
use crowd_mechanics::model_description::model_description;
use crowd_mechanics::pack::Naming;
use lemons_master::Given;
use std::io::Write;
use std::path::PathBuf;

#[derive(clap::Args)]
pub struct Arguments {
    /// The Trial directory, or a zip of it
    #[arg(value_name = "TRIAL")]
    trial: PathBuf,
}

pub fn describe(arguments: &Arguments) -> Result<()> {
    let (trial, _) = read_or_say(&Given::open(&arguments.trial)?)?;
    let text = model_description(&trial, Naming::Structured);
    Ok(tell::out().write_all(text.as_bytes())?)
}
