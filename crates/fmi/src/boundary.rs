//! What the C functions of every version of FMI have in common: pointers are checked, no panic and no error leaves them.

#![allow(unsafe_code)] // the C boundary

use crate::model::Model;
use crate::slave::{Slave, SlaveError, Snapshot};
use crate::states::{self, Unknown};
use std::ffi::{CStr, CString, c_char, c_void};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;

/// `fmi2Status`; without `Pending`, `fmi3Status`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(missing_docs)] // FMI's own names
pub enum Status {
    Ok = 0,
    Warning = 1,
    Discard = 2,
    Error = 3,
    Fatal = 4,
    Pending = 5,
}

/// The categories of log messages, with their descriptions.
pub const LOG_CATEGORIES: [(&str, &str); 4] = [
    ("logStatusWarning", "what may be a mistake"),
    ("logStatusError", "why a call was refused or failed"),
    ("logStatusFatal", "a fault of the FMU itself"),
    ("logAll", "everything"),
];

/// `fmi2CallbackLogger`
pub type Logger2 =
    unsafe extern "C" fn(*mut c_void, *const c_char, Status, *const c_char, *const c_char, ...);
/// `fmi3LogMessageCallback`
pub type Logger3 = unsafe extern "C" fn(*mut c_void, Status, *const c_char, *const c_char);

/// The importer's function for messages.
#[derive(Clone, Copy)]
pub(crate) enum Logger {
    V2(Option<Logger2>),
    V3(Option<Logger3>),
}

pub(crate) const WARNING: usize = 0;
pub(crate) const ERROR: usize = 1;
pub(crate) const FATAL: usize = 2;
pub(crate) const ALL: usize = 3;

/// The importer's logger, and which categories it wants.
pub(crate) struct Log {
    pub logger: Logger,
    pub environment: *mut c_void,
    pub instance_name: CString,
    /// One for each of [`LOG_CATEGORIES`].
    pub wanted: [bool; 4],
}

impl Log {
    /// Why calls were refused is always told; `loggingOn` is about the rest.
    pub fn wanted(logging_on: bool) -> [bool; 4] {
        [logging_on, true, true, logging_on]
    }

    pub fn write(&self, status: Status, category: usize, message: &str) {
        if !(self.wanted[category] || self.wanted[ALL]) {
            return;
        }
        // Zeros inside would end the text early.
        let message = message.replace('\0', " ");
        let category = CString::new(LOG_CATEGORIES[category].0).unwrap_or_default();
        match self.logger {
            Logger::V2(Some(logger)) => {
                // Importers replace `#r6#` by the name of a variable (FMI 2.0.5, section 2.1.5).
                let text = CString::new(message.replace('#', "##")).unwrap_or_default();
                // SAFETY: the importer's logger, called as FMI says; the message goes through "%s", so that percent signs
                // in it are themselves.
                unsafe {
                    logger(
                        self.environment,
                        self.instance_name.as_ptr(),
                        status,
                        category.as_ptr(),
                        c"%s".as_ptr(),
                        text.as_ptr(),
                    );
                }
            }
            Logger::V3(Some(logger)) => {
                let text = CString::new(message).unwrap_or_default();
                // SAFETY: the importer's logger, called as FMI says.
                unsafe { logger(self.environment, status, category.as_ptr(), text.as_ptr()) };
            }
            Logger::V2(None) | Logger::V3(None) => {}
        }
    }
}

/// The object behind an instance.
pub(crate) struct Component<M: Model> {
    pub slave: Slave<M>,
    pub log: Log,
    /// Keeps the texts of the last call that returned some alive.
    pub strings: Vec<CString>,
    /// A panic happened: the instance may be in any condition.
    broken: bool,
}

impl<M: Model> Component<M> {
    pub fn new(slave: Slave<M>, log: Log) -> Component<M> {
        let mut component = Component { slave, log, strings: Vec::new(), broken: false };
        component.tell_warnings();
        component
    }

    pub fn tell_warnings(&mut self) {
        for warning in self.slave.take_warnings() {
            self.log.write(Status::Warning, WARNING, &warning);
        }
    }

    /// The snapshot behind a state of the importer.
    pub fn state(&self, state: *mut c_void) -> Result<Arc<Snapshot<M::Saved>>, Refusal<M>> {
        if state.is_null() {
            return Err(Refusal::Null("FMUstate"));
        }
        Ok(states::get(state)?)
    }
}

/// Why a call is refused or fails.
pub(crate) enum Refusal<M: Model> {
    Slave(SlaveError<M::Error>),
    Null(&'static str),
    NotUtf8(&'static str),
    Category(String),
    BufferSize {
        given: usize,
        needed: usize,
    },
    /// A pointer that is not that of a state.
    UnknownState,
    /// The call is allowed, but there is no result.
    Discard(&'static str),
}

impl<M: Model> From<SlaveError<M::Error>> for Refusal<M> {
    fn from(error: SlaveError<M::Error>) -> Self {
        Refusal::Slave(error)
    }
}

impl<M: Model> From<Unknown> for Refusal<M> {
    fn from(Unknown: Unknown) -> Self {
        Refusal::UnknownState
    }
}

/// An argument that cannot be what FMI says it is.
pub(crate) enum Bad {
    Null(&'static str),
    NotUtf8(&'static str),
}

impl<M: Model> From<Bad> for Refusal<M> {
    fn from(bad: Bad) -> Self {
        match bad {
            Bad::Null(what) => Refusal::Null(what),
            Bad::NotUtf8(what) => Refusal::NotUtf8(what),
        }
    }
}

impl<M: Model> std::fmt::Display for Refusal<M> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Refusal::Slave(error) => write!(f, "{error}"),
            Refusal::Null(what) => write!(f, "{what} is NULL"),
            Refusal::NotUtf8(what) => write!(f, "{what} is not UTF-8 text"),
            Refusal::Category(name) => {
                let known: Vec<&str> = LOG_CATEGORIES.iter().map(|(name, _)| *name).collect();
                write!(f, "no log category {name:?}; there are {}", known.join(", "))
            }
            Refusal::BufferSize { given, needed } => {
                write!(f, "the buffer has {given} bytes, but the state needs {needed}")
            }
            Refusal::UnknownState => f.write_str("FMUstate is not a state of this instance, or it was freed"),
            Refusal::Discard(why) => f.write_str(why),
        }
    }
}

/// Removes the panic hook, so that this library prints nothing in its host. The hook has no state, so nothing is left
/// when the library is unloaded.
pub fn silence_panics() {
    static ONCE: std::sync::Once = std::sync::Once::new();
    ONCE.call_once(|| std::panic::set_hook(Box::new(|_| {})));
}

/// The callback within a step of FMI 3.0: `fmi3IntermediateUpdateCallback`.
pub type IntermediateUpdate =
    unsafe extern "C" fn(*mut c_void, f64, bool, bool, bool, bool, *mut bool, *mut f64);

/// The importer's callback within a step.
#[derive(Clone, Copy)]
pub(crate) struct Intermediate {
    pub update: Option<IntermediateUpdate>,
    pub environment: *mut c_void,
    pub early_return_allowed: bool,
}

/// The object behind an `fmi2Component` or `fmi3Instance`. The callback lies beside what calls borrow, because the
/// importer calls functions of the instance while the callback runs.
pub(crate) struct Instance<M: Model> {
    component: *mut Component<M>,
    pub intermediate: Option<Intermediate>,
}

impl<M: Model> Instance<M> {
    /// Returns an instance that the importer holds; `None` of NULL.
    pub fn of<'a>(instance: *mut c_void) -> Option<&'a Instance<M>> {
        // SAFETY: NULL or an instance of ours by the contract of the C functions.
        unsafe { instance.cast::<Instance<M>>().as_ref() }
    }
}

/// Runs a call on an instance. No panic and no error leaves it.
pub(crate) fn call<M: Model>(
    instance: *mut c_void,
    name: &str,
    body: impl FnOnce(&mut Component<M>) -> Result<(), Refusal<M>>,
) -> Status {
    // SAFETY: the component of an instance lives as long as it, and no other call borrows it.
    let component = Instance::<M>::of(instance).and_then(|it| unsafe { it.component.as_mut() });
    let Some(component) = component else { return Status::Error };
    if component.broken {
        component.log.write(Status::Fatal, FATAL, &format!("{name}: the instance broke in an earlier call"));
        return Status::Fatal;
    }
    match catch_unwind(AssertUnwindSafe(|| body(component))) {
        Ok(Ok(())) => Status::Ok,
        Ok(Err(refusal)) => {
            let status = if matches!(refusal, Refusal::Discard(_)) { Status::Discard } else { Status::Error };
            let category = if status == Status::Discard { WARNING } else { ERROR };
            component.log.write(status, category, &format!("{name}: {refusal}"));
            status
        }
        Err(panic) => {
            component.broken = true;
            component.log.write(Status::Fatal, FATAL, &format!("{name}: {}", panic_message(&*panic)));
            Status::Fatal
        }
    }
}

/// Makes an instance; NULL, after a message, if that fails.
pub(crate) fn make<M: Model>(
    log: Log,
    intermediate: Option<Intermediate>,
    name: &str,
    body: impl FnOnce() -> Result<Slave<M>, Refusal<M>>,
) -> *mut c_void {
    match catch_unwind(AssertUnwindSafe(body)) {
        Ok(Ok(slave)) => {
            let component = Box::into_raw(Box::new(Component::new(slave, log)));
            return Box::into_raw(Box::new(Instance { component, intermediate })).cast();
        }
        Ok(Err(refusal)) => log.write(Status::Error, ERROR, &format!("{name}: {refusal}")),
        Err(panic) => log.write(Status::Fatal, FATAL, &format!("{name}: {}", panic_message(&*panic))),
    }
    std::ptr::null_mut()
}

/// Frees an instance.
///
/// # Safety
/// `instance` is NULL or one that [`make`] returned, given back once.
pub(crate) unsafe fn free<M: Model>(instance: *mut c_void) {
    if !instance.is_null() {
        // SAFETY: as the caller promises.
        let component = unsafe { Box::from_raw(Box::from_raw(instance.cast::<Instance<M>>()).component) };
        let _ = catch_unwind(AssertUnwindSafe(|| drop(component)));
    }
}

fn panic_message(panic: &(dyn std::any::Any + Send)) -> String {
    let text = panic.downcast_ref::<&str>().copied().or(panic.downcast_ref::<String>().map(String::as_str));
    format!("a fault of the FMU itself: {}", text.unwrap_or("no message"))
}

/// An array that belongs to the importer.
///
/// # Safety
/// `pointer` is NULL or leads to `length` elements that live through the call.
pub(crate) unsafe fn array<'a, T>(
    pointer: *const T,
    length: usize,
    what: &'static str,
) -> Result<&'a [T], Bad> {
    match (pointer.is_null(), length) {
        (_, 0) => Ok(&[]),
        (true, _) => Err(Bad::Null(what)),
        // SAFETY: as the caller promises.
        (false, _) => Ok(unsafe { std::slice::from_raw_parts(pointer, length) }),
    }
}

/// An array of the importer's that is written to.
///
/// # Safety
/// As [`array`], and no other code uses the elements during the call.
pub(crate) unsafe fn array_mut<'a, T>(
    pointer: *mut T,
    length: usize,
    what: &'static str,
) -> Result<&'a mut [T], Bad> {
    match (pointer.is_null(), length) {
        (_, 0) => Ok(&mut []),
        (true, _) => Err(Bad::Null(what)),
        // SAFETY: as the caller promises.
        (false, _) => Ok(unsafe { std::slice::from_raw_parts_mut(pointer, length) }),
    }
}

/// A text that belongs to the importer.
///
/// # Safety
/// `pointer` is NULL or leads to a text that ends in a zero and lives through the call.
pub(crate) unsafe fn text<'a>(pointer: *const c_char, what: &'static str) -> Result<&'a str, Bad> {
    if pointer.is_null() {
        return Err(Bad::Null(what));
    }
    // SAFETY: as the caller promises.
    unsafe { CStr::from_ptr(pointer) }.to_str().map_err(|_| Bad::NotUtf8(what))
}

/// The texts of an array of the importer's.
///
/// # Safety
/// As [`array`] and [`text`].
pub(crate) unsafe fn texts<'a>(
    pointer: *const *const c_char,
    length: usize,
    what: &'static str,
) -> Result<Vec<&'a str>, Bad> {
    // SAFETY: as the caller promises.
    unsafe { array(pointer, length, what)?.iter().map(|&value| text(value, what)).collect() }
}

impl<M: Model> Component<M> {
    /// The body of `fmi2SetDebugLogging` and `fmi3SetDebugLogging`.
    pub fn set_debug_logging(&mut self, on: bool, categories: &[&str]) -> Result<(), Refusal<M>> {
        let mut wanted = [false; 4];
        for name in categories {
            let place = LOG_CATEGORIES.iter().position(|(known, _)| known == name);
            wanted[place.ok_or_else(|| Refusal::Category((*name).to_owned()))?] = true;
        }
        self.log.wanted = match (on, categories.is_empty()) {
            (false, _) => Log::wanted(false),
            (true, true) => [true; 4],
            (true, false) => wanted,
        };
        Ok(())
    }

    /// Gives the importer texts that live until the next call of this kind.
    pub fn give_texts(&mut self, texts: Vec<String>, values: &mut [*const c_char]) {
        self.strings = texts.into_iter().map(|text| CString::new(text).unwrap_or_default()).collect();
        for (value, text) in values.iter_mut().zip(&self.strings) {
            *value = text.as_ptr();
        }
    }

    /// Writes a state to a buffer of the importer's.
    pub fn serialize(&self, state: *mut c_void, buffer: &mut [u8]) -> Result<(), Refusal<M>> {
        let bytes = self.slave.serialize(&*self.state(state)?)?;
        let (given, needed) = (buffer.len(), bytes.len());
        buffer.get_mut(..needed).ok_or(Refusal::BufferSize { given, needed })?.copy_from_slice(&bytes);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn panics_have_messages() {
        let panic = catch_unwind(|| panic!("broken {}", 1)).unwrap_err();
        assert_eq!(panic_message(&*panic), "a fault of the FMU itself: broken 1");
    }
}
