//! An importer that calls the FMI 3.0 functions with anything, within FMI's contract of memory: arrays are as long as
//! said, or NULL; states are the instance's own. Every answer is held against what all functions promise.

#![allow(unsafe_code)] // the C boundary, from the other side

use crate::importer::{Nulls, State, telling};
use lemons_fmi::Status;
use lemons_fmi::v3::ArrayModel;
use lemons_testing::fmi2::{ERROR, FATAL, OK, WARNING, status as status_of};
use lemons_testing::fmi3::{Functions, Log, log};
use std::cell::Cell;
use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::marker::PhantomData;
use std::ptr::{null, null_mut};

/// Functions that take nothing but the instance.
#[derive(Debug, Clone, Copy, PartialEq, Eq, arbitrary::Arbitrary)]
pub(crate) enum Plain3 {
    ExitInitializationMode,
    EnterConfigurationMode,
    ExitConfigurationMode,
    Terminate,
    Reset,
}

/// Functions of events, clocks and other kinds of FMUs.
#[derive(Debug, Clone, Copy, arbitrary::Arbitrary)]
pub(crate) enum Foreign {
    EnterEventMode,
    EnterStepMode,
    EnterContinuousTimeMode,
    EvaluateDiscreteStates,
    UpdateDiscreteStates,
    CompletedIntegratorStep,
    SetTime,
    States,
    Intervals,
    ActivateModelPartition,
    Derivatives,
}

/// Types that no variable has.
#[derive(Debug, Clone, Copy, arbitrary::Arbitrary)]
pub(crate) enum Absent {
    Float32,
    Int8,
    UInt16,
    Int64,
    Boolean,
    Binary,
    Clock,
}

/// What the importer's callback does within a step.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, arbitrary::Arbitrary)]
pub(crate) struct Within {
    /// A variable that is read.
    reference: u8,
    /// Whether it wants the step to end there.
    returns: bool,
    /// Whether it calls what is not allowed there.
    disturbs: bool,
}

/// What instance and callbacks share. The log is first: the logger takes the environment as it.
#[repr(C)]
struct Environment {
    log: Log,
    raw: Cell<*mut c_void>,
    c: Functions,
    within: Cell<Within>,
    updates: Cell<usize>,
}

/// Reads something, and perhaps calls what is refused there.
unsafe extern "C" fn update(
    environment: *mut c_void,
    time: f64,
    set_requested: bool,
    get_allowed: bool,
    finished: bool,
    can_return: bool,
    request: *mut bool,
    until: *mut f64,
) {
    // SAFETY: the environment that was given, which lives as long as the instance.
    let at = unsafe { &*environment.cast::<Environment>() };
    assert!(time.is_finite() && !set_requested && get_allowed && finished);
    at.updates.set(at.updates.get() + 1);
    let (within, raw, c) = (at.within.get(), at.raw.get(), &at.c);
    let mut values = [f64::NAN; 4];
    // SAFETY: an instance, and arrays as long as said.
    unsafe {
        let reference = u32::from(within.reference);
        let status = (c.fmi3GetFloat64)(raw, &reference, 1, values.as_mut_ptr(), values.len());
        assert!(status == ERROR || values.iter().all(|value| value.is_finite()), "{values:?}");
        if within.disturbs {
            let refused = [
                (c.fmi3SetFloat64)(raw, &reference, 1, values.as_ptr(), 4),
                (c.fmi3GetFMUState)(raw, &mut null_mut()),
                (c.fmi3Reset)(raw),
                (c.fmi3Terminate)(raw),
                (c.fmi3DoStep)(raw, time, 0.1, true, &mut false, &mut false, &mut false, &mut 0.0),
            ];
            assert_eq!(refused, [ERROR; 5], "not within a step");
        }
        if can_return {
            (*request, *until) = (within.returns, time);
        }
    }
    at.log.take();
}

/// What a step said.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Stepped {
    pub status: Status,
    pub early: bool,
    pub time: f64,
}

/// An instance and its log.
pub(crate) struct Importer3<M: ArrayModel> {
    raw: *mut c_void,
    c: Functions,
    environment: Box<Environment>,
    /// Whether refusals are told, as the last `fmi3SetDebugLogging` wanted it.
    hears: bool,
    model: PhantomData<M>,
}

impl<M: ArrayModel> Drop for Importer3<M> {
    fn drop(&mut self) {
        // SAFETY: given back once.
        unsafe { (self.c.fmi3FreeInstance)(self.raw) }
    }
}

impl<M: ArrayModel> Importer3<M> {
    /// `fmi3InstantiateCoSimulation`, or `None` after a message.
    pub(crate) fn new(
        [name, token, path]: [Option<&CStr>; 3],
        [logging, events, early, updates]: [bool; 4],
    ) -> Option<Importer3<M>> {
        let c = Functions::of_model::<M>();
        let environment = Box::new(Environment {
            log: Log::default(),
            raw: Cell::new(null_mut()),
            c,
            within: Cell::default(),
            updates: Cell::default(),
        });
        let at = std::ptr::from_ref(&*environment).cast_mut().cast();
        let text = |text: Option<&CStr>| text.map_or(null(), CStr::as_ptr);
        let (update, log): (Option<lemons_testing::fmi3::IntermediateUpdate>, _) =
            (updates.then_some(update), Some(log as lemons_testing::fmi3::Logger3));
        let (name, token, path) = (text(name), text(token), text(path));
        // SAFETY: texts that end in a zero, or NULL.
        let raw = unsafe {
            let make = c.fmi3InstantiateCoSimulation;
            make(name, token, path, false, logging, events, early, null(), 0, at, log, update)
        };
        let told = environment.log.take();
        if raw.is_null() {
            assert!(told.iter().any(|(status, ..)| *status == ERROR), "told why: {told:?}");
            assert!(told.iter().all(|(status, ..)| *status != FATAL), "{told:?}");
            return None;
        }
        assert!(!events, "an FMU without events");
        environment.raw.set(raw);
        Some(Importer3 { raw, c, environment, hears: true, model: PhantomData })
    }

    /// What every return value promises.
    fn answered(&self, status: c_int) -> Status {
        let told = self.environment.log.take();
        for (_, category, text) in &told {
            assert!(category.starts_with("log"), "{told:?}");
            assert!(!text.is_empty(), "a message says something");
        }
        if telling() && !told.is_empty() {
            eprintln!("    {told:?}");
        }
        let tells = |wanted| told.iter().any(|(status, ..)| *status == wanted);
        assert!([OK, WARNING, ERROR].contains(&status), "{status:?}: {told:?}");
        assert!(status != ERROR || tells(status) || !self.hears, "an error without a word");
        assert!(status != OK || !tells(ERROR), "an error told, but returned Ok: {told:?}");
        assert!(!tells(FATAL), "{told:?}");
        status_of(status)
    }

    /// As [`Importer3::answered`], of a call on `count` elements some of whose `places` arrays may be NULL.
    fn answered_arrays(&self, status: c_int, count: usize, nulls: Nulls, places: u8) -> Status {
        assert!(status != OK || count == 0 || !nulls.any(places), "NULL is refused");
        self.answered(status)
    }

    pub(crate) fn within(&self, within: Within) {
        self.environment.within.set(within);
    }

    /// How many times the callback ran.
    pub(crate) fn updates(&self) -> usize {
        self.environment.updates.get()
    }

    pub(crate) fn plain(&self, function: Plain3) -> Status {
        let (c, i) = (&self.c, self.raw);
        // SAFETY: an instance.
        self.answered(unsafe {
            match function {
                Plain3::ExitInitializationMode => (c.fmi3ExitInitializationMode)(i),
                Plain3::EnterConfigurationMode => (c.fmi3EnterConfigurationMode)(i),
                Plain3::ExitConfigurationMode => (c.fmi3ExitConfigurationMode)(i),
                Plain3::Terminate => (c.fmi3Terminate)(i),
                Plain3::Reset => (c.fmi3Reset)(i),
            }
        })
    }

    /// A tolerance of 0 is not defined.
    pub(crate) fn enter_initialization(&self, tolerance: f64, start: f64, stop: Option<f64>) -> Status {
        let (defined, stop) = (stop.is_some(), stop.unwrap_or(f64::NAN));
        // SAFETY: an instance.
        self.answered(unsafe {
            (self.c.fmi3EnterInitializationMode)(self.raw, tolerance != 0.0, tolerance, start, defined, stop)
        })
    }

    /// Calls a function that is not offered: it must be refused.
    pub(crate) fn foreign(&self, function: Foreign, nulls: Nulls) -> Status {
        let (c, i) = (&self.c, self.raw);
        let (mut flags, mut number, mut count, mut whole) = ([false; 5], [0.0; 2], 0, [0; 2]);
        let flag = nulls.or_mut(0, flags.as_mut_ptr());
        let real = nulls.or_mut(1, number.as_mut_ptr());
        // SAFETY: an instance, and places of values or NULL.
        let status = unsafe {
            match function {
                Foreign::EnterEventMode => (c.fmi3EnterEventMode)(i),
                Foreign::EnterStepMode => (c.fmi3EnterStepMode)(i),
                Foreign::EnterContinuousTimeMode => (c.fmi3EnterContinuousTimeMode)(i),
                Foreign::EvaluateDiscreteStates => (c.fmi3EvaluateDiscreteStates)(i),
                Foreign::UpdateDiscreteStates => {
                    (c.fmi3UpdateDiscreteStates)(i, flag, flag, flag, flag, flag, real)
                }
                Foreign::CompletedIntegratorStep => (c.fmi3CompletedIntegratorStep)(i, true, flag, flag),
                Foreign::SetTime => (c.fmi3SetTime)(i, 1.0),
                Foreign::States => {
                    assert_eq!(
                        (c.fmi3GetNumberOfContinuousStates)(i, nulls.or_mut(2, &raw mut count)),
                        ERROR
                    );
                    assert_eq!((c.fmi3GetNumberOfEventIndicators)(i, nulls.or_mut(2, &raw mut count)), ERROR);
                    assert_eq!((c.fmi3GetContinuousStates)(i, real, 1), ERROR);
                    (c.fmi3SetContinuousStates)(i, real, 1)
                }
                Foreign::Intervals => {
                    assert_eq!((c.fmi3GetShiftDecimal)(i, &0, 1, real), ERROR);
                    (c.fmi3GetIntervalDecimal)(i, &0, 1, real, nulls.or_mut(3, whole.as_mut_ptr()))
                }
                Foreign::ActivateModelPartition => (c.fmi3ActivateModelPartition)(i, 0, 0.0),
                Foreign::Derivatives => (c.fmi3GetDirectionalDerivative)(i, &1, 1, &1, 1, real, 1, real, 1),
            }
        };
        assert_eq!(status, ERROR, "not offered");
        self.answered(status)
    }

    /// Reads or sets variables of a type that none has: right for none of them only.
    pub(crate) fn absent(&self, kind: Absent, references: &[u32], set: bool) -> Status {
        let (c, i, at, count) = (&self.c, self.raw, references.as_ptr(), references.len());
        let (mut bytes, mut sizes) = ([0_u64; 16], [0_usize; 16]);
        let (to, size) = (bytes.as_mut_ptr(), sizes.as_mut_ptr());
        // SAFETY: arrays of sixteen elements, which is more than are asked for.
        let status = unsafe {
            match (kind, set) {
                (Absent::Float32, false) => (c.fmi3GetFloat32)(i, at, count, to.cast(), count),
                (Absent::Float32, true) => (c.fmi3SetFloat32)(i, at, count, to.cast(), count),
                (Absent::Int8, false) => (c.fmi3GetInt8)(i, at, count, to.cast(), count),
                (Absent::Int8, true) => (c.fmi3SetInt8)(i, at, count, to.cast(), count),
                (Absent::UInt16, false) => (c.fmi3GetUInt16)(i, at, count, to.cast(), count),
                (Absent::UInt16, true) => (c.fmi3SetUInt16)(i, at, count, to.cast(), count),
                (Absent::Int64, false) => (c.fmi3GetInt64)(i, at, count, to.cast(), count),
                (Absent::Int64, true) => (c.fmi3SetInt64)(i, at, count, to.cast(), count),
                (Absent::Boolean, false) => (c.fmi3GetBoolean)(i, at, count, to.cast(), count),
                (Absent::Boolean, true) => (c.fmi3SetBoolean)(i, at, count, to.cast(), count),
                (Absent::Binary, false) => (c.fmi3GetBinary)(i, at, count, size, to.cast(), count),
                (Absent::Binary, true) => (c.fmi3SetBinary)(i, at, count, size, to.cast(), count),
                (Absent::Clock, false) => (c.fmi3GetClock)(i, at, count, to.cast()),
                (Absent::Clock, true) => (c.fmi3SetClock)(i, at, count, to.cast()),
            }
        };
        assert!(status != OK || count == 0, "no variable has this type");
        assert!(bytes == [0; 16] && sizes == [0; 16], "nothing is written");
        self.answered(status)
    }

    pub(crate) fn debug_logging(&mut self, on: bool, categories: &[Option<&CStr>], nulls: Nulls) -> Status {
        let pointers: Vec<*const c_char> =
            categories.iter().map(|text| text.map_or(null(), CStr::as_ptr)).collect();
        let count = pointers.len();
        // SAFETY: as many texts as said.
        let status =
            unsafe { (self.c.fmi3SetDebugLogging)(self.raw, on, count, nulls.or(0, pointers.as_ptr())) };
        let has = |wanted| categories.contains(&Some(wanted)) || categories.contains(&Some(c"logAll"));
        if status == OK {
            // Errors are told in any case.
            self.hears = !on || categories.is_empty() || has(c"logStatusError");
        }
        self.answered_arrays(status, count, nulls, 1)
    }

    pub(crate) fn get_float64(&self, references: &[u32], length: usize, nulls: Nulls) -> (Status, Vec<f64>) {
        let (count, mut values) = (references.len(), vec![f64::NAN; length]);
        let (at, to) = (nulls.or(0, references.as_ptr()), nulls.or_mut(1, values.as_mut_ptr()));
        // SAFETY: arrays as long as said.
        let status = unsafe { (self.c.fmi3GetFloat64)(self.raw, at, count, to, length) };
        (self.answered_arrays(status, count, nulls, 2), values)
    }

    pub(crate) fn get_int32(&self, references: &[u32], length: usize, nulls: Nulls) -> (Status, Vec<i32>) {
        let (count, mut values) = (references.len(), vec![0; length]);
        let (at, to) = (nulls.or(0, references.as_ptr()), nulls.or_mut(1, values.as_mut_ptr()));
        // SAFETY: arrays as long as said.
        let status = unsafe { (self.c.fmi3GetInt32)(self.raw, at, count, to, length) };
        (self.answered_arrays(status, count, nulls, 2), values)
    }

    pub(crate) fn get_uint64(&self, references: &[u32], length: usize, nulls: Nulls) -> (Status, Vec<u64>) {
        let (count, mut values) = (references.len(), vec![0; length]);
        let (at, to) = (nulls.or(0, references.as_ptr()), nulls.or_mut(1, values.as_mut_ptr()));
        // SAFETY: arrays as long as said.
        let status = unsafe { (self.c.fmi3GetUInt64)(self.raw, at, count, to, length) };
        (self.answered_arrays(status, count, nulls, 2), values)
    }

    /// The texts are read, and those of the last call are gone.
    pub(crate) fn get_string(
        &self,
        references: &[u32],
        length: usize,
        nulls: Nulls,
    ) -> (Status, Vec<CString>) {
        let (count, mut values) = (references.len(), vec![null(); length]);
        let (at, to) = (nulls.or(0, references.as_ptr()), nulls.or_mut(1, values.as_mut_ptr()));
        // SAFETY: arrays as long as said.
        let status = unsafe { (self.c.fmi3GetString)(self.raw, at, count, to, length) };
        let status = self.answered_arrays(status, count, nulls, 2);
        let texts = match status {
            // SAFETY: texts that live until the next call.
            Status::Ok => values.iter().map(|text| unsafe { CStr::from_ptr(*text) }.to_owned()).collect(),
            _ => Vec::new(),
        };
        (status, texts)
    }

    pub(crate) fn set_float64(&self, references: &[u32], values: &[f64], nulls: Nulls) -> Status {
        let (at, from) = (nulls.or(0, references.as_ptr()), nulls.or(1, values.as_ptr()));
        // SAFETY: arrays as long as said.
        let status = unsafe { (self.c.fmi3SetFloat64)(self.raw, at, references.len(), from, values.len()) };
        self.answered_arrays(status, references.len(), nulls, 2)
    }

    pub(crate) fn set_int32(&self, references: &[u32], values: &[i32], nulls: Nulls) -> Status {
        let (at, from) = (nulls.or(0, references.as_ptr()), nulls.or(1, values.as_ptr()));
        // SAFETY: arrays as long as said.
        let status = unsafe { (self.c.fmi3SetInt32)(self.raw, at, references.len(), from, values.len()) };
        self.answered_arrays(status, references.len(), nulls, 2)
    }

    pub(crate) fn set_uint64(&self, references: &[u32], values: &[u64], nulls: Nulls) -> Status {
        let (at, from) = (nulls.or(0, references.as_ptr()), nulls.or(1, values.as_ptr()));
        // SAFETY: arrays as long as said.
        let status = unsafe { (self.c.fmi3SetUInt64)(self.raw, at, references.len(), from, values.len()) };
        self.answered_arrays(status, references.len(), nulls, 2)
    }

    pub(crate) fn set_string(&self, references: &[u32], values: &[Option<&CStr>], nulls: Nulls) -> Status {
        let pointers: Vec<*const c_char> =
            values.iter().map(|text| text.map_or(null(), CStr::as_ptr)).collect();
        let (at, from) = (nulls.or(0, references.as_ptr()), nulls.or(1, pointers.as_ptr()));
        // SAFETY: arrays as long as said, of texts that end in a zero or NULL.
        let status = unsafe { (self.c.fmi3SetString)(self.raw, at, references.len(), from, values.len()) };
        assert!(status != OK || values.iter().all(Option::is_some), "a NULL text is refused");
        self.answered_arrays(status, references.len(), nulls, 2)
    }

    pub(crate) fn output_derivatives(
        &self,
        references: &[u32],
        orders: &[i32],
        length: usize,
        nulls: Nulls,
    ) -> Status {
        assert_eq!(references.len(), orders.len());
        let mut values = vec![1.0; length];
        let (at, of) = (nulls.or(0, references.as_ptr()), nulls.or(2, orders.as_ptr()));
        let (count, to) = (references.len(), nulls.or_mut(1, values.as_mut_ptr()));
        // SAFETY: arrays as long as said.
        let status = unsafe { (self.c.fmi3GetOutputDerivatives)(self.raw, at, count, of, to, length) };
        assert!(status != OK || orders.iter().all(|order| *order == 1), "only order 1 is known");
        assert!(values.iter().all(|value| value.is_finite()), "{values:?}");
        self.answered_arrays(status, count, nulls, 3)
    }

    /// Their number and, into arrays of that many and `more` elements, the dependencies.
    pub(crate) fn dependencies(&self, reference: u32, more: usize, nulls: Nulls) -> Status {
        let mut count = 0;
        // SAFETY: NULL or the place of a number.
        let status = unsafe {
            let number = self.c.fmi3GetNumberOfVariableDependencies;
            number(self.raw, reference, nulls.or_mut(0, &raw mut count))
        };
        let first = self.answered_arrays(status, 1, nulls, 1);
        if first != Status::Ok {
            return first;
        }
        let length = count + more;
        let (mut dependents, mut elements) = (vec![0; length], vec![0; length]);
        let (mut independents, mut kinds) = (vec![0; length], vec![0; length]);
        // SAFETY: arrays as long as said.
        let status = unsafe {
            (self.c.fmi3GetVariableDependencies)(
                self.raw,
                reference,
                nulls.or_mut(1, dependents.as_mut_ptr()),
                nulls.or_mut(2, independents.as_mut_ptr()),
                nulls.or_mut(3, elements.as_mut_ptr()),
                nulls.or_mut(4, kinds.as_mut_ptr()),
                length,
            )
        };
        assert!(status != OK || more == 0, "another number than there are");
        assert!(status != OK || !dependents.contains(&0) && !elements.contains(&0), "counted from 1");
        self.answered(status)
    }

    pub(crate) fn do_step(&self, from: f64, step: f64, nulls: Nulls) -> Stepped {
        let (mut event, mut terminate, mut early, mut time) = (true, true, true, f64::NAN);
        // SAFETY: an instance, and places of values or NULL.
        let status = unsafe {
            (self.c.fmi3DoStep)(
                self.raw,
                from,
                step,
                true,
                nulls.or_mut(0, &raw mut event),
                nulls.or_mut(1, &raw mut terminate),
                nulls.or_mut(2, &raw mut early),
                nulls.or_mut(3, &raw mut time),
            )
        };
        assert!((nulls.at(0) || !event) && (nulls.at(1) || !terminate), "always set");
        assert!(nulls.at(3) || time.is_finite(), "always set");
        Stepped { status: self.answered(status), early: early && !nulls.at(2), time }
    }

    pub(crate) fn get_state(&self, state: &mut State, nulls: Nulls) -> Status {
        // SAFETY: NULL or the place of a state pointer.
        let status = unsafe { (self.c.fmi3GetFMUState)(self.raw, nulls.or_mut(0, &raw mut state.0)) };
        self.answered_arrays(status, 1, nulls, 1)
    }

    pub(crate) fn set_state(&self, state: &State) -> Status {
        // SAFETY: NULL or a state.
        let status = unsafe { (self.c.fmi3SetFMUState)(self.raw, state.0) };
        assert!(status != OK || !state.is_null(), "NULL is no state");
        self.answered(status)
    }

    pub(crate) fn free_state(&self, state: &mut State, nulls: Nulls) -> Status {
        // SAFETY: NULL or the place of a state pointer.
        let status = unsafe { (self.c.fmi3FreeFMUState)(self.raw, nulls.or_mut(0, &raw mut state.0)) };
        assert!(status != OK || nulls.at(0) || state.is_null(), "it is NULL afterwards");
        self.answered(status)
    }

    pub(crate) fn serialized_size(&self, state: &State, nulls: Nulls) -> (Status, usize) {
        let mut size = 0;
        // SAFETY: NULL or a state, NULL or the place of a number.
        let status =
            unsafe { (self.c.fmi3SerializedFMUStateSize)(self.raw, state.0, nulls.or_mut(0, &raw mut size)) };
        (self.answered_arrays(status, 1, nulls, 1), size)
    }

    /// Into a buffer of `size` bytes.
    pub(crate) fn serialize(&self, state: &State, size: usize, nulls: Nulls) -> (Status, Vec<u8>) {
        let mut bytes = vec![0; size];
        // SAFETY: NULL or a state, as many bytes as said.
        let status = unsafe {
            (self.c.fmi3SerializeFMUState)(self.raw, state.0, nulls.or_mut(0, bytes.as_mut_ptr()), size)
        };
        (self.answered_arrays(status, size, nulls, 1), bytes)
    }

    pub(crate) fn deserialize(&self, bytes: &[u8], state: &mut State, nulls: Nulls) -> Status {
        let (from, to) = (nulls.or(0, bytes.as_ptr()), nulls.or_mut(1, &raw mut state.0));
        // SAFETY: as many bytes as said, NULL or the place of a state pointer.
        let status = unsafe { (self.c.fmi3DeserializeFMUState)(self.raw, from, bytes.len(), to) };
        self.answered_arrays(status, 1, nulls, 2)
    }
}
