//! The C functions of FMI as an importer sees them: of a shared library, or of a model without one.
//!
//! # Safety
//! All functions have FMI's contract: an instance is one that was instantiated and is not freed, arrays have the length
//! that is given, texts end with a zero. See [`lemons_fmi::v2::component`] and [`lemons_fmi::v3::component`].

use lemons_fmi::Status;
use std::ffi::{c_char, c_void};
use std::ptr::null_mut;

/// A function that takes an instance and returns a status, called with arguments that mean nothing.
pub struct Probe<F> {
    /// Its name.
    pub name: &'static str,
    /// How many pointers it takes, besides the instance.
    pub pointers: usize,
    /// Calls it on an instance or NULL: one element in each array, zeros in all of them, and one pointer NULL.
    pub call: fn(&F, *mut c_void, Option<usize>) -> Option<Status>,
}

/// Makes the arguments of a [`Probe`].
#[derive(Default)]
struct Arguments {
    null: Option<usize>,
    pointers: usize,
    room: [u64; 32],
}

trait Argument: Sized {
    const POINTERS: usize = 0;
    fn make(arguments: &mut Arguments) -> Self;
}

macro_rules! plain {
    ($($type:ty = $value:expr),*) => {
        $(impl Argument for $type {
            fn make(_: &mut Arguments) -> Self {
                $value
            }
        })*
    };
}
plain!(bool = false, i32 = 0, u32 = 0, usize = 1, f64 = 0.0);

impl<T> Argument for *mut T {
    const POINTERS: usize = 1;

    fn make(arguments: &mut Arguments) -> Self {
        let place = arguments.pointers;
        arguments.pointers += 1;
        if arguments.null == Some(place) { null_mut() } else { arguments.room.as_mut_ptr().cast() }
    }
}

impl<T> Argument for *const T {
    const POINTERS: usize = 1;

    fn make(arguments: &mut Arguments) -> Self {
        <*mut T>::make(arguments)
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
            call: |c: &Functions, instance, null| {
                let mut arguments = Arguments { null, ..Arguments::default() };
                $(let $argument = <$type as Argument>::make(&mut arguments);)*
                let _ = &mut arguments;
                // SAFETY: an instance or NULL, and room for one element of any type.
                unsafe { (c.$name)(instance $(, $argument)*) }.status()
            },
        })
    };
    ($($other:tt)*) => { None };
}

macro_rules! functions {
    ($version:ident $model:path; $($name:ident = $body:ident($($argument:ident: $type:ty),*) $(-> $result:ty)?;)*) => {
        /// All functions of this version.
        #[allow(non_snake_case, missing_docs)] // the standard's own names
        #[derive(Clone, Copy)]
        pub struct Functions {
            $(pub $name: unsafe extern "C" fn($($type),*) $(-> $result)?,)*
        }

        impl Functions {
            /// Their names.
            pub const NAMES: &[&str] = &[$(stringify!($name)),*];

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
            pub fn of_model<M: $model>() -> Functions {
                Functions { $($name: lemons_fmi::$version::component::$body::<M>,)* }
            }

            /// Calls of all functions that take an instance and return a status.
            pub fn probes() -> Vec<Probe<Functions>> {
                [$(probe!($name, $($argument: $type),*)),*].into_iter().flatten().collect()
            }
        }
    };
}

/// The 34 functions of FMI 2.0 co-simulation.
pub mod fmi2 {
    use super::*;
    pub use lemons_fmi::v2::CallbackFunctions;
    use libloading::Library;
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

    lemons_fmi::fmi2_functions! { [functions] v2 lemons_fmi::Model; }
}

/// The 75 functions of FMI 3.0.
pub mod fmi3 {
    use super::*;
    use lemons_fmi::v3::component::{IntermediateUpdate, Logger3};
    use libloading::Library;

    lemons_fmi::fmi3_functions! { [functions] v3 lemons_fmi::v3::ArrayModel; }
}
