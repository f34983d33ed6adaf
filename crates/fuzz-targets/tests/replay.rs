//! What the fuzzers have kept, inputs and past crashers, once more.

#![cfg(all(target_os = "linux", any(target_arch = "x86_64", target_arch = "aarch64")))]

use lemons_fuzz_targets::TARGETS;
use std::path::{Path, PathBuf};

fn inputs(target: &str) -> Vec<PathBuf> {
    let directory = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz/corpus").join(target);
    let entries = std::fs::read_dir(&directory).unwrap_or_else(|error| panic!("{directory:?}: {error}"));
    let mut files: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).collect();
    files.sort();
    files
}

fn replay(target: &str) {
    let (_, run) = TARGETS.iter().find(|(name, _)| *name == target).expect("a target");
    let files = inputs(target);
    assert!(files.len() >= 5, "the inputs of {target} are gone: {files:?}");
    for file in files {
        // Shown when it fails.
        println!("{}", file.display());
        run(&std::fs::read(&file).unwrap());
    }
}

/// libFuzzer ends at a line of another form.
#[test]
fn dictionaries_are_of_the_form_that_libfuzzer_reads() {
    for (target, _) in TARGETS {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz/dictionaries").join(target);
        let Ok(bytes) = std::fs::read(&path) else { continue };
        let text = String::from_utf8(bytes).unwrap();
        for line in text.lines().filter(|line| !line.starts_with('#')) {
            let word = line.strip_prefix('"').and_then(|line| line.strip_suffix('"'));
            let mut rest = word.filter(|word| !word.is_empty()).unwrap_or_else(|| panic!("{path:?}: {line}"));
            while let Some((before, after)) = rest.split_once('\\') {
                assert!(!before.contains('"'), "{path:?}: {line}");
                let hexadecimal = |text: &str| u8::from_str_radix(text, 16).is_ok();
                let escaped = match after.as_bytes() {
                    [b'\\' | b'"', ..] => 1,
                    [b'x', _, _, ..] if hexadecimal(&after[1..3]) => 3,
                    _ => panic!("{path:?}: {line}"),
                };
                rest = &after[escaped..];
            }
            assert!(!rest.contains('"'), "{path:?}: {line}");
            assert!(line.bytes().all(|byte| (b' '..=b'~').contains(&byte)), "{path:?}: {line}");
        }
    }
}

#[test]
fn fmi_calls() {
    replay("fmi_calls");
}

#[test]
fn decision_calls() {
    replay("decision_calls");
}

#[test]
fn states() {
    replay("states");
}

#[test]
fn fmi3_calls() {
    replay("fmi3_calls");
}

#[test]
fn decision3_calls() {
    replay("decision3_calls");
}

#[test]
fn states3() {
    replay("states3");
}

#[test]
fn trial_xml() {
    replay("trial_xml");
}

#[test]
fn fmu_archive() {
    replay("fmu_archive");
}

#[test]
fn ssp_archive() {
    replay("ssp_archive");
}

#[test]
fn decision_toml() {
    replay("decision_toml");
}

#[test]
fn drive_csv() {
    replay("drive_csv");
}

#[test]
fn table_csv() {
    replay("table_csv");
}

#[test]
fn sweep_toml() {
    replay("sweep_toml");
}

#[test]
fn run_file() {
    replay("run_file");
}

#[test]
fn light_xml() {
    replay("light_xml");
}
