//! `lemons describe`: the model description that a Trial's FMU would have.

use crate::pack::Fmi;
use crate::tell;
use crate::words::read_or_say;
use anyhow::Result;
use crowd_mechanics::model_description::{model_description, model_description_3};
use crowd_mechanics::pack::{Format, Naming};
use lemons_master::Given;
use std::io::Write;
use std::path::PathBuf;

#[derive(clap::Args)]
pub struct Arguments {
    /// The Trial directory, or a zip of it
    #[arg(value_name = "TRIAL")]
    trial: PathBuf,
    #[command(flatten)]
    fmi: Fmi,
}

pub fn describe(arguments: &Arguments) -> Result<()> {
    let (trial, _) = read_or_say(&Given::open(&arguments.trial)?)?;
    let text = match arguments.fmi.format(Naming::Structured) {
        Format::Fmi2(naming) => model_description(&trial, naming),
        Format::Fmi3 => model_description_3(&trial),
    };
    Ok(tell::out().write_all(text.as_bytes())?)
}
