//! The 34 functions of FMI 2.0 co-simulation: their C names and signatures, said once for exports,
//! importers and tests.

/// Gives the functions to a macro, after the tokens that follow its name: `fmi2_functions! {
/// [my_macro] first … }` becomes `my_macro! { first … fmi2GetVersion = v2::get_version() -> *const
/// c_char; … }`. Behind `=` is the body in this crate. Types are those of the caller: an importer
/// declares `Status` as a number.
#[macro_export]
macro_rules! fmi2_functions {
    ([$($callback:tt)+] $($first:tt)*) => { $($callback)+! { $($first)*
        fmi2GetTypesPlatform = v2::get_types_platform() -> *const c_char;
        fmi2GetVersion = v2::get_version() -> *const c_char;
        fmi2Instantiate = v2::instantiate(
            instance_name: *const c_char, fmu_type: c_int, guid: *const c_char,
            resource_location: *const c_char, functions: *const CallbackFunctions, visible: c_int,
            logging_on: c_int
        ) -> *mut c_void;
        fmi2FreeInstance = calls::free_instance(instance: *mut c_void);
        fmi2SetDebugLogging = v2::set_debug_logging(
            instance: *mut c_void, logging_on: c_int, count: usize, categories: *const *const c_char
        ) -> Status;
        fmi2SetupExperiment = v2::setup_experiment(
            instance: *mut c_void, tolerance_defined: c_int, tolerance: f64, start_time: f64,
            stop_time_defined: c_int, stop_time: f64
        ) -> Status;
        fmi2EnterInitializationMode = v2::enter_initialization_mode(instance: *mut c_void) -> Status;
        fmi2ExitInitializationMode = calls::exit_initialization_mode(instance: *mut c_void) -> Status;
        fmi2Terminate = calls::terminate(instance: *mut c_void) -> Status;
        fmi2Reset = calls::reset(instance: *mut c_void) -> Status;
        fmi2GetReal = v2::get(
            instance: *mut c_void, references: *const c_uint, count: usize, values: *mut f64
        ) -> Status;
        fmi2GetInteger = v2::get(
            instance: *mut c_void, references: *const c_uint, count: usize, values: *mut c_int
        ) -> Status;
        fmi2GetBoolean = v2::get_boolean(
            instance: *mut c_void, references: *const c_uint, count: usize, values: *mut c_int
        ) -> Status;
        fmi2GetString = v2::get_string(
            instance: *mut c_void, references: *const c_uint, count: usize, values: *mut *const c_char
        ) -> Status;
        fmi2SetReal = v2::set(
            instance: *mut c_void, references: *const c_uint, count: usize, values: *const f64
        ) -> Status;
        fmi2SetInteger = v2::set(
            instance: *mut c_void, references: *const c_uint, count: usize, values: *const c_int
        ) -> Status;
        fmi2SetBoolean = v2::set_boolean(
            instance: *mut c_void, references: *const c_uint, count: usize, values: *const c_int
        ) -> Status;
        fmi2SetString = v2::set_string(
            instance: *mut c_void, references: *const c_uint, count: usize,
            values: *const *const c_char
        ) -> Status;
        fmi2GetFMUstate = calls::get_state(instance: *mut c_void, state: *mut *mut c_void) -> Status;
        fmi2SetFMUstate = calls::set_state(instance: *mut c_void, state: *mut c_void) -> Status;
        fmi2FreeFMUstate = calls::free_state(instance: *mut c_void, state: *mut *mut c_void) -> Status;
        fmi2SerializedFMUstateSize = calls::state_size(
            instance: *mut c_void, state: *mut c_void, size: *mut usize
        ) -> Status;
        fmi2SerializeFMUstate = calls::serialize_state(
            instance: *mut c_void, state: *mut c_void, bytes: *mut u8, size: usize
        ) -> Status;
        fmi2DeSerializeFMUstate = calls::deserialize_state(
            instance: *mut c_void, bytes: *const u8, size: usize, state: *mut *mut c_void
        ) -> Status;
        fmi2GetDirectionalDerivative = v2::get_directional_derivative(
            instance: *mut c_void, unknowns: *const c_uint, unknown_count: usize,
            knowns: *const c_uint, known_count: usize, known_differentials: *const f64,
            unknown_differentials: *mut f64
        ) -> Status;
        fmi2SetRealInputDerivatives = v2::set_real_input_derivatives(
            instance: *mut c_void, references: *const c_uint, count: usize, orders: *const c_int,
            values: *const f64
        ) -> Status;
        fmi2GetRealOutputDerivatives = v2::get_real_output_derivatives(
            instance: *mut c_void, references: *const c_uint, count: usize, orders: *const c_int,
            values: *mut f64
        ) -> Status;
        fmi2DoStep = v2::do_step(
            instance: *mut c_void, current_communication_point: f64, communication_step_size: f64,
            no_set_fmu_state_prior_to_current_point: c_int
        ) -> Status;
        fmi2CancelStep = v2::cancel_step(instance: *mut c_void) -> Status;
        fmi2GetStatus = v2::get_status(instance: *mut c_void, kind: c_int, value: *mut c_int) -> Status;
        fmi2GetRealStatus = v2::get_real_status(
            instance: *mut c_void, kind: c_int, value: *mut f64
        ) -> Status;
        fmi2GetIntegerStatus = v2::get_status(
            instance: *mut c_void, kind: c_int, value: *mut c_int
        ) -> Status;
        fmi2GetBooleanStatus = v2::get_boolean_status(
            instance: *mut c_void, kind: c_int, value: *mut c_int
        ) -> Status;
        fmi2GetStringStatus = v2::get_status(
            instance: *mut c_void, kind: c_int, value: *mut *const c_char
        ) -> Status;
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
