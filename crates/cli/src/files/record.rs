//! What was written by which command: by it a file is known again that nobody has changed since.
//!
//! One file for each directory, where programs keep what they remember (`$XDG_STATE_HOME/lemons`, else
//! `~/.local/state/lemons`; `%LOCALAPPDATA%\lemons`). Where none can be kept, every file that is there is a stranger's.

use lemons_files::input;
use lemons_fmi::fingerprint;
use serde::{Deserialize, Serialize};
use std::fs::{File, Metadata};
use std::path::{Path, PathBuf};
use std::time::UNIX_EPOCH;

/// Who wrote a file.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Writer {
    /// The command and the paths of what it is of: by these it is the same one.
    pub of: Vec<String>,
    /// As it was typed.
    pub typed: String,
}

impl Writer {
    /// This process, whose command is of these.
    pub fn own(command: &str, operands: &[PathBuf]) -> Writer {
        let words = std::env::args_os().skip(1).map(|word| quoted(&word.to_string_lossy()));
        let paths = operands.iter().map(|path| path.to_string_lossy().into_owned());
        Writer {
            of: std::iter::once(command.to_owned()).chain(paths).collect(),
            typed: format!("lemons {}", words.collect::<Vec<_>>().join(" ")),
        }
    }
}

fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_alphanumeric() || "-_./=,:+@%".contains(c);
    if !word.is_empty() && word.chars().all(plain) {
        word.to_owned()
    } else {
        format!("'{}'", word.replace('\'', "'\\''"))
    }
}

/// By what a change of a file is seen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Stamp {
    length: u64,
    /// \[ns\]
    modified: i64,
}

impl Stamp {
    pub fn of(file: &Metadata) -> Stamp {
        let since = file.modified().ok().and_then(|time| time.duration_since(UNIX_EPOCH).ok());
        let modified = since.and_then(|since| i64::try_from(since.as_nanos()).ok()).unwrap_or_default();
        Stamp { length: file.len(), modified }
    }
}

/// Of a file in the directory of a record.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Written {
    pub name: String,
    pub stamp: Stamp,
    pub by: Writer,
}

#[derive(Default, Serialize, Deserialize)]
struct Record {
    directory: String,
    #[serde(default)]
    file: Vec<Written>,
}

/// Directories that are remembered.
const MOST: usize = 2000;

fn home() -> Option<PathBuf> {
    let given = |name: &str| std::env::var_os(name).map(PathBuf::from).filter(|path| path.is_absolute());
    let base = given("XDG_STATE_HOME")
        .or_else(|| given("LOCALAPPDATA").filter(|_| cfg!(windows)))
        .or_else(|| Some(given("HOME")?.join(".local/state")))?;
    Some(base.join("lemons"))
}

fn place_of(directory: &Path) -> Option<PathBuf> {
    let name = format!("{:032x}.toml", fingerprint(directory.to_string_lossy().as_bytes()));
    Some(home()?.join("written").join(name))
}

fn read(directory: &Path) -> Record {
    let text = place_of(directory).and_then(|place| input::read_text(&place, input::LARGEST_SETTINGS).ok());
    let record: Record = text.and_then(|text| toml::from_str(&text).ok()).unwrap_or_default();
    if Path::new(&record.directory) == directory { record } else { Record::default() }
}

/// What was written in a directory, given by its one path.
pub fn of(directory: &Path) -> Vec<Written> {
    read(directory).file
}

/// Remembers these of a directory. What cannot be remembered is a stranger's next time, which is safe.
pub fn add(directory: &Path, new: Vec<Written>) {
    let Some(place) = place_of(directory) else { return };
    let Some(parent) = place.parent() else { return };
    if std::fs::create_dir_all(parent).is_err() {
        return;
    }
    // One process at a time, where files can be locked.
    let lock = File::options().create(true).append(true).open(parent.join("lock"));
    let _ = lock.as_ref().map(File::lock);
    let mut record = read(directory);
    record.directory = directory.to_string_lossy().into_owned();
    let kept = |old: &Written| {
        !new.iter().any(|new| new.name == old.name) && directory.join(&old.name).symlink_metadata().is_ok()
    };
    record.file.retain(kept);
    record.file.extend(new);
    if let Ok(text) = toml::to_string(&record) {
        // Not as other files are written: a process that is ended puts nothing more into place by that way.
        let new = place.with_extension(std::process::id().to_string());
        let _ = std::fs::write(&new, text)
            .and_then(|()| std::fs::rename(&new, &place))
            .or_else(|_| std::fs::remove_file(&new));
    }
    forget_oldest(parent);
}

fn forget_oldest(records: &Path) {
    let entries = std::fs::read_dir(records).into_iter().flatten().flatten();
    let mut all: Vec<_> =
        entries.map(|entry| entry.path()).filter(|path| path.extension().is_some()).collect();
    if all.len() <= MOST {
        return;
    }
    all.sort_by_cached_key(|path| path.metadata().and_then(|file| file.modified()).ok());
    for path in &all[..all.len() - MOST / 2] {
        let _ = std::fs::remove_file(path);
    }
}
