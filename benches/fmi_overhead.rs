//! Cost of getting and setting values across the C boundary: the inputs and outputs of 1000 agents in one call each.
//!
//! `cargo bench --bench fmi_overhead`, in processor time. The exported functions are called as a C program would.

#![allow(unsafe_code)] // calls the C functions

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use crowd_mechanics::model::CrowdModel;
use crowd_mechanics::quantities::{guid, scalars};
use crowd_mechanics::setup;
use lemons_core::trial::Trial;
use lemons_fmi::Status::Ok as OK;
use lemons_verify::bench::fmu::{INPUTS, INTEGERS, Packed, REALS, SPARSE, processor_time};
use lemons_verify::testing::fmi2::{Functions, NO_CALLBACKS};
use std::ffi::{CString, c_void};

const AGENTS: usize = 1000;

/// An instance of the Trial after its first step.
fn instance(c: &Functions, trial: &Trial, packed: &Packed) -> *mut c_void {
    let guid = CString::new(guid(trial).braced().to_string()).expect("no zero");
    let resources = CString::new(packed.resources().to_str().expect("text")).expect("no zero");
    // SAFETY: texts and functions live through the calls, which come in FMI's order.
    unsafe {
        let instance =
            (c.fmi2Instantiate)(c"bench".as_ptr(), 1, guid.as_ptr(), resources.as_ptr(), &NO_CALLBACKS, 0, 0);
        assert!(!instance.is_null());
        assert_eq!((c.fmi2SetupExperiment)(instance, 0, 0.0, 0.0, 0, 0.0), OK);
        assert_eq!((c.fmi2EnterInitializationMode)(instance), OK);
        assert_eq!((c.fmi2ExitInitializationMode)(instance), OK);
        assert_eq!((c.fmi2DoStep)(instance, 0.0, 1e-4, 1), OK);
        instance
    }
}

fn overhead(criterion: &mut Criterion) {
    let packed = Packed::new(AGENTS, SPARSE).expect("a Trial");
    let (trial, _) = setup::read(&packed.trial()).expect("a good Trial");
    let places: std::collections::HashMap<String, u32> =
        scalars(&trial).into_iter().zip(0..).map(|(scalar, reference)| (scalar.name, reference)).collect();
    let references = |names: &[&str]| -> Vec<u32> {
        let all = (0..AGENTS).flat_map(|i| names.iter().map(move |name| format!("agent[{i}].{name}")));
        all.map(|name| places[&name]).collect()
    };
    let c = Functions::of_model::<CrowdModel>();
    let instance = instance(&c, &trial, &packed);
    let mut group = criterion.benchmark_group("fmi overhead");

    let inputs = references(&INPUTS);
    let values: Vec<f64> = (0..inputs.len()).map(|k| k as f64).collect();
    group.throughput(Throughput::Elements(inputs.len() as u64));
    group.bench_function(BenchmarkId::new("fmi2SetReal, 3 inputs", AGENTS), |bencher| {
        // SAFETY: as many elements as said; the same below.
        let set = || unsafe { (c.fmi2SetReal)(instance, inputs.as_ptr(), inputs.len(), values.as_ptr()) };
        assert_eq!(set(), OK);
        bencher.iter_custom(|calls| processor_time(calls, set));
    });

    // The ten outputs are Reals and Integers; the comparison has ten Reals, including the inputs.
    let ten: Vec<&str> = REALS.into_iter().chain(INPUTS).collect();
    for (name, reals) in [("fmi2GetReal, 7 outputs", &REALS[..]), ("fmi2GetReal, 10 Reals", &ten)] {
        let reals = references(reals);
        let mut values = vec![0.0; reals.len()];
        group.throughput(Throughput::Elements(reals.len() as u64));
        group.bench_function(BenchmarkId::new(name, AGENTS), |bencher| {
            let mut get =
                || unsafe { (c.fmi2GetReal)(instance, reals.as_ptr(), reals.len(), values.as_mut_ptr()) };
            assert_eq!(get(), OK);
            bencher.iter_custom(|calls| processor_time(calls, &mut get));
        });
    }

    let integers = references(&INTEGERS);
    let mut values = vec![0; integers.len()];
    group.throughput(Throughput::Elements(integers.len() as u64));
    group.bench_function(BenchmarkId::new("fmi2GetInteger, 3 outputs", AGENTS), |bencher| {
        let mut get = || unsafe {
            (c.fmi2GetInteger)(instance, integers.as_ptr(), integers.len(), values.as_mut_ptr())
        };
        assert_eq!(get(), OK);
        bencher.iter_custom(|calls| processor_time(calls, &mut get));
    });
    group.finish();
    // SAFETY: made above, not used again.
    unsafe { (c.fmi2FreeInstance)(instance) };
}

criterion_group!(benches, overhead);
criterion_main!(benches);
