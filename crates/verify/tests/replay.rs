//! What the fuzzers have kept, inputs and past crashers, once more.

#![cfg(all(target_os = "linux", any(target_arch = "x86_64", target_arch = "aarch64")))]

use lemons_verify::fuzz::TARGETS;
use std::path::{Path, PathBuf};

fn inputs(target: &str) -> Vec<PathBuf> {
    let directory = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz/corpus").join(target);
    let entries = std::fs::read_dir(&directory).unwrap_or_else(|error| panic!("{directory:?}: {error}"));
    let mut files: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).collect();
    files.sort();
    files
}

fn replay(targets: &[&str]) {
    for target in targets {
        let files = inputs(target);
        assert!(files.len() >= 5, "the inputs of {target} are gone: {files:?}");
        for file in files {
            // Shown when it fails.
            println!("{}", file.display());
            lemons_verify::fuzz::run(target, &std::fs::read(&file).unwrap());
        }
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

/// Bytes of a seed: what the fuzzers begin with.
fn random(seed: u64) -> Vec<u8> {
    let mut state = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1;
    let mut next = || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        state.to_le_bytes()[3]
    };
    (0..1500).map(|_| next()).collect()
}

#[test]
fn random_calls() {
    for seed in 0..100 {
        println!("seed {seed}");
        for target in ["fmi_calls", "decision_calls", "fmi3_calls", "decision3_calls"] {
            lemons_verify::fuzz::run(target, &random(seed));
        }
    }
}

#[test]
fn calls() {
    replay(&["fmi_calls", "decision_calls", "fmi3_calls", "decision3_calls"]);
}

#[test]
fn states() {
    replay(&["states", "states3"]);
}

#[test]
fn files() {
    let others = TARGETS.iter().map(|(name, _)| *name).filter(|name| !name.contains("calls"));
    let others: Vec<&str> = others.filter(|name| !name.starts_with("states")).collect();
    assert_eq!(others.len(), 9);
    replay(&others);
}
