//! `lemons decide`: a Trial and its decision.toml -> a Decision FMU.

use crate::binary::DECISION;
use crate::files::{self, ForceOption};
use crate::pack::{Fmi, FmuArguments, Reference, say_size};
use anyhow::{Context, Result, anyhow};
use lemons_core::trial::DriveChoice;
use lemons_decision::DECISION_FILE;
use lemons_master::{DecisionChoice, TrialInput};
use lemons_sim::lint::{self, Files};
use std::path::PathBuf;

/// The shortest `decision.toml`.
const SHORTEST: &str = "  desired_speed = 1.34
  waypoints = [{ x = 6.0, y = 2.5 }]";

const DECISION_HELP: &str = include_str!("help/decide.txt");

#[derive(clap::Args)]
#[command(after_help = DECISION_HELP)]
pub struct Arguments {
    /// The Trial whose people are driven: its directory, or a zip of it
    #[arg(value_name = "TRIAL")]
    trial: PathBuf,
    /// File with way-points, exits and desired speeds. Default: decision.toml in the Trial's directory
    #[arg(long, value_name = "FILE.toml")]
    decision: Option<PathBuf>,
    /// The FMU to write
    #[arg(short, long, value_name = "FILE.fmu")]
    output: PathBuf,
    #[command(flatten)]
    fmi: Fmi,
    #[command(flatten)]
    fmu: FmuArguments,
    #[command(flatten)]
    reference: Reference,
    #[command(flatten)]
    _force: ForceOption,
}

pub fn decide(arguments: &Arguments) -> Result<()> {
    let mut file = files::stage(&arguments.output)?;
    let given = TrialInput::open(&arguments.trial)?;
    let choice = arguments.decision.clone().map_or(DecisionChoice::Own, DecisionChoice::File);
    let (documents, mut warnings, decision) = given.documents(&DriveChoice::None, &choice)?;
    let files = Files::chosen(given.path(), &DriveChoice::None, decision.as_deref());
    warnings.extend(lint::of_documents(&documents, &files));
    warnings.iter().for_each(|warning| note!("{warning}"));
    let plan = documents.plan.as_ref().ok_or_else(|| {
        let missing = given.path().join(DECISION_FILE);
        let help = "Write it, or name another file with --decision FILE.toml. The shortest such file is:";
        anyhow!("there is no {}. {help}\n{SHORTEST}", missing.display())
    })?;
    let binaries = arguments.fmu.binaries(&DECISION)?;
    let unwritten = || format!("cannot write {}", arguments.output.display());
    lemons_decision::pack::write_fmu(
        &documents.trial,
        plan,
        arguments.fmi.format(arguments.fmu.naming()),
        &binaries,
        &mut file,
    )
    .with_context(|| arguments.output.display().to_string())?;
    arguments.reference.add(&mut file, &arguments.output, || Ok(documents))?;
    file.persist().with_context(unwritten)?;
    say_size(&arguments.output)
}
