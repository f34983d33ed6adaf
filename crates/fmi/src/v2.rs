//! The bodies of the C functions that only FMI 2.0 has, or has with other arguments than FMI 3.0.
//!
//! # Safety
//! That of [`calls`].

#![allow(unsafe_code)] // the C boundary
#![allow(clippy::missing_safety_doc)] // said once, above
#![allow(clippy::extra_unused_type_parameters)] // so that all bodies have the model as their parameter
#![allow(clippy::too_many_arguments)] // FMI's signatures

mod functions;

use crate::Version;
use crate::boundary::{Log, Logger, Logger2, Refusal, Status, array, call, silence_panics};
use crate::calls::{self, Arguments, Value};
use crate::lifecycle::Function;
use crate::location::Location;
use crate::model::Model;
use crate::slave::{Slave, SlaveError};
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
pub unsafe fn get_types_platform<M: Model>(_: &str) -> *const c_char {
    c"default".as_ptr()
}

/// `fmi2GetVersion`
pub unsafe fn get_version<M: Model>(_: &str) -> *const c_char {
    c"2.0".as_ptr()
}

/// `fmi2Instantiate`: NULL, after a message, when the instance cannot be made.
pub unsafe fn instantiate<M: Model>(
    name: &str,
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
    let log = Log {
        logger: Logger::V2(functions.logger),
        environment: functions.component_environment,
        instance_name: CString::default(),
        wanted: Log::wanted(logging_on != 0),
    };
    let arguments = Arguments {
        version: Version::V2,
        log,
        intermediate: None,
        unsupported: (fmu_type != 1).then_some("fmuType: this is a co-simulation FMU, no model exchange"),
        instance_name,
        token: (guid, "fmuGUID"),
        location: (resource_location, "fmuResourceLocation"),
        location_of: Location::Uri,
    };
    // SAFETY: the importer keeps FMI's contract; the same below.
    unsafe { calls::instantiate::<M>(name, arguments) }
}

/// `fmi2SetDebugLogging`
pub unsafe fn set_debug_logging<M: Model>(
    name: &str,
    instance: *mut c_void,
    logging_on: c_int,
    count: usize,
    categories: *const *const c_char,
) -> Status {
    unsafe { calls::set_logging::<M>(name, instance, logging_on != 0, count, categories) }
}

/// `fmi2SetupExperiment`
pub unsafe fn setup_experiment<M: Model>(
    name: &str,
    instance: *mut c_void,
    tolerance_defined: c_int,
    tolerance: f64,
    start_time: f64,
    stop_time_defined: c_int,
    stop_time: f64,
) -> Status {
    call::<M>(instance, name, |component| {
        let stop = (stop_time_defined != 0).then_some(stop_time);
        let tolerance = (tolerance_defined != 0).then_some(tolerance);
        Ok(component.slave.setup_experiment(start_time, stop, tolerance)?)
    })
}

/// `fmi2EnterInitializationMode`
pub unsafe fn enter_initialization_mode<M: Model>(name: &str, instance: *mut c_void) -> Status {
    call::<M>(instance, name, |component| Ok(component.slave.enter_initialization()?))
}

/// `fmi2GetReal`, `fmi2GetInteger`
pub unsafe fn get<M: Model>(
    name: &str,
    instance: *mut c_void,
    references: *const c_uint,
    count: usize,
    values: *mut impl Value,
) -> Status {
    unsafe { calls::get::<M>(name, instance, references, count, values, count) }
}

/// `fmi2SetReal`, `fmi2SetInteger`
pub unsafe fn set<M: Model>(
    name: &str,
    instance: *mut c_void,
    references: *const c_uint,
    count: usize,
    values: *const impl Value,
) -> Status {
    unsafe { calls::set::<M>(name, instance, references, count, values, count) }
}

/// `fmi2GetBoolean`
pub unsafe fn get_boolean<M: Model>(
    name: &str,
    instance: *mut c_void,
    references: *const c_uint,
    count: usize,
    values: *mut c_int,
) -> Status {
    unsafe { calls::get_booleans::<M>(name, instance, references, count, values, count) }
}

/// `fmi2SetBoolean`
pub unsafe fn set_boolean<M: Model>(
    name: &str,
    instance: *mut c_void,
    references: *const c_uint,
    count: usize,
    values: *const c_int,
) -> Status {
    unsafe { calls::set_booleans::<M>(name, instance, references, count, values, count) }
}

/// `fmi2GetString`
pub unsafe fn get_string<M: Model>(
    name: &str,
    instance: *mut c_void,
    references: *const c_uint,
    count: usize,
    values: *mut *const c_char,
) -> Status {
    unsafe { calls::get_string::<M>(name, instance, references, count, values, count) }
}

/// `fmi2SetString`
pub unsafe fn set_string<M: Model>(
    name: &str,
    instance: *mut c_void,
    references: *const c_uint,
    count: usize,
    values: *const *const c_char,
) -> Status {
    unsafe { calls::set_string::<M>(name, instance, references, count, values, count) }
}

/// `fmi2GetDirectionalDerivative`: not provided.
pub unsafe fn get_directional_derivative<M: Model>(
    name: &str,
    instance: *mut c_void,
    _unknowns: *const c_uint,
    _unknown_count: usize,
    _knowns: *const c_uint,
    _known_count: usize,
    _known_differentials: *const f64,
    _unknown_differentials: *mut f64,
) -> Status {
    call::<M>(instance, name, |component| {
        component.slave.check(Function::GetDirectionalDerivative)?;
        Err(SlaveError::Unsupported("providesDirectionalDerivative is false").into())
    })
}

/// `fmi2SetRealInputDerivatives`
pub unsafe fn set_real_input_derivatives<M: Model>(
    name: &str,
    instance: *mut c_void,
    references: *const c_uint,
    count: usize,
    orders: *const c_int,
    values: *const f64,
) -> Status {
    call::<M>(instance, name, |component| {
        // SAFETY: as many elements as said.
        let (references, orders, values) = unsafe {
            (array(references, count, "vr")?, array(orders, count, "order")?, array(values, count, "value")?)
        };
        Ok(component.slave.set_input_derivatives(references, orders, values)?)
    })
}

/// `fmi2GetRealOutputDerivatives`
pub unsafe fn get_real_output_derivatives<M: Model>(
    name: &str,
    instance: *mut c_void,
    references: *const c_uint,
    count: usize,
    orders: *const c_int,
    values: *mut f64,
) -> Status {
    unsafe { calls::get_output_derivatives::<M>(name, instance, references, count, orders, values, count) }
}

/// `fmi2DoStep`
pub unsafe fn do_step<M: Model>(
    name: &str,
    instance: *mut c_void,
    current_communication_point: f64,
    communication_step_size: f64,
    _no_set_fmu_state_prior_to_current_point: c_int,
) -> Status {
    calls::do_step::<M>(name, instance, current_communication_point, communication_step_size).0
}

/// `fmi2CancelStep`: a synchronous slave is never in the middle of a step.
pub unsafe fn cancel_step<M: Model>(name: &str, instance: *mut c_void) -> Status {
    call::<M>(instance, name, |component| Ok(component.slave.check(Function::CancelStep)?))
}

/// `fmi2StatusKind`
const LAST_SUCCESSFUL_TIME: c_int = 2;
const TERMINATED: c_int = 3;

/// Returns a status. Those about pending steps do not apply to a synchronous slave.
fn status<M: Model, T>(
    name: &str,
    instance: *mut c_void,
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

/// `fmi2GetStatus`, `fmi2GetIntegerStatus`, `fmi2GetStringStatus`: nothing has such a status.
pub unsafe fn get_status<M: Model>(
    name: &str,
    instance: *mut c_void,
    _kind: c_int,
    value: *mut impl Sized,
) -> Status {
    status::<M, _>(name, instance, value, |_| None)
}

/// `fmi2GetRealStatus`
pub unsafe fn get_real_status<M: Model>(
    name: &str,
    instance: *mut c_void,
    kind: c_int,
    value: *mut f64,
) -> Status {
    status::<M, _>(name, instance, value, |slave| (kind == LAST_SUCCESSFUL_TIME).then(|| slave.time()))
}

/// `fmi2GetBooleanStatus`
pub unsafe fn get_boolean_status<M: Model>(
    name: &str,
    instance: *mut c_void,
    kind: c_int,
    value: *mut c_int,
) -> Status {
    status::<M, _>(name, instance, value, |_| (kind == TERMINATED).then_some(0))
}
