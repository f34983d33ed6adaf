//! The C functions of FMI as an importer calls them: an FMU's shared library, and one instance of it.
//!
//! The library is trusted as any program that one starts: it must keep FMI's contract. What Rust can see of it is
//! checked: its symbols, NULL, the status it answers, the text it tells.

#![allow(unsafe_code)] // the C boundary, from its other side

mod v2;
mod v3;
mod values;

pub use values::Value;

use crate::ssp::Fmi;
use lemons_fmi::Status;
use libloading::Library;
use std::ffi::{CString, NulError, c_int, c_uint, c_void};
use std::fmt;
use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::ptr::{NonNull, null_mut};
use std::rc::Rc;

/// Why a C function of an FMU cannot be called, or gives nothing.
#[derive(Debug, thiserror::Error)]
pub enum CallError {
    /// The library cannot be loaded.
    #[error(transparent)]
    Load(#[from] libloading::Error),
    /// The file of the library ends before what its header speaks of: a loader would get SIGBUS.
    #[error("{}: is cut off: its table of sections ends at byte {end}, the file at byte {length}", path.display())]
    CutOff {
        /// The file.
        path: PathBuf,
        /// \[byte\] the length that its header speaks of
        end: u64,
        /// \[byte\] its length
        length: u64,
    },
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

    /// Whether the function has done what it was called for, perhaps with a warning.
    pub(crate) fn succeeded(self) -> bool {
        matches!(self.status(), Some(Status::Ok | Status::Warning))
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

/// What FMI 2.0 and FMI 3.0 call a function.
type Names = [&'static str; 2];

/// Functions that every FMU 2.0 for co-simulation must have, of those that are called here.
const REQUIRED_V2: [&str; 15] = [
    "fmi2Instantiate",
    "fmi2FreeInstance",
    "fmi2SetupExperiment",
    "fmi2EnterInitializationMode",
    "fmi2ExitInitializationMode",
    "fmi2Terminate",
    "fmi2GetReal",
    "fmi2GetInteger",
    "fmi2GetBoolean",
    "fmi2GetString",
    "fmi2SetReal",
    "fmi2SetInteger",
    "fmi2SetBoolean",
    "fmi2SetString",
    "fmi2DoStep",
];

/// The same of FMI 3.0, where an FMU may lack the functions of types that it has not.
const REQUIRED_V3: [&str; 6] = [
    "fmi3InstantiateCoSimulation",
    "fmi3FreeInstance",
    "fmi3EnterInitializationMode",
    "fmi3ExitInitializationMode",
    "fmi3Terminate",
    "fmi3DoStep",
];

/// A function of a library, by its name.
///
/// # Safety
/// `F` is the type that FMI gives it, and it is used no longer than the library lives.
unsafe fn function<F: Copy>(library: &Library, name: &'static str) -> Result<F> {
    // SAFETY: the caller's.
    let symbol = unsafe { library.get::<F>(name) };
    Ok(*symbol.map_err(|_| CallError::NoFunction(name))?)
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
pub struct Calls {
    component: NonNull<c_void>,
    fmi: Fmi,
    // FMUs keep pointers to it.
    _logger: v2::Logger,
    library: Library,
}

impl Drop for Calls {
    fn drop(&mut self) {
        type Free = unsafe extern "C" fn(*mut c_void);
        // SAFETY: FMI's type; an instance of this library, freed once.
        unsafe {
            if let Ok(free) = self.function::<Free>(self.name(["fmi2FreeInstance", "fmi3FreeInstance"])) {
                free(self.component.as_ptr());
            }
        }
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
        let place = match made.fmi {
            Fmi::V2 => v2::file_uri,
            Fmi::V3 => v3::path,
        };
        let resources = made.resources.is_dir().then(|| place(made.resources)).transpose()?;
        let resources = resources.as_deref();
        let library = load(made.library)?;
        let required = if made.fmi == Fmi::V2 { &REQUIRED_V2[..] } else { &REQUIRED_V3 };
        for &name in required {
            // SAFETY: it is not called.
            let found = unsafe { library.get::<Plain>(name) };
            found.map_err(|source| CallError::NoSymbol { name, source })?;
        }
        let logger = v2::Logger::new(hears, made.memory_functions);
        let (component, call) = match made.fmi {
            Fmi::V2 => v2::instantiate(&library, &name, &guid, resources, &logger)?,
            Fmi::V3 => v3::instantiate(&library, &name, &guid, resources, &logger)?,
        };
        let component = NonNull::new(component).ok_or(CallError::NoInstance(call))?;
        Ok(Calls { component, fmi: made.fmi, _logger: logger, library })
    }

    fn name(&self, [v2, v3]: Names) -> &'static str {
        if self.fmi == Fmi::V2 { v2 } else { v3 }
    }

    /// # Safety
    /// As that of [`function`].
    unsafe fn function<F: Copy>(&self, name: &'static str) -> Result<F> {
        // SAFETY: the caller's.
        unsafe { function(&self.library, name) }
    }

    /// Calls a function that takes the instance only.
    fn plain(&self, call: &'static str) -> Result<Answer> {
        // SAFETY: FMI's type; an instance of this library.
        let code = unsafe { self.function::<Plain>(call)?(self.component.as_ptr()) };
        Ok(Answer { code, call })
    }

    /// At a start time \[s\], with a tolerance if there is one, without stop time.
    ///
    /// # Errors
    /// The FMU lacks a function.
    pub(crate) fn enter_initialization(&self, start: f64, tolerance: Option<f64>) -> Result<Answer> {
        match self.fmi {
            Fmi::V2 => v2::enter_initialization(self, start, tolerance),
            Fmi::V3 => v3::enter_initialization(self, start, tolerance),
        }
    }

    pub(crate) fn exit_initialization(&self) -> Result<Answer> {
        self.plain(self.name(["fmi2ExitInitializationMode", "fmi3ExitInitializationMode"]))
    }

    pub(crate) fn terminate(&self) -> Result<Answer> {
        self.plain(self.name(["fmi2Terminate", "fmi3Terminate"]))
    }

    /// Reads all values of the variables: in FMI 2.0 one for each reference.
    fn get<T>(&self, call: &'static str, references: &[u32], values: &mut [T]) -> Result<Answer> {
        type V2<T> = unsafe extern "C" fn(*mut c_void, *const c_uint, usize, *mut T) -> c_int;
        type V3<T> = unsafe extern "C" fn(*mut c_void, *const u32, usize, *mut T, usize) -> c_int;
        let (component, count) = (self.component.as_ptr(), references.len());
        let (references, length, to) = (references.as_ptr(), values.len(), values.as_mut_ptr());
        assert!(self.fmi == Fmi::V3 || count == length, "a value for each reference");
        // SAFETY: FMI's types; an instance of this library; both arrays are as long as said.
        let code = unsafe {
            match self.fmi {
                Fmi::V2 => self.function::<V2<T>>(call)?(component, references, count, to),
                Fmi::V3 => self.function::<V3<T>>(call)?(component, references, count, to, length),
            }
        };
        Ok(Answer { code, call })
    }

    /// Sets all values of the variables: in FMI 2.0 one for each reference.
    fn set<T>(&self, call: &'static str, references: &[u32], values: &[T]) -> Result<Answer> {
        type V2<T> = unsafe extern "C" fn(*mut c_void, *const c_uint, usize, *const T) -> c_int;
        type V3<T> = unsafe extern "C" fn(*mut c_void, *const u32, usize, *const T, usize) -> c_int;
        let (component, count) = (self.component.as_ptr(), references.len());
        let (references, length, from) = (references.as_ptr(), values.len(), values.as_ptr());
        assert!(self.fmi == Fmi::V3 || count == length, "a value for each reference");
        // SAFETY: FMI's types; an instance of this library; both arrays are as long as said.
        let code = unsafe {
            match self.fmi {
                Fmi::V2 => self.function::<V2<T>>(call)?(component, references, count, from),
                Fmi::V3 => self.function::<V3<T>>(call)?(component, references, count, from, length),
            }
        };
        Ok(Answer { code, call })
    }

    /// From a time over a step, both \[s\]; nothing before that time is asked for any more.
    ///
    /// # Errors
    /// The FMU has returned early, or wants an event or the end.
    pub(crate) fn do_step(&self, time: f64, step: f64) -> Result<Answer> {
        match self.fmi {
            Fmi::V2 => v2::do_step(self, time, step),
            Fmi::V3 => v3::do_step(self, time, step),
        }
    }

    /// Sets structural parameters in Configuration Mode (FMI 3.0).
    ///
    /// # Errors
    /// The FMU lacks a function.
    pub(crate) fn configure(&self, references: &[u32], sizes: &[u64]) -> Result<Answer> {
        let answer = self.plain("fmi3EnterConfigurationMode")?;
        if answer.status() != Some(Status::Ok) {
            return Ok(answer);
        }
        let answer = self.set("fmi3SetUInt64", references, sizes)?;
        if answer.status() != Some(Status::Ok) {
            return Ok(answer);
        }
        self.plain("fmi3ExitConfigurationMode")
    }
}

/// A state that an instance holds for us, or none yet; given back when this is dropped.
pub(crate) struct Held {
    calls: Rc<Calls>,
    /// NULL, or of this instance.
    pointer: *mut c_void,
}

/// The type of `fmi2GetFMUstate` and `fmi2FreeFMUstate`.
type OfPointer = unsafe extern "C" fn(*mut c_void, *mut *mut c_void) -> c_int;

impl Drop for Held {
    fn drop(&mut self) {
        if !self.pointer.is_null() {
            // There is nobody to tell of a refusal.
            let _ = self.of_pointer(["fmi2FreeFMUstate", "fmi3FreeFMUState"]);
        }
    }
}

impl Held {
    pub(crate) fn none(calls: &Rc<Calls>) -> Held {
        Held { calls: calls.clone(), pointer: null_mut() }
    }

    fn of_pointer(&mut self, names: Names) -> Result<Answer> {
        let call = self.calls.name(names);
        // SAFETY: FMI's type; the pointer is NULL or a state of this instance, which lives.
        let code = unsafe {
            self.calls.function::<OfPointer>(call)?(self.calls.component.as_ptr(), &raw mut self.pointer)
        };
        Ok(Answer { code, call })
    }

    /// `fmi2GetFMUstate`
    pub(crate) fn take(&mut self) -> Result<Answer> {
        self.of_pointer(["fmi2GetFMUstate", "fmi3GetFMUState"])
    }

    /// `fmi2SetFMUstate`
    pub(crate) fn put(&self) -> Result<Answer> {
        type Set = unsafe extern "C" fn(*mut c_void, *mut c_void) -> c_int;
        self.is_there()?;
        let call = self.calls.name(["fmi2SetFMUstate", "fmi3SetFMUState"]);
        // SAFETY: FMI's type; a state of this instance.
        let code = unsafe { self.calls.function::<Set>(call)?(self.calls.component.as_ptr(), self.pointer) };
        Ok(Answer { code, call })
    }

    /// `fmi2SerializedFMUstateSize`: the size \[byte\].
    pub(crate) fn size(&self) -> Result<(Answer, usize)> {
        type Size = unsafe extern "C" fn(*mut c_void, *mut c_void, *mut usize) -> c_int;
        self.is_there()?;
        let call = self.calls.name(["fmi2SerializedFMUstateSize", "fmi3SerializedFMUStateSize"]);
        let (component, mut size) = (self.calls.component.as_ptr(), 0);
        // SAFETY: FMI's type; a state of this instance.
        let code = unsafe { self.calls.function::<Size>(call)?(component, self.pointer, &raw mut size) };
        Ok((Answer { code, call }, size))
    }

    /// `fmi2SerializeFMUstate`
    pub(crate) fn serialize(&self, bytes: &mut [u8]) -> Result<Answer> {
        type Serialize = unsafe extern "C" fn(*mut c_void, *mut c_void, *mut u8, usize) -> c_int;
        self.is_there()?;
        let call = self.calls.name(["fmi2SerializeFMUstate", "fmi3SerializeFMUState"]);
        let (component, size) = (self.calls.component.as_ptr(), bytes.len());
        // SAFETY: FMI's type; a state of this instance; the bytes are as many as said.
        let code = unsafe {
            self.calls.function::<Serialize>(call)?(component, self.pointer, bytes.as_mut_ptr(), size)
        };
        Ok(Answer { code, call })
    }

    /// `fmi2DeSerializeFMUstate`
    pub(crate) fn deserialize(&mut self, bytes: &[u8]) -> Result<Answer> {
        type Deserialize = unsafe extern "C" fn(*mut c_void, *const u8, usize, *mut *mut c_void) -> c_int;
        let call = self.calls.name(["fmi2DeSerializeFMUstate", "fmi3DeserializeFMUState"]);
        let (component, size) = (self.calls.component.as_ptr(), bytes.len());
        // SAFETY: FMI's type; the pointer is NULL or a state of this instance; the bytes are as many as said.
        let code = unsafe {
            self.calls.function::<Deserialize>(call)?(component, bytes.as_ptr(), size, &raw mut self.pointer)
        };
        Ok(Answer { code, call })
    }

    fn is_there(&self) -> Result<()> {
        if self.pointer.is_null() { Err(CallError::NoState) } else { Ok(()) }
    }
}

/// `what` is said of a text that holds a zero.
fn c_text(text: &str, what: impl FnOnce() -> String) -> Result<CString> {
    CString::new(text).map_err(|source| CallError::Zero { what: what(), source })
}

fn load(path: &Path) -> Result<Library> {
    if cfg!(all(target_os = "linux", target_pointer_width = "64")) {
        check_length(path)?;
    }
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

/// That a library of 64-bit Linux has a length: `dlopen` maps what lies behind the end of a file that is cut off, and
/// looks into it. The table of sections is the last thing that linkers write. What else is wrong is left to `dlopen`.
fn check_length(path: &Path) -> Result<()> {
    let mut header = [0; 64];
    let Ok(mut file) = File::open(path) else { return Ok(()) };
    let (Ok(()), Ok(metadata)) = (file.read_exact(&mut header), file.metadata()) else { return Ok(()) };
    // e_ident: ELF, of 64 bits
    if !header.starts_with(b"\x7fELF\x02") {
        return Ok(());
    }
    let (_, fields) = header.split_at(40);
    let sections = fields.first_chunk().map_or(0, |bytes| u64::from_ne_bytes(*bytes));
    // e_shentsize, e_shnum
    let [entry, entries] = [58, 60].map(|at| u64::from(u16::from_ne_bytes([header[at], header[at + 1]])));
    let (end, length) = (sections.saturating_add(entry * entries), metadata.len());
    if end > length { Err(CallError::CutOff { path: path.to_owned(), end, length }) } else { Ok(()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A loader that was given such a file got SIGBUS.
    #[test]
    #[cfg(target_os = "linux")]
    fn a_library_that_is_cut_off_is_an_error_at_every_length() {
        let whole = std::fs::read(crate::own_binary().unwrap().path).unwrap();
        let directory = tempfile::TempDir::new().unwrap();
        let path = directory.path().join("library.so");
        std::fs::write(&path, &whole).unwrap();
        assert!(load(&path).is_ok());
        let lengths = [0, 1, 63, 64, 4096, whole.len() - 1];
        for length in lengths.into_iter().chain((1..20).map(|part| whole.len() / 20 * part)) {
            std::fs::write(&path, &whole[..length]).unwrap();
            let said = crate::whole(&load(&path).unwrap_err());
            let expected = if length < 64 { "library.so: " } else { "library.so: is cut off: " };
            assert!(said.contains(expected), "{length}: {said}");
        }
    }

    #[test]
    fn a_status_that_fmi_does_not_know_is_told_as_a_number() {
        let said = |call| [0, 3, 5, 6, -1].map(|code| Answer { code, call }.to_string());
        let unknown = ["6, which is no status of FMI", "-1, which is no status of FMI"];
        assert_eq!(said("fmi2DoStep"), ["Ok", "Error", "Pending", unknown[0], unknown[1]]);
        assert_eq!(said("fmi3DoStep")[2], "5, which is no status of FMI");
    }
}
