//! How a page asks, through the memory of WebAssembly.
//!
//! The worker, or the page, calls [`lab_room`] and writes a request there: its length as JSON (4 bytes, little-endian),
//! the JSON, and further bytes. [`lab_ask`] answers and returns where: the length of the answer is at [`lab_length`]. It
//! is built in the same way; its JSON is `{"ok": …}` or `{"refused": …}` with a message. While people are placed, it calls `lab_progress` of the
//! module `page`, which returns whether to stop.

use crate::{Lab, Refused, Reply, Request};
use lemons_core::files::words::shortened;
use lemons_core::message::Message;
use lemons_people::placing::PlacingProgress;
use serde_json::{Value, json};
use std::cell::RefCell;
use std::ops::ControlFlow;

#[derive(Default)]
struct Exchange {
    lab: Lab,
    request: Vec<u8>,
    answer: Vec<u8>,
}

thread_local! {
    static EXCHANGE: RefCell<Exchange> = RefCell::default();
}

/// Makes room for a request of `length` bytes and returns its place.
#[allow(unsafe_code)] // A name for the page: no other library is linked to it.
#[unsafe(no_mangle)]
pub extern "C" fn lab_room(length: usize) -> *mut u8 {
    EXCHANGE.with_borrow_mut(|exchange| {
        exchange.request = vec![0; length];
        exchange.request.as_mut_ptr()
    })
}

/// Answers the request and returns the place of the answer.
#[allow(unsafe_code)] // As above.
#[unsafe(no_mangle)]
pub extern "C" fn lab_ask() -> *const u8 {
    EXCHANGE.with_borrow_mut(|exchange| {
        let request = std::mem::take(&mut exchange.request);
        exchange.answer = answer(&mut exchange.lab, &request, &mut |progress| {
            let (iteration, limit) = (progress.iteration as f64, progress.limit as f64);
            let stop =
                lab_progress(number_of(progress), iteration, limit, progress.overlap, progress.density);
            if stop == 0 { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
        });
        exchange.answer.as_ptr()
    })
}

/// Returns the length of the answer.
#[allow(unsafe_code)] // As above.
#[unsafe(no_mangle)]
pub extern "C" fn lab_length() -> usize {
    EXCHANGE.with_borrow(|exchange| exchange.answer.len())
}

/// Answers a request as it lies in memory.
pub fn answer(lab: &mut Lab, request: &[u8], watch: &mut lemons_people::placing::Watch) -> Vec<u8> {
    let reply = match parts(request) {
        Ok((request, bytes)) => lab.answer(&request, bytes, watch).map_err(|Refused(why)| why),
        Err(error) => Err(error.into()),
    };
    match reply {
        Ok(Reply { value, bytes }) => joined(&json!({ "ok": value }), &bytes),
        Err(why) => {
            let text = shortened(&why.text).into_owned();
            joined(&json!({ "refused": Message { text, ..why } }), &[])
        }
    }
}

fn parts(request: &[u8]) -> Result<(Request, &[u8]), String> {
    let cut = "the request is cut off";
    let (length, rest) = request.split_first_chunk().ok_or(cut)?;
    let (text, bytes) = rest.split_at_checked(u32::from_le_bytes(*length) as usize).ok_or(cut)?;
    let request = serde_json::from_slice(text).map_err(|error| error.to_string())?;
    Ok((request, bytes))
}

fn joined(value: &Value, bytes: &[u8]) -> Vec<u8> {
    let text = value.to_string();
    let length = u32::try_from(text.len()).unwrap_or(u32::MAX);
    [&length.to_le_bytes(), text.as_bytes(), bytes].concat()
}

/// The page's number of a stage; 5 is that of a run that is computed again, which has no overlap (`files`).
fn number_of(of: &PlacingProgress) -> u32 {
    if of.overlap.is_nan() { 5 } else { of.stage as u32 }
}

#[cfg(target_arch = "wasm32")]
#[allow(unsafe_code)] // The page gives this function with these types.
#[link(wasm_import_module = "page")]
unsafe extern "C" {
    safe fn lab_progress(stage: u32, iteration: f64, limit: f64, overlap: f64, density: f64) -> u32;
}

/// Elsewhere than in a page, nobody stops it.
#[cfg(not(target_arch = "wasm32"))]
fn lab_progress(_: u32, _: f64, _: f64, _: f64, _: f64) -> u32 {
    0
}
