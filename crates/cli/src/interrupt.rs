//! Ctrl-C, termination, a closed terminal: nothing is left half-written.

use anyhow::{Context, Result};
use crowd_mechanics::files::give_up;
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

/// Whether the command looks for [`PRESSED`] and ends its work itself.
static WATCHED: AtomicBool = AtomicBool::new(false);
static PRESSED: AtomicBool = AtomicBool::new(false);

/// Before anything is written. A signal ends the program at once, without what it has begun, unless the command watches
/// for it; a second one does in any case. A file that gets too large (`ulimit -f`) is an error of writing it.
pub fn prepare() -> Result<()> {
    ctrlc::set_handler(|| {
        if PRESSED.swap(true, Ordering::Relaxed) || !WATCHED.load(Ordering::Relaxed) {
            give_up();
            note!("lemons: {}", Interrupted::nothing_written());
            std::process::exit(EXIT_CODE.into());
        }
    })
    .context("cannot watch for Ctrl-C")?;
    #[cfg(unix)]
    signal_hook::flag::register(signal_hook::consts::SIGXFSZ, std::sync::Arc::default())
        .context("cannot watch for SIGXFSZ")?;
    Ok(())
}

/// Waits for the end of the program if a signal is about to end it: what failed meanwhile failed as its files were
/// taken away.
pub fn wait_if_ending() {
    while PRESSED.load(Ordering::Relaxed) && !WATCHED.load(Ordering::Relaxed) {
        std::thread::park();
    }
}

/// Whether Ctrl-C was pressed. Pressed twice, the program ends at once.
#[derive(Clone)]
pub struct Interrupt(());

impl Interrupt {
    /// From now on the command looks for it.
    pub fn watch() -> Interrupt {
        WATCHED.store(true, Ordering::Relaxed);
        Interrupt(())
    }

    /// Set when Ctrl-C is pressed.
    pub fn flag(&self) -> &AtomicBool {
        &PRESSED
    }

    pub fn pressed(&self) -> bool {
        PRESSED.load(Ordering::Relaxed)
    }

    pub fn check(&self) -> Result<()> {
        if self.pressed() { Err(Interrupted::nothing_written().into()) } else { Ok(()) }
    }
}
