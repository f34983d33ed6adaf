//! The bodies of the FMI 2.0 C functions, for any model: pointers in, statuses out, nothing else.
//! [`export!`](crate::export) gives them their C names.
//!
//! Nothing here panics, prints, exits or leaks across the boundary: a panic inside becomes `fmi2Fatal`
//! with a message, and from then on the instance refuses all calls but `fmi2FreeInstance`.
//!
//! # Safety
//! All functions take pointers as FMI 2.0 defines them: an instance is one that `fmi2Instantiate` gave
//! and `fmi2FreeInstance` has not taken back, arrays hold as many elements as said, strings end in a
//! zero, states come from `fmi2GetFMUstate` or `fmi2DeSerializeFMUstate`. NULL is checked everywhere.

#![allow(unsafe_code)] // the C boundary
#![allow(clippy::missing_safety_doc)] // said once, above

use crate::description::LOG_CATEGORIES;
use crate::lifecycle::Function;
use crate::model::Model;
use crate::slave::{Slave, SlaveError, Snapshot};
use std::ffi::{CStr, CString, c_char, c_int, c_uint, c_void};
use std::panic::{AssertUnwindSafe, catch_unwind};

/// `fmi2Status`
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(missing_docs)] // FMI's own names
pub enum Status {
    Ok = 0,
    Warning = 1,
    Discard = 2,
    Error = 3,
    Fatal = 4,
    Pending = 5,
}

type Logger = unsafe extern "C" fn(*mut c_void, *const c_char, Status, *const c_char, *const c_char, ...);

/// `fmi2CallbackFunctions`; the memory functions may be NULL and are never used.
#[repr(C)]
#[allow(missing_docs)] // FMI's own names
pub struct CallbackFunctions {
    pub logger: Option<Logger>,
    pub allocate_memory: *const c_void,
    pub free_memory: *const c_void,
    pub step_finished: *const c_void,
    pub component_environment: *mut c_void,
}

const WARNING: usize = 0;
const ERROR: usize = 1;
const FATAL: usize = 2;
const ALL: usize = 3;

/// The importer's logger, and which categories it wants.
struct Log {
    logger: Option<Logger>,
    environment: *mut c_void,
    instance_name: CString,
    /// One for each of [`LOG_CATEGORIES`].
    wanted: [bool; 4],
}

impl Log {
    fn write(&self, status: Status, category: usize, message: &str) {
        let Some(logger) = self.logger.filter(|_| self.wanted[category] || self.wanted[ALL]) else { return };
        // Zeros inside would end the text early.
        let text = CString::new(message.replace('\0', " ")).unwrap_or_default();
        let category = CString::new(LOG_CATEGORIES[category].0).unwrap_or_default();
        // SAFETY: the importer's logger, called as FMI says; the message goes through "%s", so that
        // percent signs in it are itself.
        unsafe {
            logger(
                self.environment,
                self.instance_name.as_ptr(),
                status,
                category.as_ptr(),
                c"%s".as_ptr(),
                text.as_ptr(),
            );
        }
    }
}

/// The object behind an `fmi2Component`.
struct Component<M: Model> {
    slave: Slave<M>,
    log: Log,
    /// Keeps the strings of the last `fmi2GetString` alive.
    strings: Vec<CString>,
    /// A panic happened: the instance may be in any condition.
    broken: bool,
}

impl<M: Model> Component<M> {
    fn tell_warnings(&mut self) {
        for warning in self.slave.take_warnings() {
            self.log.write(Status::Warning, WARNING, &warning);
        }
    }
}

/// Why a call is refused or fails.
enum Refusal<M: Model> {
    Slave(SlaveError<M::Error>),
    Null(&'static str),
    NotUtf8(&'static str),
    Category(String),
    BufferSize {
        given: usize,
        needed: usize,
    },
    /// The call is allowed, but there is no result.
    Discard(&'static str),
}

impl<M: Model> From<SlaveError<M::Error>> for Refusal<M> {
    fn from(error: SlaveError<M::Error>) -> Self {
        Refusal::Slave(error)
    }
}

/// An argument that cannot be what FMI says it is.
enum Bad {
    Null(&'static str),
    NotUtf8(&'static str),
}

impl<M: Model> From<Bad> for Refusal<M> {
    fn from(bad: Bad) -> Self {
        match bad {
            Bad::Null(what) => Refusal::Null(what),
            Bad::NotUtf8(what) => Refusal::NotUtf8(what),
        }
    }
}

impl<M: Model> std::fmt::Display for Refusal<M> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Refusal::Slave(error) => write!(f, "{error}"),
            Refusal::Null(what) => write!(f, "{what} is NULL"),
            Refusal::NotUtf8(what) => write!(f, "{what} is not UTF-8 text"),
            Refusal::Category(name) => {
                let known: Vec<&str> = LOG_CATEGORIES.iter().map(|(name, _)| *name).collect();
                write!(f, "no log category {name:?}; there are {}", known.join(", "))
            }
            Refusal::BufferSize { given, needed } => {
                write!(f, "the buffer has {given} bytes, but the state needs {needed}")
            }
            Refusal::Discard(why) => f.write_str(why),
        }
    }
}

/// Removes the panic hook, so that this library prints nothing in its host. The hook has no state, so nothing is left
/// when the library is unloaded.
pub fn silence_panics() {
    static ONCE: std::sync::Once = std::sync::Once::new();
    ONCE.call_once(|| std::panic::set_hook(Box::new(|_| {})));
}

/// Runs a call on an instance. No panic and no error leaves it.
fn call<M: Model>(
    instance: *mut c_void,
    name: &str,
    body: impl FnOnce(&mut Component<M>) -> Result<(), Refusal<M>>,
) -> Status {
    // SAFETY: not NULL, so an instance of ours by the contract of the module.
    let Some(component) = (unsafe { instance.cast::<Component<M>>().as_mut() }) else { return Status::Error };
    if component.broken {
        component.log.write(Status::Fatal, FATAL, &format!("{name}: the instance broke in an earlier call"));
        return Status::Fatal;
    }
    match catch_unwind(AssertUnwindSafe(|| body(component))) {
        Ok(Ok(())) => Status::Ok,
        Ok(Err(refusal)) => {
            let status = if matches!(refusal, Refusal::Discard(_)) { Status::Discard } else { Status::Error };
            let category = if status == Status::Discard { WARNING } else { ERROR };
            component.log.write(status, category, &format!("{name}: {refusal}"));
            status
        }
        Err(panic) => {
            component.broken = true;
            component.log.write(Status::Fatal, FATAL, &format!("{name}: {}", panic_message(&*panic)));
            Status::Fatal
        }
    }
}

fn panic_message(panic: &(dyn std::any::Any + Send)) -> String {
    let text = panic.downcast_ref::<&str>().copied().or(panic.downcast_ref::<String>().map(String::as_str));
    format!("a fault of the FMU itself: {}", text.unwrap_or("no message"))
}

/// An array that belongs to the importer.
///
/// # Safety
/// `pointer` is NULL or leads to `length` elements that live through the call.
unsafe fn array<'a, T>(pointer: *const T, length: usize, what: &'static str) -> Result<&'a [T], Bad> {
    match (pointer.is_null(), length) {
        (_, 0) => Ok(&[]),
        (true, _) => Err(Bad::Null(what)),
        // SAFETY: as the caller promises.
        (false, _) => Ok(unsafe { std::slice::from_raw_parts(pointer, length) }),
    }
}

/// An array of the importer's that is written to.
///
/// # Safety
/// As [`array`], and no other code uses the elements during the call.
unsafe fn array_mut<'a, T>(pointer: *mut T, length: usize, what: &'static str) -> Result<&'a mut [T], Bad> {
    match (pointer.is_null(), length) {
        (_, 0) => Ok(&mut []),
        (true, _) => Err(Bad::Null(what)),
        // SAFETY: as the caller promises.
        (false, _) => Ok(unsafe { std::slice::from_raw_parts_mut(pointer, length) }),
    }
}

/// A text that belongs to the importer.
///
/// # Safety
/// `pointer` is NULL or leads to a text that ends in a zero and lives through the call.
unsafe fn text<'a>(pointer: *const c_char, what: &'static str) -> Result<&'a str, Bad> {
    if pointer.is_null() {
        return Err(Bad::Null(what));
    }
    // SAFETY: as the caller promises.
    unsafe { CStr::from_ptr(pointer) }.to_str().map_err(|_| Bad::NotUtf8(what))
}

/// `fmi2GetTypesPlatform`
pub fn get_types_platform() -> *const c_char {
    c"default".as_ptr()
}

/// `fmi2GetVersion`
pub fn get_version() -> *const c_char {
    c"2.0".as_ptr()
}

/// `fmi2Instantiate`: NULL, after a message, when the instance cannot be made.
pub unsafe fn instantiate<M: Model>(
    instance_name: *const c_char,
    fmu_type: c_int,
    guid: *const c_char,
    resource_location: *const c_char,
    functions: *const CallbackFunctions,
    _visible: c_int,
    logging_on: c_int,
) -> *mut c_void {
    silence_panics();
    // SAFETY: NULL or the importer's functions. They are copied: some importers keep them on the stack.
    let Some(functions) = (unsafe { functions.as_ref() }) else { return std::ptr::null_mut() };
    // SAFETY: NULL or a text of the importer's.
    let name = unsafe { text(instance_name, "instanceName") };
    let log = Log {
        logger: functions.logger,
        environment: functions.component_environment,
        instance_name: CString::new(name.as_ref().map_or("", |name| *name)).unwrap_or_default(),
        // Reasons of refused calls are always logged; `loggingOn` switches debug messages.
        wanted: [true, true, true, logging_on != 0],
    };
    let made = catch_unwind(AssertUnwindSafe(|| {
        if name?.is_empty() {
            return Err(SlaveError::Unsupported("instanceName is empty").into());
        }
        if fmu_type != 1 {
            return Err(
                SlaveError::Unsupported("fmuType: this is a co-simulation FMU, no model exchange").into()
            );
        }
        // SAFETY: NULL or texts of the importer's.
        let (guid, uri) =
            unsafe { (text(guid, "fmuGUID")?, text(resource_location, "fmuResourceLocation")?) };
        let model = M::load(uri).map_err(SlaveError::from)?;
        Ok::<_, Refusal<M>>(Slave::new(model, guid)?)
    }));
    let slave = match made {
        Ok(Ok(slave)) => slave,
        Ok(Err(refusal)) => {
            log.write(Status::Error, ERROR, &format!("fmi2Instantiate: {refusal}"));
            return std::ptr::null_mut();
        }
        Err(panic) => {
            log.write(Status::Fatal, FATAL, &format!("fmi2Instantiate: {}", panic_message(&*panic)));
            return std::ptr::null_mut();
        }
    };
    let mut component = Component { slave, log, strings: Vec::new(), broken: false };
    component.tell_warnings();
    Box::into_raw(Box::new(component)).cast()
}

/// `fmi2FreeInstance`
pub unsafe fn free_instance<M: Model>(instance: *mut c_void) {
    if !instance.is_null() {
        // SAFETY: an instance that `fmi2Instantiate` boxed, given back once.
        let component = unsafe { Box::from_raw(instance.cast::<Component<M>>()) };
        let _ = catch_unwind(AssertUnwindSafe(|| drop(component)));
    }
}

/// `fmi2SetDebugLogging`
pub unsafe fn set_debug_logging<M: Model>(
    instance: *mut c_void,
    logging_on: c_int,
    count: usize,
    categories: *const *const c_char,
) -> Status {
    call::<M>(instance, "fmi2SetDebugLogging", |component| {
        component.slave.check(Function::SetDebugLogging)?;
        let mut wanted = [false; 4];
        // SAFETY: as many texts as said.
        for &name in unsafe { array(categories, count, "categories")? } {
            // SAFETY: NULL or a text of the importer's.
            let name = unsafe { text(name, "a category")? };
            let place = LOG_CATEGORIES.iter().position(|(known, _)| *known == name);
            wanted[place.ok_or_else(|| Refusal::Category(name.to_owned()))?] = true;
        }
        component.log.wanted = match (logging_on != 0, count) {
            (false, _) => [true, true, true, false],
            (true, 0) => [true; 4],
            (true, _) => wanted,
        };
        Ok(())
    })
}

/// `fmi2SetupExperiment`
pub unsafe fn setup_experiment<M: Model>(
    instance: *mut c_void,
    _tolerance_defined: c_int,
    _tolerance: f64,
    start_time: f64,
    stop_time_defined: c_int,
    stop_time: f64,
) -> Status {
    call::<M>(instance, "fmi2SetupExperiment", |component| {
        Ok(component.slave.setup_experiment(start_time, (stop_time_defined != 0).then_some(stop_time))?)
    })
}

/// `fmi2EnterInitializationMode`
pub unsafe fn enter_initialization_mode<M: Model>(instance: *mut c_void) -> Status {
    call::<M>(instance, "fmi2EnterInitializationMode", |component| {
        Ok(component.slave.enter_initialization()?)
    })
}

/// `fmi2ExitInitializationMode`
pub unsafe fn exit_initialization_mode<M: Model>(instance: *mut c_void) -> Status {
    call::<M>(instance, "fmi2ExitInitializationMode", |component| {
        component.slave.exit_initialization()?;
        component.tell_warnings();
        Ok(())
    })
}

/// `fmi2Terminate`
pub unsafe fn terminate<M: Model>(instance: *mut c_void) -> Status {
    call::<M>(instance, "fmi2Terminate", |component| Ok(component.slave.terminate()?))
}

/// `fmi2Reset`
pub unsafe fn reset<M: Model>(instance: *mut c_void) -> Status {
    call::<M>(instance, "fmi2Reset", |component| Ok(component.slave.reset()?))
}

/// `fmi2GetReal`
pub unsafe fn get_real<M: Model>(
    instance: *mut c_void,
    references: *const c_uint,
    count: usize,
    values: *mut f64,
) -> Status {
    call::<M>(instance, "fmi2GetReal", |component| {
        // SAFETY: as many elements as said.
        let (references, values) =
            unsafe { (array(references, count, "vr")?, array_mut(values, count, "value")?) };
        Ok(component.slave.get_real(references, values)?)
    })
}

/// `fmi2GetInteger`
pub unsafe fn get_integer<M: Model>(
    instance: *mut c_void,
    references: *const c_uint,
    count: usize,
    values: *mut c_int,
) -> Status {
    call::<M>(instance, "fmi2GetInteger", |component| {
        // SAFETY: as many elements as said.
        let (references, values) =
            unsafe { (array(references, count, "vr")?, array_mut(values, count, "value")?) };
        Ok(component.slave.get_integer(references, values)?)
    })
}

/// `fmi2GetBoolean`: there are no Booleans.
pub unsafe fn get_boolean<M: Model>(
    instance: *mut c_void,
    references: *const c_uint,
    count: usize,
    _values: *mut c_int,
) -> Status {
    call::<M>(instance, "fmi2GetBoolean", |component| {
        // SAFETY: as many elements as said.
        no_booleans(component, Function::Get, unsafe { array(references, count, "vr")? })
    })
}

/// `fmi2GetString`: the texts live until the next call of this function or the end of the instance.
pub unsafe fn get_string<M: Model>(
    instance: *mut c_void,
    references: *const c_uint,
    count: usize,
    values: *mut *const c_char,
) -> Status {
    call::<M>(instance, "fmi2GetString", |component| {
        // SAFETY: as many elements as said.
        let (references, values) =
            unsafe { (array(references, count, "vr")?, array_mut(values, count, "value")?) };
        let texts = component.slave.get_string(references)?;
        component.strings = texts.into_iter().map(|text| CString::new(text).unwrap_or_default()).collect();
        for (value, text) in values.iter_mut().zip(&component.strings) {
            *value = text.as_ptr();
        }
        Ok(())
    })
}

/// `fmi2SetReal`
pub unsafe fn set_real<M: Model>(
    instance: *mut c_void,
    references: *const c_uint,
    count: usize,
    values: *const f64,
) -> Status {
    call::<M>(instance, "fmi2SetReal", |component| {
        // SAFETY: as many elements as said.
        let (references, values) =
            unsafe { (array(references, count, "vr")?, array(values, count, "value")?) };
        Ok(component.slave.set_real(references, values)?)
    })
}

/// `fmi2SetInteger`
pub unsafe fn set_integer<M: Model>(
    instance: *mut c_void,
    references: *const c_uint,
    count: usize,
    values: *const c_int,
) -> Status {
    call::<M>(instance, "fmi2SetInteger", |component| {
        // SAFETY: as many elements as said.
        let (references, values) =
            unsafe { (array(references, count, "vr")?, array(values, count, "value")?) };
        Ok(component.slave.set_integer(references, values)?)
    })
}

/// `fmi2SetBoolean`: there are no Booleans.
pub unsafe fn set_boolean<M: Model>(
    instance: *mut c_void,
    references: *const c_uint,
    count: usize,
    _values: *const c_int,
) -> Status {
    call::<M>(instance, "fmi2SetBoolean", |component| {
        // SAFETY: as many elements as said.
        no_booleans(component, Function::Set, unsafe { array(references, count, "vr")? })
    })
}

fn no_booleans<M: Model>(
    component: &Component<M>,
    function: Function,
    references: &[c_uint],
) -> Result<(), Refusal<M>> {
    component.slave.check(function)?;
    match references.first() {
        None => Ok(()),
        Some(&reference) => Err(SlaveError::UnknownReference { kind: "Boolean", reference }.into()),
    }
}

/// `fmi2SetString`
pub unsafe fn set_string<M: Model>(
    instance: *mut c_void,
    references: *const c_uint,
    count: usize,
    values: *const *const c_char,
) -> Status {
    call::<M>(instance, "fmi2SetString", |component| {
        // SAFETY: as many elements as said.
        let (references, values) =
            unsafe { (array(references, count, "vr")?, array(values, count, "value")?) };
        // SAFETY: NULL or texts of the importer's.
        let texts = values.iter().map(|&value| unsafe { text(value, "a value") });
        let texts = texts.collect::<Result<Vec<&str>, Bad>>()?;
        component.slave.set_string(references, &texts)?;
        component.tell_warnings();
        Ok(())
    })
}

/// `fmi2GetFMUstate`: a new state, or an old one overwritten.
pub unsafe fn get_fmu_state<M: Model>(instance: *mut c_void, state: *mut *mut c_void) -> Status {
    call::<M>(instance, "fmi2GetFMUstate", |component| {
        // SAFETY: NULL or the place of a state pointer.
        let place = unsafe { state.as_mut() }.ok_or(Refusal::Null("FMUstate"))?;
        put(place, component.slave.snapshot()?);
        Ok(())
    })
}

/// Stores a snapshot behind a state pointer of the importer.
fn put<S>(place: &mut *mut c_void, snapshot: Snapshot<S>) {
    // SAFETY: NULL or a state that an earlier call boxed.
    match unsafe { place.cast::<Snapshot<S>>().as_mut() } {
        Some(old) => *old = snapshot,
        None => *place = Box::into_raw(Box::new(snapshot)).cast(),
    }
}

/// The snapshot behind a state.
///
/// # Safety
/// `state` is NULL or a state that an earlier call boxed and that lives through this one.
unsafe fn snapshot<'a, S>(state: *mut c_void) -> Result<&'a Snapshot<S>, Bad> {
    // SAFETY: as the caller promises.
    unsafe { state.cast::<Snapshot<S>>().as_ref() }.ok_or(Bad::Null("FMUstate"))
}

/// `fmi2SetFMUstate`
pub unsafe fn set_fmu_state<M: Model>(instance: *mut c_void, state: *mut c_void) -> Status {
    call::<M>(instance, "fmi2SetFMUstate", |component| {
        component.slave.check(Function::State)?;
        // SAFETY: NULL or a state of ours.
        Ok(component.slave.restore(unsafe { snapshot(state)? })?)
    })
}

/// `fmi2FreeFMUstate`: NULL is fine, and it is NULL afterwards.
pub unsafe fn free_fmu_state<M: Model>(instance: *mut c_void, state: *mut *mut c_void) -> Status {
    call::<M>(instance, "fmi2FreeFMUstate", |component| {
        component.slave.check(Function::State)?;
        // SAFETY: NULL or the place of a state pointer.
        if let Some(place) = unsafe { state.as_mut() }.filter(|place| !place.is_null()) {
            // SAFETY: a state that an earlier call boxed, given back once.
            drop(unsafe { Box::from_raw(place.cast::<Snapshot<M::Saved>>()) });
            *place = std::ptr::null_mut();
        }
        Ok(())
    })
}

/// `fmi2SerializedFMUstateSize`
pub unsafe fn serialized_fmu_state_size<M: Model>(
    instance: *mut c_void,
    state: *mut c_void,
    size: *mut usize,
) -> Status {
    call::<M>(instance, "fmi2SerializedFMUstateSize", |component| {
        component.slave.check(Function::State)?;
        // SAFETY: NULL, or a state of ours and the place of a number.
        let (snapshot, size) = unsafe { (snapshot(state)?, size.as_mut().ok_or(Refusal::Null("size"))?) };
        *size = component.slave.serialize(snapshot)?.len();
        Ok(())
    })
}

/// `fmi2SerializeFMUstate`
pub unsafe fn serialize_fmu_state<M: Model>(
    instance: *mut c_void,
    state: *mut c_void,
    bytes: *mut u8,
    size: usize,
) -> Status {
    call::<M>(instance, "fmi2SerializeFMUstate", |component| {
        component.slave.check(Function::State)?;
        // SAFETY: NULL, or a state of ours and as many bytes as said.
        let (snapshot, buffer) = unsafe { (snapshot(state)?, array_mut(bytes, size, "serializedState")?) };
        let bytes = component.slave.serialize(snapshot)?;
        let (given, needed) = (buffer.len(), bytes.len());
        buffer.get_mut(..needed).ok_or(Refusal::BufferSize { given, needed })?.copy_from_slice(&bytes);
        Ok(())
    })
}

/// `fmi2DeSerializeFMUstate`
pub unsafe fn deserialize_fmu_state<M: Model>(
    instance: *mut c_void,
    bytes: *const u8,
    size: usize,
    state: *mut *mut c_void,
) -> Status {
    call::<M>(instance, "fmi2DeSerializeFMUstate", |component| {
        // SAFETY: NULL, or as many bytes as said and the place of a state pointer.
        let (bytes, place) = unsafe { (array(bytes, size, "serializedState")?, state.as_mut()) };
        put(place.ok_or(Refusal::Null("FMUstate"))?, component.slave.deserialize(bytes)?);
        Ok(())
    })
}

/// `fmi2GetDirectionalDerivative`: not provided.
pub unsafe fn get_directional_derivative<M: Model>(
    instance: *mut c_void,
    _unknowns: *const c_uint,
    _unknown_count: usize,
    _knowns: *const c_uint,
    _known_count: usize,
    _known_differentials: *const f64,
    _unknown_differentials: *mut f64,
) -> Status {
    call::<M>(instance, "fmi2GetDirectionalDerivative", |component| {
        component.slave.check(Function::GetDirectionalDerivative)?;
        Err(SlaveError::Unsupported("providesDirectionalDerivative is false").into())
    })
}

/// `fmi2SetRealInputDerivatives`
pub unsafe fn set_real_input_derivatives<M: Model>(
    instance: *mut c_void,
    references: *const c_uint,
    count: usize,
    orders: *const c_int,
    values: *const f64,
) -> Status {
    call::<M>(instance, "fmi2SetRealInputDerivatives", |component| {
        // SAFETY: as many elements as said.
        let (references, orders, values) = unsafe {
            (array(references, count, "vr")?, array(orders, count, "order")?, array(values, count, "value")?)
        };
        Ok(component.slave.set_input_derivatives(references, orders, values)?)
    })
}

/// `fmi2GetRealOutputDerivatives`: `maxOutputDerivativeOrder` is 0.
pub unsafe fn get_real_output_derivatives<M: Model>(
    instance: *mut c_void,
    _references: *const c_uint,
    _count: usize,
    _orders: *const c_int,
    _values: *mut f64,
) -> Status {
    call::<M>(instance, "fmi2GetRealOutputDerivatives", |component| {
        component.slave.check(Function::GetRealOutputDerivatives)?;
        Err(SlaveError::Unsupported("maxOutputDerivativeOrder is 0").into())
    })
}

/// `fmi2DoStep`
pub unsafe fn do_step<M: Model>(
    instance: *mut c_void,
    current_communication_point: f64,
    communication_step_size: f64,
    _no_set_fmu_state_prior_to_current_point: c_int,
) -> Status {
    call::<M>(instance, "fmi2DoStep", |component| {
        component.slave.do_step(current_communication_point, communication_step_size)?;
        component.tell_warnings();
        Ok(())
    })
}

/// `fmi2CancelStep`: a synchronous slave is never in the middle of a step.
pub unsafe fn cancel_step<M: Model>(instance: *mut c_void) -> Status {
    call::<M>(instance, "fmi2CancelStep", |component| Ok(component.slave.check(Function::CancelStep)?))
}

/// `fmi2StatusKind`
const LAST_SUCCESSFUL_TIME: c_int = 2;
const TERMINATED: c_int = 3;

/// Returns a status. Those about pending steps do not apply to a synchronous slave.
fn status<M: Model, T>(
    instance: *mut c_void,
    name: &str,
    value: *mut T,
    read: impl FnOnce(&Slave<M>) -> Option<T>,
) -> Status {
    call::<M>(instance, name, |component| {
        component.slave.check(Function::GetStatus)?;
        // SAFETY: NULL or the place of a value.
        let place = unsafe { value.as_mut() }.ok_or(Refusal::Null("value"))?;
        *place = read(&component.slave)
            .ok_or(Refusal::Discard("fmi2DoStep never returns fmi2Pending in this FMU"))?;
        Ok(())
    })
}

/// `fmi2GetStatus`
pub unsafe fn get_status<M: Model>(instance: *mut c_void, _kind: c_int, value: *mut c_int) -> Status {
    status::<M, _>(instance, "fmi2GetStatus", value, |_| None)
}

/// `fmi2GetRealStatus`
pub unsafe fn get_real_status<M: Model>(instance: *mut c_void, kind: c_int, value: *mut f64) -> Status {
    status::<M, _>(instance, "fmi2GetRealStatus", value, |slave| {
        (kind == LAST_SUCCESSFUL_TIME).then(|| slave.time())
    })
}

/// `fmi2GetIntegerStatus`
pub unsafe fn get_integer_status<M: Model>(instance: *mut c_void, _kind: c_int, value: *mut c_int) -> Status {
    status::<M, _>(instance, "fmi2GetIntegerStatus", value, |_| None)
}

/// `fmi2GetBooleanStatus`
pub unsafe fn get_boolean_status<M: Model>(instance: *mut c_void, kind: c_int, value: *mut c_int) -> Status {
    status::<M, _>(instance, "fmi2GetBooleanStatus", value, |_| (kind == TERMINATED).then_some(0))
}

/// `fmi2GetStringStatus`
pub unsafe fn get_string_status<M: Model>(
    instance: *mut c_void,
    _kind: c_int,
    value: *mut *const c_char,
) -> Status {
    status::<M, _>(instance, "fmi2GetStringStatus", value, |_| None)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn panics_have_messages() {
        let panic = catch_unwind(|| panic!("broken {}", 1)).unwrap_err();
        assert_eq!(panic_message(&*panic), "a fault of the FMU itself: broken 1");
    }
}
