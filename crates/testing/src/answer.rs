//! What the bodies of C functions return.

use lemons_fmi::Status;
use std::ffi::c_int;

/// What a body returns, as C sees it.
pub(crate) trait Answer {
    type OfC;

    fn answer(self) -> Self::OfC;
}

impl Answer for Status {
    type OfC = c_int;

    fn answer(self) -> c_int {
        self as c_int
    }
}

impl<T> Answer for *const T {
    type OfC = *const T;

    fn answer(self) -> *const T {
        self
    }
}

impl<T> Answer for *mut T {
    type OfC = *mut T;

    fn answer(self) -> *mut T {
        self
    }
}

impl Answer for () {
    type OfC = ();

    fn answer(self) {}
}
