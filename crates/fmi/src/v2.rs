//! The bodies of the C functions that only FMI 2.0 has, or has with other arguments than FMI 3.0.
//!
//! # Safety
//! As in [`calls`](crate::calls).

#![allow(unsafe_code)] // the C boundary
#![allow(clippy::missing_safety_doc)] // said once, above
#![allow(clippy::extra_unused_type_parameters)] // so that all bodies have the model as their parameter
#![allow(clippy::too_many_arguments)] // FMI's signatures

use crate::Version;
use crate::answer::{Answer, Refusal, Status};
use crate::boundary::{
    Arguments, Component, InArray, Log, Logger, Logger2, array, make, place, silence_panics,
};
use crate::lifecycle::Function;
use crate::model::Model;
use std::ffi::{c_char, c_int, c_void};

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

/// `fmi2Instantiate`: NULL, after a message, when the instance cannot be made.
pub unsafe fn instantiate<M: Model>(
    name: &str,
    instance_name: *const c_char,
    fmu_type: c_int,
    token: *const c_char,
    location: *const c_char,
    functions: *const CallbackFunctions,
    logging_on: c_int,
) -> *mut c_void {
    silence_panics();
    // SAFETY: NULL or the importer's functions. They are copied: some importers keep them on the stack.
    let Some(functions) = (unsafe { functions.as_ref() }) else { return std::ptr::null_mut() };
    let arguments = Arguments {
        version: Version::V2,
        log: Log::new(Logger::V2(functions.logger), functions.component_environment, logging_on != 0),
        intermediate: None,
        unsupported: (fmu_type != 1).then_some("fmuType: this is a co-simulation FMU, no model exchange"),
        instance_name,
        token,
        location,
    };
    // SAFETY: the importer keeps FMI's contract; the same below.
    unsafe { make::<M>(name, arguments) }
}

/// `fmi2StatusKind`
const LAST_SUCCESSFUL_TIME: c_int = 2;
const TERMINATED: c_int = 3;

#[allow(missing_docs)] // FMI's own names
impl<M: Model> Component<M> {
    pub unsafe fn set_input_derivatives(
        &mut self,
        references: InArray<u32>,
        orders: InArray<c_int>,
        values: InArray<f64>,
    ) -> Answer<()> {
        let (references, orders, values) =
            unsafe { (array(references, "vr")?, array(orders, "order")?, array(values, "value")?) };
        self.slave.set_input_derivatives(references, orders, values)
    }

    /// A synchronous slave is never in the middle of a step.
    pub unsafe fn cancel_step(&mut self) -> Answer<()> {
        self.slave.check(Function::CancelStep)
    }

    /// Refuses a status that is an integer or a text: there is none.
    pub unsafe fn get_no_status<T>(&mut self, value: *mut T) -> Answer<()> {
        unsafe { self.get_status(value, None) }
    }

    pub unsafe fn get_real_status(&mut self, kind: c_int, value: *mut f64) -> Answer<()> {
        unsafe { self.get_status(value, (kind == LAST_SUCCESSFUL_TIME).then(|| self.slave.time())) }
    }

    pub unsafe fn get_boolean_status(&mut self, kind: c_int, value: *mut c_int) -> Answer<()> {
        unsafe { self.get_status(value, (kind == TERMINATED).then_some(0)) }
    }

    /// Statuses about pending steps do not apply to a synchronous slave.
    unsafe fn get_status<T>(&mut self, value: *mut T, status: Option<T>) -> Answer<()> {
        self.slave.check(Function::GetStatus)?;
        let place = unsafe { place(value, "value")? };
        let message = "fmi2DoStep never returns fmi2Pending in this FMU".to_owned();
        *place = status.ok_or(Refusal { status: Status::Discard, message })?;
        Ok(())
    }
}
