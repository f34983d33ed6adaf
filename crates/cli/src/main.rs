//! The `lemons` command: checks, packs and runs Trials.
//!
//! Exit codes: 0 done; 1 something failed (a file, a run); 2 the command line is wrong; 3 a Trial has errors;
//! 130 interrupted.

// `tell` prints: a closed pipe or a full disk is an error, no panic.
#![deny(clippy::print_stdout, clippy::print_stderr)]

#[macro_use]
mod tell;

mod bench;
mod binary;
mod check;
mod connect;
mod crowd;
mod decide;
mod describe;
mod error;
mod export;
mod files;
mod given;
mod info;
mod interrupt;
mod output;
mod outputs;
mod pack;
mod people;
mod pictures;
mod recording;
mod results;
mod run;
mod sweep;
mod verify;
mod watch;

use anyhow::Result;
use clap::{ArgMatches, CommandFactory, FromArgMatches, Parser, Subcommand};
use crowd_mechanics::files::give_up;
use error::{Misused, TrialHasErrors, said};
use interrupt::{EXIT_CODE, Interrupted};
use std::io::{IsTerminal, Write};
use std::process::ExitCode;

/// Contact mechanics of dense crowds: Trials, FMUs, runs, coupling.
///
/// Exit codes: 0 done; 1 something failed; 2 the command line is wrong; 3 a Trial has errors;
/// 130 interrupted.
#[derive(Parser)]
#[command(name = "lemons", version, arg_required_else_help = true, max_term_width = 80)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Make a crowd from anthropometric data: a Trial, an FMU, tables, bodies
    Crowd(Box<people::crowd::Arguments>),
    /// Say what the shape of one person is, and write the body
    Person(people::person::Arguments),
    /// Make an FMU of one or more Trial directories
    Pack(pack::Arguments),
    /// Make an FMU that decides where people want to go: way-points and speeds
    Decide(decide::Arguments),
    /// Couple FMUs: connect each output with the input of the same name, write an SSP
    Connect(connect::Arguments),
    /// Run a Trial directory, an FMU or coupled FMUs and write the trajectories
    Run(run::Arguments),
    /// Run with many combinations of parameters and measure each run
    Sweep(sweep::Arguments),
    /// Draw scenes, time series or a map of density of a run
    Plot(Box<pictures::plot::Arguments>),
    /// Draw a run as a movie
    Movie(Box<pictures::movie::Arguments>),
    /// Write a run for JuPedSim, PedPy or ChAOS, as XML, or as the Trial that goes on where it ended
    Export(export::Arguments),
    /// List the variables of an FMU
    Info(info::Arguments),
    /// Say all that is wrong with Trial directories
    Check(check::Arguments),
    /// Print the modelDescription.xml that a Trial's FMU has
    Describe(describe::Arguments),
    /// Measure the mechanics against closed forms, conservation laws and independent integrators
    Verify(verify::Arguments),
    /// Measure what a mechanical step costs, and what the FMU adds
    Bench(bench::Arguments),
}

/// A negative number is a value, though it begins like an option: the option it is for says what is wrong with it.
fn arguments() -> Result<(Arguments, ArgMatches), clap::Error> {
    let command = Arguments::command().mut_subcommands(|command| {
        command.mut_args(|argument| {
            let number = argument.get_action().takes_values();
            argument.allow_negative_numbers(number)
        })
    });
    let matches = command.try_get_matches()?;
    Ok((Arguments::from_arg_matches(&matches)?, matches))
}

fn main() -> ExitCode {
    let done = interrupt::prepare().and_then(|()| command()).and_then(|()| Ok(tell::out().flush()?));
    if done.is_err() {
        interrupt::wait_if_ending();
    }
    files::remember();
    // What could not be removed while files were open.
    give_up();
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) if error.is::<TrialHasErrors>() => ExitCode::from(3),
        Err(error) if tell::nobody_listens(&error) => ExitCode::SUCCESS,
        Err(error) => {
            note!("lemons: {}", said(&error));
            if error.is::<Misused>() {
                return ExitCode::from(2);
            }
            if error.is::<Interrupted>() {
                return ExitCode::from(EXIT_CODE);
            }
            ExitCode::FAILURE
        }
    }
}

fn command() -> Result<()> {
    let (arguments, matches) = match arguments() {
        Ok(read) => read,
        // Where it was asked for, help goes where everything goes.
        Err(asked) if std::io::stdout().is_terminal() || asked.use_stderr() => asked.exit(),
        Err(asked) => return Ok(write!(tell::out(), "{}", asked.render())?),
    };
    matches.subcommand().map_or(Ok(()), |(name, matches)| files::begin(name, matches))?;
    match arguments.command {
        Command::Crowd(arguments) => people::crowd::crowd(*arguments),
        Command::Person(arguments) => people::person::person(&arguments),
        Command::Pack(arguments) => pack::pack(&arguments),
        Command::Decide(arguments) => decide::decide(&arguments),
        Command::Connect(arguments) => connect::connect(&arguments),
        Command::Run(arguments) => run::run(&arguments),
        Command::Sweep(arguments) => sweep::sweep(&arguments),
        Command::Plot(arguments) => pictures::plot::plot(&arguments),
        Command::Movie(arguments) => pictures::movie::movie(&arguments),
        Command::Export(arguments) => export::export(&arguments),
        Command::Info(arguments) => info::info(&arguments),
        Command::Check(arguments) => check::check(&arguments),
        Command::Describe(arguments) => describe::describe(&arguments),
        Command::Bench(arguments) => bench::bench(&arguments),
        Command::Verify(arguments) => verify::verify(&arguments),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Arg;
    use crowd_mechanics::pack::Binary;
    use std::any::TypeId;
    use std::path::PathBuf;

    /// By its type, or by what its help calls its value.
    fn names_a_file(argument: &Arg) -> bool {
        let kind = argument.get_value_parser().type_id();
        let called = argument.get_value_names().unwrap_or_default().join(" ");
        let words = ["FILE", "TRIAL", "DIRECTORY", "TABLE", "SERIES", "OUT", "PATH"];
        let typed = kind == TypeId::of::<PathBuf>() || kind == TypeId::of::<Binary>();
        typed || words.iter().any(|word| called.split(|c: char| !c.is_alphabetic()).any(|part| part == *word))
    }

    #[test]
    fn every_argument_that_names_a_file_has_a_role() {
        for command in Arguments::command().get_subcommands() {
            let arguments = command.get_arguments().filter(|argument| names_a_file(argument));
            let spelled =
                |argument: &Arg| argument.get_long().map_or(String::new(), |long| format!("--{long}"));
            let mut there: Vec<(String, String)> =
                arguments.map(|argument| (argument.get_id().to_string(), spelled(argument))).collect();
            let mut known: Vec<(String, String)> = files::roles_of(command.get_name())
                .iter()
                .map(|(id, spelled, _)| ((*id).to_owned(), (*spelled).to_owned()))
                .collect();
            there.sort();
            known.sort();
            assert_eq!(there, known, "{}: give it a role in files/roles.rs", command.get_name());
        }
    }
}
