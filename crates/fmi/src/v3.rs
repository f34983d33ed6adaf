//! The bodies of the C functions that only FMI 3.0 has, or has with other arguments than FMI 2.0.
//!
//! # Safety
//! As in [`calls`](crate::calls).

#![allow(unsafe_code)] // the C boundary
#![allow(clippy::missing_safety_doc)] // said once, above
#![allow(clippy::extra_unused_type_parameters)] // so that all bodies have the model as their parameter
#![allow(clippy::too_many_arguments)] // FMI's signatures

use crate::Version;
use crate::answer::{Answer, Status, refuse};
use crate::boundary::{
    Arguments, Component, InArray, Intermediate, IntermediateUpdate, Log, Logger, Logger3, array, array_mut,
    make, place, silence_panics,
};
use crate::lifecycle::{Function, Phase};
use crate::model::Model;
use std::ffi::{c_char, c_void};
use std::ptr::null_mut;

/// `fmi3InstantiateCoSimulation`: NULL, after a message, when the instance cannot be made.
pub unsafe fn instantiate_co_simulation<M: Model>(
    name: &str,
    instance_name: *const c_char,
    token: *const c_char,
    location: *const c_char,
    logging_on: bool,
    event_mode_used: bool,
    early_return_allowed: bool,
    environment: *mut c_void,
    log_message: Option<Logger3>,
    update: Option<IntermediateUpdate>,
) -> *mut c_void {
    silence_panics();
    let arguments = Arguments {
        version: Version::V3,
        log: Log::new(Logger::V3(log_message), environment, logging_on),
        intermediate: Some(Intermediate { update, environment, early_return_allowed }),
        unsupported: event_mode_used.then_some("eventModeUsed: hasEventMode is false"),
        instance_name,
        token,
        location,
    };
    // SAFETY: the importer keeps FMI's contract; the same below.
    unsafe { make::<M>(name, arguments) }
}

/// `fmi3InstantiateModelExchange`, `fmi3InstantiateScheduledExecution`: not offered.
pub unsafe fn instantiate_another_kind<M: Model>(
    name: &str,
    environment: *mut c_void,
    log_message: Option<Logger3>,
) -> *mut c_void {
    let message = format!("{name}: this FMU is for co-simulation only");
    Log::new(Logger::V3(log_message), environment, false).write(Status::Error, &message);
    null_mut()
}

/// `fmi3Dependent`
const DEPENDENT: i32 = 5;

#[allow(missing_docs)] // FMI's own names
impl<M: Model> Component<M> {
    /// Enters Initialization Mode, with what FMI 2.0 sets up before.
    pub unsafe fn enter_with_experiment(
        &mut self,
        tolerance_defined: bool,
        tolerance: f64,
        start: f64,
        stop_defined: bool,
        stop: f64,
    ) -> Answer<()> {
        unsafe { self.setup_experiment(tolerance_defined, tolerance, start, stop_defined, stop)? };
        self.slave.enter_initialization()
    }

    pub unsafe fn enter_configuration_mode(&mut self) -> Answer<()> {
        self.slave.change_phase(Function::EnterConfigurationMode, Phase::Configuration)
    }

    pub unsafe fn exit_configuration_mode(&mut self) -> Answer<()> {
        self.slave.change_phase(Function::ExitConfigurationMode, Phase::Instantiated)
    }

    /// Reads or sets a type that no variable has: right only without variables.
    pub unsafe fn no_variables(&mut self, references: InArray<u32>) -> Answer<()> {
        let (verb, kind) = self.function.split_at("fmi3Get".len());
        let function = if verb == "fmi3Get" { Function::Get } else { Function::Set };
        self.slave.no_variables(function, kind, unsafe { array(references, "valueReferences")? })
    }

    pub unsafe fn get_number_of_variable_dependencies(
        &mut self,
        reference: u32,
        count: *mut usize,
    ) -> Answer<()> {
        let dependencies = self.slave.dependencies(reference)?;
        *unsafe { place(count, "nDependencies")? } = dependencies.len();
        Ok(())
    }

    pub unsafe fn get_variable_dependencies(
        &mut self,
        reference: u32,
        dependents: *mut usize,
        independents: *mut u32,
        elements: *mut usize,
        kinds: *mut i32,
        count: usize,
    ) -> Answer<()> {
        let found = self.slave.dependencies(reference)?;
        if found.len() != count {
            return refuse(format!("{count} values for variables of {} elements together", found.len()));
        }
        let (dependents, independents, elements, kinds) = unsafe {
            (
                array_mut((dependents, count), "elementIndicesOfDependent")?,
                array_mut((independents, count), "independents")?,
                array_mut((elements, count), "elementIndicesOfIndependents")?,
                array_mut((kinds, count), "dependencyKinds")?,
            )
        };
        for (k, (dependent, independent, element)) in found.into_iter().enumerate() {
            (dependents[k], independents[k], elements[k], kinds[k]) =
                (dependent, independent, element, DEPENDENT);
        }
        Ok(())
    }

    /// Functions of events, clocks and other kinds of FMUs.
    pub unsafe fn not_offered(&mut self) -> Answer<()> {
        self.slave.not_offered()
    }
}
