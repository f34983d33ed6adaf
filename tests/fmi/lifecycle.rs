//! The calling sequences (FMI 2.0, section 4.2.4; FMI 3.0, section 4.2.1): each function in each state, and NULL at the
//! place of each pointer.

use crate::fmu::*;
use State::*;
use lemons_fmi::testing::{fmi2, fmi3};
use std::ffi::CStr;
use std::ptr::{null, null_mut};

/// Their order is that of the tables.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum State {
    Instantiated,
    Configuration,
    Initialization,
    StepComplete,
    Terminated,
    Error,
}

pub fn states(version: Version) -> impl Iterator<Item = State> {
    let all = [Instantiated, Configuration, Initialization, StepComplete, Terminated, Error];
    let other = if version == V3 { Error } else { Configuration };
    all.into_iter().filter(move |state| *state != other)
}

/// An instance in a state.
pub fn reach(version: Version, state: State) -> Crowd {
    let crowd = Crowd::new(version);
    crowd.must(crowd.set("TimeStepMechanical", 1e-4));
    if state == Error {
        // Its acceleration is no number of this world.
        crowd.must(crowd.set_all(&[("agent[0].Mass", 1e-300), ("agent[0].Fp.x", 1e300)]));
    }
    match state {
        Instantiated => {}
        Configuration => crowd.must(crowd.enter_configuration()),
        Initialization => crowd.enter_initialization(),
        StepComplete | Terminated | Error => crowd.initialize(),
    }
    if state == Terminated {
        crowd.must(crowd.terminate());
    } else if state == Error {
        let message = crowd.refused(crowd.try_step(0.0, STEP));
        assert!(message.contains("agent \"0\"") && message.contains("finite"), "{message}");
    }
    assert_eq!(state_of(&crowd), state);
    crowd
}

/// The first byte of a serialised state's content is the phase; 4 is within a step.
pub fn state_of(crowd: &Crowd) -> State {
    const HEADER: usize = 36;
    match crowd.bytes()[HEADER] {
        0 => Instantiated,
        1 => Configuration,
        2 => Initialization,
        3 => StepComplete,
        5 => Terminated,
        6 => Error,
        other => panic!("phase {other}"),
    }
}

type Call = fn(&Crowd) -> Status;

/// Function, in which states it may be called (instantiated, configuration, initialization, stepComplete, terminated,
/// error; x: in both versions, 3: in FMI 3.0), and a call that is right where it is allowed. The columns for slaves that step asynchronously are left out.
/// Setting is narrowed further by variability.
const COMMON: [(&str, &str, &str, Call); 19] = [
    ("fmi2SetDebugLogging", "fmi3SetDebugLogging", "x x x x x x", |c| c.debug_logging(false, &[])),
    ("fmi2ExitInitializationMode", "fmi3ExitInitializationMode", "- - x - - -", |c| c.exit()),
    ("fmi2Terminate", "fmi3Terminate", "- - - x - -", |c| c.terminate()),
    ("fmi2Reset", "fmi3Reset", "x x x x x x", |c| TestInstance::reset(c)),
    ("fmi2GetReal", "fmi3GetFloat64", "3 x x x x x", |c| c.try_get("agent[1].Mass").0),
    ("fmi2GetInteger", "fmi3GetInt32", "3 x x x x x", |c| {
        c.get_integer(&[c.model.reference("Threads")], 1).0
    }),
    ("fmi2GetBoolean", "fmi3GetBoolean", "3 x x x x x", |c| c.get_boolean(&[], 0).0),
    ("fmi2GetString", "fmi3GetString", "3 x x x x x", |c| c.get_string(&[c.model.reference("Trial")], 1).0),
    ("fmi2SetReal", "fmi3SetFloat64", "x - x x - -", |c| c.set("agent[1].Mp", 1.0)),
    ("fmi2SetReal", "fmi3SetFloat64", "x - x - - -", |c| c.set("agent[1].Mass", 80.0)),
    ("fmi2SetInteger", "fmi3SetInt32", "x - x - - -", |c| c.try_integer("Threads", 1)),
    ("fmi2SetBoolean", "fmi3SetBoolean", "x x x x - -", |c| c.set_boolean(&[], &[])),
    ("fmi2SetString", "fmi3SetString", "x - x - - -", |c| c.set_text("OutputDirectory", "")),
    ("fmi2GetFMUstate", "fmi3GetFMUState", "x x x x x x", |c| {
        c.free(c.save());
        OK
    }),
    ("fmi2SetFMUstate", "fmi3SetFMUState", "x x x x x x", |c| {
        let state = c.save();
        let status = c.set_state(state);
        c.free(state);
        status
    }),
    ("fmi2FreeFMUstate", "fmi3FreeFMUState", "x x x x x x", |c| c.free_state(&mut c.save())),
    ("fmi2SerializeFMUstate", "fmi3SerializeFMUState", "x x x x x x", |c| {
        c.bytes();
        OK
    }),
    ("fmi2DeSerializeFMUstate", "fmi3DeserializeFMUState", "x x x x x x", |c| c.restore(&c.bytes())),
    ("fmi2GetRealOutputDerivatives", "fmi3GetOutputDerivatives", "- - - x x x", |c| {
        c.try_derivative("agent[0].Omega", 1).0
    }),
];

const OF_V2: [(&str, &str, Call); 11] = [
    ("fmi2SetupExperiment", "x x - - - -", |c| c.set_up(Some(1e-6), 0.5, Some(2.0))),
    ("fmi2EnterInitializationMode", "x - - - - -", |c| {
        // It must have a start time; elsewhere that is refused before it.
        if state_of(c) == Instantiated {
            c.must(c.set_up(None, 0.0, None));
        }
        unsafe { (c.v2().fmi2EnterInitializationMode)(c.raw) }
    }),
    ("fmi2SetRealInputDerivatives", "x - x x - -", |c| {
        c.set_input_derivatives(&[c.model.reference("agent[1].Fp.y")], &[1], &[2.0])
    }),
    ("fmi2DoStep", "- - - x - -", |c| c.try_step(0.0, STEP)),
    ("fmi2CancelStep", "- - - - - -", |c| unsafe { (c.v2().fmi2CancelStep)(c.raw) }),
    ("fmi2GetDirectionalDerivative", "- - x x x x", |c| unsafe {
        (c.v2().fmi2GetDirectionalDerivative)(c.raw, null(), 0, null(), 0, null(), null_mut())
    }),
    ("fmi2GetStatus", "- - - x x -", |c| unsafe { (c.v2().fmi2GetStatus)(c.raw, 0, &mut 0) }),
    ("fmi2GetRealStatus", "- - - x x -", |c| unsafe { (c.v2().fmi2GetRealStatus)(c.raw, 2, &mut 0.0) }),
    ("fmi2GetIntegerStatus", "- - - x x -", |c| unsafe { (c.v2().fmi2GetIntegerStatus)(c.raw, 0, &mut 0) }),
    ("fmi2GetBooleanStatus", "- - - x x -", |c| unsafe { (c.v2().fmi2GetBooleanStatus)(c.raw, 3, &mut 0) }),
    ("fmi2GetStringStatus", "- - - x x -", |c| unsafe {
        (c.v2().fmi2GetStringStatus)(c.raw, 1, &mut null())
    }),
];

const OF_V3: [(&str, &str, Call); 8] = [
    ("fmi3EnterConfigurationMode", "x - - - - -", |c| c.enter_configuration()),
    ("fmi3ExitConfigurationMode", "- x - - - -", |c| c.exit_configuration()),
    ("fmi3EnterInitializationMode", "x - - - - -", |c| c.enter(Some(1e-6), 0.5, Some(2.0))),
    ("fmi3GetUInt64", "x x x x x x", |c| c.get_size(&[c.model.reference("Agents")], 1).0),
    ("fmi3SetUInt64", "- x - - - -", |c| c.set_size(&[c.model.reference("Agents")], &[AGENTS as u64])),
    ("fmi3GetNumberOfVariableDependencies", "x x x x x x", |c| unsafe {
        let reference = c.model.reference("agent[0].Omega");
        (c.v3().fmi3GetNumberOfVariableDependencies)(c.raw, reference, &mut 0)
    }),
    ("fmi3GetVariableDependencies", "x x x x x x", |c| unsafe {
        let (none, reference) = (null_mut(), c.model.reference("agent[0].Omega"));
        (c.v3().fmi3GetVariableDependencies)(c.raw, reference, none, null_mut(), none, null_mut(), 0)
    }),
    ("fmi3DoStep", "- - - x - -", |c| c.try_step(0.0, STEP)),
];

fn table(version: Version) -> Vec<(&'static str, &'static str, Call)> {
    let common = COMMON.iter().map(|(v2, v3, states, call)| {
        let name = if version == V2 { v2 } else { v3 };
        (*name, *states, *call)
    });
    common.chain(if version == V2 { OF_V2.to_vec() } else { OF_V3.to_vec() }).collect()
}

/// Returns where a function leads: FMI's own transitions. All other functions stay.
fn leads_to(name: &str, state: State) -> State {
    match &name[4..] {
        "EnterConfigurationMode" => Configuration,
        "EnterInitializationMode" => Initialization,
        "ExitInitializationMode" => StepComplete,
        "Terminate" => Terminated,
        "Reset" | "ExitConfigurationMode" => Instantiated,
        _ => state,
    }
}

#[test]
fn functions_are_allowed_where_the_standard_allows_them() {
    for version in BOTH {
        for (name, cells, call) in table(version) {
            for state in states(version) {
                let crowd = reach(version, state);
                let before = crowd.bytes();
                let status = call(&crowd);
                let log = crowd.take_messages();
                let case = format!("{name} in {state:?}: {status:?}, {log:?}");
                let cell = cells.split(' ').nth(state as usize);
                if cell == Some("x") || cell == Some("3") && version == V3 {
                    if name == "fmi2GetDirectionalDerivative" {
                        assert!(log[0].text.contains("providesDirectionalDerivative"), "{case}");
                    } else if name.ends_with("Status") {
                        assert!(status == OK || status == DISCARD, "{case}");
                    } else {
                        assert_eq!(status, OK, "{case}");
                    }
                    assert_eq!(state_of(&crowd), leads_to(name, state), "{case}");
                } else {
                    assert_eq!(status, ERROR, "{case}");
                    let [message] = &*log else { panic!("{case}") };
                    assert!(message.text.starts_with(&format!("{name}: ")), "{case}");
                    assert!(crowd.bytes() == before, "{case} has changed something");
                }
            }
        }
    }
}

/// FMI 3.0 has no state of errors: after a step that failed it is terminated. What is only refused changes nothing.
#[test]
fn a_failed_step_terminates_and_a_refused_value_does_not() {
    let crowd = Crowd::new(V3);
    assert_eq!(crowd.set("agent[0].Mass", -1.0), DISCARD);
    crowd.must(crowd.set_all(&[("TimeStepMechanical", 1e-4), ("agent[0].Mass", 1e-300)]));
    crowd.take_messages();
    crowd.must(crowd.set("agent[0].Fp.x", 1e300));
    crowd.initialize();
    assert_eq!(state_of(&crowd), StepComplete);
    let failed = crowd.do_step(0.0, STEP);
    assert_eq!((failed.status, failed.early, failed.time), (ERROR, false, 0.0));
    assert_eq!(state_of(&crowd), Terminated);
    crowd.take_messages();
    assert!(crowd.refused(crowd.try_step(0.0, STEP)).contains("Terminated"));
    crowd.reset();
    crowd.initialize();
    crowd.must(crowd.try_step(0.0, STEP));
}

/// FMI 3.0, section 2.3.2: start values can be read at once, and as they were set; nothing else can.
#[test]
fn start_values_are_read_before_initialization_begins() {
    let crowd = Crowd::new(V3);
    crowd.must(crowd.set("agent[1].Mass", 81.5));
    assert_eq!(crowd.values("Mass")[..2], [89.0, 81.5]);
    assert_eq!((crowd.values("Position")[2], crowd.text("Trial")), (0.279, "Trial_push".to_owned()));
    for name in ["NormalForce", "LargestOverlap", "time"] {
        let place = crowd.model.reference(name);
        let message =
            crowd.refused(crowd.get_real(&[place], if name == "NormalForce" { AGENTS } else { 1 }).0);
        assert!(message.contains(name) && message.contains("no start value"), "{message}");
    }
    let ids = crowd.get_string(&[crowd.model.reference("AgentId")], AGENTS).0;
    assert!(crowd.refused(ids).contains("no start value"));
}

/// Functions that take an instance and return a status are in the table or not offered; the rest is for instances.
#[test]
fn every_function_is_in_a_table_or_is_not_offered() {
    let crowd = Crowd::pushed(V3);
    for probe in fmi3::Functions::probes() {
        if table(V3).iter().any(|(name, ..)| *name == probe.name) {
            continue;
        }
        if probe.name.ends_with("SerializedFMUStateSize") {
            continue;
        }
        let message = crowd.refused(probe.call(crowd.v3(), crowd.raw, None).unwrap());
        let messages =
            ["without events and clocks", "no variable of type", "Derivatives are false", "no variable"];
        assert!(messages.iter().any(|words| message.contains(words)), "{message}");
    }
    crowd.steps(0, 1);
    let known: Vec<&str> = table(V2).iter().map(|(name, ..)| *name).collect();
    let rest: Vec<&str> =
        fmi2::Functions::NAMES.iter().copied().filter(|name| !known.contains(name)).collect();
    assert_eq!((fmi2::Functions::NAMES.len(), fmi3::Functions::NAMES.len()), (34, 75));
    assert_eq!(
        rest,
        ["GetTypesPlatform", "GetVersion", "Instantiate", "FreeInstance", "SerializedFMUstateSize"]
            .map(|name| format!("fmi2{name}"))
    );
    let (c, c3) = (Crowd::new(V2), crowd.v3());
    let text = |text| unsafe { CStr::from_ptr(text) };
    unsafe {
        assert_eq!((text((c.v2().fmi2GetVersion)()), text((c3.fmi3GetVersion)())), (c"2.0", c"3.0"));
        assert_eq!(text((c.v2().fmi2GetTypesPlatform)()), c"default");
        let (name, none) = (c"crowd".as_ptr(), null_mut());
        assert!((c3.fmi3InstantiateModelExchange)(name, null(), null(), false, false, none, None).is_null());
    }
}

#[test]
fn no_instance_is_an_error() {
    let (v2, v3) = (Crowd::new(V2), Crowd::new(V3));
    for probe in fmi2::Functions::probes() {
        assert_eq!(probe.call(v2.v2(), null_mut(), None), Some(ERROR), "{}", probe.name);
    }
    for probe in fmi3::Functions::probes() {
        assert_eq!(probe.call(v3.v3(), null_mut(), None), Some(ERROR), "{}", probe.name);
    }
    unsafe {
        (v2.v2().fmi2FreeInstance)(null_mut());
        (v3.v3().fmi3FreeInstance)(null_mut());
    }
}

/// Pointers that an importer need not give: flags of a step of FMI 3.0. Nothing to free is no error.
fn may_be_null(name: &str) -> bool {
    name == "fmi3DoStep" || name.ends_with("FreeFMUstate") || name.ends_with("FreeFMUState")
}

#[test]
fn null_arguments_are_refused_in_words_in_every_state() {
    for version in BOTH {
        for state in states(version) {
            let crowd = reach(version, state);
            let before = crowd.bytes();
            let mut named = 0;
            let mut check = |name: &str, place: usize, status: Option<Status>| {
                if may_be_null(name) {
                    crowd.take_messages();
                    return;
                }
                let message = crowd.refused(status.unwrap());
                assert!(message.starts_with(&format!("{name}: ")), "pointer {place} in {state:?}: {message}");
                assert!(
                    crowd.bytes() == before,
                    "{name}, pointer {place} in {state:?} has changed something"
                );
                named += usize::from(message.contains("is NULL"));
            };
            for probe in fmi2::Functions::probes().into_iter().filter(|_| version == V2) {
                for null in 0..probe.pointers {
                    check(probe.name, null, probe.call(crowd.v2(), crowd.raw, Some(null)));
                }
            }
            for probe in fmi3::Functions::probes().into_iter().filter(|_| version == V3) {
                for null in 0..probe.pointers {
                    check(probe.name, null, probe.call(crowd.v3(), crowd.raw, Some(null)));
                }
            }
            // The others are wrong in another way too, which is told first.
            assert!(named >= 10, "{version:?} {state:?}: {named}");
        }
    }
}

#[test]
fn no_elements_need_no_array() {
    for version in BOTH {
        let crowd = Crowd::pushed(version);
        crowd.nulls.set(!0);
        crowd.must(crowd.debug_logging(false, &[]));
        let got = [crowd.get_real(&[], 0).0, crowd.get_integer(&[], 0).0, crowd.get_boolean(&[], 0).0];
        assert_eq!((got, crowd.get_string(&[], 0).0), ([OK; 3], OK));
        let set = [crowd.set_real(&[], &[]), crowd.set_integer(&[], &[]), crowd.set_boolean(&[], &[])];
        assert_eq!((set, crowd.set_string(&[], &[])), ([OK; 3], OK));
        crowd.must(crowd.free_state(&mut null_mut()));
        crowd.nulls.set(0);
        crowd.must(crowd.free_state(&mut null_mut()));
        crowd.steps(0, 1);
    }
}

/// FMI 2.0: it "must be called at least once" before initialization, so that there is a start time.
#[test]
fn initialization_needs_an_experiment() {
    let crowd = Crowd::new(V2);
    let enter = || unsafe { (crowd.v2().fmi2EnterInitializationMode)(crowd.raw) };
    assert!(crowd.refused(enter()).contains("fmi2SetupExperiment"));
    assert_eq!(state_of(&crowd), Instantiated);
    crowd.initialize();
    crowd.reset();
    assert!(crowd.refused(enter()).contains("fmi2SetupExperiment"), "a reset forgets it");
}

#[test]
fn reset_leads_back_to_the_state_after_instantiation() {
    for version in BOTH {
        for state in states(version) {
            let fresh = Crowd::new(version);
            let crowd = reach(version, state);
            crowd.reset();
            assert!(crowd.bytes() == fresh.bytes(), "{state:?}");
            for crowd in [&fresh, &crowd] {
                crowd.push_and_initialize();
                crowd.steps(0, 12);
            }
            assert_eq!(crowd.everything(), fresh.everything(), "{state:?}");
        }
    }
}

#[test]
fn statuses_of_a_synchronous_slave() {
    const LAST_SUCCESSFUL_TIME: i32 = 2;
    const TERMINATED: i32 = 3;
    let crowd = Crowd::pushed(V2);
    crowd.steps(0, 2);
    let (c, i) = (crowd.v2(), crowd.raw);
    let (mut real, mut boolean) = (f64::NAN, 7);
    let discarded = |status: Status| {
        let log = crowd.take_messages();
        assert!(status == DISCARD && log.len() == 1 && log[0].status == DISCARD, "{status:?} {log:?}");
    };
    unsafe {
        crowd.must((c.fmi2GetRealStatus)(i, LAST_SUCCESSFUL_TIME, &mut real));
        crowd.must((c.fmi2GetBooleanStatus)(i, TERMINATED, &mut boolean));
        assert_eq!((real, boolean), (2.0 * STEP, 0));
        // About pending steps, or of another type.
        discarded((c.fmi2GetStatus)(i, 0, &mut 0));
        discarded((c.fmi2GetStringStatus)(i, 1, &mut null()));
        discarded((c.fmi2GetIntegerStatus)(i, 0, &mut 0));
        for kind in [0, 1, TERMINATED, -1, 99] {
            discarded((c.fmi2GetRealStatus)(i, kind, &mut real));
        }
        for kind in [0, 1, LAST_SUCCESSFUL_TIME, -1, 99] {
            discarded((c.fmi2GetBooleanStatus)(i, kind, &mut boolean));
        }
    }
    assert_eq!((real, boolean), (2.0 * STEP, 0), "a value that is not returned is not written");
    crowd.steps(2, 3);
}
