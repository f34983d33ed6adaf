//! Cost of the engine per agent and mechanical step, in a crowd pressed together: flat in the number of agents.
//!
//! `cargo bench`; divide the reported time by the reported number of elements (throughput does it).

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use crowd_mechanics::engine::*;
use std::hint::black_box;

/// The paper's agent 0 and contact, on a lattice with 1 mm of overlap between neighbours, in a closed box.
fn pressed(side: usize) -> World {
    let law = PairLaw {
        normal_stiffness: 2.5e6,
        tangential_stiffness: 1.8e6,
        normal_damping: 700.0,
        tangential_damping: 700.0,
        friction: 0.4,
    };
    let mut laws = LawTable::new(1);
    laws.set(0, 0, law);
    let shape = [
        (0.09495, -0.015458, 0.153544),
        (0.13058, 0.008692, 0.067374),
        (0.1365, 0.013532, 4e-06),
        (0.13058, 0.008692, -0.067376),
        (0.09495, -0.015458, -0.153546),
    ];
    let body = BodySpec {
        mass: 89.0,
        inertia: 1.85,
        translation_rate: 4.5,
        rotation_rate: 4.5,
        disks: shape
            .iter()
            .map(|&(radius, x, y)| DiskSpec { radius, position: vec2(x, y), material: 0 })
            .collect(),
    };
    let (dx, dy) = (0.272, 0.496);
    let (width, height) = (dx * side as f64, dy * side as f64);
    let corners = [(0.0, 0.0), (width, 0.0), (width, height), (0.0, height), (0.0, 0.0)];
    let wall = WallSpec { material: 0, corners: corners.iter().map(|&(x, y)| vec2(x, y)).collect() };
    let poses = (0..side * side)
        .map(|k| Pose {
            position: vec2(dx * ((k % side) as f64 + 0.5), dy * ((k / side) as f64 + 0.5)),
            orientation: 0.0,
        })
        .collect();
    let scene = Scene::new(&vec![body; side * side], &[wall], &laws).expect("one law serves all");
    World::new(scene, State::new(poses, vec![Twist::default(); side * side]), 1e-5)
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
