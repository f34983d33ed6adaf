//! Finds the sources from which the command `lemons` is built: the commit, its date, and whether files have changed
//! since.
//!
//! It also lists the files of the lab (`lab/dist`, made by `lab/build.sh`), for the command to hold them.
//!
//! It belongs to the only crate that shows the version. As the build script of the root package it would rebuild the
//! engine and everything that uses it for each commit. It never fails: what it cannot find is left empty.
//!
//! Packagers whose sources have no `.git` set `LEMONS_COMMIT`, and `LEMONS_COMMIT_DATE` (`2026-11-22`) or
//! `SOURCE_DATE_EPOCH` \[s\]. These have priority over `.git`.

use std::env;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Files that programs are built from, as git's pathspecs.
const BUILT_FROM: [&str; 8] = [
    "Cargo.toml",
    "Cargo.lock",
    "build.rs",
    "src",
    "crates",
    ":(exclude,glob)crates/*/tests/**",
    ":(exclude,glob)crates/*/benches/**",
    ":(exclude,glob)crates/*/examples/**",
];

fn main() {
    // The workspace. A `.git` in a directory above it belongs to another project.
    let root = PathBuf::from(env::var_os("CARGO_MANIFEST_DIR").unwrap_or_default()).join("../..");
    let root = root.canonicalize().unwrap_or(root);
    println!("cargo::rerun-if-changed={}", root.join("crates/cli/build.rs").display());
    let [commit, date, epoch] = ["LEMONS_COMMIT", "LEMONS_COMMIT_DATE", "SOURCE_DATE_EPOCH"].map(|name| {
        println!("cargo::rerun-if-env-changed={name}");
        env::var(name).ok()
    });
    let is_repository = commit.is_none() && root.join(".git").exists();
    let [own, day_of_it, changed] = is_repository.then(|| of_git(&root)).flatten().unwrap_or_default();
    let epoch = epoch.and_then(|seconds| day(seconds.trim().parse().ok()?));
    let date = date.as_deref().and_then(plain).or(epoch).unwrap_or(day_of_it);
    println!(
        "cargo::rustc-env=LEMONS_BUILD_COMMIT={}",
        commit.map_or(Some(own), |commit| plain(&commit)).unwrap_or_default()
    );
    println!("cargo::rustc-env=LEMONS_BUILD_DATE={date}");
    println!("cargo::rustc-env=LEMONS_BUILD_CHANGED={changed}");
    lab(&root);
}

/// Writes `lab.rs` into `OUT_DIR`: the names and contents of the files in `lab/dist`, none if it was not made. The
/// libraries there are not among them: the command has its own. Of a file that is there compressed, too, it holds this one.
fn lab(root: &Path) {
    let dist = root.join("lab/dist");
    // Cargo would run this each time for a directory that is not there.
    if let Some(watched) = [&dist, &root.join("lab")].into_iter().find(|directory| directory.is_dir()) {
        println!("cargo::rerun-if-changed={}", watched.display());
    }
    let entries = fs::read_dir(&dist).into_iter().flatten().flatten();
    let mut files: Vec<PathBuf> = entries.map(|entry| entry.path()).filter(|path| path.is_file()).collect();
    files.retain(|path| path.file_name().is_some_and(|name| name != "binaries.json"));
    let all = files.clone();
    files.retain(|path| !all.contains(&PathBuf::from(format!("{}.gz", path.display()))));
    files.sort();
    let line = |path: &PathBuf| {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        format!("    ({name:?}, include_bytes!({:?})),\n", path.display().to_string())
    };
    let lines: String = files.iter().map(line).collect();
    let text = format!("/// Name and content.\nconst FILES: &[(&str, &[u8])] = &[\n{lines}];\n");
    let place = PathBuf::from(env::var_os("OUT_DIR").unwrap_or_default()).join("lab.rs");
    // Without it the command cannot be compiled, and the compiler says so.
    let _ = fs::write(place, text);
}

/// Returns the text if it is one short word without spaces, because it is printed in lines and tables.
fn plain(text: &str) -> Option<String> {
    let text = text.trim();
    let fits = |c: char| c.is_ascii_alphanumeric() || "-+._:".contains(c);
    (!text.is_empty() && text.len() <= 64 && text.chars().all(fits)).then(|| text.to_owned())
}

/// Returns the complete commit, its date in UTC such as `2026-11-22`, and "1" if a file that programs are built from
/// differs from it.
fn of_git(root: &Path) -> Option<[String; 3]> {
    // The first two change when another commit is checked out or made. Missing files are left out, because cargo would
    // then run this script every time.
    let places = git(root, &["rev-parse", "--git-path", "HEAD", "--git-path", "logs/HEAD"])?;
    let files = git(root, &[&["ls-files", "--"], &BUILT_FROM[..]].concat())?;
    let watched = places.lines().chain(files.lines()).map(|path| root.join(path));
    watched
        .filter(|path| path.exists())
        .for_each(|path| println!("cargo::rerun-if-changed={}", path.display()));
    let format = ["--no-show-signature", "--date=format-local:%Y-%m-%d", "--format=%H %cd"];
    let commit = git(root, &[&["log", "-1"], &format[..]].concat())?;
    let (commit, date) = commit.trim().split_once(' ')?;
    let changes = git(root, &[&["diff", "--name-only", "HEAD", "--"], &BUILT_FROM[..]].concat())?;
    let changed = if changes.is_empty() { "" } else { "1" };
    Some([commit, date, changed].map(str::to_owned))
}

/// The output of git for this repository, independent of hooks and settings.
fn git(root: &Path, arguments: &[&str]) -> Option<String> {
    let mut command = Command::new("git");
    for name in ["GIT_DIR", "GIT_WORK_TREE", "GIT_INDEX_FILE", "GIT_COMMON_DIR", "GIT_PREFIX"] {
        command.env_remove(name);
    }
    if let Some(above) = root.parent() {
        command.env("GIT_CEILING_DIRECTORIES", above);
    }
    // Git must not refresh the index: reading must not change files.
    command.env("GIT_OPTIONAL_LOCKS", "0").env("TZ", "UTC").arg("-C").arg(root).args(arguments);
    let output = command.output().ok()?;
    output.status.success().then(|| String::from_utf8(output.stdout).ok()).flatten()
}

/// Date in UTC, such as `2026-11-22`, from seconds since 1970; `None` if the year does not have four digits.
fn day(seconds: i64) -> Option<String> {
    // Days since 1 March of the year 0: a leap day is then the last day of a year. 400 years have 146 097 days
    // (Gregorian calendar).
    let days = seconds.div_euclid(86_400).checked_add(719_468)?;
    let (cycle, day) = (days.div_euclid(146_097), days.rem_euclid(146_097));
    let year = (day - day / 1460 + day / 36_524 - day / 146_096) / 365;
    let rest = day - (365 * year + year / 4 - year / 100);
    let month = (5 * rest + 2) / 153;
    let day = rest - (153 * month + 2) / 5 + 1;
    let month = if month < 10 { month + 3 } else { month - 9 };
    let year = cycle * 400 + year + i64::from(month <= 2);
    (1000..=9999).contains(&year).then(|| format!("{year}-{month:02}-{day:02}"))
}
