//! What a slave that steps synchronously returns of itself, and derivatives of outputs.

use crate::fmu::*;
use std::ffi::c_int;
use std::ptr::null;

const DO_STEP_STATUS: c_int = 0;
const PENDING_STATUS: c_int = 1;
const LAST_SUCCESSFUL_TIME: c_int = 2;
const TERMINATED: c_int = 3;

#[track_caller]
fn discarded(instance: &Instance, status: c_int) {
    let log = instance.log.take();
    assert_eq!(status, DISCARD, "{log:?}");
    assert!(log.len() == 1 && log[0].status == DISCARD, "{log:?}");
}

#[test]
fn statuses_of_a_synchronous_slave() {
    let instance = Instance::pushed(Fmu::get());
    instance.steps(0, 2);
    let (c, i) = (&instance.fmu.c, instance.raw);
    let (mut real, mut boolean) = (f64::NAN, 7);
    unsafe {
        instance.must((c.fmi2GetRealStatus)(i, LAST_SUCCESSFUL_TIME, &mut real));
        assert_eq!(real, 2.0 * STEP);
        instance.must((c.fmi2GetBooleanStatus)(i, TERMINATED, &mut boolean));
        assert_eq!(boolean, 0);
        // About pending steps, or of another type.
        discarded(&instance, (c.fmi2GetStatus)(i, DO_STEP_STATUS, &mut 0));
        discarded(&instance, (c.fmi2GetStringStatus)(i, PENDING_STATUS, &mut null()));
        discarded(&instance, (c.fmi2GetIntegerStatus)(i, DO_STEP_STATUS, &mut 0));
        for kind in [DO_STEP_STATUS, PENDING_STATUS, TERMINATED, -1, 99] {
            discarded(&instance, (c.fmi2GetRealStatus)(i, kind, &mut real));
        }
        for kind in [DO_STEP_STATUS, PENDING_STATUS, LAST_SUCCESSFUL_TIME, -1, 99] {
            discarded(&instance, (c.fmi2GetBooleanStatus)(i, kind, &mut boolean));
        }
    }
    assert_eq!((real, boolean), (2.0 * STEP, 0), "a value that is not returned is not written");
    instance.steps(2, 3);
}

#[test]
fn there_is_no_step_to_cancel() {
    let instance = Instance::pushed(Fmu::get());
    let message = instance.refused(unsafe { (instance.fmu.c.fmi2CancelStep)(instance.raw) });
    assert!(message.contains("not allowed"), "{message}");
    instance.steps(0, 1);
}

#[test]
fn directional_derivatives_are_refused_by_the_name_of_their_capability() {
    let instance = Instance::pushed(Fmu::get());
    let (c, i) = (&instance.fmu.c, instance.raw);
    let (input, output) =
        (instance.model.reference("agent[0].Fp.x"), instance.model.reference("agent[0].Velocity.x"));
    let mut value = 7.0;
    let message = instance
        .refused(unsafe { (c.fmi2GetDirectionalDerivative)(i, &output, 1, &input, 1, &1.0, &mut value) });
    assert!(message.contains("providesDirectionalDerivative"), "{message}");
    assert_eq!(value, 7.0);
    instance.steps(0, 1);
}

/// Beside the outputs of two short steps: a central difference.
#[test]
fn derivatives_of_outputs_are_those_of_the_motion() {
    const SHORT: f64 = 1e-6;
    let instance = Instance::pushed(Fmu::get());
    instance.steps(0, 12);
    let time = 12.0 * STEP;
    let names = ["Position.x", "Position.y", "Theta", "Velocity.x", "Velocity.y", "Omega"];
    let names: Vec<String> = (0..5).flat_map(|i| names.map(|name| format!("agent[{i}].{name}"))).collect();
    let references: Vec<_> = names.iter().map(|name| instance.model.reference(name)).collect();
    let values = || names.iter().map(|name| instance.get(name)).collect::<Vec<f64>>();
    instance.must(instance.try_step(time, SHORT));
    let state = instance.save();
    let mut derivatives = vec![f64::NAN; names.len()];
    let orders = vec![1; names.len()];
    let get = instance.fmu.c.fmi2GetRealOutputDerivatives;
    let count = references.len();
    instance.must(unsafe {
        get(instance.raw, references.as_ptr(), count, orders.as_ptr(), derivatives.as_mut_ptr())
    });
    let before = values();
    instance.must(instance.try_step(time + SHORT, SHORT));
    let after = values();
    let moved = derivatives.iter().filter(|rate| rate.abs() > 0.1).count();
    assert!(moved >= 4, "a push is on: {derivatives:?}");
    for (k, name) in names.iter().enumerate() {
        let difference = (after[k] - before[k]) / SHORT;
        // Forces change within the short step, most of all where a contact begins.
        let close = (derivatives[k] - difference).abs() <= 0.02 * (1.0 + difference.abs());
        assert!(close, "{name}: {} beside {difference}", derivatives[k]);
    }
    instance.free_state(state);
    // Who is not there does not move, whatever the drive.
    instance.must(instance.set("agent[0].Fp.y", 300.0));
    instance.must(instance.set_boolean("agent[0].Active", false));
    for stepped in [false, true] {
        if stepped {
            instance.must(instance.try_step(time + 2.0 * SHORT, SHORT));
        }
        instance.must(unsafe {
            get(instance.raw, references.as_ptr(), count, orders.as_ptr(), derivatives.as_mut_ptr())
        });
        assert_eq!(derivatives[..6], [0.0; 6], "{stepped}");
        assert!(derivatives[6..].iter().any(|rate| rate.abs() > 0.1));
    }
    // Only order 1, only of motion, of inputs not.
    for (name, order, why) in [
        ("agent[0].Omega", 2, "order 2"),
        ("agent[0].Omega", 0, "order 0"),
        ("agent[0].MeanNormalForce", 1, "not known"),
        ("agent[0].Fp.x", 1, "not known"),
    ] {
        let mut value = 7.0;
        let message = instance
            .refused(unsafe { get(instance.raw, &instance.model.reference(name), 1, &order, &mut value) });
        assert!(message.contains(name) && message.contains(why) && value == 7.0, "{message}");
    }
}
