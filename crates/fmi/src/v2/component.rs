//! The bodies of the FMI 2.0 C functions, for any model: pointers in, statuses out, nothing else.
//! [`export_fmi2!`](crate::export_fmi2) gives them their C names.
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
#![allow(clippy::extra_unused_type_parameters)] // so that all bodies have the model as their parameter

use super::slave::{Slave, Table};
use crate::boundary::{
    Component, Log, Logger, Logger2, Refusal, Status, array, array_mut, make, text, texts,
};
use crate::boundary::{free, silence_panics};
use crate::lifecycle::Function;
use crate::location::Location;
use crate::model::Model;
use crate::slave::SlaveError;
use crate::states;
use std::ffi::{CString, c_char, c_int, c_uint, c_void};

/// `fmi2CallbackFunctions`; the memory functions may be NULL and are never used.
#[repr(C)]
#[derive(Clone, Copy)]
#[allow(missing_docs)] // FMI's own names
pub struct CallbackFunctions {
    pub logger: Option<Logger2>,
    pub allocate_memory: *const c_void,
    pub free_memory: *const c_void,
    pub step_finished: *const c_void,
    pub component_environment: *mut c_void,
}

/// `fmi2GetTypesPlatform`
pub extern "C" fn get_types_platform<M: Model>() -> *const c_char {
    c"default".as_ptr()
}

/// `fmi2GetVersion`
pub extern "C" fn get_version<M: Model>() -> *const c_char {
    c"2.0".as_ptr()
}

/// `fmi2Instantiate`: NULL, after a message, when the instance cannot be made.
pub unsafe extern "C" fn instantiate<M: Model>(
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
        logger: Logger::V2(functions.logger),
        environment: functions.component_environment,
        instance_name: CString::new(name.as_ref().map_or("", |name| *name)).unwrap_or_default(),
        wanted: Log::wanted(logging_on != 0),
    };
    make::<M, Table<M>>(log, "fmi2Instantiate", || {
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
        let model = M::load(Location::Uri(uri)).map_err(SlaveError::from)?;
        Ok(Slave::new(model, guid)?)
    })
}

/// `fmi2FreeInstance`
pub unsafe extern "C" fn free_instance<M: Model>(instance: *mut c_void) {
    // SAFETY: an instance that `fmi2Instantiate` made, given back once.
    unsafe { free::<M, Table<M>>(instance) }
}

/// Runs a call on an instance.
fn call<M: Model>(
    instance: *mut c_void,
    name: &str,
    body: impl FnOnce(&mut Component<M, Table<M>>) -> Result<(), Refusal<M>>,
) -> Status {
    crate::boundary::call(instance, name, body)
}

/// `fmi2SetDebugLogging`
pub unsafe extern "C" fn set_debug_logging<M: Model>(
    instance: *mut c_void,
    logging_on: c_int,
    count: usize,
    categories: *const *const c_char,
) -> Status {
    call::<M>(instance, "fmi2SetDebugLogging", |component| {
        component.slave.check(Function::SetDebugLogging)?;
        // SAFETY: as many texts as said.
        component.set_debug_logging(logging_on != 0, &unsafe { texts(categories, count, "a category")? })
    })
}

/// `fmi2SetupExperiment`
pub unsafe extern "C" fn setup_experiment<M: Model>(
    instance: *mut c_void,
    tolerance_defined: c_int,
    tolerance: f64,
    start_time: f64,
    stop_time_defined: c_int,
    stop_time: f64,
) -> Status {
    call::<M>(instance, "fmi2SetupExperiment", |component| {
        let stop = (stop_time_defined != 0).then_some(stop_time);
        let tolerance = (tolerance_defined != 0).then_some(tolerance);
        Ok(component.slave.setup_experiment(start_time, stop, tolerance)?)
    })
}

/// `fmi2EnterInitializationMode`
pub unsafe extern "C" fn enter_initialization_mode<M: Model>(instance: *mut c_void) -> Status {
    call::<M>(instance, "fmi2EnterInitializationMode", |component| {
        Ok(component.slave.enter_initialization()?)
    })
}

/// `fmi2ExitInitializationMode`
pub unsafe extern "C" fn exit_initialization_mode<M: Model>(instance: *mut c_void) -> Status {
    call::<M>(instance, "fmi2ExitInitializationMode", |component| {
        component.slave.exit_initialization()?;
        component.tell_warnings();
        Ok(())
    })
}

/// `fmi2Terminate`
pub unsafe extern "C" fn terminate<M: Model>(instance: *mut c_void) -> Status {
    call::<M>(instance, "fmi2Terminate", |component| Ok(component.slave.terminate()?))
}

/// `fmi2Reset`
pub unsafe extern "C" fn reset<M: Model>(instance: *mut c_void) -> Status {
    call::<M>(instance, "fmi2Reset", |component| Ok(component.slave.reset()?))
}

/// `fmi2GetReal`
pub unsafe extern "C" fn get_real<M: Model>(
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
pub unsafe extern "C" fn get_integer<M: Model>(
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

/// `fmi2GetBoolean`
pub unsafe extern "C" fn get_boolean<M: Model>(
    instance: *mut c_void,
    references: *const c_uint,
    count: usize,
    values: *mut c_int,
) -> Status {
    call::<M>(instance, "fmi2GetBoolean", |component| {
        // SAFETY: as many elements as said.
        let (references, values) =
            unsafe { (array(references, count, "vr")?, array_mut(values, count, "value")?) };
        Ok(component.slave.get_boolean(references, values)?)
    })
}

/// `fmi2GetString`: the texts live until the next call of this function or the end of the instance.
pub unsafe extern "C" fn get_string<M: Model>(
    instance: *mut c_void,
    references: *const c_uint,
    count: usize,
    values: *mut *const c_char,
) -> Status {
    call::<M>(instance, "fmi2GetString", |component| {
        // SAFETY: as many elements as said.
        let (references, values) =
            unsafe { (array(references, count, "vr")?, array_mut(values, count, "value")?) };
        let texts = component.slave.get_string(references)?.into_iter().map(str::to_owned).collect();
        component.give_texts(texts, values);
        Ok(())
    })
}

/// `fmi2SetReal`
pub unsafe extern "C" fn set_real<M: Model>(
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
pub unsafe extern "C" fn set_integer<M: Model>(
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

/// `fmi2SetBoolean`
pub unsafe extern "C" fn set_boolean<M: Model>(
    instance: *mut c_void,
    references: *const c_uint,
    count: usize,
    values: *const c_int,
) -> Status {
    call::<M>(instance, "fmi2SetBoolean", |component| {
        // SAFETY: as many elements as said.
        let (references, values) =
            unsafe { (array(references, count, "vr")?, array(values, count, "value")?) };
        Ok(component.slave.set_boolean(references, values)?)
    })
}

/// `fmi2SetString`
pub unsafe extern "C" fn set_string<M: Model>(
    instance: *mut c_void,
    references: *const c_uint,
    count: usize,
    values: *const *const c_char,
) -> Status {
    call::<M>(instance, "fmi2SetString", |component| {
        // SAFETY: as many elements as said.
        let (references, values) =
            unsafe { (array(references, count, "vr")?, texts(values, count, "a value")?) };
        component.slave.set_string(references, &values)?;
        component.tell_warnings();
        Ok(())
    })
}

/// `fmi2GetFMUstate`: a new state, or an old one overwritten.
pub unsafe extern "C" fn get_fmu_state<M: Model>(instance: *mut c_void, state: *mut *mut c_void) -> Status {
    call::<M>(instance, "fmi2GetFMUstate", |component| {
        // SAFETY: NULL or the place of a state pointer.
        let place = unsafe { state.as_mut() }.ok_or(Refusal::Null("FMUstate"))?;
        Ok(states::put(place, component.slave.snapshot()?)?)
    })
}

/// `fmi2SetFMUstate`
pub unsafe extern "C" fn set_fmu_state<M: Model>(instance: *mut c_void, state: *mut c_void) -> Status {
    call::<M>(instance, "fmi2SetFMUstate", |component| {
        component.slave.check(Function::State)?;
        let snapshot = component.state(state)?;
        Ok(component.slave.restore(&snapshot)?)
    })
}

/// `fmi2FreeFMUstate`: NULL is fine, and it is NULL afterwards.
pub unsafe extern "C" fn free_fmu_state<M: Model>(instance: *mut c_void, state: *mut *mut c_void) -> Status {
    call::<M>(instance, "fmi2FreeFMUstate", |component| {
        component.slave.check(Function::State)?;
        // SAFETY: NULL or the place of a state pointer.
        Ok(unsafe { state.as_mut() }.map_or(Ok(()), states::free)?)
    })
}

/// `fmi2SerializedFMUstateSize`
pub unsafe extern "C" fn serialized_fmu_state_size<M: Model>(
    instance: *mut c_void,
    state: *mut c_void,
    size: *mut usize,
) -> Status {
    call::<M>(instance, "fmi2SerializedFMUstateSize", |component| {
        component.slave.check(Function::State)?;
        let snapshot = component.state(state)?;
        // SAFETY: NULL or the place of a number.
        let size = unsafe { size.as_mut() }.ok_or(Refusal::Null("size"))?;
        *size = component.slave.serialize(&snapshot)?.len();
        Ok(())
    })
}

/// `fmi2SerializeFMUstate`
pub unsafe extern "C" fn serialize_fmu_state<M: Model>(
    instance: *mut c_void,
    state: *mut c_void,
    bytes: *mut u8,
    size: usize,
) -> Status {
    call::<M>(instance, "fmi2SerializeFMUstate", |component| {
        component.slave.check(Function::State)?;
        // SAFETY: NULL or as many bytes as said.
        component.serialize(state, unsafe { array_mut(bytes, size, "serializedState")? })
    })
}

/// `fmi2DeSerializeFMUstate`
pub unsafe extern "C" fn deserialize_fmu_state<M: Model>(
    instance: *mut c_void,
    bytes: *const u8,
    size: usize,
    state: *mut *mut c_void,
) -> Status {
    call::<M>(instance, "fmi2DeSerializeFMUstate", |component| {
        // SAFETY: NULL, or as many bytes as said and the place of a state pointer.
        let (bytes, place) = unsafe { (array(bytes, size, "serializedState")?, state.as_mut()) };
        let place = place.ok_or(Refusal::Null("FMUstate"))?;
        Ok(states::put(place, component.slave.deserialize(bytes)?)?)
    })
}

/// `fmi2GetDirectionalDerivative`: not provided.
pub unsafe extern "C" fn get_directional_derivative<M: Model>(
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
pub unsafe extern "C" fn set_real_input_derivatives<M: Model>(
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

/// `fmi2GetRealOutputDerivatives`
pub unsafe extern "C" fn get_real_output_derivatives<M: Model>(
    instance: *mut c_void,
    references: *const c_uint,
    count: usize,
    orders: *const c_int,
    values: *mut f64,
) -> Status {
    call::<M>(instance, "fmi2GetRealOutputDerivatives", |component| {
        // SAFETY: as many elements as said.
        let (references, orders, values) = unsafe {
            (
                array(references, count, "vr")?,
                array(orders, count, "order")?,
                array_mut(values, count, "value")?,
            )
        };
        Ok(component.slave.get_output_derivatives(references, orders, values)?)
    })
}

/// `fmi2DoStep`
pub unsafe extern "C" fn do_step<M: Model>(
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
pub unsafe extern "C" fn cancel_step<M: Model>(instance: *mut c_void) -> Status {
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
pub unsafe extern "C" fn get_status<M: Model>(
    instance: *mut c_void,
    _kind: c_int,
    value: *mut c_int,
) -> Status {
    status::<M, _>(instance, "fmi2GetStatus", value, |_| None)
}

/// `fmi2GetRealStatus`
pub unsafe extern "C" fn get_real_status<M: Model>(
    instance: *mut c_void,
    kind: c_int,
    value: *mut f64,
) -> Status {
    status::<M, _>(instance, "fmi2GetRealStatus", value, |slave| {
        (kind == LAST_SUCCESSFUL_TIME).then(|| slave.time())
    })
}

/// `fmi2GetIntegerStatus`
pub unsafe extern "C" fn get_integer_status<M: Model>(
    instance: *mut c_void,
    _kind: c_int,
    value: *mut c_int,
) -> Status {
    status::<M, _>(instance, "fmi2GetIntegerStatus", value, |_| None)
}

/// `fmi2GetBooleanStatus`
pub unsafe extern "C" fn get_boolean_status<M: Model>(
    instance: *mut c_void,
    kind: c_int,
    value: *mut c_int,
) -> Status {
    status::<M, _>(instance, "fmi2GetBooleanStatus", value, |_| (kind == TERMINATED).then_some(0))
}

/// `fmi2GetStringStatus`
pub unsafe extern "C" fn get_string_status<M: Model>(
    instance: *mut c_void,
    _kind: c_int,
    value: *mut *const c_char,
) -> Status {
    status::<M, _>(instance, "fmi2GetStringStatus", value, |_| None)
}
