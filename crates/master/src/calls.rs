//! The C functions of FMI as an importer calls them: an FMU's shared library, and one instance of it.
//!
//! The library is trusted as any program that one starts: it must keep FMI's contract. What Rust can see of it is
//! checked: its symbols, NULL, the status it answers, the text it tells.

#![allow(unsafe_code)] // the C boundary, from its other side

mod v2;
mod v3;

use lemons_fmi::Status;
use lemons_ssp::{Fmi, Native};
use libloading::Library;
use std::ffi::{CStr, CString, NulError, c_char, c_int, c_void};
use std::fmt;
use std::io;
use std::path::{Path, PathBuf};
use std::ptr::{NonNull, null, null_mut};
use std::rc::Rc;

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
    /// The FMU lacks a function that not every FMU needs.
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
    /// There is no URI or path of the directory `resources`.
    #[error("{}", path.display())]
    Resources {
        /// The directory.
        path: PathBuf,
        /// Why not.
        source: io::Error,
    },
    /// The FMU refuses to be instantiated.
    #[error("{0} returned NULL")]
    NoInstance(&'static str),
    /// The FMU has not given a state.
    #[error("the FMU gave no state")]
    NoState,
    /// A value that the FMU gave, or that it is given, is not one of a smaller type.
    #[error("{call}: {value} is not a value of {of}")]
    Range {
        /// The C function.
        call: &'static str,
        /// The value.
        value: i128,
        /// The smaller type.
        of: &'static str,
    },
    /// A step has ended otherwise than as a whole.
    #[error("{call}: {why}")]
    Ended {
        /// The C function.
        call: &'static str,
        /// What the FMU said.
        why: String,
    },
}

type Result<T> = std::result::Result<T, CallError>;

/// What a C function returned.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[must_use]
pub struct Answer {
    pub(crate) code: c_int,
    /// The function's name.
    pub(crate) call: &'static str,
}

impl Answer {
    /// The status; `None` if FMI has no such status.
    pub fn status(self) -> Option<Status> {
        use Status::{Discard, Error, Fatal, Ok, Pending, Warning};
        let pending = self.call.starts_with("fmi2").then_some(Pending);
        let known = [Ok, Warning, Discard, Error, Fatal].into_iter().chain(pending);
        known.into_iter().find(|status| *status as c_int == self.code)
    }

    /// The name of the C function.
    pub fn call(self) -> &'static str {
        self.call
    }
}

impl fmt::Display for Answer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.status() {
            Some(status) => write!(f, "{status:?}"),
            None => write!(f, "{}, which is no status of FMI", self.code),
        }
    }
}

/// Who hears what an instance tells; perhaps called from threads of the FMU's.
pub(crate) type Hears = dyn Fn(Option<Status>, &str) + Send + Sync;

type Plain = unsafe extern "C" fn(*mut c_void) -> c_int;

/// A C function, with its name.
type Named<T> = (T, &'static str);

macro_rules! functions {
    (required { $($field:ident: $type:ty = $name:literal;)* } optional { $($may:ident: $may_type:ty = $may_name:literal;)* }) => {
        /// Those that are called here.
        pub(super) struct Functions {
            $(pub(super) $field: $crate::calls::Named<$type>,)*
            $(pub(super) $may: $crate::calls::Named<Option<$may_type>>,)*
        }

        impl Functions {
            /// # Safety
            /// They are used no longer than the library lives, and have FMI's types.
            pub(super) unsafe fn of(library: &libloading::Library) -> $crate::calls::Result<Functions> {
                // SAFETY: the caller's.
                unsafe {
                    Ok(Functions {
                        $($field: (*library.get::<$type>($name)
                            .map_err(|source| $crate::calls::CallError::NoSymbol { name: $name, source })?, $name),)*
                        $($may: (library.get::<$may_type>($may_name).ok().map(|symbol| *symbol), $may_name),)*
                    })
                }
            }
        }
    };
}
use functions;

/// Functions for states: they differ in their names only.
struct States {
    get: Named<Option<unsafe extern "C" fn(*mut c_void, *mut *mut c_void) -> c_int>>,
    set: Named<Option<unsafe extern "C" fn(*mut c_void, *mut c_void) -> c_int>>,
    free: Named<Option<unsafe extern "C" fn(*mut c_void, *mut *mut c_void) -> c_int>>,
    size: Named<Option<unsafe extern "C" fn(*mut c_void, *mut c_void, *mut usize) -> c_int>>,
    serialize: Named<Option<unsafe extern "C" fn(*mut c_void, *mut c_void, *mut u8, usize) -> c_int>>,
    deserialize:
        Named<Option<unsafe extern "C" fn(*mut c_void, *const u8, usize, *mut *mut c_void) -> c_int>>,
}

impl States {
    /// # Safety
    /// As that of `Functions::of`.
    unsafe fn of(library: &Library, fmi: Fmi) -> States {
        macro_rules! state {
            ($v2:literal, $v3:literal) => {{
                let name = if fmi == Fmi::V2 { $v2 } else { $v3 };
                // SAFETY: the caller's.
                (unsafe { library.get(name) }.ok().map(|symbol| *symbol), name)
            }};
        }
        States {
            get: state!("fmi2GetFMUstate", "fmi3GetFMUState"),
            set: state!("fmi2SetFMUstate", "fmi3SetFMUState"),
            free: state!("fmi2FreeFMUstate", "fmi3FreeFMUState"),
            size: state!("fmi2SerializedFMUstateSize", "fmi3SerializedFMUStateSize"),
            serialize: state!("fmi2SerializeFMUstate", "fmi3SerializeFMUState"),
            deserialize: state!("fmi2DeSerializeFMUstate", "fmi3DeserializeFMUState"),
        }
    }
}

/// The functions of the FMU's version.
enum Functions {
    V2(Box<v2::Functions>),
    V3(Box<v3::Functions>),
}

/// What an instance is made of.
pub(crate) struct Made<'a> {
    pub(crate) fmi: Fmi,
    /// The shared library.
    pub(crate) library: &'a Path,
    /// The FMU's directory `resources`; it need not exist.
    pub(crate) resources: &'a Path,
    pub(crate) name: &'a str,
    /// In FMI 3.0 the `instantiationToken`.
    pub(crate) guid: &'a str,
    /// Whether the FMU gets functions for memory.
    pub(crate) memory_functions: bool,
}

/// An instance. It is freed when this is dropped, before its library is unloaded.
pub(crate) struct Calls {
    component: NonNull<c_void>,
    functions: Functions,
    states: States,
    // FMUs keep pointers to it.
    _heard: v2::Heard,
    _library: Library,
}

impl Drop for Calls {
    fn drop(&mut self) {
        let free = match &self.functions {
            Functions::V2(functions) => functions.free_instance.0,
            Functions::V3(functions) => functions.free_instance.0,
        };
        // SAFETY: an instance of this library, freed once.
        unsafe { free(self.component.as_ptr()) }
    }
}

/// One call of the FMU's version.
macro_rules! either {
    ($self:ident, $functions:ident => $call:expr) => {
        match &$self.functions {
            Functions::V2($functions) => $call,
            Functions::V3($functions) => $call,
        }
    };
}

impl Calls {
    /// Loads a library and instantiates its FMU for co-simulation.
    ///
    /// # Errors
    /// The library cannot be loaded or is none of an FMU; or the FMU refuses.
    pub(crate) fn new(made: &Made, hears: Box<Hears>) -> Result<Calls> {
        let name = c_text(made.name, || format!("instance name={:?}", made.name))?;
        let guid = c_text(made.guid, || format!("guid={:?}", made.guid))?;
        let place = match made.fmi {
            Fmi::V2 => v2::file_uri,
            Fmi::V3 => v3::path,
        };
        let resources = made.resources.is_dir().then(|| place(made.resources)).transpose()?;
        let resources = resources.as_deref();
        let library = load(made.library)?;
        let heard = v2::Heard::new(hears, made.memory_functions);
        // SAFETY: kept together with the library; an FMU's library has them as FMI says.
        let (functions, states) = unsafe {
            let functions = match made.fmi {
                Fmi::V2 => Functions::V2(Box::new(v2::Functions::of(&library)?)),
                Fmi::V3 => Functions::V3(Box::new(v3::Functions::of(&library)?)),
            };
            (functions, States::of(&library, made.fmi))
        };
        let (component, call) = match &functions {
            Functions::V2(functions) => functions.instantiate(&name, &guid, resources, &heard),
            Functions::V3(functions) => functions.instantiate(&name, &guid, resources, &heard),
        };
        let component = NonNull::new(component).ok_or(CallError::NoInstance(call))?;
        Ok(Calls { component, functions, states, _heard: heard, _library: library })
    }

    fn plain(&self, (function, call): Named<Plain>) -> Answer {
        // SAFETY: an instance of this library.
        Answer { code: unsafe { function(self.component.as_ptr()) }, call }
    }

    /// At a start time \[s\], with a tolerance if there is one, without stop time.
    ///
    /// # Errors
    /// The FMU lacks a function.
    pub(crate) fn enter_initialization(&self, start: f64, tolerance: Option<f64>) -> Answer {
        either!(self, functions => functions.enter_initialization(self, start, tolerance))
    }

    pub(crate) fn exit_initialization(&self) -> Answer {
        either!(self, functions => self.plain(functions.exit_initialization))
    }

    pub(crate) fn terminate(&self) -> Answer {
        either!(self, functions => self.plain(functions.terminate))
    }

    pub(crate) fn reset(&self) -> Answer {
        either!(self, functions => self.plain(functions.reset))
    }

    /// Reads all values of Reals.
    pub(crate) fn get_real(&self, of: Native, references: &[u32], values: &mut [f64]) -> Result<Answer> {
        either!(self, functions => functions.get_real(self, of, references, values))
    }

    /// Reads all values of whole numbers.
    pub(crate) fn get_integer(&self, of: Native, references: &[u32], values: &mut [i32]) -> Result<Answer> {
        either!(self, functions => functions.get_integer(self, of, references, values))
    }

    /// Reads all values of Booleans.
    pub(crate) fn get_boolean(&self, references: &[u32], values: &mut [i32]) -> Result<Answer> {
        either!(self, functions => functions.get_boolean(self, references, values))
    }

    /// Reads all texts; leaves the values as they are if the FMU refuses.
    pub(crate) fn get_string(&self, references: &[u32], values: &mut [String]) -> Result<Answer> {
        let mut texts = vec![null(); values.len()];
        let answer = either!(self, functions => functions.get_string(self, references, &mut texts))?;
        if matches!(answer.status(), Some(Status::Ok | Status::Warning)) {
            for (value, text) in values.iter_mut().zip(texts) {
                // SAFETY: not NULL, so a text of the FMU's, which lives until its next call.
                let text = (!text.is_null()).then(|| unsafe { CStr::from_ptr(text) });
                *value = text.map(|text| text.to_string_lossy().into_owned()).unwrap_or_default();
            }
        }
        Ok(answer)
    }

    /// Sets all values of Reals.
    pub(crate) fn set_real(&self, of: Native, references: &[u32], values: &[f64]) -> Result<Answer> {
        either!(self, functions => functions.set_real(self, of, references, values))
    }

    /// Sets all values of whole numbers.
    pub(crate) fn set_integer(&self, of: Native, references: &[u32], values: &[i32]) -> Result<Answer> {
        either!(self, functions => functions.set_integer(self, of, references, values))
    }

    /// Sets all values of Booleans.
    pub(crate) fn set_boolean(&self, references: &[u32], values: &[i32]) -> Result<Answer> {
        either!(self, functions => functions.set_boolean(self, references, values))
    }

    /// Sets all texts.
    ///
    /// # Errors
    /// A text holds a zero, which would end it.
    pub(crate) fn set_string(&self, references: &[u32], values: &[&str]) -> Result<Answer> {
        let zero = |text: &str| format!("{text:?}: a text for an FMU holds no zero");
        let texts = values.iter().map(|text| c_text(text, || zero(text)));
        let texts = texts.collect::<Result<Vec<CString>>>()?;
        let pointers: Vec<*const c_char> = texts.iter().map(|text| text.as_ptr()).collect();
        either!(self, functions => functions.set_string(self, references, &pointers))
    }

    /// From a time over a step, both \[s\]; nothing before that time is asked for any more.
    ///
    /// # Errors
    /// The FMU has returned early, or wants an event or the end.
    pub(crate) fn do_step(&self, time: f64, step: f64) -> Result<Answer> {
        either!(self, functions => functions.do_step(self, time, step))
    }

    /// Sets structural parameters in Configuration Mode.
    ///
    /// # Errors
    /// The FMU lacks a function.
    pub(crate) fn configure(&self, references: &[u32], sizes: &[u64]) -> Result<Answer> {
        match &self.functions {
            Functions::V2(_) => Err(CallError::NoFunction("fmi3EnterConfigurationMode")),
            Functions::V3(functions) => functions.configure(self, references, sizes),
        }
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
        if let Some(free) = self.calls.states.free.0.filter(|_| !self.pointer.is_null()) {
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
        let (function, call) = there(self.calls.states.get)?;
        // SAFETY: the pointer is NULL or a state of this instance.
        Ok(Answer { code: unsafe { function(self.calls.component.as_ptr(), &raw mut self.pointer) }, call })
    }

    /// `fmi2SetFMUstate`
    pub(crate) fn put(&self) -> Result<Answer> {
        self.is_there()?;
        let (function, call) = there(self.calls.states.set)?;
        // SAFETY: a state of this instance.
        Ok(Answer { code: unsafe { function(self.calls.component.as_ptr(), self.pointer) }, call })
    }

    /// `fmi2SerializedFMUstateSize` \[byte\]
    pub(crate) fn size(&self) -> Result<(Answer, usize)> {
        self.is_there()?;
        let (function, call) = there(self.calls.states.size)?;
        let mut size = 0;
        // SAFETY: a state of this instance.
        let code = unsafe { function(self.calls.component.as_ptr(), self.pointer, &raw mut size) };
        Ok((Answer { code, call }, size))
    }

    /// `fmi2SerializeFMUstate`
    pub(crate) fn serialize(&self, bytes: &mut [u8]) -> Result<Answer> {
        self.is_there()?;
        let (function, call) = there(self.calls.states.serialize)?;
        let (component, size) = (self.calls.component.as_ptr(), bytes.len());
        // SAFETY: a state of this instance; the bytes are as many as said.
        Ok(Answer { code: unsafe { function(component, self.pointer, bytes.as_mut_ptr(), size) }, call })
    }

    /// `fmi2DeSerializeFMUstate`
    pub(crate) fn deserialize(&mut self, bytes: &[u8]) -> Result<Answer> {
        let (function, call) = there(self.calls.states.deserialize)?;
        let (component, size) = (self.calls.component.as_ptr(), bytes.len());
        // SAFETY: the pointer is NULL or a state of this instance; the bytes are as many as said.
        let code = unsafe { function(component, bytes.as_ptr(), size, &raw mut self.pointer) };
        Ok(Answer { code, call })
    }

    fn is_there(&self) -> Result<()> {
        if self.pointer.is_null() { Err(CallError::NoState) } else { Ok(()) }
    }
}

fn there<T>((function, name): Named<Option<T>>) -> Result<Named<T>> {
    Ok((function.ok_or(CallError::NoFunction(name))?, name))
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
        // With the libraries that lie beside it. Windows wants an absolute path with backslashes for that.
        let flags = windows::LOAD_WITH_ALTERED_SEARCH_PATH;
        let path = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
        // SAFETY: as above.
        Ok(unsafe { windows::Library::load_with_flags(path, flags) }?.into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_status_that_fmi_does_not_know_is_told_as_a_number() {
        let said = |call| [0, 3, 5, 6, -1].map(|code| Answer { code, call }.to_string());
        let unknown = ["6, which is no status of FMI", "-1, which is no status of FMI"];
        assert_eq!(said("fmi2DoStep"), ["Ok", "Error", "Pending", unknown[0], unknown[1]]);
        assert_eq!(said("fmi3DoStep")[2], "5, which is no status of FMI");
    }
}
