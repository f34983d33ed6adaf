//! The bodies of the C functions that only FMI 3.0 has, or has with other arguments than FMI 2.0.
//!
//! # Safety
//! That of [`calls`].

#![allow(unsafe_code)] // the C boundary
#![allow(clippy::missing_safety_doc)] // said once, above
#![allow(clippy::extra_unused_type_parameters)] // so that all bodies have the model as their parameter
#![allow(clippy::too_many_arguments)] // FMI's signatures

mod functions;

use crate::Version;
use crate::boundary::{
    ERROR, Intermediate, Log, Logger, Refusal, Status, array, array_mut, call, silence_panics,
};
pub use crate::boundary::{IntermediateUpdate, Logger3};
use crate::calls::{self, Arguments, no_variables};
use crate::lifecycle::{Function, Phase};
use crate::location::Location;
use crate::model::Model;
use crate::slave::SlaveError;
use std::ffi::{CString, c_char, c_void};
use std::ptr::null_mut;

/// `fmi3GetVersion`
pub unsafe fn get_version<M: Model>(_: &str) -> *const c_char {
    c"3.0".as_ptr()
}

fn log(logger: Option<Logger3>, environment: *mut c_void, logging_on: bool) -> Log {
    let wanted = Log::wanted(logging_on);
    Log { logger: Logger::V3(logger), environment, instance_name: CString::default(), wanted }
}

/// `fmi3InstantiateCoSimulation`: NULL, after a message, when the instance cannot be made.
pub unsafe fn instantiate_co_simulation<M: Model>(
    name: &str,
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
    update: Option<IntermediateUpdate>,
) -> *mut c_void {
    silence_panics();
    let arguments = Arguments {
        version: Version::V3,
        log: log(log_message, environment, logging_on),
        intermediate: Some(Intermediate { update, environment, early_return_allowed }),
        unsupported: event_mode_used.then_some("eventModeUsed: hasEventMode is false"),
        instance_name,
        token: (token, "instantiationToken"),
        location: (resource_path, "resourcePath"),
        location_of: Location::Path,
    };
    // SAFETY: the importer keeps FMI's contract; the same below.
    unsafe { calls::instantiate::<M>(name, arguments) }
}

fn of_another_kind(name: &str, environment: *mut c_void, log_message: Option<Logger3>) -> *mut c_void {
    let message = format!("{name}: this FMU is for co-simulation only");
    log(log_message, environment, false).write(Status::Error, ERROR, &message);
    null_mut()
}

/// `fmi3InstantiateModelExchange`: not offered.
pub unsafe fn instantiate_model_exchange<M: Model>(
    name: &str,
    _instance_name: *const c_char,
    _token: *const c_char,
    _resource_path: *const c_char,
    _visible: bool,
    _logging_on: bool,
    environment: *mut c_void,
    log_message: Option<Logger3>,
) -> *mut c_void {
    of_another_kind(name, environment, log_message)
}

/// `fmi3InstantiateScheduledExecution`: not offered.
pub unsafe fn instantiate_scheduled_execution<M: Model>(
    name: &str,
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
    of_another_kind(name, environment, log_message)
}

/// `fmi3SetDebugLogging`
pub unsafe fn set_debug_logging<M: Model>(
    name: &str,
    instance: *mut c_void,
    logging_on: bool,
    count: usize,
    categories: *const *const c_char,
) -> Status {
    unsafe { calls::set_logging::<M>(name, instance, logging_on, count, categories) }
}

/// `fmi3EnterInitializationMode`
pub unsafe fn enter_initialization_mode<M: Model>(
    name: &str,
    instance: *mut c_void,
    tolerance_defined: bool,
    tolerance: f64,
    start_time: f64,
    stop_time_defined: bool,
    stop_time: f64,
) -> Status {
    call::<M>(instance, name, |component| {
        let (stop, tolerance) =
            (stop_time_defined.then_some(stop_time), tolerance_defined.then_some(tolerance));
        Ok(component.slave.enter_with_experiment(start_time, stop, tolerance)?)
    })
}

/// `fmi3EnterConfigurationMode`
pub unsafe fn enter_configuration_mode<M: Model>(name: &str, instance: *mut c_void) -> Status {
    call::<M>(instance, name, |component| {
        Ok(component.slave.change_phase(Function::EnterConfigurationMode, Phase::Configuration)?)
    })
}

/// `fmi3ExitConfigurationMode`
pub unsafe fn exit_configuration_mode<M: Model>(name: &str, instance: *mut c_void) -> Status {
    call::<M>(instance, name, |component| {
        Ok(component.slave.change_phase(Function::ExitConfigurationMode, Phase::Instantiated)?)
    })
}

/// `fmi3GetBoolean`
pub unsafe fn get_boolean<M: Model>(
    name: &str,
    instance: *mut c_void,
    references: *const u32,
    count: usize,
    values: *mut bool,
    value_count: usize,
) -> Status {
    // A bool is a byte, and 0 and 1 are written.
    unsafe { calls::get_booleans::<M>(name, instance, references, count, values.cast::<u8>(), value_count) }
}

/// `fmi3SetBoolean`
pub unsafe fn set_boolean<M: Model>(
    name: &str,
    instance: *mut c_void,
    references: *const u32,
    count: usize,
    values: *const bool,
    value_count: usize,
) -> Status {
    // As bytes: an importer may write others than 0 and 1.
    unsafe { calls::set_booleans::<M>(name, instance, references, count, values.cast::<u8>(), value_count) }
}

/// Reads or sets a type that no variable has: right only without variables.
unsafe fn without_variables<M: Model>(
    name: &str,
    instance: *mut c_void,
    kind: &'static str,
    references: *const u32,
    count: usize,
) -> Status {
    let function = if name.starts_with("fmi3Get") { Function::Get } else { Function::Set };
    call::<M>(instance, name, |component| {
        // SAFETY: as many elements as said.
        Ok(no_variables(&component.slave, function, kind, unsafe {
            array(references, count, "valueReferences")?
        })?)
    })
}

/// `fmi3GetClock`: no variable has this type.
pub unsafe fn get_clock<M: Model>(
    name: &str,
    instance: *mut c_void,
    references: *const u32,
    count: usize,
    _values: *mut bool,
) -> Status {
    unsafe { without_variables::<M>(name, instance, "Clock", references, count) }
}

/// `fmi3SetClock`: no variable has this type.
pub unsafe fn set_clock<M: Model>(
    name: &str,
    instance: *mut c_void,
    references: *const u32,
    count: usize,
    _values: *const bool,
) -> Status {
    unsafe { without_variables::<M>(name, instance, "Clock", references, count) }
}

/// `fmi3GetBinary`: no variable has this type.
pub unsafe fn get_binary<M: Model>(
    name: &str,
    instance: *mut c_void,
    references: *const u32,
    count: usize,
    _sizes: *mut usize,
    _values: *mut *const u8,
    _value_count: usize,
) -> Status {
    unsafe { without_variables::<M>(name, instance, "Binary", references, count) }
}

/// `fmi3SetBinary`: no variable has this type.
pub unsafe fn set_binary<M: Model>(
    name: &str,
    instance: *mut c_void,
    references: *const u32,
    count: usize,
    _sizes: *const usize,
    _values: *const *const u8,
    _value_count: usize,
) -> Status {
    unsafe { without_variables::<M>(name, instance, "Binary", references, count) }
}

/// `fmi3GetNumberOfVariableDependencies`
pub unsafe fn get_number_of_variable_dependencies<M: Model>(
    name: &str,
    instance: *mut c_void,
    reference: u32,
    count: *mut usize,
) -> Status {
    call::<M>(instance, name, |component| {
        let dependencies = component.slave.dependencies(reference)?;
        // SAFETY: NULL or the place of a number.
        *unsafe { count.as_mut() }.ok_or(Refusal::Null("nDependencies"))? = dependencies.len();
        Ok(())
    })
}

/// `fmi3Dependent`
const DEPENDENT: i32 = 5;

/// `fmi3GetVariableDependencies`
pub unsafe fn get_variable_dependencies<M: Model>(
    name: &str,
    instance: *mut c_void,
    reference: u32,
    dependents: *mut usize,
    independents: *mut u32,
    elements: *mut usize,
    kinds: *mut i32,
    count: usize,
) -> Status {
    call::<M>(instance, name, |component| {
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

fn unsupported<M: Model>(name: &str, instance: *mut c_void, function: Function, why: &'static str) -> Status {
    call::<M>(instance, name, |component| {
        component.slave.check(function)?;
        Err(SlaveError::Unsupported(why).into())
    })
}

/// `fmi3GetDirectionalDerivative`, `fmi3GetAdjointDerivative`: not provided.
pub unsafe fn get_directional_derivative<M: Model>(
    name: &str,
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
    let why = "providesDirectionalDerivatives and providesAdjointDerivatives are false";
    unsupported::<M>(name, instance, Function::GetDirectionalDerivative, why)
}

/// The functions of events, clocks and other kinds of FMUs: not offered.
pub unsafe fn not_offered<M: Model>(name: &str, instance: *mut c_void) -> Status {
    let why = "this FMU is for co-simulation without events and clocks";
    unsupported::<M>(name, instance, Function::Unsupported, why)
}

/// `fmi3DoStep`
pub unsafe fn do_step<M: Model>(
    name: &str,
    instance: *mut c_void,
    current_communication_point: f64,
    communication_step_size: f64,
    _no_set_fmu_state_prior_to_current_point: bool,
    event_handling_needed: *mut bool,
    terminate_simulation: *mut bool,
    early_return: *mut bool,
    last_successful_time: *mut f64,
) -> Status {
    if instance.is_null() {
        return Status::Error;
    }
    let (from, step) = (current_communication_point, communication_step_size);
    let (status, time, returned_early) = calls::do_step::<M>(name, instance, from, step);
    let flags =
        [(event_handling_needed, false), (terminate_simulation, false), (early_return, returned_early)];
    // SAFETY: NULL or the places of values of the importer's.
    unsafe {
        for (place, value) in flags {
            if let Some(place) = place.as_mut() {
                *place = value;
            }
        }
        if let Some(place) = last_successful_time.as_mut() {
            *place = time;
        }
    }
    status
}
