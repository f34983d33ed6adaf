//! Cost of walking models beside the mechanics: `cargo run --release -p lemons-decision --example cost`.
//!
//! People stand at 4 per m² in a hall with a door, and walk towards it slowly, or half of them away from it. Printed: nanoseconds per person and
//! communication step, the least of several rounds.

use lemons_core::plane::vec2;
use lemons_decision::rule::Pose;
use lemons_decision::{Decision, DecisionConfig, Person, Plan};
use std::time::Instant;

fn main() {
    let columns = 50;
    for rows in [10, 40, 160] {
        let people: Vec<Person> = (0..rows * columns)
            .map(|k| Person {
                id: k.to_string(),
                mass: 80.0,
                stature: None,
                moment_of_inertia: 1.5,
                floor_damping: 4.5,
                angular_damping: 4.0,
                pose: Pose {
                    x: 0.5 + 0.5 * f64::from(k % columns) + 0.05 * f64::from(k % 7),
                    y: 0.5 + 0.5 * f64::from(k / columns) + 0.05 * f64::from(k % 5),
                    theta: 0.0,
                },
                disks: vec![[0.0, 0.11, 0.12], [0.0, 0.0, 0.12], [0.0, -0.11, 0.12]],
            })
            .collect();
        let high = 0.5 * f64::from(rows) + 1.0;
        let middle = 0.5 * high;
        let hall =
            [(26.0, middle + 1.0), (26.0, high), (0.0, high), (0.0, 0.0), (26.0, 0.0), (26.0, middle - 1.0)];
        let hall = hall.map(|(x, y)| vec2(x, y));
        let models = ["straight", "collision-free-speed", "social-force", "rotational"];
        let walking = |model: &str, share: f64| {
            let exit = |name: &str, x: f64, share: f64| {
                let (low, high) = (middle - 1.0, middle + 1.0);
                format!("{{ name = \"{name}\", line = [[{x}, {low}], [{x}, {high}]], share = {share} }}")
            };
            let exits = [exit("door", 26.5, share), exit("behind", 0.1, 1.0 - share)].join(", ");
            format!("model = \"{model}\"\nexits = [{exits}]")
        };
        let mut configs: Vec<(String, String)> =
            models.map(|model| (model.to_owned(), walking(model, 1.0))).into();
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
            let plan = Plan::among(std::iter::once(&hall[..]), &people, &config, 0.02).unwrap();
            let mut decision = Decision::new(plan);
            let mut step = |shift: f64| {
                let began = Instant::now();
                let moved = |person: &Person| Pose { x: person.pose.x + shift, ..person.pose };
                decision.see(people.iter().map(|person| (moved(person), vec2(0.1, 0.05))));
                decision.acts().unwrap();
                decision.pass(0.02).unwrap();
                began.elapsed().as_secs_f64()
            };
            step(0.0);
            let least = (1..30).map(|k| step(0.002 * f64::from(k))).fold(f64::INFINITY, f64::min);
            println!("{} people, {label}: {:.0} ns", people.len(), least / people.len() as f64 * 1e9);
        }
    }
}
