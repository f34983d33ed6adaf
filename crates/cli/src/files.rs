//! What the command reads and what it writes: the one place that says whether a file may be written.
//!
//! - What is read is never written, whatever path leads to it.
//! - No two outputs go into one file.
//! - A file that is there is replaced only by the command that wrote it, of the same Trial, FMU or table, and only as
//!   long as nobody has changed it. Everything else needs `--force`.

mod record;
mod roles;

use anyhow::{Context, Result, bail};
use clap::ArgMatches;
use crowd_mechanics::files::Staged;
use crowd_mechanics::trial::Trial;
use record::{Stamp, Writer, Written};
use roles::{Argument, ROLES, Role};
use std::collections::{BTreeMap, HashMap};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Of the people of a Trial, in its directory.
pub const WISHES_FILE: &str = "decision.toml";

/// Of the commands that write.
#[derive(clap::Args, Clone)]
pub struct Force {
    /// Replace files that are there although they are of something else, or somebody changed them
    #[arg(long)]
    pub force: bool,
}

/// One file, whatever path leads to it.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
enum Identity {
    /// Device and inode.
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
    /// What may have been written, and what was there before.
    places: Vec<(PathBuf, Option<Stamp>)>,
    records: HashMap<PathBuf, Vec<Written>>,
}

/// Of the one command of this process.
static FILES: Mutex<Option<Files>> = Mutex::new(None);

fn files() -> MutexGuard<'static, Option<Files>> {
    FILES.lock().unwrap_or_else(PoisonError::into_inner)
}

fn with<T>(work: impl FnOnce(&mut Files) -> T) -> T {
    work(files().get_or_insert_default())
}

/// The one path of a file, which need not be there: absolute and without links.
fn only_path(path: &Path) -> io::Result<PathBuf> {
    if let Ok(there) = path.canonicalize() {
        return Ok(there);
    }
    let name = path.file_name().ok_or(io::ErrorKind::InvalidFilename)?;
    let directory = path.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
    // Of directories that are yet to be made.
    let directory = if directory.exists() { directory.canonicalize()? } else { only_path(directory)? };
    Ok(directory.join(name))
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
        all.extend(Trial::files_read(path));
        all.extend([crowd_mechanics::pack::DRIVE_FILE, WISHES_FILE].map(|name| path.join(name)));
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
                Role::Writes | Role::WritesInto => outputs.push(path),
            }
        }
    }
    // Later ones may be in directories that are made first.
    outputs.iter().try_for_each(|path| with(|files| files.check_unread(path)))
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
/// It is read, other results go there, or what is there is not to be replaced.
pub fn claim(path: &Path) -> Result<()> {
    with(|files| files.claim(path, false))
}

/// As [`claim`], for a file whose content is kept and continued, or that is put together from what it holds.
///
/// # Errors
/// It is read, or other results go there.
pub fn claim_to_go_on(path: &Path) -> Result<()> {
    with(|files| files.claim(path, true))
}

/// A file that appears under its name only when it is complete.
///
/// # Errors
/// As [`claim`], or it cannot be written.
pub fn stage(path: &Path) -> Result<Staged> {
    claim(path)?;
    open(path)
}

/// As [`stage`] after [`claim_to_go_on`].
///
/// # Errors
/// As those.
pub fn stage_to_go_on(path: &Path) -> Result<Staged> {
    claim_to_go_on(path)?;
    open(path)
}

fn open(path: &Path) -> Result<Staged> {
    Staged::beside(path).with_context(|| format!("cannot write {}", path.display()))
}

/// Claims a file that is written later, and sees that it can be.
///
/// # Errors
/// As [`stage`].
pub fn claim_and_try(path: &Path) -> Result<()> {
    claim(path)?;
    // A pipe would be opened, and closed for its reader.
    let device = path.metadata().is_ok_and(|there| !there.is_file() && !there.is_dir());
    if device { Ok(()) } else { open(path).map(drop) }
}

/// Whether files may be put into a directory: into none that is read itself.
///
/// # Errors
/// It is read, or other results go there.
pub fn claim_directory(directory: &Path) -> Result<()> {
    with(|files| {
        files.check_unread(directory)?;
        files.take(directory)
    })
}

/// Remembers what was written, so that the same command may replace it.
pub fn remember() {
    let Some(files) = files().take() else { return };
    let mut new: BTreeMap<PathBuf, Vec<Written>> = BTreeMap::new();
    for (place, before) in files.places {
        let (Some(directory), Some(name)) = (place.parent(), place.file_name()) else { continue };
        let there = place.metadata().ok().filter(std::fs::Metadata::is_file);
        let Some(stamp) = there.as_ref().map(Stamp::of).filter(|stamp| Some(*stamp) != before) else {
            continue;
        };
        let name = name.to_string_lossy().into_owned();
        let written = Written { name, stamp, by: files.writer.clone() };
        new.entry(directory.to_owned()).or_default().push(written);
    }
    for (directory, new) in new {
        record::add(&directory, new);
    }
}

impl Files {
    fn claim(&mut self, path: &Path, goes_on: bool) -> Result<()> {
        let cannot = || format!("cannot write {}", path.display());
        self.check_unread(path)?;
        let there = path.metadata().ok();
        // What is no regular file is written, not replaced.
        if there.as_ref().is_some_and(|there| !there.is_file()) {
            return Ok(());
        }
        self.take(path)?;
        let place = only_path(path).with_context(cannot)?;
        let own = identities(path).is_ok_and(|all| all.iter().any(|one| self.goes_on.contains(one)));
        if let Some(there) = there.as_ref().filter(|_| !goes_on && !own && !self.force)
            && let Some(why) = self.why_keep(&place, there.len(), Stamp::of(there))
        {
            bail!("{}: {why}; --force replaces it", cannot());
        }
        self.places.push((place, there.as_ref().map(Stamp::of)));
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
                bail!("cannot write {}: other results go there", path.display());
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
            None => Some("it is there already, and lemons does not know it as its own".to_owned()),
            Some(written) if written.stamp != stamp => {
                Some(format!("it was changed after `{}` wrote it", written.by.typed))
            }
            Some(written) if written.by.of == self.writer.of => None,
            Some(written) => Some(format!("it is of something else, `{}` wrote it", written.by.typed)),
        }
    }
}
