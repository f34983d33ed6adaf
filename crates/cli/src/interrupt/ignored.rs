//! Actions of signals when the program starts.

use std::ffi::c_int;
use std::mem::MaybeUninit;

/// Returns whether whoever started the program lets it ignore a signal.
#[allow(unsafe_code)]
pub fn is_ignored(signal: c_int) -> bool {
    let mut action = MaybeUninit::<libc::sigaction>::uninit();
    // SAFETY: without a new action the call only asks; where it returns 0, it has filled in the one there is.
    unsafe {
        libc::sigaction(signal, std::ptr::null(), action.as_mut_ptr()) == 0
            && action.assume_init().sa_sigaction == libc::SIG_IGN
    }
}
