//! A file that a writer of one type fills, and that is given back with its own type.
//!
//! The writers are built once in this crate, not again for each type of file in each program.

use std::io::{self, Write};
use std::sync::{Arc, Mutex, PoisonError};

/// What is written to. It is [`Lent::back`] when no writer has it any more.
pub(super) struct Lent<W>(Arc<Mutex<W>>);

/// The same for a writer.
pub(super) struct Sink(Arc<Mutex<dyn Write + Send>>);

impl<W: Write + Send + 'static> Lent<W> {
    pub fn new(file: W) -> (Lent<W>, Sink) {
        let file = Arc::new(Mutex::new(file));
        (Lent(file.clone()), Sink(file))
    }

    /// The file. `sink` is the one that was made with it.
    pub fn back(self, sink: Sink) -> io::Result<W> {
        drop(sink);
        let file = Arc::into_inner(self.0).ok_or_else(|| io::Error::other("the file is still written"))?;
        Ok(file.into_inner().unwrap_or_else(PoisonError::into_inner))
    }
}

impl Write for Sink {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).flush()
    }
}
