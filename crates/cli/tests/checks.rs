//! What is refused before it is begun, and what `lemons check` warns of.

mod common;

use common::*;
use crowd_mechanics::engine::vec2;
use std::fs;
use std::path::Path;
use tempfile::TempDir;

/// A copy of the default Trial.
fn copy_trial(to: &Path) {
    for part in [
        "Parameters.xml",
        "static/Agents.xml",
        "static/Geometry.xml",
        "static/Materials.xml",
        "dynamic/AgentDynamics.xml",
        "drive.csv",
    ] {
        let target = to.join(part);
        fs::create_dir_all(target.parent().unwrap()).unwrap();
        fs::copy(default_trial().join(part), target).unwrap();
    }
}

/// An FMU of `trials.txt/` could not be loaded, one of `box\n/` held no such Trial.
#[test]
fn trials_that_could_not_be_loaded_from_an_fmu_are_not_packed() {
    let directory = TempDir::new().unwrap();
    let at = directory.path();
    for name in ["trials.txt", "Trials.TXT", "box\n", "two\nlines", "a\\b", "bell\u{7}", " ", "C:"] {
        copy_trial(&at.join(name));
        let output = lemons(at, &["pack", &format!("./{name}"), "-o", "x.fmu"]);
        assert_code(&output, 1);
        let said = err(&output);
        assert!(said.contains(&format!("{name:?}, which cannot be a directory's name in an FMU")), "{said}");
        assert!(!at.join("x.fmu").exists());
    }
    for name in ["trials", "my trials.txt", "Größe 1", "box.d"] {
        copy_trial(&at.join(name));
        done(at, &["pack", name, "-o", "x.fmu"]);
        let info = out(&done(at, &["info", "x.fmu", "--only", "no such"]));
        assert!(info.contains(&format!("Trials    {name}\n")), "{info}");
    }
}

/// 100 000 took 28 s and 1.4 GB, and no command read the FMU.
#[test]
fn crowds_too_large_for_a_model_description_are_refused_before_the_work() {
    let directory = TempDir::new().unwrap();
    let at = directory.path();
    lemons_bench::fmu::write_trial(60_000, vec2(0.5, 0.5), &at.join("large")).unwrap();
    let output = lemons(at, &["pack", "large", "-o", "x.fmu"]);
    assert_code(&output, 1);
    let said = err(&output);
    let words = ["60000 agents are too many for an FMU", "MB, and at most 256 MB can be read"];
    assert!(words.iter().all(|word| said.contains(word)), "{said}");
    assert!(!at.join("x.fmu").exists());
}
