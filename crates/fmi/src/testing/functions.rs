//! The C functions of FMI as an importer sees them: of a shared library, or of a model without one.
//!
//! # Safety
//! All functions have FMI's contract: an instance is one that was instantiated and is not freed, arrays have the length
//! that is given, texts end with a zero. See [`crate::calls`].

use crate::{Model, Status};
use libloading::{Library, Symbol};
use std::any::TypeId;
use std::ffi::{c_char, c_void};
use std::ptr::null_mut;

/// Gives arguments to a function, one after the other.
pub trait ArgumentSource {
    /// The bits of a number of this type.
    fn number(&mut self, of: TypeId) -> u64;
    /// A pointer of this type, to an array or to a place of values; or NULL.
    fn pointer(&mut self, of: TypeId) -> *mut c_void;
}

/// A function that takes an instance and returns a status.
pub struct Probe<F> {
    /// Its name.
    pub name: &'static str,
    /// Number of pointers that it takes, besides the instance.
    pub pointers: usize,
    /// Calls it on an instance or NULL, with arguments from a source.
    pub with: fn(&F, *mut c_void, &mut dyn ArgumentSource) -> Option<Status>,
}

impl<F> Probe<F> {
    /// Calls the function with arguments that mean nothing: one element in each array, zeros in all of them, and one
    /// pointer NULL.
    pub fn call(&self, functions: &F, instance: *mut c_void, null: Option<usize>) -> Option<Status> {
        (self.with)(functions, instance, &mut Zeros { null, pointers: 0, room: [0; 32] })
    }
}

struct Zeros {
    null: Option<usize>,
    pointers: usize,
    room: [u64; 32],
}

impl ArgumentSource for Zeros {
    fn number(&mut self, of: TypeId) -> u64 {
        u64::from(of == TypeId::of::<usize>())
    }

    fn pointer(&mut self, _: TypeId) -> *mut c_void {
        let place = self.pointers;
        self.pointers += 1;
        if self.null == Some(place) { null_mut() } else { self.room.as_mut_ptr().cast() }
    }
}

trait Argument: Sized {
    const POINTERS: usize = 0;
    fn make(source: &mut dyn ArgumentSource) -> Self;
}

macro_rules! plain {
    ($($type:ty = $from:expr),*) => {
        $(impl Argument for $type {
            fn make(source: &mut dyn ArgumentSource) -> Self {
                $from(source.number(TypeId::of::<$type>()))
            }
        })*
    };
}
plain!(
    bool = |bits| bits != 0,
    i32 = |bits| bits as i32,
    u32 = |bits| bits as u32,
    usize = |bits| bits as usize,
    f64 = f64::from_bits
);

impl<T: 'static> Argument for *mut T {
    const POINTERS: usize = 1;

    fn make(source: &mut dyn ArgumentSource) -> Self {
        source.pointer(TypeId::of::<*mut T>()).cast()
    }
}

impl<T: 'static> Argument for *const T {
    const POINTERS: usize = 1;

    fn make(source: &mut dyn ArgumentSource) -> Self {
        source.pointer(TypeId::of::<*const T>()).cast_const().cast()
    }
}

trait Outcome {
    fn status(self) -> Option<Status>;
}

impl Outcome for Status {
    fn status(self) -> Option<Status> {
        Some(self)
    }
}

/// A probe, if the first argument is an instance that stays alive.
macro_rules! probe {
    (fmi2FreeInstance, $($rest:tt)*) => { None };
    (fmi3FreeInstance, $($rest:tt)*) => { None };
    ($name:ident, instance: $instance:ty $(, $argument:ident: $type:ty)*) => {
        Some(Probe {
            name: stringify!($name),
            pointers: 0 $(+ <$type as Argument>::POINTERS)*,
            with: |c: &Functions, instance, source| {
                $(let $argument = <$type as Argument>::make(source);)*
                let _ = source;
                // SAFETY: an instance or NULL, and arrays as long as the source says.
                unsafe { (c.$name)(instance $(, $argument)*) }.status()
            },
        })
    };
    ($($other:tt)*) => { None };
}

macro_rules! functions {
    (
        $($name:ident($($argument:ident: $type:ty),*) $(-> $result:ty)?
            = $module:ident::$body:ident($($with:expr),*);)*
        [of an instance]
        $($call:ident($($given:ident: $of:ty),*) = $method:ident($($passed:expr),*);)*
    ) => {
        /// All functions of this version.
        #[allow(non_snake_case, missing_docs)] // the standard's own names
        #[derive(Clone, Copy)]
        pub struct Functions {
            $(pub $name: unsafe extern "C" fn($($type),*) $(-> $result)?,)*
            $(pub $call: unsafe extern "C" fn(*mut c_void $(, $of)*) -> Status,)*
        }

        impl Functions {
            /// Their names.
            pub const NAMES: &[&str] = &[$(stringify!($name),)* $(stringify!($call)),*];

            /// Those of a shared library, which must stay loaded while they are called.
            ///
            /// # Panics
            /// One is not exported.
            pub fn of(library: &Library) -> Functions {
                Functions {
                    // SAFETY: the library exports them with the standard's signatures.
                    $($name: *unsafe { exported(library, stringify!($name)) },)*
                    $($call: *unsafe { exported(library, stringify!($call)) },)*
                }
            }

            /// Those of a model, without a library.
            #[allow(non_snake_case)] // the standard's own names
            pub fn of_model<M: Model>() -> Functions {
                $(
                    #[allow(unused_variables)] // what is not offered takes arguments, too
                    unsafe extern "C" fn $name<M: Model>($($argument: $type),*) $(-> $result)? {
                        // SAFETY: the caller keeps FMI's contract, which is the body's.
                        unsafe { crate::$module::$body::<M>(stringify!($name) $(, $with)*) }
                    }
                )*
                $(
                    #[allow(unused_variables)] // as above
                    unsafe extern "C" fn $call<M: Model>(instance: *mut c_void $(, $given: $of)*) -> Status {
                        // SAFETY: as above.
                        unsafe {
                            crate::boundary::call::<M>(instance, stringify!($call), |component| {
                                component.$method($($passed),*)
                            })
                        }
                    }
                )*
                Functions { $($name: $name::<M>,)* $($call: $call::<M>,)* }
            }

            /// Calls of all functions that take an instance and return a status.
            pub fn probes() -> Vec<Probe<Functions>> {
                let all = [
                    $(probe!($name, $($argument: $type),*),)*
                    $(probe!($call, instance: *mut c_void $(, $given: $of)*),)*
                ];
                all.into_iter().flatten().collect()
            }
        }
    };
}

/// Returns a function of a shared library.
///
/// # Safety
/// The library exports it with this type.
unsafe fn exported<'a, F>(library: &'a Library, name: &str) -> Symbol<'a, F> {
    // SAFETY: as the caller promises.
    unsafe { library.get(name) }.unwrap_or_else(|error| panic!("{name} is not exported: {error}"))
}

/// The 34 functions of FMI 2.0 co-simulation.
pub mod fmi2 {
    use super::*;
    pub use crate::v2::CallbackFunctions;
    use std::ffi::{c_int, c_uint};

    /// `fmi2CoSimulation`
    pub const CO_SIMULATION: c_int = 1;

    /// No logger, no memory functions: all of them may be NULL.
    pub const NO_CALLBACKS: CallbackFunctions = CallbackFunctions {
        logger: None,
        allocate_memory: std::ptr::null(),
        free_memory: std::ptr::null(),
        step_finished: std::ptr::null(),
        component_environment: null_mut(),
    };

    crate::fmi2_functions! { [functions] }
}

/// The 75 functions of FMI 3.0.
pub mod fmi3 {
    use super::*;
    use crate::boundary::{IntermediateUpdate, Logger3};

    crate::fmi3_functions! { [functions] }
}
