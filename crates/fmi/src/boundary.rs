//! Common parts of the C functions of every version of FMI: pointers are checked, no panic and no error leaves them.

#![allow(unsafe_code)] // the C boundary

use crate::Version;
use crate::answer::{Answer, Refusal, Status, refuse};
use crate::location::Location;
use crate::model::Model;
use crate::slave::Slave;
use lemons_core::files::words::shortened;
use std::ffi::{CStr, CString, c_char, c_void};
use std::panic::{AssertUnwindSafe, catch_unwind};

/// The categories of log messages, with their descriptions.
pub const LOG_CATEGORIES: [(&str, &str); 4] = [
    ("logStatusWarning", "what may be a mistake"),
    ("logStatusError", "why a call was refused or failed"),
    ("logStatusFatal", "a fault of the FMU itself"),
    ("logAll", "everything"),
];
const ALL: usize = 3;

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
    Component(LoggerOfComponent),
}

/// The function for messages of a component: the instance's name, status, category, message.
pub type LoggerOfComponent = fn(&str, Status, &str, &str);

/// The importer's logger, and which categories it wants.
pub struct Log {
    logger: Logger,
    environment: *mut c_void,
    instance_name: CString,
    /// One for each of [`LOG_CATEGORIES`].
    wanted: [bool; 4],
}

impl Log {
    pub(crate) fn new(logger: Logger, environment: *mut c_void, logging_on: bool) -> Log {
        Log { logger, environment, instance_name: CString::default(), wanted: Log::wanted(logging_on) }
    }

    /// Makes the log of a component's instance.
    pub fn of_component(logger: LoggerOfComponent, instance_name: &str, logging_on: bool) -> Log {
        let log = Log::new(Logger::Component(logger), std::ptr::null_mut(), logging_on);
        Log { instance_name: CString::new(instance_name).unwrap_or_default(), ..log }
    }

    /// Chooses the categories that are wanted: all if none is named.
    ///
    /// # Errors
    /// A name is not that of a category. Then nothing has changed.
    pub fn choose(&mut self, on: bool, categories: &[&str]) -> Answer<()> {
        let mut wanted = [categories.is_empty(); 4];
        for name in categories {
            let Some(place) = LOG_CATEGORIES.iter().position(|(known, _)| known == name) else {
                let known = LOG_CATEGORIES.map(|(name, _)| name).join(", ");
                return refuse(format!("no log category {name:?}; there are {known}"));
            };
            wanted[place] = true;
        }
        self.wanted = if on { wanted } else { Log::wanted(false) };
        Ok(())
    }

    /// Why calls were refused is always told; `loggingOn` is about the rest.
    fn wanted(logging_on: bool) -> [bool; 4] {
        [logging_on, true, true, logging_on]
    }

    /// Writes a message if its category is wanted.
    pub fn write(&self, status: Status, message: &str) {
        let category = match (status, self.logger) {
            (Status::Fatal, _) => 2,
            (Status::Error | Status::Discard, _) => 1,
            _ => 0,
        };
        if !(self.wanted[category] || self.wanted[ALL]) {
            return;
        }
        // Zeros inside would end the text early. Importers replace `#r6#` by the name of a variable, in FMI 3.0 `#6#`
        // (FMI 2.0.5, section 2.1.5; FMI 3.0, section 2.3.1).
        let message = shortened(message).replace('\0', " ").replace('#', "##");
        if let Logger::Component(logger) = self.logger {
            let instance_name = self.instance_name.to_str().unwrap_or_default();
            return logger(instance_name, status, LOG_CATEGORIES[category].0, &message);
        }
        let category = CString::new(LOG_CATEGORIES[category].0).unwrap_or_default();
        match self.logger {
            Logger::V2(Some(logger)) => {
                let text = CString::new(message).unwrap_or_default();
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
            Logger::V2(None) | Logger::V3(None) | Logger::Component(_) => {}
        }
    }
}

/// An instance as the C functions see it: importers hold a pointer to it.
pub struct Component<M: Model> {
    pub(crate) slave: Slave<M>,
    pub(crate) log: Log,
    /// Keeps the texts of the last call that returned some alive.
    pub(crate) strings: Vec<CString>,
    /// The function that runs.
    pub(crate) function: &'static str,
    /// A panic happened: the instance may be in any condition.
    broken: bool,
}

impl<M: Model> Component<M> {
    fn tell_warnings(&mut self) {
        for warning in self.slave.take_warnings() {
            self.log.write(Status::Warning, &warning);
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
    ///
    /// # Safety
    /// `instance` is NULL or one that [`make`] returned and that lives.
    pub unsafe fn of<'a>(instance: *mut c_void) -> Option<&'a Instance<M>> {
        // SAFETY: as the caller promises.
        unsafe { instance.cast::<Instance<M>>().as_ref() }
    }
}

/// Runs a call on an instance, and tells its warnings. No panic and no error leaves it.
///
/// # Safety
/// `instance` is NULL or one that `make` returned and that lives; no other call on it runs.
pub unsafe fn call<M: Model>(
    instance: *mut c_void,
    name: &'static str,
    body: impl FnOnce(&mut Component<M>) -> Answer<()>,
) -> Status {
    // SAFETY: the component of an instance lives as long as it, and no other call borrows it.
    let component = unsafe { Instance::<M>::of(instance).and_then(|it| it.component.as_mut()) };
    let Some(component) = component else { return Status::Error };
    let told = if component.broken {
        Refusal { status: Status::Fatal, message: "the instance broke in an earlier call".to_owned() }
    } else {
        component.function = name;
        match catch_unwind(AssertUnwindSafe(|| body(component))) {
            Ok(Ok(())) => {
                component.tell_warnings();
                return Status::Ok;
            }
            Ok(Err(refusal)) => refusal,
            Err(panic) => {
                component.broken = true;
                fault(&*panic)
            }
        }
    };
    component.log.write(told.status, &format!("{name}: {told}"));
    told.status
}

/// The arguments that make an instance.
pub(crate) struct Arguments {
    pub version: Version,
    pub log: Log,
    pub intermediate: Option<Intermediate>,
    /// A capability that the importer asks for and that does not exist here.
    pub unsupported: Option<&'static str>,
    pub instance_name: *const c_char,
    pub token: *const c_char,
    pub location: *const c_char,
}

/// Makes an instance: NULL, after a message, when that fails.
///
/// # Safety
/// The texts are NULL or end with a zero.
pub(crate) unsafe fn make<M: Model>(name: &str, arguments: Arguments) -> *mut c_void {
    let Arguments { version, mut log, intermediate, unsupported, .. } = arguments;
    // SAFETY: as the caller promises; the same below.
    let instance_name = unsafe { text(arguments.instance_name, "instanceName") };
    log.instance_name = CString::new(instance_name.as_ref().map_or("", |name| *name)).unwrap_or_default();
    let slave = || {
        if instance_name?.trim().is_empty() {
            return refuse("instanceName is empty or blank");
        }
        if let Some(why) = unsupported {
            return refuse(why);
        }
        let (of_token, of_location, location) = match version {
            Version::V2 => ("fmuGUID", "fmuResourceLocation", Location::Uri as fn(_) -> _),
            Version::V3 => ("instantiationToken", "resourcePath", Location::Path as fn(_) -> _),
        };
        let token = unsafe { text(arguments.token, of_token)? };
        Slave::new(M::load(location(unsafe { text(arguments.location, of_location)? }))?, version, token)
    };
    let told = match catch_unwind(AssertUnwindSafe(slave)) {
        Ok(Ok(slave)) => {
            let mut component = Component { slave, log, strings: Vec::new(), function: "", broken: false };
            component.tell_warnings();
            let component = Box::into_raw(Box::new(component));
            return Box::into_raw(Box::new(Instance { component, intermediate })).cast();
        }
        Ok(Err(refusal)) => refusal,
        Err(panic) => fault(&*panic),
    };
    log.write(told.status, &format!("{name}: {told}"));
    std::ptr::null_mut()
}

/// Frees an instance.
///
/// # Safety
/// `instance` is NULL or one that was made, given back once.
pub unsafe fn free<M: Model>(_: &str, instance: *mut c_void) {
    if !instance.is_null() {
        // SAFETY: as the caller promises.
        let component = unsafe { Box::from_raw(Box::from_raw(instance.cast::<Instance<M>>()).component) };
        let _ = catch_unwind(AssertUnwindSafe(|| drop(component)));
    }
}

fn fault(panic: &(dyn std::any::Any + Send)) -> Refusal {
    let text = panic.downcast_ref::<&str>().copied().or(panic.downcast_ref::<String>().map(String::as_str));
    let message = format!("a fault of the FMU itself: {}", text.unwrap_or("no message"));
    Refusal { status: Status::Fatal, message }
}

/// A pointer of the importer's, and how many elements it leads to.
pub type InArray<T> = (*const T, usize);
/// The same, of elements that are written to.
pub type OutArray<T> = (*mut T, usize);

/// An array that belongs to the importer.
///
/// # Safety
/// The pointer is NULL or leads to as many elements as said, which live through the call.
pub(crate) unsafe fn array<'a, T>((pointer, length): InArray<T>, what: &str) -> Answer<&'a [T]> {
    match (pointer.is_null(), length) {
        (_, 0) => Ok(&[]),
        (true, _) => refuse(format!("{what} is NULL")),
        // SAFETY: as the caller promises.
        (false, _) => Ok(unsafe { std::slice::from_raw_parts(pointer, length) }),
    }
}

/// An array of the importer's that is written to.
///
/// # Safety
/// As [`array`], and no other code uses the elements during the call.
pub(crate) unsafe fn array_mut<'a, T>((pointer, length): OutArray<T>, what: &str) -> Answer<&'a mut [T]> {
    match (pointer.is_null(), length) {
        (_, 0) => Ok(&mut []),
        (true, _) => refuse(format!("{what} is NULL")),
        // SAFETY: as the caller promises.
        (false, _) => Ok(unsafe { std::slice::from_raw_parts_mut(pointer, length) }),
    }
}

/// The place of a value of the importer's.
///
/// # Safety
/// As [`array_mut`] of one element.
pub(crate) unsafe fn place<'a, T>(pointer: *mut T, what: &str) -> Answer<&'a mut T> {
    // SAFETY: as the caller promises.
    unsafe { pointer.as_mut() }.map_or_else(|| refuse(format!("{what} is NULL")), Ok)
}

/// A text that belongs to the importer.
///
/// # Safety
/// `pointer` is NULL or leads to a text that ends in a zero and lives through the call.
pub(crate) unsafe fn text<'a>(pointer: *const c_char, what: &str) -> Answer<&'a str> {
    if pointer.is_null() {
        return refuse(format!("{what} is NULL"));
    }
    // SAFETY: as the caller promises.
    let text = unsafe { CStr::from_ptr(pointer) }.to_str();
    text.or_else(|_| refuse(format!("{what} is not UTF-8 text")))
}

/// The texts of an array of the importer's.
///
/// # Safety
/// As [`array`] and [`text`].
pub(crate) unsafe fn texts<'a>(values: InArray<*const c_char>, what: &str) -> Answer<Vec<&'a str>> {
    // SAFETY: as the caller promises.
    unsafe { array(values, what)?.iter().map(|&value| text(value, what)).collect() }
}
