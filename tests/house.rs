//! The house's own rules: generated files are up to date, rooms import only from those before them.

use crowd_mechanics::model_description::model_description;
use crowd_mechanics::pack::Naming;
use crowd_mechanics::trial::Trial;
use std::path::{Path, PathBuf};

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

#[test]
fn committed_model_description_is_the_generated_one() {
    let (trial, warnings) = Trial::read(&root().join("resources/Trial_push")).unwrap();
    assert!(warnings.is_empty(), "{warnings}");
    let committed = std::fs::read_to_string(root().join("fmu/modelDescription.xml")).unwrap();
    assert!(
        committed == model_description(&trial, Naming::Structured),
        "regenerate it: cargo run --release -- describe resources/Trial_push > fmu/modelDescription.xml"
    );
}

/// The rooms of a directory of sources in their order, each with what it may import of those before it. `lib` stands
/// for what lib.rs or main.rs itself defines.
type Rooms = [(&'static str, &'static [&'static str])];

const CRATES: [(&str, &Rooms); 10] = [
    (
        "src",
        &[
            ("engine", &[]),
            ("files", &[]),
            ("trial", &["engine", "files"]),
            ("variables", &["trial"]),
            ("resources", &["trial"]),
            ("model_description", &["trial", "variables"]),
            ("pack", &["trial", "variables", "model_description", "resources", "files"]),
            ("crowd", &["engine", "files", "trial", "variables", "resources"]),
            ("fmi2", &["crowd"]),
            ("c_api", &["files", "trial"]),
        ],
    ),
    (
        "crates/fmi2/src",
        &[
            ("variables", &[]),
            ("lifecycle", &[]),
            ("model", &["variables", "lifecycle"]),
            ("slave", &["variables", "lifecycle", "model"]),
            ("description", &["variables"]),
            ("location", &[]),
            ("archive", &[]),
            ("component", &["lifecycle", "model", "slave", "description"]),
            ("export", &["lib", "component"]),
        ],
    ),
    (
        "crates/decision/src",
        &[
            ("rule", &[]),
            ("plan", &["rule"]),
            ("decision", &["rule", "plan"]),
            ("pack", &["plan", "decision"]),
        ],
    ),
    (
        "crates/crowd/src",
        &[
            ("person", &[]),
            ("disk", &[]),
            ("normal", &[]),
            ("random", &["normal"]),
            ("union", &["disk", "random"]),
            ("shape", &["person", "disk", "union"]),
            ("body3d", &["person"]),
            ("copula", &["normal", "random"]),
            ("anthropometry", &["person", "copula"]),
            ("survey", &["person"]),
            ("bicycle", &["disk", "normal", "random"]),
            (
                "population",
                &["person", "normal", "random", "shape", "copula", "anthropometry", "survey", "bicycle"],
            ),
            ("custom", &["normal", "copula", "bicycle", "population"]),
            ("placing", &["disk", "shape"]),
            ("table", &["person", "bicycle", "population"]),
            ("light_xml", &["disk", "random", "shape", "bicycle", "population"]),
            ("trial", &["person", "shape"]),
        ],
    ),
    (
        "crates/ssp/src",
        &[
            ("allowance", &[]),
            ("unit", &[]),
            ("xml", &[]),
            ("document", &["unit"]),
            ("read", &["unit", "xml", "document"]),
            ("write", &["unit", "document"]),
            ("archive", &["allowance", "document", "read"]),
            ("interface", &["unit", "xml", "document", "read"]),
            ("connect", &["unit", "document", "interface"]),
        ],
    ),
    (
        "crates/master/src",
        &[
            ("clock", &[]),
            ("unzip", &[]),
            ("kind", &["unzip"]),
            ("library", &[]),
            ("fmu", &["unzip", "kind", "library"]),
            ("state", &["fmu"]),
            ("drive", &["fmu"]),
            ("system", &["fmu", "state"]),
            ("extremes", &[]),
            ("saved", &["state", "system", "extremes"]),
            ("assemble", &["kind", "fmu", "system"]),
        ],
    ),
    (
        "crates/export/src",
        &[
            ("area", &[]),
            ("error", &[]),
            ("run", &["error"]),
            ("record", &["error", "run"]),
            ("jupedsim", &["area", "error", "run", "record"]),
            ("rows", &["error", "run"]),
            ("parquet", &["run", "record", "rows"]),
            ("table", &["error", "run", "record", "rows", "parquet"]),
            ("text", &["error", "record"]),
            ("series", &["error", "run", "record", "text"]),
        ],
    ),
    (
        "crates/picture/src",
        &[
            ("text", &[]),
            ("colour", &[]),
            ("style", &["colour"]),
            ("plane", &[]),
            ("body", &["text", "plane"]),
            ("bicycle", &["text", "colour", "plane", "body"]),
            ("density", &["plane"]),
            ("scene", &["plane", "body", "bicycle", "density"]),
            ("lettering", &["text"]),
            ("page", &["plane", "scene"]),
            ("ids", &["body", "scene", "lettering"]),
            ("colouring", &["text", "colour", "style", "scene"]),
            ("furniture", &["text", "colour", "lettering", "page", "colouring"]),
            ("range", &["text"]),
            ("curve", &[]),
            ("raster", &[]),
            ("pdf", &["raster"]),
            ("animation", &["colour", "raster"]),
            ("isobands", &["text", "body", "density", "scene", "page", "colouring"]),
            ("look", &["text", "colour", "style", "plane", "bicycle", "scene", "page", "furniture"]),
            ("overlay", &["text", "colour", "plane", "body", "scene", "page", "look"]),
            (
                "world",
                &[
                    "text",
                    "colour",
                    "style",
                    "plane",
                    "body",
                    "bicycle",
                    "scene",
                    "lettering",
                    "page",
                    "ids",
                    "colouring",
                    "isobands",
                    "look",
                    "overlay",
                ],
            ),
            (
                "draw",
                &[
                    "text",
                    "colour",
                    "style",
                    "scene",
                    "lettering",
                    "page",
                    "colouring",
                    "furniture",
                    "look",
                    "world",
                ],
            ),
            (
                "chart",
                &[
                    "text",
                    "colour",
                    "lettering",
                    "page",
                    "colouring",
                    "furniture",
                    "range",
                    "curve",
                    "look",
                    "draw",
                ],
            ),
            (
                "sheet",
                &[
                    "style",
                    "plane",
                    "scene",
                    "lettering",
                    "page",
                    "colouring",
                    "furniture",
                    "look",
                    "world",
                    "draw",
                ],
            ),
        ],
    ),
    (
        "crates/sweep/src",
        &[
            ("measure", &[]),
            ("points", &[]),
            ("directory", &["points"]),
            ("spec", &["measure", "points"]),
            ("simulate", &["measure", "points", "spec"]),
            ("sweep", &["points", "directory", "simulate", "spec"]),
        ],
    ),
    (
        "crates/cli/src",
        &[
            ("tell", &[]),
            ("error", &[]),
            ("binary", &[]),
            ("interrupt", &[]),
            ("files", &[]),
            ("output", &["files"]),
            ("given", &["error"]),
            ("pack", &["binary", "files", "given"]),
            ("decide", &["binary", "files", "given", "pack"]),
            ("connect", &["files", "pack"]),
            ("results", &["files"]),
            ("recording", &["results"]),
            ("crowd", &["results", "recording"]),
            ("outputs", &["results", "recording"]),
            ("watch", &["connect", "results", "recording", "crowd", "outputs"]),
            (
                "run",
                &["error", "files", "given", "interrupt", "pack", "results", "recording", "crowd", "watch"],
            ),
            ("export", &["files", "given"]),
            ("people", &["tell", "error", "binary", "files", "given", "interrupt", "output", "pack"]),
            ("pictures", &["error", "files", "interrupt", "output", "crowd", "run", "export"]),
            ("sweep", &["error", "files", "given", "interrupt", "pack"]),
            ("bench", &["tell"]),
            ("check", &["tell", "error", "files", "given", "decide"]),
            ("describe", &["tell", "given"]),
            ("info", &["tell"]),
            ("verify", &["tell"]),
        ],
    ),
];

fn sources(path: &Path) -> Vec<PathBuf> {
    if path.is_file() {
        return vec![path.to_owned()];
    }
    let entries = std::fs::read_dir(path).unwrap();
    entries.flat_map(|entry| sources(&entry.unwrap().path())).collect()
}

/// The rooms that a line of code names after `crate::`.
fn imports(line: &str) -> impl Iterator<Item = &str> {
    let code = line.split("//").next().unwrap();
    code.split("crate::").skip(1).map(|path| {
        let room = path.split(|c: char| c != '_' && !c.is_alphanumeric()).next().unwrap();
        if room.starts_with(char::is_lowercase) { room } else { "lib" }
    })
}

#[test]
fn rooms_import_only_from_those_before_them() {
    for (directory, rooms) in CRATES {
        for (place, (room, allowed)) in rooms.iter().enumerate() {
            let before =
                |other: &str| other == "lib" || rooms[..place].iter().any(|(name, _)| *name == other);
            assert!(
                allowed.iter().all(|other| before(other)),
                "{directory}: {room} may import what is not before it"
            );
        }
        let mut found = 0;
        for file in sources(&root().join(directory)) {
            let inside = file.strip_prefix(root().join(directory)).unwrap();
            let first = inside.iter().next().unwrap().to_str().unwrap();
            let room = first.trim_end_matches(".rs");
            if ["lib", "main"].contains(&room) || file.extension().is_none_or(|extension| extension != "rs") {
                continue;
            }
            let Some((_, allowed)) = rooms.iter().find(|(name, _)| *name == room) else {
                panic!("{directory}: no room {room} in the table");
            };
            for (number, line) in std::fs::read_to_string(&file).unwrap().lines().enumerate() {
                for other in imports(line) {
                    found += 1;
                    let place = format!("{directory}/{}:{}", inside.display(), number + 1);
                    let good = other == room || allowed.contains(&other);
                    assert!(good, "{place}: {room} must not know {other}");
                }
            }
        }
        assert!(found >= rooms.len() / 2, "the test finds imports in {directory}: {found}");
    }
}

/// Where the C boundary lies, and who calls across it as a host does.
const UNSAFE: [&str; 8] = [
    "src/fmi2.rs",
    "src/c_api.rs",
    "crates/fmi2/src/component.rs",
    "crates/fmi2/src/export.rs",
    "crates/fmi2/tests/faults.rs",
    "crates/decision-fmu/src/lib.rs",
    "crates/verify/src/interfaces.rs",
    "crates/fuzz-targets/src/importer.rs",
];

#[test]
fn only_the_c_boundary_is_unsafe() {
    for file in sources(&root().join("src")).into_iter().chain(sources(&root().join("crates"))) {
        let Ok(text) = std::fs::read_to_string(&file) else { continue };
        let boundary = UNSAFE.iter().any(|name| file.ends_with(name));
        assert!(boundary || !text.contains("unsafe {"), "{}", file.display());
    }
}
