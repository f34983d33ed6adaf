//! Ctrl-C during long work: nothing is left half-written.

use anyhow::{Context, Result};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// The user pressed Ctrl-C; what became of the work.
#[derive(Debug)]
pub struct Interrupted(pub String);

impl Interrupted {
    /// What was begun is given up.
    pub fn nothing_written() -> Interrupted {
        Interrupted("interrupted: nothing was written".into())
    }
}

impl std::fmt::Display for Interrupted {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for Interrupted {}

/// As shells count it: 128 and the number of the signal.
pub const EXIT_CODE: u8 = 130;

/// Whether Ctrl-C was pressed. Pressed twice, the program ends at once.
#[derive(Clone)]
pub struct Interrupt(Arc<AtomicBool>);

impl Interrupt {
    /// To be called once.
    pub fn watch() -> Result<Interrupt> {
        let pressed = Arc::new(AtomicBool::new(false));
        let handler = pressed.clone();
        ctrlc::set_handler(move || {
            if handler.swap(true, Ordering::Relaxed) {
                std::process::exit(EXIT_CODE.into());
            }
        })
        .context("cannot watch for Ctrl-C")?;
        Ok(Interrupt(pressed))
    }

    /// Set when Ctrl-C is pressed.
    pub fn flag(&self) -> &AtomicBool {
        &self.0
    }

    pub fn pressed(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }

    pub fn check(&self) -> Result<()> {
        if self.pressed() { Err(Interrupted::nothing_written().into()) } else { Ok(()) }
    }
}
