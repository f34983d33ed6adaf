//! Ctrl-C, termination, a closed terminal: nothing is left half-written, and what is complete is said.

#[cfg(unix)]
mod ignored;

use crate::files;
use crate::print::few;
use anyhow::{Context, Result};
use lemons_core::files::give_up;
use std::cell::RefCell;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, LazyLock};

/// The user pressed Ctrl-C; what became of the work.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct Interrupted(pub String);

impl Interrupted {
    /// Says that what was begun is given up; what is complete stays.
    pub fn given_up() -> Interrupted {
        let complete: Vec<String> = files::complete().iter().map(|path| path.display().to_string()).collect();
        Interrupted(match complete.len() {
            0 => "interrupted: nothing was written".into(),
            count => format!("interrupted: {count} of the files are complete ({})", few(&complete, 8)),
        })
    }
}

/// Exit code as shells count it: 128 and the number of the signal.
pub const EXIT_CODE: u8 = 130;

/// A flag that is set if the command looks for [`PRESSED`] and ends its work itself.
static WATCHED: AtomicBool = AtomicBool::new(false);
static PRESSED: LazyLock<Arc<AtomicBool>> = LazyLock::new(Arc::default);

thread_local! {
    /// Flag that stops the command of this thread, where another program has called it.
    static STOP: RefCell<Option<Arc<AtomicBool>>> = const { RefCell::new(None) };
}

/// Does work in this thread that is stopped by a flag instead of Ctrl-C.
pub fn stopped_by<T>(stop: Arc<AtomicBool>, work: impl FnOnce() -> T) -> T {
    STOP.set(Some(stop));
    let done = work();
    STOP.set(None);
    done
}

/// Prepares for signals, before anything is written. A signal ends the program at once, without what it has begun, unless the command watches
/// for it; a second one does in any case. Signals that whoever started the program lets it ignore (`nohup`, a shell's
/// `&`) stay ignored. A file that gets too large (`ulimit -f`) is an error of writing it.
pub fn prepare() -> Result<()> {
    #[cfg(unix)]
    {
        use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM, SIGXFSZ};
        let heeded = [SIGINT, SIGTERM, SIGHUP].into_iter().filter(|signal| !ignored::is_ignored(*signal));
        let mut signals = signal_hook::iterator::Signals::new(heeded).context("cannot watch for Ctrl-C")?;
        let thread = std::thread::Builder::new().name("signals".into());
        thread.spawn(move || signals.forever().for_each(|_| pressed())).context("cannot start a thread")?;
        signal_hook::flag::register(SIGXFSZ, std::sync::Arc::default())
            .context("cannot watch for SIGXFSZ")?;
    }
    #[cfg(not(unix))]
    ctrlc::set_handler(pressed).context("cannot watch for Ctrl-C")?;
    Ok(())
}

fn pressed() {
    if PRESSED.swap(true, Ordering::Relaxed) || !WATCHED.load(Ordering::Relaxed) {
        // From here on no file gets complete.
        give_up();
        note!("lemons: {}", Interrupted::given_up());
        std::process::exit(EXIT_CODE.into());
    }
}

/// Waits for the end of the program if a signal is about to end it: what failed meanwhile failed as its files were
/// taken away.
pub fn wait_if_ending() {
    while PRESSED.load(Ordering::Relaxed) && !WATCHED.load(Ordering::Relaxed) {
        std::thread::park();
    }
}

/// A flag that is set when Ctrl-C is pressed. Pressed twice, the program ends at once.
#[derive(Clone)]
pub struct Interrupt(Arc<AtomicBool>);

impl Interrupt {
    /// Lets the command look for it from now on.
    pub fn watch() -> Interrupt {
        Interrupt(STOP.with_borrow(Clone::clone).unwrap_or_else(|| {
            WATCHED.store(true, Ordering::Relaxed);
            PRESSED.clone()
        }))
    }

    /// Returns what is set when Ctrl-C is pressed.
    pub fn flag(&self) -> &AtomicBool {
        &self.0
    }

    pub fn pressed(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }

    pub fn check(&self) -> Result<()> {
        if self.pressed() { Err(Interrupted::given_up().into()) } else { Ok(()) }
    }
}
