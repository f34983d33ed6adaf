//! The 34 functions of FMI 2.0 co-simulation, declared here anew from the standard, and a logger that keeps what it is
//! told.
//!
//! [`Functions::of`] takes them from a shared library as an importer does; [`Functions::of_model`] calls their bodies for
//! a model, without a library.
//!
//! # Safety
//! All functions have the contract of FMI 2.0: an instance is one that `fmi2Instantiate` returned and that is not freed,
//! arrays have the length that is given, texts end with a zero. See [`lemons_fmi::v2::component`].

#![allow(unsafe_code)] // the C boundary, from the other side

use crate::answer::Answer;
use lemons_fmi::{Model, Status};
use libloading::Library;
use std::ffi::{CStr, c_char, c_int, c_uint, c_void};
use std::ptr::null;
use std::sync::{Mutex, PoisonError};

/// `fmi2OK`
pub const OK: c_int = 0;
/// `fmi2Warning`
pub const WARNING: c_int = 1;
/// `fmi2Discard`
pub const DISCARD: c_int = 2;
/// `fmi2Error`
pub const ERROR: c_int = 3;
/// `fmi2Fatal`
pub const FATAL: c_int = 4;

/// The status with this number of the standard.
///
/// # Panics
/// There is none.
pub fn status(number: c_int) -> Status {
    use Status::*;
    let all = [Ok, Warning, Discard, Error, Fatal, Pending];
    all.into_iter().find(|status| *status as c_int == number).expect("a status of FMI 2.0")
}

/// `fmi2CoSimulation`
pub const CO_SIMULATION: c_int = 1;

/// The standard's logger has variable arguments, which stable Rust cannot define. All calls of our libraries pass one
/// argument, the text for "%s". By the C calling conventions of Linux on x86_64 and aarch64, a call with variable
/// arguments puts six pointers where a function with six fixed pointers looks for them: in registers.
pub type Logger =
    unsafe extern "C" fn(*mut c_void, *const c_char, c_int, *const c_char, *const c_char, *const c_char);

/// `fmi2CallbackFunctions`
#[repr(C)]
#[derive(Debug, Clone, Copy)]
#[allow(missing_docs)] // the standard's own names
pub struct Callbacks {
    pub logger: Option<Logger>,
    pub allocate_memory: *const c_void,
    pub free_memory: *const c_void,
    pub step_finished: *const c_void,
    pub environment: *mut c_void,
}

impl Callbacks {
    /// No logger, no memory functions: all of them may be NULL.
    pub const NONE: Callbacks = Callbacks {
        logger: None,
        allocate_memory: null(),
        free_memory: null(),
        step_finished: null(),
        environment: std::ptr::null_mut(),
    };
}

macro_rules! functions {
    ($($name:ident = $body:ident($($argument:ident: $type:ty),*) $(-> $result:ty)?;)*) => {
        /// All functions of FMI 2.0 co-simulation.
        #[allow(non_snake_case, missing_docs)] // the standard's own names
        #[derive(Debug, Clone, Copy)]
        pub struct Functions {
            $(pub $name: unsafe extern "C" fn($($type),*) $(-> $result)?,)*
        }

        /// Their names.
        pub const NAMES: &[&str] = &[$(stringify!($name)),*];

        impl Functions {
            /// Those of a shared library, which must stay loaded while they are called.
            ///
            /// # Panics
            /// One is not exported.
            pub fn of(library: &Library) -> Functions {
                Functions {
                    // SAFETY: the library exports them with the standard's signatures.
                    $($name: *unsafe { library.get(stringify!($name)) }
                        .unwrap_or_else(|error| panic!("{} is not exported: {error}", stringify!($name))),)*
                }
            }

            /// Those of a model, without a library.
            pub fn of_model<M: Model>() -> Functions {
                Functions { $($name: called::$body::<M>,)* }
            }
        }

        /// The bodies with the types and the calling convention of C.
        mod called {
            use super::*;
            $(
                pub unsafe extern "C" fn $body<M: Model>($($argument: $type),*) $(-> $result)? {
                    // SAFETY: the caller keeps the contract of FMI, which is that of the body.
                    unsafe { bodies::$body::<M>($($argument),*) }.answer()
                }
            )*
        }
    };
}

functions! {
    fmi2GetTypesPlatform = get_types_platform() -> *const c_char;
    fmi2GetVersion = get_version() -> *const c_char;
    fmi2SetDebugLogging = set_debug_logging(
        instance: *mut c_void, on: c_int, count: usize, categories: *const *const c_char
    ) -> c_int;
    fmi2Instantiate = instantiate(
        name: *const c_char, kind: c_int, guid: *const c_char, resources: *const c_char,
        callbacks: *const Callbacks, visible: c_int, logging_on: c_int
    ) -> *mut c_void;
    fmi2FreeInstance = free_instance(instance: *mut c_void);
    fmi2SetupExperiment = setup_experiment(
        instance: *mut c_void, has_tolerance: c_int, tolerance: f64, start: f64, has_stop: c_int, stop: f64
    ) -> c_int;
    fmi2EnterInitializationMode = enter_initialization_mode(instance: *mut c_void) -> c_int;
    fmi2ExitInitializationMode = exit_initialization_mode(instance: *mut c_void) -> c_int;
    fmi2Terminate = terminate(instance: *mut c_void) -> c_int;
    fmi2Reset = reset(instance: *mut c_void) -> c_int;
    fmi2GetReal = get_real(
        instance: *mut c_void, references: *const c_uint, count: usize, values: *mut f64
    ) -> c_int;
    fmi2GetInteger = get_integer(
        instance: *mut c_void, references: *const c_uint, count: usize, values: *mut c_int
    ) -> c_int;
    fmi2GetBoolean = get_boolean(
        instance: *mut c_void, references: *const c_uint, count: usize, values: *mut c_int
    ) -> c_int;
    fmi2GetString = get_string(
        instance: *mut c_void, references: *const c_uint, count: usize, values: *mut *const c_char
    ) -> c_int;
    fmi2SetReal = set_real(
        instance: *mut c_void, references: *const c_uint, count: usize, values: *const f64
    ) -> c_int;
    fmi2SetInteger = set_integer(
        instance: *mut c_void, references: *const c_uint, count: usize, values: *const c_int
    ) -> c_int;
    fmi2SetBoolean = set_boolean(
        instance: *mut c_void, references: *const c_uint, count: usize, values: *const c_int
    ) -> c_int;
    fmi2SetString = set_string(
        instance: *mut c_void, references: *const c_uint, count: usize, values: *const *const c_char
    ) -> c_int;
    fmi2GetFMUstate = get_fmu_state(instance: *mut c_void, state: *mut *mut c_void) -> c_int;
    fmi2SetFMUstate = set_fmu_state(instance: *mut c_void, state: *mut c_void) -> c_int;
    fmi2FreeFMUstate = free_fmu_state(instance: *mut c_void, state: *mut *mut c_void) -> c_int;
    fmi2SerializedFMUstateSize = serialized_fmu_state_size(
        instance: *mut c_void, state: *mut c_void, size: *mut usize
    ) -> c_int;
    fmi2SerializeFMUstate = serialize_fmu_state(
        instance: *mut c_void, state: *mut c_void, bytes: *mut u8, size: usize
    ) -> c_int;
    fmi2DeSerializeFMUstate = deserialize_fmu_state(
        instance: *mut c_void, bytes: *const u8, size: usize, state: *mut *mut c_void
    ) -> c_int;
    fmi2GetDirectionalDerivative = get_directional_derivative(
        instance: *mut c_void, unknowns: *const c_uint, unknown_count: usize, knowns: *const c_uint,
        known_count: usize, known_differentials: *const f64, unknown_differentials: *mut f64
    ) -> c_int;
    fmi2SetRealInputDerivatives = set_real_input_derivatives(
        instance: *mut c_void, references: *const c_uint, count: usize, orders: *const c_int,
        values: *const f64
    ) -> c_int;
    fmi2GetRealOutputDerivatives = get_real_output_derivatives(
        instance: *mut c_void, references: *const c_uint, count: usize, orders: *const c_int, values: *mut f64
    ) -> c_int;
    fmi2DoStep = do_step(instance: *mut c_void, from: f64, step: f64, no_earlier_state: c_int) -> c_int;
    fmi2CancelStep = cancel_step(instance: *mut c_void) -> c_int;
    fmi2GetStatus = get_status(instance: *mut c_void, kind: c_int, value: *mut c_int) -> c_int;
    fmi2GetRealStatus = get_real_status(instance: *mut c_void, kind: c_int, value: *mut f64) -> c_int;
    fmi2GetIntegerStatus = get_integer_status(instance: *mut c_void, kind: c_int, value: *mut c_int) -> c_int;
    fmi2GetBooleanStatus = get_boolean_status(instance: *mut c_void, kind: c_int, value: *mut c_int) -> c_int;
    fmi2GetStringStatus = get_string_status(
        instance: *mut c_void, kind: c_int, value: *mut *const c_char
    ) -> c_int;
}

/// The bodies, all of them with the model as their parameter, though two do not need it.
#[allow(clippy::extra_unused_type_parameters)]
mod bodies {
    use super::{Callbacks, Model, c_char, c_int, c_void};
    pub use lemons_fmi::v2::component::*;

    pub unsafe fn get_types_platform<M: Model>() -> *const c_char {
        lemons_fmi::v2::component::get_types_platform()
    }

    pub unsafe fn get_version<M: Model>() -> *const c_char {
        lemons_fmi::v2::component::get_version()
    }

    pub unsafe fn instantiate<M: Model>(
        name: *const c_char,
        kind: c_int,
        guid: *const c_char,
        resources: *const c_char,
        callbacks: *const Callbacks,
        visible: c_int,
        logging_on: c_int,
    ) -> *mut c_void {
        // The same structure; the logger is one with variable arguments (see `Logger`).
        let callbacks = callbacks.cast();
        // SAFETY: the caller keeps the contract of FMI.
        unsafe {
            lemons_fmi::v2::component::instantiate::<M>(
                name, kind, guid, resources, callbacks, visible, logging_on,
            )
        }
    }
}

/// A message to the importer.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Message {
    /// Name of the instance.
    pub instance: String,
    /// `fmi2Status`
    pub status: c_int,
    /// Log category.
    pub category: String,
    /// Format of C's `printf`.
    pub format: String,
    /// Its one argument.
    pub text: String,
}

/// Keeps the messages of an instance. It must not move while the instance lives: put it into a box or a static.
#[derive(Debug, Default)]
pub struct Log(Mutex<Vec<Message>>);

impl Log {
    /// The messages since the last call.
    pub fn take(&self) -> Vec<Message> {
        std::mem::take(&mut *self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// With this log as their environment. Importers may keep them on the stack: an instance copies them.
    pub fn callbacks(&self) -> Callbacks {
        let environment = std::ptr::from_ref(self).cast_mut().cast();
        Callbacks { logger: Some(log), environment, ..Callbacks::NONE }
    }
}

unsafe extern "C" fn log(
    environment: *mut c_void,
    instance: *const c_char,
    status: c_int,
    category: *const c_char,
    format: *const c_char,
    text: *const c_char,
) {
    let string = |text| {
        // SAFETY: the library passes texts that end with a zero.
        let text = unsafe { CStr::from_ptr(text) };
        text.to_str().expect("the logger gets UTF-8 text").to_owned()
    };
    let message = Message {
        instance: string(instance),
        status,
        category: string(category),
        format: string(format),
        text: string(text),
    };
    // SAFETY: the library returns the environment that it was given, which is a `Log`.
    let log = unsafe { environment.cast::<Log>().as_ref() }.expect("the environment that was given");
    log.0.lock().unwrap_or_else(PoisonError::into_inner).push(message);
}
