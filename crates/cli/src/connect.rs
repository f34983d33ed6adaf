//! `lemons connect`: FMUs -> an SSP.

use crate::files::{self, ForceOption};
use crate::pack::say_size;
use crate::print::few;
use anyhow::{Result, bail};
use lemons_master::ssp::{Participant, write_archive};
use lemons_master::{Fmu, notes};
use std::collections::HashSet;
use std::path::{Path, PathBuf};

#[derive(clap::Args)]
pub struct Arguments {
    /// FMUs for co-simulation. The Gauss-Seidel algorithm steps them in this order
    #[arg(required = true, num_args = 2.., value_name = "FILE.fmu")]
    fmus: Vec<PathBuf>,
    /// An output that feeds an input of another name; instead of outputs with the input's name, or of those that
    /// terminals of the FMUs say. Components are called
    /// as their files: decision.Mp=turnstile.Wanted; of each person: 'decision.agent[*].Mp=turnstile.agent[*].Wanted'.
    /// Repeatable
    #[arg(long, value_name = "OUTPUT=INPUT", value_parser = chosen)]
    connection: Vec<(String, String)>,
    /// The SSP to write
    #[arg(short, long, value_name = "FILE.ssp")]
    output: PathBuf,
    #[command(flatten)]
    _force: ForceOption,
}

pub fn connect(arguments: &Arguments) -> Result<()> {
    let output = &arguments.output;
    if !output.extension().is_some_and(|end| end.eq_ignore_ascii_case("ssp")) {
        bail!("{}: the name of an SSP ends in .ssp", output.display());
    }
    files::claim_and_try(output)?;
    let fmus = arguments.fmus.iter().map(|path| Fmu::open(path)).collect::<Result<Vec<_>, _>>()?;
    let stems: Vec<String> = arguments.fmus.iter().map(|path| stem(path)).collect();
    let names = plain_names(stems.iter().map(String::as_str));
    let mut participants = Vec::new();
    for ((path, name), fmu) in arguments.fmus.iter().zip(&names).zip(&fmus) {
        let interface = &fmu.description;
        if interface.co_simulation.is_none() {
            bail!("{}: the FMU is not for co-simulation", path.display());
        }
        let source = format!("resources/{name}.fmu");
        participants.push(Participant { name: name.clone(), source, interface, terminals: fmu.terminals()? });
    }
    let connected =
        lemons_master::ssp::connect(&stem(&arguments.output), &participants, &arguments.connection)?;
    let sources = participants.iter().map(|participant| participant.source.clone());
    let files: Vec<(String, &Path)> = sources.zip(arguments.fmus.iter().map(PathBuf::as_path)).collect();
    files::check_still(output)?;
    write_archive(&arguments.output, &connected.structure, &files)?;

    for (i, from) in names.iter().enumerate() {
        for (k, to) in names.iter().enumerate() {
            let between = connected.connections.iter().filter(|(from, to, _)| (*from, *to) == (i, k));
            let connectors: Vec<&str> = between.map(|(.., name)| name.as_str()).collect();
            if !connectors.is_empty() {
                say!("{from} -> {to}: {} connected: {}", connectors.len(), few(&connectors, NAMED))?;
            }
        }
    }
    for ((component, fmu), inputs) in names.iter().zip(&fmus).zip(&connected.unconnected) {
        let free: HashSet<&str> = inputs.iter().map(String::as_str).collect();
        if fmu.loses_drive(|input| !free.contains(input))? {
            note!("{}", notes::drive_replaced(component));
        }
        // People are there, and doors and exits keep to their times, unless somebody says otherwise.
        let usual = |name: &&str| {
            let of_one = name.rsplit_once('.').map_or("", |(_, quantity)| quantity);
            ["Active", "Open"].contains(&of_one) || ["Active", "DoorOpen", "ExitOpen"].contains(name)
        };
        let names: Vec<&str> = inputs.iter().map(String::as_str).filter(|name| !usual(name)).collect();
        if !names.is_empty() {
            note!("warning: {component}: {} inputs not connected: {}", names.len(), few(&names, NAMED));
        }
    }
    say_size(&arguments.output)
}

fn chosen(text: &str) -> Result<(String, String), &'static str> {
    let (output, input) = text.split_once('=').ok_or("must be OUTPUT=INPUT")?;
    Ok((output.to_owned(), input.to_owned()))
}

/// Names of variables that are printed.
const NAMED: usize = 3;

fn stem(path: &Path) -> String {
    path.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

/// The names with letters, digits, `_` and `-` only, made different where they are not: they become names of
/// components, of files, and stand in URIs and before the dots of variables.
pub fn plain_names<'a>(names: impl Iterator<Item = &'a str>) -> Vec<String> {
    let mut taken = HashSet::new();
    let plain = names.map(|name| {
        let plain = |c: char| if c.is_ascii_alphanumeric() || "_-".contains(c) { c } else { '_' };
        let name: String = name.chars().map(plain).collect();
        let candidates = (1..).map(|n| if n == 1 { name.clone() } else { format!("{name}_{n}") });
        // There are more candidates than names.
        candidates.into_iter().find(|candidate| taken.insert(candidate.clone())).unwrap_or_default()
    });
    plain.collect()
}
