//! The bodies of the FMI 3.0 C functions, for any model with arrays: pointers in, statuses out, nothing else.
//! [`export_fmi3!`](crate::export_fmi3) gives them their C names.
//!
//! Nothing here panics, prints, exits or leaks across the boundary: a panic inside becomes `fmi3Fatal` with a message,
//! and from then on the instance refuses all calls but `fmi3FreeInstance`.
//!
//! # Safety
//! All functions take pointers as FMI 3.0 defines them: an instance is one that `fmi3InstantiateCoSimulation` gave and
//! `fmi3FreeInstance` has not taken back, arrays hold as many elements as said, strings end in a zero. NULL is checked
//! everywhere.

#![allow(unsafe_code)] // the C boundary
#![allow(clippy::missing_safety_doc)] // said once, above
#![allow(clippy::extra_unused_type_parameters)] // so that all bodies have the model as their parameter
#![allow(clippy::too_many_arguments)] // FMI's signatures

use super::arrays::ArrayModel;
use super::slave::{Slave, Table};
use crate::boundary::{
    Component, ERROR, Log, Logger, Refusal, Status, array, array_mut, free, make, silence_panics, text, texts,
};
use crate::lifecycle::Function;
use crate::location::Location;
use crate::slave::SlaveError;
use crate::states;
use std::ffi::{CString, c_char, c_void};

pub use crate::boundary::Logger3;

/// `fmi3IntermediateUpdateCallback`
pub type IntermediateUpdate =
    unsafe extern "C" fn(*mut c_void, f64, bool, bool, bool, bool, *mut bool, *mut f64);

/// The importer's callback within a step.
#[derive(Clone, Copy)]
struct Intermediate {
    update: Option<IntermediateUpdate>,
    environment: *mut c_void,
    early_return_allowed: bool,
}

/// The object behind an `fmi3Instance`: the callback lies beside what calls borrow, because the importer calls functions
/// of the instance while the callback runs.
#[repr(C)]
struct Instance<M: ArrayModel> {
    component: *mut c_void,
    intermediate: Intermediate,
    model: std::marker::PhantomData<M>,
}

/// `fmi3GetVersion`
pub extern "C" fn get_version<M: ArrayModel>() -> *const c_char {
    c"3.0".as_ptr()
}

/// The component of an instance; NULL of NULL.
fn component_of<M: ArrayModel>(instance: *mut c_void) -> *mut c_void {
    // SAFETY: NULL or an instance of ours by the contract of the module.
    unsafe { instance.cast::<Instance<M>>().as_ref() }.map_or(std::ptr::null_mut(), |it| it.component)
}

/// Runs a call on an instance.
fn call<M: ArrayModel>(
    instance: *mut c_void,
    name: &str,
    body: impl FnOnce(&mut Component<M, Table<M>>) -> Result<(), Refusal<M>>,
) -> Status {
    crate::boundary::call(component_of::<M>(instance), name, body)
}

/// `fmi3InstantiateCoSimulation`: NULL, after a message, when the instance cannot be made.
pub unsafe extern "C" fn instantiate_co_simulation<M: ArrayModel>(
    instance_name: *const c_char,
    token: *const c_char,
    resource_path: *const c_char,
    _visible: bool,
    logging_on: bool,
    event_mode_used: bool,
    early_return_allowed: bool,
    _required: *const u32,
    _required_count: usize,
    environment: *mut c_void,
    log_message: Option<Logger3>,
    intermediate_update: Option<IntermediateUpdate>,
) -> *mut c_void {
    silence_panics();
    // SAFETY: NULL or a text of the importer's.
    let name = unsafe { text(instance_name, "instanceName") };
    let log = Log {
        logger: Logger::V3(log_message),
        environment,
        instance_name: CString::default(),
        wanted: Log::wanted(logging_on),
    };
    let component = make::<M, Table<M>>(log, "fmi3InstantiateCoSimulation", || {
        if name?.is_empty() {
            return Err(SlaveError::Unsupported("instanceName is empty").into());
        }
        if event_mode_used {
            return Err(SlaveError::Unsupported("eventModeUsed: hasEventMode is false").into());
        }
        // SAFETY: NULL or texts of the importer's.
        let (token, path) =
            unsafe { (text(token, "instantiationToken")?, text(resource_path, "resourcePath")?) };
        let model = M::load(Location::Path(path)).map_err(SlaveError::from)?;
        Ok(Slave::new(model, token)?)
    });
    if component.is_null() {
        return component;
    }
    let intermediate = Intermediate { update: intermediate_update, environment, early_return_allowed };
    Box::into_raw(Box::new(Instance::<M> { component, intermediate, model: std::marker::PhantomData })).cast()
}

/// `fmi3InstantiateModelExchange` and `fmi3InstantiateScheduledExecution`: not offered.
fn not_offered(name: &str, environment: *mut c_void, log_message: Option<Logger3>) -> *mut c_void {
    let log = Log {
        logger: Logger::V3(log_message),
        environment,
        instance_name: CString::default(),
        wanted: Log::wanted(false),
    };
    log.write(Status::Error, ERROR, &format!("{name}: this FMU is for co-simulation only"));
    std::ptr::null_mut()
}

/// `fmi3InstantiateModelExchange`: not offered.
pub unsafe extern "C" fn instantiate_model_exchange<M: ArrayModel>(
    _instance_name: *const c_char,
    _token: *const c_char,
    _resource_path: *const c_char,
    _visible: bool,
    _logging_on: bool,
    environment: *mut c_void,
    log_message: Option<Logger3>,
) -> *mut c_void {
    not_offered("fmi3InstantiateModelExchange", environment, log_message)
}

/// `fmi3InstantiateScheduledExecution`: not offered.
pub unsafe extern "C" fn instantiate_scheduled_execution<M: ArrayModel>(
    _instance_name: *const c_char,
    _token: *const c_char,
    _resource_path: *const c_char,
    _visible: bool,
    _logging_on: bool,
    environment: *mut c_void,
    log_message: Option<Logger3>,
    _clock_update: *const c_void,
    _lock: *const c_void,
    _unlock: *const c_void,
) -> *mut c_void {
    not_offered("fmi3InstantiateScheduledExecution", environment, log_message)
}

/// `fmi3FreeInstance`
pub unsafe extern "C" fn free_instance<M: ArrayModel>(instance: *mut c_void) {
    if !instance.is_null() {
        // SAFETY: an instance that `fmi3InstantiateCoSimulation` boxed, given back once.
        let instance = unsafe { Box::from_raw(instance.cast::<Instance<M>>()) };
        // SAFETY: its component, which `make` returned.
        unsafe { free::<M, Table<M>>(instance.component) };
    }
}

/// `fmi3SetDebugLogging`
pub unsafe extern "C" fn set_debug_logging<M: ArrayModel>(
    instance: *mut c_void,
    logging_on: bool,
    count: usize,
    categories: *const *const c_char,
) -> Status {
    call::<M>(instance, "fmi3SetDebugLogging", |component| {
        component.slave.check(Function::SetDebugLogging)?;
        // SAFETY: as many texts as said.
        component.set_debug_logging(logging_on, &unsafe { texts(categories, count, "a category")? })
    })
}

/// `fmi3EnterInitializationMode`
pub unsafe extern "C" fn enter_initialization_mode<M: ArrayModel>(
    instance: *mut c_void,
    tolerance_defined: bool,
    tolerance: f64,
    start_time: f64,
    stop_time_defined: bool,
    stop_time: f64,
) -> Status {
    call::<M>(instance, "fmi3EnterInitializationMode", |component| {
        let (stop, tolerance) =
            (stop_time_defined.then_some(stop_time), tolerance_defined.then_some(tolerance));
        Ok(component.slave.begin(start_time, stop, tolerance)?)
    })
}

/// `fmi3ExitInitializationMode`
pub unsafe extern "C" fn exit_initialization_mode<M: ArrayModel>(instance: *mut c_void) -> Status {
    call::<M>(instance, "fmi3ExitInitializationMode", |component| {
        component.slave.end_initialization()?;
        component.tell_warnings();
        Ok(())
    })
}

/// `fmi3EnterConfigurationMode`
pub unsafe extern "C" fn enter_configuration_mode<M: ArrayModel>(instance: *mut c_void) -> Status {
    call::<M>(instance, "fmi3EnterConfigurationMode", |component| {
        Ok(component.slave.enter_configuration()?)
    })
}

/// `fmi3ExitConfigurationMode`
pub unsafe extern "C" fn exit_configuration_mode<M: ArrayModel>(instance: *mut c_void) -> Status {
    call::<M>(instance, "fmi3ExitConfigurationMode", |component| Ok(component.slave.exit_configuration()?))
}

/// `fmi3Terminate`
pub unsafe extern "C" fn terminate<M: ArrayModel>(instance: *mut c_void) -> Status {
    call::<M>(instance, "fmi3Terminate", |component| Ok(component.slave.terminate()?))
}

/// `fmi3Reset`
pub unsafe extern "C" fn reset<M: ArrayModel>(instance: *mut c_void) -> Status {
    call::<M>(instance, "fmi3Reset", |component| Ok(component.slave.reset()?))
}

/// `fmi3GetFloat64`
pub unsafe extern "C" fn get_float64<M: ArrayModel>(
    instance: *mut c_void,
    references: *const u32,
    count: usize,
    values: *mut f64,
    value_count: usize,
) -> Status {
    call::<M>(instance, "fmi3GetFloat64", |component| {
        // SAFETY: as many elements as said.
        let (references, values) = unsafe {
            (array(references, count, "valueReferences")?, array_mut(values, value_count, "values")?)
        };
        Ok(component.slave.get_float64(references, values)?)
    })
}

/// `fmi3GetInt32`
pub unsafe extern "C" fn get_int32<M: ArrayModel>(
    instance: *mut c_void,
    references: *const u32,
    count: usize,
    values: *mut i32,
    value_count: usize,
) -> Status {
    call::<M>(instance, "fmi3GetInt32", |component| {
        // SAFETY: as many elements as said.
        let (references, values) = unsafe {
            (array(references, count, "valueReferences")?, array_mut(values, value_count, "values")?)
        };
        Ok(component.slave.get_int32(references, values)?)
    })
}

/// `fmi3GetUInt64`
pub unsafe extern "C" fn get_uint64<M: ArrayModel>(
    instance: *mut c_void,
    references: *const u32,
    count: usize,
    values: *mut u64,
    value_count: usize,
) -> Status {
    call::<M>(instance, "fmi3GetUInt64", |component| {
        // SAFETY: as many elements as said.
        let (references, values) = unsafe {
            (array(references, count, "valueReferences")?, array_mut(values, value_count, "values")?)
        };
        Ok(component.slave.get_uint64(references, values)?)
    })
}

/// `fmi3GetString`: the texts live until the next call of this function or the end of the instance.
pub unsafe extern "C" fn get_string<M: ArrayModel>(
    instance: *mut c_void,
    references: *const u32,
    count: usize,
    values: *mut *const c_char,
    value_count: usize,
) -> Status {
    call::<M>(instance, "fmi3GetString", |component| {
        // SAFETY: as many elements as said.
        let (references, values) = unsafe {
            (array(references, count, "valueReferences")?, array_mut(values, value_count, "values")?)
        };
        let texts = component.slave.get_string(references, values.len())?;
        component.give_texts(texts, values);
        Ok(())
    })
}

/// `fmi3SetFloat64`
pub unsafe extern "C" fn set_float64<M: ArrayModel>(
    instance: *mut c_void,
    references: *const u32,
    count: usize,
    values: *const f64,
    value_count: usize,
) -> Status {
    call::<M>(instance, "fmi3SetFloat64", |component| {
        // SAFETY: as many elements as said.
        let (references, values) =
            unsafe { (array(references, count, "valueReferences")?, array(values, value_count, "values")?) };
        Ok(component.slave.set_float64(references, values)?)
    })
}

/// `fmi3SetInt32`
pub unsafe extern "C" fn set_int32<M: ArrayModel>(
    instance: *mut c_void,
    references: *const u32,
    count: usize,
    values: *const i32,
    value_count: usize,
) -> Status {
    call::<M>(instance, "fmi3SetInt32", |component| {
        // SAFETY: as many elements as said.
        let (references, values) =
            unsafe { (array(references, count, "valueReferences")?, array(values, value_count, "values")?) };
        Ok(component.slave.set_int32(references, values)?)
    })
}

/// `fmi3SetUInt64`
pub unsafe extern "C" fn set_uint64<M: ArrayModel>(
    instance: *mut c_void,
    references: *const u32,
    count: usize,
    values: *const u64,
    value_count: usize,
) -> Status {
    call::<M>(instance, "fmi3SetUInt64", |component| {
        // SAFETY: as many elements as said.
        let (references, values) =
            unsafe { (array(references, count, "valueReferences")?, array(values, value_count, "values")?) };
        Ok(component.slave.set_uint64(references, values)?)
    })
}

/// `fmi3SetString`
pub unsafe extern "C" fn set_string<M: ArrayModel>(
    instance: *mut c_void,
    references: *const u32,
    count: usize,
    values: *const *const c_char,
    value_count: usize,
) -> Status {
    call::<M>(instance, "fmi3SetString", |component| {
        // SAFETY: as many elements as said.
        let (references, values) =
            unsafe { (array(references, count, "valueReferences")?, texts(values, value_count, "a value")?) };
        component.slave.set_string(references, &values)?;
        component.tell_warnings();
        Ok(())
    })
}

/// `fmi3GetBoolean`
pub unsafe extern "C" fn get_boolean<M: ArrayModel>(
    instance: *mut c_void,
    references: *const u32,
    count: usize,
    values: *mut bool,
    value_count: usize,
) -> Status {
    call::<M>(instance, "fmi3GetBoolean", |component| {
        // SAFETY: as many elements as said; a bool is a byte, and 0 and 1 are written.
        let (references, values) = unsafe {
            (array(references, count, "valueReferences")?, array_mut(values.cast(), value_count, "values")?)
        };
        Ok(component.slave.get_boolean(references, values)?)
    })
}

/// `fmi3SetBoolean`
pub unsafe extern "C" fn set_boolean<M: ArrayModel>(
    instance: *mut c_void,
    references: *const u32,
    count: usize,
    values: *const bool,
    value_count: usize,
) -> Status {
    call::<M>(instance, "fmi3SetBoolean", |component| {
        // SAFETY: as many elements as said. They are read as bytes: an importer may write others than 0 and 1.
        let (references, values) = unsafe {
            (array(references, count, "valueReferences")?, array(values.cast(), value_count, "values")?)
        };
        Ok(component.slave.set_boolean(references, values)?)
    })
}

/// Functions for types that no variable has: right only without variables.
fn no_variables<M: ArrayModel>(
    instance: *mut c_void,
    name: &str,
    kind: &'static str,
    function: Function,
    references: *const u32,
    count: usize,
) -> Status {
    call::<M>(instance, name, |component| {
        component.slave.check(function)?;
        // SAFETY: as many elements as said.
        match unsafe { array(references, count, "valueReferences")? }.first() {
            None => Ok(()),
            Some(&reference) => Err(SlaveError::UnknownReference { kind, reference }.into()),
        }
    })
}

/// The bodies of functions that read or set a type that no variable has.
macro_rules! without_variables {
    ($($body:ident($type:ty) = $name:literal, $kind:literal, $function:ident;)*) => {
        $(
            #[doc = concat!("`", $name, "`: no variable has this type.")]
            pub unsafe extern "C" fn $body<M: ArrayModel>(
                instance: *mut c_void,
                references: *const u32,
                count: usize,
                _values: $type,
                _value_count: usize,
            ) -> Status {
                no_variables::<M>(instance, $name, $kind, Function::$function, references, count)
            }
        )*
    };
}

without_variables! {
    get_float32(*mut f32) = "fmi3GetFloat32", "Float32", Get;
    get_int8(*mut i8) = "fmi3GetInt8", "Int8", Get;
    get_uint8(*mut u8) = "fmi3GetUInt8", "UInt8", Get;
    get_int16(*mut i16) = "fmi3GetInt16", "Int16", Get;
    get_uint16(*mut u16) = "fmi3GetUInt16", "UInt16", Get;
    get_uint32(*mut u32) = "fmi3GetUInt32", "UInt32", Get;
    get_int64(*mut i64) = "fmi3GetInt64", "Int64", Get;
    set_float32(*const f32) = "fmi3SetFloat32", "Float32", Set;
    set_int8(*const i8) = "fmi3SetInt8", "Int8", Set;
    set_uint8(*const u8) = "fmi3SetUInt8", "UInt8", Set;
    set_int16(*const i16) = "fmi3SetInt16", "Int16", Set;
    set_uint16(*const u16) = "fmi3SetUInt16", "UInt16", Set;
    set_uint32(*const u32) = "fmi3SetUInt32", "UInt32", Set;
    set_int64(*const i64) = "fmi3SetInt64", "Int64", Set;
}

/// `fmi3GetClock`: no variable has this type.
pub unsafe extern "C" fn get_clock<M: ArrayModel>(
    instance: *mut c_void,
    references: *const u32,
    count: usize,
    _values: *mut bool,
) -> Status {
    no_variables::<M>(instance, "fmi3GetClock", "Clock", Function::Get, references, count)
}

/// `fmi3SetClock`: no variable has this type.
pub unsafe extern "C" fn set_clock<M: ArrayModel>(
    instance: *mut c_void,
    references: *const u32,
    count: usize,
    _values: *const bool,
) -> Status {
    no_variables::<M>(instance, "fmi3SetClock", "Clock", Function::Set, references, count)
}

/// `fmi3GetBinary`: no variable has this type.
pub unsafe extern "C" fn get_binary<M: ArrayModel>(
    instance: *mut c_void,
    references: *const u32,
    count: usize,
    _sizes: *mut usize,
    _values: *mut *const u8,
    _value_count: usize,
) -> Status {
    no_variables::<M>(instance, "fmi3GetBinary", "Binary", Function::Get, references, count)
}

/// `fmi3SetBinary`: no variable has this type.
pub unsafe extern "C" fn set_binary<M: ArrayModel>(
    instance: *mut c_void,
    references: *const u32,
    count: usize,
    _sizes: *const usize,
    _values: *const *const u8,
    _value_count: usize,
) -> Status {
    no_variables::<M>(instance, "fmi3SetBinary", "Binary", Function::Set, references, count)
}

/// `fmi3GetNumberOfVariableDependencies`
pub unsafe extern "C" fn get_number_of_variable_dependencies<M: ArrayModel>(
    instance: *mut c_void,
    reference: u32,
    count: *mut usize,
) -> Status {
    call::<M>(instance, "fmi3GetNumberOfVariableDependencies", |component| {
        let dependencies = component.slave.dependencies(reference)?;
        // SAFETY: NULL or the place of a number.
        *unsafe { count.as_mut() }.ok_or(Refusal::Null("nDependencies"))? = dependencies.len();
        Ok(())
    })
}

/// `fmi3Dependent`
const DEPENDENT: i32 = 5;

/// `fmi3GetVariableDependencies`
pub unsafe extern "C" fn get_variable_dependencies<M: ArrayModel>(
    instance: *mut c_void,
    reference: u32,
    dependents: *mut usize,
    independents: *mut u32,
    elements: *mut usize,
    kinds: *mut i32,
    count: usize,
) -> Status {
    call::<M>(instance, "fmi3GetVariableDependencies", |component| {
        let found = component.slave.dependencies(reference)?;
        if found.len() != count {
            return Err(SlaveError::ValueCount { given: count, wanted: found.len() as u64 }.into());
        }
        // SAFETY: as many elements as said.
        let (dependents, independents, elements, kinds) = unsafe {
            (
                array_mut(dependents, count, "elementIndicesOfDependent")?,
                array_mut(independents, count, "independents")?,
                array_mut(elements, count, "elementIndicesOfIndependents")?,
                array_mut(kinds, count, "dependencyKinds")?,
            )
        };
        for (k, (dependent, independent, element)) in found.into_iter().enumerate() {
            // FMI counts elements from 1; 0 would be all of them.
            (dependents[k], independents[k], elements[k], kinds[k]) =
                (dependent + 1, independent, element + 1, DEPENDENT);
        }
        Ok(())
    })
}

/// `fmi3GetFMUState`: a new state, or an old one overwritten.
pub unsafe extern "C" fn get_fmu_state<M: ArrayModel>(
    instance: *mut c_void,
    state: *mut *mut c_void,
) -> Status {
    call::<M>(instance, "fmi3GetFMUState", |component| {
        // SAFETY: NULL or the place of a state pointer.
        let place = unsafe { state.as_mut() }.ok_or(Refusal::Null("FMUState"))?;
        Ok(states::put(place, component.slave.snapshot()?)?)
    })
}

/// `fmi3SetFMUState`
pub unsafe extern "C" fn set_fmu_state<M: ArrayModel>(instance: *mut c_void, state: *mut c_void) -> Status {
    call::<M>(instance, "fmi3SetFMUState", |component| {
        component.slave.check(Function::State)?;
        let snapshot = component.state(state)?;
        Ok(component.slave.restore(&snapshot)?)
    })
}

/// `fmi3FreeFMUState`: NULL is fine, and it is NULL afterwards.
pub unsafe extern "C" fn free_fmu_state<M: ArrayModel>(
    instance: *mut c_void,
    state: *mut *mut c_void,
) -> Status {
    call::<M>(instance, "fmi3FreeFMUState", |component| {
        component.slave.check(Function::State)?;
        // SAFETY: NULL or the place of a state pointer.
        Ok(unsafe { state.as_mut() }.map_or(Ok(()), states::free)?)
    })
}

/// `fmi3SerializedFMUStateSize`
pub unsafe extern "C" fn serialized_fmu_state_size<M: ArrayModel>(
    instance: *mut c_void,
    state: *mut c_void,
    size: *mut usize,
) -> Status {
    call::<M>(instance, "fmi3SerializedFMUStateSize", |component| {
        component.slave.check(Function::State)?;
        let snapshot = component.state(state)?;
        // SAFETY: NULL or the place of a number.
        let size = unsafe { size.as_mut() }.ok_or(Refusal::Null("size"))?;
        *size = component.slave.serialize(&snapshot)?.len();
        Ok(())
    })
}

/// `fmi3SerializeFMUState`
pub unsafe extern "C" fn serialize_fmu_state<M: ArrayModel>(
    instance: *mut c_void,
    state: *mut c_void,
    bytes: *mut u8,
    size: usize,
) -> Status {
    call::<M>(instance, "fmi3SerializeFMUState", |component| {
        component.slave.check(Function::State)?;
        // SAFETY: NULL or as many bytes as said.
        component.serialize(state, unsafe { array_mut(bytes, size, "serializedState")? })
    })
}

/// `fmi3DeserializeFMUState`
pub unsafe extern "C" fn deserialize_fmu_state<M: ArrayModel>(
    instance: *mut c_void,
    bytes: *const u8,
    size: usize,
    state: *mut *mut c_void,
) -> Status {
    call::<M>(instance, "fmi3DeserializeFMUState", |component| {
        // SAFETY: NULL, or as many bytes as said and the place of a state pointer.
        let (bytes, place) = unsafe { (array(bytes, size, "serializedState")?, state.as_mut()) };
        let place = place.ok_or(Refusal::Null("FMUState"))?;
        Ok(states::put(place, component.slave.deserialize(bytes)?)?)
    })
}

/// A function that is not offered.
fn unsupported<M: ArrayModel>(
    instance: *mut c_void,
    name: &str,
    function: Function,
    why: &'static str,
) -> Status {
    call::<M>(instance, name, |component| {
        component.slave.check(function)?;
        Err(SlaveError::Unsupported(why).into())
    })
}

/// `fmi3GetDirectionalDerivative`: not provided.
pub unsafe extern "C" fn get_directional_derivative<M: ArrayModel>(
    instance: *mut c_void,
    _unknowns: *const u32,
    _unknown_count: usize,
    _knowns: *const u32,
    _known_count: usize,
    _seed: *const f64,
    _seed_count: usize,
    _sensitivity: *mut f64,
    _sensitivity_count: usize,
) -> Status {
    let why = "providesDirectionalDerivatives is false";
    unsupported::<M>(instance, "fmi3GetDirectionalDerivative", Function::GetDirectionalDerivative, why)
}

/// `fmi3GetAdjointDerivative`: not provided.
pub unsafe extern "C" fn get_adjoint_derivative<M: ArrayModel>(
    instance: *mut c_void,
    _unknowns: *const u32,
    _unknown_count: usize,
    _knowns: *const u32,
    _known_count: usize,
    _seed: *const f64,
    _seed_count: usize,
    _sensitivity: *mut f64,
    _sensitivity_count: usize,
) -> Status {
    let why = "providesAdjointDerivatives is false";
    unsupported::<M>(instance, "fmi3GetAdjointDerivative", Function::GetDirectionalDerivative, why)
}

/// `fmi3GetOutputDerivatives`
pub unsafe extern "C" fn get_output_derivatives<M: ArrayModel>(
    instance: *mut c_void,
    references: *const u32,
    count: usize,
    orders: *const i32,
    values: *mut f64,
    value_count: usize,
) -> Status {
    call::<M>(instance, "fmi3GetOutputDerivatives", |component| {
        // SAFETY: as many elements as said.
        let (references, orders, values) = unsafe {
            (
                array(references, count, "valueReferences")?,
                array(orders, count, "orders")?,
                array_mut(values, value_count, "values")?,
            )
        };
        Ok(component.slave.get_output_derivatives(references, orders, values)?)
    })
}

/// The functions of events, clocks and other kinds of FMUs: not offered.
macro_rules! not_offered {
    ($($body:ident($($argument:ident: $type:ty),*) = $name:literal;)*) => {
        $(
            #[doc = concat!("`", $name, "`: this FMU is for co-simulation without events and clocks.")]
            pub unsafe extern "C" fn $body<M: ArrayModel>(instance: *mut c_void $(, $argument: $type)*) -> Status {
                $(let _ = $argument;)*
                let why = "this FMU is for co-simulation without events and clocks";
                unsupported::<M>(instance, $name, Function::Unsupported, why)
            }
        )*
    };
}

not_offered! {
    enter_event_mode() = "fmi3EnterEventMode";
    enter_step_mode() = "fmi3EnterStepMode";
    enter_continuous_time_mode() = "fmi3EnterContinuousTimeMode";
    evaluate_discrete_states() = "fmi3EvaluateDiscreteStates";
    update_discrete_states(
        a: *mut bool, b: *mut bool, c: *mut bool, d: *mut bool, e: *mut bool, f: *mut f64
    ) = "fmi3UpdateDiscreteStates";
    get_interval_decimal(a: *const u32, b: usize, c: *mut f64, d: *mut i32) = "fmi3GetIntervalDecimal";
    get_interval_fraction(a: *const u32, b: usize, c: *mut u64, d: *mut u64, e: *mut i32) =
        "fmi3GetIntervalFraction";
    get_shift_decimal(a: *const u32, b: usize, c: *mut f64) = "fmi3GetShiftDecimal";
    get_shift_fraction(a: *const u32, b: usize, c: *mut u64, d: *mut u64) = "fmi3GetShiftFraction";
    set_interval_decimal(a: *const u32, b: usize, c: *const f64) = "fmi3SetIntervalDecimal";
    set_interval_fraction(a: *const u32, b: usize, c: *const u64, d: *const u64) = "fmi3SetIntervalFraction";
    set_shift_decimal(a: *const u32, b: usize, c: *const f64) = "fmi3SetShiftDecimal";
    set_shift_fraction(a: *const u32, b: usize, c: *const u64, d: *const u64) = "fmi3SetShiftFraction";
    completed_integrator_step(a: bool, b: *mut bool, c: *mut bool) = "fmi3CompletedIntegratorStep";
    set_time(a: f64) = "fmi3SetTime";
    set_continuous_states(a: *const f64, b: usize) = "fmi3SetContinuousStates";
    get_continuous_states(a: *mut f64, b: usize) = "fmi3GetContinuousStates";
    get_continuous_state_derivatives(a: *mut f64, b: usize) = "fmi3GetContinuousStateDerivatives";
    get_nominals_of_continuous_states(a: *mut f64, b: usize) = "fmi3GetNominalsOfContinuousStates";
    get_event_indicators(a: *mut f64, b: usize) = "fmi3GetEventIndicators";
    get_number_of_event_indicators(a: *mut usize) = "fmi3GetNumberOfEventIndicators";
    get_number_of_continuous_states(a: *mut usize) = "fmi3GetNumberOfContinuousStates";
    activate_model_partition(a: u32, b: f64) = "fmi3ActivateModelPartition";
}

/// `fmi3DoStep`
///
/// If the model wants values to be seen within the step, and the importer has given a callback for it, the step is done
/// in parts. No borrow of the instance is held while the callback runs: it reads values by calls of its own.
pub unsafe extern "C" fn do_step<M: ArrayModel>(
    instance: *mut c_void,
    current_communication_point: f64,
    communication_step_size: f64,
    _no_set_fmu_state_prior_to_current_point: bool,
    event_handling_needed: *mut bool,
    terminate_simulation: *mut bool,
    early_return: *mut bool,
    last_successful_time: *mut f64,
) -> Status {
    const NAME: &str = "fmi3DoStep";
    // SAFETY: NULL or an instance of ours by the contract of the module.
    let Some(intermediate) = (unsafe { instance.cast::<Instance<M>>().as_ref() }).map(|it| it.intermediate)
    else {
        return Status::Error;
    };
    let mut parts = Vec::new();
    let mut time = f64::NAN;
    let begun = call::<M>(instance, NAME, |component| {
        time = component.slave.time();
        let wanted = intermediate.update.is_some();
        parts = component.slave.parts(current_communication_point, communication_step_size, wanted)?;
        Ok(())
    });
    let mut status = begun;
    let mut returned_early = false;
    let last = parts.len().saturating_sub(1);
    for (k, part) in parts.iter().enumerate() {
        status = call::<M>(instance, NAME, |component| {
            component.slave.do_part(part)?;
            component.tell_warnings();
            Ok(())
        });
        if status != Status::Ok {
            break;
        }
        time = part.time;
        let Some(update) = intermediate.update.filter(|_| k < last) else { continue };
        let (mut requested, mut until) = (false, time);
        set_intermediate::<M>(instance, true);
        // SAFETY: the importer's callback, called as FMI says. No borrow of the instance is held.
        unsafe {
            update(
                intermediate.environment,
                time,
                false,
                true,
                true,
                intermediate.early_return_allowed,
                &raw mut requested,
                &raw mut until,
            );
        }
        set_intermediate::<M>(instance, false);
        // A time to return at that is later is reached by a later part.
        if requested && intermediate.early_return_allowed && (until <= time || until.is_nan()) {
            returned_early = true;
            break;
        }
    }
    // SAFETY: NULL or the places of values of the importer's.
    unsafe {
        let set = |place: *mut bool, value: bool| {
            if let Some(place) = place.as_mut() {
                *place = value;
            }
        };
        set(event_handling_needed, false);
        set(terminate_simulation, false);
        set(early_return, returned_early);
        if let Some(place) = last_successful_time.as_mut() {
            *place = time;
        }
    }
    status
}

fn set_intermediate<M: ArrayModel>(instance: *mut c_void, intermediate: bool) {
    call::<M>(instance, "fmi3DoStep", |component| {
        component.slave.set_intermediate(intermediate);
        Ok(())
    });
}
