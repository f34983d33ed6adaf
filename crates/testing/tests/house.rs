//! The house's own rules: no modules or packages use each other in a circle, and the lowest
//! use nothing above them.
//!
//! The order of modules is nowhere written down: it is computed from what they import (`house/modules.rs`). Those of
//! Python: tests/fmpy/test_house.py.

#[path = "house/circles.rs"]
mod circles;
#[path = "house/modules.rs"]
mod modules;
#[path = "house/shown.rs"]
mod shown;

use circles::{Edge, circles};
use modules::{Crate, Use};
use std::fmt::Write;
use std::path::{Path, PathBuf};

fn root() -> &'static Path {
    lemons_testing::repository()
}

/// The package of `src`.
const ROOT: &str = "crowd-mechanics";

/// The manifest of a package, its directory and its name.
struct Package {
    directory: PathBuf,
    name: String,
    manifest: String,
}

fn packages() -> Vec<Package> {
    let crates = std::fs::read_dir(root().join("crates")).unwrap().map(|entry| entry.unwrap().path());
    let mut packages: Vec<Package> = crates
        .chain([root().to_owned()])
        .map(|directory| {
            let manifest = std::fs::read_to_string(directory.join("Cargo.toml")).unwrap();
            let name =
                manifest.parse::<toml::Table>().unwrap()["package"]["name"].as_str().unwrap().to_owned();
            Package { directory, name, manifest }
        })
        .collect();
    packages.sort_by(|one, other| one.name.cmp(&other.name));
    packages
}

impl Package {
    /// Where a file of it is, from the root of the repository.
    fn shown(&self, file: &str) -> String {
        self.directory.join(file).strip_prefix(root()).unwrap().display().to_string()
    }

    /// Its library and its commands.
    fn crates(&self) -> Vec<Crate> {
        let roots = ["src/lib.rs", "src/main.rs"].map(|file| self.shown(file));
        let roots = roots.iter().filter(|file| root().join(file).exists());
        let read = |file: &Path| std::fs::read_to_string(root().join(file)).ok();
        roots.map(|file| Crate::read(Path::new(file), &read)).collect()
    }

    /// The packages that it depends on, and where it says so; for tests and benches only, too, if they are wanted.
    fn dependencies(&self, of_tests: bool) -> Vec<(String, String)> {
        let manifest: toml::Table = self.manifest.parse().unwrap();
        let targets = manifest.get("target").and_then(|targets| targets.as_table());
        let of_targets =
            targets.into_iter().flat_map(|targets| targets.values()).filter_map(|one| one.as_table());
        let mut kinds = vec!["dependencies", "build-dependencies"];
        kinds.extend(of_tests.then_some("dev-dependencies"));
        let tables = of_targets.chain([&manifest]);
        let listed = tables.flat_map(|table| kinds.iter().filter_map(|kind| table.get(*kind)?.as_table()));
        let named = listed.flat_map(|list| list.keys()).map(|name| {
            let names =
                |line: &str| line.strip_prefix(name).is_some_and(|rest| rest.starts_with(['.', ' ', '=']));
            let line = self.manifest.lines().position(names).unwrap();
            (name.clone(), format!("{}:{}: {name}", self.shown("Cargo.toml"), line + 1))
        });
        named.collect()
    }
}

#[test]
fn no_module_is_in_a_circle() {
    let mut found = String::new();
    for package in packages() {
        let crates = package.crates();
        assert!(!crates.is_empty(), "{}: there are sources", package.name);
        for (level, circle) in crates.iter().flat_map(Crate::circles) {
            let level = std::iter::once(&package.name).chain(&level).map(String::as_str).collect::<Vec<_>>();
            writeln!(found, "{}: {circle}", level.join("::")).unwrap();
        }
    }
    assert!(found.is_empty(), "modules use each other in a circle:\n{found}");
}

/// What the tests and benches of a package may use though it uses the package: they are crates of their own, which cargo
/// builds after both.
const ONLY_TESTS: [(&str, &str); 3] =
    [(ROOT, "lemons-bench"), (ROOT, "lemons-verify"), ("lemons-fmi", "lemons-testing")];

#[test]
fn no_package_is_in_a_circle_but_by_its_tests() {
    let packages = packages();
    let mut edges = Vec::new();
    for package in &packages {
        for (to, place) in package.dependencies(true) {
            edges.push(Edge { from: package.name.clone(), to, place });
        }
    }
    for allowed in ONLY_TESTS {
        let place = edges.iter().position(|edge| (&edge.from[..], &edge.to[..]) == allowed);
        edges.remove(place.unwrap_or_else(|| panic!("{allowed:?} need not be allowed")));
    }
    let found: Vec<String> = circles(edges).iter().map(ToString::to_string).collect();
    assert!(found.is_empty(), "packages use each other in a circle:\n{}", found.join("\n"));
}

/// Packages that must stay easy to use and to build without the others, and those of the workspace that they may use.
const LOW: [(&str, &[&str]); 12] = [
    ("lemons-plane", &[]),
    ("lemons-files", &[]),
    ("lemons-xml", &[]),
    // Serves any model.
    ("lemons-fmi", &["lemons-files", "lemons-xml"]),
    // What people want is said of the people of a Trial.
    ("lemons-decision", &["lemons-files", "lemons-fmi", "lemons-plane", "lemons-trial", "lemons-xml"]),
    // Documents, pictures and records need no engine.
    ("lemons-trial", &["lemons-files", "lemons-plane", "lemons-xml"]),
    ("lemons-ssp", &["lemons-files", "lemons-xml"]),
    ("lemons-picture", &["lemons-plane", "lemons-trial"]),
    ("lemons-record", &["lemons-files", "lemons-plane", "lemons-trial"]),
    ("lemons-measure", &["lemons-plane", "lemons-record"]),
    // What an importer loads.
    (ROOT, &["lemons-files", "lemons-fmi", "lemons-plane", "lemons-trial", "lemons-xml"]),
];

/// Packages that only these may use.
const WRAPPED: [(&str, &[&str]); 2] = [
    // Libraries have error types of their own.
    ("anyhow", &["lemons-cli"]),
    // For its tests: a quarter of all packages come with it.
    ("fmi-rs", &["lemons-master"]),
];

#[test]
fn packages_use_only_what_is_below_them() {
    let packages = packages();
    let own: Vec<&str> = packages.iter().map(|package| &package.name[..]).collect();
    for (package, allowed) in LOW {
        let package = packages.iter().find(|known| known.name == package).unwrap();
        for (name, place) in package.dependencies(false) {
            let good = !own.contains(&&name[..]) || allowed.contains(&&name[..]);
            assert!(good, "{place}: {} must not know it", package.name);
        }
    }
    for (wrapped, by) in WRAPPED {
        for package in &packages {
            let used = package.dependencies(true).into_iter().find(|(name, _)| name == wrapped);
            match used {
                Some((_, place)) => assert!(by.contains(&&package.name[..]), "{place}: only {by:?} use it"),
                None => assert!(!by.contains(&&package.name[..]), "{} does not use {wrapped}", package.name),
            }
        }
    }
}

fn own_crate() -> Crate {
    packages().iter().find(|package| package.name == ROOT).unwrap().crates().remove(0)
}

/// Rooms of `src` and those that they may use.
const ROOMS: [(&str, &[&str]); 4] = [
    ("engine", &[]),
    ("setup", &["engine"]),
    // C functions: one line each.
    ("fmi2", &["model"]),
    ("c_api", &["setup"]),
];

#[test]
fn rooms_use_only_what_is_below_them() {
    let all = own_crate();
    let uses = all.uses();
    for (room, allowed) in ROOMS {
        assert!(all.modules().any(|path| path == [room]), "there is a room {room}");
        for Use { from, to, place } in &uses {
            let inside = from.first().is_some_and(|first| first == room);
            let good = to.first().is_none_or(|other| other == room || allowed.contains(&&other[..]));
            assert!(!inside || good, "{place}: {room} must not know {}", to.join("::"));
        }
    }
}

/// Mechanics alone: no file, no FMI.
#[test]
fn the_engine_knows_nothing_of_files() {
    let all = own_crate();
    let foreign = all.foreign(&["engine".to_owned()]);
    assert!(foreign.iter().any(|(path, _)| path[0] == "lemons_plane"));
    for (path, place) in foreign {
        let own = path[0].starts_with("lemons_") && path[0] != "lemons_plane";
        let outside = ["std::fs", "std::io", "std::env", "std::net", "std::path", "std::process"];
        let outside = outside.contains(&&path[..2].join("::")[..]);
        assert!(!own && !outside, "{place}: the engine is mechanics alone");
    }
}

fn sources(path: &Path) -> Vec<PathBuf> {
    if path.is_file() {
        return vec![path.to_owned()];
    }
    let entries = std::fs::read_dir(path).unwrap();
    entries.flat_map(|entry| sources(&entry.unwrap().path())).collect()
}

/// Where the C boundary lies, and who calls across it as a host does.
const UNSAFE: [&str; 20] = [
    "src/fmi2.rs",
    "src/fmi3.rs",
    "src/c_api.rs",
    "crates/fmi/src/boundary.rs",
    "crates/fmi/src/v2/component.rs",
    "crates/fmi/src/v3/component.rs",
    "crates/fmi/src/v2/export.rs",
    "crates/fmi/src/v3/export.rs",
    "crates/fmi/tests/faults.rs",
    "crates/decision-fmu/src/lib.rs",
    "crates/decision/tests/arrays.rs",
    "crates/master/src/calls.rs",
    "crates/master/src/calls/v2.rs",
    "crates/master/src/calls/v3.rs",
    "crates/testing/src/fmi2.rs",
    "crates/testing/src/fmi3.rs",
    "crates/verify/src/interfaces.rs",
    // The system has no other form of the question.
    "crates/cli/src/interrupt/ignored.rs",
    "crates/fuzz-targets/src/importer.rs",
    "crates/fuzz-targets/src/importer3.rs",
];

#[test]
fn only_the_c_boundary_is_unsafe() {
    for file in sources(&root().join("src")).into_iter().chain(sources(&root().join("crates"))) {
        let Ok(text) = std::fs::read_to_string(&file) else { continue };
        let boundary = UNSAFE.iter().any(|name| file.ends_with(name));
        assert!(boundary || !text.contains(concat!("unsafe", " {")), "{}", file.display());
    }
}

/// A module with modules of its own is `name.rs` beside `name/`: an editor's tab tells which it is.
#[test]
fn a_module_is_a_file_of_its_name() {
    let places = ["src", "crates"].map(|place| sources(&root().join(place)));
    let files: Vec<PathBuf> = places.into_iter().flatten().collect();
    assert!(files.iter().any(|file| file.ends_with("src/engine.rs")));
    // Beside `tests/name.rs`, cargo would take `tests/common.rs` for a test.
    let tests = |file: &Path| file.components().any(|part| part.as_os_str() == "tests");
    let found: Vec<&PathBuf> = files.iter().filter(|file| file.ends_with("mod.rs") && !tests(file)).collect();
    assert!(found.is_empty(), "{found:?}");
}
