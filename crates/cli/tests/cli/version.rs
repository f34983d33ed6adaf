//! The version that `build.rs` finds: it is compiled here and run on repositories of its own.

use crate::common::{done, out};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::LazyLock;
use tempfile::TempDir;

/// The build script as a program.
static SCRIPT: LazyLock<(TempDir, PathBuf)> = LazyLock::new(|| {
    let directory = TempDir::new().unwrap();
    let program = directory.path().join(format!("script{}", std::env::consts::EXE_SUFFIX));
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("build.rs");
    let rustc = Path::new(env!("CARGO")).with_file_name(format!("rustc{}", std::env::consts::EXE_SUFFIX));
    let mut command = Command::new(rustc);
    command.args(["--edition", "2024", "--crate-name", "script", "-o"]).arg(&program).arg(source);
    assert!(command.status().unwrap().success());
    (directory, program)
});

/// Output of the script for a workspace.
struct Printed {
    /// Commit, date, "1" for changes.
    values: [String; 3],
    /// Files for which it is run again.
    watched: Vec<PathBuf>,
}

fn script(root: &Path, around: &[(&str, &str)]) -> Printed {
    let mut command = Command::new(&SCRIPT.1);
    command.env("CARGO_MANIFEST_DIR", root.join("crates/cli")).env("OUT_DIR", SCRIPT.0.path());
    for name in ["LEMONS_COMMIT", "LEMONS_COMMIT_DATE", "SOURCE_DATE_EPOCH"] {
        command.env_remove(name);
    }
    let output = command.envs(around.iter().copied()).output().unwrap();
    assert!(output.status.success() && output.stderr.is_empty(), "{output:?}");
    let text = out(&output);
    let all = |begin: &str| text.lines().filter_map(|line| line.strip_prefix(begin)).collect::<Vec<_>>();
    let values = ["COMMIT", "DATE", "CHANGED"]
        .map(|name| all(&format!("cargo::rustc-env=LEMONS_BUILD_{name}="))[0].to_owned());
    let watched: Vec<PathBuf> = all("cargo::rerun-if-changed=").into_iter().map(PathBuf::from).collect();
    // Cargo runs a script each time if a file is not there.
    assert!(watched.iter().all(|path| path.exists()), "{text}");
    Printed { values, watched }
}

/// The directory of a workspace.
fn workspace(at: &Path) -> PathBuf {
    let root = at.join("workspace");
    for (name, text) in [
        ("Cargo.toml", "[workspace]"),
        ("build.rs", ""),
        ("crates/cli/build.rs", ""),
        ("src/lib.rs", "//! One."),
        ("crates/cli/src/lib.rs", "//! Two."),
        ("crates/cli/tests/all.rs", "//! Three."),
        ("README.md", "four"),
    ] {
        let path = root.join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, text).unwrap();
    }
    root.canonicalize().unwrap()
}

fn git(root: &Path, arguments: &[&str]) -> String {
    let mut command = Command::new("git");
    for (name, _) in std::env::vars_os().filter(|(name, _)| name.to_string_lossy().starts_with("GIT_")) {
        command.env_remove(name);
    }
    let date = "2026-11-22T23:30:00-02:00";
    command.env("GIT_AUTHOR_DATE", date).env("GIT_COMMITTER_DATE", date);
    command.env("GIT_CONFIG_GLOBAL", root.join("none")).env("GIT_CONFIG_NOSYSTEM", "1");
    let who = ["-c", "user.name=A", "-c", "user.email=a@example.org", "-c", "init.defaultBranch=main"];
    let output = command.arg("-C").arg(root).args(who).args(arguments).output().unwrap();
    assert!(output.status.success(), "git {arguments:?}: {output:?}");
    out(&output).trim().to_owned()
}

/// A repository with one commit.
fn repository(at: &Path) -> PathBuf {
    let root = workspace(at);
    git(&root, &["init", "-q"]);
    git(&root, &["add", "."]);
    git(&root, &["commit", "-q", "-m", "one"]);
    root
}

/// Newest time of what a script is run again for.
fn newest(printed: &Printed) -> std::time::SystemTime {
    printed.watched.iter().map(|path| path.symlink_metadata().unwrap().modified().unwrap()).max().unwrap()
}

#[test]
fn the_command_says_its_version_and_commit() {
    let here = TempDir::new().unwrap();
    let [short, long] = ["-V", "--version"].map(|option| out(&done(here.path(), &[option])));
    let version = env!("CARGO_PKG_VERSION");
    assert!(short.starts_with(&format!("lemons {version}")) && short.lines().count() == 1, "{short}");
    assert_eq!(long.lines().next(), short.lines().next());
    let Some((_, known)) = short.split_once(" (") else { return };
    let commit = known.split([' ', ')']).next().unwrap();
    assert!(long.contains(&format!("\ncommit {commit}")), "{short}{long}");
    // Sources with `.git` are at least said to be of a commit.
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let told = option_env!("LEMONS_COMMIT").is_some();
    assert!(told || !root.join(".git").exists() || commit.len() == 7, "{short}");
}

#[test]
fn a_commit_its_date_and_changes_are_said() {
    let directory = TempDir::new().unwrap();
    let root = repository(directory.path());
    let says = |changed: &str| {
        // In UTC it is the next day.
        assert_eq!(script(&root, &[]).values, [&*git(&root, &["rev-parse", "HEAD"]), "2026-11-23", changed]);
    };
    says("");
    // What no program is built from is no change of it.
    fs::write(root.join("README.md"), "five").unwrap();
    fs::write(root.join("crates/cli/tests/all.rs"), "//! Six.").unwrap();
    fs::write(root.join("src/new.rs"), "//! Not in git, named by nobody.").unwrap();
    says("");
    fs::write(root.join("crates/cli/src/lib.rs"), "//! Seven.").unwrap();
    says("1");
    git(&root, &["commit", "-q", "-a", "-m", "two"]);
    says("");
}

#[test]
fn it_is_run_again_for_a_commit_and_not_for_a_question() {
    let directory = TempDir::new().unwrap();
    let root = repository(directory.path());
    let next = |root: &Path, what: &str| {
        let before = newest(&script(root, &[]));
        // A program that asks git refreshes its index.
        git(root, &["status"]);
        assert_eq!(newest(&script(root, &[])), before, "{what}: nothing happened");
        std::thread::sleep(std::time::Duration::from_millis(20));
        let commit = script(root, &[]);
        git(root, &["commit", "-q", "--allow-empty", "-m", what]);
        // Of the files that were watched before.
        assert!(newest(&commit) > before, "{what}: the commit is not seen");
        assert_ne!(script(root, &[]).values, commit.values, "{what}");
    };
    next(&root, "a branch");
    git(&root, &["pack-refs", "--all"]);
    assert!(!root.join(".git/refs/heads/main").exists());
    next(&root, "a packed branch");
    git(&root, &["checkout", "-q", "--detach"]);
    next(&root, "no branch");
    git(&root, &["worktree", "add", "-q", "-b", "other", "../tree"]);
    let tree = root.join("../tree").canonicalize().unwrap();
    assert!(tree.join(".git").is_file());
    next(&tree, "a worktree");
    git(&root, &["pack-refs", "--all"]);
    next(&tree, "a worktree of a packed branch");
}

#[test]
fn sources_without_git_have_a_version_only_wherever_they_lie() {
    let directory = TempDir::new().unwrap();
    // Within somebody else's repository.
    let outer = repository(directory.path());
    let root = workspace(&outer.join("vendored"));
    let says_nothing = |around: &[(&str, &str)]| assert_eq!(script(&root, around).values, [""; 3]);
    says_nothing(&[]);
    // A `.git` that is none must not lead there either.
    fs::create_dir(root.join(".git")).unwrap();
    says_nothing(&[]);
    fs::remove_dir(root.join(".git")).unwrap();
    fs::write(root.join(".git"), "gitdir: /nowhere/at/all\n").unwrap();
    says_nothing(&[]);
    // Nor what a hook of it sets.
    says_nothing(&[("GIT_DIR", outer.join(".git").to_str().unwrap())]);
}

#[test]
fn packagers_say_commit_and_date() {
    let directory = TempDir::new().unwrap();
    let root = repository(directory.path());
    let own = git(&root, &["rev-parse", "HEAD"]);
    fs::write(root.join("src/lib.rs"), "//! Patched.").unwrap();
    for (commit, date, epoch, expected) in [
        ("v0.1.0", "2026-11-20", "", ["v0.1.0", "2026-11-20", ""]),
        ("abc1234", "", "1709164800", ["abc1234", "2024-02-29", ""]),
        ("abc1234", "", "", ["abc1234", "", ""]),
        ("two words\nand lines", "", "", ["", "", ""]),
        ("-", "", "951868799", [&own, "2000-02-29", "1"]),
        ("-", "", "-1", [&own, "1969-12-31", "1"]),
        ("-", "", "4107542400", [&own, "2100-03-01", "1"]),
        ("-", "", "9223372036854775807", [&own, "2026-11-23", "1"]),
        ("-", "", "soon", [&own, "2026-11-23", "1"]),
    ] {
        let mut around = vec![("LEMONS_COMMIT_DATE", date), ("SOURCE_DATE_EPOCH", epoch)];
        around.extend((commit != "-").then_some(("LEMONS_COMMIT", commit)));
        assert_eq!(script(&root, &around).values, expected, "{around:?}");
    }
}
