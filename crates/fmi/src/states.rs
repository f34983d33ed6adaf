//! The states that importers hold.
//!
//! A state's pointer is a number that is given once in the life of the library, and never dereferenced. So a pointer that
//! is not a state, or one that was freed, is an error and not a crash: some importers free states by a wrong pointer.
//! A state may be restored in any instance of the library, also after the one that saved it was freed.

use std::any::Any;
use std::collections::BTreeMap;
use std::ffi::c_void;
use std::ptr::without_provenance_mut;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

type State = Arc<dyn Any + Send + Sync>;

/// Without states it owns no memory, so nothing is left when the library is unloaded.
struct Held {
    /// The last number that was given.
    last: usize,
    states: BTreeMap<usize, State>,
}

static HELD: Mutex<Held> = Mutex::new(Held { last: 0, states: BTreeMap::new() });

fn held() -> MutexGuard<'static, Held> {
    HELD.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A pointer that is not that of a state.
#[derive(Debug, PartialEq, Eq, thiserror::Error)]
#[error("FMUstate is not a state of this instance, or it was freed")]
pub(crate) struct Unknown;

/// Keeps a new state, or another one in place of an old one.
pub(crate) fn put<S: Send + Sync + 'static>(place: &mut *mut c_void, state: S) -> Result<(), Unknown> {
    let (mut held, state) = (held(), Arc::new(state));
    if place.is_null() {
        held.last += 1;
        let number = held.last;
        held.states.insert(number, state);
        *place = without_provenance_mut(number);
        return Ok(());
    }
    *held.states.get_mut(&place.addr()).ok_or(Unknown)? = state;
    Ok(())
}

/// Returns a state.
pub(crate) fn get<S: Send + Sync + 'static>(pointer: *mut c_void) -> Result<Arc<S>, Unknown> {
    let state = held().states.get(&pointer.addr()).cloned().ok_or(Unknown)?;
    state.downcast().map_err(|_| Unknown)
}

/// Frees a state; NULL is fine. The pointer is NULL afterwards.
pub(crate) fn free(place: &mut *mut c_void) -> Result<(), Unknown> {
    if !place.is_null() {
        let mut held = held();
        let state = held.states.remove(&place.addr()).ok_or(Unknown)?;
        if held.states.is_empty() {
            // An emptied map still owns memory.
            held.states = BTreeMap::new();
        }
        drop(held);
        drop(state);
        *place = std::ptr::null_mut();
    }
    Ok(())
}
