//! The house's own rules: generated files are up to date, rooms import only downwards.

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

/// What each room of src/ may import, besides itself.
const ROOMS: [(&str, &[&str]); 10] = [
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
];

fn sources(path: &Path) -> Vec<PathBuf> {
    if path.is_file() {
        return vec![path.to_owned()];
    }
    let entries = std::fs::read_dir(path).unwrap();
    entries.flat_map(|entry| sources(&entry.unwrap().path())).collect()
}

#[test]
fn rooms_import_only_downwards() {
    let mut imports = 0;
    for file in sources(&root().join("src")) {
        let inside = file.strip_prefix(root().join("src")).unwrap();
        let first = inside.iter().next().unwrap().to_str().unwrap();
        let room = first.trim_end_matches(".rs");
        if room == "lib" || file.extension().is_none_or(|extension| extension != "rs") {
            continue;
        }
        let (_, allowed) =
            ROOMS.iter().find(|(name, _)| *name == room).unwrap_or_else(|| panic!("no room {room}"));
        let text = std::fs::read_to_string(&file).unwrap();
        for (number, line) in text.lines().enumerate() {
            let Some(path) = line.trim_start().trim_start_matches("pub ").strip_prefix("use crate::") else {
                continue;
            };
            let other = path.split([':', ';', ' ', '{']).next().unwrap();
            imports += 1;
            let place = format!("{}:{}", inside.display(), number + 1);
            assert!(other == room || allowed.contains(&other), "{place}: {room} must not know {other}");
        }
    }
    assert!(imports > 10, "the test finds imports: {imports}");
}

#[test]
fn only_the_c_boundary_is_unsafe() {
    for file in sources(&root().join("src")).into_iter().chain(sources(&root().join("crates"))) {
        let Ok(text) = std::fs::read_to_string(&file) else { continue };
        let boundary = [
            "src/fmi2.rs",
            "src/c_api.rs",
            "fmi2/src/component.rs",
            "verify/src/interfaces.rs",
            "fmi2/src/export.rs",
            "decision-fmu/src/lib.rs",
            "fuzz-targets/src/importer.rs",
        ]
        .iter()
        .any(|name| file.ends_with(name));
        assert!(boundary || !text.contains("unsafe {"), "{}", file.display());
    }
}
