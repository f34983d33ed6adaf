//! Functions that FMUs call to tell something.

use crate::messages::{Messages, status_of};
use lemons_fmi::v2::CallbackFunctions;
use lemons_fmi::{Status, Version};
use std::ffi::{CStr, c_char, c_int, c_void};
use std::ptr::null;
use std::rc::Rc;
use std::sync::Arc;

/// The environment of `lemons_logger`.
#[repr(C)]
struct Listener {
    hear: unsafe extern "C" fn(*const Listener, c_int, *const c_char),
    messages: Arc<Messages>,
}

/// Callbacks and their environment, to which FMUs keep pointers.
pub(super) struct Logger {
    callbacks: Rc<CallbackFunctions>,
    listener: Rc<Listener>,
}

impl Logger {
    pub(super) fn new(messages: Arc<Messages>, memory_functions: bool) -> Logger {
        let listener = Rc::new(Listener { hear, messages });
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

    /// The callbacks of FMI 2.0.
    pub(super) fn callbacks(&self) -> *const CallbackFunctions {
        Rc::as_ptr(&self.callbacks)
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
    listener.messages.hear(status_of(Version::V2, status), &told(text.to_bytes()));
}

/// `fmi3LogMessageCallback`: a message is a text, without arguments.
///
/// # Safety
/// The environment is a listener that lives, the message ends in a zero.
pub(super) unsafe extern "C" fn log_3(
    environment: *mut c_void,
    status: c_int,
    _: *const c_char,
    message: *const c_char,
) {
    if environment.is_null() || message.is_null() {
        return;
    }
    // SAFETY: as said above, and not NULL.
    let (listener, text) = unsafe { (&*environment.cast::<Listener>(), CStr::from_ptr(message)) };
    let text = &text.to_bytes()[..text.count_bytes().min(LONGEST)];
    listener.messages.hear(status_of(Version::V3, status), &told(text));
}

/// A number sign in a message is doubled (FMI 2.0.5, section 2.1.5; FMI 3.0, section 2.3.1).
fn told(text: &[u8]) -> String {
    String::from_utf8_lossy(text).replace("##", "#")
}

/// \[byte\] Of a message; the rest is cut off.
const LONGEST: usize = 1_000_000;

#[cfg(test)]
mod tests {
    use super::*;
    use std::ptr::null_mut;

    /// Returns what is heard when an FMU tells something.
    fn heard(tell: impl FnOnce(*mut c_void)) -> Arc<Messages> {
        let messages = Arc::<Messages>::default();
        tell(Logger::new(messages.clone(), false).environment());
        messages
    }

    #[test]
    fn what_an_fmu_tells_is_formatted_as_printf_does() {
        let messages = heard(|environment| {
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
        assert_eq!(
            (messages.errors(), messages.warnings()),
            (vec!["this is 7 of 0.50 %".into()], vec!["\u{fffd} plain".into()])
        );
    }

    #[test]
    fn an_endless_message_is_cut() {
        let messages = heard(|environment| {
            // SAFETY: a width and its argument.
            unsafe {
                let (format, width) = (c"%*d".as_ptr(), 50_000_000 as c_int);
                lemons_logger(environment, null(), Status::Error, null(), format, width, 1 as c_int);
            }
        });
        assert_eq!(messages.errors()[0].len(), 1_000_000);
    }
}
