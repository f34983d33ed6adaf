//! The bodies of the C functions that both versions of FMI have, for any model: pointers in,
//! refusals out, nothing else. `export_fmi2!` and `export_fmi3!` make functions of them.
//!
//! Nothing here panics, prints, exits or leaks across the boundary: a panic inside becomes "fatal"
//! with a message, and from then on the instance refuses all calls but the one that frees it.
//!
//! # Safety
//! All functions take pointers as FMI defines them: an instance is one that was instantiated and is
//! not freed, arrays hold as many elements as said, strings end in a zero, states come from
//! functions of FMI. NULL is checked everywhere.

#![allow(unsafe_code)] // the C boundary
#![allow(clippy::missing_safety_doc)] // said once, above

use crate::answer::{Answer, Status, refuse};
use crate::boundary::{
    Component, InArray, Instance, Intermediate, OutArray, array, array_mut, call, place, texts,
};
use crate::lifecycle::{Function, Phase};
use crate::model::{Model, Step};
use crate::slave::Snapshot;
use crate::states;
use crate::variables::Number;
use std::ffi::{CStr, CString, c_char, c_void};
use std::sync::Arc;

const REFERENCES: &str = "valueReferences";
const VALUES: &str = "values";
const STATE: &str = "FMUstate";

#[allow(missing_docs)] // FMI's own names
impl<M: Model> Component<M> {
    pub unsafe fn set_debug_logging(
        &mut self,
        on: impl Default + PartialEq,
        categories: InArray<*const c_char>,
    ) -> Answer<()> {
        self.slave.check(Function::SetDebugLogging)?;
        // SAFETY: the importer keeps FMI's contract; the same below.
        let categories = unsafe { texts(categories, "a category")? };
        self.log.choose(on != Default::default(), &categories)
    }

    pub unsafe fn setup_experiment(
        &mut self,
        tolerance_defined: impl Default + PartialEq,
        tolerance: f64,
        start: f64,
        stop_defined: impl Default + PartialEq,
        stop: f64,
    ) -> Answer<()> {
        let tolerance = (tolerance_defined != Default::default()).then_some(tolerance);
        let stop = (stop_defined != Default::default()).then_some(stop);
        self.slave.setup_experiment(start, stop, tolerance)
    }

    pub unsafe fn enter_initialization_mode(&mut self) -> Answer<()> {
        self.slave.enter_initialization()
    }

    pub unsafe fn exit_initialization_mode(&mut self) -> Answer<()> {
        self.slave.exit_initialization()
    }

    pub unsafe fn terminate(&mut self) -> Answer<()> {
        self.slave.change_phase(Function::Terminate, Phase::Terminated)
    }

    pub unsafe fn reset(&mut self) -> Answer<()> {
        self.slave.reset()
    }

    pub unsafe fn get(&mut self, references: InArray<u32>, values: OutArray<impl Number>) -> Answer<()> {
        let (references, values) = unsafe { (array(references, REFERENCES)?, array_mut(values, VALUES)?) };
        self.slave.get(references, values)
    }

    pub unsafe fn set(&mut self, references: InArray<u32>, values: InArray<impl Number>) -> Answer<()> {
        let (references, values) = unsafe { (array(references, REFERENCES)?, array(values, VALUES)?) };
        self.slave.set(references, values)
    }

    /// The texts live until the next such call or the end of the instance.
    pub unsafe fn get_strings(
        &mut self,
        references: InArray<u32>,
        values: OutArray<*const c_char>,
    ) -> Answer<()> {
        let (references, values) = unsafe { (array(references, REFERENCES)?, array_mut(values, VALUES)?) };
        let texts = self.slave.get_strings(references, values.len())?;
        self.strings = texts.into_iter().map(|text| CString::new(text).unwrap_or_default()).collect();
        for (value, text) in values.iter_mut().zip(&self.strings) {
            *value = text.as_ptr();
        }
        Ok(())
    }

    pub unsafe fn set_strings(
        &mut self,
        references: InArray<u32>,
        values: InArray<*const c_char>,
    ) -> Answer<()> {
        let (references, values) = unsafe { (array(references, REFERENCES)?, texts(values, "a value")?) };
        self.slave.set_strings(references, &values)
    }

    pub unsafe fn get_output_derivatives(
        &mut self,
        references: InArray<u32>,
        orders: InArray<i32>,
        values: OutArray<f64>,
    ) -> Answer<()> {
        let (references, orders) = unsafe { (array(references, REFERENCES)?, array(orders, "orders")?) };
        self.slave.get_output_derivatives(references, orders, unsafe { array_mut(values, VALUES)? })
    }

    pub unsafe fn no_directional_derivative(&mut self) -> Answer<()> {
        self.slave.no_directional_derivative()
    }

    /// A state that is not NULL is overwritten.
    pub unsafe fn get_state(&mut self, state: *mut *mut c_void) -> Answer<()> {
        Ok(states::put(unsafe { place(state, STATE)? }, self.slave.snapshot()?)?)
    }

    pub unsafe fn set_state(&mut self, state: *mut c_void) -> Answer<()> {
        let snapshot = self.state(state)?;
        self.slave.restore(&snapshot)
    }

    /// NULL is fine, and it is NULL afterwards.
    pub unsafe fn free_state(&mut self, state: *mut *mut c_void) -> Answer<()> {
        self.slave.check(Function::State)?;
        Ok(unsafe { state.as_mut() }.map_or(Ok(()), states::free)?)
    }

    pub unsafe fn state_size(&mut self, state: *mut c_void, size: *mut usize) -> Answer<()> {
        let snapshot = self.state(state)?;
        *unsafe { place(size, "size")? } = self.slave.serialize(&snapshot)?.len();
        Ok(())
    }

    pub unsafe fn serialize_state(&mut self, state: *mut c_void, buffer: OutArray<u8>) -> Answer<()> {
        self.slave.check(Function::State)?;
        let buffer = unsafe { array_mut(buffer, "serializedState")? };
        let bytes = self.slave.serialize(&*self.state(state)?)?;
        let (given, needed) = (buffer.len(), bytes.len());
        let Some(buffer) = buffer.get_mut(..needed) else {
            return refuse(format!("the buffer has {given} bytes, but the state needs {needed}"));
        };
        buffer.copy_from_slice(&bytes);
        Ok(())
    }

    pub unsafe fn deserialize_state(&mut self, bytes: InArray<u8>, state: *mut *mut c_void) -> Answer<()> {
        let (bytes, place) = unsafe { (array(bytes, "serializedState")?, place(state, STATE)?) };
        Ok(states::put(place, self.slave.deserialize(bytes)?)?)
    }

    /// The snapshot behind a state of the importer.
    fn state(&self, state: *mut c_void) -> Answer<Arc<Snapshot<M::Saved>>> {
        self.slave.check(Function::State)?;
        if state.is_null() {
            return refuse(format!("{STATE} is NULL"));
        }
        Ok(states::get(state)?)
    }
}

/// Gives a text that is always the same: a version, or the types of a platform.
pub unsafe fn text<M: Model>(_: &str, text: &'static CStr) -> *const c_char {
    text.as_ptr()
}

/// Does a communication step. If the model wants values to be seen within it, and the importer has
/// given a callback for that, it is looked ahead first. No borrow of the instance is held while the
/// callback runs: it reads values by calls of its own. If the importer asks for an early return, the
/// step ends at the time that it says, if that is not over, and else at once. Writes to places, unless they are NULL:
/// whether events must be handled, whether the simulation shall end, whether it returned early; and
/// the time that was reached.
pub unsafe fn do_step<M: Model>(
    name: &'static str,
    instance: *mut c_void,
    from: f64,
    length: f64,
    flags: [*mut bool; 3],
    last_time: *mut f64,
) -> Status {
    let Some(Instance { intermediate, .. }) = (unsafe { Instance::<M>::of(instance) }) else {
        return Status::Error;
    };
    let intermediate = intermediate.filter(|intermediate| intermediate.update.is_some());
    let (mut points, mut time) = (Vec::new(), f64::NAN);
    let mut status = unsafe {
        call::<M>(instance, name, |component| {
            time = component.slave.time();
            points = component.slave.points(from, length, intermediate.is_some())?;
            Ok(())
        })
    };
    let (mut step, mut so_far) = (Step::of(from, length), 0.0);
    if status == Status::Ok {
        for point in points {
            let at = from + point;
            if at == from {
                // Nearer than times can be told apart.
                continue;
            }
            let Some(Intermediate { update: Some(update), environment, early_return_allowed }) =
                intermediate.filter(|_| at < step.to)
            else {
                break;
            };
            let mut seen = false;
            status = unsafe {
                call::<M>(instance, name, |component| {
                    seen = component.slave.look_ahead(from, so_far, point);
                    Ok(())
                })
            };
            if !seen {
                break;
            }
            so_far = point;
            let (mut requested, mut until) = (false, at);
            let (request, place) = (&raw mut requested, &raw mut until);
            // SAFETY: the importer's callback, called as FMI says. No borrow of the instance is held.
            unsafe { update(environment, at, false, true, true, early_return_allowed, request, place) };
            if requested && early_return_allowed {
                // Also if it is not a number.
                let to = until.max(at);
                if to < step.to {
                    step = Step { to, length: if to == at { point } else { to - from }, from };
                }
            }
        }
        if status == Status::Ok {
            status = unsafe { call::<M>(instance, name, |component| component.slave.do_step(step, time)) };
        }
        if status == Status::Ok {
            time = step.to;
        }
    }
    let early = status == Status::Ok && step.to < from + length;
    unsafe {
        for (place, value) in flags.into_iter().zip([false, false, early]) {
            if let Some(place) = place.as_mut() {
                *place = value;
            }
        }
        if let Some(place) = last_time.as_mut() {
            *place = time;
        }
    }
    status
}
