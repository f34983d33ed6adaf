//! NULL wherever FMI passes a pointer: an error and a message, never a crash.

use crate::fmu::*;
use crate::lifecycle::{STATES, reach};
use std::ffi::{c_int, c_void};
use std::ptr::{null, null_mut};

type Call = fn(&Functions, *mut c_void) -> c_int;

/// Calls of all functions that take an instance and return a status.
const WELL_FORMED: [(&str, Call); 30] = [
    ("fmi2SetDebugLogging", |c, i| unsafe { (c.fmi2SetDebugLogging)(i, 1, 0, null()) }),
    ("fmi2SetupExperiment", |c, i| unsafe { (c.fmi2SetupExperiment)(i, 0, 0.0, 0.0, 0, 0.0) }),
    ("fmi2EnterInitializationMode", |c, i| unsafe { (c.fmi2EnterInitializationMode)(i) }),
    ("fmi2ExitInitializationMode", |c, i| unsafe { (c.fmi2ExitInitializationMode)(i) }),
    ("fmi2Terminate", |c, i| unsafe { (c.fmi2Terminate)(i) }),
    ("fmi2Reset", |c, i| unsafe { (c.fmi2Reset)(i) }),
    ("fmi2GetReal", |c, i| unsafe { (c.fmi2GetReal)(i, &0, 1, &mut 0.0) }),
    ("fmi2GetInteger", |c, i| unsafe { (c.fmi2GetInteger)(i, &0, 1, &mut 0) }),
    ("fmi2GetBoolean", |c, i| unsafe { (c.fmi2GetBoolean)(i, &0, 1, &mut 0) }),
    ("fmi2GetString", |c, i| unsafe { (c.fmi2GetString)(i, &0, 1, &mut null()) }),
    ("fmi2SetReal", |c, i| unsafe { (c.fmi2SetReal)(i, &0, 1, &1.0) }),
    ("fmi2SetInteger", |c, i| unsafe { (c.fmi2SetInteger)(i, &0, 1, &1) }),
    ("fmi2SetBoolean", |c, i| unsafe { (c.fmi2SetBoolean)(i, &0, 1, &1) }),
    ("fmi2SetString", |c, i| unsafe { (c.fmi2SetString)(i, &0, 1, &c"".as_ptr()) }),
    ("fmi2GetFMUstate", |c, i| unsafe { (c.fmi2GetFMUstate)(i, &mut null_mut()) }),
    ("fmi2SetFMUstate", |c, i| unsafe { (c.fmi2SetFMUstate)(i, null_mut()) }),
    ("fmi2FreeFMUstate", |c, i| unsafe { (c.fmi2FreeFMUstate)(i, &mut null_mut()) }),
    ("fmi2SerializedFMUstateSize", |c, i| unsafe { (c.fmi2SerializedFMUstateSize)(i, null_mut(), &mut 0) }),
    ("fmi2SerializeFMUstate", |c, i| unsafe { (c.fmi2SerializeFMUstate)(i, null_mut(), &mut 0, 1) }),
    ("fmi2DeSerializeFMUstate", |c, i| unsafe { (c.fmi2DeSerializeFMUstate)(i, &0, 1, &mut null_mut()) }),
    ("fmi2GetDirectionalDerivative", |c, i| unsafe {
        (c.fmi2GetDirectionalDerivative)(i, &0, 1, &0, 1, &0.0, &mut 0.0)
    }),
    ("fmi2SetRealInputDerivatives", |c, i| unsafe { (c.fmi2SetRealInputDerivatives)(i, &0, 1, &1, &0.0) }),
    ("fmi2GetRealOutputDerivatives", |c, i| unsafe {
        (c.fmi2GetRealOutputDerivatives)(i, &0, 1, &1, &mut 0.0)
    }),
    ("fmi2DoStep", |c, i| unsafe { (c.fmi2DoStep)(i, 0.0, STEP, 1) }),
    ("fmi2CancelStep", |c, i| unsafe { (c.fmi2CancelStep)(i) }),
    ("fmi2GetStatus", |c, i| unsafe { (c.fmi2GetStatus)(i, 0, &mut 0) }),
    ("fmi2GetRealStatus", |c, i| unsafe { (c.fmi2GetRealStatus)(i, 2, &mut 0.0) }),
    ("fmi2GetIntegerStatus", |c, i| unsafe { (c.fmi2GetIntegerStatus)(i, 0, &mut 0) }),
    ("fmi2GetBooleanStatus", |c, i| unsafe { (c.fmi2GetBooleanStatus)(i, 3, &mut 0) }),
    ("fmi2GetStringStatus", |c, i| unsafe { (c.fmi2GetStringStatus)(i, 1, &mut null()) }),
];

#[test]
fn no_instance_is_an_error() {
    let c = &Fmu::get().c;
    // The others are fmi2GetTypesPlatform, fmi2GetVersion, fmi2Instantiate and:
    unsafe { (c.fmi2FreeInstance)(null_mut()) };
    for (name, call) in WELL_FORMED {
        assert_eq!(call(c, null_mut()), ERROR, "{name}");
    }
}

/// A state that stays what it is: nobody may follow it in these calls.
static mut SOMETHING: u8 = 0;
const FOREIGN: *mut c_void = (&raw mut SOMETHING).cast();

/// Calls with a NULL that is none of FMI's, in turn at each place.
const MALFORMED: [(&str, Call); 28] = [
    ("fmi2SetDebugLogging", |c, i| unsafe { (c.fmi2SetDebugLogging)(i, 1, 1, null()) }),
    ("fmi2SetDebugLogging", |c, i| unsafe { (c.fmi2SetDebugLogging)(i, 1, 1, &null()) }),
    ("fmi2GetReal", |c, i| unsafe { (c.fmi2GetReal)(i, null(), 1, &mut 0.0) }),
    ("fmi2GetReal", |c, i| unsafe { (c.fmi2GetReal)(i, &0, 1, null_mut()) }),
    ("fmi2GetInteger", |c, i| unsafe { (c.fmi2GetInteger)(i, null(), 1, &mut 0) }),
    ("fmi2GetInteger", |c, i| unsafe { (c.fmi2GetInteger)(i, &1, 1, null_mut()) }),
    ("fmi2GetBoolean", |c, i| unsafe { (c.fmi2GetBoolean)(i, null(), 1, &mut 0) }),
    ("fmi2GetBoolean", |c, i| unsafe { (c.fmi2GetBoolean)(i, &0, 1, null_mut()) }),
    ("fmi2GetString", |c, i| unsafe { (c.fmi2GetString)(i, null(), 1, &mut null()) }),
    ("fmi2GetString", |c, i| unsafe { (c.fmi2GetString)(i, &2, 1, null_mut()) }),
    ("fmi2SetReal", |c, i| unsafe { (c.fmi2SetReal)(i, null(), 1, &1.0) }),
    ("fmi2SetReal", |c, i| unsafe { (c.fmi2SetReal)(i, &0, 1, null()) }),
    ("fmi2SetInteger", |c, i| unsafe { (c.fmi2SetInteger)(i, null(), 1, &1) }),
    ("fmi2SetInteger", |c, i| unsafe { (c.fmi2SetInteger)(i, &1, 1, null()) }),
    ("fmi2SetBoolean", |c, i| unsafe { (c.fmi2SetBoolean)(i, null(), 1, &1) }),
    ("fmi2SetBoolean", |c, i| unsafe { (c.fmi2SetBoolean)(i, &0, 1, null()) }),
    ("fmi2SetString", |c, i| unsafe { (c.fmi2SetString)(i, null(), 1, &c"".as_ptr()) }),
    ("fmi2SetString", |c, i| unsafe { (c.fmi2SetString)(i, &3, 1, null()) }),
    ("fmi2SetString", |c, i| unsafe { (c.fmi2SetString)(i, &3, 1, &null()) }),
    ("fmi2GetFMUstate", |c, i| unsafe { (c.fmi2GetFMUstate)(i, null_mut()) }),
    ("fmi2SetFMUstate", |c, i| unsafe { (c.fmi2SetFMUstate)(i, null_mut()) }),
    ("fmi2SerializedFMUstateSize", |c, i| unsafe { (c.fmi2SerializedFMUstateSize)(i, null_mut(), &mut 0) }),
    ("fmi2SerializedFMUstateSize", |c, i| unsafe { (c.fmi2SerializedFMUstateSize)(i, FOREIGN, null_mut()) }),
    ("fmi2SerializeFMUstate", |c, i| unsafe { (c.fmi2SerializeFMUstate)(i, null_mut(), &mut 0, 1) }),
    ("fmi2SerializeFMUstate", |c, i| unsafe { (c.fmi2SerializeFMUstate)(i, FOREIGN, null_mut(), 1) }),
    ("fmi2DeSerializeFMUstate", |c, i| unsafe { (c.fmi2DeSerializeFMUstate)(i, null(), 1, &mut null_mut()) }),
    ("fmi2DeSerializeFMUstate", |c, i| unsafe { (c.fmi2DeSerializeFMUstate)(i, &0, 1, null_mut()) }),
    ("fmi2DeSerializeFMUstate", |c, i| unsafe { (c.fmi2DeSerializeFMUstate)(i, null(), 0, &mut null_mut()) }),
];

#[test]
fn null_arguments_are_refused_in_words_in_every_state() {
    for state in STATES {
        let instance = reach(state);
        let before = instance.bytes();
        for (place, (name, call)) in MALFORMED.iter().enumerate() {
            let message = instance.refused(call(&instance.fmu.c, instance.raw));
            assert!(message.starts_with(&format!("{name}: ")), "call {place} in {state:?}: {message}");
            assert!(instance.bytes() == before, "call {place} in {state:?} has changed something");
        }
    }
}

#[test]
fn null_is_named() {
    let instance = Instance::pushed(Fmu::get());
    for (name, call) in MALFORMED {
        let message = instance.refused(call(&instance.fmu.c, instance.raw));
        let told = message.contains("is NULL");
        // Wrong in another way too, which is told first: no Booleans, and what is not a state.
        let otherwise =
            message.contains("Boolean") || message.contains("cut off") || message.contains("not a state");
        assert!(told || otherwise, "{name}: {message}");
    }
}

#[test]
fn no_elements_need_no_array() {
    let instance = Instance::pushed(Fmu::get());
    let (c, i) = (&instance.fmu.c, instance.raw);
    unsafe {
        instance.must((c.fmi2SetDebugLogging)(i, 0, 0, null()));
        instance.must((c.fmi2GetReal)(i, null(), 0, null_mut()));
        instance.must((c.fmi2GetInteger)(i, null(), 0, null_mut()));
        instance.must((c.fmi2GetBoolean)(i, null(), 0, null_mut()));
        instance.must((c.fmi2GetString)(i, null(), 0, null_mut()));
        instance.must((c.fmi2SetReal)(i, null(), 0, null()));
        instance.must((c.fmi2SetInteger)(i, null(), 0, null()));
        instance.must((c.fmi2SetBoolean)(i, null(), 0, null()));
        instance.must((c.fmi2SetString)(i, null(), 0, null()));
        // Nothing to free.
        instance.must((c.fmi2FreeFMUstate)(i, null_mut()));
        instance.must((c.fmi2FreeFMUstate)(i, &mut null_mut()));
    }
    instance.steps(0, 1);
}

/// The status functions have only one pointer to leave out, that for the value.
#[test]
fn no_place_for_a_status_is_an_error() {
    let instance = Instance::pushed(Fmu::get());
    let (c, i) = (&instance.fmu.c, instance.raw);
    let answers = unsafe {
        [
            (c.fmi2GetStatus)(i, 0, null_mut()),
            (c.fmi2GetRealStatus)(i, 2, null_mut()),
            (c.fmi2GetIntegerStatus)(i, 0, null_mut()),
            (c.fmi2GetBooleanStatus)(i, 3, null_mut()),
            (c.fmi2GetStringStatus)(i, 1, null_mut()),
        ]
    };
    assert_eq!(answers, [ERROR; 5]);
    let log = instance.log.take();
    assert!(log.len() == 5 && log.iter().all(|message| message.text.ends_with("value is NULL")), "{log:?}");
}
