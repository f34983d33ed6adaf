//! Commands that another program calls: their arguments are the same words, runs may be in memory, and nothing is printed.

use crate::error::full_message;
pub use crate::record::InMemory;
use crate::{Command, interrupt, print, read};
use anyhow::Result;
use lemons_core::files::words::shortened;
use std::ffi::OsString;
use std::path::PathBuf;
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Mutex, PoisonError};

/// An operand that is elsewhere than in the file which its name says.
#[derive(Debug)]
pub enum Held {
    /// A run in memory.
    Run(Arc<InMemory>),
    /// A database of trajectories.
    Database(PathBuf),
}

/// Result of a command.
#[derive(Debug, Default)]
pub struct Done {
    /// Text that it would print on standard output.
    pub printed: String,
    /// Lines that it would print on standard error: what is probably not meant.
    pub notes: Vec<String>,
    /// Picture of `plot`, in the format of the file that `--output` names, which is not written.
    pub picture: Vec<u8>,
    /// Summary of `measure`, as JSON.
    pub summary: String,
    /// Tables of `measure` as CSV, by their names.
    pub tables: Vec<(&'static str, String)>,
}

/// The command that writes files: they are those of one command at a time.
static WRITING: Mutex<()> = Mutex::new(());

/// Calls a command, with its name and arguments as words. `held` is its operand, if that is elsewhere. It ends soon after
/// `stop` is set, if it takes long.
///
/// # Errors
/// The message of the command, with what it noted before.
pub fn call(words: &[OsString], held: Option<Held>, stop: Arc<AtomicBool>) -> Result<Done, String> {
    let (done, printed, notes) = interrupt::stopped_by(stop, || print::caught(|| dispatch(words, held)));
    match done {
        Ok(done) => Ok(Done { printed, notes, ..done }),
        Err(error) => {
            let why = full_message(&error);
            Err(notes.into_iter().chain([shortened(&why).into_owned()]).collect::<Vec<_>>().join("\n"))
        }
    }
}

fn dispatch(words: &[OsString], held: Option<Held>) -> Result<Done> {
    let (run, database) = match held {
        Some(Held::Run(run)) => (Some(run), None),
        Some(Held::Database(path)) => (None, Some(path)),
        None => (None, None),
    };
    let _one = WRITING.lock().unwrap_or_else(PoisonError::into_inner);
    let words = [OsString::from("lemons")].into_iter().chain(words.iter().cloned());
    // As one sentence, without the usage.
    let command = read(words).map_err(|error| {
        let text = error.render().to_string();
        let first = text.split("\n\nUsage:").next().unwrap_or_default();
        let first = first.split("\n\nFor more information").next().unwrap_or_default();
        anyhow::Error::msg(first.trim_start_matches("error: ").trim_end().to_owned())
    })?;
    let mut done = Done::default();
    match command? {
        Command::Plot(mut arguments) => {
            arguments.source.hold(run, database);
            done.picture = crate::pictures::plot::drawn(&mut arguments)?;
        }
        Command::Movie(mut arguments) => {
            arguments.source.hold(run, database);
            crate::pictures::movie::movie(&arguments)?;
        }
        Command::Measure(mut arguments) => {
            arguments.source.hold(run, database);
            let measured = crate::measure::measured(&mut arguments)?;
            (done.summary, done.tables) = (measured.json, measured.tables);
        }
        Command::Export(mut arguments) => {
            (arguments.memory, arguments.reading.database) = (run, database);
            crate::export::export(&arguments)?;
        }
        other => crate::execute(other)?,
    }
    Ok(done)
}
