//! `lemons check`: all that is wrong with a Trial at once.

use crate::decide::plan_of;
use crate::error::TrialHasErrors;
use crate::files::WISHES_FILE;
use crate::given::Given;
use crate::tell;
use anyhow::{Context, Result};
use crowd_mechanics::trial::Problems;
use lemons_master::Drive;
use std::io::{self, Write};
use std::path::PathBuf;

#[derive(clap::Args)]
pub struct Arguments {
    /// Trial directories, or zips of them
    #[arg(required = true, value_name = "TRIAL")]
    trials: Vec<PathBuf>,
}

pub fn check(arguments: &Arguments) -> Result<()> {
    let mut out = tell::out();
    let mut broken = false;
    for path in &arguments.trials {
        let given = match Given::open(path) {
            Ok(given) => given,
            Err(error) => {
                broken = true;
                writeln!(out, "{error:#}")?;
                continue;
            }
        };
        match given.read() {
            Ok((trial, warnings)) => {
                print(&mut out, &warnings)?;
                let wishes = given.directory().join(WISHES_FILE);
                let wished = if wishes.exists() { plan_of(&trial, &wishes).map(drop) } else { Ok(()) };
                let wished = wished.with_context(|| wishes.display().to_string());
                if let Err(error) = wished.and_then(|()| Drive::of(Some(&trial), None).map(drop)) {
                    broken = true;
                    // A zip is unpacked elsewhere.
                    let (there, named) = (given.directory().display(), path.display());
                    writeln!(
                        out,
                        "{}",
                        format!("{error:#}").replace(&there.to_string(), &named.to_string())
                    )?;
                    writeln!(out, "{named}: 1 error")?;
                    continue;
                }
                let parameters = &trial.parameters;
                writeln!(
                    out,
                    "{}: {} agents, {} walls, TimeStep {:?} s, TimeStepMechanical {:?} s: {}",
                    path.display(),
                    trial.agents.len(),
                    trial.geometry.walls.len(),
                    parameters.time_step,
                    parameters.time_step_mechanical,
                    match warnings.iter().count() {
                        0 => "no problem".to_owned(),
                        1 => "1 warning".to_owned(),
                        n => format!("{n} warnings"),
                    }
                )?;
            }
            Err(problems) => {
                broken = true;
                print(&mut out, &problems)?;
                let errors = problems.errors().count();
                let noun = if errors == 1 { "error" } else { "errors" };
                writeln!(out, "{}: {errors} {noun}", path.display())?;
            }
        }
    }
    if broken { Err(TrialHasErrors.into()) } else { Ok(()) }
}

fn print(out: &mut impl Write, problems: &Problems) -> io::Result<()> {
    problems.iter().try_for_each(|problem| writeln!(out, "{problem}"))
}
