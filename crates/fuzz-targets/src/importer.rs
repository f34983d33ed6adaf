//! An importer that calls the FMI functions with anything, within FMI's contract of memory: arrays are as
//! long as said, or NULL; states are the instance's own. Every answer is held against what all functions promise.

#![allow(unsafe_code)] // the C boundary, from the other side

use lemons_fmi::{Model, Status};
use lemons_testing::fmi2::{DISCARD, ERROR, FATAL, Functions, Log, OK, WARNING};
use std::ffi::{CStr, CString, c_char, c_int, c_uint, c_void};
use std::marker::PhantomData;
use std::ptr::{null, null_mut};
use std::sync::OnceLock;

/// Whether calls, answers and messages are shown: see `examples/one.rs`.
pub(crate) fn telling() -> bool {
    static TELLING: OnceLock<bool> = OnceLock::new();
    *TELLING.get_or_init(|| std::env::var_os("FUZZ_TOLD").is_some())
}

/// Which pointers of a call are NULL, one bit each; mostly none.
#[derive(Debug, Clone, Copy, arbitrary::Arbitrary)]
pub(crate) struct Nulls(u8);

impl Nulls {
    pub(crate) const NONE: Nulls = Nulls(0);

    pub(crate) fn at(self, place: u8) -> bool {
        self.0 & 0xe0 == 0xe0 && self.0 >> place & 1 == 1
    }

    pub(crate) fn any(self, places: u8) -> bool {
        (0..places).any(|place| self.at(place))
    }

    pub(crate) fn or<T>(self, place: u8, pointer: *const T) -> *const T {
        if self.at(place) { null() } else { pointer }
    }

    pub(crate) fn or_mut<T>(self, place: u8, pointer: *mut T) -> *mut T {
        if self.at(place) { null_mut() } else { pointer }
    }
}

/// A pointer of `fmi2GetFMUstate`, perhaps still NULL.
pub(crate) struct State(pub(crate) *mut c_void);

impl State {
    pub(crate) const NULL: State = State(null_mut());

    pub(crate) fn is_null(&self) -> bool {
        self.0.is_null()
    }
}

/// Functions that take nothing but the instance.
#[derive(Debug, Clone, Copy, PartialEq, Eq, arbitrary::Arbitrary)]
pub(crate) enum Plain {
    EnterInitializationMode,
    ExitInitializationMode,
    Terminate,
    Reset,
    CancelStep,
}

/// The functions that ask for a status.
#[derive(Debug, Clone, Copy, arbitrary::Arbitrary)]
pub(crate) enum StatusOf {
    Status,
    Real,
    Integer,
    Boolean,
    String,
}

/// An instance and its log.
pub(crate) struct Importer<M: Model> {
    raw: *mut c_void,
    c: Functions,
    log: Box<Log>,
    /// Whether refusals and discards are told, as the last `fmi2SetDebugLogging` wanted it.
    hears: [bool; 2],
    model: PhantomData<M>,
}

impl<M: Model> Drop for Importer<M> {
    fn drop(&mut self) {
        // SAFETY: given back once.
        unsafe { (self.c.fmi2FreeInstance)(self.raw) }
    }
}

impl<M: Model> Importer<M> {
    /// `fmi2Instantiate`, or `None` after a message.
    pub(crate) fn new(
        [name, guid, uri]: [Option<&CStr>; 3],
        fmu_type: c_int,
        logging_on: c_int,
    ) -> Option<Importer<M>> {
        let (c, log) = (Functions::of_model::<M>(), Box::<Log>::default());
        let callbacks = log.callbacks();
        let pointer = |text: Option<&CStr>| text.map_or(null(), CStr::as_ptr);
        // SAFETY: texts that end in a zero, or NULL.
        let raw = unsafe {
            (c.fmi2Instantiate)(
                pointer(name),
                fmu_type,
                pointer(guid),
                pointer(uri),
                &callbacks,
                0,
                logging_on,
            )
        };
        if raw.is_null() {
            let told = log.take();
            assert!(told.iter().any(|message| message.status == ERROR), "told why: {told:?}");
            assert!(told.iter().all(|message| message.status != FATAL), "{told:?}");
            return None;
        }
        log.take();
        Some(Importer { raw, c, log, hears: [true, logging_on != 0], model: PhantomData })
    }

    /// What every return value promises.
    fn answered(&self, status: c_int) -> Status {
        let told = self.log.take();
        for message in &told {
            assert_eq!(message.format, "%s");
            assert!(message.category.starts_with("log"), "{message:?}");
            assert!(!message.text.is_empty(), "a message says something");
        }
        if telling() && !told.is_empty() {
            eprintln!("    {told:?}");
        }
        let tells = |wanted| told.iter().any(|message| message.status == wanted);
        assert!([OK, WARNING, DISCARD, ERROR].contains(&status), "{status:?}: {told:?}");
        assert!(status != ERROR || tells(status) || !self.hears[0], "an error without a word");
        assert!(status != DISCARD || tells(status) || !self.hears[1], "a discard without a word");
        assert!(status != OK || !tells(ERROR), "an error told, but returned Ok: {told:?}");
        assert!(!tells(FATAL), "{told:?}");
        lemons_testing::fmi2::status(status)
    }

    /// As [`Importer::answered`], of a call on `count` elements some of whose `places` arrays may be NULL.
    fn answered_arrays(&self, status: c_int, count: usize, nulls: Nulls, places: u8) -> Status {
        assert!(status != OK || count == 0 || !nulls.any(places), "NULL is refused");
        self.answered(status)
    }

    pub(crate) fn plain(&self, function: Plain) -> Status {
        // SAFETY: an instance.
        self.answered(unsafe {
            match function {
                Plain::EnterInitializationMode => (self.c.fmi2EnterInitializationMode)(self.raw),
                Plain::ExitInitializationMode => (self.c.fmi2ExitInitializationMode)(self.raw),
                Plain::Terminate => (self.c.fmi2Terminate)(self.raw),
                Plain::Reset => (self.c.fmi2Reset)(self.raw),
                Plain::CancelStep => (self.c.fmi2CancelStep)(self.raw),
            }
        })
    }

    pub(crate) fn debug_logging(&mut self, on: bool, categories: &[Option<&CStr>], nulls: Nulls) -> Status {
        let pointers: Vec<*const c_char> =
            categories.iter().map(|text| text.map_or(null(), CStr::as_ptr)).collect();
        let count = pointers.len();
        // SAFETY: as many texts as said.
        let status = unsafe {
            (self.c.fmi2SetDebugLogging)(self.raw, on.into(), count, nulls.or(0, pointers.as_ptr()))
        };
        let has = |wanted| categories.contains(&Some(wanted)) || categories.contains(&Some(c"logAll"));
        if status == OK {
            let all = categories.is_empty();
            // Errors are told in any case.
            self.hears = if on {
                [all || has(c"logStatusError"), all || has(c"logStatusWarning")]
            } else {
                [true, false]
            };
        }
        self.answered_arrays(status, count, nulls, 1)
    }

    /// A tolerance of 0 is not defined.
    pub(crate) fn setup_experiment(&self, tolerance: f64, start: f64, stop: Option<f64>) -> Status {
        // SAFETY: an instance.
        self.answered(unsafe {
            let (defined, stop) = (stop.is_some().into(), stop.unwrap_or(f64::NAN));
            let with_tolerance = (tolerance != 0.0).into();
            (self.c.fmi2SetupExperiment)(self.raw, with_tolerance, tolerance, start, defined, stop)
        })
    }

    pub(crate) fn get_real(&self, references: &[u32], nulls: Nulls) -> (Status, Vec<f64>) {
        let (count, mut values) = (references.len(), vec![f64::NAN; references.len()]);
        let (at, to) = (nulls.or(0, references.as_ptr()), nulls.or_mut(1, values.as_mut_ptr()));
        // SAFETY: arrays as long as said.
        let status = unsafe { (self.c.fmi2GetReal)(self.raw, at, count, to) };
        (self.answered_arrays(status, count, nulls, 2), values)
    }

    pub(crate) fn get_integer(&self, references: &[u32], nulls: Nulls) -> (Status, Vec<c_int>) {
        let (count, mut values) = (references.len(), vec![0; references.len()]);
        let (at, to) = (nulls.or(0, references.as_ptr()), nulls.or_mut(1, values.as_mut_ptr()));
        // SAFETY: arrays as long as said.
        let status = unsafe { (self.c.fmi2GetInteger)(self.raw, at, count, to) };
        (self.answered_arrays(status, count, nulls, 2), values)
    }

    pub(crate) fn get_boolean(&self, references: &[u32], nulls: Nulls) -> Status {
        let (count, mut values) = (references.len(), vec![0; references.len()]);
        let (at, to) = (nulls.or(0, references.as_ptr()), nulls.or_mut(1, values.as_mut_ptr()));
        // SAFETY: arrays as long as said.
        let status = unsafe { (self.c.fmi2GetBoolean)(self.raw, at, count, to) };
        self.answered_arrays(status, count, nulls, 2)
    }

    /// The texts are read, and those of the last call are gone.
    pub(crate) fn get_string(&self, references: &[u32], nulls: Nulls) -> (Status, Vec<CString>) {
        let (count, mut values) = (references.len(), vec![null(); references.len()]);
        let (at, to) = (nulls.or(0, references.as_ptr()), nulls.or_mut(1, values.as_mut_ptr()));
        // SAFETY: arrays as long as said.
        let status = unsafe { (self.c.fmi2GetString)(self.raw, at, count, to) };
        let status = self.answered_arrays(status, count, nulls, 2);
        let texts = match status {
            // SAFETY: texts that live until the next call.
            Status::Ok => values.iter().map(|text| unsafe { CStr::from_ptr(*text) }.to_owned()).collect(),
            _ => Vec::new(),
        };
        (status, texts)
    }

    pub(crate) fn set_real(&self, references: &[u32], values: &[f64], nulls: Nulls) -> Status {
        assert_eq!(references.len(), values.len());
        let (at, from) = (nulls.or(0, references.as_ptr()), nulls.or(1, values.as_ptr()));
        // SAFETY: arrays as long as said.
        let status = unsafe { (self.c.fmi2SetReal)(self.raw, at, values.len(), from) };
        self.answered_arrays(status, values.len(), nulls, 2)
    }

    pub(crate) fn set_integer(&self, references: &[u32], values: &[c_int], nulls: Nulls) -> Status {
        assert_eq!(references.len(), values.len());
        let (at, from) = (nulls.or(0, references.as_ptr()), nulls.or(1, values.as_ptr()));
        // SAFETY: arrays as long as said.
        let status = unsafe { (self.c.fmi2SetInteger)(self.raw, at, values.len(), from) };
        self.answered_arrays(status, values.len(), nulls, 2)
    }

    pub(crate) fn set_boolean(&self, references: &[u32], values: &[c_int], nulls: Nulls) -> Status {
        assert_eq!(references.len(), values.len());
        let (at, from) = (nulls.or(0, references.as_ptr()), nulls.or(1, values.as_ptr()));
        // SAFETY: arrays as long as said.
        let status = unsafe { (self.c.fmi2SetBoolean)(self.raw, at, values.len(), from) };
        self.answered_arrays(status, values.len(), nulls, 2)
    }

    pub(crate) fn set_string(&self, references: &[u32], values: &[Option<&CStr>], nulls: Nulls) -> Status {
        assert_eq!(references.len(), values.len());
        let pointers: Vec<*const c_char> =
            values.iter().map(|text| text.map_or(null(), CStr::as_ptr)).collect();
        let (at, from) = (nulls.or(0, references.as_ptr()), nulls.or(1, pointers.as_ptr()));
        // SAFETY: arrays as long as said, of texts that end in a zero or NULL.
        let status = unsafe { (self.c.fmi2SetString)(self.raw, at, values.len(), from) };
        assert!(status != OK || values.iter().all(Option::is_some), "a NULL text is refused");
        self.answered_arrays(status, values.len(), nulls, 2)
    }

    pub(crate) fn set_input_derivatives(
        &self,
        references: &[u32],
        orders: &[c_int],
        values: &[f64],
        nulls: Nulls,
    ) -> Status {
        assert_eq!((references.len(), orders.len()), (values.len(), values.len()));
        let (at, orders) = (nulls.or(0, references.as_ptr()), nulls.or(1, orders.as_ptr()));
        let from = nulls.or(2, values.as_ptr());
        // SAFETY: arrays as long as said.
        let status =
            unsafe { (self.c.fmi2SetRealInputDerivatives)(self.raw, at, values.len(), orders, from) };
        self.answered_arrays(status, values.len(), nulls, 3)
    }

    /// `fmi2GetRealOutputDerivatives`, and `fmi2GetDirectionalDerivative`, which this FMU does not offer.
    pub(crate) fn get_derivatives(&self, references: &[u32], nulls: Nulls) {
        let (count, orders, seeds) =
            (references.len(), vec![1; references.len()], vec![1.0; references.len()]);
        let mut values = seeds.clone();
        let at: *const c_uint = nulls.or(0, references.as_ptr());
        let to = nulls.or_mut(1, values.as_mut_ptr());
        // SAFETY: arrays as long as said.
        let status = unsafe {
            (self.c.fmi2GetRealOutputDerivatives)(self.raw, at, count, nulls.or(2, orders.as_ptr()), to)
        };
        self.answered(status);
        // SAFETY: arrays as long as said.
        let status = unsafe {
            (self.c.fmi2GetDirectionalDerivative)(self.raw, at, count, at, count, seeds.as_ptr(), to)
        };
        assert_eq!(status, ERROR);
        self.answered(status);
        assert!(values.iter().all(|value| value.is_finite()), "{values:?}");
    }

    pub(crate) fn do_step(&self, from: f64, step: f64) -> Status {
        // SAFETY: an instance.
        self.answered(unsafe { (self.c.fmi2DoStep)(self.raw, from, step, 1) })
    }

    /// Asks one of the functions for a status.
    pub(crate) fn status(&self, of: StatusOf, kind: c_int, nulls: Nulls) -> Status {
        let (mut real, mut integer, mut text) = (0.0, 0, null());
        let whole = nulls.or_mut(0, &raw mut integer);
        // SAFETY: NULL or the places of values.
        let status = unsafe {
            match of {
                StatusOf::Status => (self.c.fmi2GetStatus)(self.raw, kind, whole),
                StatusOf::Real => (self.c.fmi2GetRealStatus)(self.raw, kind, nulls.or_mut(0, &raw mut real)),
                StatusOf::Integer => (self.c.fmi2GetIntegerStatus)(self.raw, kind, whole),
                StatusOf::Boolean => (self.c.fmi2GetBooleanStatus)(self.raw, kind, whole),
                StatusOf::String => {
                    (self.c.fmi2GetStringStatus)(self.raw, kind, nulls.or_mut(0, &raw mut text))
                }
            }
        };
        self.answered_arrays(status, 1, nulls, 1)
    }

    /// The last successful time \[s\], where FMI lets one ask for it.
    pub(crate) fn time(&self) -> Option<f64> {
        const LAST_SUCCESSFUL_TIME: c_int = 2;
        let mut time = f64::NAN;
        // SAFETY: the place of a value.
        let status = unsafe { (self.c.fmi2GetRealStatus)(self.raw, LAST_SUCCESSFUL_TIME, &mut time) };
        (self.answered(status) == Status::Ok).then_some(time)
    }

    pub(crate) fn get_state(&self, state: &mut State, nulls: Nulls) -> Status {
        // SAFETY: NULL or the place of a state pointer.
        let status = unsafe { (self.c.fmi2GetFMUstate)(self.raw, nulls.or_mut(0, &raw mut state.0)) };
        self.answered_arrays(status, 1, nulls, 1)
    }

    pub(crate) fn set_state(&self, state: &State) -> Status {
        // SAFETY: NULL or a state.
        let status = unsafe { (self.c.fmi2SetFMUstate)(self.raw, state.0) };
        assert!(status != OK || !state.is_null(), "NULL is no state");
        self.answered(status)
    }

    pub(crate) fn free_state(&self, state: &mut State, nulls: Nulls) -> Status {
        // SAFETY: NULL or the place of a state pointer.
        let status = unsafe { (self.c.fmi2FreeFMUstate)(self.raw, nulls.or_mut(0, &raw mut state.0)) };
        assert!(status != OK || nulls.at(0) || state.is_null(), "it is NULL afterwards");
        self.answered(status)
    }

    pub(crate) fn serialized_size(&self, state: &State, nulls: Nulls) -> (Status, usize) {
        let mut size = 0;
        // SAFETY: NULL or a state, NULL or the place of a number.
        let status =
            unsafe { (self.c.fmi2SerializedFMUstateSize)(self.raw, state.0, nulls.or_mut(0, &raw mut size)) };
        (self.answered_arrays(status, 1, nulls, 1), size)
    }

    /// Into a buffer of `size` bytes.
    pub(crate) fn serialize(&self, state: &State, size: usize, nulls: Nulls) -> (Status, Vec<u8>) {
        let mut bytes = vec![0; size];
        // SAFETY: NULL or a state, as many bytes as said.
        let status = unsafe {
            (self.c.fmi2SerializeFMUstate)(self.raw, state.0, nulls.or_mut(0, bytes.as_mut_ptr()), size)
        };
        (self.answered_arrays(status, size, nulls, 1), bytes)
    }

    pub(crate) fn deserialize(&self, bytes: &[u8], state: &mut State, nulls: Nulls) -> Status {
        let (from, to) = (nulls.or(0, bytes.as_ptr()), nulls.or_mut(1, &raw mut state.0));
        // SAFETY: as many bytes as said, NULL or the place of a state pointer.
        let status = unsafe { (self.c.fmi2DeSerializeFMUstate)(self.raw, from, bytes.len(), to) };
        self.answered_arrays(status, 1, nulls, 2)
    }
}
