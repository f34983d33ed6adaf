//! A model that panics: the host is told in words, and the instance refuses all calls but fmi2FreeInstance.
//! FMI's state "fatal", the column of section 4.2.4 that no call of a sound model reaches.

#![allow(unsafe_code)] // calls the C functions

use lemons_fmi::location::Location;
use lemons_fmi::v2::guid;
use lemons_fmi::variables::{Domain, Kind, Role, Variable, units};
use lemons_fmi::{Model, Phase, StepError};
use lemons_testing::fmi2::{FATAL, Functions, Log, Message, OK};
use std::ffi::{CStr, CString, c_int, c_void};
use std::ptr::{null, null_mut};

/// Its one variable is an input; at 13 it breaks.
struct Brittle {
    x: f64,
}

#[derive(Debug)]
struct Never;

impl std::fmt::Display for Never {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("never")
    }
}

impl std::error::Error for Never {}

impl Model for Brittle {
    type Quantity = ();
    type Saved = f64;
    type Error = Never;

    const INTERPOLATES_INPUTS: bool = false;
    const STATE_VERSION: u32 = 1;

    fn load(location: Location<'_>) -> Result<Brittle, Never> {
        assert!(location.text() != "broken", "no such place");
        Ok(Brittle { x: 0.0 })
    }

    fn table(&self) -> Vec<Variable<()>> {
        vec![Variable {
            name: "x".into(),
            quantity: (),
            kind: Kind::Real(units::ONE),
            role: Role::Input,
            domain: Domain::Finite,
            description: String::new(),
        }]
    }

    fn take_warnings(&mut self) -> Vec<String> {
        Vec::new()
    }

    fn real(&mut self, (): ()) -> Result<f64, Never> {
        Ok(self.x)
    }

    fn integer(&mut self, (): ()) -> Result<i32, Never> {
        unreachable!()
    }

    fn string(&self, (): ()) -> &str {
        unreachable!()
    }

    fn set_real(&mut self, (): (), value: f64, _: Phase) {
        self.x = value;
    }

    fn set_integer(&mut self, (): (), _: i32, _: Phase) {}

    fn set_strings(&mut self, _: &[((), &str)]) -> Result<(), Never> {
        Ok(())
    }

    fn initialize(&mut self, _: f64) -> Result<(), Never> {
        Ok(())
    }

    fn advance(&mut self, _: f64, _: f64) -> Result<(), StepError<Never>> {
        assert!(self.x != 13.0, "x is {}", self.x);
        Ok(())
    }

    fn reset(&mut self) -> Result<(), Never> {
        Ok(())
    }

    fn save(&self) -> f64 {
        self.x
    }

    fn restore(&mut self, saved: &f64) -> Result<(), Never> {
        self.x = *saved;
        Ok(())
    }
}

fn instantiate_at(c: &Functions, location: &CStr, log: &Log) -> *mut c_void {
    let guid = CString::new(guid(&Brittle { x: 0.0 }.table()).braced().to_string()).unwrap();
    let callbacks = log.callbacks();
    // SAFETY: texts that end with a zero; the log outlives the instance.
    unsafe { (c.fmi2Instantiate)(c"brittle".as_ptr(), 1, guid.as_ptr(), location.as_ptr(), &callbacks, 0, 0) }
}

type Call = unsafe fn(&Functions, *mut c_void) -> c_int;

/// Every function that takes an instance and returns a status, with arguments that are right elsewhere.
const CALLS: [(&str, Call); 31] = {
    static VALUE: f64 = 1.0;
    static REFERENCE: u32 = 0;
    static ORDER: c_int = 1;
    [
        ("SetDebugLogging", |c, i| unsafe { (c.fmi2SetDebugLogging)(i, 1, 0, null()) }),
        ("SetupExperiment", |c, i| unsafe { (c.fmi2SetupExperiment)(i, 0, 0.0, 0.0, 0, 0.0) }),
        ("EnterInitializationMode", |c, i| unsafe { (c.fmi2EnterInitializationMode)(i) }),
        ("ExitInitializationMode", |c, i| unsafe { (c.fmi2ExitInitializationMode)(i) }),
        ("Terminate", |c, i| unsafe { (c.fmi2Terminate)(i) }),
        ("Reset", |c, i| unsafe { (c.fmi2Reset)(i) }),
        ("GetReal", |c, i| unsafe { (c.fmi2GetReal)(i, &REFERENCE, 1, &mut 0.0) }),
        ("GetInteger", |c, i| unsafe { (c.fmi2GetInteger)(i, null(), 0, null_mut()) }),
        ("GetBoolean", |c, i| unsafe { (c.fmi2GetBoolean)(i, null(), 0, null_mut()) }),
        ("GetString", |c, i| unsafe { (c.fmi2GetString)(i, null(), 0, null_mut()) }),
        ("SetReal", |c, i| unsafe { (c.fmi2SetReal)(i, &REFERENCE, 1, &VALUE) }),
        ("SetInteger", |c, i| unsafe { (c.fmi2SetInteger)(i, null(), 0, null()) }),
        ("SetBoolean", |c, i| unsafe { (c.fmi2SetBoolean)(i, null(), 0, null()) }),
        ("SetString", |c, i| unsafe { (c.fmi2SetString)(i, null(), 0, null()) }),
        ("GetFMUstate", |c, i| unsafe { (c.fmi2GetFMUstate)(i, &mut null_mut()) }),
        ("SetFMUstate", |c, i| unsafe { (c.fmi2SetFMUstate)(i, null_mut()) }),
        ("FreeFMUstate", |c, i| unsafe { (c.fmi2FreeFMUstate)(i, &mut null_mut()) }),
        ("SerializedFMUstateSize", |c, i| unsafe { (c.fmi2SerializedFMUstateSize)(i, null_mut(), &mut 0) }),
        ("SerializeFMUstate", |c, i| unsafe { (c.fmi2SerializeFMUstate)(i, null_mut(), null_mut(), 0) }),
        ("DeSerializeFMUstate", |c, i| unsafe { (c.fmi2DeSerializeFMUstate)(i, null(), 0, &mut null_mut()) }),
        ("GetDirectionalDerivative", |c, i| unsafe {
            (c.fmi2GetDirectionalDerivative)(i, null(), 0, null(), 0, null(), null_mut())
        }),
        ("SetRealInputDerivatives", |c, i| unsafe {
            (c.fmi2SetRealInputDerivatives)(i, &REFERENCE, 1, &ORDER, &VALUE)
        }),
        ("GetRealOutputDerivatives", |c, i| unsafe {
            (c.fmi2GetRealOutputDerivatives)(i, null(), 0, null(), null_mut())
        }),
        ("DoStep", |c, i| unsafe { (c.fmi2DoStep)(i, 0.0, 1.0, 1) }),
        ("CancelStep", |c, i| unsafe { (c.fmi2CancelStep)(i) }),
        ("GetStatus", |c, i| unsafe { (c.fmi2GetStatus)(i, 0, &mut 0) }),
        ("GetRealStatus", |c, i| unsafe { (c.fmi2GetRealStatus)(i, 2, &mut 0.0) }),
        ("GetIntegerStatus", |c, i| unsafe { (c.fmi2GetIntegerStatus)(i, 0, &mut 0) }),
        ("GetBooleanStatus", |c, i| unsafe { (c.fmi2GetBooleanStatus)(i, 3, &mut 0) }),
        ("GetStringStatus", |c, i| unsafe { (c.fmi2GetStringStatus)(i, 1, &mut null()) }),
        ("DoStep again", |c, i| unsafe { (c.fmi2DoStep)(i, 0.0, 1.0, 1) }),
    ]
};

#[test]
fn a_panic_is_fatal_and_told_and_the_instance_can_be_freed() {
    let (c, told) = (Functions::of_model::<Brittle>(), Log::default());
    let instance = instantiate_at(&c, c"sound", &told);
    assert!(!instance.is_null());
    let ok = |status| assert_eq!(status, OK, "{:?}", told.take());
    unsafe {
        ok((c.fmi2SetupExperiment)(instance, 0, 0.0, 0.0, 0, 0.0));
        ok((c.fmi2EnterInitializationMode)(instance));
        ok((c.fmi2ExitInitializationMode)(instance));
        ok((c.fmi2DoStep)(instance, 0.0, 1.0, 1));
        ok((c.fmi2SetReal)(instance, &0, 1, &13.0));
        assert_eq!((c.fmi2DoStep)(instance, 1.0, 1.0, 1), FATAL);
    }
    let messages = told.take();
    let [Message { status: FATAL, text: message, .. }] = &*messages else { panic!("{messages:?}") };
    assert!(message.contains("fmi2DoStep") && message.contains("x is 13"), "{message}");
    for (name, call) in CALLS {
        assert_eq!(unsafe { call(&c, instance) }, FATAL, "{name}");
        let messages = told.take();
        let [Message { status: FATAL, text: message, .. }] = &*messages else {
            panic!("{name}: {messages:?}")
        };
        assert!(message.contains(name.trim_end_matches(" again")), "{message}");
    }
    unsafe { (c.fmi2FreeInstance)(instance) };
    assert!(told.take().is_empty());
}

#[test]
fn a_panic_while_instantiating_gives_no_instance_and_words() {
    let (c, told) = (Functions::of_model::<Brittle>(), Log::default());
    assert!(instantiate_at(&c, c"broken", &told).is_null());
    let messages = told.take();
    let [Message { status: FATAL, text: message, .. }] = &*messages else { panic!("{messages:?}") };
    assert!(message.contains("fmi2Instantiate") && message.contains("no such place"), "{message}");
}

#[test]
fn an_instance_of_another_thread_is_not_touched_by_a_fault() {
    let c = Functions::of_model::<Brittle>();
    let (told, others) = (Log::default(), Log::default());
    let (broken, sound) = (instantiate_at(&c, c"sound", &told), instantiate_at(&c, c"sound", &others));
    unsafe {
        for instance in [broken, sound] {
            (c.fmi2SetupExperiment)(instance, 0, 0.0, 0.0, 0, 0.0);
            (c.fmi2EnterInitializationMode)(instance);
            (c.fmi2ExitInitializationMode)(instance);
        }
        (c.fmi2SetReal)(broken, &0, 1, &13.0);
        assert_eq!((c.fmi2DoStep)(broken, 0.0, 1.0, 1), FATAL);
        assert_eq!((c.fmi2DoStep)(sound, 0.0, 1.0, 1), OK);
        (c.fmi2FreeInstance)(broken);
        (c.fmi2FreeInstance)(sound);
    }
    assert!(others.take().is_empty());
}
