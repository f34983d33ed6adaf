//! The 75 functions of FMI 3.0: their C names and signatures, said once for exports, importers and
//! tests.

/// Gives the functions to a macro, after the tokens that follow its name: `fmi3_functions! {
/// [my_macro] first … }` becomes `my_macro! { first … fmi3GetVersion = v3::get_version() -> *const
/// c_char; … }`. Behind `=` is the body in this crate. Functions after `[not offered]` are about
/// events, clocks and other kinds of FMUs. Types are those of the caller: an importer declares
/// `Status` as a number.
#[macro_export]
macro_rules! fmi3_functions {
    ([$($callback:tt)+] $($first:tt)*) => { $($callback)+! { $($first)*
        fmi3GetVersion = v3::get_version() -> *const c_char;
        fmi3SetDebugLogging = v3::set_debug_logging(
            instance: *mut c_void, logging_on: bool, n_categories: usize,
            categories: *const *const c_char
        ) -> Status;
        fmi3InstantiateModelExchange = v3::instantiate_model_exchange(
            instance_name: *const c_char, instantiation_token: *const c_char,
            resource_path: *const c_char, visible: bool, logging_on: bool,
            instance_environment: *mut c_void, log_message: Option<Logger3>
        ) -> *mut c_void;
        fmi3InstantiateCoSimulation = v3::instantiate_co_simulation(
            instance_name: *const c_char, instantiation_token: *const c_char,
            resource_path: *const c_char, visible: bool, logging_on: bool, event_mode_used: bool,
            early_return_allowed: bool, required_intermediate_variables: *const u32,
            n_required_intermediate_variables: usize, instance_environment: *mut c_void,
            log_message: Option<Logger3>, intermediate_update: Option<IntermediateUpdate>
        ) -> *mut c_void;
        fmi3InstantiateScheduledExecution = v3::instantiate_scheduled_execution(
            instance_name: *const c_char, instantiation_token: *const c_char,
            resource_path: *const c_char, visible: bool, logging_on: bool,
            instance_environment: *mut c_void, log_message: Option<Logger3>,
            clock_update: *const c_void, lock_preemption: *const c_void,
            unlock_preemption: *const c_void
        ) -> *mut c_void;
        fmi3FreeInstance = calls::free_instance(instance: *mut c_void);
        fmi3EnterInitializationMode = v3::enter_initialization_mode(
            instance: *mut c_void, tolerance_defined: bool, tolerance: f64, start_time: f64,
            stop_time_defined: bool, stop_time: f64
        ) -> Status;
        fmi3ExitInitializationMode = calls::exit_initialization_mode(instance: *mut c_void) -> Status;
        fmi3Terminate = calls::terminate(instance: *mut c_void) -> Status;
        fmi3Reset = calls::reset(instance: *mut c_void) -> Status;
        fmi3GetFloat32 = calls::get(
            instance: *mut c_void, references: *const u32, count: usize, values: *mut f32,
            value_count: usize
        ) -> Status;
        fmi3GetFloat64 = calls::get(
            instance: *mut c_void, references: *const u32, count: usize, values: *mut f64,
            value_count: usize
        ) -> Status;
        fmi3GetInt8 = calls::get(
            instance: *mut c_void, references: *const u32, count: usize, values: *mut i8,
            value_count: usize
        ) -> Status;
        fmi3GetUInt8 = calls::get(
            instance: *mut c_void, references: *const u32, count: usize, values: *mut u8,
            value_count: usize
        ) -> Status;
        fmi3GetInt16 = calls::get(
            instance: *mut c_void, references: *const u32, count: usize, values: *mut i16,
            value_count: usize
        ) -> Status;
        fmi3GetUInt16 = calls::get(
            instance: *mut c_void, references: *const u32, count: usize, values: *mut u16,
            value_count: usize
        ) -> Status;
        fmi3GetInt32 = calls::get(
            instance: *mut c_void, references: *const u32, count: usize, values: *mut i32,
            value_count: usize
        ) -> Status;
        fmi3GetUInt32 = calls::get(
            instance: *mut c_void, references: *const u32, count: usize, values: *mut u32,
            value_count: usize
        ) -> Status;
        fmi3GetInt64 = calls::get(
            instance: *mut c_void, references: *const u32, count: usize, values: *mut i64,
            value_count: usize
        ) -> Status;
        fmi3GetUInt64 = calls::get(
            instance: *mut c_void, references: *const u32, count: usize, values: *mut u64,
            value_count: usize
        ) -> Status;
        fmi3GetBoolean = v3::get_boolean(
            instance: *mut c_void, references: *const u32, count: usize, values: *mut bool,
            value_count: usize
        ) -> Status;
        fmi3GetString = calls::get_string(
            instance: *mut c_void, references: *const u32, count: usize, values: *mut *const c_char,
            value_count: usize
        ) -> Status;
        fmi3GetBinary = v3::get_binary(
            instance: *mut c_void, references: *const u32, count: usize, value_sizes: *mut usize,
            values: *mut *const u8, value_count: usize
        ) -> Status;
        fmi3GetClock = v3::get_clock(
            instance: *mut c_void, references: *const u32, count: usize, values: *mut bool
        ) -> Status;
        fmi3SetFloat32 = calls::set(
            instance: *mut c_void, references: *const u32, count: usize, values: *const f32,
            value_count: usize
        ) -> Status;
        fmi3SetFloat64 = calls::set(
            instance: *mut c_void, references: *const u32, count: usize, values: *const f64,
            value_count: usize
        ) -> Status;
        fmi3SetInt8 = calls::set(
            instance: *mut c_void, references: *const u32, count: usize, values: *const i8,
            value_count: usize
        ) -> Status;
        fmi3SetUInt8 = calls::set(
            instance: *mut c_void, references: *const u32, count: usize, values: *const u8,
            value_count: usize
        ) -> Status;
        fmi3SetInt16 = calls::set(
            instance: *mut c_void, references: *const u32, count: usize, values: *const i16,
            value_count: usize
        ) -> Status;
        fmi3SetUInt16 = calls::set(
            instance: *mut c_void, references: *const u32, count: usize, values: *const u16,
            value_count: usize
        ) -> Status;
        fmi3SetInt32 = calls::set(
            instance: *mut c_void, references: *const u32, count: usize, values: *const i32,
            value_count: usize
        ) -> Status;
        fmi3SetUInt32 = calls::set(
            instance: *mut c_void, references: *const u32, count: usize, values: *const u32,
            value_count: usize
        ) -> Status;
        fmi3SetInt64 = calls::set(
            instance: *mut c_void, references: *const u32, count: usize, values: *const i64,
            value_count: usize
        ) -> Status;
        fmi3SetUInt64 = calls::set(
            instance: *mut c_void, references: *const u32, count: usize, values: *const u64,
            value_count: usize
        ) -> Status;
        fmi3SetBoolean = v3::set_boolean(
            instance: *mut c_void, references: *const u32, count: usize, values: *const bool,
            value_count: usize
        ) -> Status;
        fmi3SetString = calls::set_string(
            instance: *mut c_void, references: *const u32, count: usize, values: *const *const c_char,
            value_count: usize
        ) -> Status;
        fmi3SetBinary = v3::set_binary(
            instance: *mut c_void, references: *const u32, count: usize, value_sizes: *const usize,
            values: *const *const u8, value_count: usize
        ) -> Status;
        fmi3SetClock = v3::set_clock(
            instance: *mut c_void, references: *const u32, count: usize, values: *const bool
        ) -> Status;
        fmi3GetNumberOfVariableDependencies = v3::get_number_of_variable_dependencies(
            instance: *mut c_void, value_reference: u32, n_dependencies: *mut usize
        ) -> Status;
        fmi3GetVariableDependencies = v3::get_variable_dependencies(
            instance: *mut c_void, dependent: u32, element_indices_of_dependent: *mut usize,
            independents: *mut u32, element_indices_of_independents: *mut usize,
            dependency_kinds: *mut i32, n_dependencies: usize
        ) -> Status;
        fmi3GetFMUState = calls::get_state(instance: *mut c_void, state: *mut *mut c_void) -> Status;
        fmi3SetFMUState = calls::set_state(instance: *mut c_void, state: *mut c_void) -> Status;
        fmi3FreeFMUState = calls::free_state(instance: *mut c_void, state: *mut *mut c_void) -> Status;
        fmi3SerializedFMUStateSize = calls::state_size(
            instance: *mut c_void, state: *mut c_void, size: *mut usize
        ) -> Status;
        fmi3SerializeFMUState = calls::serialize_state(
            instance: *mut c_void, state: *mut c_void, serialized_state: *mut u8, size: usize
        ) -> Status;
        fmi3DeserializeFMUState = calls::deserialize_state(
            instance: *mut c_void, serialized_state: *const u8, size: usize, state: *mut *mut c_void
        ) -> Status;
        fmi3GetDirectionalDerivative = v3::get_directional_derivative(
            instance: *mut c_void, unknowns: *const u32, n_unknowns: usize, knowns: *const u32,
            n_knowns: usize, seed: *const f64, n_seed: usize, sensitivity: *mut f64,
            n_sensitivity: usize
        ) -> Status;
        fmi3GetAdjointDerivative = v3::get_directional_derivative(
            instance: *mut c_void, unknowns: *const u32, n_unknowns: usize, knowns: *const u32,
            n_knowns: usize, seed: *const f64, n_seed: usize, sensitivity: *mut f64,
            n_sensitivity: usize
        ) -> Status;
        fmi3EnterConfigurationMode = v3::enter_configuration_mode(instance: *mut c_void) -> Status;
        fmi3ExitConfigurationMode = v3::exit_configuration_mode(instance: *mut c_void) -> Status;
        fmi3GetOutputDerivatives = calls::get_output_derivatives(
            instance: *mut c_void, references: *const u32, count: usize, orders: *const i32,
            values: *mut f64, value_count: usize
        ) -> Status;
        fmi3DoStep = v3::do_step(
            instance: *mut c_void, current_communication_point: f64, communication_step_size: f64,
            no_set_state_prior_to_current_point: bool, event_handling_needed: *mut bool,
            terminate_simulation: *mut bool, early_return: *mut bool, last_successful_time: *mut f64
        ) -> Status;
        [not offered]
        fmi3EnterEventMode(instance: *mut c_void);
        fmi3GetIntervalDecimal(
            instance: *mut c_void, references: *const u32, count: usize, intervals: *mut f64,
            qualifiers: *mut i32
        );
        fmi3GetIntervalFraction(
            instance: *mut c_void, references: *const u32, count: usize, counters: *mut u64,
            resolutions: *mut u64, qualifiers: *mut i32
        );
        fmi3GetShiftDecimal(
            instance: *mut c_void, references: *const u32, count: usize, shifts: *mut f64
        );
        fmi3GetShiftFraction(
            instance: *mut c_void, references: *const u32, count: usize, counters: *mut u64,
            resolutions: *mut u64
        );
        fmi3SetIntervalDecimal(
            instance: *mut c_void, references: *const u32, count: usize, intervals: *const f64
        );
        fmi3SetIntervalFraction(
            instance: *mut c_void, references: *const u32, count: usize, counters: *const u64,
            resolutions: *const u64
        );
        fmi3SetShiftDecimal(
            instance: *mut c_void, references: *const u32, count: usize, shifts: *const f64
        );
        fmi3SetShiftFraction(
            instance: *mut c_void, references: *const u32, count: usize, counters: *const u64,
            resolutions: *const u64
        );
        fmi3EvaluateDiscreteStates(instance: *mut c_void);
        fmi3UpdateDiscreteStates(
            instance: *mut c_void, discrete_states_need_update: *mut bool,
            terminate_simulation: *mut bool, nominals_of_continuous_states_changed: *mut bool,
            values_of_continuous_states_changed: *mut bool, next_event_time_defined: *mut bool,
            next_event_time: *mut f64
        );
        fmi3EnterContinuousTimeMode(instance: *mut c_void);
        fmi3CompletedIntegratorStep(
            instance: *mut c_void, no_set_state_prior_to_current_point: bool,
            enter_event_mode: *mut bool, terminate_simulation: *mut bool
        );
        fmi3SetTime(instance: *mut c_void, time: f64);
        fmi3SetContinuousStates(
            instance: *mut c_void, continuous_states: *const f64, n_continuous_states: usize
        );
        fmi3GetContinuousStateDerivatives(
            instance: *mut c_void, derivatives: *mut f64, n_continuous_states: usize
        );
        fmi3GetEventIndicators(
            instance: *mut c_void, event_indicators: *mut f64, n_event_indicators: usize
        );
        fmi3GetContinuousStates(
            instance: *mut c_void, continuous_states: *mut f64, n_continuous_states: usize
        );
        fmi3GetNominalsOfContinuousStates(
            instance: *mut c_void, nominals: *mut f64, n_continuous_states: usize
        );
        fmi3GetNumberOfEventIndicators(
            instance: *mut c_void, n_event_indicators: *mut usize
        );
        fmi3GetNumberOfContinuousStates(
            instance: *mut c_void, n_continuous_states: *mut usize
        );
        fmi3EnterStepMode(instance: *mut c_void);
        fmi3ActivateModelPartition(
            instance: *mut c_void, clock_reference: u32, activation_time: f64
        );
    } };
}

/// Exports the functions of FMI 3.0 for a model ([`Model`](crate::Model)), which is given by its
/// full path (`crate::…`). Use it once in a shared library, in a file of its own that allows
/// `unsafe_code`.
///
/// The functions are unsafe, because FMI requires callers to follow rules: see
/// [`calls`](crate::calls).
#[macro_export]
macro_rules! export_fmi3 {
    ($model:path) => {
        use std::ffi::{c_char, c_void};
        use $crate::Status;
        use $crate::v3::{IntermediateUpdate, Logger3};

        $crate::fmi3_functions! { [$crate::export_functions] $model; }
    };
}
