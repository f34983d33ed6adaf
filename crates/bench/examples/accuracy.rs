//! What mechanical step has which error, and what it costs, for five kinds of scene (some minutes):
//!
//! `cargo run --release -p lemons-bench --example accuracy [TEXT]`
//!
//! With a text, only scenes with it in their names.

use lemons_bench::accuracy::{STEPS, scenes};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let only = std::env::args().nth(1).unwrap_or_default();
    for scene in scenes()?.into_iter().filter(|scene| scene.name.contains(&only)) {
        let found = scene.measure(&STEPS)?;
        let last = scene.times().len() - 1;
        println!("{}: {} people, after {} s", scene.name, scene.people(), scene.times()[last]);
        println!("{:>9} {:>9} {:>9} {:>9} {:>11}", "step [s]", "median", "90 %", "largest", "s per s");
        for found in &found {
            let [median, most, largest] = [0.5, 0.9, 1.0].map(|share| found.error(last, share));
            println!("{:>9.0e} {median:>9.1e} {most:>9.1e} {largest:>9.1e} {:>11.4}", found.step, found.cost);
        }
        println!("largest error over time");
        for (stage, time) in scene.times().iter().enumerate() {
            if stage % 2 == 1 || last < 8 {
                let of = |found: &lemons_bench::accuracy::Found| format!("{:8.1e}", found.error(stage, 1.0));
                println!("{time:>9} {}", found.iter().map(of).collect::<Vec<_>>().join(" "));
            }
        }
        println!();
    }
    Ok(())
}
