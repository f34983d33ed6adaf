//! Errors of the mechanics against mechanical steps, over the cases of a file that tests/fmpy/reference.py wrote:
//!
//! `cargo run --release -p lemons-verify --example accuracy -- tests/reference/usual.json [cases]`
//!
//! With `cases`, each case has a line.

use lemons_verify::checks::reference;

/// \[s\]
const STEPS: [f64; 9] = [1e-7, 1e-6, 2e-6, 5e-6, 1e-5, 2e-5, 5e-5, 1e-4, 2e-4];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let text = std::fs::read_to_string(arguments.first().ok_or("which file of cases?")?)?;
    let runs = STEPS.map(|step| reference::of(&text, step));
    let mut found = Vec::new();
    for run in runs {
        found.push(run?);
    }
    let heads: Vec<String> = STEPS.iter().map(|step| format!("{step:8.0e}")).collect();
    println!("{:42} {}", "largest error of a pose [m, rad], step [s]", heads.join(" "));
    if arguments.len() > 1 {
        for (k, (name, ..)) in found[0].iter().enumerate() {
            let errors: Vec<String> = found.iter().map(|run| format!("{:8.1e}", run[k].1)).collect();
            println!("{name:42} {}", errors.join(" "));
        }
    }
    for (what, share) in [("median", 0.5), ("90 %", 0.9), ("largest", 1.0)] {
        let errors = found.iter().map(|run| {
            let mut errors: Vec<f64> = run.iter().map(|case| case.1).collect();
            errors.sort_by(f64::total_cmp);
            format!("{:8.1e}", errors[(share * (errors.len() - 1) as f64).round() as usize])
        });
        println!("{what:42} {}", errors.collect::<Vec<_>>().join(" "));
    }
    Ok(())
}
