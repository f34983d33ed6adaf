//! What a slave that steps synchronously and has no derivatives of outputs returns.

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
fn derivatives_are_refused_by_the_name_of_their_capability() {
    let instance = Instance::pushed(Fmu::get());
    let (c, i) = (&instance.fmu.c, instance.raw);
    let (input, output) =
        (instance.model.reference("agent[0].Fp.x"), instance.model.reference("agent[0].Velocity.x"));
    let mut value = 7.0;
    let messages = unsafe {
        [
            instance.refused((c.fmi2GetDirectionalDerivative)(i, &output, 1, &input, 1, &1.0, &mut value)),
            instance.refused((c.fmi2GetRealOutputDerivatives)(i, &output, 1, &1, &mut value)),
        ]
    };
    let capabilities = ["providesDirectionalDerivative", "maxOutputDerivativeOrder"];
    for (message, capability) in messages.iter().zip(capabilities) {
        assert!(message.contains(capability), "{message}");
    }
    assert_eq!(value, 7.0);
    instance.steps(0, 1);
}
