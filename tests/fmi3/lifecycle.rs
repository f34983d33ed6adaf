//! In which states functions are allowed (FMI 3.0, section 4.2.1), as a table.

use crate::fmu::*;
use State::*;
use lemons_testing::fmi3::NAMES;
use std::ffi::c_int;
use std::ptr::{null, null_mut};

#[derive(Debug, Clone, Copy, PartialEq)]
enum State {
    Instantiated,
    Configuration,
    Initialization,
    StepComplete,
    Terminated,
}

const STATES: [State; 5] = [Instantiated, Configuration, Initialization, StepComplete, Terminated];

fn reach(state: State) -> Instance<'static> {
    let instance = Instance::new();
    match state {
        Instantiated => {}
        Configuration => instance.must(unsafe { (instance.c.fmi3EnterConfigurationMode)(instance.raw) }),
        Initialization => instance.enter_initialization(),
        StepComplete | Terminated => instance.initialize(),
    }
    if state == Terminated {
        instance.must(unsafe { (instance.c.fmi3Terminate)(instance.raw) });
    }
    instance
}

type Call = fn(&Instance) -> c_int;

/// Function, where it is allowed (in the order of [`STATES`]), and a call that is right there.
const TABLE: [(&str, &str, Call); 27] = [
    ("fmi3SetDebugLogging", "x x x x x", |i| unsafe { (i.c.fmi3SetDebugLogging)(i.raw, true, 0, null()) }),
    ("fmi3EnterConfigurationMode", "x - - - -", |i| unsafe { (i.c.fmi3EnterConfigurationMode)(i.raw) }),
    ("fmi3ExitConfigurationMode", "- x - - -", |i| unsafe { (i.c.fmi3ExitConfigurationMode)(i.raw) }),
    ("fmi3EnterInitializationMode", "x - - - -", |i| unsafe {
        (i.c.fmi3EnterInitializationMode)(i.raw, true, 1e-6, 0.5, true, 2.0)
    }),
    ("fmi3ExitInitializationMode", "- - x - -", |i| unsafe { (i.c.fmi3ExitInitializationMode)(i.raw) }),
    ("fmi3Terminate", "- - - x -", |i| unsafe { (i.c.fmi3Terminate)(i.raw) }),
    ("fmi3Reset", "x x x x x", |i| unsafe { (i.c.fmi3Reset)(i.raw) }),
    ("fmi3GetFloat64", "- x x x x", |i| i.try_get("Mass", AGENTS).0),
    ("fmi3GetInt32", "- x x x x", |i| unsafe {
        (i.c.fmi3GetInt32)(i.raw, &reference("Threads"), 1, &mut 0, 1)
    }),
    ("fmi3GetUInt64", "- x x x x", |i| unsafe {
        (i.c.fmi3GetUInt64)(i.raw, &reference("Agents"), 1, &mut 0, 1)
    }),
    ("fmi3GetString", "- x x x x", |i| unsafe {
        (i.c.fmi3GetString)(i.raw, &reference("Trial"), 1, &mut null(), 1)
    }),
    ("fmi3GetBoolean", "- x x x x", |i| unsafe { (i.c.fmi3GetBoolean)(i.raw, null(), 0, null_mut(), 0) }),
    ("fmi3SetFloat64", "x - x x -", |i| i.try_set("Mp", &[1.0; AGENTS])),
    ("fmi3SetInt32", "x - x - -", |i| i.try_set_integer("Threads", 1)),
    ("fmi3SetUInt64", "- x - - -", |i| i.try_set_size("Agents", AGENTS as u64)),
    ("fmi3SetString", "x - x - -", |i| i.try_set_text("OutputDirectory", "")),
    ("fmi3SetBoolean", "x x x x -", |i| unsafe { (i.c.fmi3SetBoolean)(i.raw, null(), 0, null(), 0) }),
    ("fmi3GetNumberOfVariableDependencies", "x x x x x", |i| unsafe {
        (i.c.fmi3GetNumberOfVariableDependencies)(i.raw, reference("Omega"), &mut 0)
    }),
    ("fmi3GetVariableDependencies", "x x x x x", |i| unsafe {
        let none = (null_mut(), null_mut(), null_mut(), null_mut());
        let get = i.c.fmi3GetVariableDependencies;
        get(i.raw, reference("Omega"), none.0, none.1, none.2, none.3, 0)
    }),
    ("fmi3GetFMUState", "x x x x x", |i| {
        i.free(i.save());
        OK
    }),
    ("fmi3SetFMUState", "x x x x x", |i| {
        let state = i.save();
        let status = unsafe { (i.c.fmi3SetFMUState)(i.raw, state) };
        i.free(state);
        status
    }),
    ("fmi3FreeFMUState", "x x x x x", |i| unsafe { (i.c.fmi3FreeFMUState)(i.raw, &mut i.save()) }),
    ("fmi3SerializedFMUStateSize", "x x x x x", |i| {
        let state = i.save();
        let status = unsafe { (i.c.fmi3SerializedFMUStateSize)(i.raw, state, &mut 0) };
        i.free(state);
        status
    }),
    ("fmi3SerializeFMUState", "x x x x x", |i| {
        i.bytes();
        OK
    }),
    ("fmi3DeserializeFMUState", "x x x x x", |i| i.restore(&i.bytes())),
    ("fmi3GetOutputDerivatives", "- - - x x", |i| unsafe {
        let (mut rates, get) = ([0.0; AGENTS], i.c.fmi3GetOutputDerivatives);
        get(i.raw, &reference("Omega"), 1, &1, rates.as_mut_ptr(), AGENTS)
    }),
    ("fmi3DoStep", "- - - x -", |i| i.try_step(0.0, STEP).0),
];

#[test]
fn functions_are_allowed_where_the_standard_allows_them() {
    for (name, states, call) in TABLE {
        assert!(NAMES.contains(&name), "{name}");
        for (state, cell) in STATES.into_iter().zip(states.split(' ')) {
            let instance = reach(state);
            let before = instance.bytes();
            let status = call(&instance);
            let said = instance.log.take();
            let case = format!("{name} in {state:?}: {status}, {said:?}");
            if cell == "x" {
                assert_eq!(status, OK, "{case}");
            } else {
                assert_eq!(status, ERROR, "{case}");
                assert!(said.len() == 1 && said[0].2.starts_with(&format!("{name}: ")), "{case}");
                assert!(instance.bytes() == before, "{case} has changed something");
            }
        }
    }
}

/// Functions of other kinds of FMUs, of events and clocks: they are there, and say that they are not offered.
#[test]
fn what_is_not_offered_says_so() {
    let instance = Instance::new();
    instance.initialize();
    let (c, i) = (instance.c, instance.raw);
    let statuses = unsafe {
        [
            (c.fmi3EnterEventMode)(i),
            (c.fmi3EnterStepMode)(i),
            (c.fmi3EnterContinuousTimeMode)(i),
            (c.fmi3EvaluateDiscreteStates)(i),
            {
                let (mut no, mut time) = ([false; 5], 0.0);
                let [a, b, d, e, f] = &mut no;
                (c.fmi3UpdateDiscreteStates)(i, a, b, d, e, f, &mut time)
            },
            (c.fmi3CompletedIntegratorStep)(i, true, &mut false, &mut false),
            (c.fmi3GetIntervalDecimal)(i, &0, 1, &mut 0.0, &mut 0),
            (c.fmi3GetShiftFraction)(i, &0, 1, &mut 0, &mut 0),
            (c.fmi3SetIntervalDecimal)(i, &0, 1, &1.0),
            (c.fmi3GetClock)(i, &0, 1, &mut false),
            (c.fmi3SetClock)(i, &0, 1, &true),
            (c.fmi3SetTime)(i, 1.0),
            (c.fmi3GetNumberOfContinuousStates)(i, &mut 0),
            (c.fmi3GetNumberOfEventIndicators)(i, &mut 0),
            (c.fmi3ActivateModelPartition)(i, 0, 0.0),
            (c.fmi3GetDirectionalDerivative)(i, null(), 0, null(), 0, null(), 0, null_mut(), 0),
            (c.fmi3GetAdjointDerivative)(i, null(), 0, null(), 0, null(), 0, null_mut(), 0),
        ]
    };
    let said = instance.log.take();
    assert!(statuses.iter().all(|status| *status == ERROR) && said.len() == statuses.len(), "{said:?}");
    instance.steps(0, 1);
    let none = unsafe {
        (c.fmi3InstantiateModelExchange)(c"crowd".as_ptr(), null(), null(), false, false, null_mut(), None)
    };
    assert!(none.is_null());
}

#[test]
fn reset_leads_back_from_each_state() {
    let pristine = Instance::new().bytes();
    for state in STATES {
        let instance = reach(state);
        if state == StepComplete {
            instance.push();
            instance.steps(0, 2);
        }
        instance.must(unsafe { (instance.c.fmi3Reset)(instance.raw) });
        assert!(instance.bytes() == pristine, "{state:?}");
        instance.initialize();
        instance.steps(0, 1);
    }
}

#[test]
fn types_that_no_variable_has_are_refused() {
    let instance = Instance::new();
    instance.enter_initialization();
    let (c, i, mass) = (instance.c, instance.raw, &reference("Mass"));
    let (mut bytes, mut size) = ([0_u64; 1], 0);
    let at = bytes.as_mut_ptr();
    let statuses = unsafe {
        [
            ("Float32", (c.fmi3GetFloat32)(i, mass, 1, at.cast(), 1)),
            ("Int8", (c.fmi3GetInt8)(i, mass, 1, at.cast(), 1)),
            ("UInt8", (c.fmi3GetUInt8)(i, mass, 1, at.cast(), 1)),
            ("Int16", (c.fmi3GetInt16)(i, mass, 1, at.cast(), 1)),
            ("UInt16", (c.fmi3GetUInt16)(i, mass, 1, at.cast(), 1)),
            ("Int32", (c.fmi3GetInt32)(i, mass, 1, at.cast(), 1)),
            ("UInt32", (c.fmi3GetUInt32)(i, mass, 1, at.cast(), 1)),
            ("Int64", (c.fmi3GetInt64)(i, mass, 1, at.cast(), 1)),
            ("UInt64", (c.fmi3GetUInt64)(i, mass, 1, at, 1)),
            ("Boolean", (c.fmi3GetBoolean)(i, mass, 1, at.cast(), 1)),
            ("String", (c.fmi3GetString)(i, mass, 1, at.cast(), 1)),
            ("Binary", (c.fmi3GetBinary)(i, mass, 1, &mut size, at.cast(), 1)),
            ("Clock", (c.fmi3GetClock)(i, mass, 1, at.cast())),
            ("Float64", (c.fmi3GetFloat64)(i, &reference("Threads"), 1, at.cast(), 1)),
            ("Float32", (c.fmi3SetFloat32)(i, mass, 1, at.cast(), 1)),
            ("Int64", (c.fmi3SetInt64)(i, mass, 1, at.cast(), 1)),
            ("Boolean", (c.fmi3SetBoolean)(i, mass, 1, at.cast(), 1)),
            ("UInt64", (c.fmi3SetUInt64)(i, mass, 1, at, 1)),
            ("Int32", (c.fmi3SetInt32)(i, mass, 1, at.cast(), 1)),
        ]
    };
    let said = instance.log.take();
    assert_eq!(said.len(), statuses.len());
    for ((kind, status), (_, _, text)) in statuses.into_iter().zip(said) {
        assert_eq!(status, ERROR, "{kind}");
        assert!(text.contains(&format!("no variable of type {kind} has the value reference")), "{text}");
    }
    assert_eq!((bytes, size), ([0], 0), "nothing is written");
}

#[test]
fn what_cannot_be_instantiated_says_why() {
    let path = Resources::shared().path();
    let Err(message) = Instance::with(Fmu::get(), "{1}", path, None, false) else { panic!("made") };
    assert!(message.contains("instantiationToken"), "{message}");
    let token = lemons_fmi::v3::token::<crowd_mechanics::model::CrowdModel>().to_string();
    let nowhere = std::path::Path::new("/no/such/place");
    let Err(message) = Instance::with(Fmu::get(), &token, nowhere, None, false) else { panic!("made") };
    assert!(message.contains("/no/such/place"), "{message}");
}

#[test]
fn no_instance_is_an_error() {
    let c = &Fmu::get().c;
    unsafe {
        assert_eq!((c.fmi3Reset)(null_mut()), ERROR);
        assert_eq!((c.fmi3GetFloat64)(null_mut(), null(), 0, null_mut(), 0), ERROR);
        let (mut no, mut time) = (true, 0.0);
        let places = (&raw mut no, &raw mut time);
        assert_eq!((c.fmi3DoStep)(null_mut(), 0.0, 1.0, true, places.0, places.0, places.0, places.1), ERROR);
        (c.fmi3FreeInstance)(null_mut());
    }
}
