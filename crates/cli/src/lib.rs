//! The `lemons` command: checks, packs and runs Trials.
//!
//! Exit codes: 0 success; 1 a file or a run failed; 2 the command line is wrong; 3 a Trial has errors;
//! 130 interrupted by a signal.

// `tell` prints: a closed pipe or a full disk is an error, no panic.
#![deny(clippy::print_stdout, clippy::print_stderr)]

#[macro_use]
mod print;

mod binary;
mod check;
mod connect;
mod decide;
mod describe;
pub mod embedded;
mod error;
mod examples;
mod export;
mod files;
mod info;
mod interrupt;
mod lab;
mod measure;
mod output;
mod pack;
mod people;
mod pictures;
mod record;
mod replay;
mod report;
mod run;
mod sweep;
mod trajectories;
mod values;
mod verify;
mod version;

use anyhow::Result;
use clap::error::{ContextKind, ContextValue};
use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};
use error::{TrialHasErrors, full_message};
use interrupt::{EXIT_CODE, Interrupted};
use lemons_core::files::give_up;
use std::ffi::OsString;
use std::io::{IsTerminal, Write};
use std::process::ExitCode;
use version::SHORT_AND_LONG;

/// Simulate contact mechanics of dense crowds: make, check, pack, run, couple and draw them
///
/// A Trial is a directory with the XML files of a scene. Exit codes: 0 success, also of a sweep in
/// which only some points failed; 1 a file or a run failed; 2 the command line is wrong; 3 a Trial has errors; 130 interrupted by a signal.
#[derive(Parser)]
#[command(name = "lemons", version = SHORT_AND_LONG[0].as_str(), long_version = SHORT_AND_LONG[1].as_str(), arg_required_else_help = true, max_term_width = 80)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Open the lab: make and run crowds in the browser
    Lab(lab::Arguments),
    /// Make a crowd from anthropometric data: as a Trial, an FMU, tables, pictures or meshes
    Crowd(Box<people::crowd::Arguments>),
    /// Read a room from a drawing (DXF, GeoJSON, WKT, SVG), say what is in it, draw and write it
    Room(Box<people::room::Arguments>),
    /// Print disks that cover a drawn outline, for bodies of any shape
    Shape(people::shape::Arguments),
    /// Print the shape of one person, and write the body as a mesh or a picture
    Person(people::person::Arguments),
    /// Pack one or more Trials into an FMU
    Pack(pack::Arguments),
    /// Run an FMU again by the reference in it, and compare
    Replay(replay::Arguments),
    /// Make the Decision FMU, which drives the people of a Trial along way-points
    Decide(decide::Arguments),
    /// Couple FMUs in an SSP: connect each output with the input of the same name
    Connect(connect::Arguments),
    /// Simulate a Trial, an FMU or coupled FMUs, and write the trajectories
    Run(run::Arguments),
    /// Simulate many combinations of parameters, and evaluate each run
    Sweep(sweep::Arguments),
    /// Draw scenes, time series or a density map of a run
    Plot(Box<pictures::plot::Arguments>),
    /// Draw a run as a movie
    Movie(Box<pictures::movie::Arguments>),
    /// Measure a run: flow over lines, density in areas, exposure to squeeze
    Measure(Box<measure::Arguments>),
    /// Make a report of a scenario: runs with several seeds, as a page (HTML) or PDF
    Report(report::Arguments),
    /// Convert a run for JuPedSim, PedPy or ChAOS, to XML, or to a Trial that continues it
    Export(export::Arguments),
    /// List the variables of an FMU
    Info(info::Arguments),
    /// Report all errors of Trials, and what is probably not meant
    Check(check::Arguments),
    /// Print the modelDescription.xml of a Trial's FMU
    Describe(describe::Arguments),
    /// Compare the mechanics with analytic solutions, conservation laws and other integrators
    Verify(verify::Arguments),
}

/// The commands, arguments and help of `lemons`: for its reference, man pages and completions.
pub fn definition() -> clap::Command {
    Arguments::command().mut_subcommands(|command| {
        let own = command.get_after_help().map(ToString::to_string);
        let help = examples::help_of(command.get_name(), own);
        command.after_help(help).mut_args(|argument| {
            // A negative number is a value although it begins like an option. The option says what is wrong with it.
            let number = argument.get_action().takes_values();
            argument.allow_negative_numbers(number)
        })
    })
}

/// The command `lemons`: reads the command line, does what it says, and returns the exit code.
pub fn main() -> ExitCode {
    let done = interrupt::prepare().and_then(|()| command()).and_then(|()| Ok(print::out().flush()?));
    if done.is_err() {
        interrupt::wait_if_ending();
    }
    // What could not be removed while files were open.
    give_up();
    let Err(error) = done else { return ExitCode::SUCCESS };
    if print::is_closed_pipe(&error) {
        return ExitCode::SUCCESS;
    }
    if !error.is::<TrialHasErrors>() {
        note!("lemons: {}", full_message(&error));
    }
    ExitCode::from(match error.downcast_ref() {
        Some(lemons_master::MasterError::Misused(_)) => 2,
        Some(lemons_master::MasterError::Broken { .. }) => 3,
        _ if error.is::<TrialHasErrors>() => 3,
        _ if error.is::<Interrupted>() => EXIT_CODE,
        _ => 1,
    })
}

fn command() -> Result<()> {
    match read(std::env::args_os()) {
        Ok(command) => execute(command?),
        // Where it was asked for, help goes where everything goes.
        Err(asked) if std::io::stdout().is_terminal() || asked.use_stderr() => asked.exit(),
        Err(asked) => Ok(write!(print::out(), "{}", asked.render())?),
    }
}

/// Reads a command line, and begins with the files that it names.
///
/// # Errors
/// Help was asked for, or a word is wrong; within: an output is an input.
fn read(words: impl IntoIterator<Item = OsString>) -> Result<Result<Command>, clap::Error> {
    let mut all = definition();
    let matches = all.try_get_matches_from_mut(words).map_err(without_far_tip)?;
    let command = Arguments::from_arg_matches(&matches)?.command;
    let named = matches.subcommand().and_then(|(name, own)| Some((all.find_subcommand(name)?, own)));
    Ok(named.map_or(Ok(()), |(command, own)| files::begin(command, own)).map(|()| command))
}

/// Takes away the tip that a word is another one misspelt, if it begins with another letter: `--slope` is not `--close`.
fn without_far_tip(mut error: clap::Error) -> clap::Error {
    let first = |kind| match error.get(kind) {
        Some(ContextValue::String(word)) => word.trim_start_matches('-').chars().next(),
        Some(ContextValue::Strings(words)) => words.first()?.trim_start_matches('-').chars().next(),
        _ => None,
    };
    let tip = first(ContextKind::SuggestedArg);
    if tip.is_some() && tip != first(ContextKind::InvalidArg) {
        error.remove(ContextKind::SuggestedArg);
        // It is that of the option.
        error.remove(ContextKind::Usage);
    }
    error
}

fn execute(command: Command) -> Result<()> {
    match command {
        Command::Lab(arguments) => lab::lab(&arguments),
        Command::Crowd(arguments) => people::crowd::crowd(*arguments),
        Command::Room(arguments) => people::room::room(&arguments),
        Command::Shape(arguments) => people::shape::shape(&arguments),
        Command::Person(arguments) => people::person::person(&arguments),
        Command::Pack(arguments) => pack::pack(&arguments),
        Command::Replay(arguments) => replay::replay(&arguments),
        Command::Decide(arguments) => decide::decide(&arguments),
        Command::Connect(arguments) => connect::connect(&arguments),
        Command::Run(arguments) => run::run(&arguments),
        Command::Sweep(arguments) => sweep::sweep(&arguments),
        Command::Plot(mut arguments) => pictures::plot::plot(&mut arguments),
        Command::Movie(arguments) => pictures::movie::movie(&arguments),
        Command::Measure(arguments) => measure::measure(*arguments),
        Command::Report(arguments) => report::report(&arguments),
        Command::Export(arguments) => export::export(&arguments),
        Command::Info(arguments) => info::info(&arguments),
        Command::Check(arguments) => check::check(&arguments),
        Command::Describe(arguments) => describe::describe(&arguments),
        Command::Verify(arguments) => verify::verify(&arguments),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crowd_mechanics::pack::Binary;
    use std::any::TypeId;
    use std::path::PathBuf;

    #[test]
    fn examples_of_the_help_are_accepted_by_the_command() {
        for command in Arguments::command().get_subcommands() {
            let name = command.get_name();
            let lines = examples::of_command(name).unwrap_or_else(|| panic!("{name}: no example"));
            for line in lines.replace("\\\n", "").lines() {
                assert!(format!("{line} ").starts_with(&format!("lemons {name} ")), "{line}");
                let read = definition().try_get_matches_from(line.split_whitespace());
                assert!(read.is_ok(), "{line}: {}", read.unwrap_err());
            }
            for line in lines.lines() {
                assert!(line.len() <= 78, "{line}");
            }
        }
    }

    #[test]
    fn a_tip_begins_with_the_letter_of_the_word() {
        for (word, tip) in [("--slope", None), ("--gemoetry", Some("--geometry")), ("--hights", None)] {
            let message = read(["lemons", "crowd", word, "5"].map(OsString::from)).err().unwrap().to_string();
            assert!(message.contains(&format!("unexpected argument '{word}'")), "{message}");
            let tip = tip.map(|tip| format!("a similar argument exists: '{tip}'"));
            assert_eq!(message.contains("a similar argument"), tip.is_some(), "{message}");
            assert!(
                tip.is_none_or(|tip| message.contains(&tip)) && !message.contains("--close"),
                "{message}"
            );
        }
    }

    /// A path that is not of type `PathBuf` would be neither an input nor an output of [`files`].
    #[test]
    fn every_argument_that_names_a_file_is_a_path() {
        let words = ["FILE", "TRIAL", "DIRECTORY", "TABLE", "TABLES", "SERIES", "OUT", "PATH"];
        let paths = [TypeId::of::<PathBuf>(), TypeId::of::<Binary>()];
        for command in Arguments::command().get_subcommands() {
            for argument in command.get_arguments() {
                let called = argument.get_value_names().unwrap_or_default().join(" ");
                let is_file = called.split(|c: char| !c.is_alphabetic()).any(|part| words.contains(&part));
                let kind = argument.get_value_parser().type_id();
                let is_path = paths.iter().any(|path| kind == *path);
                assert_eq!(is_file, is_path, "{}: {}", command.get_name(), argument.get_id());
            }
        }
    }
}
