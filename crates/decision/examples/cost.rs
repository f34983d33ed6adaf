//! Cost of walking models beside the mechanics: `cargo run --release -p lemons-decision --example cost`.
//!
//! People stand at 4 per m² in a hall with a door, and walk towards it slowly, or half of them away from it. Printed: nanoseconds per person and
//! communication step, the least of several rounds.

use lemons_core::plane::{Motion, vec2};
use lemons_core::trial::{Agent, AgentDynamics, Trial, Wall};
use lemons_decision::{Decision, DecisionConfig, Plan, WalkingModelName};
use std::time::Instant;

fn main() {
    let columns = 50;
    for rows in [10, 40, 160] {
        let disks = [[0.0, 0.11, 0.12], [0.0, 0.0, 0.12], [0.0, -0.11, 0.12]];
        let person = |k: i32| {
            let position = vec2(
                0.5 + 0.5 * f64::from(k % columns) + 0.05 * f64::from(k % 7),
                0.5 + 0.5 * f64::from(k / columns) + 0.05 * f64::from(k % 5),
            );
            let agent = Agent::new(k.to_string(), 80.0, 1.5, [4.5, 4.0]).with_disks(&disks);
            (agent, AgentDynamics { position, velocity: vec2(0.1, 0.05), ..AgentDynamics::default() })
        };
        let high = 0.5 * f64::from(rows) + 1.0;
        let middle = 0.5 * high;
        let hall =
            [(26.0, middle + 1.0), (26.0, high), (0.0, high), (0.0, 0.0), (26.0, 0.0), (26.0, middle - 1.0)];
        let hall = Wall::new("hall", "", hall.map(|(x, y)| vec2(x, y)).to_vec());
        let trial = Trial::of((0..rows * columns).map(person), vec![hall], 0.02);
        let models = WalkingModelName::ALL.iter().map(|model| model.name());
        let walking = |model: &str, share: f64| {
            let exit = |name: &str, x: f64, share: f64| {
                let (low, high) = (middle - 1.0, middle + 1.0);
                format!("{{ name = \"{name}\", line = [[{x}, {low}], [{x}, {high}]], share = {share} }}")
            };
            let exits = [exit("door", 26.5, share), exit("behind", 0.1, 1.0 - share)].join(", ");
            format!("model = \"{model}\"\nexits = [{exits}]")
        };
        let mut configs: Vec<(String, String)> =
            models.map(|model| (model.to_owned(), walking(model, 1.0))).collect();
        configs.push(("rotational, half of them the other way".to_owned(), walking("rotational", 0.5)));
        for balance in ["pendulum", "two-level"] {
            let config = format!("balance = \"{balance}\"");
            configs.push((format!("straight, {balance}: all stand"), config.clone()));
            configs.push((
                format!("rotational, {balance}"),
                format!("{config}\n{}", walking("rotational", 1.0)),
            ));
        }
        for (label, config) in configs {
            let config = DecisionConfig::from_toml(&config).unwrap();
            let plan = Plan::of(&trial, &config).unwrap();
            let mut decision = Decision::new(plan);
            let mut step = |shift: f64| {
                let began = Instant::now();
                decision.see(trial.dynamics.iter().map(|own| {
                    let mut motion: Motion = own.motion();
                    motion.pose.position.x += shift;
                    motion
                }));
                decision.acts().unwrap();
                decision.pass(0.02).unwrap();
                began.elapsed().as_secs_f64()
            };
            step(0.0);
            let least = (1..30).map(|k| step(0.002 * f64::from(k))).fold(f64::INFINITY, f64::min);
            println!(
                "{} people, {label}: {:.0} ns",
                trial.agents.len(),
                least / trial.agents.len() as f64 * 1e9
            );
        }
    }
}
