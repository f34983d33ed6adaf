//! Errors and costs of mechanical steps, for five kinds of scene: the table of docs/step.md, with the
//! errors over time (three minutes):
//!
//! `cargo run --release -p lemons-verify --features bench --example steps [TEXT]`
//!
//! With a text, only scenes with it in their names.

use lemons_verify::bench::accuracy::{Found, STEPS, scenes};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let only = std::env::args().nth(1).unwrap_or_default();
    let mut heads = vec!["step [s]".to_owned()];
    let mut rows: Vec<Vec<String>> = STEPS.iter().map(|step| vec![format!("{step:e}")]).collect();
    for scene in scenes()?.into_iter().filter(|scene| scene.name.contains(&only)) {
        let found = scene.measure()?;
        let last = scene.times.len() - 1;
        println!("{}: {} people, after {} s", scene.name, scene.people(), scene.times[last]);
        println!("{:>9} {:>9} {:>9} {:>9} {:>11}", "step [s]", "median", "90 %", "largest", "s per s");
        for found in &found {
            let [median, most, largest] = [0.5, 0.9, 1.0].map(|share| found.error(last, share));
            println!("{:>9.0e} {median:>9.1e} {most:>9.1e} {largest:>9.1e} {:>11.4}", found.step, found.cost);
        }
        println!("largest error [m] over time [s]");
        for (stage, time) in scene.times.iter().enumerate() {
            if stage % 2 == 1 || last < 8 {
                let of = |found: &Found| format!("{:8.1e}", found.error(stage, 1.0));
                println!("{time:>9} {}", found.iter().map(of).collect::<Vec<_>>().join(" "));
            }
        }
        println!();
        heads.push(format!("{}, {} s [mm]", scene.name, scene.times[last]));
        heads.push("cost [s]".to_owned());
        for (row, found) in rows.iter_mut().zip(&found) {
            row.push(significant(1e3 * found.error(last, 0.9)));
            row.push(significant(found.cost));
        }
    }
    println!("| {} |\n|{}", heads.join(" | "), "---|".repeat(heads.len()));
    for row in rows {
        println!("| {} |", row.join(" | "));
    }
    Ok(())
}

/// With two digits, and without an exponent where that is not longer.
fn significant(number: f64) -> String {
    let rounded: f64 = format!("{number:.1e}").parse().unwrap_or(number);
    if (1e-3..1e4).contains(&rounded) { rounded.to_string() } else { format!("{rounded:e}") }
}
