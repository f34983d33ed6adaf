//! The C functions of FMI as an importer calls them: an FMU's shared library, and one instance of it.
//!
//! The library is trusted as any program that one starts: it must keep FMI's contract. What Rust can see of it is
//! checked: its symbols, NULL, the status it answers, the text it tells.

#![allow(unsafe_code)] // the C boundary, from its other side

mod location;
mod logger;
mod signatures;
mod values;

pub use values::FmiValue;

use crate::error::{ErrorPlace, MasterError, Result, require};
use crate::messages::{Messages, prefix};
use crate::ssp::{FmiType, Interface};
use lemons_fmi::{Status, Version};
use libloading::Library;
use location::{file_uri, path_text};
use logger::Logger;
use signatures::{
    fmi2DeSerializeFMUstate, fmi2DoStep, fmi2FreeInstance, fmi2GetFMUstate, fmi2Instantiate,
    fmi2SerializeFMUstate, fmi2SerializedFMUstateSize, fmi2SetFMUstate, fmi2SetupExperiment, fmi2Terminate,
    fmi3DoStep, fmi3EnterInitializationMode, fmi3InstantiateCoSimulation,
};
use std::cell::{Cell, RefCell};
use std::ffi::{CStr, CString, c_int, c_uint, c_void};
use std::path::Path;
use std::ptr::{NonNull, null, null_mut};
use std::sync::Arc;

/// \[byte\] The largest state, and the largest sum of those of all components, which are held in memory: some ten times
/// that of 100 000 agents in contact.
pub const LARGEST_STATE: usize = 1_000_000_000;

/// Returns the functions that every FMU for co-simulation must have, of those that are called here. In FMI 3.0 it may lack
/// those of types that it has not.
fn required(version: Version) -> impl Iterator<Item = String> {
    let all = "FreeInstance EnterInitializationMode ExitInitializationMode Terminate DoStep";
    let own = match version {
        Version::V2 => {
            "Instantiate SetupExperiment GetReal SetReal GetInteger SetInteger GetBoolean SetBoolean GetString SetString"
        }
        Version::V3 => "InstantiateCoSimulation",
    };
    all.split(' ').chain(own.split(' ')).map(move |name| prefix(version).to_owned() + name)
}

/// `fmi2CoSimulation`
const CO_SIMULATION: c_int = 1;
const FALSE: c_int = 0;
const TRUE: c_int = 1;

/// A function of a library, by its name.
///
/// # Safety
/// `F` is the type that FMI gives it, and it is used no longer than the library lives.
unsafe fn function<F: Copy>(library: &Library, name: &str) -> Result<F> {
    // SAFETY: the caller's.
    let symbol = unsafe { library.get::<F>(name) };
    Ok(*symbol.map_err(|_| MasterError::new(format!("the FMU has no function {name}")))?)
}

/// Values that are set when an instance is in initialization.
type Later = Box<dyn FnOnce(&FmuInstance) -> Result<()>>;

/// An instance of an FMU. It is freed when this is dropped, before its library is unloaded.
pub struct FmuInstance {
    component: NonNull<c_void>,
    pub(crate) description: Arc<Interface>,
    messages: Arc<Messages>,
    /// True once initialization has begun.
    pub(crate) initialized: Cell<bool>,
    /// Arrays: not every FMU lets their other elements be read before initialization.
    pub(crate) later: RefCell<Vec<Later>>,
    // FMUs keep pointers to it.
    _logger: Logger,
    library: Library,
}

impl Drop for FmuInstance {
    fn drop(&mut self) {
        // SAFETY: FMI's type; an instance of this library, freed once.
        unsafe {
            if let Ok(free) = function::<fmi2FreeInstance>(&self.library, &self.name("FreeInstance")) {
                free(self.component.as_ptr());
            }
        }
    }
}

impl FmuInstance {
    /// Loads a library and instantiates its FMU for co-simulation. The FMU's directory `resources` need not exist.
    ///
    /// # Errors
    /// The library cannot be loaded or is none of an FMU; or the FMU refuses.
    pub(crate) fn new(
        description: Arc<Interface>,
        library: &Path,
        resources: &Path,
        name: &str,
        messages: Arc<Messages>,
    ) -> Result<FmuInstance> {
        let Interface { fmi, guid, co_simulation, .. } = &*description;
        let name = c_text(name, || format!("instance name={name:?}"))?;
        let guid = c_text(guid, || format!("guid={guid:?}"))?;
        let place = if *fmi == Version::V2 { file_uri } else { path_text };
        let resources = resources.is_dir().then(|| place(resources)).transpose()?;
        let resources = resources.as_deref().map_or(null(), CStr::as_ptr);
        let library = load(library)?;
        for name in required(*fmi) {
            // SAFETY: it is not called.
            let found = unsafe { library.get::<fmi2Terminate>(&name) };
            found.place(|| format!("has no function {name}"))?;
        }
        let alone = co_simulation.as_ref().is_some_and(|own| own.cannot_use_memory_functions);
        let logger = Logger::new(messages.clone(), !alone);
        let (name, guid) = (name.as_ptr(), guid.as_ptr());
        // With logging: else an FMU tells no warnings; what it tells with the status Ok is not kept.
        // SAFETY: FMI's types and arguments; the callbacks and their environment live as long as the instance.
        let (call, component) = unsafe {
            match fmi {
                Version::V2 => {
                    let instantiate = function::<fmi2Instantiate>(&library, "fmi2Instantiate")?;
                    let callbacks = logger.callbacks();
                    let own = instantiate(name, CO_SIMULATION, guid, resources, callbacks, FALSE, TRUE);
                    ("fmi2Instantiate", own)
                }
                Version::V3 => {
                    let call = "fmi3InstantiateCoSimulation";
                    let instantiate = function::<fmi3InstantiateCoSimulation>(&library, call)?;
                    let (to, log) = (logger.environment(), Some(logger::log_3 as _));
                    // Without Event Mode, early return and intermediate updates.
                    let none = (null(), 0);
                    let own = instantiate(
                        name, guid, resources, false, true, false, false, none.0, none.1, to, log, None,
                    );
                    (call, own)
                }
            }
        };
        let component =
            NonNull::new(component).ok_or_else(|| MasterError::new(format!("{call} returned NULL")))?;
        let (initialized, later) = (Cell::new(false), RefCell::default());
        Ok(FmuInstance { component, description, messages, initialized, later, _logger: logger, library })
    }

    fn version(&self) -> Version {
        self.description.fmi
    }

    /// Returns the name of a function, without its prefix as in FMI 3.0, in the FMU's version.
    fn name(&self, name: &str) -> String {
        let name = prefix(self.version()).to_owned() + name;
        match self.version() {
            Version::V2 => name.replace("FMUState", "FMUstate").replace("Deserialize", "DeSerialize"),
            Version::V3 => name,
        }
    }

    /// Returns the name of the function that gets or sets values of a type.
    fn accessor(&self, verb: &str, of: FmiType) -> String {
        let of = match (self.version(), of) {
            (Version::V2, FmiType::Enumeration) => FmiType::Integer,
            (Version::V3, FmiType::Enumeration) => FmiType::Int64,
            (_, of) => of,
        };
        self.name(&format!("{verb}{of}"))
    }

    /// Calls a function of the library, which gets the instance first. A refusal is an error.
    ///
    /// # Safety
    /// `F` is the type that FMI gives to the function.
    unsafe fn call<F: Copy>(&self, call: &str, with: impl FnOnce(F, *mut c_void) -> c_int) -> Result<Status> {
        // SAFETY: the caller's.
        let function = unsafe { function::<F>(&self.library, call)? };
        self.messages.done(self.version(), call, with(function, self.component.as_ptr()))
    }

    /// Calls a function that takes the instance only.
    fn plain(&self, name: &str) -> Result<()> {
        // SAFETY: FMI's type; an instance of this library.
        unsafe { self.call(&self.name(name), |run: fmi2Terminate, own| run(own)) }.map(drop)
    }

    /// Sets structural parameters, in Configuration Mode (FMI 3.0).
    pub(crate) fn configure(&self, references: &[u32], sizes: &[u64]) -> Result<()> {
        if references.is_empty() {
            return Ok(());
        }
        self.plain("EnterConfigurationMode")?;
        self.set_all(FmiType::UInt64, references, sizes)?;
        self.plain("ExitConfigurationMode")
    }

    /// `fmi2SetupExperiment` at a time \[s\] and `fmi2EnterInitializationMode`, or `fmi3EnterInitializationMode`; then
    /// elements of arrays are set that were set before. The tolerance is this one, else that of the FMU's own
    /// DefaultExperiment, if there is one.
    ///
    /// # Errors
    /// The FMU refuses the call.
    pub fn enter_initialization(&self, start: f64, tolerance: Option<f64>) -> Result<()> {
        let tolerance = tolerance.or(self.description.tolerance);
        let (defined, tolerance) = (tolerance.is_some(), tolerance.unwrap_or(0.0));
        // SAFETY: FMI's types; an instance of this library.
        unsafe {
            match self.version() {
                Version::V2 => self.call("fmi2SetupExperiment", |set_up: fmi2SetupExperiment, own| {
                    set_up(own, defined.into(), tolerance, start, FALSE, 0.0)
                }),
                Version::V3 => {
                    self.call("fmi3EnterInitializationMode", |enter: fmi3EnterInitializationMode, own| {
                        enter(own, defined, tolerance, start, false, 0.0)
                    })
                }
            }
        }?;
        if self.version() == Version::V2 {
            self.plain("EnterInitializationMode")?;
        }
        self.initialized.set(true);
        let later = std::mem::take(&mut *self.later.borrow_mut());
        later.into_iter().try_for_each(|set| set(self))
    }

    /// `fmi2ExitInitializationMode`, `fmi3ExitInitializationMode`
    ///
    /// # Errors
    /// The FMU refuses the call.
    pub fn exit_initialization(&self) -> Result<()> {
        self.plain("ExitInitializationMode")
    }

    /// `fmi2Terminate`, `fmi3Terminate`
    ///
    /// # Errors
    /// The FMU refuses the call.
    pub fn terminate(&self) -> Result<()> {
        self.plain("Terminate")
    }

    /// Returns the warnings of the FMU since the last call: the first 1000, the number of further ones, and the time \[s\] of
    /// the first step that returned the status Warning.
    pub fn warnings(&self) -> Vec<String> {
        self.messages.warnings()
    }

    /// Reads all values of the variables: in FMI 2.0 one for each reference.
    fn get_all<T>(&self, of: FmiType, references: &[u32], mut values: Vec<T>) -> Result<Vec<T>> {
        // SAFETY: a function that writes as many values as said.
        unsafe { self.pass("Get", of, references, values.as_mut_ptr(), values.len()) }?;
        Ok(values)
    }

    /// Sets all values of the variables: in FMI 2.0 one for each reference.
    fn set_all<T>(&self, of: FmiType, references: &[u32], values: &[T]) -> Result<()> {
        // SAFETY: a function that reads as many values as said, and writes none.
        unsafe { self.pass("Set", of, references, values.as_ptr().cast_mut(), values.len()) }
    }

    /// # Safety
    /// An array of as many values as said, which have this type.
    unsafe fn pass<T>(
        &self,
        verb: &str,
        of: FmiType,
        references: &[u32],
        values: *mut T,
        length: usize,
    ) -> Result<()> {
        type V2<T> = unsafe extern "C" fn(*mut c_void, *const c_uint, usize, *mut T) -> c_int;
        type V3<T> = unsafe extern "C" fn(*mut c_void, *const u32, usize, *mut T, usize) -> c_int;
        let (call, count, references) = (self.accessor(verb, of), references.len(), references.as_ptr());
        assert!(self.version() == Version::V3 || count == length, "a value for each reference");
        // SAFETY: FMI's types; an instance of this library; both arrays are as long as said.
        unsafe {
            match self.version() {
                Version::V2 => self.call(&call, |run: V2<T>, own| run(own, references, count, values)),
                Version::V3 => {
                    self.call(&call, |run: V3<T>, own| run(own, references, count, values, length))
                }
            }
        }
        .map(drop)
    }

    /// Makes a step from a time, both \[s\]; nothing before that time is asked for any more.
    ///
    /// # Errors
    /// The FMU refuses the step or fails; in FMI 3.0 also if it has returned early, wants an event, or the end of the
    /// simulation.
    pub fn step(&self, time: f64, step: f64) -> Result<()> {
        // The FMU might write something else than a `bool` is.
        let (mut event, mut end, mut early, mut last) = (0_u8, 0_u8, 0_u8, f64::NAN);
        let flags = [&raw mut event, &raw mut end, &raw mut early].map(<*mut u8>::cast);
        // SAFETY: FMI's types; an instance of this library; it is told where all four go.
        let status = unsafe {
            match self.version() {
                Version::V2 => {
                    self.call("fmi2DoStep", |do_step: fmi2DoStep, own| do_step(own, time, step, TRUE))
                }
                Version::V3 => self.call("fmi3DoStep", |do_step: fmi3DoStep, own| {
                    do_step(own, time, step, true, flags[0], flags[1], flags[2], &raw mut last)
                }),
            }
        }?;
        let within = format!("at t = {last:?} s, within the step from {time:?} s over {step:?} s");
        let why = match (end, event, early) {
            (0, 0, 0) => {
                if status == Status::Warning {
                    self.messages.warned(time, self.version());
                }
                return Ok(());
            }
            (0, 0, _) => format!("the FMU has returned {within}"),
            (0, ..) => format!("the FMU wants Event Mode at t = {last:?} s, which this master has not"),
            _ => format!("the FMU ends the simulation {within}"),
        };
        Err(MasterError::new(format!("fmi3DoStep: {why}")))
    }

    /// Returns the present state as bytes: `fmi2GetFMUstate`, `fmi2SerializeFMUstate`.
    ///
    /// # Errors
    /// The FMU refuses a call, or the state is too large for the memory.
    pub fn state(&self) -> Result<Vec<u8>> {
        let mut state = State { instance: self, pointer: null_mut() };
        state.hand("GetFMUState")?;
        let (pointer, mut size) = (state.there()?, 0_usize);
        let call = self.name("SerializedFMUStateSize");
        // SAFETY: FMI's type; a state of this instance.
        unsafe { self.call(&call, |run: fmi2SerializedFMUstateSize, own| run(own, pointer, &raw mut size)) }?;
        require(size <= LARGEST_STATE, || {
            format!("{call} returned {size} bytes, more than {LARGEST_STATE}")
        })?;
        let mut bytes = Vec::new();
        bytes.try_reserve_exact(size).place(|| format!("a state of {size} bytes"))?;
        bytes.resize(size, 0_u8);
        let call = self.name("SerializeFMUState");
        // SAFETY: FMI's type; a state of this instance; the bytes are as many as said.
        unsafe {
            self.call(&call, |run: fmi2SerializeFMUstate, own| run(own, pointer, bytes.as_mut_ptr(), size))
        }?;
        Ok(bytes)
    }

    /// Goes to a state: `fmi2DeSerializeFMUstate`, `fmi2SetFMUstate`.
    ///
    /// # Errors
    /// Bytes that are none of such an FMU, or its refusal.
    pub fn restore(&self, bytes: &[u8]) -> Result<()> {
        let mut state = State { instance: self, pointer: null_mut() };
        let (call, to) = (self.name("DeserializeFMUState"), &raw mut state.pointer);
        // SAFETY: FMI's type; the pointer is NULL; the bytes are as many as said.
        unsafe {
            self.call(&call, |run: fmi2DeSerializeFMUstate, own| run(own, bytes.as_ptr(), bytes.len(), to))
        }?;
        let pointer = state.there()?;
        // SAFETY: FMI's type; a state of this instance.
        unsafe { self.call(&self.name("SetFMUState"), |run: fmi2SetFMUstate, own| run(own, pointer)) }
            .map(drop)
    }
}

/// A state that an instance holds for us, or none yet; given back when this is dropped.
struct State<'a> {
    instance: &'a FmuInstance,
    /// NULL, or of this instance.
    pointer: *mut c_void,
}

impl Drop for State<'_> {
    fn drop(&mut self) {
        if !self.pointer.is_null() {
            // There is nobody to tell of a refusal.
            let _ = self.hand("FreeFMUState");
        }
    }
}

impl State<'_> {
    /// Calls a function that makes the state, or takes it back.
    fn hand(&mut self, name: &str) -> Result<Status> {
        let (call, to) = (self.instance.name(name), &raw mut self.pointer);
        // SAFETY: FMI's type; the pointer is NULL or a state of this instance.
        unsafe { self.instance.call(&call, |run: fmi2GetFMUstate, own| run(own, to)) }
    }

    fn there(&self) -> Result<*mut c_void> {
        require(!self.pointer.is_null(), || "the FMU gave no state")?;
        Ok(self.pointer)
    }
}

/// `what` is said of a text that holds a zero.
fn c_text(text: &str, what: impl FnOnce() -> String) -> Result<CString> {
    CString::new(text).place(what)
}

fn load(path: &Path) -> Result<Library> {
    let cannot = |error: libloading::Error| MasterError::new(error.to_string());
    // SAFETY: what a library does when it is loaded is the FMU's; see the module.
    #[cfg(not(windows))]
    return unsafe { Library::new(path) }.map_err(cannot);
    #[cfg(windows)]
    {
        use libloading::os::windows;
        // With the libraries that lie beside it. Windows wants an absolute path with backslashes for that.
        let flags = windows::LOAD_WITH_ALTERED_SEARCH_PATH;
        let path = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
        // SAFETY: as above.
        Ok(unsafe { windows::Library::load_with_flags(path, flags) }.map_err(cannot)?.into())
    }
}
