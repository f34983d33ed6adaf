//! Cost of the engine per agent and mechanical step, in a crowd pressed together: flat in the number of agents.
//!
//! `cargo bench`; divide the reported time by the reported number of elements (throughput does it).

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use crowd_mechanics::engine::{Pose, Twist, World};
use lemons_verify::scenes::{BODIES, at, pedestrian, wall, world};
use std::hint::black_box;

/// The paper's agent 0 and contact, on a lattice with 1 mm of overlap between neighbours, in a closed box.
fn pressed(side: usize) -> World {
    let (body, law) = (pedestrian(89.0, 4.5), BODIES);
    let (dx, dy) = (0.272, 0.496);
    let (width, height) = (dx * side as f64, dy * side as f64);
    let around = wall(&[(0.0, 0.0), (width, 0.0), (width, height), (0.0, height), (0.0, 0.0)]);
    let motions: Vec<(Pose, Twist)> = (0..side * side)
        .map(|k| (at(dx * ((k % side) as f64 + 0.5), dy * ((k / side) as f64 + 0.5)), Twist::default()))
        .collect();
    world(&vec![body; side * side], &[around], law, &motions, 1e-5)
}

fn steps(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("pressed crowd, 100 mechanical steps");
    for side in [10, 32, 100] {
        let agents = (side * side) as u64;
        let mut world = pressed(side);
        world.advance(1e-3).expect("finite");
        group.throughput(Throughput::Elements(100 * agents));
        group.sample_size(10);
        group.bench_function(BenchmarkId::from_parameter(agents), |bencher| {
            bencher.iter(|| black_box(&mut world).advance(1e-3).expect("finite"));
        });
    }
    group.finish();
}

criterion_group!(benches, steps);
criterion_main!(benches);
