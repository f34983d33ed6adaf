//! The functions of FMI 2.0 and FMI 3.0: their C names and signatures, said once for exports,
//! importers and tests.
//!
//! `fmi2_functions! { [my_macro] first … }` becomes `my_macro! { first … }` with two lists, and so does
//! `fmi3_functions!`. Types are those of the caller: an importer declares `Status` as a number.
//!
//! - The functions of the first list are said whole. Behind `=` is the body in this crate, and what
//!   it gets of the arguments.
//! - Those after `[of an instance]` also take the instance, before all else, and return a status.
//!   Behind `=` is a method of [`Component`](crate::boundary::Component).

/// Defines the C functions of the lists.
#[doc(hidden)]
#[macro_export]
macro_rules! export_functions {
    (
        $model:path;
        $($name:ident($($argument:ident: $type:ty),*) $(-> $result:ty)?
            = $module:ident::$body:ident($($with:expr),*);)*
        [of an instance]
        $($call:ident($($given:ident: $of:ty),*) = $method:ident($($passed:expr),*);)*
    ) => {
        $(
            #[doc = concat!("`", stringify!($name), "`")]
            #[allow(unused_variables)] // what is not offered takes arguments, too
            #[unsafe(no_mangle)]
            pub unsafe extern "C" fn $name($($argument: $type),*) $(-> $result)? {
                // SAFETY: the importer keeps FMI's contract, which is the body's.
                unsafe { $crate::$module::$body::<$model>(stringify!($name) $(, $with)*) }
            }
        )*
        $(
            #[doc = concat!("`", stringify!($call), "`")]
            #[allow(unused_variables)] // as above
            #[unsafe(no_mangle)]
            pub unsafe extern "C" fn $call(instance: *mut c_void $(, $given: $of)*) -> Status {
                // SAFETY: as above.
                unsafe {
                    $crate::boundary::call::<$model>(instance, stringify!($call), |component| {
                        component.$method($($passed),*)
                    })
                }
            }
        )*
    };
}

/// Gives the 34 functions of FMI 2.0 co-simulation to a macro, after the tokens that follow its name.
#[macro_export]
macro_rules! fmi2_functions {
    ([$($callback:tt)+] $($first:tt)*) => { $($callback)+! { $($first)*
        fmi2GetTypesPlatform() -> *const c_char = calls::text(c"default");
        fmi2GetVersion() -> *const c_char = calls::text(c"2.0");
        fmi2Instantiate(
            instance_name: *const c_char, fmu_type: c_int, guid: *const c_char,
            resource_location: *const c_char, functions: *const CallbackFunctions, visible: c_int,
            logging_on: c_int
        ) -> *mut c_void
            = v2::instantiate(instance_name, fmu_type, guid, resource_location, functions, logging_on);
        fmi2FreeInstance(instance: *mut c_void) = boundary::free(instance);
        fmi2DoStep(
            instance: *mut c_void, current_communication_point: f64, communication_step_size: f64,
            no_set_fmu_state_prior_to_current_point: c_int
        ) -> Status = calls::do_step(
            instance, current_communication_point, communication_step_size,
            [std::ptr::null_mut(); 3], std::ptr::null_mut()
        );
        [of an instance]
        fmi2SetDebugLogging(on: c_int, count: usize, categories: *const *const c_char)
            = set_debug_logging(on, (categories, count));
        fmi2SetupExperiment(
            tolerance_defined: c_int, tolerance: f64, start: f64, stop_defined: c_int, stop: f64
        ) = setup_experiment(tolerance_defined, tolerance, start, stop_defined, stop);
        fmi2EnterInitializationMode() = enter_initialization_mode();
        fmi2ExitInitializationMode() = exit_initialization_mode();
        fmi2Terminate() = terminate();
        fmi2Reset() = reset();
        fmi2GetReal(vr: *const c_uint, nvr: usize, values: *mut f64) = get((vr, nvr), (values, nvr));
        fmi2GetInteger(vr: *const c_uint, nvr: usize, values: *mut c_int) = get((vr, nvr), (values, nvr));
        fmi2GetBoolean(vr: *const c_uint, nvr: usize, values: *mut c_int)
            = get((vr, nvr), (values.cast::<$crate::variables::Flag<c_int>>(), nvr));
        fmi2GetString(vr: *const c_uint, nvr: usize, values: *mut *const c_char)
            = get_strings((vr, nvr), (values, nvr));
        fmi2SetReal(vr: *const c_uint, nvr: usize, values: *const f64) = set((vr, nvr), (values, nvr));
        fmi2SetInteger(vr: *const c_uint, nvr: usize, values: *const c_int) = set((vr, nvr), (values, nvr));
        fmi2SetBoolean(vr: *const c_uint, nvr: usize, values: *const c_int)
            = set((vr, nvr), (values.cast::<$crate::variables::Flag<c_int>>(), nvr));
        fmi2SetString(vr: *const c_uint, nvr: usize, values: *const *const c_char)
            = set_strings((vr, nvr), (values, nvr));
        fmi2GetFMUstate(state: *mut *mut c_void) = get_state(state);
        fmi2SetFMUstate(state: *mut c_void) = set_state(state);
        fmi2FreeFMUstate(state: *mut *mut c_void) = free_state(state);
        fmi2SerializedFMUstateSize(state: *mut c_void, size: *mut usize) = state_size(state, size);
        fmi2SerializeFMUstate(state: *mut c_void, bytes: *mut u8, size: usize)
            = serialize_state(state, (bytes, size));
        fmi2DeSerializeFMUstate(bytes: *const u8, size: usize, state: *mut *mut c_void)
            = deserialize_state((bytes, size), state);
        fmi2GetDirectionalDerivative(
            unknowns: *const c_uint, unknown_count: usize, knowns: *const c_uint, known_count: usize,
            known_differentials: *const f64, unknown_differentials: *mut f64
        ) = no_directional_derivative();
        fmi2SetRealInputDerivatives(
            vr: *const c_uint, nvr: usize, orders: *const c_int, values: *const f64
        ) = set_input_derivatives((vr, nvr), (orders, nvr), (values, nvr));
        fmi2GetRealOutputDerivatives(
            vr: *const c_uint, nvr: usize, orders: *const c_int, values: *mut f64
        ) = get_output_derivatives((vr, nvr), (orders, nvr), (values, nvr));
        fmi2CancelStep() = cancel_step();
        fmi2GetStatus(kind: c_int, value: *mut c_int) = get_no_status(value);
        fmi2GetRealStatus(kind: c_int, value: *mut f64) = get_real_status(kind, value);
        fmi2GetIntegerStatus(kind: c_int, value: *mut c_int) = get_no_status(value);
        fmi2GetBooleanStatus(kind: c_int, value: *mut c_int) = get_boolean_status(kind, value);
        fmi2GetStringStatus(kind: c_int, value: *mut *const c_char) = get_no_status(value);
    } };
}

/// Gives the 75 functions of FMI 3.0 to a macro, after the tokens that follow its name.
#[macro_export]
macro_rules! fmi3_functions {
    ([$($callback:tt)+] $($first:tt)*) => { $($callback)+! { $($first)*
        fmi3GetVersion() -> *const c_char = calls::text(c"3.0");
        fmi3InstantiateModelExchange(
            instance_name: *const c_char, instantiation_token: *const c_char,
            resource_path: *const c_char, visible: bool, logging_on: bool,
            instance_environment: *mut c_void, log_message: Option<Logger3>
        ) -> *mut c_void = v3::instantiate_another_kind(instance_environment, log_message);
        fmi3InstantiateCoSimulation(
            instance_name: *const c_char, instantiation_token: *const c_char,
            resource_path: *const c_char, visible: bool, logging_on: bool, event_mode_used: bool,
            early_return_allowed: bool, required_intermediate_variables: *const u32,
            n_required_intermediate_variables: usize, instance_environment: *mut c_void,
            log_message: Option<Logger3>, intermediate_update: Option<IntermediateUpdate>
        ) -> *mut c_void = v3::instantiate_co_simulation(
            instance_name, instantiation_token, resource_path, logging_on, event_mode_used,
            early_return_allowed, instance_environment, log_message, intermediate_update
        );
        fmi3InstantiateScheduledExecution(
            instance_name: *const c_char, instantiation_token: *const c_char,
            resource_path: *const c_char, visible: bool, logging_on: bool,
            instance_environment: *mut c_void, log_message: Option<Logger3>,
            clock_update: *const c_void, lock_preemption: *const c_void,
            unlock_preemption: *const c_void
        ) -> *mut c_void = v3::instantiate_another_kind(instance_environment, log_message);
        fmi3FreeInstance(instance: *mut c_void) = boundary::free(instance);
        fmi3DoStep(
            instance: *mut c_void, current_communication_point: f64, communication_step_size: f64,
            no_set_state_prior_to_current_point: bool, event_handling_needed: *mut bool,
            terminate_simulation: *mut bool, early_return: *mut bool, last_successful_time: *mut f64
        ) -> Status = calls::do_step(
            instance, current_communication_point, communication_step_size,
            [event_handling_needed, terminate_simulation, early_return], last_successful_time
        );
        [of an instance]
        fmi3SetDebugLogging(on: bool, count: usize, categories: *const *const c_char)
            = set_debug_logging(on, (categories, count));
        fmi3EnterInitializationMode(
            tolerance_defined: bool, tolerance: f64, start: f64, stop_defined: bool, stop: f64
        ) = enter_with_experiment(tolerance_defined, tolerance, start, stop_defined, stop);
        fmi3ExitInitializationMode() = exit_initialization_mode();
        fmi3Terminate() = terminate();
        fmi3Reset() = reset();
        fmi3GetFloat32(vr: *const u32, nvr: usize, values: *mut f32, n: usize) = no_variables((vr, nvr));
        fmi3GetFloat64(vr: *const u32, nvr: usize, values: *mut f64, n: usize) = get((vr, nvr), (values, n));
        fmi3GetInt8(vr: *const u32, nvr: usize, values: *mut i8, n: usize) = no_variables((vr, nvr));
        fmi3GetUInt8(vr: *const u32, nvr: usize, values: *mut u8, n: usize) = no_variables((vr, nvr));
        fmi3GetInt16(vr: *const u32, nvr: usize, values: *mut i16, n: usize) = no_variables((vr, nvr));
        fmi3GetUInt16(vr: *const u32, nvr: usize, values: *mut u16, n: usize) = no_variables((vr, nvr));
        fmi3GetInt32(vr: *const u32, nvr: usize, values: *mut i32, n: usize) = get((vr, nvr), (values, n));
        fmi3GetUInt32(vr: *const u32, nvr: usize, values: *mut u32, n: usize) = no_variables((vr, nvr));
        fmi3GetInt64(vr: *const u32, nvr: usize, values: *mut i64, n: usize) = no_variables((vr, nvr));
        fmi3GetUInt64(vr: *const u32, nvr: usize, values: *mut u64, n: usize) = get((vr, nvr), (values, n));
        fmi3GetBoolean(vr: *const u32, nvr: usize, values: *mut bool, n: usize)
            = get((vr, nvr), (values.cast::<$crate::variables::Flag<u8>>(), n));
        fmi3GetString(vr: *const u32, nvr: usize, values: *mut *const c_char, n: usize)
            = get_strings((vr, nvr), (values, n));
        fmi3GetBinary(
            vr: *const u32, nvr: usize, sizes: *mut usize, values: *mut *const u8, n: usize
        ) = no_variables((vr, nvr));
        fmi3GetClock(vr: *const u32, nvr: usize, values: *mut bool) = no_variables((vr, nvr));
        fmi3SetFloat32(vr: *const u32, nvr: usize, values: *const f32, n: usize) = no_variables((vr, nvr));
        fmi3SetFloat64(vr: *const u32, nvr: usize, values: *const f64, n: usize)
            = set((vr, nvr), (values, n));
        fmi3SetInt8(vr: *const u32, nvr: usize, values: *const i8, n: usize) = no_variables((vr, nvr));
        fmi3SetUInt8(vr: *const u32, nvr: usize, values: *const u8, n: usize) = no_variables((vr, nvr));
        fmi3SetInt16(vr: *const u32, nvr: usize, values: *const i16, n: usize) = no_variables((vr, nvr));
        fmi3SetUInt16(vr: *const u32, nvr: usize, values: *const u16, n: usize) = no_variables((vr, nvr));
        fmi3SetInt32(vr: *const u32, nvr: usize, values: *const i32, n: usize) = set((vr, nvr), (values, n));
        fmi3SetUInt32(vr: *const u32, nvr: usize, values: *const u32, n: usize) = no_variables((vr, nvr));
        fmi3SetInt64(vr: *const u32, nvr: usize, values: *const i64, n: usize) = no_variables((vr, nvr));
        fmi3SetUInt64(vr: *const u32, nvr: usize, values: *const u64, n: usize) = set((vr, nvr), (values, n));
        fmi3SetBoolean(vr: *const u32, nvr: usize, values: *const bool, n: usize)
            = set((vr, nvr), (values.cast::<$crate::variables::Flag<u8>>(), n));
        fmi3SetString(vr: *const u32, nvr: usize, values: *const *const c_char, n: usize)
            = set_strings((vr, nvr), (values, n));
        fmi3SetBinary(
            vr: *const u32, nvr: usize, sizes: *const usize, values: *const *const u8, n: usize
        ) = no_variables((vr, nvr));
        fmi3SetClock(vr: *const u32, nvr: usize, values: *const bool) = no_variables((vr, nvr));
        fmi3GetNumberOfVariableDependencies(vr: u32, count: *mut usize)
            = get_number_of_variable_dependencies(vr, count);
        fmi3GetVariableDependencies(
            dependent: u32, elements_of_dependent: *mut usize, independents: *mut u32,
            elements_of_independents: *mut usize, kinds: *mut i32, count: usize
        ) = get_variable_dependencies(
            dependent, elements_of_dependent, independents, elements_of_independents, kinds, count
        );
        fmi3GetFMUState(state: *mut *mut c_void) = get_state(state);
        fmi3SetFMUState(state: *mut c_void) = set_state(state);
        fmi3FreeFMUState(state: *mut *mut c_void) = free_state(state);
        fmi3SerializedFMUStateSize(state: *mut c_void, size: *mut usize) = state_size(state, size);
        fmi3SerializeFMUState(state: *mut c_void, bytes: *mut u8, size: usize)
            = serialize_state(state, (bytes, size));
        fmi3DeserializeFMUState(bytes: *const u8, size: usize, state: *mut *mut c_void)
            = deserialize_state((bytes, size), state);
        fmi3GetDirectionalDerivative(
            unknowns: *const u32, n_unknowns: usize, knowns: *const u32, n_knowns: usize,
            seed: *const f64, n_seed: usize, sensitivity: *mut f64, n_sensitivity: usize
        ) = no_directional_derivative();
        fmi3GetAdjointDerivative(
            unknowns: *const u32, n_unknowns: usize, knowns: *const u32, n_knowns: usize,
            seed: *const f64, n_seed: usize, sensitivity: *mut f64, n_sensitivity: usize
        ) = no_directional_derivative();
        fmi3EnterConfigurationMode() = enter_configuration_mode();
        fmi3ExitConfigurationMode() = exit_configuration_mode();
        fmi3GetOutputDerivatives(
            vr: *const u32, nvr: usize, orders: *const i32, values: *mut f64, n: usize
        ) = get_output_derivatives((vr, nvr), (orders, nvr), (values, n));
        fmi3EnterEventMode() = not_offered();
        fmi3GetIntervalDecimal(
            vr: *const u32, nvr: usize, intervals: *mut f64, qualifiers: *mut i32
        ) = not_offered();
        fmi3GetIntervalFraction(
            vr: *const u32, nvr: usize, counters: *mut u64, resolutions: *mut u64,
            qualifiers: *mut i32
        ) = not_offered();
        fmi3GetShiftDecimal(vr: *const u32, nvr: usize, shifts: *mut f64) = not_offered();
        fmi3GetShiftFraction(
            vr: *const u32, nvr: usize, counters: *mut u64, resolutions: *mut u64
        ) = not_offered();
        fmi3SetIntervalDecimal(vr: *const u32, nvr: usize, intervals: *const f64) = not_offered();
        fmi3SetIntervalFraction(
            vr: *const u32, nvr: usize, counters: *const u64, resolutions: *const u64
        ) = not_offered();
        fmi3SetShiftDecimal(vr: *const u32, nvr: usize, shifts: *const f64) = not_offered();
        fmi3SetShiftFraction(
            vr: *const u32, nvr: usize, counters: *const u64, resolutions: *const u64
        ) = not_offered();
        fmi3EvaluateDiscreteStates() = not_offered();
        fmi3UpdateDiscreteStates(
            discrete_states_need_update: *mut bool, terminate_simulation: *mut bool,
            nominals_of_continuous_states_changed: *mut bool,
            values_of_continuous_states_changed: *mut bool, next_event_time_defined: *mut bool,
            next_event_time: *mut f64
        ) = not_offered();
        fmi3EnterContinuousTimeMode() = not_offered();
        fmi3CompletedIntegratorStep(
            no_set_state_prior_to_current_point: bool, enter_event_mode: *mut bool,
            terminate_simulation: *mut bool
        ) = not_offered();
        fmi3SetTime(time: f64) = not_offered();
        fmi3SetContinuousStates(states: *const f64, n: usize) = not_offered();
        fmi3GetContinuousStateDerivatives(derivatives: *mut f64, n: usize) = not_offered();
        fmi3GetEventIndicators(indicators: *mut f64, n: usize) = not_offered();
        fmi3GetContinuousStates(states: *mut f64, n: usize) = not_offered();
        fmi3GetNominalsOfContinuousStates(nominals: *mut f64, n: usize) = not_offered();
        fmi3GetNumberOfEventIndicators(n: *mut usize) = not_offered();
        fmi3GetNumberOfContinuousStates(n: *mut usize) = not_offered();
        fmi3EnterStepMode() = not_offered();
        fmi3ActivateModelPartition(clock_reference: u32, activation_time: f64) = not_offered();
    } };
}

/// Exports the functions of FMI 2.0 for a model ([`Model`](crate::Model)), which is given by its
/// full path (`crate::…`). Use it once in a shared library, in a file of its own that allows
/// `unsafe_code`.
///
/// The functions are unsafe, because FMI requires callers to follow rules: see
/// [`calls`](crate::calls).
#[macro_export]
macro_rules! export_fmi2 {
    ($model:path) => {
        use std::ffi::{c_char, c_int, c_uint, c_void};
        use $crate::Status;
        use $crate::v2::CallbackFunctions;

        $crate::fmi2_functions! { [$crate::export_functions] $model; }
    };
}

/// Exports the functions of FMI 3.0 for a model, as [`export_fmi2!`](crate::export_fmi2) does.
#[macro_export]
macro_rules! export_fmi3 {
    ($model:path) => {
        use std::ffi::{c_char, c_void};
        use $crate::Status;
        use $crate::boundary::{IntermediateUpdate, Logger3};

        $crate::fmi3_functions! { [$crate::export_functions] $model; }
    };
}
