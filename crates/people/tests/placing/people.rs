//! People for trials of the packers: five disks by the closed-form fit to breadth and depth.

use lemons_core::plane::vec2;
use lemons_people::{Disk, Shape};
use chacha20::ChaCha8Rng;
use chacha20::rand_core::{Rng, SeedableRng};

/// \[cm\] The paper's template in the frame of an agent, about its area centroid: forward, left, radius.
const TEMPLATE: [(f64, f64, f64); 5] = [
    (-2.0143, 20.4246, 10.4346),
    (0.6363, 8.9625, 14.3492),
    (1.1674, 0.0, 15.0),
    (0.6363, -8.9625, 14.3492),
    (-2.0143, -20.4246, 10.4346),
];

/// A person of this breadth and depth \[m\].
pub fn person(breadth: f64, depth: f64) -> Shape {
    let radial = depth / 0.30;
    let lateral = (0.5 * breadth - 0.104346 * radial) / 0.204246;
    let disk = |&(forward, left, radius): &(f64, f64, f64)| Disk {
        radius: 0.01 * radius * radial,
        centre: vec2(0.01 * forward * radial, 0.01 * left * lateral),
    };
    Shape { disks: TEMPLATE.iter().map(disk).collect() }
}

/// Men and women in turn.
pub fn people(count: usize, seed: u64) -> Vec<Shape> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut unit = || ((random.next_u64() >> 11) as f64 + 0.5) * (1.0 / (1u64 << 53) as f64);
    let mut normal = |mean: f64, deviation: f64| {
        let (u, v) = (unit(), unit());
        mean + deviation * (-2.0 * libm::log(u)).sqrt() * libm::cos(std::f64::consts::TAU * v)
    };
    (0..count)
        .map(|k| {
            let man = k % 2 == 0;
            let breadth = if man { normal(0.51, 0.0325) } else { normal(0.455, 0.03) };
            let depth = if man { normal(0.254, 0.026) } else { normal(0.247, 0.026) };
            person(breadth, depth.min(0.95 * breadth))
        })
        .collect()
}
