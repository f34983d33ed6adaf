//! Where the tests of all crates find their files. It uses none of them.

use std::path::{Path, PathBuf};

/// The root of the repository.
pub fn repository() -> &'static Path {
    let own = Path::new(env!("CARGO_MANIFEST_DIR"));
    own.ancestors().nth(2).expect("it is crates/testing of the repository")
}

/// The default Trial: the push of the paper's App. C, with five agents.
pub fn trial_push() -> PathBuf {
    repository().join("resources/Trial_push")
}

/// A room with a door and its `decision.toml`.
pub fn trial_door() -> PathBuf {
    repository().join("resources/Trial_door")
}

/// Scenarios: their names, and the files.
///
/// # Panics
/// There are few, or they cannot be found.
pub fn scenarios() -> Vec<(String, PathBuf)> {
    let files = std::fs::read_dir(repository().join("crates/scenario/tests/crowds")).expect("scenarios");
    let named = |path: PathBuf| (path.file_stem().expect("a name").to_string_lossy().into_owned(), path);
    let mut all: Vec<_> = files.map(|file| named(file.expect("a scenario").path())).collect();
    all.sort();
    assert!(all.len() >= 20, "{all:?}");
    all
}

/// A file or directory of the data that are beside the repository. `None`, with a message for the test's output, if it
/// is not there: the test is skipped then.
pub fn shared(part: &str) -> Option<PathBuf> {
    let path = repository().join("../shared/data").join(part);
    if path.exists() {
        return Some(path);
    }
    eprintln!("skipped: there is no {}", path.display());
    None
}

/// Copies a directory with everything in it.
///
/// # Panics
/// A file cannot be read or written.
pub fn copy_tree(from: &Path, to: &Path) {
    let must = |done: std::io::Result<()>| done.unwrap_or_else(|error| panic!("{}: {error}", to.display()));
    must(std::fs::create_dir_all(to));
    for entry in std::fs::read_dir(from).unwrap_or_else(|error| panic!("{}: {error}", from.display())) {
        let path = entry.expect("an entry of a directory").path();
        let to = to.join(path.file_name().expect("an entry has a name"));
        if path.is_dir() {
            copy_tree(&path, &to);
        } else {
            must(std::fs::copy(&path, to).map(drop));
        }
    }
}
