//! An instance of FMI 2.0 or 3.0 as an importer holds it: the same calls for both versions, and its messages.
//!
//! Arrays are as long as said. [`TestInstance::nulls`] leaves out pointers of the calls that follow.

#![allow(clippy::not_unsafe_ptr_arg_deref)] // states are given as the importer holds them

use crate::testing::functions::{fmi2, fmi3};
use crate::v2::CallbackFunctions;
use crate::{Model, Status, Version};
use libloading::Library;
use std::cell::{Cell, RefCell};
use std::ffi::{CStr, c_char, c_int, c_void};
use std::path::Path;
use std::ptr::{null, null_mut};
use std::sync::{Mutex, PoisonError};

impl Version {
    /// Both.
    pub const BOTH: [Version; 2] = [Version::V2, Version::V3];

    /// Returns what an importer says of a directory of resources.
    pub fn location(self, path: &Path) -> String {
        match self {
            Version::V2 => format!("file://{}", path.display()),
            Version::V3 => path.display().to_string(),
        }
    }
}

/// The C functions of a version.
#[derive(Clone)]
#[allow(missing_docs)]
pub enum VersionFunctions {
    V2(Box<fmi2::Functions>),
    V3(Box<fmi3::Functions>),
}

impl VersionFunctions {
    /// Those of a shared library, which must stay loaded while they are called.
    pub fn of(library: &Library, version: Version) -> VersionFunctions {
        match version {
            Version::V2 => VersionFunctions::V2(Box::new(fmi2::Functions::of(library))),
            Version::V3 => VersionFunctions::V3(Box::new(fmi3::Functions::of(library))),
        }
    }

    /// Those of a model, without a library.
    pub fn of_model<M: Model>(version: Version) -> VersionFunctions {
        match version {
            Version::V2 => VersionFunctions::V2(Box::new(fmi2::Functions::of_model::<M>())),
            Version::V3 => VersionFunctions::V3(Box::new(fmi3::Functions::of_model::<M>())),
        }
    }

    /// The version.
    pub fn version(&self) -> Version {
        match self {
            VersionFunctions::V2(_) => Version::V2,
            VersionFunctions::V3(_) => Version::V3,
        }
    }
}

/// A message to the importer.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LoggedMessage {
    /// Status.
    pub status: Status,
    /// Log category.
    pub category: String,
    /// Text.
    pub text: String,
}

/// Called within a step of FMI 3.0, at a time \[s\], and whether the step may end there: returns when it shall end.
pub type Update = dyn FnMut(f64, bool) -> Option<f64>;

/// Things that the callbacks of an instance know.
#[derive(Default)]
struct Environment {
    messages: Mutex<Vec<LoggedMessage>>,
    update: RefCell<Option<Box<Update>>>,
}

impl Environment {
    /// # Safety
    /// The environment is one of ours that lives, texts end with a zero.
    unsafe fn told(environment: *mut c_void, status: Status, category: *const c_char, text: *const c_char) {
        // SAFETY: as said above.
        let (environment, category, text) =
            unsafe { (&*environment.cast::<Environment>(), CStr::from_ptr(category), CStr::from_ptr(text)) };
        let string = |text: &CStr| text.to_str().expect("the logger gets UTF-8 text").to_owned();
        let message = LoggedMessage { status, category: string(category), text: string(text) };
        environment.messages.lock().unwrap_or_else(PoisonError::into_inner).push(message);
    }
}

/// The standard's logger has variable arguments, which stable Rust cannot define. All calls of our libraries pass one
/// argument, the text for "%s". By the C calling conventions of Linux on x86_64 and aarch64, a call with variable
/// arguments puts six pointers where a function with six fixed pointers looks for them: in registers.
type Logger2 =
    unsafe extern "C" fn(*mut c_void, *const c_char, Status, *const c_char, *const c_char, *const c_char);

unsafe extern "C" fn log2(
    environment: *mut c_void,
    _instance: *const c_char,
    status: Status,
    category: *const c_char,
    format: *const c_char,
    text: *const c_char,
) {
    // SAFETY: the environment and the texts that the library was given or makes.
    unsafe {
        assert_eq!(CStr::from_ptr(format), c"%s");
        Environment::told(environment, status, category, text);
    }
}

unsafe extern "C" fn log3(
    environment: *mut c_void,
    status: Status,
    category: *const c_char,
    text: *const c_char,
) {
    // SAFETY: the environment and the texts that the library was given or makes.
    unsafe { Environment::told(environment, status, category, text) };
}

unsafe extern "C" fn update(
    environment: *mut c_void,
    time: f64,
    set_requested: bool,
    get_allowed: bool,
    finished: bool,
    can_return: bool,
    request: *mut bool,
    until: *mut f64,
) {
    assert!(time.is_finite() && !set_requested && get_allowed && finished);
    // SAFETY: the environment that the library was given.
    let environment = unsafe { &*environment.cast::<Environment>() };
    if let Some(update) = environment.update.borrow_mut().as_mut()
        && let Some(stop) = update(time, can_return)
    {
        // SAFETY: places of values.
        unsafe { (*request, *until) = (true, stop) };
    }
}

/// The arguments of `fmi2Instantiate` and `fmi3InstantiateCoSimulation`.
#[derive(Debug, Clone, Copy)]
#[allow(missing_docs)]
pub struct Arguments<'a> {
    pub name: Option<&'a CStr>,
    /// GUID or instantiation token.
    pub token: Option<&'a CStr>,
    /// URI or path of the resources.
    pub location: Option<&'a CStr>,
    pub logging_on: bool,
    /// `fmi2Type`
    pub fmu_type: c_int,
    /// `eventModeUsed` and what follows in FMI 3.0.
    pub event_mode: bool,
    pub early_return: bool,
    pub updates: bool,
}

impl<'a> Arguments<'a> {
    /// Returns those of an instance that a master makes.
    pub fn new(token: &'a CStr, location: &'a CStr) -> Arguments<'a> {
        Arguments {
            name: Some(c"crowd"),
            token: Some(token),
            location: Some(location),
            logging_on: true,
            fmu_type: fmi2::CO_SIMULATION,
            event_mode: false,
            early_return: false,
            updates: false,
        }
    }
}

/// Answer of a step.
#[derive(Debug, Clone, Copy, PartialEq)]
#[allow(missing_docs)]
pub struct Stepped {
    pub status: Status,
    /// True if it returned early; never in FMI 2.0.
    pub early: bool,
    /// \[s\] the time that was reached.
    pub time: f64,
}

/// An instance; freed when dropped.
pub struct TestInstance {
    /// Pointer that the functions take.
    pub raw: *mut c_void,
    /// The functions.
    pub functions: VersionFunctions,
    environment: Box<Environment>,
    /// Pointers of the next calls that are NULL, one bit each.
    pub nulls: Cell<u8>,
}

// SAFETY: FMI lets instances move between threads; callbacks stay on the thread that they were given on.
unsafe impl Send for TestInstance {}

impl Drop for TestInstance {
    fn drop(&mut self) {
        // SAFETY: given back once.
        match &self.functions {
            VersionFunctions::V2(c) => unsafe { (c.fmi2FreeInstance)(self.raw) },
            VersionFunctions::V3(c) => unsafe { (c.fmi3FreeInstance)(self.raw) },
        }
    }
}

/// A call that differs in the name of the function only.
macro_rules! call {
    ($self:ident, $v2:ident / $v3:ident $(, $argument:expr)*) => {
        // SAFETY: an instance, and arrays as long as said, or NULL.
        match &$self.functions {
            VersionFunctions::V2(c) => unsafe { (c.$v2)($self.raw $(, $argument)*) },
            VersionFunctions::V3(c) => unsafe { (c.$v3)($self.raw $(, $argument)*) },
        }
    };
}

/// A call on values, whose number FMI 3.0 also takes.
macro_rules! values {
    ($self:ident, $v2:ident / $v3:ident, $references:ident, $values:expr, $length:expr) => {{
        let (at, count) = ($self.or_null(0, $references.as_ptr()), $references.len());
        let (values, length) = ($values, $length);
        // SAFETY: an instance, and arrays as long as said, or NULL.
        match &$self.functions {
            VersionFunctions::V2(c) => {
                assert_eq!(count, length, "FMI 2.0 has a value for each reference");
                unsafe { (c.$v2)($self.raw, at, count, values) }
            }
            VersionFunctions::V3(c) => unsafe { (c.$v3)($self.raw, at, count, values, length) },
        }
    }};
}

mod values;

impl TestInstance {
    /// Makes an instance, or returns what was told.
    pub fn new(
        functions: &VersionFunctions,
        arguments: &Arguments<'_>,
    ) -> Result<TestInstance, Vec<LoggedMessage>> {
        let environment = Box::<Environment>::default();
        let at = std::ptr::from_ref(&*environment).cast_mut().cast();
        let text = |text: Option<&CStr>| text.map_or(null(), CStr::as_ptr);
        let Arguments { name, token, location, logging_on, .. } = *arguments;
        let (name, token, location) = (text(name), text(token), text(location));
        // SAFETY: texts that end in a zero, or NULL. Importers may keep the callbacks on the stack.
        let raw = unsafe {
            match functions {
                VersionFunctions::V2(c) => {
                    // The same arguments in the same places: see `Logger2`.
                    let logger = std::mem::transmute::<Logger2, crate::Logger2>(log2);
                    let callbacks = CallbackFunctions {
                        logger: Some(logger),
                        component_environment: at,
                        ..fmi2::NO_CALLBACKS
                    };
                    let kind = arguments.fmu_type;
                    (c.fmi2Instantiate)(name, kind, token, location, &callbacks, 0, logging_on.into())
                }
                VersionFunctions::V3(c) => (c.fmi3InstantiateCoSimulation)(
                    name,
                    token,
                    location,
                    false,
                    logging_on,
                    arguments.event_mode,
                    arguments.early_return,
                    null(),
                    0,
                    at,
                    Some(log3),
                    if arguments.updates { Some(update) } else { None },
                ),
            }
        };
        if raw.is_null() {
            return Err(environment.messages.into_inner().unwrap_or_else(PoisonError::into_inner));
        }
        Ok(TestInstance { raw, functions: functions.clone(), environment, nulls: Cell::new(0) })
    }

    /// The functions of FMI 2.0.
    pub fn v2(&self) -> &fmi2::Functions {
        let VersionFunctions::V2(c) = &self.functions else { panic!("an instance of FMI 3.0") };
        c
    }

    /// The functions of FMI 3.0.
    pub fn v3(&self) -> &fmi3::Functions {
        let VersionFunctions::V3(c) = &self.functions else { panic!("an instance of FMI 2.0") };
        c
    }

    /// The version.
    pub fn version(&self) -> Version {
        self.functions.version()
    }

    /// The messages since the last call.
    pub fn take_messages(&self) -> Vec<LoggedMessage> {
        std::mem::take(&mut *self.environment.messages.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// Sees values within steps.
    pub fn on_update(&self, update: Box<Update>) {
        *self.environment.update.borrow_mut() = Some(update);
    }

    /// Asserts `Ok`; what was told until then is forgotten.
    #[track_caller]
    pub fn must(&self, status: Status) {
        let messages = self.take_messages();
        assert_eq!(status, Status::Ok, "{messages:?}");
    }

    /// Returns the message of a call that took a value out of its range, which both versions discard.
    #[track_caller]
    pub fn discarded(&self, status: Status) -> String {
        assert_eq!(status, Status::Discard);
        self.refused(status)
    }

    /// Asserts an error with one message, or that values were discarded, and returns its text.
    #[track_caller]
    pub fn refused(&self, status: Status) -> String {
        let messages = self.take_messages();
        assert!(matches!(status, Status::Error | Status::Discard), "{status:?} {messages:?}");
        let [LoggedMessage { status: told, category, text }] = &*messages else {
            panic!("one message, not {messages:?}")
        };
        assert_eq!((*told, &**category), (status, "logStatusError"), "{messages:?}");
        text.clone()
    }

    fn or_null<T>(&self, place: u8, pointer: *const T) -> *const T {
        if self.nulls.get() >> place & 1 == 1 { null() } else { pointer }
    }

    fn or_null_mut<T>(&self, place: u8, pointer: *mut T) -> *mut T {
        self.or_null(place, pointer.cast_const()).cast_mut()
    }

    /// Sets up an experiment from a start time \[s\], in FMI 2.0 only.
    pub fn set_up(&self, tolerance: Option<f64>, start: f64, stop: Option<f64>) -> Status {
        let VersionFunctions::V2(c) = &self.functions else { return Status::Ok };
        let defined = (c_int::from(tolerance.is_some()), c_int::from(stop.is_some()));
        let (tolerance, stop) = (tolerance.unwrap_or(f64::NAN), stop.unwrap_or(f64::NAN));
        // SAFETY: an instance.
        unsafe { (c.fmi2SetupExperiment)(self.raw, defined.0, tolerance, start, defined.1, stop) }
    }

    /// Begins initialization, with an experiment from a start time \[s\].
    pub fn enter(&self, tolerance: Option<f64>, start: f64, stop: Option<f64>) -> Status {
        let status = self.set_up(tolerance, start, stop);
        if status != Status::Ok {
            return status;
        }
        let defined = (tolerance.is_some(), stop.is_some());
        let (tolerance, stop) = (tolerance.unwrap_or(f64::NAN), stop.unwrap_or(f64::NAN));
        // SAFETY: an instance.
        match &self.functions {
            VersionFunctions::V2(c) => unsafe { (c.fmi2EnterInitializationMode)(self.raw) },
            VersionFunctions::V3(c) => unsafe {
                (c.fmi3EnterInitializationMode)(self.raw, defined.0, tolerance, start, defined.1, stop)
            },
        }
    }

    /// Ends initialization.
    pub fn exit(&self) -> Status {
        call!(self, fmi2ExitInitializationMode / fmi3ExitInitializationMode)
    }

    /// Leads from instantiated to the first step, at time 0.
    #[track_caller]
    pub fn initialize(&self) {
        self.must(self.enter(None, 0.0, None));
        self.must(self.exit());
    }

    /// `fmi2Terminate`, `fmi3Terminate`
    pub fn terminate(&self) -> Status {
        call!(self, fmi2Terminate / fmi3Terminate)
    }

    /// `fmi2Reset`, `fmi3Reset`
    pub fn reset(&self) -> Status {
        call!(self, fmi2Reset / fmi3Reset)
    }

    /// `fmi3EnterConfigurationMode`
    pub fn enter_configuration(&self) -> Status {
        // SAFETY: an instance.
        unsafe { (self.v3().fmi3EnterConfigurationMode)(self.raw) }
    }

    /// `fmi3ExitConfigurationMode`
    pub fn exit_configuration(&self) -> Status {
        // SAFETY: an instance.
        unsafe { (self.v3().fmi3ExitConfigurationMode)(self.raw) }
    }

    /// `fmi2SetDebugLogging`, `fmi3SetDebugLogging`
    pub fn debug_logging(&self, on: bool, categories: &[Option<&CStr>]) -> Status {
        let pointers: Vec<_> = categories.iter().map(|text| text.map_or(null(), CStr::as_ptr)).collect();
        let (count, at) = (pointers.len(), self.or_null(0, pointers.as_ptr()));
        // SAFETY: an instance, and as many texts as said, or NULL.
        match &self.functions {
            VersionFunctions::V2(c) => unsafe { (c.fmi2SetDebugLogging)(self.raw, on.into(), count, at) },
            VersionFunctions::V3(c) => unsafe { (c.fmi3SetDebugLogging)(self.raw, on, count, at) },
        }
    }

    /// Makes a step from a time, both \[s\].
    pub fn do_step(&self, from: f64, step: f64) -> Stepped {
        let (mut event, mut terminate, mut early, mut time) = (true, true, true, f64::NAN);
        // SAFETY: an instance, and places of values or NULL.
        match &self.functions {
            VersionFunctions::V2(c) => {
                let status = unsafe { (c.fmi2DoStep)(self.raw, from, step, 1) };
                Stepped { status, early: false, time: from + step }
            }
            VersionFunctions::V3(c) => {
                let status = unsafe {
                    (c.fmi3DoStep)(
                        self.raw,
                        from,
                        step,
                        true,
                        self.or_null_mut(0, &raw mut event),
                        self.or_null_mut(1, &raw mut terminate),
                        self.or_null_mut(2, &raw mut early),
                        self.or_null_mut(3, &raw mut time),
                    )
                };
                let set = |place: u8, value: bool| self.nulls.get() >> place & 1 == 1 || value;
                assert!(set(0, !event) && set(1, !terminate) && set(3, time.is_finite()), "always set");
                Stepped { status, early: early && self.nulls.get() >> 2 & 1 == 0, time }
            }
        }
    }

    /// `fmi2GetFMUstate`, `fmi3GetFMUState`
    pub fn get_state(&self, state: &mut *mut c_void) -> Status {
        call!(self, fmi2GetFMUstate / fmi3GetFMUState, self.or_null_mut(0, state))
    }

    /// `fmi2SetFMUstate`, `fmi3SetFMUState`
    pub fn set_state(&self, state: *mut c_void) -> Status {
        call!(self, fmi2SetFMUstate / fmi3SetFMUState, state)
    }

    /// `fmi2FreeFMUstate`, `fmi3FreeFMUState`
    pub fn free_state(&self, state: &mut *mut c_void) -> Status {
        call!(self, fmi2FreeFMUstate / fmi3FreeFMUState, self.or_null_mut(0, state))
    }

    /// `fmi2SerializedFMUstateSize`, `fmi3SerializedFMUStateSize`
    pub fn serialized_size(&self, state: *mut c_void) -> (Status, usize) {
        let mut size = 0;
        let to = self.or_null_mut(0, &raw mut size);
        (call!(self, fmi2SerializedFMUstateSize / fmi3SerializedFMUStateSize, state, to), size)
    }

    /// Writes a state into a buffer of `size` bytes.
    pub fn serialize(&self, state: *mut c_void, size: usize) -> (Status, Vec<u8>) {
        let mut bytes = vec![0xEE; size];
        let to = self.or_null_mut(0, bytes.as_mut_ptr());
        (call!(self, fmi2SerializeFMUstate / fmi3SerializeFMUState, state, to, size), bytes)
    }

    /// `fmi2DeSerializeFMUstate`, `fmi3DeserializeFMUState`
    pub fn deserialize(&self, bytes: &[u8], state: &mut *mut c_void) -> Status {
        let (from, to) = (self.or_null(0, bytes.as_ptr()), self.or_null_mut(1, state));
        call!(self, fmi2DeSerializeFMUstate / fmi3DeserializeFMUState, from, bytes.len(), to)
    }

    /// A state that must be given back with [`TestInstance::free`].
    #[track_caller]
    pub fn save(&self) -> *mut c_void {
        let mut state = null_mut();
        self.must(self.get_state(&mut state));
        state
    }

    /// Gives a state back.
    #[track_caller]
    pub fn free(&self, mut state: *mut c_void) {
        self.must(self.free_state(&mut state));
        assert!(state.is_null());
    }

    /// The present state as bytes: with the phase and the time in it, all that an instance is.
    #[track_caller]
    pub fn bytes(&self) -> Vec<u8> {
        let state = self.save();
        let bytes = self.bytes_of(state);
        self.free(state);
        bytes
    }

    /// A state as bytes.
    #[track_caller]
    pub fn bytes_of(&self, state: *mut c_void) -> Vec<u8> {
        let (status, size) = self.serialized_size(state);
        self.must(status);
        let (status, bytes) = self.serialize(state, size);
        self.must(status);
        bytes
    }

    /// Goes back to what [`TestInstance::bytes`] gave; the first status that is not `Ok`.
    pub fn restore(&self, bytes: &[u8]) -> Status {
        let mut state = null_mut();
        let status = self.deserialize(bytes, &mut state);
        if status != Status::Ok {
            assert!(state.is_null(), "a refused state is not handed out");
            return status;
        }
        let status = self.set_state(state);
        assert_eq!(self.free_state(&mut state), Status::Ok);
        status
    }
}
