//! `lemons pack`: Trials -> FMU.

use crate::TrialHasErrors;
use anyhow::Result;
use crowd_mechanics::model_description::Naming;
use crowd_mechanics::pack::{Binary, PackError, Package};
use crowd_mechanics::trial::Trial;
use lemons_master::own_binary;
use lemons_picture::{Fill, Scene, Style, png, svg};
use std::path::{Path, PathBuf};

#[derive(clap::Args)]
pub struct Arguments {
    /// Trial directories; the first is the default of the parameter Trial
    #[arg(required = true, value_name = "TRIAL")]
    trials: Vec<PathBuf>,
    /// The FMU to write
    #[arg(short, long, value_name = "FILE.fmu")]
    output: PathBuf,
    /// A shared library for a platform (linux64=FILE, win64=FILE, …); default: this machine's
    #[arg(long = "binary", value_name = "PLATFORM=FILE", value_parser = parse_binary)]
    binaries: Vec<Binary>,
    /// Declare the variable names as "flat": some tools check structured names slowly
    #[arg(long)]
    flat_names: bool,
}

fn parse_binary(text: &str) -> Result<Binary, String> {
    let (platform, path) = text.split_once('=').ok_or("expected PLATFORM=FILE")?;
    Ok(Binary { platform: platform.to_owned(), path: path.into() })
}

pub fn pack(arguments: &Arguments) -> Result<()> {
    let naming = if arguments.flat_names { Naming::Flat } else { Naming::Structured };
    let mut binaries = arguments.binaries.clone();
    if binaries.is_empty() {
        binaries.push(own_binary()?);
    }
    let warnings = write_fmu(&arguments.trials, binaries, naming, &arguments.output)?;
    for warning in warnings {
        eprintln!("{warning}");
    }
    let size = std::fs::metadata(&arguments.output)?.len();
    println!("{}: {:.1} MB", arguments.output.display(), size as f64 / 1e6);
    Ok(())
}

/// Packs Trials; errors of a Trial are printed, one line each.
pub fn write_fmu(
    trials: &[PathBuf],
    binaries: Vec<Binary>,
    naming: Naming,
    output: &Path,
) -> Result<Vec<String>> {
    let package = Package {
        trials: trials.to_vec(),
        binaries,
        picture: trials.first().and_then(|t| picture(t)),
        naming,
    };
    match package.write(output) {
        Ok(warnings) => Ok(warnings),
        Err(PackError::Broken { path, problems }) => {
            eprintln!("{problems}");
            eprintln!("lemons: {} has errors", path.display());
            Err(TrialHasErrors.into())
        }
        Err(error) => Err(error.into()),
    }
}

/// `model.png`; a Trial that cannot be read or drawn has none.
fn picture(trial: &Path) -> Option<Vec<u8>> {
    let (trial, _) = Trial::read(trial).ok()?;
    let style = Style { width: 640.0, fill: Fill::BodyArea, ..Style::default() };
    png(&svg(&Scene::at_start(&trial), &style), 640).ok()
}
