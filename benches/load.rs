//! Time until a crowd of 10 000 can be stepped.
//!
//! `cargo bench --bench load`; `lemons bench` measures the same through a loaded FMU.

use criterion::{BatchSize, BenchmarkId, Criterion, criterion_group, criterion_main};
use crowd_mechanics::model::CrowdModel;
use crowd_mechanics::pack::Format;
use crowd_mechanics::quantities::guid;
use crowd_mechanics::setup;
use lemons_fmi::location::Location;
use lemons_fmi::{Model, Slave, Version};
use lemons_verify::bench::fmu::{DENSE, Packed};

const AGENTS: usize = 10_000;

fn load(criterion: &mut Criterion) {
    let packed = Packed::new(AGENTS, DENSE).expect("a Trial");
    let mut group = criterion.benchmark_group("load");
    group.sample_size(10);
    group.bench_function(BenchmarkId::new("read and check", AGENTS), |bencher| {
        bencher.iter(|| setup::read(&packed.trial()).expect("a good Trial"));
    });
    group.bench_function(BenchmarkId::new("read, check and pack", AGENTS), |bencher| {
        bencher.iter(|| packed.pack(Format::default()).expect("a good Trial"));
    });
    let guid = guid(&setup::read(&packed.trial()).expect("a good Trial").0).to_string();
    let resources = packed.resources();
    // What fmi2Instantiate does.
    let instantiate = || {
        let crowd =
            CrowdModel::load(Location::Path(resources.to_str().expect("text"))).expect("a good Trial");
        Slave::new(crowd, Version::V2, &guid).expect("its GUID")
    };
    group.bench_function(BenchmarkId::new("instantiate", AGENTS), |bencher| bencher.iter(instantiate));
    group.bench_function(BenchmarkId::new("initialize", AGENTS), |bencher| {
        bencher.iter_batched_ref(
            instantiate,
            |slave| {
                slave.setup_experiment(0.0, None, None).expect("once");
                slave.enter_initialization().expect("once");
                slave.exit_initialization().expect("a good Trial");
            },
            BatchSize::PerIteration,
        );
    });
    group.finish();
}

criterion_group!(benches, load);
criterion_main!(benches);
