//! An importer that calls the FMI functions with anything, within FMI's contract of memory: arrays are as
//! long as said, or NULL; states are the instance's own. Every answer is held against what all functions promise.

#![allow(unsafe_code)] // the C boundary, from the other side

use lemons_fmi2::component as c;
use lemons_fmi2::{CallbackFunctions, Model, Status};
use std::ffi::{CStr, CString, c_char, c_int, c_uint, c_void};
use std::marker::PhantomData;
use std::ptr::{null, null_mut};
use std::sync::{Mutex, OnceLock};

/// What the logger was told, of the categories that are listened to.
#[derive(Default)]
struct Log(Mutex<Vec<(Status, String)>>);

impl Log {
    fn take(&self) -> Vec<(Status, String)> {
        self.0.lock().map(|mut told| std::mem::take(&mut *told)).unwrap_or_default()
    }
}

/// The standard's logger is variadic, which stable Rust cannot define. The library passes one argument
/// after the format; by the C calling conventions of Linux on x86_64 and aarch64 it is where a callee of
/// six fixed pointers looks for it.
type Logger = unsafe extern "C" fn(*mut c_void, *const c_char, Status, *const c_char, *const c_char, ...);
type FixedLogger =
    unsafe extern "C" fn(*mut c_void, *const c_char, Status, *const c_char, *const c_char, *const c_char);

unsafe extern "C" fn log(
    environment: *mut c_void,
    _instance: *const c_char,
    status: Status,
    category: *const c_char,
    format: *const c_char,
    text: *const c_char,
) {
    // SAFETY: the library gives back the environment that it was given, and texts that end in a zero.
    let (log, category, format, text) = unsafe {
        (&*environment.cast::<Log>(), CStr::from_ptr(category), CStr::from_ptr(format), CStr::from_ptr(text))
    };
    assert_eq!(format, c"%s");
    assert!(category.to_bytes().starts_with(b"log"), "{category:?}");
    let text = text.to_str().expect("messages are UTF-8").to_owned();
    assert!(!text.is_empty(), "a message says something");
    if let Ok(mut told) = log.0.lock() {
        told.push((status, text));
    }
}

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

    fn at(self, place: u8) -> bool {
        self.0 & 0xe0 == 0xe0 && self.0 >> place & 1 == 1
    }

    fn any(self, places: u8) -> bool {
        (0..places).any(|place| self.at(place))
    }

    fn or<T>(self, place: u8, pointer: *const T) -> *const T {
        if self.at(place) { null() } else { pointer }
    }

    fn or_mut<T>(self, place: u8, pointer: *mut T) -> *mut T {
        if self.at(place) { null_mut() } else { pointer }
    }
}

/// A pointer of `fmi2GetFMUstate`, perhaps still NULL.
pub(crate) struct State(*mut c_void);

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
    log: Box<Log>,
    /// Whether refusals and discards are told, as the last `fmi2SetDebugLogging` wanted it.
    hears: [bool; 2],
    model: PhantomData<M>,
}

impl<M: Model> Drop for Importer<M> {
    fn drop(&mut self) {
        // SAFETY: given back once.
        unsafe { c::free_instance::<M>(self.raw) }
    }
}

impl<M: Model> Importer<M> {
    /// `fmi2Instantiate`, or `None` after a message.
    pub(crate) fn new(
        [name, guid, uri]: [Option<&CStr>; 3],
        fmu_type: c_int,
        logging_on: c_int,
    ) -> Option<Importer<M>> {
        let log = Box::<Log>::default();
        // SAFETY: see `FixedLogger`.
        let logger = unsafe { std::mem::transmute::<FixedLogger, Logger>(self::log) };
        let callbacks = CallbackFunctions {
            logger: Some(logger),
            allocate_memory: null(),
            free_memory: null(),
            step_finished: null(),
            component_environment: std::ptr::from_ref(&*log).cast_mut().cast(),
        };
        let pointer = |text: Option<&CStr>| text.map_or(null(), CStr::as_ptr);
        // SAFETY: texts that end in a zero, or NULL.
        let raw = unsafe {
            c::instantiate::<M>(
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
            assert!(told.iter().any(|(status, _)| *status == Status::Error), "told why: {told:?}");
            assert!(told.iter().all(|(status, _)| *status != Status::Fatal), "{told:?}");
            return None;
        }
        log.take();
        Some(Importer { raw, log, hears: [true; 2], model: PhantomData })
    }

    /// What every answer promises.
    fn answered(&self, status: Status) -> Status {
        let told = self.log.take();
        if telling() && !told.is_empty() {
            eprintln!("    {told:?}");
        }
        let tells = |wanted| told.iter().any(|(status, _)| *status == wanted);
        assert!(!matches!(status, Status::Fatal | Status::Pending), "{status:?}: {told:?}");
        assert!(status != Status::Error || tells(status) || !self.hears[0], "an error without a word");
        assert!(status != Status::Discard || tells(status) || !self.hears[1], "a discard without a word");
        assert!(status != Status::Ok || !tells(Status::Error), "an error told, but answered Ok: {told:?}");
        assert!(!tells(Status::Fatal), "{told:?}");
        status
    }

    /// As [`Importer::answered`], of a call on `count` elements some of whose `places` arrays may be NULL.
    fn answered_arrays(&self, status: Status, count: usize, nulls: Nulls, places: u8) -> Status {
        assert!(status != Status::Ok || count == 0 || !nulls.any(places), "NULL is refused");
        self.answered(status)
    }

    pub(crate) fn plain(&self, function: Plain) -> Status {
        // SAFETY: an instance.
        self.answered(unsafe {
            match function {
                Plain::EnterInitializationMode => c::enter_initialization_mode::<M>(self.raw),
                Plain::ExitInitializationMode => c::exit_initialization_mode::<M>(self.raw),
                Plain::Terminate => c::terminate::<M>(self.raw),
                Plain::Reset => c::reset::<M>(self.raw),
                Plain::CancelStep => c::cancel_step::<M>(self.raw),
            }
        })
    }

    pub(crate) fn debug_logging(&mut self, on: bool, categories: &[Option<&CStr>], nulls: Nulls) -> Status {
        let pointers: Vec<*const c_char> =
            categories.iter().map(|text| text.map_or(null(), CStr::as_ptr)).collect();
        let count = pointers.len();
        // SAFETY: as many texts as said.
        let status =
            unsafe { c::set_debug_logging::<M>(self.raw, on.into(), count, nulls.or(0, pointers.as_ptr())) };
        let has = |wanted| categories.contains(&Some(wanted)) || categories.contains(&Some(c"logAll"));
        if status == Status::Ok {
            let all = !on || categories.is_empty();
            self.hears = [all || has(c"logStatusError"), all || has(c"logStatusWarning")];
        }
        self.answered_arrays(status, count, nulls, 1)
    }

    pub(crate) fn setup_experiment(&self, tolerance: f64, start: f64, stop: Option<f64>) -> Status {
        // SAFETY: an instance.
        self.answered(unsafe {
            let (defined, stop) = (stop.is_some().into(), stop.unwrap_or(f64::NAN));
            c::setup_experiment::<M>(self.raw, 1, tolerance, start, defined, stop)
        })
    }

    pub(crate) fn get_real(&self, references: &[u32], nulls: Nulls) -> (Status, Vec<f64>) {
        let (count, mut values) = (references.len(), vec![f64::NAN; references.len()]);
        let (at, to) = (nulls.or(0, references.as_ptr()), nulls.or_mut(1, values.as_mut_ptr()));
        // SAFETY: arrays as long as said.
        let status = unsafe { c::get_real::<M>(self.raw, at, count, to) };
        (self.answered_arrays(status, count, nulls, 2), values)
    }

    pub(crate) fn get_integer(&self, references: &[u32], nulls: Nulls) -> (Status, Vec<c_int>) {
        let (count, mut values) = (references.len(), vec![0; references.len()]);
        let (at, to) = (nulls.or(0, references.as_ptr()), nulls.or_mut(1, values.as_mut_ptr()));
        // SAFETY: arrays as long as said.
        let status = unsafe { c::get_integer::<M>(self.raw, at, count, to) };
        (self.answered_arrays(status, count, nulls, 2), values)
    }

    pub(crate) fn get_boolean(&self, references: &[u32], nulls: Nulls) -> Status {
        let (count, mut values) = (references.len(), vec![0; references.len()]);
        let (at, to) = (nulls.or(0, references.as_ptr()), nulls.or_mut(1, values.as_mut_ptr()));
        // SAFETY: arrays as long as said.
        let status = unsafe { c::get_boolean::<M>(self.raw, at, count, to) };
        self.answered_arrays(status, count, nulls, 2)
    }

    /// The texts are read, and those of the last call are gone.
    pub(crate) fn get_string(&self, references: &[u32], nulls: Nulls) -> (Status, Vec<CString>) {
        let (count, mut values) = (references.len(), vec![null(); references.len()]);
        let (at, to) = (nulls.or(0, references.as_ptr()), nulls.or_mut(1, values.as_mut_ptr()));
        // SAFETY: arrays as long as said.
        let status = unsafe { c::get_string::<M>(self.raw, at, count, to) };
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
        let status = unsafe { c::set_real::<M>(self.raw, at, values.len(), from) };
        self.answered_arrays(status, values.len(), nulls, 2)
    }

    pub(crate) fn set_integer(&self, references: &[u32], values: &[c_int], nulls: Nulls) -> Status {
        assert_eq!(references.len(), values.len());
        let (at, from) = (nulls.or(0, references.as_ptr()), nulls.or(1, values.as_ptr()));
        // SAFETY: arrays as long as said.
        let status = unsafe { c::set_integer::<M>(self.raw, at, values.len(), from) };
        self.answered_arrays(status, values.len(), nulls, 2)
    }

    pub(crate) fn set_boolean(&self, references: &[u32], values: &[c_int], nulls: Nulls) -> Status {
        assert_eq!(references.len(), values.len());
        let (at, from) = (nulls.or(0, references.as_ptr()), nulls.or(1, values.as_ptr()));
        // SAFETY: arrays as long as said.
        let status = unsafe { c::set_boolean::<M>(self.raw, at, values.len(), from) };
        self.answered_arrays(status, values.len(), nulls, 2)
    }

    pub(crate) fn set_string(&self, references: &[u32], values: &[Option<&CStr>], nulls: Nulls) -> Status {
        assert_eq!(references.len(), values.len());
        let pointers: Vec<*const c_char> =
            values.iter().map(|text| text.map_or(null(), CStr::as_ptr)).collect();
        let (at, from) = (nulls.or(0, references.as_ptr()), nulls.or(1, pointers.as_ptr()));
        // SAFETY: arrays as long as said, of texts that end in a zero or NULL.
        let status = unsafe { c::set_string::<M>(self.raw, at, values.len(), from) };
        assert!(status != Status::Ok || values.iter().all(Option::is_some), "a NULL text is refused");
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
        let status = unsafe { c::set_real_input_derivatives::<M>(self.raw, at, values.len(), orders, from) };
        self.answered_arrays(status, values.len(), nulls, 3)
    }

    /// `fmi2GetRealOutputDerivatives` and `fmi2GetDirectionalDerivative`, which this FMU does not offer.
    pub(crate) fn get_derivatives(&self, references: &[u32], nulls: Nulls) {
        let (count, orders, seeds) =
            (references.len(), vec![1; references.len()], vec![1.0; references.len()]);
        let mut values = seeds.clone();
        let at: *const c_uint = nulls.or(0, references.as_ptr());
        let to = nulls.or_mut(1, values.as_mut_ptr());
        // SAFETY: arrays as long as said.
        let answers = unsafe {
            [
                c::get_real_output_derivatives::<M>(self.raw, at, count, nulls.or(2, orders.as_ptr()), to),
                c::get_directional_derivative::<M>(self.raw, at, count, at, count, seeds.as_ptr(), to),
            ]
        };
        for status in answers {
            assert_eq!(status, Status::Error);
        }
        self.answered(Status::Error);
    }

    pub(crate) fn do_step(&self, from: f64, step: f64) -> Status {
        // SAFETY: an instance.
        self.answered(unsafe { c::do_step::<M>(self.raw, from, step, 1) })
    }

    /// Asks one of the functions for a status.
    pub(crate) fn status(&self, of: StatusOf, kind: c_int, nulls: Nulls) -> Status {
        let (mut real, mut integer, mut text) = (0.0, 0, null());
        let whole = nulls.or_mut(0, &raw mut integer);
        // SAFETY: NULL or the places of values.
        let status = unsafe {
            match of {
                StatusOf::Status => c::get_status::<M>(self.raw, kind, whole),
                StatusOf::Real => c::get_real_status::<M>(self.raw, kind, nulls.or_mut(0, &raw mut real)),
                StatusOf::Integer => c::get_integer_status::<M>(self.raw, kind, whole),
                StatusOf::Boolean => c::get_boolean_status::<M>(self.raw, kind, whole),
                StatusOf::String => c::get_string_status::<M>(self.raw, kind, nulls.or_mut(0, &raw mut text)),
            }
        };
        self.answered_arrays(status, 1, nulls, 1)
    }

    /// The last successful time \[s\], where FMI lets one ask for it.
    pub(crate) fn time(&self) -> Option<f64> {
        const LAST_SUCCESSFUL_TIME: c_int = 2;
        let mut time = f64::NAN;
        // SAFETY: the place of a value.
        let status = unsafe { c::get_real_status::<M>(self.raw, LAST_SUCCESSFUL_TIME, &mut time) };
        (self.answered(status) == Status::Ok).then_some(time)
    }

    pub(crate) fn get_state(&self, state: &mut State, nulls: Nulls) -> Status {
        // SAFETY: NULL or the place of a state pointer.
        let status = unsafe { c::get_fmu_state::<M>(self.raw, nulls.or_mut(0, &raw mut state.0)) };
        self.answered_arrays(status, 1, nulls, 1)
    }

    pub(crate) fn set_state(&self, state: &State) -> Status {
        // SAFETY: NULL or a state.
        let status = unsafe { c::set_fmu_state::<M>(self.raw, state.0) };
        assert!(status != Status::Ok || !state.is_null(), "NULL is no state");
        self.answered(status)
    }

    pub(crate) fn free_state(&self, state: &mut State, nulls: Nulls) -> Status {
        // SAFETY: NULL or the place of a state pointer.
        let status = unsafe { c::free_fmu_state::<M>(self.raw, nulls.or_mut(0, &raw mut state.0)) };
        assert!(status != Status::Ok || nulls.at(0) || state.is_null(), "it is NULL afterwards");
        self.answered(status)
    }

    pub(crate) fn serialized_size(&self, state: &State, nulls: Nulls) -> (Status, usize) {
        let mut size = 0;
        // SAFETY: NULL or a state, NULL or the place of a number.
        let status =
            unsafe { c::serialized_fmu_state_size::<M>(self.raw, state.0, nulls.or_mut(0, &raw mut size)) };
        (self.answered_arrays(status, 1, nulls, 1), size)
    }

    /// Into a buffer of `size` bytes.
    pub(crate) fn serialize(&self, state: &State, size: usize, nulls: Nulls) -> (Status, Vec<u8>) {
        let mut bytes = vec![0; size];
        // SAFETY: NULL or a state, as many bytes as said.
        let status = unsafe {
            c::serialize_fmu_state::<M>(self.raw, state.0, nulls.or_mut(0, bytes.as_mut_ptr()), size)
        };
        (self.answered_arrays(status, size, nulls, 1), bytes)
    }

    pub(crate) fn deserialize(&self, bytes: &[u8], state: &mut State, nulls: Nulls) -> Status {
        let (from, to) = (nulls.or(0, bytes.as_ptr()), nulls.or_mut(1, &raw mut state.0));
        // SAFETY: as many bytes as said, NULL or the place of a state pointer.
        let status = unsafe { c::deserialize_fmu_state::<M>(self.raw, from, bytes.len(), to) };
        self.answered_arrays(status, 1, nulls, 2)
    }
}
