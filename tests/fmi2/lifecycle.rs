//! The calling sequence of FMI 2.0, section 4.2.4: each function in each state.

use crate::fmu::*;
use State::*;
use std::ffi::c_int;
use std::ptr::{null, null_mut};

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum State {
    Instantiated,
    Initialization,
    StepComplete,
    Terminated,
    Error,
}

pub const STATES: [State; 5] = [Instantiated, Initialization, StepComplete, Terminated, Error];

/// An instance in a state.
pub fn reach(state: State) -> Instance<'static> {
    let instance = Instance::new(Fmu::get());
    let c = &instance.fmu.c;
    instance.must(instance.set("TimeStepMechanical", 1e-4));
    if state == Error {
        // Its acceleration is no number of this world.
        instance.must(instance.set_all(&[("agent[0].Mass", 1e-300), ("agent[0].Fp.x", 1e300)]));
    }
    unsafe {
        match state {
            Instantiated => {}
            Initialization => instance.enter_initialization(),
            StepComplete => instance.initialize(),
            Terminated => {
                instance.initialize();
                instance.must((c.fmi2Terminate)(instance.raw));
            }
            Error => {
                instance.initialize();
                let message = instance.refused(instance.try_step(0.0, STEP));
                assert!(message.contains("agent \"0\"") && message.contains("finite"), "{message}");
            }
        }
    }
    assert_eq!(state_of(&instance), state);
    instance
}

/// `fmi2CancelStep` is for steps in progress: it is always refused here, and says where it was called.
fn state_of(instance: &Instance) -> State {
    let message = instance.refused(unsafe { (instance.fmu.c.fmi2CancelStep)(instance.raw) });
    let state = STATES.iter().find(|state| message.ends_with(&format!("{state:?}")));
    *state.unwrap_or_else(|| panic!("no state in {message:?}"))
}

type Call = fn(&Instance) -> c_int;

/// What leaves a state: FMI's own transitions. All other functions stay.
const LEADS_TO: [(&str, State); 4] = [
    ("fmi2EnterInitializationMode", Initialization),
    ("fmi2ExitInitializationMode", StepComplete),
    ("fmi2Terminate", Terminated),
    ("fmi2Reset", Instantiated),
];

/// The table of section 4.2.4 without its columns for slaves that step asynchronously: in which states
/// a function may be called (instantiated, initialization, stepComplete, terminated, error), and a call
/// that is right where it is allowed. Setting Integers, Strings and Booleans is narrowed further by their
/// variability: here none are set.
const TABLE: [(&str, &str, Call); 34] = [
    ("fmi2GetTypesPlatform", "x x x x x", |i| unsafe { (i.fmu.c.fmi2GetTypesPlatform)().is_null().into() }),
    ("fmi2GetVersion", "x x x x x", |i| unsafe { (i.fmu.c.fmi2GetVersion)().is_null().into() }),
    ("fmi2SetDebugLogging", "x x x x x", |i| i.log_on(false, &[])),
    // The standard's column is "start and end": of another instance, which this one does not hinder.
    ("fmi2Instantiate", "x x x x x", |i| {
        drop(Instance::new(i.fmu));
        OK
    }),
    // Of this one when the walk drops it, in every state.
    ("fmi2FreeInstance", "x x x x x", |_| OK),
    ("fmi2SetupExperiment", "x - - - -", |i| unsafe {
        (i.fmu.c.fmi2SetupExperiment)(i.raw, 1, 1e-6, 0.5, 1, 2.0)
    }),
    ("fmi2EnterInitializationMode", "x - - - -", |i| unsafe {
        // It must have a start time; elsewhere that is refused before it.
        let c = &i.fmu.c;
        if state_of(i) == Instantiated {
            i.must((c.fmi2SetupExperiment)(i.raw, 0, 0.0, 0.0, 0, 0.0));
        }
        (c.fmi2EnterInitializationMode)(i.raw)
    }),
    ("fmi2ExitInitializationMode", "- x - - -", |i| unsafe { (i.fmu.c.fmi2ExitInitializationMode)(i.raw) }),
    ("fmi2Terminate", "- - x - -", |i| unsafe { (i.fmu.c.fmi2Terminate)(i.raw) }),
    ("fmi2Reset", "x x x x x", |i| unsafe { (i.fmu.c.fmi2Reset)(i.raw) }),
    ("fmi2GetReal", "- x x x x", |i| i.try_get("agent[1].NormalForce").0),
    ("fmi2GetInteger", "- x x x x", |i| unsafe {
        (i.fmu.c.fmi2GetInteger)(i.raw, &i.model.reference("AgentContacts"), 1, &mut 0)
    }),
    ("fmi2GetBoolean", "- x x x x", |i| unsafe { (i.fmu.c.fmi2GetBoolean)(i.raw, null(), 0, null_mut()) }),
    ("fmi2GetString", "- x x x x", |i| unsafe {
        (i.fmu.c.fmi2GetString)(i.raw, &i.model.reference("Trial"), 1, &mut null())
    }),
    ("fmi2SetReal", "x x x - -", |i| i.set("agent[1].Fp.y", 1.0)),
    ("fmi2SetInteger", "x x x - -", |i| unsafe { (i.fmu.c.fmi2SetInteger)(i.raw, null(), 0, null()) }),
    ("fmi2SetBoolean", "x x x - -", |i| unsafe { (i.fmu.c.fmi2SetBoolean)(i.raw, null(), 0, null()) }),
    ("fmi2SetString", "x x x - -", |i| unsafe { (i.fmu.c.fmi2SetString)(i.raw, null(), 0, null()) }),
    ("fmi2GetFMUstate", "x x x x x", |i| {
        i.free_state(i.save());
        OK
    }),
    ("fmi2SetFMUstate", "x x x x x", |i| {
        let state = i.save();
        let status = unsafe { (i.fmu.c.fmi2SetFMUstate)(i.raw, state) };
        i.free_state(state);
        status
    }),
    ("fmi2FreeFMUstate", "x x x x x", |i| unsafe { (i.fmu.c.fmi2FreeFMUstate)(i.raw, &mut i.save()) }),
    ("fmi2SerializedFMUstateSize", "x x x x x", |i| {
        let state = i.save();
        let status = unsafe { (i.fmu.c.fmi2SerializedFMUstateSize)(i.raw, state, &mut 0) };
        i.free_state(state);
        status
    }),
    ("fmi2SerializeFMUstate", "x x x x x", |i| {
        let (state, mut bytes) = (i.save(), [0; 10_000]);
        let status =
            unsafe { (i.fmu.c.fmi2SerializeFMUstate)(i.raw, state, bytes.as_mut_ptr(), bytes.len()) };
        i.free_state(state);
        status
    }),
    ("fmi2DeSerializeFMUstate", "x x x x x", |i| i.restore_bytes(&i.bytes())),
    ("fmi2GetDirectionalDerivative", "- x x x x", |i| unsafe {
        (i.fmu.c.fmi2GetDirectionalDerivative)(i.raw, null(), 0, null(), 0, null(), null_mut())
    }),
    ("fmi2SetRealInputDerivatives", "x x x - -", |i| unsafe {
        (i.fmu.c.fmi2SetRealInputDerivatives)(i.raw, &i.model.reference("agent[1].Fp.y"), 1, &1, &2.0)
    }),
    ("fmi2GetRealOutputDerivatives", "- - x x x", |i| unsafe {
        (i.fmu.c.fmi2GetRealOutputDerivatives)(i.raw, &i.model.reference("agent[1].Omega"), 1, &1, &mut 0.0)
    }),
    ("fmi2DoStep", "- - x - -", |i| i.try_step(0.0, STEP)),
    ("fmi2CancelStep", "- - - - -", |i| unsafe { (i.fmu.c.fmi2CancelStep)(i.raw) }),
    ("fmi2GetStatus", "- - x x -", |i| unsafe { (i.fmu.c.fmi2GetStatus)(i.raw, 0, &mut 0) }),
    ("fmi2GetRealStatus", "- - x x -", |i| unsafe { (i.fmu.c.fmi2GetRealStatus)(i.raw, 2, &mut 0.0) }),
    ("fmi2GetIntegerStatus", "- - x x -", |i| unsafe { (i.fmu.c.fmi2GetIntegerStatus)(i.raw, 0, &mut 0) }),
    ("fmi2GetBooleanStatus", "- - x x -", |i| unsafe { (i.fmu.c.fmi2GetBooleanStatus)(i.raw, 3, &mut 0) }),
    ("fmi2GetStringStatus", "- - x x -", |i| unsafe { (i.fmu.c.fmi2GetStringStatus)(i.raw, 1, &mut null()) }),
];

/// Not provided, and saying so, where they are allowed.
const NOT_PROVIDED: [&str; 1] = ["fmi2GetDirectionalDerivative"];

#[test]
fn the_table_has_every_function() {
    let names: Vec<&str> = TABLE.iter().map(|(name, ..)| *name).collect();
    for name in NAMES {
        assert_eq!(names.iter().filter(|other| *other == name).count(), 1, "{name}");
    }
}

#[test]
fn functions_are_allowed_where_the_standard_allows_them() {
    for (name, states, call) in TABLE {
        for (state, cell) in STATES.into_iter().zip(states.split(' ')) {
            let instance = reach(state);
            let before = instance.bytes();
            let status = call(&instance);
            let log = instance.log.take();
            let case = format!("{name} in {state:?}: {status}, {log:?}");
            if cell == "x" {
                assert!(log.iter().all(|message| !message.text.contains("not allowed")), "{case}");
                if NOT_PROVIDED.contains(&name) {
                    assert!(status == ERROR && log.len() == 1, "{case}");
                } else if name.ends_with("Status") {
                    assert!(status == OK || status == DISCARD, "{case}");
                } else {
                    assert_eq!(status, OK, "{case}");
                }
                let then = LEADS_TO.iter().find(|(from, _)| *from == name).map_or(state, |(_, to)| *to);
                assert_eq!(state_of(&instance), then, "{case}");
            } else {
                assert_eq!(status, ERROR, "{case}");
                let [message] = &*log else { panic!("{case}") };
                assert!(message.status == ERROR && message.text.starts_with(name), "{case}");
                assert!(message.text.contains(&format!("not allowed in the state {state:?}")), "{case}");
                assert!(instance.bytes() == before, "{case} has changed something");
            }
        }
    }
}

/// FMI 2.0: it "must be called at least once" before initialization, so that there is a start time.
#[test]
fn initialization_needs_an_experiment() {
    let instance = Instance::new(Fmu::get());
    let c = &instance.fmu.c;
    let message = instance.refused(unsafe { (c.fmi2EnterInitializationMode)(instance.raw) });
    assert!(message.contains("fmi2SetupExperiment"), "{message}");
    assert_eq!(state_of(&instance), Instantiated);
    instance.initialize();
    instance.must(unsafe { (c.fmi2Reset)(instance.raw) });
    let message = instance.refused(unsafe { (c.fmi2EnterInitializationMode)(instance.raw) });
    assert!(message.contains("fmi2SetupExperiment"), "a reset forgets it: {message}");
}

/// The other way back is `fmi2Reset`, below.
#[test]
fn a_state_leads_back_from_an_error() {
    let instance = Instance::new(Fmu::get());
    instance.must(instance.set("agent[2].Mass", 1e-3));
    instance.push_and_initialize();
    instance.steps(0, 1);
    let (good, values) = (instance.bytes(), instance.everything());
    instance.must(instance.set("agent[2].Fp.x", 1e308));
    let message = instance.refused(instance.try_step(STEP, STEP));
    assert!(message.contains("agent \"2\"") && message.contains("finite"), "{message}");
    assert_eq!(state_of(&instance), Error);
    instance.must(instance.restore_bytes(&good));
    assert_eq!(state_of(&instance), StepComplete);
    assert_eq!(instance.everything(), values);
    instance.steps(1, 3);
}

#[test]
fn an_output_directory_that_cannot_be_made_is_refused_and_named() {
    let instance = Instance::new(Fmu::get());
    instance.must(instance.set_string("OutputDirectory", "/dev/null/at all"));
    let c = &instance.fmu.c;
    instance.enter_initialization();
    let message = instance.refused(unsafe { (c.fmi2ExitInitializationMode)(instance.raw) });
    assert!(message.contains("OutputDirectory") && message.contains("/dev/null/at all"), "{message}");
    assert_eq!(state_of(&instance), Initialization);
}

#[test]
fn output_that_cannot_be_written_is_an_error_and_named() {
    let directory = tempfile::tempdir().unwrap();
    let output = directory.path().join("made/by the FMU");
    let instance = Instance::new(Fmu::get());
    instance.must(instance.set_string("OutputDirectory", output.to_str().unwrap()));
    instance.must(instance.set("TimeStepMechanical", 1e-4));
    instance.initialize();
    instance.steps(0, 1);
    std::fs::remove_dir_all(&output).unwrap();
    let message = instance.refused(instance.try_step(STEP, STEP));
    assert!(message.contains("OutputDirectory") && message.contains("by the FMU"), "{message}");
    assert_eq!(state_of(&instance), Error);
}

/// An importer may write anywhere, but not through a link that somebody else left there.
#[test]
#[cfg(unix)]
fn output_does_not_go_through_a_link() {
    let directory = tempfile::tempdir().unwrap();
    let mine = directory.path().join("mine");
    std::fs::write(&mine, "precious").unwrap();
    let output = directory.path().join("output");
    std::fs::create_dir(&output).unwrap();
    for name in ["AgentDynamics output t=0.05.xml", "AgentInteractions t=0.05.xml"] {
        std::os::unix::fs::symlink(&mine, output.join(name)).unwrap();
        let instance = Instance::new(Fmu::get());
        instance.must(instance.set_string("OutputDirectory", output.to_str().unwrap()));
        instance.must(instance.set("TimeStepMechanical", 1e-4));
        instance.initialize();
        let message = instance.refused(instance.try_step(0.0, 0.05));
        assert!(message.contains(name) && message.contains("there is a link"), "{message}");
        assert_eq!(std::fs::read_to_string(&mine).unwrap(), "precious");
        std::fs::remove_file(output.join(name)).unwrap();
    }
}

#[test]
fn reset_leads_back_to_the_state_after_instantiation() {
    for state in STATES {
        let fresh = Instance::new(Fmu::get());
        let instance = reach(state);
        instance.must(unsafe { (instance.fmu.c.fmi2Reset)(instance.raw) });
        assert!(instance.bytes() == fresh.bytes(), "{state:?}");
        for instance in [&fresh, &instance] {
            instance.push_and_initialize();
            instance.steps(0, 12);
        }
        assert_eq!(instance.everything(), fresh.everything(), "{state:?}");
    }
}
