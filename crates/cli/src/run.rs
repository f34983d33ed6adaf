//! `lemons run`: an FMU, or FMUs coupled by an SSP, stepped like any FMI master would.

mod accuracy;
mod fmus;
mod job;
mod model;
mod outputs;
mod recorder;
mod trial;

use crate::error::Misused;
use crate::files::ForceOption;
use crate::interrupt::{Interrupt, Interrupted};
use crate::values::{duration, parser_of, positive};
use accuracy::run_for;
use anyhow::{Result, bail};
use clap::builder::{PossibleValuesParser, TypedValueParser};
pub use job::{RunJob, simulate};
use lemons_core::trial::DriveChoice;
use lemons_master::{DecisionChoice, RunSettings};
use lemons_results::TableFormat;
use lemons_sim::{Algorithm, Until};
use outputs::TableFile;
pub use recorder::RowTarget;
use std::path::{Path, PathBuf};
pub use trial::not_set;

#[derive(clap::Args)]
pub struct Arguments {
    /// A Trial (a directory or a zip), an FMU, or an SSP of coupled FMUs
    #[arg(value_name = "TRIAL, FILE.fmu or FILE.ssp")]
    input: PathBuf,
    /// End of the simulation, in seconds; or the word left: when everybody has left by the exits of
    /// decision.toml, or when in 300 s nobody has left or got further than 5 m; at the latest after 3600 s.
    /// With --every, such a run goes on to the next row.
    /// Default: the stop time of the SSP, else 5
    #[arg(long, value_name = "SECONDS|left", value_parser = until)]
    until: Option<Until>,
    /// How coupled FMUs exchange values. jacobi: all FMUs use the values of the last communication
    /// point. gauss-seidel: the FMUs step one after the other, in the order of the SSP, and each uses the
    /// newest values
    #[arg(long, default_value = "jacobi", value_parser = PossibleValuesParser::new(["jacobi", "gauss-seidel"]).try_map(algorithm))]
    algorithm: Algorithm,
    #[command(flatten)]
    inputs: Inputs,
    /// Set a parameter or a start value, for example --set TimeStepMechanical=1e-5; for all agents:
    /// --set 'agent[*].Mass=80'; in an SSP, with the name of the component: --set crowd.Threads=2; for
    /// people who walk by decision.toml, --set 'decision.agent[3].DesiredSpeed=0.5'
    // The help shows it as it is.
    #[allow(rustdoc::broken_intra_doc_links)]
    #[arg(long = "set", value_name = "NAME=VALUE", value_parser = name_and_value)]
    settings: Vec<(String, String)>,
    /// Number of threads of the crowd. They pay off from a few thousand agents on. Results do not depend
    /// on the number. In an SSP, use --set NAME.Threads=N
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(i32).range(1..))]
    threads: Option<i32>,
    /// Choose the mechanical step for this accuracy, in metres, and run twice: with this step and with half
    /// of it. The results are those of the second run. The summary says by how much a point of a body
    /// differs at most between both, and whether the accuracy was met (docs/step.md)
    #[arg(long, value_name = "METRES", value_parser = length, conflicts_with = "resume")]
    accuracy: Option<f64>,
    /// File for the trajectories; - is standard output. Several crowds go to FILE_NAME.csv, with the name
    /// of each component. If nothing is a crowd, as of a summary FMU: file for the outputs. Default: trajectories.csv
    /// of a crowd, else none
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// File for the outputs of what is not a crowd: of other FMUs, or where people want to go
    #[arg(long, value_name = "FILE")]
    outputs: Option<PathBuf>,
    /// Format of the tables: csv; or parquet, for long runs: smaller, with units in the metadata. Default: by the
    /// extension of -o, else csv
    #[arg(long, value_name = "FORMAT", hide_possible_values = true, value_parser = parser_of(&[TableFormat::Csv, TableFormat::Parquet], TableFormat::extension))]
    format: Option<TableFormat>,
    /// Write only every N-th communication point, beginning with the first. Default: 1. Mean and peak
    /// squeeze in a row are of all steps since the row before
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    every: Option<u32>,
    /// Save the state of the run when it ends or is stopped by Ctrl-C; --resume continues it
    #[arg(long, value_name = "FILE.run")]
    state: Option<PathBuf>,
    /// Continue a saved run of the same Trial, FMU or SSP. What follows goes into tables of its own (-o), which
    /// lemons measure, plot, movie and export read together with those of the saved run
    #[arg(long, value_name = "FILE.run")]
    resume: Option<PathBuf>,
    #[command(flatten)]
    _force: ForceOption,
}

pub fn until(text: &str) -> Result<Until, String> {
    match text {
        "left" => Ok(Until::Left),
        text => duration(text).map(Until::Time).map_err(|must| format!("{must}, or the word left")),
    }
}

/// Inputs of a run that is made now: who is pushed, and where people walk.
#[derive(clap::Args)]
pub struct Inputs {
    /// Communication step, in seconds. Default: the Trial's TimeStep; for several FMUs, the smallest
    /// of their default step sizes
    #[arg(long, value_name = "SECONDS", value_parser = duration)]
    pub step: Option<f64>,
    /// Propulsion over time: a CSV file with columns t,agent,Fp.x,Fp.y,Mp. At each communication point,
    /// values are interpolated linearly between rows; they are held until the next point, so results
    /// depend on the communication step. Before the first and after the last row they are zero. Agents that are not
    /// in the file keep the values of AgentDynamics.xml. Default: the Trial's drive.csv if there is one, which
    /// its FMU plays by itself (in an SSP, too, but not for people whose Fp or Mp is connected). Where people walk by decision.toml, it is added to the forces
    /// with which they walk
    #[arg(long, value_name = "FILE.csv", conflicts_with = "no_drive")]
    drive: Option<PathBuf>,
    /// Ignore the Trial's drive.csv
    #[arg(long)]
    no_drive: bool,
    /// Where people walk, instead of the Trial's decision.toml: see lemons decide --help. The run is that of
    /// the Trial's FMU coupled with that of lemons decide
    #[arg(long, value_name = "FILE.toml", conflicts_with = "no_decision")]
    decision: Option<PathBuf>,
    /// Ignore the Trial's decision.toml
    #[arg(long)]
    no_decision: bool,
}

impl Inputs {
    /// Returns whether one of its options was given.
    pub fn given(&self) -> bool {
        self.step.is_some()
            || self.drive.is_some()
            || self.no_drive
            || self.decision.is_some()
            || self.no_decision
    }

    /// Returns the settings of a run with these inputs.
    pub fn settings(&self, input: &Path) -> RunSettings {
        let drive = match &self.drive {
            Some(path) => DriveChoice::File(path.clone()),
            None if self.no_drive => DriveChoice::None,
            None => DriveChoice::Own,
        };
        let decision = match &self.decision {
            Some(path) => DecisionChoice::File(path.clone()),
            None if self.no_decision => DecisionChoice::None,
            None => DecisionChoice::Own,
        };
        RunSettings { step: self.step, drive, decision, ..RunSettings::of(input) }
    }
}

impl Arguments {
    fn job(&self) -> Result<RunJob> {
        let (rows, outputs) = places_of(self)?;
        let settings = RunSettings {
            threads: self.threads,
            until: self.until.map(Until::latest),
            every: self.every.map(u64::from),
            algorithm: self.algorithm,
            resume: self.resume.clone(),
            saves: self.state.is_some(),
            parameters: self.settings.clone(),
            ..self.inputs.settings(&self.input)
        };
        Ok(RunJob {
            settings,
            rows: RowTarget::Table(rows),
            outputs,
            either: self.output.is_some(),
            state: self.state.clone(),
            until: self.until,
        })
    }
}

/// Name and value of `--set`.
pub fn name_and_value(text: &str) -> Result<(String, String), &'static str> {
    let (name, value) = text.split_once('=').ok_or("expected NAME=VALUE")?;
    Ok((name.to_owned(), value.to_owned()))
}

fn algorithm(name: String) -> serde_json::Result<Algorithm> {
    serde_json::from_value(name.into())
}

fn length(text: &str) -> Result<f64, String> {
    positive(text).map_err(|must| format!("{must} of metres, for example 1e-4"))
}

pub fn run(arguments: &Arguments) -> Result<()> {
    let (job, interrupt) = (arguments.job()?, Interrupt::watch());
    let ended = match arguments.accuracy {
        Some(accuracy) => run_for(accuracy, job, &interrupt)?,
        None => simulate(job, &interrupt)?,
    };
    let printed = ended.summary.iter().try_for_each(|line| say!("{line}"));
    // What was computed is told nevertheless.
    ended.complete?;
    let Some(time) = ended.stopped else { return Ok(printed?) };
    let go_on = match &arguments.state {
        Some(path) => format!("go on with --resume {}", path.display()),
        None => "it is not saved (--state)".into(),
    };
    Err(Interrupted(format!("stopped at t = {time:?} s; {go_on}")).into())
}

/// Returns where the trajectories and the outputs go, and as what.
fn places_of(arguments: &Arguments) -> Result<(TableFile, Option<TableFile>)> {
    let Arguments { output, outputs, format, .. } = arguments;
    let common = format.or(output.as_deref().and_then(TableFormat::of)).unwrap_or(TableFormat::Csv);
    let place = |path: &Path| match (TableFormat::of(path), *format) {
        (Some(own), Some(wanted)) if own != wanted => bail!(Misused(format!(
            "{}: ends in .{}, but --format is {}",
            path.display(),
            own.extension(),
            wanted.extension()
        ))),
        (None, None) if path.extension().is_some() => bail!(Misused(format!(
            "{}: tables are .csv or .parquet: give such a name, or --format for one that ends otherwise",
            path.display()
        ))),
        (own, _) => Ok(TableFile { path: path.to_owned(), format: own.unwrap_or(common) }),
    };
    let default = PathBuf::from(format!("trajectories.{}", common.extension()));
    let trajectories = place(output.as_deref().unwrap_or(&default))?;
    Ok((trajectories, outputs.as_deref().map(place).transpose()?))
}
