//! The one place that prints. A closed pipe or a full disk is an error, never a panic.

use anyhow::Result;
use indicatif::{ProgressBar, ProgressStyle};
use lemons_core::files::reader_left;
use lemons_core::files::words::shortened;
use std::cell::RefCell;
use std::fmt;
use std::io::{self, Write};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// A line on standard output; its error is that of [`line()`].
macro_rules! say {
    ($($text:tt)*) => { $crate::print::line(format_args!($($text)*)) };
}

/// A line on standard error: a warning, or what went wrong.
macro_rules! note {
    ($($text:tt)*) => { $crate::print::aside(format_args!($($text)*)) };
}

/// Standard output cannot be written.
#[derive(Debug, thiserror::Error)]
#[error("cannot write to standard output: {0}")]
struct OutputError(io::Error);

fn own(error: io::Error) -> io::Error {
    io::Error::new(error.kind(), OutputError(error))
}

/// Standard output is for results: what the command says goes to standard error.
static TO_STANDARD_ERROR: AtomicBool = AtomicBool::new(false);

/// Lets nothing but results go to standard output from now on.
pub fn use_standard_error() {
    TO_STANDARD_ERROR.store(true, Ordering::Relaxed);
}

/// Words of a command that another program has called.
#[derive(Default)]
struct Caught {
    printed: String,
    notes: Vec<String>,
}

thread_local! {
    static CAUGHT: RefCell<Option<Caught>> = const { RefCell::new(None) };
}

/// Does something in this thread without printing. Also returns what would be printed on standard output, and the lines
/// of standard error.
pub fn caught<T>(work: impl FnOnce() -> T) -> (T, String, Vec<String>) {
    CAUGHT.set(Some(Caught::default()));
    let done = work();
    let Caught { printed, notes } = CAUGHT.take().unwrap_or_default();
    (done, printed, notes)
}

fn is_caught() -> bool {
    CAUGHT.with_borrow(Option::is_some)
}

/// Returns the first names, at most so many, and `…` for the others.
pub fn few(names: &[impl AsRef<str>], most: usize) -> String {
    let more = (names.len() > most).then_some("…");
    let first = names.iter().take(most).map(AsRef::as_ref);
    first.chain(more).collect::<Vec<_>>().join(", ")
}

/// Makes a progress bar of this template, which only a terminal shows.
pub fn bar(length: u64, template: &str) -> Result<ProgressBar> {
    let bar = if is_caught() { ProgressBar::hidden() } else { ProgressBar::new(length) };
    Ok(bar.with_style(ProgressStyle::with_template(template)?))
}

/// Returns whether it is time for a line that says how far a long command is, where no progress bar is shown: half a
/// minute after the `last` one, as in Python.
pub fn is_due(last: &mut Instant, now: Instant) -> bool {
    let due = now.duration_since(*last) >= Duration::from_secs(30);
    if due {
        *last = now;
    }
    due
}

/// Standard output, whose errors say that they are its own.
pub enum Console {
    StandardOutput(io::StdoutLock<'static>),
    StandardError,
    Caught,
}

/// Returns where more than a line is written.
pub fn out() -> Console {
    if is_caught() {
        Console::Caught
    } else if TO_STANDARD_ERROR.load(Ordering::Relaxed) {
        Console::StandardError
    } else {
        Console::StandardOutput(io::stdout().lock())
    }
}

impl Write for Console {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match self {
            Console::StandardOutput(out) => out.write(bytes).map_err(own),
            // As of everything that is said there: perhaps nobody hears it.
            Console::StandardError => {
                let _ = io::stderr().lock().write_all(bytes);
                Ok(bytes.len())
            }
            Console::Caught => {
                let text = String::from_utf8_lossy(bytes);
                CAUGHT.with_borrow_mut(|caught| caught.iter_mut().for_each(|caught| caught.printed += &text));
                Ok(bytes.len())
            }
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        match self {
            Console::StandardOutput(out) => out.flush().map_err(own),
            Console::StandardError | Console::Caught => Ok(()),
        }
    }
}

/// See [`say!`].
pub fn line(text: fmt::Arguments) -> io::Result<()> {
    writeln!(out(), "{text}")
}

/// See [`note!`]. Where nobody can hear it, there is nobody to tell.
pub fn aside(text: fmt::Arguments) {
    let text = text.to_string();
    let text = shortened(&text);
    if is_caught() {
        CAUGHT.with_borrow_mut(|caught| {
            caught.iter_mut().for_each(|caught| caught.notes.push(text.to_string()))
        });
        return;
    }
    let _ = writeln!(io::stderr().lock(), "{text}");
}

/// Returns whether somebody closed the pipe (`lemons info … | head`): they have what they wanted.
pub fn is_closed_pipe(error: &anyhow::Error) -> bool {
    if reader_left() {
        return true;
    }
    error.chain().filter_map(|cause| cause.downcast_ref::<io::Error>()).any(|error| {
        let own = error.get_ref().is_some_and(|inner| inner.is::<OutputError>());
        own && error.kind() == io::ErrorKind::BrokenPipe
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_is_due_every_half_minute() {
        let begin = Instant::now();
        let mut last = begin;
        let seconds = [1, 29, 30, 31, 59, 61, 62, 200, 229, 230];
        let due = seconds.map(|second| is_due(&mut last, begin + Duration::from_secs(second)));
        assert_eq!(due, [false, false, true, false, false, true, false, true, false, true]);
    }
}
