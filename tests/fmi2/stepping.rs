//! `fmi2SetupExperiment` and `fmi2DoStep`: times and steps that are refused, and those that are not.

use crate::fmu::*;
use std::ffi::c_int;

fn set_up(instance: &Instance, start: f64, stop: Option<f64>) -> c_int {
    let (defined, stop) = (stop.is_some().into(), stop.unwrap_or(f64::NAN));
    unsafe { (instance.fmu.c.fmi2SetupExperiment)(instance.raw, 0, f64::NAN, start, defined, stop) }
}

fn last_time(instance: &Instance) -> f64 {
    let mut time = f64::NAN;
    instance.must(unsafe { (instance.fmu.c.fmi2GetRealStatus)(instance.raw, 2, &mut time) });
    time
}

#[test]
fn experiments_are_checked() {
    let instance = Instance::new(Fmu::get());
    let before = instance.bytes();
    for (start, stop) in [
        (f64::NAN, None),
        (f64::INFINITY, None),
        (0.0, Some(f64::NAN)),
        (0.0, Some(f64::INFINITY)),
        (1.0, Some(0.5)),
    ] {
        let message = instance.refused(set_up(&instance, start, stop));
        assert!(message.contains("time"), "{message}");
    }
    assert!(instance.bytes() == before);
    // An undefined stop time and tolerance are not looked at.
    instance.must(set_up(&instance, -3.0, None));
    // The last one counts.
    instance.must(set_up(&instance, 7.0, Some(7.02)));
    instance.must(instance.set("TimeStepMechanical", 1e-4));
    let c = &instance.fmu.c;
    unsafe {
        instance.must((c.fmi2EnterInitializationMode)(instance.raw));
        instance.must((c.fmi2ExitInitializationMode)(instance.raw));
    }
    instance.must(instance.try_step(7.0, STEP));
    assert_eq!(last_time(&instance), 7.0 + STEP);
}

#[test]
fn refused_steps_change_nothing() {
    let instance = Instance::new(Fmu::get());
    instance.must(instance.set("TimeStepMechanical", 1e-4));
    instance.must(set_up(&instance, 0.0, Some(0.05)));
    let c = &instance.fmu.c;
    unsafe {
        instance.must((c.fmi2EnterInitializationMode)(instance.raw));
        instance.must((c.fmi2ExitInitializationMode)(instance.raw));
    }
    instance.steps(0, 2);
    let (before, values) = (instance.bytes(), instance.everything());
    let cases = [
        (0.02, 0.0, "step"),
        (0.02, -STEP, "step"),
        (0.02, f64::NAN, "step"),
        (0.02, f64::INFINITY, "step"),
        (0.0, STEP, "communication point"),
        (0.03, STEP, "communication point"),
        (f64::NAN, STEP, "communication point"),
        (f64::INFINITY, STEP, "communication point"),
        (0.02, 0.04, "stop time"),
    ];
    for (from, step, word) in cases {
        let message = instance.refused(instance.try_step(from, step));
        assert!(message.contains(word), "({from}, {step}): {message}");
    }
    assert!(instance.bytes() == before && instance.everything() == values);
    // As masters add up their times.
    instance.must(instance.try_step(0.019_999_999_999_999_997, 0.010_000_000_000_000_002));
    instance.must(instance.try_step(0.03, 0.020_000_000_000_000_004));
}

/// A step of absurdly many mechanical steps is no step of this slave's, but none of its faults either.
#[test]
fn steps_that_would_never_end_are_refused() {
    let instance = Instance::new(Fmu::get());
    instance.must(instance.set("TimeStepMechanical", 1e-300));
    instance.initialize();
    let message = instance.refused(instance.try_step(0.0, 0.05));
    assert!(message.contains("too many steps"), "{message}");
}

/// The time after it would be infinite, and a state of it could not be restored.
#[test]
fn steps_beyond_all_numbers_are_refused() {
    let instance = Instance::new(Fmu::get());
    instance.must(instance.set("TimeStepMechanical", 1e308));
    instance.must(set_up(&instance, 1e308, None));
    let c = &instance.fmu.c;
    unsafe {
        instance.must((c.fmi2EnterInitializationMode)(instance.raw));
        instance.must((c.fmi2ExitInitializationMode)(instance.raw));
    }
    let message = instance.refused(instance.try_step(1e308, 1e308));
    assert!(message.contains("finite time"), "{message}");
    assert_eq!(last_time(&instance), 1e308);
}

/// Any other H is served too, and two halves lead about where one whole leads.
#[test]
fn the_step_may_vary() {
    let (one, two) = (Instance::pushed(Fmu::get()), Instance::pushed(Fmu::get()));
    one.must(one.try_step(0.0, 0.04));
    two.must(two.try_step(0.0, 0.013));
    two.must(two.try_step(0.013, 0.027));
    let (one, two) = (one.get("agent[0].Position.x"), two.get("agent[0].Position.x"));
    assert!(one > 0.005 && (one - two).abs() < 1e-9, "{one} {two}");
}
