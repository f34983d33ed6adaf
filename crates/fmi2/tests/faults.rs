//! A model that panics: the host is told in words, and the instance answers nothing but fmi2FreeInstance.
//! FMI's state "fatal", the column of section 4.2.4 that no call of a sound model reaches.

#![allow(unsafe_code)] // calls the bodies of the C functions

use lemons_fmi2::component::*;
use lemons_fmi2::lifecycle::Phase;
use lemons_fmi2::variables::{Domain, Kind, Role, Variable, guid, units};
use lemons_fmi2::{Model, Status, StepError};
use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::ptr::{null, null_mut};
use std::sync::Mutex;

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

    fn load(location: &str) -> Result<Brittle, Never> {
        assert!(location != "broken", "no such place");
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

    fn set_real(&mut self, _: u32, (): (), value: f64, _: Phase) {
        self.x = value;
    }

    fn set_integer(&mut self, (): (), _: i32) {}

    fn set_strings(&mut self, _: &[((), &str)]) -> Result<(), Never> {
        Ok(())
    }

    fn initialize(&mut self) -> Result<(), Never> {
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

type Log = Mutex<Vec<(Status, String)>>;

/// All messages come as one text for "%s": a callee of six fixed pointers finds it where a variadic one
/// would, by the C calling conventions of x86_64 and aarch64.
unsafe extern "C" fn log(
    environment: *mut c_void,
    _: *const c_char,
    status: Status,
    _: *const c_char,
    _: *const c_char,
    text: *const c_char,
) {
    let (log, text) = unsafe { (&*environment.cast::<Log>(), CStr::from_ptr(text)) };
    log.lock().unwrap().push((status, text.to_string_lossy().into_owned()));
}

fn instantiate_at(location: &CStr, log_to: &Log) -> *mut c_void {
    let callbacks = CallbackFunctions {
        // SAFETY: see `log`.
        logger: Some(unsafe {
            std::mem::transmute::<
                unsafe extern "C" fn(
                    *mut c_void,
                    *const c_char,
                    Status,
                    *const c_char,
                    *const c_char,
                    *const c_char,
                ),
                unsafe extern "C" fn(*mut c_void, *const c_char, Status, *const c_char, *const c_char, ...),
            >(log)
        }),
        allocate_memory: null(),
        free_memory: null(),
        step_finished: null(),
        component_environment: std::ptr::from_ref(log_to).cast_mut().cast(),
    };
    let guid = CString::new(guid(&Brittle { x: 0.0 }.table()).braced().to_string()).unwrap();
    unsafe {
        instantiate::<Brittle>(c"brittle".as_ptr(), 1, guid.as_ptr(), location.as_ptr(), &callbacks, 0, 0)
    }
}

type M = Brittle;
type Call = unsafe fn(*mut c_void) -> Status;

/// Every function that takes an instance and answers a status, with arguments that are right elsewhere.
const CALLS: [(&str, Call); 31] = {
    static VALUE: f64 = 1.0;
    static REFERENCE: u32 = 0;
    static ORDER: c_int = 1;
    [
        ("SetDebugLogging", |i| unsafe { set_debug_logging::<M>(i, 1, 0, null()) }),
        ("SetupExperiment", |i| unsafe { setup_experiment::<M>(i, 0, 0.0, 0.0, 0, 0.0) }),
        ("EnterInitializationMode", |i| unsafe { enter_initialization_mode::<M>(i) }),
        ("ExitInitializationMode", |i| unsafe { exit_initialization_mode::<M>(i) }),
        ("Terminate", |i| unsafe { terminate::<M>(i) }),
        ("Reset", |i| unsafe { reset::<M>(i) }),
        ("GetReal", |i| unsafe { get_real::<M>(i, &REFERENCE, 1, &mut 0.0) }),
        ("GetInteger", |i| unsafe { get_integer::<M>(i, null(), 0, null_mut()) }),
        ("GetBoolean", |i| unsafe { get_boolean::<M>(i, null(), 0, null_mut()) }),
        ("GetString", |i| unsafe { get_string::<M>(i, null(), 0, null_mut()) }),
        ("SetReal", |i| unsafe { set_real::<M>(i, &REFERENCE, 1, &VALUE) }),
        ("SetInteger", |i| unsafe { set_integer::<M>(i, null(), 0, null()) }),
        ("SetBoolean", |i| unsafe { set_boolean::<M>(i, null(), 0, null()) }),
        ("SetString", |i| unsafe { set_string::<M>(i, null(), 0, null()) }),
        ("GetFMUstate", |i| unsafe { get_fmu_state::<M>(i, &mut null_mut()) }),
        ("SetFMUstate", |i| unsafe { set_fmu_state::<M>(i, null_mut()) }),
        ("FreeFMUstate", |i| unsafe { free_fmu_state::<M>(i, &mut null_mut()) }),
        ("SerializedFMUstateSize", |i| unsafe { serialized_fmu_state_size::<M>(i, null_mut(), &mut 0) }),
        ("SerializeFMUstate", |i| unsafe { serialize_fmu_state::<M>(i, null_mut(), null_mut(), 0) }),
        ("DeSerializeFMUstate", |i| unsafe { deserialize_fmu_state::<M>(i, null(), 0, &mut null_mut()) }),
        ("GetDirectionalDerivative", |i| unsafe {
            get_directional_derivative::<M>(i, null(), 0, null(), 0, null(), null_mut())
        }),
        ("SetRealInputDerivatives", |i| unsafe {
            set_real_input_derivatives::<M>(i, &REFERENCE, 1, &ORDER, &VALUE)
        }),
        ("GetRealOutputDerivatives", |i| unsafe {
            get_real_output_derivatives::<M>(i, null(), 0, null(), null_mut())
        }),
        ("DoStep", |i| unsafe { do_step::<M>(i, 0.0, 1.0, 1) }),
        ("CancelStep", |i| unsafe { cancel_step::<M>(i) }),
        ("GetStatus", |i| unsafe { get_status::<M>(i, 0, &mut 0) }),
        ("GetRealStatus", |i| unsafe { get_real_status::<M>(i, 2, &mut 0.0) }),
        ("GetIntegerStatus", |i| unsafe { get_integer_status::<M>(i, 0, &mut 0) }),
        ("GetBooleanStatus", |i| unsafe { get_boolean_status::<M>(i, 3, &mut 0) }),
        ("GetStringStatus", |i| unsafe { get_string_status::<M>(i, 1, &mut null()) }),
        ("DoStep again", |i| unsafe { do_step::<M>(i, 0.0, 1.0, 1) }),
    ]
};

#[test]
fn a_panic_is_fatal_and_told_and_the_instance_can_be_freed() {
    let told = Log::default();
    let instance = instantiate_at(c"sound", &told);
    assert!(!instance.is_null());
    let ok = |status| assert_eq!(status, Status::Ok, "{:?}", told.lock().unwrap());
    unsafe {
        ok(setup_experiment::<M>(instance, 0, 0.0, 0.0, 0, 0.0));
        ok(enter_initialization_mode::<M>(instance));
        ok(exit_initialization_mode::<M>(instance));
        ok(do_step::<M>(instance, 0.0, 1.0, 1));
        ok(set_real::<M>(instance, &0, 1, &13.0));
        assert_eq!(do_step::<M>(instance, 1.0, 1.0, 1), Status::Fatal);
    }
    let messages = std::mem::take(&mut *told.lock().unwrap());
    let [(Status::Fatal, message)] = &*messages else { panic!("{messages:?}") };
    assert!(message.contains("fmi2DoStep") && message.contains("x is 13"), "{message}");
    for (name, call) in CALLS {
        assert_eq!(unsafe { call(instance) }, Status::Fatal, "{name}");
        let messages = std::mem::take(&mut *told.lock().unwrap());
        let [(Status::Fatal, message)] = &*messages else { panic!("{name}: {messages:?}") };
        assert!(message.contains(name.trim_end_matches(" again")), "{message}");
    }
    unsafe { free_instance::<M>(instance) };
    assert!(told.lock().unwrap().is_empty());
}

#[test]
fn a_panic_while_instantiating_gives_no_instance_and_words() {
    let told = Log::default();
    assert!(instantiate_at(c"broken", &told).is_null());
    let messages = told.lock().unwrap();
    let [(Status::Fatal, message)] = &**messages else { panic!("{messages:?}") };
    assert!(message.contains("fmi2Instantiate") && message.contains("no such place"), "{message}");
}

#[test]
fn an_instance_of_another_thread_is_not_touched_by_a_fault() {
    let (told, others) = (Log::default(), Log::default());
    let (broken, sound) = (instantiate_at(c"sound", &told), instantiate_at(c"sound", &others));
    unsafe {
        for instance in [broken, sound] {
            setup_experiment::<M>(instance, 0, 0.0, 0.0, 0, 0.0);
            enter_initialization_mode::<M>(instance);
            exit_initialization_mode::<M>(instance);
        }
        set_real::<M>(broken, &0, 1, &13.0);
        assert_eq!(do_step::<M>(broken, 0.0, 1.0, 1), Status::Fatal);
        assert_eq!(do_step::<M>(sound, 0.0, 1.0, 1), Status::Ok);
        free_instance::<M>(broken);
        free_instance::<M>(sound);
    }
    assert!(others.lock().unwrap().is_empty());
}
