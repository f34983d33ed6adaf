//! A run under way: what it has recorded can be completed while a step is still computed.

use super::Ended;
use crate::error::and_then;
use crate::watch::{Recorded, Watch};
use anyhow::{Context, Result, bail};
use indicatif::ProgressBar;
use lemons_files::Staged;
use lemons_master::Saved;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Instant;

/// What a run has recorded so far, and what it takes to end it without its FMUs.
pub struct Underway {
    /// \[s\] where this run began
    pub first: f64,
    /// \[s\] the last communication point that is recorded
    pub time: f64,
    pub started: Instant,
    pub coupling: Vec<String>,
    pub watch: Watch,
    /// Where the run is saved.
    pub file: Option<(Staged, PathBuf)>,
    /// Of the last communication point, if it was put by.
    pub at_hand: Option<AtHand>,
    pub bar: ProgressBar,
    /// Directories of the FMUs.
    pub unzipped: Vec<PathBuf>,
}

/// A run that can be saved without a call of its FMUs.
pub struct AtHand {
    pub saved: Saved,
    /// Of each component.
    pub states: Vec<Vec<u8>>,
}

/// Of the thread that steps and of the one that waits.
#[derive(Clone, Default)]
pub struct Shared(Arc<Mutex<Stage>>);

/// How far a run is.
#[derive(Default)]
enum Stage {
    /// It is prepared: files are read, which may be pipes that nobody writes.
    #[default]
    Before,
    /// It steps.
    Underway(Box<Underway>),
    /// One of both ends it.
    Over,
}

impl Shared {
    fn held(&self) -> MutexGuard<'_, Stage> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The first step is next.
    ///
    /// # Errors
    /// The run was given up.
    pub fn put(&self, underway: Underway) -> Result<()> {
        let mut stage = self.held();
        match *stage {
            Stage::Before => *stage = Stage::Underway(Box::new(underway)),
            Stage::Underway(_) | Stage::Over => bail!(GIVEN_UP),
        }
        Ok(())
    }

    /// For the one who ends the run.
    pub fn take(&self) -> Option<Underway> {
        let mut stage = self.held();
        match std::mem::replace(&mut *stage, Stage::Over) {
            Stage::Underway(underway) => Some(*underway),
            // Who ended it may still write its files.
            Stage::Before | Stage::Over => None,
        }
    }

    /// Whether the run was given up before its first step: then it makes none.
    pub fn give_up_before(&self) -> bool {
        let mut stage = self.held();
        let before = matches!(*stage, Stage::Before);
        if before {
            *stage = Stage::Over;
        }
        before
    }

    /// # Errors
    /// The run was given up.
    pub fn with<T>(&self, what: impl FnOnce(&mut Underway) -> Result<T>) -> Result<T> {
        match &mut *self.held() {
            Stage::Underway(underway) => what(underway),
            Stage::Before | Stage::Over => bail!(GIVEN_UP),
        }
    }
}

const GIVEN_UP: &str = "the run was given up";

impl Underway {
    /// Ends the run at its last communication point while a step is computed, which goes with the program.
    pub fn give_up(self) -> Result<Ended> {
        self.bar.finish_and_clear();
        // The thread that steps would do it, but is not waited for.
        for directory in &self.unzipped {
            let _ = std::fs::remove_dir_all(directory);
        }
        let wall = self.started.elapsed();
        let Recorded { lines: seen, placed, .. } = self.watch.finish();
        let saved = match (self.at_hand, self.file) {
            (Some(at_hand), Some((file, path))) => at_hand.write(file, &path).map(Some),
            _ => Ok(None),
        };
        let (saved, kept) = saved.map_or_else(|error| (None, Err(error)), |saved| (saved, Ok(())));
        Ok(Ended {
            poses: Vec::new(),
            chosen: Vec::new(),
            step: 0.0,
            compared: Vec::new(),
            simulated: self.time - self.first,
            wall,
            stopped: Some(self.time),
            coupling: self.coupling,
            seen,
            saved,
            // A run that is shown is not shown in parts.
            recorded: None,
            failed: and_then(placed, kept).err(),
        })
    }
}

impl AtHand {
    /// Writes the saved run; returns a line of the summary.
    pub fn write(&self, file: Staged, path: &Path) -> Result<String> {
        let path = path.display();
        self.saved.write(&self.states, file).with_context(|| format!("cannot write {path}"))?;
        Ok(format!("saved run          {path}   (at t = {:.3} s)", self.saved.time))
    }
}
