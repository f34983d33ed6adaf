//! The 75 functions of FMI 3.0, declared here anew from the standard's headers, and a logger that keeps what it is told.
//!
//! [`Functions::of`] takes them from a shared library as an importer does; [`Functions::of_model`] calls their bodies for
//! a model, without a library.
//!
//! # Safety
//! All functions have the contract of FMI 3.0: an instance is one that `fmi3InstantiateCoSimulation` returned and that is
//! not freed, arrays have the length that is given, texts end with a zero. See [`lemons_fmi::v3::component`].

#![allow(unsafe_code)] // the C boundary, from the other side

use crate::answer::Answer;
use lemons_fmi::v3::ArrayModel;
use libloading::Library;
use std::ffi::{CStr, c_char, c_int, c_void};
use std::sync::{Mutex, PoisonError};

/// `fmi3LogMessageCallback`
pub type Logger3 = unsafe extern "C" fn(*mut c_void, c_int, *const c_char, *const c_char);
/// `fmi3IntermediateUpdateCallback`
pub type IntermediateUpdate =
    unsafe extern "C" fn(*mut c_void, f64, bool, bool, bool, bool, *mut bool, *mut f64);

macro_rules! functions {
    ($($name:ident = $body:ident($($argument:ident: $type:ty),*) $(-> $result:ty)?;)*) => {
        /// All functions of FMI 3.0.
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
            pub fn of_model<M: ArrayModel>() -> Functions {
                Functions { $($name: called::$body::<M>,)* }
            }
        }

        /// The bodies with the types and the calling convention of C.
        mod called {
            use super::*;
            $(
                #[allow(clippy::too_many_arguments)] // FMI's signatures
                pub unsafe extern "C" fn $body<M: ArrayModel>($($argument: $type),*) $(-> $result)? {
                    // SAFETY: the caller keeps the contract of FMI, which is that of the body.
                    unsafe { bodies::$body::<M>($($argument),*) }.answer()
                }
            )*
        }
    };
}

functions! {
    fmi3GetVersion = get_version() -> *const c_char;
    fmi3SetDebugLogging = set_debug_logging(
        instance: *mut c_void, logging_on: bool, n_categories: usize, categories: *const *const c_char
    ) -> c_int;
    fmi3InstantiateModelExchange = instantiate_model_exchange(
        instance_name: *const c_char, instantiation_token: *const c_char, resource_path: *const c_char,
        visible: bool, logging_on: bool, instance_environment: *mut c_void, log_message: Option<Logger3>
    ) -> *mut c_void;
    fmi3InstantiateCoSimulation = instantiate_co_simulation(
        instance_name: *const c_char, instantiation_token: *const c_char, resource_path: *const c_char,
        visible: bool, logging_on: bool, event_mode_used: bool, early_return_allowed: bool,
        required_intermediate_variables: *const u32, n_required_intermediate_variables: usize,
        instance_environment: *mut c_void, log_message: Option<Logger3>,
        intermediate_update: Option<IntermediateUpdate>
    ) -> *mut c_void;
    fmi3InstantiateScheduledExecution = instantiate_scheduled_execution(
        instance_name: *const c_char, instantiation_token: *const c_char, resource_path: *const c_char,
        visible: bool, logging_on: bool, instance_environment: *mut c_void, log_message: Option<Logger3>,
        clock_update: *const c_void, lock_preemption: *const c_void, unlock_preemption: *const c_void
    ) -> *mut c_void;
    fmi3FreeInstance = free_instance(instance: *mut c_void);
    fmi3EnterInitializationMode = enter_initialization_mode(
        instance: *mut c_void, tolerance_defined: bool, tolerance: f64, start_time: f64,
        stop_time_defined: bool, stop_time: f64
    ) -> c_int;
    fmi3ExitInitializationMode = exit_initialization_mode(instance: *mut c_void) -> c_int;
    fmi3EnterEventMode = enter_event_mode(instance: *mut c_void) -> c_int;
    fmi3Terminate = terminate(instance: *mut c_void) -> c_int;
    fmi3Reset = reset(instance: *mut c_void) -> c_int;
    fmi3GetFloat32 = get_float32(
        instance: *mut c_void, references: *const u32, count: usize, values: *mut f32, value_count: usize
    ) -> c_int;
    fmi3GetFloat64 = get_float64(
        instance: *mut c_void, references: *const u32, count: usize, values: *mut f64, value_count: usize
    ) -> c_int;
    fmi3GetInt8 = get_int8(
        instance: *mut c_void, references: *const u32, count: usize, values: *mut i8, value_count: usize
    ) -> c_int;
    fmi3GetUInt8 = get_uint8(
        instance: *mut c_void, references: *const u32, count: usize, values: *mut u8, value_count: usize
    ) -> c_int;
    fmi3GetInt16 = get_int16(
        instance: *mut c_void, references: *const u32, count: usize, values: *mut i16, value_count: usize
    ) -> c_int;
    fmi3GetUInt16 = get_uint16(
        instance: *mut c_void, references: *const u32, count: usize, values: *mut u16, value_count: usize
    ) -> c_int;
    fmi3GetInt32 = get_int32(
        instance: *mut c_void, references: *const u32, count: usize, values: *mut i32, value_count: usize
    ) -> c_int;
    fmi3GetUInt32 = get_uint32(
        instance: *mut c_void, references: *const u32, count: usize, values: *mut u32, value_count: usize
    ) -> c_int;
    fmi3GetInt64 = get_int64(
        instance: *mut c_void, references: *const u32, count: usize, values: *mut i64, value_count: usize
    ) -> c_int;
    fmi3GetUInt64 = get_uint64(
        instance: *mut c_void, references: *const u32, count: usize, values: *mut u64, value_count: usize
    ) -> c_int;
    fmi3GetBoolean = get_boolean(
        instance: *mut c_void, references: *const u32, count: usize, values: *mut bool, value_count: usize
    ) -> c_int;
    fmi3GetString = get_string(
        instance: *mut c_void, references: *const u32, count: usize, values: *mut *const c_char,
        value_count: usize
    ) -> c_int;
    fmi3GetBinary = get_binary(
        instance: *mut c_void, references: *const u32, count: usize, value_sizes: *mut usize,
        values: *mut *const u8, value_count: usize
    ) -> c_int;
    fmi3GetClock = get_clock(instance: *mut c_void, references: *const u32, count: usize, values: *mut bool) -> c_int;
    fmi3SetFloat32 = set_float32(
        instance: *mut c_void, references: *const u32, count: usize, values: *const f32, value_count: usize
    ) -> c_int;
    fmi3SetFloat64 = set_float64(
        instance: *mut c_void, references: *const u32, count: usize, values: *const f64, value_count: usize
    ) -> c_int;
    fmi3SetInt8 = set_int8(
        instance: *mut c_void, references: *const u32, count: usize, values: *const i8, value_count: usize
    ) -> c_int;
    fmi3SetUInt8 = set_uint8(
        instance: *mut c_void, references: *const u32, count: usize, values: *const u8, value_count: usize
    ) -> c_int;
    fmi3SetInt16 = set_int16(
        instance: *mut c_void, references: *const u32, count: usize, values: *const i16, value_count: usize
    ) -> c_int;
    fmi3SetUInt16 = set_uint16(
        instance: *mut c_void, references: *const u32, count: usize, values: *const u16, value_count: usize
    ) -> c_int;
    fmi3SetInt32 = set_int32(
        instance: *mut c_void, references: *const u32, count: usize, values: *const i32, value_count: usize
    ) -> c_int;
    fmi3SetUInt32 = set_uint32(
        instance: *mut c_void, references: *const u32, count: usize, values: *const u32, value_count: usize
    ) -> c_int;
    fmi3SetInt64 = set_int64(
        instance: *mut c_void, references: *const u32, count: usize, values: *const i64, value_count: usize
    ) -> c_int;
    fmi3SetUInt64 = set_uint64(
        instance: *mut c_void, references: *const u32, count: usize, values: *const u64, value_count: usize
    ) -> c_int;
    fmi3SetBoolean = set_boolean(
        instance: *mut c_void, references: *const u32, count: usize, values: *const bool, value_count: usize
    ) -> c_int;
    fmi3SetString = set_string(
        instance: *mut c_void, references: *const u32, count: usize, values: *const *const c_char,
        value_count: usize
    ) -> c_int;
    fmi3SetBinary = set_binary(
        instance: *mut c_void, references: *const u32, count: usize, value_sizes: *const usize,
        values: *const *const u8, value_count: usize
    ) -> c_int;
    fmi3SetClock = set_clock(instance: *mut c_void, references: *const u32, count: usize, values: *const bool) -> c_int;
    fmi3GetNumberOfVariableDependencies = get_number_of_variable_dependencies(
        instance: *mut c_void, value_reference: u32, n_dependencies: *mut usize
    ) -> c_int;
    fmi3GetVariableDependencies = get_variable_dependencies(
        instance: *mut c_void, dependent: u32, element_indices_of_dependent: *mut usize,
        independents: *mut u32, element_indices_of_independents: *mut usize, dependency_kinds: *mut i32,
        n_dependencies: usize
    ) -> c_int;
    fmi3GetFMUState = get_fmu_state(instance: *mut c_void, state: *mut *mut c_void) -> c_int;
    fmi3SetFMUState = set_fmu_state(instance: *mut c_void, state: *mut c_void) -> c_int;
    fmi3FreeFMUState = free_fmu_state(instance: *mut c_void, state: *mut *mut c_void) -> c_int;
    fmi3SerializedFMUStateSize = serialized_fmu_state_size(instance: *mut c_void, state: *mut c_void, size: *mut usize) -> c_int;
    fmi3SerializeFMUState = serialize_fmu_state(
        instance: *mut c_void, state: *mut c_void, serialized_state: *mut u8, size: usize
    ) -> c_int;
    fmi3DeserializeFMUState = deserialize_fmu_state(
        instance: *mut c_void, serialized_state: *const u8, size: usize, state: *mut *mut c_void
    ) -> c_int;
    fmi3GetDirectionalDerivative = get_directional_derivative(
        instance: *mut c_void, unknowns: *const u32, n_unknowns: usize, knowns: *const u32,
        n_knowns: usize, seed: *const f64, n_seed: usize, sensitivity: *mut f64, n_sensitivity: usize
    ) -> c_int;
    fmi3GetAdjointDerivative = get_adjoint_derivative(
        instance: *mut c_void, unknowns: *const u32, n_unknowns: usize, knowns: *const u32,
        n_knowns: usize, seed: *const f64, n_seed: usize, sensitivity: *mut f64, n_sensitivity: usize
    ) -> c_int;
    fmi3EnterConfigurationMode = enter_configuration_mode(instance: *mut c_void) -> c_int;
    fmi3ExitConfigurationMode = exit_configuration_mode(instance: *mut c_void) -> c_int;
    fmi3GetIntervalDecimal = get_interval_decimal(
        instance: *mut c_void, references: *const u32, count: usize, intervals: *mut f64,
        qualifiers: *mut i32
    ) -> c_int;
    fmi3GetIntervalFraction = get_interval_fraction(
        instance: *mut c_void, references: *const u32, count: usize, counters: *mut u64,
        resolutions: *mut u64, qualifiers: *mut i32
    ) -> c_int;
    fmi3GetShiftDecimal = get_shift_decimal(
        instance: *mut c_void, references: *const u32, count: usize, shifts: *mut f64
    ) -> c_int;
    fmi3GetShiftFraction = get_shift_fraction(
        instance: *mut c_void, references: *const u32, count: usize, counters: *mut u64,
        resolutions: *mut u64
    ) -> c_int;
    fmi3SetIntervalDecimal = set_interval_decimal(
        instance: *mut c_void, references: *const u32, count: usize, intervals: *const f64
    ) -> c_int;
    fmi3SetIntervalFraction = set_interval_fraction(
        instance: *mut c_void, references: *const u32, count: usize, counters: *const u64,
        resolutions: *const u64
    ) -> c_int;
    fmi3SetShiftDecimal = set_shift_decimal(
        instance: *mut c_void, references: *const u32, count: usize, shifts: *const f64
    ) -> c_int;
    fmi3SetShiftFraction = set_shift_fraction(
        instance: *mut c_void, references: *const u32, count: usize, counters: *const u64,
        resolutions: *const u64
    ) -> c_int;
    fmi3EvaluateDiscreteStates = evaluate_discrete_states(instance: *mut c_void) -> c_int;
    fmi3UpdateDiscreteStates = update_discrete_states(
        instance: *mut c_void, discrete_states_need_update: *mut bool, terminate_simulation: *mut bool,
        nominals_of_continuous_states_changed: *mut bool, values_of_continuous_states_changed: *mut bool,
        next_event_time_defined: *mut bool, next_event_time: *mut f64
    ) -> c_int;
    fmi3EnterContinuousTimeMode = enter_continuous_time_mode(instance: *mut c_void) -> c_int;
    fmi3CompletedIntegratorStep = completed_integrator_step(
        instance: *mut c_void, no_set_state_prior_to_current_point: bool, enter_event_mode: *mut bool,
        terminate_simulation: *mut bool
    ) -> c_int;
    fmi3SetTime = set_time(instance: *mut c_void, time: f64) -> c_int;
    fmi3SetContinuousStates = set_continuous_states(
        instance: *mut c_void, continuous_states: *const f64, n_continuous_states: usize
    ) -> c_int;
    fmi3GetContinuousStateDerivatives = get_continuous_state_derivatives(
        instance: *mut c_void, derivatives: *mut f64, n_continuous_states: usize
    ) -> c_int;
    fmi3GetEventIndicators = get_event_indicators(
        instance: *mut c_void, event_indicators: *mut f64, n_event_indicators: usize
    ) -> c_int;
    fmi3GetContinuousStates = get_continuous_states(
        instance: *mut c_void, continuous_states: *mut f64, n_continuous_states: usize
    ) -> c_int;
    fmi3GetNominalsOfContinuousStates = get_nominals_of_continuous_states(
        instance: *mut c_void, nominals: *mut f64, n_continuous_states: usize
    ) -> c_int;
    fmi3GetNumberOfEventIndicators = get_number_of_event_indicators(instance: *mut c_void, n_event_indicators: *mut usize) -> c_int;
    fmi3GetNumberOfContinuousStates = get_number_of_continuous_states(instance: *mut c_void, n_continuous_states: *mut usize) -> c_int;
    fmi3EnterStepMode = enter_step_mode(instance: *mut c_void) -> c_int;
    fmi3GetOutputDerivatives = get_output_derivatives(
        instance: *mut c_void, references: *const u32, count: usize, orders: *const i32, values: *mut f64,
        value_count: usize
    ) -> c_int;
    fmi3DoStep = do_step(
        instance: *mut c_void, current_communication_point: f64, communication_step_size: f64,
        no_set_state_prior_to_current_point: bool, event_handling_needed: *mut bool,
        terminate_simulation: *mut bool, early_return: *mut bool, last_successful_time: *mut f64
    ) -> c_int;
    fmi3ActivateModelPartition = activate_model_partition(instance: *mut c_void, clock_reference: u32, activation_time: f64) -> c_int;
}

/// The bodies, with the logger as it is declared here, and all with the model as their parameter.
#[allow(clippy::extra_unused_type_parameters, clippy::too_many_arguments)] // FMI's signatures
mod bodies {
    use super::{ArrayModel, IntermediateUpdate, Logger3, c_char, c_void};
    use lemons_fmi::v3::component;
    pub use lemons_fmi::v3::component::*;

    /// The same function: its status is declared as a number here, which is what it is in C.
    fn logger(logger: Option<Logger3>) -> Option<component::Logger3> {
        // SAFETY: the types differ in the status only, an enumeration with the layout of C.
        logger.map(|logger| unsafe { std::mem::transmute::<Logger3, component::Logger3>(logger) })
    }

    pub unsafe fn get_version<M: ArrayModel>() -> *const c_char {
        component::get_version()
    }

    pub unsafe fn instantiate_model_exchange<M: ArrayModel>(
        name: *const c_char,
        token: *const c_char,
        path: *const c_char,
        visible: bool,
        logging_on: bool,
        environment: *mut c_void,
        log: Option<Logger3>,
    ) -> *mut c_void {
        let log = logger(log);
        // SAFETY: the caller keeps the contract of FMI.
        unsafe {
            component::instantiate_model_exchange::<M>(
                name,
                token,
                path,
                visible,
                logging_on,
                environment,
                log,
            )
        }
    }

    pub unsafe fn instantiate_scheduled_execution<M: ArrayModel>(
        name: *const c_char,
        token: *const c_char,
        path: *const c_char,
        visible: bool,
        logging_on: bool,
        environment: *mut c_void,
        log: Option<Logger3>,
        update: *const c_void,
        lock: *const c_void,
        unlock: *const c_void,
    ) -> *mut c_void {
        let log = logger(log);
        // SAFETY: the caller keeps the contract of FMI.
        unsafe {
            component::instantiate_scheduled_execution::<M>(
                name,
                token,
                path,
                visible,
                logging_on,
                environment,
                log,
                update,
                lock,
                unlock,
            )
        }
    }

    pub unsafe fn instantiate_co_simulation<M: ArrayModel>(
        name: *const c_char,
        token: *const c_char,
        path: *const c_char,
        visible: bool,
        logging_on: bool,
        events: bool,
        early: bool,
        required: *const u32,
        required_count: usize,
        environment: *mut c_void,
        log: Option<Logger3>,
        update: Option<IntermediateUpdate>,
    ) -> *mut c_void {
        let log = logger(log);
        // SAFETY: the caller keeps the contract of FMI.
        unsafe {
            component::instantiate_co_simulation::<M>(
                name,
                token,
                path,
                visible,
                logging_on,
                events,
                early,
                required,
                required_count,
                environment,
                log,
                update,
            )
        }
    }
}

/// A message of an instance: its status, its category, its text.
pub type Message = (c_int, String, String);

/// Keeps the messages of an instance, whose environment it is. It must not move while the instance lives.
#[derive(Debug, Default)]
pub struct Log(Mutex<Vec<Message>>);

impl Log {
    /// The messages since the last call.
    pub fn take(&self) -> Vec<Message> {
        std::mem::take(&mut *self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

/// The logger that keeps messages in a [`Log`].
///
/// # Safety
/// The environment is a `Log`, the texts end with a zero.
pub unsafe extern "C" fn log(
    environment: *mut c_void,
    status: c_int,
    category: *const c_char,
    message: *const c_char,
) {
    // SAFETY: as said above.
    let (log, category, message) =
        unsafe { (&*environment.cast::<Log>(), CStr::from_ptr(category), CStr::from_ptr(message)) };
    let text = |text: &CStr| text.to_str().expect("the logger gets UTF-8 text").to_owned();
    log.0.lock().unwrap_or_else(PoisonError::into_inner).push((status, text(category), text(message)));
}
