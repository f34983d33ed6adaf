//! The C functions of FMI 2.0.

use super::{Answer, CallError, Calls, Hears, Result, c_text, function};
use lemons_fmi::Status;
use lemons_fmi::v2::CallbackFunctions;
use libloading::Library;
use percent_encoding::{AsciiSet, NON_ALPHANUMERIC, percent_encode};
use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::path::Path;
use std::ptr::null;
use std::rc::Rc;

/// What `lemons_logger` gets as its environment.
#[repr(C)]
pub(super) struct Listener {
    hear: unsafe extern "C" fn(*const Listener, c_int, *const c_char),
    pub(super) hears: Box<Hears>,
}

/// What FMUs keep pointers to.
pub(super) struct Logger {
    callbacks: Rc<CallbackFunctions>,
    listener: Rc<Listener>,
}

impl Logger {
    pub(super) fn new(hears: Box<Hears>, memory_functions: bool) -> Logger {
        let listener = Rc::new(Listener { hear, hears });
        let memory = |function: *const c_void| if memory_functions { function } else { null() };
        let callbacks = Rc::new(CallbackFunctions {
            logger: Some(lemons_logger),
            allocate_memory: memory(libc::calloc as *const c_void),
            free_memory: memory(libc::free as *const c_void),
            step_finished: null(),
            component_environment: Rc::as_ptr(&listener).cast_mut().cast(),
        });
        Logger { callbacks, listener }
    }

    /// A [`Listener`].
    pub(super) fn environment(&self) -> *mut c_void {
        Rc::as_ptr(&self.listener).cast_mut().cast()
    }
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
    let status = Answer { code: status, call: "fmi2CallbackLogger" }.status();
    // A number sign in a message is doubled (FMI 2.0.5, section 2.1.5).
    (listener.hears)(status, &text.to_string_lossy().replace("##", "#"));
}

/// `fmi2CoSimulation`
const CO_SIMULATION: c_int = 1;
const FALSE: c_int = 0;
const TRUE: c_int = 1;

/// A pointer to the instance or NULL, and the name of the function.
pub(super) fn instantiate(
    library: &Library,
    name: &CStr,
    guid: &CStr,
    resources: Option<&CStr>,
    logger: &Logger,
) -> Result<(*mut c_void, &'static str)> {
    type Instantiate = unsafe extern "C" fn(
        *const c_char,
        c_int,
        *const c_char,
        *const c_char,
        *const CallbackFunctions,
        c_int,
        c_int,
    ) -> *mut c_void;
    let call = "fmi2Instantiate";
    let resources = resources.map_or(null(), CStr::as_ptr);
    let callbacks = Rc::as_ptr(&logger.callbacks);
    // SAFETY: FMI's type and arguments; the callbacks and their environment live as long as the instance.
    let component = unsafe {
        let instantiate = function::<Instantiate>(library, call)?;
        // With logging: else an FMU tells no warnings; what it tells with the status `fmi2OK` is not kept.
        instantiate(name.as_ptr(), CO_SIMULATION, guid.as_ptr(), resources, callbacks, FALSE, TRUE)
    };
    Ok((component, call))
}

pub(super) fn enter_initialization(calls: &Calls, start: f64, tolerance: Option<f64>) -> Result<Answer> {
    type SetupExperiment = unsafe extern "C" fn(*mut c_void, c_int, f64, f64, c_int, f64) -> c_int;
    let call = "fmi2SetupExperiment";
    let (component, defined) = (calls.component.as_ptr(), c_int::from(tolerance.is_some()));
    // SAFETY: FMI's type; an instance of this library.
    let code = unsafe {
        let setup = calls.function::<SetupExperiment>(call)?;
        setup(component, defined, tolerance.unwrap_or(0.0), start, FALSE, 0.0)
    };
    let answer = Answer { code, call };
    if answer.succeeded() { calls.plain("fmi2EnterInitializationMode") } else { Ok(answer) }
}

pub(super) fn do_step(calls: &Calls, time: f64, step: f64) -> Result<Answer> {
    type DoStep = unsafe extern "C" fn(*mut c_void, f64, f64, c_int) -> c_int;
    let call = "fmi2DoStep";
    // SAFETY: FMI's type; an instance of this library.
    let code = unsafe { calls.function::<DoStep>(call)?(calls.component.as_ptr(), time, step, TRUE) };
    Ok(Answer { code, call })
}

/// What stands for itself in the path of an URI.
const ENCODED: &AsciiSet = &NON_ALPHANUMERIC.remove(b'-').remove(b'.').remove(b'_').remove(b'~').remove(b'/');

/// `file:///…/`, as FMI 2.0 wants it.
pub(super) fn file_uri(directory: &Path) -> Result<CString> {
    let unknown = |source| CallError::Resources { path: directory.to_owned(), source };
    let path = std::path::absolute(directory).map_err(unknown)?;
    let uri = uri_of(path.as_os_str().as_encoded_bytes(), cfg!(windows));
    c_text(&uri, || uri.clone())
}

/// Of an absolute path.
fn uri_of(path: &[u8], windows: bool) -> String {
    let encoded = |path: &[u8]| {
        let text = percent_encode(path, ENCODED).to_string();
        text.trim_end_matches('/').to_owned()
    };
    if !windows {
        return format!("file://{}/", encoded(path));
    }
    // What tells Windows to take a path as it is stands before a drive, or before the name of a machine.
    let share = path
        .strip_prefix(br"\\?\UNC\")
        .or_else(|| path.strip_prefix(br"\\").filter(|rest| !rest.starts_with(b"?")));
    let plain = share.or_else(|| path.strip_prefix(br"\\?\")).unwrap_or(path);
    let slashes: Vec<u8> = plain.iter().map(|&byte| if byte == b'\\' { b'/' } else { byte }).collect();
    // The colon of the drive stands for itself.
    let encoded = encoded(&slashes).replacen("%3A", ":", 1);
    if share.is_some() { format!("file://{encoded}/") } else { format!("file:///{encoded}/") }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lemons_fmi::Status;
    use std::ptr::null_mut;
    use std::sync::{Arc, Mutex};

    /// What is heard when an FMU tells something.
    fn heard(tell: impl FnOnce(*mut c_void)) -> Vec<(Option<Status>, String)> {
        let all = Arc::new(Mutex::new(Vec::new()));
        let list = all.clone();
        let hears: Box<Hears> =
            Box::new(move |status, text| list.lock().unwrap().push((status, text.to_owned())));
        let heard = Logger::new(hears, false);
        tell(heard.environment());
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
    fn a_path_of_windows_is_named_by_an_uri() {
        let said = |path: &str| uri_of(path.as_bytes(), true);
        assert_eq!(said(r"C:\Users\Jürgen\a b%\x"), "file:///C:/Users/J%C3%BCrgen/a%20b%25/x/");
        assert_eq!(said(r"\\?\C:\Users\x\"), "file:///C:/Users/x/");
        assert_eq!(said(r"\\server\share\x"), "file://server/share/x/");
        assert_eq!(said(r"\\?\UNC\server\share\x"), "file://server/share/x/");
    }
}
