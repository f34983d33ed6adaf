//! What the command says: the one place that prints. A closed pipe or a full disk is an error, never a panic.

use std::fmt::{self, Display};
use std::io::{self, Write};

/// A line on standard output; its error is that of [`line()`].
macro_rules! say {
    ($($text:tt)*) => { $crate::tell::line(format_args!($($text)*)) };
}

/// A line on standard error: a warning, or what went wrong.
macro_rules! note {
    ($($text:tt)*) => { $crate::tell::aside(format_args!($($text)*)) };
}

/// Standard output cannot be written.
#[derive(Debug)]
struct NotSaid(io::Error);

impl Display for NotSaid {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "cannot write to standard output: {}", self.0)
    }
}

impl std::error::Error for NotSaid {}

fn not_said(error: io::Error) -> io::Error {
    io::Error::new(error.kind(), NotSaid(error))
}

/// Standard output, whose errors say that they are its own.
pub struct Out(io::StdoutLock<'static>);

/// To write more than a line.
pub fn out() -> Out {
    Out(io::stdout().lock())
}

impl Write for Out {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.write(bytes).map_err(not_said)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.0.flush().map_err(not_said)
    }
}

/// See [`say!`].
pub fn line(text: fmt::Arguments) -> io::Result<()> {
    writeln!(out(), "{text}")
}

/// See [`note!`]. Where nobody can hear it, there is nobody to tell.
pub fn aside(text: fmt::Arguments) {
    let _ = writeln!(io::stderr().lock(), "{text}");
}

/// Whether somebody closed the pipe (`lemons info … | head`): they have what they wanted.
pub fn nobody_listens(error: &anyhow::Error) -> bool {
    error.chain().filter_map(|cause| cause.downcast_ref::<io::Error>()).any(|error| {
        let own = error.get_ref().is_some_and(|inner| inner.is::<NotSaid>());
        own && error.kind() == io::ErrorKind::BrokenPipe
    })
}
