//! The C functions of FMI 3.0.

use super::v2::{Listener, Logger};
use super::{Answer, CallError, Calls, Result, c_text, function};
use libloading::Library;
use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::path::{MAIN_SEPARATOR, Path};
use std::ptr::null;

/// `fmi3LogMessageCallback`: a message is a text, without arguments.
///
/// # Safety
/// The environment is a listener that lives, the message ends in a zero.
unsafe extern "C" fn log(environment: *mut c_void, status: c_int, _: *const c_char, message: *const c_char) {
    if environment.is_null() || message.is_null() {
        return;
    }
    // SAFETY: as said above, and not NULL.
    let (listener, text) = unsafe { (&*environment.cast::<Listener>(), CStr::from_ptr(message)) };
    let status = Answer { code: status, call: "fmi3LogMessageCallback" }.status();
    let text = text.to_bytes();
    (listener.hears)(status, &String::from_utf8_lossy(&text[..text.len().min(LONGEST)]));
}

/// \[byte\] Of a message; the rest is cut off.
const LONGEST: usize = 1_000_000;

/// A pointer to the instance or NULL, and the name of the function.
pub(super) fn instantiate(
    library: &Library,
    name: &CStr,
    token: &CStr,
    resources: Option<&CStr>,
    logger: &Logger,
) -> Result<(*mut c_void, &'static str)> {
    type LogMessage = unsafe extern "C" fn(*mut c_void, c_int, *const c_char, *const c_char);
    type Instantiate = unsafe extern "C" fn(
        *const c_char,
        *const c_char,
        *const c_char,
        bool,
        bool,
        bool,
        bool,
        *const u32,
        usize,
        *mut c_void,
        Option<LogMessage>,
        *const c_void,
    ) -> *mut c_void;
    let call = "fmi3InstantiateCoSimulation";
    let resources = resources.map_or(null(), CStr::as_ptr);
    // SAFETY: FMI's type and arguments; the environment lives as long as the instance.
    let component = unsafe {
        function::<Instantiate>(library, call)?(
            name.as_ptr(),
            token.as_ptr(),
            resources,
            false,
            // Else an FMU tells no warnings; what it tells with the status `fmi3OK` is not kept.
            true,
            // Without Event Mode, early return and intermediate updates.
            false,
            false,
            null(),
            0,
            logger.environment(),
            Some(log),
            null(),
        )
    };
    Ok((component, call))
}

pub(super) fn enter_initialization(calls: &Calls, start: f64, tolerance: Option<f64>) -> Result<Answer> {
    type Enter = unsafe extern "C" fn(*mut c_void, bool, f64, f64, bool, f64) -> c_int;
    let call = "fmi3EnterInitializationMode";
    let (component, defined) = (calls.component.as_ptr(), tolerance.is_some());
    // SAFETY: FMI's type; an instance of this library.
    let code = unsafe {
        let enter = calls.function::<Enter>(call)?;
        enter(component, defined, tolerance.unwrap_or(0.0), start, false, 0.0)
    };
    Ok(Answer { code, call })
}

pub(super) fn do_step(calls: &Calls, time: f64, step: f64) -> Result<Answer> {
    type DoStep =
        unsafe extern "C" fn(*mut c_void, f64, f64, bool, *mut u8, *mut u8, *mut u8, *mut f64) -> c_int;
    let call = "fmi3DoStep";
    let (mut event, mut end, mut early, mut last) = (0, 0, 0, f64::NAN);
    // SAFETY: FMI's type; an instance of this library; it is told where all four go.
    let code = unsafe {
        calls.function::<DoStep>(call)?(
            calls.component.as_ptr(),
            time,
            step,
            true,
            &raw mut event,
            &raw mut end,
            &raw mut early,
            &raw mut last,
        )
    };
    let answer = Answer { code, call };
    if !answer.succeeded() {
        return Ok(answer);
    }
    let within = format!("at t = {last:?} s, within the step from {time:?} s over {step:?} s");
    let why = if end != 0 {
        format!("the FMU ends the simulation {within}")
    } else if event != 0 {
        format!("the FMU wants Event Mode at t = {last:?} s, which this master has not")
    } else if early != 0 {
        format!("the FMU has returned {within}")
    } else {
        return Ok(answer);
    };
    Err(CallError::Ended { call, why })
}

/// The directory, with a separator at its end, as FMI 3.0 wants it.
pub(super) fn path(directory: &Path) -> Result<CString> {
    let unknown = |source| CallError::Resources { path: directory.to_owned(), source };
    let path = std::path::absolute(directory).map_err(unknown)?;
    let text = path.to_str().ok_or_else(|| unknown(std::io::ErrorKind::InvalidFilename.into()))?;
    let text = format!("{}{MAIN_SEPARATOR}", text.trim_end_matches(MAIN_SEPARATOR));
    c_text(&text, || text.clone())
}
