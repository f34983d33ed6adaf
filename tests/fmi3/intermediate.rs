//! The importer's callback within a step.

use crate::fmu::*;
use std::cell::RefCell;
use std::ffi::c_void;

thread_local! {
    /// What the callback of this thread saw: times \[s\] and positions; and when it wants to return.
    static SEEN: RefCell<Seen> = const { RefCell::new(Seen { raw: 0, times: Vec::new(), x: Vec::new(), stop: None }) };
}

struct Seen {
    raw: usize,
    times: Vec<f64>,
    x: Vec<f64>,
    stop: Option<f64>,
}

unsafe extern "C" fn update(
    _environment: *mut c_void,
    time: f64,
    set_requested: bool,
    get_allowed: bool,
    finished: bool,
    can_return: bool,
    request: *mut bool,
    until: *mut f64,
) {
    assert!(!set_requested && get_allowed && finished);
    SEEN.with_borrow_mut(|seen| {
        let raw = std::ptr::with_exposed_provenance_mut(seen.raw);
        let c = &Fmu::get().c;
        let mut values = [f64::NAN; 2 * AGENTS];
        let status =
            unsafe { (c.fmi3GetFloat64)(raw, &reference("Position"), 1, values.as_mut_ptr(), 2 * AGENTS) };
        assert_eq!(status, OK);
        // Nothing can be set or saved now.
        let drive = [0.0; 2 * AGENTS];
        let set = unsafe { (c.fmi3SetFloat64)(raw, &reference("Fp"), 1, drive.as_ptr(), 2 * AGENTS) };
        let saved = unsafe { (c.fmi3GetFMUState)(raw, &mut std::ptr::null_mut()) };
        assert_eq!((set, saved), (ERROR, ERROR));
        seen.times.push(time);
        seen.x.push(values[0]);
        if let Some(stop) = seen.stop {
            assert!(can_return);
            unsafe { (*request, *until) = (true, stop) };
        }
    });
}

/// An instance whose callback reads it after every 5000 mechanical steps of 2 µs: every 10 ms.
fn watched(stop: Option<f64>) -> Instance<'static> {
    let instance = Instance::of(Fmu::get(), Some(update), stop.is_some()).unwrap();
    instance.must(instance.try_set_integer("IntermediateSteps", 5000));
    SEEN.set(Seen { raw: instance.raw.expose_provenance(), times: Vec::new(), x: Vec::new(), stop });
    instance.initialize();
    instance.push();
    instance
}

#[test]
fn values_within_a_step_are_those_of_short_steps() {
    let instance = watched(None);
    let (status, early, time) = instance.try_step(0.0, STEP);
    instance.must(status);
    assert!(!early && time == STEP);
    let short = Instance::new();
    short.initialize();
    short.push();
    let mut expected = Vec::new();
    for k in 0..5 {
        short.must(short.try_step(f64::from(k) * 0.01, 0.01).0);
        expected.push(short.get("Position", 2 * AGENTS)[0]);
    }
    instance.log.take();
    let at_end = instance.get("Position", 2 * AGENTS)[0];
    SEEN.with_borrow(|seen| {
        assert_eq!(seen.times.len(), 4);
        for (k, time) in (1..).zip(&seen.times) {
            assert!((time - f64::from(k) * 0.01).abs() < 1e-12, "{time}");
        }
        assert_eq!(seen.x, expected[..4]);
    });
    assert_eq!(at_end, expected[4]);
}

/// Mean and peak squeeze are those of the whole communication step, as without a callback.
#[test]
fn squeeze_is_that_of_the_whole_step() {
    let (instance, plain) = (watched(None), Instance::new());
    plain.initialize();
    plain.push();
    let mut squeezed = 0;
    for k in 0..12 {
        instance.must(instance.try_step(f64::from(k) * STEP, STEP).0);
        plain.must(plain.try_step(f64::from(k) * STEP, STEP).0);
        instance.log.take();
        for name in ["MeanNormalForce", "PeakNormalForce", "PeakOverlap"] {
            let (ours, theirs) = (instance.get(name, AGENTS), plain.get(name, AGENTS));
            squeezed += theirs.iter().filter(|value| **value > 0.0).count();
            for (a, b) in ours.iter().zip(&theirs) {
                assert!((a - b).abs() <= 1e-6 * (1.0 + b.abs()), "{name} in step {k}: {a} beside {b}");
            }
        }
    }
    assert!(squeezed >= 6, "{squeezed}");
}

#[test]
fn a_step_returns_early_where_the_importer_asks() {
    // At the first point that is not before 0.015 s.
    let instance = watched(Some(0.015));
    let (status, early, time) = instance.try_step(0.0, STEP);
    instance.must(status);
    assert!(early && (time - 0.02).abs() < 1e-12, "{time}");
    SEEN.with_borrow(|seen| assert_eq!(seen.times.len(), 2));
    instance.log.take();
    assert_eq!(instance.get("time", 1), [time]);
    // It goes on from there.
    SEEN.with_borrow_mut(|seen| seen.stop = Some(f64::INFINITY));
    let (status, early, end) = instance.try_step(time, STEP - time);
    instance.must(status);
    assert!(!early && (end - STEP).abs() < 1e-12);
}
