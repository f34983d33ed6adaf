//! `fmi2SetRealInputDerivatives`: inputs that vary linearly within a step.

use crate::fmu::*;
use std::ffi::c_int;

fn rates(instance: &Instance, names: &[&str], orders: &[c_int], values: &[f64]) -> c_int {
    let references: Vec<u32> = names.iter().map(|name| instance.model.reference(name)).collect();
    assert!(references.len() == orders.len() && orders.len() == values.len());
    unsafe {
        (instance.fmu.c.fmi2SetRealInputDerivatives)(
            instance.raw,
            references.as_ptr(),
            references.len(),
            orders.as_ptr(),
            values.as_ptr(),
        )
    }
}

/// \[m/s\] of a mass under the force `f + j t` and relaxation at a rate, from rest.
fn speed(mass: f64, rate: f64, f: f64, j: f64, t: f64) -> f64 {
    // dv/dt + λ v = (f + j t)/m: a particular solution is linear in t, the rest dies out.
    let linear = |t: f64| (f - j / rate + j * t) / (rate * mass);
    linear(t) - linear(0.0) * (-rate * t).exp()
}

/// Agent 4 is the last of the row and walks away from it: nothing touches it.
#[test]
fn a_force_rises_within_the_step_as_the_closed_form_has_it() {
    let instance = Instance::new(Fmu::get());
    instance.initialize();
    let (mass, rate) = (instance.get("agent[4].Mass"), instance.get("agent[4].FloorDamping"));
    let (f, j, h) = (30.0, 400.0, 0.2);
    instance.must(instance.set("agent[4].Fp.x", f));
    instance.must(rates(&instance, &["agent[4].Fp.x"], &[1], &[j]));
    instance.must(instance.try_step(0.0, h));
    let found = instance.get("agent[4].Velocity.x");
    let expected = speed(mass, rate, f, j, h);
    assert!((found - expected).abs() < 1e-12, "{found} {expected}");
    assert!(expected > 1.5 * speed(mass, rate, f, 0.0, h), "the rate matters");
    assert_eq!(instance.get("agent[4].Fp.x"), f, "an input keeps the value that was set");
}

/// The same ramp, once in one step and once in ten whose forces are the ramp's: in contact too.
#[test]
fn a_ramp_does_not_depend_on_the_communication_step() {
    let run = |steps: usize, interpolate: bool| {
        let instance = Instance::new(Fmu::get());
        instance.must(instance.set("TimeStepMechanical", 1e-5));
        instance.initialize();
        let (h, j) = (0.4 / steps as f64, 3000.0);
        for k in 0..steps {
            let t = h * k as f64;
            instance.must(instance.set("agent[0].Fp.x", j * t));
            if interpolate {
                instance.must(rates(&instance, &["agent[0].Fp.x"], &[1], &[j]));
            }
            instance.must(instance.try_step(t, h));
        }
        assert!(instance.get("agent[1].Velocity.x") > 0.1, "it was hit");
        instance.get("agent[0].Position.x")
    };
    let (once, tenfold) = (run(1, true), run(10, true));
    assert!((once - tenfold).abs() < 1e-7, "{once} {tenfold}");
    // Held, the force lags by half a step.
    let (held, finer) = (run(10, false), run(100, false));
    assert!((held - tenfold).abs() > 1e-4 && (finer - tenfold).abs() > 1e-5, "{held} {finer} {tenfold}");
    let order = ((held - tenfold) / (finer - tenfold)).log10();
    assert!((order - 1.0).abs() < 0.1, "{order}");
}

#[test]
fn a_rate_counts_for_one_step_and_zero_is_held() {
    let [with, zero, without] = [(); 3].map(|()| Instance::pushed(Fmu::get()));
    without.steps(0, 12);
    with.must(rates(&with, &["agent[0].Fp.x", "agent[3].Mp"], &[1, 1], &[500.0, -3.0]));
    with.steps(0, 1);
    for k in 0..12 {
        zero.must(rates(&zero, &["agent[0].Fp.x", "agent[3].Mp"], &[1, 1], &[0.0, -0.0]));
        zero.steps(k, k + 1);
    }
    assert_eq!(zero.everything(), without.everything());
    // From here on nothing remembers the rate but the motion.
    let state = with.bytes();
    with.steps(1, 12);
    let other = Instance::new(Fmu::get());
    other.must(other.restore_bytes(&state));
    other.steps(1, 12);
    assert_eq!(with.everything(), other.everything());
    assert_ne!(with.everything(), without.everything());
}

#[test]
fn a_state_holds_rates_that_wait_for_their_step() {
    let instance = Instance::pushed(Fmu::get());
    instance.steps(0, 3);
    instance.must(rates(&instance, &["agent[0].Fp.x"], &[1], &[9000.0]));
    let (waiting, other) = (instance.bytes(), Instance::new(Fmu::get()));
    instance.steps(3, 5);
    other.must(other.restore_bytes(&waiting));
    other.steps(3, 5);
    assert_eq!(other.everything(), instance.everything());
    // A refused step does not use them up.
    other.must(other.restore_bytes(&waiting));
    other.refused(other.try_step(3.0 * STEP, -STEP));
    other.steps(3, 5);
    assert_eq!(other.everything(), instance.everything());
    // Nor does a reset keep them.
    other.must(other.restore_bytes(&waiting));
    other.must(unsafe { (other.fmu.c.fmi2Reset)(other.raw) });
    assert!(other.bytes() == Instance::new(Fmu::get()).bytes());
}

#[test]
fn what_is_no_first_derivative_of_an_input_is_refused_and_named() {
    let instance = Instance::pushed(Fmu::get());
    instance.steps(0, 1);
    let before = instance.bytes();
    let good = ("agent[1].Fp.x", 1, 5.0);
    for (bad, words) in [
        (("agent[0].Fp.x", 2, 1.0), ["agent[0].Fp.x", "order 2"]),
        (("agent[0].Fp.x", 0, 1.0), ["agent[0].Fp.x", "order 0"]),
        (("agent[0].Fp.y", 1, f64::NAN), ["agent[0].Fp.y", "finite"]),
        (("agent[0].Mp", 1, f64::INFINITY), ["agent[0].Mp", "finite"]),
        (("agent[0].Velocity.x", 1, 1.0), ["agent[0].Velocity.x", "not an input"]),
        (("agent[0].Mass", 1, 1.0), ["agent[0].Mass", "not an input"]),
        (("Threads", 1, 1.0), ["no variable of type Real", "reference"]),
    ] {
        let (names, orders, values) = ([good.0, bad.0], [good.1, bad.1], [good.2, bad.2]);
        let message = instance.refused(rates(&instance, &names, &orders, &values));
        assert!(words.iter().all(|word| message.contains(word)), "{message}");
        assert!(instance.bytes() == before, "{message}: something was set");
    }
}
