//! The files that a command reads and writes: the one place that says whether a file may be written.
//!
//! - A file that is read is never written, whatever path leads to it.
//! - Two outputs never go into one file.
//! - An existing file is replaced only with `--force`, or if it is a table or picture with the name that the command
//!   gives it by default.
//! - What another program has put into the place meanwhile is not replaced; the output then gets another name.
//! - `-` is standard output, for a text or a picture; the command's messages go to standard error then.

use crate::error::Misused;
use crate::print;
use anyhow::{Context, Result, bail};
use clap::{ArgMatches, Command};
use crowd_mechanics::pack::Binary;
use lemons_core::files::{FileStamp, Staged, mark_of, target_of};
use lemons_core::trial::Trial;
use lemons_decision::DECISION_FILE;
use lemons_results::series_in;
use std::collections::HashMap;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

/// Names of options that name an output, and of the operand OUT. Every other path is an input.
const OUTPUTS: [&str; 20] = [
    "output",
    "outputs",
    "state",
    "zip",
    "fmu",
    "population",
    "light_xml",
    "sections_geojson",
    "sections_wkt",
    "geojson",
    "wkt",
    "obj",
    "stl",
    "svg",
    "png",
    "pdf",
    "csv",
    "summary",
    "plot",
    "save_scenario",
];
const OUTPUT_OPERAND: &str = "out";

/// Tables and pictures that a command replaces without `--force`: the names it gives them by default (with the name of a
/// component between the beginning and the end).
const DEFAULT_NAMES: [(&str, &str, &str); 7] = [
    ("run", "trajectories", ".csv"),
    ("run", "trajectories", ".parquet"),
    ("run", "outputs", ".csv"),
    ("run", "outputs", ".parquet"),
    ("plot", "plot", ".png"),
    ("movie", "movie", ".mp4"),
    ("movie", "movie", ".gif"),
];

/// Option of the commands that write.
#[derive(clap::Args, Clone)]
pub struct ForceOption {
    /// Replace existing files
    #[arg(long)]
    pub force: bool,
}

/// A file that is to be written.
struct Target {
    /// Path as the user calls it.
    path: PathBuf,
    place: PathBuf,
    before: Option<FileStamp>,
}

#[derive(Default)]
struct Files {
    command: String,
    force: bool,
    /// Inputs, and the arguments that name them.
    inputs: HashMap<PathBuf, String>,
    targets: Vec<Target>,
    /// The saved run that is continued, if its file is also the output.
    continued: Option<PathBuf>,
    /// Whether an output goes to standard output.
    streams: bool,
}

/// Files of the one command of this process.
static FILES: Mutex<Option<Files>> = Mutex::new(None);

fn with<T>(work: impl FnOnce(&mut Files) -> T) -> T {
    work(FILES.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert_default())
}

/// Returns whether a path is `-`.
pub fn is_standard_output(path: &Path) -> bool {
    path.as_os_str() == "-"
}

/// Notes the files that the arguments of a command name.
///
/// # Errors
/// An output is an input, or cannot go to standard output.
pub fn begin(command: &Command, matches: &ArgMatches) -> Result<()> {
    let name = command.get_name();
    let force = matches.try_get_one::<bool>("force").ok().flatten().is_some_and(|force| *force);
    with(|files| *files = Files { command: name.to_owned(), force, ..Files::default() });
    let paths = |id: &str| -> Vec<PathBuf> {
        matches.try_get_many::<PathBuf>(id).ok().flatten().into_iter().flatten().cloned().collect()
    };
    let state = paths("state").pop().and_then(|state| target_of(&state).ok());
    let mut outputs = Vec::new();
    for argument in command.get_arguments() {
        let id = argument.get_id().as_str();
        let option = argument.get_long().map(|long| format!("--{long}"));
        let is_output = if option.is_some() { OUTPUTS.contains(&id) } else { id == OUTPUT_OPERAND };
        for path in paths(id) {
            let who = option.clone().unwrap_or_else(|| path.display().to_string());
            if is_output && is_standard_output(&path) {
                with(|files| files.stream(id, &who))?;
            } else if is_output {
                outputs.push(path);
            } else if id == "resume" && state.is_some() && target_of(&path).ok() == state {
                with(|files| files.continued.clone_from(&state));
            } else {
                reads(&path, &who);
            }
        }
        for binary in matches.try_get_many::<Binary>(id).ok().flatten().into_iter().flatten() {
            reads(&binary.path, &option.clone().unwrap_or_default());
        }
    }
    // Before other outputs are made.
    outputs.iter().try_for_each(|path| with(|files| files.check_no_input(path)).map(drop))
}

/// Notes that the command reads a file for `who`: an option, or another file that names it.
pub fn reads(path: &Path, who: &str) {
    let mut all = vec![path.to_owned()];
    if path.join("Parameters.xml").is_file() {
        // Files that are not there yet would be read by the next command.
        all.extend([lemons_core::trial::DRIVE_FILE, DECISION_FILE].map(|name| path.join(name)));
        for file in Trial::files_read(path) {
            all.extend(file.parent().filter(|directory| *directory != path).map(Path::to_owned));
            all.push(file);
        }
    } else if path.is_dir() {
        let entries = std::fs::read_dir(path).into_iter().flatten().flatten();
        all.extend(entries.map(|entry| entry.path()));
    }
    with(|files| {
        for place in all.iter().filter_map(|path| target_of(path).ok()) {
            files.inputs.entry(place).or_insert_with(|| who.to_owned());
        }
    });
}

/// Reserves a file for one output.
///
/// # Errors
/// It is an input or another output, or it exists and is not to be replaced.
pub fn claim(path: &Path) -> Result<()> {
    with(|files| files.claim(path))
}

/// Claims a file, and opens a temporary one that will replace it.
///
/// # Errors
/// As [`claim`], or it cannot be written.
pub fn stage(path: &Path) -> Result<Staged> {
    claim(path)?;
    open(path)
}

/// Does the same as [`stage`]; for a run that `goes_on`, nothing may be there.
///
/// # Errors
/// As [`stage`], or a file is there, and `--force` is not given.
pub fn stage_new(path: &Path, goes_on: bool) -> Result<Staged> {
    let there = || path.metadata().is_ok_and(|there| there.is_file() && there.len() > 0);
    if goes_on && !is_standard_output(path) && there() && !with(|files| files.force) {
        bail!(
            "{}: it is there, and may hold what the saved run has written: give the rows that follow a file of their \
             own (-o FILE); --force replaces it",
            path.display()
        );
    }
    stage(path)
}

/// Opens a file that was claimed.
///
/// # Errors
/// It cannot be written.
pub fn open(path: &Path) -> Result<Staged> {
    let file = if is_standard_output(path) {
        standard_output()
    } else {
        Staged::beside(path).map(|staged| match with(|files| files.before(path)) {
            Some(before) => staged.instead_of(before),
            None => staged,
        })
    };
    file.with_context(|| format!("cannot write {}", path.display()))
}

fn standard_output() -> io::Result<Staged> {
    #[cfg(unix)]
    let own = std::os::fd::AsFd::as_fd(&io::stdout()).try_clone_to_owned()?;
    #[cfg(windows)]
    let own = std::os::windows::io::AsHandle::as_handle(&io::stdout()).try_clone_to_owned()?;
    Ok(Staged::onto(own.into()))
}

/// Claims a file that is written later, and checks that it can be.
///
/// # Errors
/// As [`stage`].
pub fn claim_and_try(path: &Path) -> Result<()> {
    stage(path).map(drop)
}

/// Reserves a directory into which files are put; each of these is claimed, too.
///
/// # Errors
/// It is an input or another output.
pub fn claim_directory(directory: &Path) -> Result<()> {
    with(|files| files.add(directory).map(drop))
}

/// Reserves a directory into which a crowd writes the files of a series. Returns those of an earlier run.
///
/// # Errors
/// As [`claim_directory`], or files of an earlier run are there and are not to be replaced.
pub fn claim_series(directory: &Path) -> Result<Vec<PathBuf>> {
    claim_directory(directory)?;
    let there: Vec<PathBuf> = series_in(directory)?.into_iter().map(|name| directory.join(name)).collect();
    there.iter().try_for_each(|path| claim(path))?;
    Ok(there)
}

/// Checks, before something is written without [`open`], that nobody else has written what was claimed, or what was claimed
/// in this directory.
///
/// # Errors
/// Another program has written it meanwhile.
pub fn check_still(path: &Path) -> Result<()> {
    let changed = |target: &&Target| target.path.starts_with(path) && mark_of(&target.path) != target.before;
    with(|files| match files.targets.iter().find(changed) {
        Some(target) => {
            bail!("cannot write {}: another program has written it meanwhile", target.path.display())
        }
        None => Ok(()),
    })
}

/// Returns the outputs that are complete and in their places, as the user calls them.
pub fn complete() -> Vec<PathBuf> {
    with(|files| {
        let done = files.targets.iter().filter(|target| {
            let now = mark_of(&target.place);
            now.is_some() && now != target.before
        });
        done.map(|target| target.path.clone()).collect()
    })
}

/// Returns warnings about files of a replaced Trial that stay there and are used. The command itself writes `written`.
pub fn staying(trial: &Path, written: &[&str]) -> impl Iterator<Item = String> {
    let names =
        [lemons_core::trial::DRIVE_FILE, DECISION_FILE].into_iter().filter(|name| !written.contains(name));
    let files: Vec<PathBuf> = names.map(|name| trial.join(name)).collect();
    files
        .into_iter()
        .filter(|file| file.is_file())
        .map(|file| format!("warning: {} of the Trial that was there stays, and is used", file.display()))
}

impl Files {
    /// Sends an output to standard output.
    fn stream(&mut self, id: &str, option: &str) -> Result<()> {
        let is_text = match id {
            "output" => self.command == "run",
            "zip" | "fmu" | "state" | "plot" => false,
            _ => true,
        };
        if !is_text {
            let message = "this result cannot go to standard output; for a file of this name, write ./-";
            bail!(Misused(format!("{option} -: {message}")));
        }
        if std::mem::replace(&mut self.streams, true) {
            bail!("cannot write -: another result goes there");
        }
        print::use_standard_error();
        Ok(())
    }

    fn check_no_input(&self, path: &Path) -> Result<PathBuf> {
        let place = target_of(path).with_context(|| format!("cannot write {}", path.display()))?;
        if let Some(who) = self.inputs.get(&place) {
            bail!("cannot write {}: lemons {} reads it ({who})", path.display(), self.command);
        }
        Ok(place)
    }

    fn add(&mut self, path: &Path) -> Result<PathBuf> {
        let place = self.check_no_input(path)?;
        if self.targets.iter().any(|target| target.place == place) {
            bail!("cannot write {}: another result goes there", path.display());
        }
        let before = mark_of(&place);
        self.targets.push(Target { path: path.to_owned(), place: place.clone(), before });
        Ok(place)
    }

    /// Returns the stamp of what was in the place of a file when it was claimed.
    fn before(&self, path: &Path) -> Option<Option<FileStamp>> {
        self.targets.iter().find(|target| target.path == path).map(|target| target.before)
    }

    fn claim(&mut self, path: &Path) -> Result<()> {
        if is_standard_output(path) {
            return Ok(());
        }
        let place = self.add(path)?;
        let may_replace = self.force || self.continued.as_ref() == Some(&place);
        if place.is_file() && !may_replace && !self.is_default_name(&place) {
            bail!("cannot write {}: it exists already; --force replaces it", path.display());
        }
        Ok(())
    }

    fn is_default_name(&self, place: &Path) -> bool {
        let name = place.file_name().unwrap_or_default().to_string_lossy();
        DEFAULT_NAMES.iter().any(|(command, begin, end)| {
            let middle = name.strip_prefix(begin).and_then(|rest| rest.strip_suffix(end));
            *command == self.command && middle.is_some_and(|name| name.is_empty() || name.starts_with('_'))
        })
    }
}
