//! What the command reads and what it writes: the one place that says whether a file may be written.
//!
//! - What is read is never written, whatever path leads to it.
//! - No two outputs go into one file, pipe or device, but for `/dev/null`.
//! - A file that is there is replaced only by the command that wrote it, of the same Trial, FMU or table, and only if
//!   nobody has changed it since. Everything else needs `--force`.
//! - A file that somebody changes while the command runs is not replaced either: the results stay beside it.
//! - `-` is standard output, for what is a text or a picture; the command's own words go to standard error then.

mod record;
mod roles;

use crate::error::Misused;
use crate::tell;
use anyhow::{Context, Result, bail};
use clap::ArgMatches;
use lemons_decision::WISHES_FILE;
use lemons_files::{Before, Staged, guard, only_path, placed};
use lemons_record::series_in;
use lemons_trial::Trial;
use record::{Stamp, Writer, Written};
use roles::{Argument, ROLES, Role};
use std::collections::{BTreeMap, HashMap};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Says of a Trial that is replaced which files stay there that the command does not write, and that are used. Of these,
/// it writes `written`.
pub fn staying(trial: &Path, written: &[&str]) -> impl Iterator<Item = String> {
    let names = [lemons_trial::DRIVE_FILE, WISHES_FILE].into_iter().filter(|name| !written.contains(name));
    let files: Vec<PathBuf> = names.map(|name| trial.join(name)).collect();
    files
        .into_iter()
        .filter(|file| file.is_file())
        .map(|file| format!("warning: {} of the Trial that was there stays, and is used", file.display()))
}

/// Of the commands that write.
#[derive(clap::Args, Clone)]
pub struct Force {
    /// Replace existing files, even if they were made from something else or were changed since
    #[arg(long)]
    pub force: bool,
}

/// One file, whatever path leads to it.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
enum Identity {
    /// Device and inode.
    #[cfg(unix)]
    Node(u64, u64),
    /// Absolute and without links.
    Path(PathBuf),
}

/// Why a file cannot be written.
#[derive(Debug, Clone)]
enum Taken {
    /// By the argument of this name.
    Read(String),
    Written,
}

#[derive(Default)]
struct Files {
    command: String,
    writer: Writer,
    force: bool,
    taken: HashMap<Identity, Taken>,
    /// What a run goes on from, it may replace.
    goes_on: Vec<Identity>,
    /// What may be written: its one path, and how the user calls it.
    places: BTreeMap<PathBuf, PathBuf>,
    records: HashMap<PathBuf, Vec<Written>>,
    /// Directories where an FMU writes the files of a series, and those that were there.
    series: Vec<(PathBuf, BTreeMap<String, Stamp>)>,
    remembered: bool,
    /// Something goes to standard output.
    shown: bool,
}

/// Of the one command of this process.
static FILES: Mutex<Option<Files>> = Mutex::new(None);

fn files() -> MutexGuard<'static, Option<Files>> {
    FILES.lock().unwrap_or_else(PoisonError::into_inner)
}

fn with<T>(work: impl FnOnce(&mut Files) -> T) -> T {
    work(files().get_or_insert_default())
}

/// Whether results go to standard output instead of a file.
pub fn is_standard_output(path: &Path) -> bool {
    path.as_os_str() == "-"
}

fn standard_output() -> io::Result<Staged> {
    #[cfg(unix)]
    let own = std::os::fd::AsFd::as_fd(&io::stdout()).try_clone_to_owned()?;
    #[cfg(windows)]
    let own = std::os::windows::io::AsHandle::as_handle(&io::stdout()).try_clone_to_owned()?;
    Ok(Staged::onto(own.into()))
}

fn identities(path: &Path) -> io::Result<Vec<Identity>> {
    let only = only_path(path)?;
    let mut all = Vec::new();
    #[cfg(unix)]
    if let Ok(there) = only.metadata() {
        use std::os::unix::fs::MetadataExt;
        all.push(Identity::Node(there.dev(), there.ino()));
    }
    all.push(Identity::Path(only));
    Ok(all)
}

/// What is read of it: a file, a Trial's files (those too that are not there), the files of a series.
fn read_of(path: &Path) -> Vec<PathBuf> {
    let mut all = vec![path.to_owned()];
    if path.join("Parameters.xml").is_file() {
        let files = Trial::files_read(path);
        // Nothing is put into its directories, either.
        all.extend(
            files.iter().filter_map(|file| file.parent()).filter(|dir| *dir != path).map(Path::to_owned),
        );
        all.extend(files);
        all.extend([lemons_trial::DRIVE_FILE, WISHES_FILE].map(|name| path.join(name)));
    } else if path.is_dir() {
        let entries = std::fs::read_dir(path).into_iter().flatten().flatten();
        all.extend(entries.map(|entry| entry.path()));
    }
    all
}

/// The arguments of a command that name files.
pub fn roles_of(command: &str) -> &'static [Argument] {
    ROLES.iter().find(|(name, _)| *name == command).map_or(&[], |(_, roles)| roles)
}

/// Notes what the arguments of a command name.
///
/// # Errors
/// An output is an input.
pub fn begin(command: &str, arguments: &ArgMatches) -> Result<()> {
    let force = arguments.try_get_one::<bool>("force").ok().flatten().copied().unwrap_or_default();
    let roles = roles_of(command);
    let given = |id: &str| -> Vec<PathBuf> {
        let raw = arguments.try_get_raw(id).ok().flatten();
        raw.into_iter().flatten().map(PathBuf::from).collect()
    };
    let operands = roles.iter().filter(|(_, spelled, role)| spelled.is_empty() && *role == Role::Reads);
    let operands = operands.flat_map(|(id, ..)| given(id)).map(|path| only_path(&path).unwrap_or(path));
    let writer = Writer::own(command, &operands.collect::<Vec<_>>());
    with(|files| (files.command, files.writer, files.force) = (command.to_owned(), writer, force));
    let mut outputs = Vec::new();
    for (id, spelled, role) in roles {
        for path in given(id) {
            let who = if spelled.is_empty() { path.display().to_string() } else { (*spelled).to_owned() };
            match role {
                Role::Reads => reads(&path, &who),
                Role::ReadsAfterEquals => {
                    let text = path.to_string_lossy();
                    text.split_once('=').into_iter().for_each(|(_, path)| reads(Path::new(path), &who));
                }
                Role::GoesOn => {
                    let own = identities(&path).unwrap_or_default();
                    let over =
                        given("state").iter().any(|state| identities(state).is_ok_and(|all| all == own));
                    if over { with(|files| files.goes_on = own) } else { reads(&path, &who) }
                }
                Role::Shows if is_standard_output(&path) => {
                    if with(|files| std::mem::replace(&mut files.shown, true)) {
                        bail!("cannot write -: another result goes there");
                    }
                    tell::speak_aside();
                }
                Role::Writes | Role::WritesInto if is_standard_output(&path) => {
                    let option = if spelled.is_empty() { id } else { spelled };
                    bail!(Misused(format!(
                        "{option} -: this result cannot go to standard output; for a file of this name, write ./-"
                    )));
                }
                Role::Shows | Role::Writes | Role::WritesInto => outputs.push(path),
            }
        }
    }
    check_shared(&outputs)?;
    // Later ones may be in directories that are made first.
    outputs.iter().try_for_each(|path| with(|files| files.check_unread(path)))
}

/// That no pipe or device is to take two outputs, before one of them is opened, which waits for a reader.
fn check_shared(outputs: &[PathBuf]) -> Result<()> {
    let mut seen = Vec::new();
    for path in outputs.iter().filter(|path| is_device(path) && !is_nowhere(path)) {
        let all = identities(path).unwrap_or_default();
        if all.iter().any(|one| seen.contains(one)) {
            bail!("cannot write {}: another result goes there", path.display());
        }
        seen.extend(all);
    }
    Ok(())
}

/// Whether something is there that is written, and not replaced.
fn is_device(path: &Path) -> bool {
    path.metadata().is_ok_and(|there| !there.is_file() && !there.is_dir())
}

/// Whether what is written there disappears.
fn is_nowhere(path: &Path) -> bool {
    path.canonicalize().is_ok_and(|place| place == Path::new("/dev/null"))
}

/// Notes that the command reads this for somebody: an option, or what another file names.
pub fn reads(path: &Path, who: &str) {
    with(|files| {
        for identity in read_of(path).iter().flat_map(|path| identities(path).unwrap_or_default()) {
            files.taken.entry(identity).or_insert_with(|| Taken::Read(who.to_owned()));
        }
    });
}

/// Whether a file may be written; from now on nothing else goes there.
///
/// # Errors
/// It is read, another result goes there, or what is there is not to be replaced.
pub fn claim(path: &Path) -> Result<()> {
    with(|files| files.claim(path))
}

/// A file that appears under its name only when it is complete.
///
/// # Errors
/// As [`claim`], or it cannot be written.
pub fn stage(path: &Path) -> Result<Staged> {
    claim(path)?;
    open(path)
}

/// As [`stage`], where nothing is there yet.
///
/// # Errors
/// As [`stage`], or a file is there, and `--force` is not given.
pub fn stage_new(path: &Path) -> Result<Staged> {
    let there =
        !is_standard_output(path) && path.metadata().is_ok_and(|there| there.is_file() && there.len() > 0);
    if there && !with(|files| files.force) {
        bail!(
            "{}: it is there, and may hold what the saved run has written: give the rows that follow a file of their \
             own (-o FILE); --force replaces it",
            path.display()
        );
    }
    stage(path)
}

/// Opens what was claimed.
///
/// # Errors
/// It cannot be written.
pub fn open(path: &Path) -> Result<Staged> {
    let file = if is_standard_output(path) { standard_output() } else { Staged::beside(path) };
    file.with_context(|| format!("cannot write {}", path.display()))
}

/// Claims a file that is written later, and sees that it can be.
///
/// # Errors
/// As [`stage`].
pub fn claim_and_try(path: &Path) -> Result<()> {
    claim(path)?;
    // A pipe would be opened, and closed for its reader.
    if is_device(path) { Ok(()) } else { open(path).map(drop) }
}

/// Whether files may be put into a directory: into none that is read itself.
///
/// # Errors
/// It is read, or another result goes there.
pub fn claim_directory(directory: &Path) -> Result<()> {
    with(|files| {
        files.check_unread(directory)?;
        files.take(directory)
    })
}

/// Whether an FMU may write the files of a series into a directory. Returns those that are there, all of this command's;
/// `is_own` says of a name, with its time \[s\], whether it is of this run.
///
/// # Errors
/// As [`claim_directory`] and [`claim`], or a file is of another run.
pub fn claim_series(directory: &Path, is_own: impl Fn(&str, Option<f64>) -> bool) -> Result<Vec<PathBuf>> {
    claim_directory(directory)?;
    let names = series_in(directory, is_own)?;
    let there: Vec<PathBuf> = names.iter().map(|name| directory.join(name)).collect();
    there.iter().try_for_each(|path| claim(path))?;
    let directory = only_path(directory).with_context(|| format!("cannot write {}", directory.display()))?;
    with(|files| files.series.push((directory.clone(), stamps(&directory))));
    Ok(there)
}

/// Of the files of a series.
fn stamps(directory: &Path) -> BTreeMap<String, Stamp> {
    let names = series_in(directory, |_, _| true).unwrap_or_default();
    let stamp = |name: &str| Some(Stamp::of(&directory.join(name).symlink_metadata().ok()?));
    names.into_iter().filter_map(|name| stamp(&name).map(|stamp| (name, stamp))).collect()
}

/// What is complete and in its place, as the user calls it.
pub fn complete() -> Vec<PathBuf> {
    let there = placed().into_iter().filter(|(place, _)| place.exists());
    with(|files| there.filter_map(|(place, _)| files.places.get(&place).cloned()).collect())
}

/// Remembers what was put into its place, so that the same command may replace it. Once: whoever ends the process
/// meanwhile waits for it.
pub fn remember() {
    with(|files| {
        if std::mem::replace(&mut files.remembered, true) {
            return;
        }
        let mut new: BTreeMap<PathBuf, Vec<Written>> = BTreeMap::new();
        // As it was put there: whoever changed it a moment later is a stranger.
        for (place, there) in placed() {
            let (Some(directory), Some(name)) = (place.parent(), place.file_name()) else { continue };
            // Of what was temporary nothing is left.
            if !place.exists() {
                continue;
            }
            let name = name.to_string_lossy().into_owned();
            let written = Written { name, stamp: Stamp::of(&there), by: files.writer.clone() };
            new.entry(directory.to_owned()).or_default().push(written);
        }
        // An FMU's library knows nothing of what this program guards.
        for (directory, before) in &files.series {
            let now = stamps(directory).into_iter().filter(|(name, stamp)| before.get(name) != Some(stamp));
            let now = now.map(|(name, stamp)| Written { name, stamp, by: files.writer.clone() });
            new.entry(directory.clone()).or_default().extend(now);
        }
        for (directory, new) in new {
            record::add(&directory, new);
        }
    });
}

impl Files {
    fn claim(&mut self, path: &Path) -> Result<()> {
        if is_standard_output(path) {
            return Ok(());
        }
        let cannot = || format!("cannot write {}", path.display());
        self.check_unread(path)?;
        let there = path.metadata().ok();
        // What is not a regular file is written, not replaced.
        if there.as_ref().is_some_and(|there| !there.is_file()) {
            return if is_nowhere(path) { Ok(()) } else { self.take(path) };
        }
        self.take(path)?;
        let place = only_path(path).with_context(cannot)?;
        let own = identities(path).is_ok_and(|all| all.iter().any(|one| self.goes_on.contains(one)));
        if let Some(there) = there.as_ref().filter(|_| !own && !self.force)
            && let Some(why) = self.why_keep(&place, there.len(), Stamp::of(there))
        {
            bail!("{}: {why}; --force replaces it", cannot());
        }
        guard(
            place.clone(),
            match there {
                _ if self.force => Before::Anything,
                Some(there) => Before::File(there),
                None => Before::Nothing,
            },
        );
        self.places.insert(place, path.to_owned());
        Ok(())
    }

    fn check_unread(&self, path: &Path) -> Result<()> {
        let all = identities(path).with_context(|| format!("cannot write {}", path.display()))?;
        match all.iter().find_map(|one| self.taken.get(one)) {
            Some(Taken::Read(who)) => {
                bail!("cannot write {}: lemons {} reads it ({who})", path.display(), self.command)
            }
            _ => Ok(()),
        }
    }

    fn take(&mut self, path: &Path) -> Result<()> {
        for identity in identities(path).with_context(|| format!("cannot write {}", path.display()))? {
            if self.taken.insert(identity, Taken::Written).is_some() {
                bail!("cannot write {}: another result goes there", path.display());
            }
        }
        Ok(())
    }

    /// Why what is there is not to be replaced.
    fn why_keep(&mut self, place: &Path, length: u64, stamp: Stamp) -> Option<String> {
        // Nothing is lost.
        if length == 0 {
            return None;
        }
        let directory = place.parent()?.to_owned();
        let name = place.file_name()?.to_string_lossy();
        let record = self.records.entry(directory).or_insert_with_key(|directory| record::of(directory));
        match record.iter().find(|written| written.name == name) {
            None => Some("it exists already, and lemons has no record of writing it".to_owned()),
            Some(written) if written.stamp != stamp => {
                Some(format!("it was changed after `{}` wrote it", written.by.typed))
            }
            Some(written) if written.by.of == self.writer.of => None,
            Some(written) => Some(format!("it was made from something else, by `{}`", written.by.typed)),
        }
    }
}
