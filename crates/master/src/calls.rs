//! The C functions of FMI 2.0 as an importer calls them: an FMU's shared library, and one instance of it.
//!
//! The library is trusted as any program that one starts: it must keep FMI's contract. What Rust can see of it is
//! checked: its symbols, NULL, the status it answers, the text it tells.

#![allow(unsafe_code)] // the C boundary, from its other side

use lemons_fmi::Status;
use lemons_fmi::v2::CallbackFunctions;
use libloading::Library;
use percent_encoding::{AsciiSet, NON_ALPHANUMERIC, percent_encode};
use std::ffi::{CStr, CString, NulError, c_char, c_int, c_uint, c_void};
use std::path::{Path, PathBuf};
use std::ptr::{NonNull, null, null_mut};
use std::rc::Rc;
use std::{fmt, io};

/// Why a C function of an FMU cannot be called, or gives nothing.
#[derive(Debug, thiserror::Error)]
pub enum CallError {
    /// The library cannot be loaded.
    #[error(transparent)]
    Load(#[from] libloading::Error),
    /// The library is none of an FMU.
    #[error("has no function {name}")]
    NoSymbol {
        /// Of the function.
        name: &'static str,
        /// What the loader says.
        source: libloading::Error,
    },
    /// The FMU lacks a function that FMI makes optional.
    #[error("the FMU has no function {0}")]
    NoFunction(&'static str),
    /// A zero would end a text.
    #[error("{what}")]
    Zero {
        /// Which text.
        what: String,
        /// Where it is.
        source: NulError,
    },
    /// There is no URI of the directory `resources`.
    #[error("{}", path.display())]
    Resources {
        /// The directory.
        path: PathBuf,
        /// Why not.
        source: io::Error,
    },
    /// The FMU refuses to be instantiated.
    #[error("fmi2Instantiate returned NULL")]
    NoInstance,
    /// The FMU has not given a state.
    #[error("the FMU gave no state")]
    NoState,
}

type Result<T> = std::result::Result<T, CallError>;

/// What a C function returned.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[must_use]
pub struct Answer(pub(crate) c_int);

impl Answer {
    /// The status; `None` if FMI has no such status.
    pub fn status(self) -> Option<Status> {
        use Status::{Discard, Error, Fatal, Ok, Pending, Warning};
        [Ok, Warning, Discard, Error, Fatal, Pending].into_iter().find(|status| *status as c_int == self.0)
    }
}

impl fmt::Display for Answer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.status() {
            Some(status) => write!(f, "{status:?}"),
            None => write!(f, "{}, which is no status of FMI", self.0),
        }
    }
}

/// Who hears what an instance tells; perhaps called from threads of the FMU's.
pub(crate) type Hears = dyn Fn(Option<Status>, &str) + Send + Sync;

/// What `lemons_logger` gets as its environment.
#[repr(C)]
struct Listener {
    hear: unsafe extern "C" fn(*const Listener, c_int, *const c_char),
    hears: Box<Hears>,
}

unsafe extern "C" {
    /// `fmi2CallbackLogger`; see logger.c.
    fn lemons_logger(
        environment: *mut c_void,
        instance: *const c_char,
        status: Status,
        category: *const c_char,
        message: *const c_char,
        ...
    );
}

/// # Safety
/// The listener lives, the text ends in a zero.
unsafe extern "C" fn hear(listener: *const Listener, status: c_int, text: *const c_char) {
    // SAFETY: as said above; only `lemons_logger` calls this.
    let (listener, text) = unsafe { (&*listener, CStr::from_ptr(text)) };
    // A number sign in a message is doubled (FMI 2.0.5, section 2.1.5).
    (listener.hears)(Answer(status).status(), &text.to_string_lossy().replace("##", "#"));
}

type Plain = unsafe extern "C" fn(*mut c_void) -> c_int;
type Get<T> = unsafe extern "C" fn(*mut c_void, *const c_uint, usize, *mut T) -> c_int;
type Set<T> = unsafe extern "C" fn(*mut c_void, *const c_uint, usize, *const T) -> c_int;

macro_rules! functions {
    (required { $($field:ident: $type:ty = $name:literal;)* } optional { $($may:ident: $may_type:ty = $may_name:literal;)* }) => {
        /// Those that are called here.
        struct Functions {
            $($field: $type,)*
            $($may: Option<$may_type>,)*
        }

        impl Functions {
            /// # Safety
            /// They are used no longer than the library lives, and have FMI's types.
            unsafe fn of(library: &Library) -> Result<Functions> {
                // SAFETY: the caller's.
                unsafe {
                    Ok(Functions {
                        $($field: *library.get::<$type>($name)
                            .map_err(|source| CallError::NoSymbol { name: $name, source })?,)*
                        $($may: library.get::<$may_type>($may_name).ok().map(|symbol| *symbol),)*
                    })
                }
            }
        }
    };
}

functions! {
    required {
        instantiate: unsafe extern "C" fn(
            *const c_char, c_int, *const c_char, *const c_char, *const CallbackFunctions, c_int, c_int
        ) -> *mut c_void = "fmi2Instantiate";
        free_instance: unsafe extern "C" fn(*mut c_void) = "fmi2FreeInstance";
        setup_experiment: unsafe extern "C" fn(*mut c_void, c_int, f64, f64, c_int, f64) -> c_int
            = "fmi2SetupExperiment";
        enter_initialization: Plain = "fmi2EnterInitializationMode";
        exit_initialization: Plain = "fmi2ExitInitializationMode";
        terminate: Plain = "fmi2Terminate";
        reset: Plain = "fmi2Reset";
        get_real: Get<f64> = "fmi2GetReal";
        get_integer: Get<c_int> = "fmi2GetInteger";
        get_boolean: Get<c_int> = "fmi2GetBoolean";
        get_string: Get<*const c_char> = "fmi2GetString";
        set_real: Set<f64> = "fmi2SetReal";
        set_integer: Set<c_int> = "fmi2SetInteger";
        set_boolean: Set<c_int> = "fmi2SetBoolean";
        set_string: Set<*const c_char> = "fmi2SetString";
        do_step: unsafe extern "C" fn(*mut c_void, f64, f64, c_int) -> c_int = "fmi2DoStep";
    }
    optional {
        get_state: unsafe extern "C" fn(*mut c_void, *mut *mut c_void) -> c_int = "fmi2GetFMUstate";
        set_state: unsafe extern "C" fn(*mut c_void, *mut c_void) -> c_int = "fmi2SetFMUstate";
        free_state: unsafe extern "C" fn(*mut c_void, *mut *mut c_void) -> c_int = "fmi2FreeFMUstate";
        state_size: unsafe extern "C" fn(*mut c_void, *mut c_void, *mut usize) -> c_int
            = "fmi2SerializedFMUstateSize";
        serialize: unsafe extern "C" fn(*mut c_void, *mut c_void, *mut u8, usize) -> c_int
            = "fmi2SerializeFMUstate";
        deserialize: unsafe extern "C" fn(*mut c_void, *const u8, usize, *mut *mut c_void) -> c_int
            = "fmi2DeSerializeFMUstate";
    }
}

/// `fmi2CoSimulation`
const CO_SIMULATION: c_int = 1;
const FALSE: c_int = 0;
const TRUE: c_int = 1;

/// What an instance is made of.
pub(crate) struct Made<'a> {
    /// The shared library.
    pub(crate) library: &'a Path,
    /// The FMU's directory `resources`; it need not exist.
    pub(crate) resources: &'a Path,
    pub(crate) name: &'a str,
    pub(crate) guid: &'a str,
    /// Whether the FMU gets functions for memory.
    pub(crate) memory_functions: bool,
}

/// An instance. It is freed when this is dropped, before its library is unloaded.
pub(crate) struct Calls {
    component: NonNull<c_void>,
    functions: Functions,
    // FMUs keep pointers to both.
    _callbacks: Rc<CallbackFunctions>,
    _listener: Rc<Listener>,
    _library: Library,
}

impl Drop for Calls {
    fn drop(&mut self) {
        // SAFETY: an instance of this library, freed once.
        unsafe { (self.functions.free_instance)(self.component.as_ptr()) }
    }
}

impl Calls {
    /// Loads a library and instantiates its FMU for co-simulation.
    ///
    /// # Errors
    /// The library cannot be loaded or is none of an FMU; or the FMU refuses.
    pub(crate) fn new(made: &Made, hears: Box<Hears>) -> Result<Calls> {
        let name = c_text(made.name, || format!("instance name={:?}", made.name))?;
        let guid = c_text(made.guid, || format!("guid={:?}", made.guid))?;
        let resources = made.resources.is_dir().then(|| file_uri(made.resources)).transpose()?;
        let library = load(made.library)?;
        // SAFETY: kept together with the library; an FMU's library has them as FMI says.
        let functions = unsafe { Functions::of(&library) }?;
        let listener = Rc::new(Listener { hear, hears });
        let memory = |function: *const c_void| if made.memory_functions { function } else { null() };
        let callbacks = Rc::new(CallbackFunctions {
            logger: Some(lemons_logger),
            allocate_memory: memory(libc::calloc as *const c_void),
            free_memory: memory(libc::free as *const c_void),
            step_finished: null(),
            component_environment: Rc::as_ptr(&listener).cast_mut().cast(),
        });
        // SAFETY: FMI's arguments; the callbacks and their environment live as long as the instance.
        let component = unsafe {
            (functions.instantiate)(
                name.as_ptr(),
                CO_SIMULATION,
                guid.as_ptr(),
                resources.as_ref().map_or(null(), |uri| uri.as_ptr()),
                Rc::as_ptr(&callbacks),
                FALSE,
                // Else an FMU tells no warnings; what it tells with the status `fmi2OK` is not kept.
                TRUE,
            )
        };
        let component = NonNull::new(component).ok_or(CallError::NoInstance)?;
        Ok(Calls { component, functions, _callbacks: callbacks, _listener: listener, _library: library })
    }

    fn plain(&self, function: Plain) -> Answer {
        // SAFETY: an instance of this library.
        Answer(unsafe { function(self.component.as_ptr()) })
    }

    fn get<T>(&self, function: Get<T>, references: &[u32], values: &mut [T]) -> Answer {
        assert_eq!(references.len(), values.len(), "a value for each reference");
        // SAFETY: an instance of this library; both arrays are as long as said.
        Answer(unsafe {
            function(self.component.as_ptr(), references.as_ptr(), references.len(), values.as_mut_ptr())
        })
    }

    fn set<T>(&self, function: Set<T>, references: &[u32], values: &[T]) -> Answer {
        assert_eq!(references.len(), values.len(), "a value for each reference");
        // SAFETY: an instance of this library; both arrays are as long as said.
        Answer(unsafe {
            function(self.component.as_ptr(), references.as_ptr(), references.len(), values.as_ptr())
        })
    }

    /// Without tolerance and stop time.
    pub(crate) fn setup_experiment(&self, start: f64) -> Answer {
        // SAFETY: an instance of this library.
        Answer(unsafe {
            (self.functions.setup_experiment)(self.component.as_ptr(), FALSE, 0.0, start, FALSE, 0.0)
        })
    }

    pub(crate) fn enter_initialization(&self) -> Answer {
        self.plain(self.functions.enter_initialization)
    }

    pub(crate) fn exit_initialization(&self) -> Answer {
        self.plain(self.functions.exit_initialization)
    }

    pub(crate) fn terminate(&self) -> Answer {
        self.plain(self.functions.terminate)
    }

    pub(crate) fn reset(&self) -> Answer {
        self.plain(self.functions.reset)
    }

    pub(crate) fn get_real(&self, references: &[u32], values: &mut [f64]) -> Answer {
        self.get(self.functions.get_real, references, values)
    }

    pub(crate) fn get_integer(&self, references: &[u32], values: &mut [i32]) -> Answer {
        self.get(self.functions.get_integer, references, values)
    }

    pub(crate) fn get_boolean(&self, references: &[u32], values: &mut [i32]) -> Answer {
        self.get(self.functions.get_boolean, references, values)
    }

    /// Leaves the values as they are if the FMU refuses.
    pub(crate) fn get_string(&self, references: &[u32], values: &mut [String]) -> Answer {
        assert_eq!(references.len(), values.len(), "a value for each reference");
        let mut texts = vec![null(); references.len()];
        let answer = self.get(self.functions.get_string, references, &mut texts);
        if matches!(answer.status(), Some(Status::Ok | Status::Warning)) {
            for (value, text) in values.iter_mut().zip(texts) {
                // SAFETY: not NULL, so a text of the FMU's, which lives until its next call.
                let text = (!text.is_null()).then(|| unsafe { CStr::from_ptr(text) });
                *value = text.map(|text| text.to_string_lossy().into_owned()).unwrap_or_default();
            }
        }
        answer
    }

    pub(crate) fn set_real(&self, references: &[u32], values: &[f64]) -> Answer {
        self.set(self.functions.set_real, references, values)
    }

    pub(crate) fn set_integer(&self, references: &[u32], values: &[i32]) -> Answer {
        self.set(self.functions.set_integer, references, values)
    }

    pub(crate) fn set_boolean(&self, references: &[u32], values: &[i32]) -> Answer {
        self.set(self.functions.set_boolean, references, values)
    }

    /// # Errors
    /// A text holds a zero, which would end it.
    pub(crate) fn set_string(&self, references: &[u32], values: &[&str]) -> Result<Answer> {
        let zero = |text: &str| format!("{text:?}: a text for an FMU holds no zero");
        let texts = values.iter().map(|text| c_text(text, || zero(text)));
        let texts = texts.collect::<Result<Vec<CString>>>()?;
        let pointers: Vec<*const c_char> = texts.iter().map(|text| text.as_ptr()).collect();
        Ok(self.set(self.functions.set_string, references, &pointers))
    }

    /// From a time over a step, both \[s\]; nothing before that time is asked for any more.
    pub(crate) fn do_step(&self, time: f64, step: f64) -> Answer {
        // SAFETY: an instance of this library.
        Answer(unsafe { (self.functions.do_step)(self.component.as_ptr(), time, step, TRUE) })
    }
}

/// A state that an instance holds for us, or none yet; given back when this is dropped.
pub(crate) struct Held {
    calls: Rc<Calls>,
    /// NULL, or of this instance.
    pointer: *mut c_void,
}

impl Drop for Held {
    fn drop(&mut self) {
        if let Some(free) = self.calls.functions.free_state.filter(|_| !self.pointer.is_null()) {
            // SAFETY: a state of this instance, which lives. There is nobody to tell of a refusal.
            unsafe { free(self.calls.component.as_ptr(), &raw mut self.pointer) };
        }
    }
}

impl Held {
    pub(crate) fn none(calls: &Rc<Calls>) -> Held {
        Held { calls: calls.clone(), pointer: null_mut() }
    }

    /// `fmi2GetFMUstate`
    pub(crate) fn take(&mut self) -> Result<Answer> {
        let function = there(self.calls.functions.get_state, "fmi2GetFMUstate")?;
        // SAFETY: the pointer is NULL or a state of this instance.
        Ok(Answer(unsafe { function(self.calls.component.as_ptr(), &raw mut self.pointer) }))
    }

    /// `fmi2SetFMUstate`
    pub(crate) fn put(&self) -> Result<Answer> {
        self.is_there()?;
        let function = there(self.calls.functions.set_state, "fmi2SetFMUstate")?;
        // SAFETY: a state of this instance.
        Ok(Answer(unsafe { function(self.calls.component.as_ptr(), self.pointer) }))
    }

    /// `fmi2SerializedFMUstateSize` \[byte\]
    pub(crate) fn size(&self) -> Result<(Answer, usize)> {
        self.is_there()?;
        let function = there(self.calls.functions.state_size, "fmi2SerializedFMUstateSize")?;
        let mut size = 0;
        // SAFETY: a state of this instance.
        let answer = unsafe { function(self.calls.component.as_ptr(), self.pointer, &raw mut size) };
        Ok((Answer(answer), size))
    }

    /// `fmi2SerializeFMUstate`
    pub(crate) fn serialize(&self, bytes: &mut [u8]) -> Result<Answer> {
        self.is_there()?;
        let function = there(self.calls.functions.serialize, "fmi2SerializeFMUstate")?;
        let (component, size) = (self.calls.component.as_ptr(), bytes.len());
        // SAFETY: a state of this instance; the bytes are as many as said.
        Ok(Answer(unsafe { function(component, self.pointer, bytes.as_mut_ptr(), size) }))
    }

    /// `fmi2DeSerializeFMUstate`
    pub(crate) fn deserialize(&mut self, bytes: &[u8]) -> Result<Answer> {
        let function = there(self.calls.functions.deserialize, "fmi2DeSerializeFMUstate")?;
        let component = self.calls.component.as_ptr();
        // SAFETY: the pointer is NULL or a state of this instance; the bytes are as many as said.
        Ok(Answer(unsafe { function(component, bytes.as_ptr(), bytes.len(), &raw mut self.pointer) }))
    }

    fn is_there(&self) -> Result<()> {
        if self.pointer.is_null() { Err(CallError::NoState) } else { Ok(()) }
    }
}

fn there<T>(function: Option<T>, name: &'static str) -> Result<T> {
    function.ok_or(CallError::NoFunction(name))
}

/// `what` is said of a text that holds a zero.
fn c_text(text: &str, what: impl FnOnce() -> String) -> Result<CString> {
    CString::new(text).map_err(|source| CallError::Zero { what: what(), source })
}

fn load(path: &Path) -> Result<Library> {
    // SAFETY: what a library does when it is loaded is the FMU's; see the module.
    #[cfg(not(windows))]
    return Ok(unsafe { Library::new(path) }?);
    #[cfg(windows)]
    {
        use libloading::os::windows;
        // With the libraries that lie beside it.
        let flags = windows::LOAD_WITH_ALTERED_SEARCH_PATH;
        // SAFETY: as above.
        Ok(unsafe { windows::Library::load_with_flags(path, flags) }?.into())
    }
}

/// What stands for itself in the path of an URI.
const ENCODED: &AsciiSet = &NON_ALPHANUMERIC.remove(b'-').remove(b'.').remove(b'_').remove(b'~').remove(b'/');

/// `file:///…/`, as FMI wants it.
fn file_uri(directory: &Path) -> Result<CString> {
    let unknown = |source| CallError::Resources { path: directory.to_owned(), source };
    let path = std::path::absolute(directory).map_err(unknown)?;
    let encoded = percent_encode(path.as_os_str().as_encoded_bytes(), ENCODED).to_string();
    let path =
        if cfg!(windows) { format!("/{}", encoded.replace("%5C", "/").replace("%3A", ":")) } else { encoded };
    let uri = format!("file://{}/", path.trim_end_matches('/'));
    c_text(&uri, || uri.clone())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::{Arc, Mutex};

    /// What is heard when an FMU tells something.
    fn heard(tell: impl FnOnce(*mut c_void)) -> Vec<(Option<Status>, String)> {
        let all = Arc::new(Mutex::new(Vec::new()));
        let list = all.clone();
        let hears: Box<Hears> =
            Box::new(move |status, text| list.lock().unwrap().push((status, text.to_owned())));
        let listener = Rc::new(Listener { hear, hears });
        tell(Rc::as_ptr(&listener).cast_mut().cast());
        std::mem::take(&mut *all.lock().unwrap())
    }

    #[test]
    fn what_an_fmu_tells_is_formatted_as_printf_does() {
        let said = heard(|environment| {
            let (name, category) = (c"x".as_ptr(), c"all".as_ptr());
            // SAFETY: arguments as the formats want them.
            unsafe {
                let format = c"%s is %d of %.2f %%".as_ptr();
                let (what, count) = (c"this".as_ptr(), 7 as c_int);
                lemons_logger(environment, name, Status::Error, category, format, what, count, 0.5_f64);
                lemons_logger(environment, null(), Status::Warning, null(), c"\xff plain".as_ptr());
                lemons_logger(environment, name, Status::Ok, category, null());
                lemons_logger(null_mut(), name, Status::Ok, category, c"nobody hears".as_ptr());
            }
        });
        let expected = [
            (Some(Status::Error), "this is 7 of 0.50 %".to_owned()),
            (Some(Status::Warning), "\u{fffd} plain".to_owned()),
        ];
        assert_eq!(said, expected);
    }

    #[test]
    fn an_endless_message_is_cut() {
        let said = heard(|environment| {
            // SAFETY: a width and its argument.
            unsafe {
                let (format, width) = (c"%*d".as_ptr(), 50_000_000 as c_int);
                lemons_logger(environment, null(), Status::Ok, null(), format, width, 1 as c_int);
            }
        });
        assert_eq!(said[0].1.len(), 1_000_000);
    }

    #[test]
    #[cfg(unix)]
    fn the_resources_are_named_by_an_uri() {
        let said = |path: &str| file_uri(Path::new(path)).unwrap().into_string().unwrap();
        assert_eq!(said("/tmp/a_b-c.d~/resources"), "file:///tmp/a_b-c.d~/resources/");
        assert_eq!(said("/tmp/a b%20#?/ü/"), "file:///tmp/a%20b%2520%23%3F/%C3%BC/");
        let here = std::env::current_dir().unwrap();
        assert_eq!(said("x"), said(here.join("x").to_str().unwrap()));
        // As the other side reads it.
        let read = lemons_fmi::location::directories(&said("/tmp/a b%20#?/ü")).unwrap();
        assert_eq!(read[0], Path::new("/tmp/a b%20#?/ü/"));
    }

    #[test]
    fn a_status_that_fmi_does_not_know_is_told_as_a_number() {
        let said = [0, 3, 5, 6, -1].map(|code| Answer(code).to_string());
        let unknown = ["6, which is no status of FMI", "-1, which is no status of FMI"];
        assert_eq!(said, ["Ok", "Error", "Pending", unknown[0], unknown[1]]);
    }
}
