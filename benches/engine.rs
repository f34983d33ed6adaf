//! Cost of the engine per agent and mechanical step; `lemons bench` measures the same crowds.
//!
//! `cargo bench`; divide the reported time by the reported number of elements (throughput does it).

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use lemons_verify::bench::cases;
use std::hint::black_box;

fn agent_step(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("agent step");
    group.sample_size(10);
    for case in cases() {
        let mut world = (case.make)(case.agents).expect("finite");
        let steps = case.steps.min(1_000);
        let duration = world.mechanical_step * steps as f64;
        world.advance(duration).expect("finite");
        group.throughput(Throughput::Elements(steps * case.agents as u64));
        group.bench_function(BenchmarkId::new(case.name, case.agents), |bencher| {
            bencher.iter(|| black_box(&mut world).advance(duration).expect("finite"));
        });
    }
    group.finish();
}

criterion_group!(benches, agent_step);
criterion_main!(benches);
