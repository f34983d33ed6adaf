//! The bodies of the C functions that both versions of FMI have, for any model: pointers in,
//! statuses out, nothing else. Each body gets the name of its function, for messages;
//! `export_fmi2!` and `export_fmi3!` make functions of them.
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

use crate::boundary::{
    Component, Instance, Intermediate, Log, Refusal, Status, array, array_mut, call, free, make, text, texts,
};
use crate::lifecycle::{Function, Phase};
use crate::location::Location;
use crate::model::Model;
use crate::slave::{Answer, Slave, SlaveError};
use crate::{Version, states};
use std::ffi::{CString, c_char, c_void};

/// The C type of numbers. All types but those of variables refuse every value reference.
pub trait Value: Copy {
    /// Name of the type in FMI 3.0.
    const NAME: &'static str;

    /// Reads variables of the type.
    fn get<M: Model>(slave: &mut Slave<M>, references: &[u32], _values: &mut [Self]) -> Answer<M, ()> {
        no_variables(slave, Function::Get, Self::NAME, references)
    }

    /// Sets variables of the type.
    fn set<M: Model>(slave: &mut Slave<M>, references: &[u32], _values: &[Self]) -> Answer<M, ()> {
        no_variables(slave, Function::Set, Self::NAME, references)
    }
}

impl Value for f64 {
    const NAME: &'static str = "Float64";

    fn get<M: Model>(slave: &mut Slave<M>, references: &[u32], values: &mut [f64]) -> Answer<M, ()> {
        slave.get_real(references, values)
    }

    fn set<M: Model>(slave: &mut Slave<M>, references: &[u32], values: &[f64]) -> Answer<M, ()> {
        slave.set_real(references, values)
    }
}

impl Value for i32 {
    const NAME: &'static str = "Int32";

    fn get<M: Model>(slave: &mut Slave<M>, references: &[u32], values: &mut [i32]) -> Answer<M, ()> {
        slave.get_integer(references, values)
    }

    fn set<M: Model>(slave: &mut Slave<M>, references: &[u32], values: &[i32]) -> Answer<M, ()> {
        slave.set_integer(references, values)
    }
}

impl Value for u64 {
    const NAME: &'static str = "UInt64";

    fn get<M: Model>(slave: &mut Slave<M>, references: &[u32], values: &mut [u64]) -> Answer<M, ()> {
        slave.get_size(references, values)
    }

    fn set<M: Model>(slave: &mut Slave<M>, references: &[u32], values: &[u64]) -> Answer<M, ()> {
        slave.set_size(references, values)
    }
}

impl Value for f32 {
    const NAME: &'static str = "Float32";
}

impl Value for i8 {
    const NAME: &'static str = "Int8";
}

impl Value for u8 {
    const NAME: &'static str = "UInt8";
}

impl Value for i16 {
    const NAME: &'static str = "Int16";
}

impl Value for u16 {
    const NAME: &'static str = "UInt16";
}

impl Value for u32 {
    const NAME: &'static str = "UInt32";
}

impl Value for i64 {
    const NAME: &'static str = "Int64";
}

/// Refuses references of a type that no variable has.
pub(crate) fn no_variables<M: Model>(
    slave: &Slave<M>,
    function: Function,
    kind: &'static str,
    references: &[u32],
) -> Answer<M, ()> {
    slave.check(function)?;
    match references.first() {
        None => Ok(()),
        Some(&reference) => Err(SlaveError::UnknownReference { kind, reference }),
    }
}

/// What both versions pass to make an instance.
pub(crate) struct Arguments<'a> {
    pub version: Version,
    pub log: Log,
    pub intermediate: Option<Intermediate>,
    /// What the importer asks for that there is not.
    pub unsupported: Option<&'static str>,
    pub instance_name: *const c_char,
    pub token: (*const c_char, &'static str),
    pub location: (*const c_char, &'static str),
    pub location_of: fn(&'a str) -> Location<'a>,
}

/// Makes an instance: NULL, after a message, when that fails.
pub(crate) unsafe fn instantiate<M: Model>(name: &str, arguments: Arguments<'_>) -> *mut c_void {
    let Arguments { version, mut log, intermediate, unsupported, .. } = arguments;
    // SAFETY: NULL or texts of the importer's; the same below.
    let instance_name = unsafe { text(arguments.instance_name, "instanceName") };
    log.instance_name = CString::new(instance_name.as_ref().map_or("", |name| *name)).unwrap_or_default();
    make::<M>(log, intermediate, name, || {
        if instance_name?.is_empty() {
            return Err(SlaveError::Unsupported("instanceName is empty").into());
        }
        if let Some(why) = unsupported {
            return Err(SlaveError::Unsupported(why).into());
        }
        let ((token, token_name), (location, location_name)) = (arguments.token, arguments.location);
        let (token, location) = unsafe { (text(token, token_name)?, text(location, location_name)?) };
        let model = M::load((arguments.location_of)(location)).map_err(SlaveError::from)?;
        Ok(Slave::new(model, version, token)?)
    })
}

/// Frees an instance.
pub unsafe fn free_instance<M: Model>(_: &str, instance: *mut c_void) {
    // SAFETY: an instance that was made, given back once.
    unsafe { free::<M>(instance) }
}

/// Sets which messages are written.
pub(crate) unsafe fn set_logging<M: Model>(
    name: &str,
    instance: *mut c_void,
    on: bool,
    count: usize,
    categories: *const *const c_char,
) -> Status {
    call::<M>(instance, name, |component| {
        component.slave.check(Function::SetDebugLogging)?;
        // SAFETY: as many texts as said.
        component.set_debug_logging(on, &unsafe { texts(categories, count, "a category")? })
    })
}

/// Runs a call that may warn.
fn warn<M: Model>(
    name: &str,
    instance: *mut c_void,
    body: impl FnOnce(&mut Slave<M>) -> Answer<M, ()>,
) -> Status {
    call(instance, name, |component: &mut Component<M>| {
        body(&mut component.slave)?;
        component.tell_warnings();
        Ok(())
    })
}

/// Leaves Initialization Mode.
pub unsafe fn exit_initialization_mode<M: Model>(name: &str, instance: *mut c_void) -> Status {
    warn(name, instance, Slave::<M>::exit_initialization)
}

/// Ends the simulation.
pub unsafe fn terminate<M: Model>(name: &str, instance: *mut c_void) -> Status {
    warn(name, instance, |slave: &mut Slave<M>| slave.change_phase(Function::Terminate, Phase::Terminated))
}

/// Goes back to the state after instantiation.
pub unsafe fn reset<M: Model>(name: &str, instance: *mut c_void) -> Status {
    warn(name, instance, Slave::<M>::reset)
}

/// Reads numbers.
pub unsafe fn get<M: Model>(
    name: &str,
    instance: *mut c_void,
    references: *const u32,
    count: usize,
    values: *mut impl Value,
    value_count: usize,
) -> Status {
    call::<M>(instance, name, |component| {
        // SAFETY: as many elements as said; the same below.
        let (references, values) = unsafe {
            (array(references, count, "valueReferences")?, array_mut(values, value_count, "values")?)
        };
        Ok(Value::get(&mut component.slave, references, values)?)
    })
}

/// Sets numbers.
pub unsafe fn set<M: Model>(
    name: &str,
    instance: *mut c_void,
    references: *const u32,
    count: usize,
    values: *const impl Value,
    value_count: usize,
) -> Status {
    call::<M>(instance, name, |component| {
        let (references, values) =
            unsafe { (array(references, count, "valueReferences")?, array(values, value_count, "values")?) };
        Ok(Value::set(&mut component.slave, references, values)?)
    })
}

/// Reads Booleans, as 0 or 1 of a type of C.
pub(crate) unsafe fn get_booleans<M: Model>(
    name: &str,
    instance: *mut c_void,
    references: *const u32,
    count: usize,
    values: *mut impl From<bool>,
    value_count: usize,
) -> Status {
    call::<M>(instance, name, |component| {
        let (references, values) = unsafe {
            (array(references, count, "valueReferences")?, array_mut(values, value_count, "values")?)
        };
        Ok(component.slave.get_boolean(references, values)?)
    })
}

/// Sets Booleans: everything but 0 is true.
pub(crate) unsafe fn set_booleans<M: Model>(
    name: &str,
    instance: *mut c_void,
    references: *const u32,
    count: usize,
    values: *const (impl Default + PartialEq),
    value_count: usize,
) -> Status {
    call::<M>(instance, name, |component| {
        let (references, values) =
            unsafe { (array(references, count, "valueReferences")?, array(values, value_count, "values")?) };
        let values: Vec<bool> = values.iter().map(|value| *value != Default::default()).collect();
        Ok(component.slave.set_boolean(references, &values)?)
    })
}

/// Reads texts, which live until the next such call or the end of the instance.
pub unsafe fn get_string<M: Model>(
    name: &str,
    instance: *mut c_void,
    references: *const u32,
    count: usize,
    values: *mut *const c_char,
    value_count: usize,
) -> Status {
    call::<M>(instance, name, |component| {
        let (references, values) = unsafe {
            (array(references, count, "valueReferences")?, array_mut(values, value_count, "values")?)
        };
        let texts = component.slave.get_string(references, values.len())?;
        component.give_texts(texts, values);
        Ok(())
    })
}

/// Sets texts.
pub unsafe fn set_string<M: Model>(
    name: &str,
    instance: *mut c_void,
    references: *const u32,
    count: usize,
    values: *const *const c_char,
    value_count: usize,
) -> Status {
    call::<M>(instance, name, |component| {
        let (references, values) =
            unsafe { (array(references, count, "valueReferences")?, texts(values, value_count, "a value")?) };
        component.slave.set_string(references, &values)?;
        component.tell_warnings();
        Ok(())
    })
}

/// Reads derivatives of outputs.
pub unsafe fn get_output_derivatives<M: Model>(
    name: &str,
    instance: *mut c_void,
    references: *const u32,
    count: usize,
    orders: *const i32,
    values: *mut f64,
    value_count: usize,
) -> Status {
    call::<M>(instance, name, |component| {
        let (references, orders, values) = unsafe {
            (
                array(references, count, "valueReferences")?,
                array(orders, count, "orders")?,
                array_mut(values, value_count, "values")?,
            )
        };
        Ok(component.slave.get_output_derivatives(references, orders, values)?)
    })
}

/// Saves a state: a new one, or an old one overwritten.
pub unsafe fn get_state<M: Model>(name: &str, instance: *mut c_void, state: *mut *mut c_void) -> Status {
    call::<M>(instance, name, |component| {
        // SAFETY: NULL or the place of a state pointer; the same below.
        let place = unsafe { state.as_mut() }.ok_or(Refusal::Null("FMUstate"))?;
        Ok(states::put(place, component.slave.snapshot()?)?)
    })
}

/// Restores a state.
pub unsafe fn set_state<M: Model>(name: &str, instance: *mut c_void, state: *mut c_void) -> Status {
    call::<M>(instance, name, |component| {
        component.slave.check(Function::State)?;
        let snapshot = component.state(state)?;
        Ok(component.slave.restore(&snapshot)?)
    })
}

/// Frees a state: NULL is fine, and it is NULL afterwards.
pub unsafe fn free_state<M: Model>(name: &str, instance: *mut c_void, state: *mut *mut c_void) -> Status {
    call::<M>(instance, name, |component| {
        component.slave.check(Function::State)?;
        Ok(unsafe { state.as_mut() }.map_or(Ok(()), states::free)?)
    })
}

/// Tells how many bytes a state has.
pub unsafe fn state_size<M: Model>(
    name: &str,
    instance: *mut c_void,
    state: *mut c_void,
    size: *mut usize,
) -> Status {
    call::<M>(instance, name, |component| {
        component.slave.check(Function::State)?;
        let snapshot = component.state(state)?;
        // SAFETY: NULL or the place of a number.
        let size = unsafe { size.as_mut() }.ok_or(Refusal::Null("size"))?;
        *size = component.slave.serialize(&snapshot)?.len();
        Ok(())
    })
}

/// Writes a state to a buffer of the importer's.
pub unsafe fn serialize_state<M: Model>(
    name: &str,
    instance: *mut c_void,
    state: *mut c_void,
    bytes: *mut u8,
    size: usize,
) -> Status {
    call::<M>(instance, name, |component| {
        component.slave.check(Function::State)?;
        // SAFETY: NULL or as many bytes as said.
        component.serialize(state, unsafe { array_mut(bytes, size, "serializedState")? })
    })
}

/// Reads a state from bytes.
pub unsafe fn deserialize_state<M: Model>(
    name: &str,
    instance: *mut c_void,
    bytes: *const u8,
    size: usize,
    state: *mut *mut c_void,
) -> Status {
    call::<M>(instance, name, |component| {
        // SAFETY: NULL, or as many bytes as said and the place of a state pointer.
        let (bytes, place) = unsafe { (array(bytes, size, "serializedState")?, state.as_mut()) };
        let place = place.ok_or(Refusal::Null("FMUstate"))?;
        Ok(states::put(place, component.slave.deserialize(bytes)?)?)
    })
}

/// Does a communication step. If the model wants values to be seen within it, and the importer has
/// given a callback for that, it is done in parts. No borrow of the instance is held while the
/// callback runs: it reads values by calls of its own. Returns the time that was reached, and
/// whether the importer asked for an early return.
pub(crate) fn do_step<M: Model>(
    name: &str,
    instance: *mut c_void,
    from: f64,
    step: f64,
) -> (Status, f64, bool) {
    let intermediate = Instance::<M>::of(instance).and_then(|instance| instance.intermediate);
    let Some(Intermediate { update: Some(update), environment, early_return_allowed }) = intermediate else {
        let mut time = f64::NAN;
        let status = call::<M>(instance, name, |component| {
            time = component.slave.time();
            component.slave.do_step(from, step)?;
            time = component.slave.time();
            component.tell_warnings();
            Ok(())
        });
        return (status, time, false);
    };
    let (mut parts, mut time) = (Vec::new(), f64::NAN);
    let mut status = call::<M>(instance, name, |component| {
        time = component.slave.time();
        parts = component.slave.parts(from, step)?;
        Ok(())
    });
    for part in parts {
        status = warn(name, instance, |slave: &mut Slave<M>| slave.do_part(part));
        if status != Status::Ok {
            break;
        }
        time = part.end();
        if part.at_end.is_some() {
            break;
        }
        let within = |intermediate| {
            call::<M>(instance, name, |component| {
                component.slave.set_intermediate(intermediate);
                Ok(())
            })
        };
        let (mut requested, mut until) = (false, time);
        within(true);
        // SAFETY: the importer's callback, called as FMI says. No borrow of the instance is held.
        unsafe {
            update(
                environment,
                time,
                false,
                true,
                true,
                early_return_allowed,
                &raw mut requested,
                &raw mut until,
            );
        }
        within(false);
        // A time to return at that is later is reached by a later part.
        if requested && early_return_allowed && (until <= time || until.is_nan()) {
            return (status, time, true);
        }
    }
    (status, time, false)
}
