//! Writes files completely or not at all, and removes temporary ones.
//!
//! The modules; each imports only from those above it:
//!
//! - [`paths`]: where links lead, and free names
//! - [`guard`](mod@guard): places that another program may have changed meanwhile
//! - [`temporary`]: removed unless they are put into place
//! - [`staged`]: written beside their place, then moved there
//! - [`scratch`]: what only this process needs
//! - [`change`]: several files, all or none

mod change;
mod guard;
mod paths;
mod scratch;
mod staged;
mod temporary;

pub use change::{Change, change_all, remove_file, write_atomically};
pub use guard::{Before, Changed, guard, placed};
pub use paths::{names_beside, only_path};
pub use scratch::{Scratch, unnamed};
pub use staged::{Staged, StagedDirectory, reader_left, wait_no_longer, waited_in_vain};
use std::io;
use std::path::{Path, PathBuf};
pub use temporary::{give_up, make_directories};

/// A file that could not be written.
#[derive(Debug, thiserror::Error)]
#[error("{}: cannot be written: {error}", path.display())]
pub struct WriteError {
    /// The file or directory.
    pub path: PathBuf,
    /// The reason.
    pub error: io::Error,
}

impl WriteError {
    /// Returns a function for `map_err` that adds the path.
    pub fn at(path: &Path) -> impl FnOnce(io::Error) -> WriteError + use<> {
        let path = path.to_owned();
        move |error| WriteError { path, error }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tempfile::TempDir;

    #[test]
    fn all_changes_or_none() {
        let directory = TempDir::new().unwrap();
        let at = |name: &str| directory.path().join(name);
        std::fs::write(at("a"), "old a").unwrap();
        std::fs::write(at("b"), "old b").unwrap();
        let write = |name: &str, text: &str| Change::Write(at(name), text.into());
        change_all(&[write("a", "new a"), Change::Remove(at("b")), Change::Remove(at("none"))]).unwrap();
        assert_eq!(std::fs::read_to_string(at("a")).unwrap(), "new a");
        assert!(!at("b").exists());
        // A directory in the way makes the last change fail after the others were made.
        std::fs::create_dir_all(at("c/inside")).unwrap();
        for last in [Change::Remove(at("c")), write("c", "x"), write("no/such/directory", "x")] {
            assert!(change_all(&[write("a", "newer a"), write("d", "new d"), last]).is_err());
            assert_eq!(std::fs::read_to_string(at("a")).unwrap(), "new a");
            assert!(!at("d").exists());
        }
        let left = std::fs::read_dir(directory.path()).unwrap().count();
        assert_eq!(left, 2, "no temporary file is left");
    }

    #[test]
    #[cfg(unix)]
    fn links_lead_on_and_permissions_stay() {
        use std::os::unix::fs::{PermissionsExt, symlink};
        let directory = TempDir::new().unwrap();
        let (file, link) = (directory.path().join("file"), directory.path().join("link"));
        std::fs::write(&file, "old").unwrap();
        std::fs::set_permissions(&file, std::fs::Permissions::from_mode(0o640)).unwrap();
        symlink(&file, &link).unwrap();
        write_atomically(&link, "new").unwrap();
        assert!(link.symlink_metadata().unwrap().is_symlink());
        assert_eq!(std::fs::read_to_string(&file).unwrap(), "new");
        assert_eq!(file.metadata().unwrap().permissions().mode() & 0o777, 0o640);
    }

    #[test]
    #[cfg(unix)]
    fn links_to_what_is_not_there_lead_on_and_circles_are_an_error() {
        use std::os::unix::fs::symlink;
        let directory = TempDir::new().unwrap();
        let at = |name: &str| directory.path().join(name);
        symlink("file", at("link")).unwrap();
        symlink(at("link"), at("second")).unwrap();
        assert_eq!(only_path(&at("second")).unwrap(), only_path(&at("file")).unwrap());
        write_atomically(&at("second"), "new").unwrap();
        assert_eq!(std::fs::read_to_string(at("file")).unwrap(), "new");
        assert!(["link", "second"].iter().all(|link| at(link).symlink_metadata().unwrap().is_symlink()));
        symlink("there", at("back")).unwrap();
        symlink("back", at("there")).unwrap();
        assert!(only_path(&at("back")).is_err());
        let error = write_atomically(&at("back"), "x").unwrap_err().to_string();
        assert!(error.starts_with(&format!("{}: cannot be written: ", at("back").display())), "{error}");
        assert!(at("back").symlink_metadata().unwrap().is_symlink());
    }

    /// Guards are the process's: each test has its own directory.
    #[test]
    fn what_was_changed_since_it_was_looked_at_stays() {
        let directory = TempDir::new().unwrap();
        let at = |name: &str| directory.path().join(name);
        let guarded = |name: &str| {
            let before = at(name).metadata().map_or(Before::Nothing, Before::File);
            guard(only_path(&at(name)).unwrap(), before);
        };
        let placed = |name: &str| {
            let name = only_path(&at(name)).unwrap();
            placed().iter().any(|(place, _)| *place == name)
        };
        let read = |name: &str| std::fs::read_to_string(at(name)).unwrap();
        std::fs::write(at("a.txt"), "old").unwrap();
        ["a.txt", "b.txt", "c.txt"].into_iter().for_each(guarded);
        // Of what this process itself puts there it goes on.
        for text in ["new", "newer"] {
            write_atomically(&at("a.txt"), text).unwrap();
        }
        assert!(placed("a.txt") && !placed("b.txt"));
        std::fs::write(at("a.txt"), "edited").unwrap();
        std::fs::write(at("b.txt"), "appeared").unwrap();
        for (name, there) in [("a.txt", "edited"), ("b.txt", "appeared")] {
            for kept in ["_new", "_new_2"] {
                let kept = name.replace('.', &format!("{kept}."));
                let error = write_atomically(&at(name), "mine").unwrap_err().to_string();
                assert!(error.contains("another program changed it") && error.contains(&kept), "{error}");
                assert_eq!((read(name).as_str(), read(&kept).as_str()), (there, "mine"));
            }
            assert!(remove_file(&at(name)).is_err() && at(name).exists());
        }
        assert!(!placed("b.txt"));
        // What went away took nothing with it.
        std::fs::remove_file(at("a.txt")).unwrap();
        write_atomically(&at("a.txt"), "again").unwrap();
        // A change of several is undone, and is nobody's then.
        let changes = [Change::Write(at("c.txt"), "new".into()), Change::Write(at("b.txt"), "new".into())];
        assert!(change_all(&changes).is_err());
        assert!(!at("c.txt").exists() && !placed("c.txt") && read("b.txt") == "appeared");
    }

    #[test]
    #[cfg(unix)]
    fn what_is_no_regular_file_is_written_not_replaced() {
        use std::os::unix::fs::FileTypeExt;
        let directory = TempDir::new().unwrap();
        let pipe = directory.path().join("pipe");
        assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
        let reader = std::thread::spawn({
            let pipe = pipe.clone();
            move || std::fs::read_to_string(pipe).unwrap()
        });
        write_atomically(&pipe, "through").unwrap();
        assert_eq!(reader.join().unwrap(), "through");
        // Nobody writes to it, so nothing can be read of it.
        let reader = std::thread::spawn({
            let pipe = pipe.clone();
            move || std::fs::read_to_string(pipe).unwrap()
        });
        change_all(&[Change::Write(pipe.clone(), "through".into())]).unwrap();
        assert_eq!(reader.join().unwrap(), "through");
        assert!(change_all(&[Change::Remove(pipe.clone())]).is_err());
        assert!(pipe.metadata().unwrap().file_type().is_fifo());
        assert!(write_atomically(directory.path(), "x").is_err(), "a directory is no place for a file");
    }
}
