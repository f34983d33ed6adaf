//! What is refused before it is begun, and what `lemons check` warns of.

use crate::common::*;
use lemons_core::plane::vec2;
use tempfile::TempDir;

/// 100 000 took 28 s and 1.4 GB, and no command read the FMU.
#[test]
fn crowds_too_large_for_a_model_description_are_refused_before_the_work() {
    let directory = TempDir::new().unwrap();
    let at = directory.path();
    lemons_verify::bench::fmu::write_trial(60_000, vec2(0.5, 0.5), &at.join("large")).unwrap();
    let output = lemons(at, &["pack", "large", "-o", "x.fmu"]);
    assert_code(&output, 1);
    let said = err(&output);
    let words = ["60000 agents are too many for an FMU", "MB, and at most 256 MB can be read"];
    assert!(words.iter().all(|word| said.contains(word)), "{said}");
    assert!(!at.join("x.fmu").exists());
}
