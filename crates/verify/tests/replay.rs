//! Replays what the fuzzers have kept: inputs and past crashers.

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

#[test]
fn inputs_of_all_targets() {
    for (target, run) in TARGETS {
        let files = inputs(target);
        assert!(files.len() >= 5, "the inputs of {target} are gone: {files:?}");
        for file in files {
            // Shown when it fails.
            println!("{}", file.display());
            run(&std::fs::read(&file).unwrap());
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
    for seed in 0..400 {
        println!("seed {seed}");
        lemons_verify::fuzz::run("calls", &[&[seed as u8], &random(seed)[..]].concat());
    }
}
